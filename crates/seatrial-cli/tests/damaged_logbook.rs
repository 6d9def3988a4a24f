//! What is told of a damaged logbook, and what comes out of it.

use std::path::Path;

use seatrial_dev::{run_to_text, unwrapped};
use serde_json::Value;

use crate::dashboard::server::Server;

/// Two campaigns, of which something was changed in the first.
fn damaged(folder: &Path) {
    for seed in ["1", "2"] {
        let trial = ["trial", "--seed", seed, "--logbook", "seatrial.db"];
        assert_eq!(run_to_text(folder, &trial).0, 0);
    }
    let path = folder.join("seatrial.db");
    let logbook = rusqlite::Connection::open(path).unwrap();
    logbook
        .execute_batch(
            "UPDATE sample SET surge_speed_m_s = surge_speed_m_s + 0.01 WHERE campaign = 1 AND number = 300",
        )
        .unwrap();
}

fn outcome(folder: &Path, log: &str) -> Value {
    let (_, printed, told) = run_to_text(folder, &["identify", log, "--json"]);
    let found: Value = serde_json::from_str(&printed).unwrap_or_else(|_| panic!("{told}"));
    found["verdict"].clone()
}

#[test]
fn cli_a_damaged_campaign_is_exported_only_where_that_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    damaged(folder);
    let export = |number: &str, more: &[&str]| {
        let line = ["logbook", "export", number, "--out", "s.csv"];
        run_to_text(folder, &[&line[..], more].concat())
    };
    let (code, _, told) = export("1", &[]);
    assert_eq!(code, 3, "{told}");
    assert!(unwrapped(&told).contains("--accept"), "{told}");
    assert!(!folder.join("s.csv").exists());
    assert_eq!(export("1", &["--accept"]).0, 0);
    let csv = std::fs::read_to_string(folder.join("s.csv")).unwrap();
    assert!(csv.starts_with("# damaged: campaign 1, run 1: "));
    let verdict = outcome(folder, "s.csv");
    assert_ne!(verdict["outcome"], "use");
    assert!(verdict.to_string().contains("\"damaged\""), "{verdict}");
    std::fs::remove_file(folder.join("s.csv")).unwrap();
    // The other campaign is whole.
    assert_eq!(export("2", &[]).0, 0);
    let verdict = outcome(folder, "s.csv");
    assert_eq!(verdict["outcome"], "use", "{verdict}");
    let server = Server::start(folder, &[]);
    for (file, status) in [("1/samples.csv", 422), ("1/samples.mcap", 422)] {
        let (found, refused) = server.ask("GET", &format!("/campaigns/{file}")).send();
        assert_eq!(found, status, "{file}: {refused}");
    }
}

#[test]
fn cli_a_terminal_is_told_of_damage_wherever_a_campaign_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    damaged(folder);
    for line in [
        &["report", "--logbook", "seatrial.db", "--campaign", "1"][..],
        &["replay", "seatrial.db", "--campaign", "1"],
        &["logbook", "1"],
        &["logbook", "diff", "1", "2"],
    ] {
        let (_, _, told) = run_to_text(folder, line);
        assert!(told.contains("campaign 1: DAMAGED"), "{line:?}: {told}");
        assert!(!told.contains("campaign 2: DAMAGED"), "{line:?}: {told}");
    }
    let (_, listed, _) = run_to_text(folder, &["logbook", "list"]);
    assert!(!listed.contains("campaign 2: DAMAGED"), "{listed}");
    let (code, found, _) = run_to_text(folder, &["logbook", "--verify"]);
    assert_eq!(code, 3);
    assert!(found.contains("Whole  campaign 2"), "{found}");
}

/// Pages of the file that were overwritten: nothing that is said of them is in the words of a database.
#[test]
fn cli_damage_is_told_in_plain_words() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let trial = ["trial", "--logbook", "seatrial.db"];
    assert_eq!(run_to_text(folder, &trial).0, 0);
    let path = folder.join("seatrial.db");
    let whole = std::fs::read(&path).unwrap();
    for at in (0..whole.len()).step_by(whole.len() / 40) {
        let mut bytes = whole.clone();
        let end = (at + 5000).min(bytes.len());
        bytes[at..end].fill(0xa5);
        std::fs::write(&path, bytes).unwrap();
        for line in [
            &["logbook", "--verify"][..],
            &["logbook"],
            &["logbook", "1"],
            &["gains", "--logbook", "seatrial.db"],
            &["report", "--logbook", "seatrial.db"],
            &["doctor", "--logbook", "seatrial.db"],
        ] {
            let (_, printed, told) = run_to_text(folder, line);
            let said = unwrapped(&(printed + &told));
            for word in [
                "SQL",
                "malformed",
                "Error code",
                "rowid",
                "Rowid",
                "Tree",
                "index ",
                "column",
                "type ",
                "UTF",
                "utf",
                "sealed",
                "table ",
            ] {
                assert!(!said.contains(word), "{at}, {line:?}, {word}: {said}");
            }
            let advises_itself =
                line.contains(&"--verify") && said.contains("seatrial logbook --verify");
            assert!(!advises_itself, "{at}: {said}");
        }
    }
}

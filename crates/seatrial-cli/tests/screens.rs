//! What a person sees in a terminal of 60, 80 and 200 columns: nothing wider than it, a verdict in colour, K_p and its promise.

use std::path::Path;
use std::process::Command;

use seatrial_dev::{program, program_path, skip, unwrapped};

const WIDTHS: [usize; 3] = [60, 80, 200];

/// Standard output of a command in a terminal of so many columns. `script`, which gives it the terminal, is part of every Linux.
fn screen(folder: &Path, columns: usize, command: &str) -> String {
    let seatrial = program_path();
    let seatrial = seatrial.display();
    let line = format!("stty cols {columns} rows 50; {seatrial} {command} 2>/dev/null");
    let output = Command::new("script")
        .args(["-qec", &line, "/dev/null"])
        .current_dir(folder)
        .env_remove("NO_COLOR")
        .env("TERM", "xterm")
        .output()
        .unwrap();
    String::from_utf8(output.stdout).unwrap().replace('\r', "")
}

/// A text without colours.
fn plain(text: &str) -> String {
    let mut parts = text.split("\x1b[");
    let first = parts.next().unwrap_or_default().to_owned();
    let coloured = parts.map(|part| part.split_once('m').map_or(part, |(_, rest)| rest));
    first + &coloured.collect::<String>()
}

fn has_terminals() -> bool {
    let version = Command::new("script").arg("--version").output();
    version.is_ok_and(|version| String::from_utf8_lossy(&version.stdout).contains("util-linux"))
}

/// Two campaigns in `seatrial.db`, and a log of one of their runs.
fn prepare(folder: &Path) {
    for seed in ["1", "2"] {
        let made = program().args(["trial", "--seed", seed]).current_dir(folder).output().unwrap();
        assert_eq!(made.status.code(), Some(0), "{made:?}");
    }
    let made = program()
        .args(["sim", "log", "--seed", "1", "--out", "run.csv"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(made.status.success(), "{made:?}");
}

#[test]
fn cli_no_screen_is_wider_than_its_terminal_and_verdicts_have_colour() {
    if !has_terminals() {
        return skip("a terminal: `script` of util-linux is missing");
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    prepare(folder);
    let verdicts = [
        ("trial --logbook other.db", "USE"),
        ("logbook 1", "USE"),
        ("identify run.csv", "USE"),
        ("compare run.csv", "THE METHODS AGREE"),
        ("health 1 2", "NO CHANGE FOUND"),
        ("health 1 --watch run.csv", ""),
        ("identify run.csv --verbose", ""),
        ("gains", ""),
        ("turn", ""),
        ("logbook list", ""),
        ("fleet run.csv --out f.parquet", ""),
        ("inspect run.csv", "USE"),
        ("logbook 1 2", ""),
    ];
    for columns in WIDTHS {
        for (command, verdict) in verdicts {
            let shown = screen(folder, columns, command);
            let text = plain(&shown);
            println!("{columns} {command}\n{text}");
            let widest = text.lines().map(|line| line.chars().count()).max();
            assert!(widest.unwrap_or(0) <= columns, "{columns} {command}\n{text}");
            assert!(
                shown.contains(&format!("m{verdict}\x1b[0m")) || verdict.is_empty(),
                "{columns} {command}\n{shown}"
            );
        }
    }
}

#[test]
fn cli_a_refused_campaign_is_refused_in_the_same_words_everywhere() {
    if !has_terminals() {
        return skip("a terminal: `script` of util-linux is missing");
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let made =
        program().args(["trial", "--scenario", "broken_fin"]).current_dir(folder).output().unwrap();
    assert_eq!(made.status.code(), Some(4), "{made:?}");
    for command in ["logbook 1", "turn --campaign 1", "gains --campaign 1"] {
        let shown = screen(folder, 80, command);
        assert!(shown.starts_with("\x1b[1;31mDO NOT USE\x1b[0m"), "{shown}");
    }
    let list = screen(folder, 200, "logbook list");
    assert!(list.contains("do not use    0 of 5"), "{list}");
}

#[test]
fn cli_gains_keep_their_promise_on_every_screen() {
    if !has_terminals() {
        return skip("a terminal: `script` of util-linux is missing");
    }
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    for columns in WIDTHS {
        let shown = screen(folder.path(), columns, "gains");
        assert!(
            unwrapped(&shown).starts_with("A 40 deg course change will overshoot by"),
            "{shown}"
        );
        for heading in ["K_p", "overshoot"] {
            let head = shown.lines().find(|line| line.contains("thrust  speed"));
            assert!(head.is_some_and(|head| head.contains(heading)), "{shown}");
        }
        // No heading of the table of a trial or a log stands twice.
        for command in ["logbook 1", "identify run.csv"] {
            let shown = screen(folder.path(), columns, command);
            let head = shown.lines().find(|line| line.contains("verdict"));
            let names: Vec<&str> = head.expect("a table").split_whitespace().collect();
            let mut once = names.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), names.len(), "{shown}");
        }
    }
}

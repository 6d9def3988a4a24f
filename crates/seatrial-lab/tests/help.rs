//! The help of `seatrial-lab`: its examples run as they are printed, and it fits a terminal.

use seatrial_dev::{lab, text};

/// Verbs of the program.
const VERBS: [&str; 8] =
    ["estimators", "faults", "lies", "commission", "manoeuvres", "surge", "world", "field"];

/// Examples that take minutes: that they are understood is all that is asserted.
const LONG: [&str; 1] = ["world --depth outputs --seeds 200"];

fn help(verb: &str) -> String {
    let output = lab().args([verb, "--help"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{verb}");
    text(&output.stdout)
}

#[test]
fn cli_help_names_every_verb_and_fits_80_columns() {
    let first = text(&lab().arg("--help").output().unwrap().stdout);
    for verb in VERBS {
        assert!(first.contains(&format!("\n  {verb} ")), "{verb}: {first}");
        for line in help(verb).lines() {
            assert!(line.chars().count() <= 80, "{verb}: {line}");
        }
    }
}

#[test]
fn cli_every_example_runs_and_ends_well() {
    let folder = tempfile::tempdir().unwrap();
    let mut examples = 0;
    for verb in VERBS {
        let help = help(verb);
        let lines = help.lines().map(str::trim);
        for example in lines.filter_map(|line| line.strip_prefix("seatrial-lab ")) {
            examples += 1;
            let mut command = lab();
            command.args(example.split(' ')).current_dir(folder.path());
            if LONG.contains(&example) {
                command.arg("--help");
            }
            let output = command.output().unwrap();
            // The paper's claims do not all hold on a simulator without drift: 4 says which.
            let is_of_the_paper = verb == "field" && output.status.code() == Some(4);
            assert!(output.status.success() || is_of_the_paper, "{example}: {output:?}");
        }
    }
    assert!(examples >= VERBS.len(), "{examples}");
}

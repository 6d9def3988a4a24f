//! Every option of the command that a text below the edges names has other words for a page and for Python.

use std::path::{Path, PathBuf};

use seatrial::identification::Reader;
use seatrial_app::advice::addressed;

/// Crates whose texts are read in a terminal, on a page and in Python.
const CRATES: [&str; 5] =
    ["seatrial", "seatrial-app", "seatrial-links", "seatrial-logs", "seatrial-mavlink"];

/// What only the terminal shows: the checks of a machine's set-up, and what to type next.
const OF_THE_TERMINAL: [&str; 3] = ["set_up.rs", "next.rs", "advice.rs"];

/// Options of other programs.
const OF_OTHERS: [&str; 3] = ["--features", "--src", "--dst"];

/// Texts that name options, at least.
const LEAST_TEXTS: usize = 80;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The texts of a source file, without those of its tests and comments.
fn texts(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = lines.collect::<Vec<_>>().join("\n").replace("'\"'", "' '");
    // What stands in the place of a name when it is said.
    let code = code
        .replace("\\\"", "'")
        .replace("{quantity}", "heading")
        .replace("--rudder-{invalid}", "--rudder-lag");
    code.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Is an option named outside of a command that is to be typed?
fn names_an_option(text: &str) -> bool {
    let options = text.match_indices("--").filter(|(at, _)| {
        let rest = &text[at + 2..];
        rest.starts_with(|c: char| c.is_ascii_lowercase())
    });
    options.into_iter().any(|(at, _)| {
        let before = &text[..at];
        let command = before.rsplit(['`', ';', '(']).next().unwrap_or_default();
        let is_of_others = OF_OTHERS.iter().any(|other| text[at..].starts_with(other));
        !is_of_others && !command.contains("seatrial ")
    })
}

#[test]
fn exact_no_text_names_an_option_to_a_page_or_python() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut read = 0;
    let mut left = Vec::new();
    for name in CRATES {
        let mut files = Vec::new();
        sources(&crates.join(name).join("src"), &mut files);
        for file in files {
            if OF_THE_TERMINAL.iter().any(|other| file.ends_with(other)) {
                continue;
            }
            let source = std::fs::read_to_string(&file).expect("a source");
            for text in texts(&source).into_iter().filter(|text| names_an_option(text)) {
                read += 1;
                for reader in [Reader::Dashboard, Reader::Python] {
                    let text = addressed(&text, reader);
                    if names_an_option(&text) {
                        left.push(format!("{}: {text}", file.display()));
                    }
                }
            }
        }
    }
    assert!(left.is_empty(), "{}", left.join("\n"));
    assert!(read >= LEAST_TEXTS, "{read} texts");
}

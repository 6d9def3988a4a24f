//! Every line of docs/security.md has a test, and the test is there.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

const PREFIXES: [&str; 8] =
    ["exact_", "recover_", "prop_", "regress_", "parity_", "io_", "cli_", "test_"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs" || extension == "py") {
            found.push(path);
        }
    }
}

/// The names of all functions of all crates that are tests by their prefix.
fn tests() -> HashSet<String> {
    let mut files = Vec::new();
    sources(&root().join("crates"), &mut files);
    let mut names = HashSet::new();
    for file in files {
        for line in fs::read_to_string(file).unwrap().lines() {
            let line = line.trim_start();
            let name = ["fn ", "def "]
                .iter()
                .find_map(|word| line.strip_prefix(word))
                .and_then(|rest| rest.split_once("("));
            names.extend(name.map(|(name, _)| name.to_owned()).filter(|name| is_test(name)));
        }
    }
    names
}

fn is_test(name: &str) -> bool {
    PREFIXES.iter().any(|prefix| name.starts_with(prefix))
}

#[test]
fn parity_every_line_of_the_threat_model_has_its_test() {
    let page = fs::read_to_string(root().join("docs/security.md")).unwrap();
    let tests = tests();
    let is_row = |line: &&str| {
        line.starts_with("| ") && !line.starts_with("| threat") && !line.starts_with("|---")
    };
    let rows: Vec<&str> = page.lines().filter(is_row).collect();
    assert!(rows.len() > 20, "{}", rows.len());
    for row in rows {
        let named: Vec<&str> = row.split('`').filter(|name| is_test(name)).collect();
        assert!(!named.is_empty(), "no test: {row}");
        for name in named {
            assert!(tests.contains(name), "{name} is no test: {row}");
        }
    }
}

/// A tag of an action can be moved to other code; a commit cannot.
#[test]
fn exact_actions_of_the_public_host_are_pinned_by_commit() {
    let mut count = 0;
    for entry in fs::read_dir(root().join(".github/workflows")).unwrap() {
        let path = entry.unwrap().path();
        for line in fs::read_to_string(&path).unwrap().lines() {
            let Some((_, action)) = line.split_once("uses: ") else {
                continue;
            };
            let commit = action.split([' ', '@']).nth(1).unwrap_or_default();
            let is_commit = commit.len() == 40 && commit.bytes().all(|c| c.is_ascii_hexdigit());
            assert!(is_commit, "{}: {action}", path.display());
            count += 1;
        }
    }
    assert!(count > 5);
}

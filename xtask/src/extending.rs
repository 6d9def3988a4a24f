//! The program outside the workspace that brings a format, a vehicle and an estimator of its own, which the pages on extending show.

use std::path::Path;

use crate::cargo;
use crate::steps::run;
use crate::target::in_target;

const FOLDER: &str = "examples/extending";
/// Where programs outside the workspace are built, which have other features.
pub const TARGET: &str = "examples";

/// Builds the library, the command and the tests of the program, whose manifest makes warnings errors, and runs the tests.
pub fn check() -> Result<(), String> {
    let manifest = Path::new(FOLDER).join("Cargo.toml");
    let mut tests = cargo(&["test", "--quiet", "--locked", "--manifest-path"]);
    tests
        .arg(&manifest)
        .arg("--target-dir")
        .arg(in_target(TARGET));
    tests.env("CARGO_INCREMENTAL", "0");
    run(&mut tests, format!("the tests of {FOLDER}"))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn files(folder: &str, ending: &str) -> Vec<(PathBuf, String)> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(folder);
        let entries = std::fs::read_dir(folder).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let named = paths.filter(|path| path.extension().is_some_and(|e| e == ending));
        named
            .map(|path| (path.clone(), std::fs::read_to_string(path).unwrap()))
            .collect()
    }

    #[test]
    fn exact_the_pages_on_extending_show_code_that_is_tested() {
        let mut sources = [
            files("examples/extending/src", "rs"),
            files("examples/extending/tests", "rs"),
        ]
        .concat();
        let with_fleet = files("crates/seatrial-app/tests", "rs");
        sources.extend(
            with_fleet
                .into_iter()
                .filter(|(path, _)| path.ends_with("own_format.rs")),
        );
        let pages = files("docs/extending", "md");
        assert_eq!(pages.len(), 3);
        for (page, text) in pages {
            let blocks: Vec<&str> = text
                .split("```rust\n")
                .skip(1)
                .filter_map(|rest| rest.split("```").next())
                .collect();
            assert!(blocks.len() > 1, "{}", page.display());
            for block in blocks {
                let is_shown = sources.iter().any(|(_, source)| source.contains(block));
                assert!(is_shown, "{}: in no source: {block}", page.display());
            }
        }
    }
}

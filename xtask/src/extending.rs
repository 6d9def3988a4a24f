//! Programs outside the workspace: one that brings a format, a vehicle and an estimator of its own, which the pages on extending show,
//! and the data loader for Foxglove, which is also built as the module that Foxglove loads.

use anyhow::{Result, ensure};

use crate::long_log::long_log;
use crate::shell::{Run, command, has, tell_size};
use crate::steps::missing;
use crate::toolchain::BROWSER;
use crate::workspace::in_target;

/// Where they are built, below the folder that cargo builds into: they have other features.
const TARGET: &str = "examples";
/// A log that is opened through the module.
const LOG_MB: &str = "4";
/// What a program in the place of Foxglove says of it: topic, encoding, messages, least and greatest.
const SAID: [&str; 2] =
    ["/heading_rad cdr 45000 0.646 1.370", "/rudder_fraction cdr 45000 -0.500 0.500"];

/// Builds the library, the command and the tests of the program that extends seatrial, and runs the tests.
pub fn check() -> Result<()> {
    cargo("test", "extending")
}

/// Runs the tests of the data loader on this machine.
pub fn check_loader() -> Result<()> {
    cargo("test", "foxglove-loader")
}

/// Runs the tests of the data loader, builds the module and opens a log through it.
pub fn build_loader() -> Result<()> {
    check_loader()?;
    cargo(&format!("build --release --lib --target {BROWSER}"), "foxglove-loader")?;
    let module = in_target(TARGET).join(BROWSER).join("release/seatrial_foxglove_loader.wasm");
    tell_size(&module)?;
    if !has("node") {
        return missing("node, in which the module is loaded, is missing");
    }
    let log = long_log("examples/log.bin", LOG_MB)?;
    let said = command!("node examples/foxglove-loader/tests/host.mjs {module} {log}").read()?;
    ensure!(SAID.iter().all(|topic| said.contains(topic)), "{said}\nexpected {SAID:?}");
    Ok(())
}

/// The manifests make warnings errors.
fn cargo(words: &str, example: &str) -> Result<()> {
    let (words, folder) = (words.split(' '), in_target(TARGET));
    command!("cargo {words...} --quiet --locked --manifest-path examples/{example}/Cargo.toml --target-dir {folder}")
        .env("CARGO_INCREMENTAL", "0")
        .run()
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    fn files(folder: &str, ending: &str) -> Vec<(PathBuf, String)> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
        let entries = std::fs::read_dir(folder).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let named = paths.filter(|path| path.extension().is_some_and(|e| e == ending));
        named.map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
    }

    #[test]
    fn exact_the_pages_on_extending_show_code_that_is_tested() {
        let mut sources =
            [files("examples/extending/src", "rs"), files("examples/extending/tests", "rs")]
                .concat();
        let with_fleet = files("crates/seatrial-app/tests", "rs");
        sources.extend(with_fleet.into_iter().filter(|(path, _)| path.ends_with("own_format.rs")));
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

//! The program outside the workspace that brings a format, a vehicle and an estimator of its own, which the pages on extending show.
//!
//! The compiler takes the crates that the tests have built: by cargo, a workspace of its own would build all of them once more.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::{ROS2, cargo, succeeds};

const FOLDER: &str = "examples/extending";
const OUT: &str = "target/extending";
const NAME: &str = "seatrial_extending";

/// Builds the library, the command and the tests of the program, with warnings as errors, and runs the tests.
pub fn check() -> Result<(), String> {
    let folder = Path::new(FOLDER);
    let failed = |error: std::io::Error| format!("{OUT}: {error}");
    std::fs::create_dir_all(OUT).map_err(failed)?;
    let crates = built()?;
    let mut externs = Vec::new();
    for name in dependencies()? {
        let name = name.replace('-', "_");
        let library = crates
            .get(&name)
            .ok_or_else(|| format!("{FOLDER}/Cargo.toml: {name} is not among the workspace's"))?;
        externs.push(format!("{name}={}", library.display()));
    }
    let compile = |source: &str, rest: &[&str]| {
        let mut rustc = Command::new("rustc");
        rustc.args(["--edition", "2024", "-D", "warnings", "-C", "opt-level=2"]);
        rustc.args(["--out-dir", OUT, "-L", "dependency=target/debug/deps"]);
        for found in &externs {
            rustc.args(["--extern", found]);
        }
        rustc.args(rest).arg(folder.join(source));
        match succeeds(&mut rustc) {
            true => Ok(()),
            false => Err(format!("rustc {FOLDER}/{source}")),
        }
    };
    compile("src/lib.rs", &["--crate-type", "lib", "--crate-name", NAME])?;
    let own = format!("{NAME}={OUT}/lib{NAME}.rlib");
    compile("src/main.rs", &["--crate-name", "helm", "--extern", &own])?;
    compile("tests/extending.rs", &["--test", "--extern", &own])?;
    match succeeds(&mut Command::new(Path::new(OUT).join("extending"))) {
        true => Ok(()),
        false => Err(format!("the tests of {FOLDER}")),
    }
}

/// The libraries that the tests of the workspace link, by name.
fn built() -> Result<BTreeMap<String, PathBuf>, String> {
    let arguments = ["test", "--workspace", "--features", ROS2, "--no-run"];
    let said = cargo(&arguments)
        .args(["--quiet", "--message-format", "json"])
        .output()
        .map_err(|error| format!("cargo test --no-run: {error}"))?;
    let text = String::from_utf8_lossy(&said.stdout);
    let messages = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    Ok(messages.filter_map(|message| library(&message)).collect())
}

/// A library that others link, of a message of cargo.
fn library(message: &Value) -> Option<(String, PathBuf)> {
    let target = &message["target"];
    let is_lib = target["kind"]
        .as_array()?
        .iter()
        .any(|kind| kind == "lib" || kind == "rlib");
    let is_test = message["profile"]["test"] == true;
    let files = message["filenames"].as_array()?;
    let file = files
        .iter()
        .filter_map(Value::as_str)
        .find(|file| file.ends_with(".rlib"))?;
    (is_lib && !is_test).then(|| {
        (
            target["name"].as_str().unwrap_or_default().into(),
            file.into(),
        )
    })
}

/// What the program's manifest names.
fn dependencies() -> Result<Vec<String>, String> {
    let manifest = format!("{FOLDER}/Cargo.toml");
    let said = cargo(&["metadata", "--format-version", "1", "--no-deps"])
        .args(["--manifest-path", &manifest])
        .output()
        .map_err(|error| format!("cargo metadata: {error}"))?;
    let metadata: Value = serde_json::from_slice(&said.stdout)
        .map_err(|_| format!("{manifest}: {}", String::from_utf8_lossy(&said.stderr)))?;
    let all = metadata["packages"][0]["dependencies"].as_array().cloned();
    let names = all.unwrap_or_default().into_iter();
    Ok(names
        .filter_map(|dependency| Some(dependency["name"].as_str()?.to_owned()))
        .collect())
}

#[cfg(test)]
mod tests {
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
        let sources = [
            files("examples/extending/src", "rs"),
            files("examples/extending/tests", "rs"),
        ]
        .concat();
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
                assert!(is_shown, "{}: not in {FOLDER}: {block}", page.display());
            }
        }
    }

    #[test]
    fn exact_only_a_library_that_others_link_is_taken() {
        let message = serde_json::json!({
            "target": {"kind": ["lib"], "name": "seatrial_logs"},
            "profile": {"test": false},
            "filenames": ["deps/libseatrial_logs.rlib", "deps/libseatrial_logs.rmeta"],
        });
        let expected = (
            "seatrial_logs".to_owned(),
            "deps/libseatrial_logs.rlib".into(),
        );
        assert_eq!(library(&message), Some(expected));
        let mut test = message.clone();
        test["profile"]["test"] = true.into();
        assert_eq!(library(&test), None);
        let mut macros = message;
        macros["target"]["kind"] = serde_json::json!(["proc-macro"]);
        assert_eq!(library(&macros), None);
    }
}

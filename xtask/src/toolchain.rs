//! What rust-toolchain.toml names beside the compiler, which a machine with that compiler may lack.

use std::path::Path;
use std::process::Command;

use crate::cargo;
use crate::steps::succeeds;
use crate::target::root;

const FILE: &str = "rust-toolchain.toml";
pub const CORTEX_M: &str = "thumbv7em-none-eabihf";
pub const BROWSER: &str = "wasm32-unknown-unknown";

/// Adds the components and targets that are missing. What cannot be had is told by the step that needs it.
pub fn prepare() -> Result<(), String> {
    let add = |what: &str, names: Vec<String>| {
        if !names.is_empty() && !succeeds(Command::new("rustup").args([what, "add"]).args(names)) {
            eprintln!("== rustup {what} add failed: steps that need it are skipped");
        }
    };
    let is_missing = |name: &String| !has_component(name);
    add(
        "component",
        named("components")?
            .into_iter()
            .filter(is_missing)
            .collect(),
    );
    let is_missing = |name: &String| !has_library(name);
    add(
        "target",
        named("targets")?.into_iter().filter(is_missing).collect(),
    );
    Ok(())
}

/// Can the compiler build for a target?
pub fn has_library(target: &str) -> bool {
    let mut rustc = Command::new("rustc");
    let found = rustc
        .args(["--print", "target-libdir", "--target", target])
        .output();
    found.is_ok_and(|found| Path::new(String::from_utf8_lossy(&found.stdout).trim()).exists())
}

/// What a step says that cannot build for a target.
pub fn no_library(target: &str) -> String {
    format!("the standard library of {target} is missing: rustup target add {target}")
}

fn has_component(name: &str) -> bool {
    let program = if name == "rustfmt" { "fmt" } else { name };
    let said = cargo(&[program, "--version"]).output();
    said.is_ok_and(|said| said.status.success())
}

fn named(list: &str) -> Result<Vec<String>, String> {
    let path = root().join(FILE);
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{FILE}: {error}"))?;
    names(&text, list).ok_or_else(|| format!("{FILE}: no list of {list}"))
}

/// The strings of a list that stands on a line of its own.
fn names(text: &str, list: &str) -> Option<Vec<String>> {
    let line = text.lines().find_map(|line| line.strip_prefix(list))?;
    let quoted = line.split('"').skip(1).step_by(2);
    Some(quoted.map(String::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_pinned_toolchain_names_what_the_steps_build_for() {
        let targets = named("targets").unwrap();
        assert!(targets.contains(&CORTEX_M.to_owned()), "{targets:?}");
        assert!(targets.contains(&BROWSER.to_owned()), "{targets:?}");
        assert_eq!(named("components").unwrap(), ["rustfmt", "clippy"]);
        assert_eq!(names("channel = \"1\"\n", "targets"), None);
    }
}

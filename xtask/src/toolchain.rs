//! What rust-toolchain.toml names beside the compiler, which a machine with that compiler may lack.

use std::path::Path;

use anyhow::{Context, Result};

use crate::shell::{Run, command, shell};
use crate::steps::missing;
use crate::workspace::root;

pub const CORTEX_M: &str = "thumbv7em-none-eabihf";
pub const BROWSER: &str = "wasm32-unknown-unknown";

/// Adds the components and targets. What cannot be had is told by the step that needs it.
pub fn prepare() -> Result<()> {
    for what in ["component", "target"] {
        let names = named(what)?;
        if command!("rustup {what} add {names...}").read().is_err() {
            eprintln!("== rustup {what} add failed: steps that need it are skipped");
        }
    }
    Ok(())
}

/// Ends a step that builds for a target whose standard library the compiler has not.
pub fn needs_library(target: &str) -> Result<()> {
    let folder = command!("rustc --print target-libdir --target {target}").read();
    match folder.is_ok_and(|folder| Path::new(folder.trim()).exists()) {
        true => Ok(()),
        false => missing(format!(
            "the standard library of {target} is missing: rustup target add {target}"
        )),
    }
}

/// The components or the targets of the pinned toolchain.
fn named(what: &str) -> Result<Vec<String>> {
    let text = shell().read_file(root().join("rust-toolchain.toml"))?;
    let pinned: toml::Table = text.parse()?;
    let names = pinned["toolchain"].get(format!("{what}s"));
    let names = names.with_context(|| format!("rust-toolchain.toml: no {what}s"))?;
    Ok(names.clone().try_into()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_pinned_toolchain_names_what_the_steps_build_for() {
        let targets = named("target").unwrap();
        assert!(targets.contains(&CORTEX_M.to_owned()), "{targets:?}");
        assert!(targets.contains(&BROWSER.to_owned()), "{targets:?}");
        assert_eq!(named("component").unwrap(), ["rustfmt", "clippy"]);
        assert!(named("profile name").is_err());
    }
}

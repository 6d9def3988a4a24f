//! Crates that promise an older compiler than that of the workspace, built with that compiler.

use anyhow::Result;
use serde_json::Value;

use crate::packages::is_published;
use crate::shell::{Run, command};
use crate::steps::missing;
use crate::workspace::{in_target, metadata, packages, text};

/// A crate and the compiler that its `rust-version` names.
#[derive(Debug, PartialEq)]
struct Promise {
    name: String,
    compiler: String,
}

/// Builds each of them, with all features, with its compiler, which is installed where it is missing.
pub fn check() -> Result<()> {
    for Promise { name, compiler } in promises(metadata()?, env!("CARGO_PKG_RUST_VERSION")) {
        let mut rustup =
            command!("rustup toolchain install {compiler} --profile minimal --no-self-update");
        let is_there = command!("rustup run {compiler} rustc --version").works();
        if !is_there && rustup.run().is_err() {
            let what = "is missing, and rustup could not install it";
            return missing(format!("Rust {compiler} for {name} {what}"));
        }
        // What the pinned compiler has made is of no use to another.
        let folder = in_target("oldest");
        // This process runs under the pinned compiler, which its environment names.
        command!("rustup run {compiler} cargo check --quiet --all-features -p {name} --target-dir {folder}")
            .env_remove("RUSTC")
            .env_remove("RUSTUP_TOOLCHAIN")
            .run()?;
        eprintln!("== {name} builds on Rust {compiler}");
    }
    Ok(())
}

/// Published crates whose oldest compiler is not the workspace's.
fn promises(metadata: &Value, workspace: &str) -> Vec<Promise> {
    let promised = packages(metadata).iter().filter_map(|found| {
        let version = found["rust_version"].as_str()?;
        // The toolchain 1.88 is its last patch; a promise is kept by the first.
        let compiler = match version.matches('.').count() {
            1 => format!("{version}.0"),
            _ => version.to_owned(),
        };
        let name = text(found, "name").to_owned();
        (is_published(found) && version != workspace).then_some(Promise { name, compiler })
    });
    promised.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_published_crate_with_an_older_compiler_is_a_promise() {
        let metadata = serde_json::json!({"packages": [
            {"name": "core", "rust_version": "1.88", "publish": null},
            {"name": "edge", "rust_version": "1.95", "publish": null},
            {"name": "own", "rust_version": "1.80", "publish": []},
        ]});
        let expected = Promise { name: "core".into(), compiler: "1.88.0".into() };
        assert_eq!(promises(&metadata, "1.95"), [expected]);
    }
}

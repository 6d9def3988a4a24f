//! Crates that promise an older compiler than that of the workspace, built with that compiler.

use std::process::Command;

use serde_json::Value;

use crate::packages;
use crate::steps::{run, skipped, succeeds};
use crate::target::in_target;

/// A build of its own: what the pinned compiler has made is of no use to another.
const FOLDER: &str = "oldest";

/// A crate and the compiler that its `rust-version` names.
#[derive(Debug, PartialEq)]
struct Promise {
    name: String,
    compiler: String,
}

/// Builds each of them, with all features, with its compiler, which is installed where it is missing.
pub fn check() -> Result<(), String> {
    for Promise { name, compiler } in
        promises(&packages::metadata()?, env!("CARGO_PKG_RUST_VERSION"))
    {
        if !is_installed(&compiler) && !install(&compiler) {
            let missing = format!("Rust {compiler} is missing, and rustup could not install it");
            skipped(&format!("{name} on Rust {compiler}"), &missing)?;
            continue;
        }
        let mut build = Command::new("rustup");
        build.args(["run", &compiler, "cargo", "check", "--quiet"]);
        build.args(["--all-features", "-p", &name, "--target-dir"]);
        build.arg(in_target(FOLDER));
        // This process runs under the pinned compiler, which its environment names.
        build.env_remove("RUSTC").env_remove("RUSTUP_TOOLCHAIN");
        run(
            &mut build,
            format!("{name} does not build on Rust {compiler}, which it promises"),
        )?;
        eprintln!("== {name} builds on Rust {compiler}");
    }
    Ok(())
}

/// Published crates whose oldest compiler is not the workspace's.
fn promises(metadata: &Value, workspace: &str) -> Vec<Promise> {
    let crates = metadata["packages"].as_array().cloned().unwrap_or_default();
    let older = crates.iter().filter(|found| packages::is_published(found));
    let promised = older.filter_map(|found| {
        let version = found["rust_version"].as_str()?;
        let numbers: Vec<&str> = version.split('.').collect();
        // The toolchain 1.88 is its last patch; a promise is kept by the first.
        let compiler = match numbers.len() {
            2 => format!("{version}.0"),
            _ => version.to_owned(),
        };
        (version != workspace).then(|| Promise {
            name: found["name"].as_str().unwrap_or_default().to_owned(),
            compiler,
        })
    });
    promised.collect()
}

fn install(compiler: &str) -> bool {
    let mut rustup = Command::new("rustup");
    rustup.args([
        "toolchain",
        "install",
        compiler,
        "--profile",
        "minimal",
        "--no-self-update",
    ]);
    succeeds(&mut rustup)
}

fn is_installed(compiler: &str) -> bool {
    let mut rustup = Command::new("rustup");
    let said = rustup
        .args(["run", compiler, "rustc", "--version"])
        .output();
    said.is_ok_and(|said| said.status.success())
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
        let expected = Promise {
            name: "core".into(),
            compiler: "1.88.0".into(),
        };
        assert_eq!(promises(&metadata, "1.95"), [expected]);
    }
}

//! The page that stands alone: seatrial in WebAssembly, in one file that opens without a server.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::long_log::long_log;
use crate::steps::{run, skipped};
use crate::target::{binary, in_target};
use crate::toolchain::{BROWSER, has_library, no_library};
use crate::{cargo, page, python};

const MODULE: &str = "wasm32-unknown-unknown/wasm/seatrial_wasm.wasm";
const FOLDER: &str = "alone";
const PAGE: &str = "seatrial.html";
/// Where the last measurement is kept.
const MEASURED: &str = "validation/2026-11-25-page/table.md";
/// A log as long as a person waits for, MB.
const LONG_LOG_MB: &str = "62";
/// One that the browser does not keep, MB.
const LONGEST_LOG_MB: &str = "200";
/// The page as a server sends it, packed.
const MOST_BYTES: u64 = 3_000_000;

/// The page as it is built.
pub fn place() -> PathBuf {
    in_target(FOLDER).join(PAGE)
}

/// Compiles the module. It takes a minute or two where nothing is built yet. Where the page cannot be built, neither is the module.
pub fn compile() -> Result<(), String> {
    if !can_be_built() {
        return Ok(());
    }
    let mut build = cargo(&["rustc", "--package", "seatrial-wasm", "--lib", "--quiet"]);
    build.args(["--crate-type", "cdylib", "--profile", "wasm"]);
    build.args(["--target", BROWSER]);
    run(&mut build, "cargo rustc -p seatrial-wasm")
}

/// Builds the page; `None` where npm, or what the lock names, is missing.
pub fn build() -> Result<Option<PathBuf>, String> {
    if !can_be_built() {
        let missing = match has_library(BROWSER) {
            true => page::NO_NPM.to_owned(),
            false => no_library(BROWSER),
        };
        return skipped("the page without a server", &missing).map(|()| None);
    }
    compile()?;
    let mut vite = page::node();
    vite.arg("node_modules/vite/bin/vite.js")
        .args(["build", "--logLevel", "warn"])
        .args(["--config", "vite.alone.config.ts"])
        .arg("--outDir")
        .arg(in_target(FOLDER))
        .env("SEATRIAL_WASM", in_target(MODULE));
    run(&mut vite, "vite build --config vite.alone.config.ts")?;
    Ok(Some(place()))
}

fn can_be_built() -> bool {
    has_library(BROWSER) && page::prepared()
}

/// Builds the page, weighs it, and compares its answers with those of the terminal in a browser.
pub fn check() -> Result<(), String> {
    let Some(page) = build()? else { return Ok(()) };
    let packed = packed_bytes(&page)?;
    eprintln!("{PAGE}: {packed} bytes packed");
    if packed > MOST_BYTES {
        return Err(format!(
            "{PAGE}: {packed} bytes packed, more than {MOST_BYTES}"
        ));
    }
    if !Path::new(page::BROWSER).exists() {
        return skipped("the page without a server", "chromium is missing");
    }
    let mut tests = page::node();
    tests
        .args(["--test", "--test-reporter=spec", "tests/alone.check.ts"])
        .env("SEATRIAL_PAGE", &page)
        .env("SEATRIAL", binary())
        .env("SEATRIAL_PYTHON", python::of_tests("python"))
        .env("SEATRIAL_DATA", data()?);
    run(&mut tests, "tests of the page without a server")
}

/// Measures the page and the command side by side on a long log, and fails where a goal is missed.
pub fn measure() -> Result<(), String> {
    let Some(page) = build()? else { return Ok(()) };
    if !Path::new(page::BROWSER).exists() {
        return skipped("the page beside the terminal", "chromium is missing");
    }
    let make = |name, megabytes| long_log(in_target(FOLDER).join(name), megabytes);
    let log = make("trial.BIN", LONG_LOG_MB)?;
    let long = make("long.BIN", LONGEST_LOG_MB)?;
    let mut build = cargo(&["build", "--quiet", "--package", "seatrial-cli"]);
    run(&mut build, "cargo build -p seatrial-cli")?;
    let mut measure = page::node();
    measure
        .arg("tests/speed.ts")
        .env("SEATRIAL_PAGE", &page)
        .env("SEATRIAL", binary())
        .env("SEATRIAL_LOG", log)
        .env("SEATRIAL_LONG_LOG", long)
        .env(
            "SEATRIAL_TABLE",
            std::path::absolute(MEASURED).unwrap_or_default(),
        );
    run(&mut measure, "goals of the page")
}

/// Logs for tests, where they are.
fn data() -> Result<PathBuf, String> {
    match std::env::var_os("SEATRIAL_DATA") {
        Some(folder) => Ok(folder.into()),
        None => std::path::absolute("../shared/data").map_err(|error| error.to_string()),
    }
}

fn packed_bytes(page: &Path) -> Result<u64, String> {
    let packed = Command::new("gzip")
        .args(["-9", "--stdout"])
        .arg(page)
        .output()
        .map_err(|error| format!("gzip: {error}"))?;
    Ok(packed.stdout.len() as u64)
}

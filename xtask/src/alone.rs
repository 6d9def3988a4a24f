//! The page that stands alone: seatrial in WebAssembly, in one file that opens without a server.

use std::path::PathBuf;

use anyhow::{Result, ensure};

use crate::long_log::long_log;
use crate::shell::{Run, command};
use crate::toolchain::{BROWSER, needs_library};
use crate::workspace::{binary, data, in_target, root};
use crate::{page, python};

/// Where the last measurement is kept.
const MEASURED: &str = "validation/2026-11-25-page/table.md";
/// A log as long as a person waits for, MB.
const LONG_LOG_MB: &str = "62";
/// One that the browser does not keep, MB.
const LONGEST_LOG_MB: &str = "200";
/// The page as a server sends it, packed.
const MOST_BYTES: usize = 3_000_000;

/// The page as it is built.
pub fn place() -> PathBuf {
    in_target("alone/seatrial.html")
}

/// Compiles the module. It takes a minute or two where nothing is built yet.
pub fn compile() -> Result<()> {
    needs_library(BROWSER)?;
    page::prepare()?;
    command!("cargo rustc -p seatrial-wasm --lib --quiet --crate-type cdylib --profile wasm --target {BROWSER}").run()
}

/// Builds the page.
fn build() -> Result<PathBuf> {
    compile()?;
    let module = in_target(BROWSER).join("wasm/seatrial_wasm.wasm");
    let mut vite = page::vite("vite.alone.config.ts", &in_target("alone"));
    vite.env("SEATRIAL_WASM", module).run()?;
    Ok(place())
}

/// Builds the page, weighs it, and compares its answers with those of the terminal in a browser.
pub fn check() -> Result<()> {
    let page = build()?;
    let packed = command!("gzip -9 --stdout {page}").outcome()?.stdout.len();
    eprintln!("{}: {packed} bytes packed", page.display());
    ensure!(packed <= MOST_BYTES, "the page: {packed} bytes packed, more than {MOST_BYTES}");
    page::needs_browser()?;
    page::tests("tests/alone.check.ts")
        .env("SEATRIAL_PAGE", &page)
        .env("SEATRIAL_PYTHON", python::OF_TESTS.path("python"))
        .env("SEATRIAL_DATA", data())
        .run()
}

/// Measures the page and the command side by side on a long log, and fails where a goal is missed.
pub fn measure() -> Result<()> {
    let page = build()?;
    page::needs_browser()?;
    let log = long_log("alone/trial.BIN", LONG_LOG_MB)?;
    let long = long_log("alone/long.BIN", LONGEST_LOG_MB)?;
    command!("cargo build --quiet -p seatrial-cli").run()?;
    page::node("tests/speed.ts")
        .env("SEATRIAL_PAGE", page)
        .env("SEATRIAL", binary())
        .env("SEATRIAL_LOG", log)
        .env("SEATRIAL_LONG_LOG", long)
        .env("SEATRIAL_TABLE", root().join(MEASURED))
        .run()
}

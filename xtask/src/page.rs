//! The page of the dashboard: rebuilt from its source, compared with what is committed, and used in a browser.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::shell::{Run, command, files, shell};
use crate::steps::missing;
use crate::workspace::{binary, in_target, root};

const SOURCE: &str = "web";
const COMMITTED: &str = "crates/seatrial-dash/dist";
const BROWSER: &str = "/usr/bin/chromium";

/// Installs what the lock names where it is not there, or ends the step that needs it.
pub fn prepare() -> Result<()> {
    let lock = shell().read_file("web/package-lock.json")?;
    let installed = Path::new(SOURCE).join("node_modules/installed.json");
    if shell().read_file(&installed).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    let mut npm = command!("npm ci --no-audit --no-fund --loglevel=error");
    if npm.current_dir(SOURCE).run().is_err() {
        return missing("npm, or what package-lock.json names, is missing");
    }
    Ok(shell().write_file(installed, lock)?)
}

/// Ends a step that needs a browser where there is none.
pub fn needs_browser() -> Result<()> {
    match Path::new(BROWSER).exists() {
        true => Ok(()),
        false => missing("chromium is missing"),
    }
}

/// Builds the page and proves that the committed one is the same bytes, then opens it in a browser over `seatrial serve`.
pub fn check() -> Result<()> {
    prepare()?;
    node("node_modules/prettier/bin/prettier.cjs --check --log-level warn .").run()?;
    node("node_modules/typescript/bin/tsc --noEmit").run()?;
    let rebuilt = in_target("page");
    vite("vite.config.ts", &rebuilt).run()?;
    ensure!(
        content(&rebuilt)? == content(Path::new(COMMITTED))?,
        "{COMMITTED} is not what {SOURCE} builds: run `npm run build` in {SOURCE} and commit the result"
    );
    needs_browser()?;
    tests("tests/*.test.ts").run()
}

/// Vite, which builds a page into a folder.
pub fn vite(config: &str, out: &Path) -> Command {
    let mut vite = node("node_modules/vite/bin/vite.js build --logLevel warn");
    vite.args(["--config", config, "--outDir"]).arg(out);
    vite
}

/// Tests in a browser, which find the command that the tests built.
pub fn tests(files: &str) -> Command {
    let mut tests = node("--test --test-reporter=spec");
    tests.arg(files).env("SEATRIAL", binary());
    tests
}

/// The node that the lock pins, with words between blanks: a system's own may be too old for the tools.
pub fn node(words: &str) -> Command {
    let architecture = match std::env::consts::ARCH {
        "aarch64" => "arm64",
        _ => "x64",
    };
    let pinned = root().join(format!("{SOURCE}/node_modules/node-linux-{architecture}/bin/node"));
    let program = if pinned.exists() { pinned } else { PathBuf::from("node") };
    let words = words.split(' ');
    let mut node = command!("{program} {words...}");
    node.current_dir(SOURCE);
    node
}

/// Every file of a folder with its bytes.
fn content(folder: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let content = files(folder, "")?.into_iter().map(|file| {
        let bytes = shell().read_binary_file(&file)?;
        Ok((file.strip_prefix(folder)?.to_owned(), bytes))
    });
    content.collect()
}

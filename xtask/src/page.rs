//! The page of the dashboard: rebuilt from its source, compared with what is committed, and used in a browser.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::{run, skipped, succeeds};
use crate::target::{binary, in_target};

const SOURCE: &str = "web";
const COMMITTED: &str = "crates/seatrial-dash/dist";
const REBUILT: &str = "page";
pub const BROWSER: &str = "/usr/bin/chromium";
pub const NO_NPM: &str = "npm, or what package-lock.json names, is missing";

/// Installs what the lock names where it is not there.
pub fn prepare() {
    prepared();
}

/// Is what the lock names there, or could it be fetched?
pub fn prepared() -> bool {
    is_installed() || install()
}

/// Builds the page and proves that the committed one is the same bytes, then opens it in a browser over `seatrial serve`.
/// Where npm or the browser is missing, this is said and skipped; with `CI=true` it is a failure.
pub fn check() -> Result<(), String> {
    if !prepared() {
        return skipped("the page", NO_NPM);
    }
    with_node(
        "prettier/bin/prettier.cjs",
        &["--check", "--log-level", "warn", "."],
    )?;
    with_node("typescript/bin/tsc", &["--noEmit"])?;
    let rebuilt = in_target(REBUILT);
    let out = rebuilt.display().to_string();
    with_node(
        "vite/bin/vite.js",
        &["build", "--logLevel", "warn", "--outDir", &out],
    )?;
    compare(&rebuilt, Path::new(COMMITTED))?;
    if !Path::new(BROWSER).exists() {
        return skipped("the page", "chromium is missing");
    }
    let mut tests = node();
    tests
        .args(["--test", "--test-reporter=spec", "tests/*.test.ts"])
        .env("SEATRIAL", binary());
    run(&mut tests, "tests of the page in the browser")
}

/// Has `node_modules` what the lock names today?
fn is_installed() -> bool {
    let lock = std::fs::read(Path::new(SOURCE).join("package-lock.json"));
    let installed = std::fs::read(Path::new(SOURCE).join("node_modules/installed.json"));
    lock.is_ok_and(|lock| installed.is_ok_and(|installed| installed == lock))
}

fn install() -> bool {
    let mut npm = Command::new("npm");
    npm.args(["ci", "--no-audit", "--no-fund", "--loglevel=error"])
        .current_dir(SOURCE);
    let source = Path::new(SOURCE);
    succeeds(&mut npm)
        && std::fs::copy(
            source.join("package-lock.json"),
            source.join("node_modules/installed.json"),
        )
        .is_ok()
}

/// The node that the lock pins: a system's own may be too old for the tools.
pub fn node() -> Command {
    let architecture = match std::env::consts::ARCH {
        "aarch64" => "arm64",
        _ => "x64",
    };
    let pinned: PathBuf = [
        SOURCE,
        "node_modules",
        &format!("node-linux-{architecture}"),
        "bin/node",
    ]
    .iter()
    .collect();
    let program = match std::path::absolute(&pinned) {
        Ok(path) if path.exists() => path,
        _ => "node".into(),
    };
    let mut command = Command::new(program);
    command.current_dir(SOURCE);
    command
}

fn with_node(tool: &str, arguments: &[&str]) -> Result<(), String> {
    let mut command = node();
    command
        .arg(Path::new("node_modules").join(tool))
        .args(arguments);
    run(&mut command, format!("{tool} {}", arguments.join(" ")))
}

fn compare(rebuilt: &Path, committed: &Path) -> Result<(), String> {
    let (ours, built) = (files(committed)?, files(rebuilt)?);
    let same = ours.len() == built.len()
        && ours.iter().zip(&built).all(|(ours, built)| {
            let name = |file: &Path, place: &Path| file.strip_prefix(place).map(Path::to_owned);
            name(ours, committed) == name(built, rebuilt)
                && matches!((std::fs::read(ours), std::fs::read(built)), (Ok(a), Ok(b)) if a == b)
        });
    if same {
        Ok(())
    } else {
        Err(format!(
            "{COMMITTED} is not what {SOURCE} builds: found {ours:?}, built {built:?}. Run `npm run build` in {SOURCE} and commit the result"
        ))
    }
}

/// Every file of a folder and of those in it.
fn files(place: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", place.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(place).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

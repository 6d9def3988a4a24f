//! The command for Windows: built with mingw, packed, and held under Wine against the command of this machine.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::archive::{self, WINDOWS};
use crate::http::Client;
use crate::shell::{Run, command, empty_folder, has, patiently, shell, tell_size};
use crate::steps::missing;
use crate::toolchain::needs_library;
use crate::workspace::{binary, in_target};

const COMPILER: &str = "x86_64-w64-mingw32-gcc";
/// A library of Windows 10 that Debian 12's Wine lacks.
const RANDOM: &str = "xtask/src/windows_random.c";
/// Longest that anything may take to answer.
const PATIENCE: Duration = Duration::from_secs(120);
const LOGS: [&str; 3] = ["run.csv", "run.parquet", "run.mcap"];
const DASHBOARD: &str = "127.0.0.1:18042";
const VEHICLE: &str = "127.0.0.1:18550";

/// A short trial.
const PLAN: &str = include_str!("../../crates/seatrial-cli/tests/short_plan.toml");

/// Builds, packs and tries it.
pub fn check() -> Result<()> {
    needs_library(WINDOWS)?;
    for (program, package) in [(COMPILER, "gcc-mingw-w64-x86-64"), ("wine", "wine")] {
        if !has(program) {
            return missing(format!("{program} is missing: Debian's {package}"));
        }
    }
    command!("cargo build --quiet --release -p seatrial-cli --target {WINDOWS}").run()?;
    let exe = in_target(WINDOWS).join("release/seatrial.exe");
    command!("x86_64-w64-mingw32-strip {exe}").run()?;
    tell_size(&archive::zipped(&exe)?)?;
    command!("cargo build --quiet -p seatrial-cli").run()?;
    prepare(&exe)?;
    says_the_same()?;
    serves_the_page()?;
    tries_over_mavlink()?;
    is_interrupted()
}

/// A folder for the command of Windows and one for that of this machine, with the same files in both.
fn prepare(exe: &Path) -> Result<()> {
    empty_folder(&folder(""))?;
    for side in ["here", "wine"].map(folder) {
        shell().write_file(side.join("plan.toml"), PLAN)?;
        for log in LOGS {
            here(&format!("sim log --seed 1 --out {log}")).current_dir(&side).read()?;
        }
    }
    shell().copy_file(exe, folder("wine"))?;
    let library = folder("wine/bcryptprimitives.dll");
    command!("{COMPILER} -std=c99 -O2 -Wall -Werror -shared -o {library} {RANDOM} -ladvapi32")
        .run()?;
    // The first program of a fresh prefix waits for Wine's set-up.
    wine("--version").read().map(drop)
}

fn folder(name: &str) -> PathBuf {
    in_target("windows").join(name)
}

/// The command of this machine.
fn here(words: &str) -> Command {
    let (binary, words) = (binary(), words.split(' '));
    let mut command = command!("{binary} {words...}");
    command.current_dir(folder("here"));
    command
}

/// The command of Windows.
fn wine(words: &str) -> Command {
    let words = words.split(' ');
    in_own_prefix(command!("wine seatrial.exe {words...}"))
}

fn in_own_prefix(mut command: Command) -> Command {
    command.current_dir(folder("wine")).env("WINEPREFIX", folder("prefix"));
    command.env("WINEDEBUG", "-all").env_remove("DISPLAY");
    command
}

/// Both print equal bytes for a trial and for a model from each format.
fn says_the_same() -> Result<()> {
    let identify = LOGS.map(|log| format!("identify --json {log}"));
    for words in ["trial --yes --json --seed 7 --plan plan.toml".to_owned()].iter().chain(&identify)
    {
        let [here, wine] = [here(words).outcome()?, wine(words).outcome()?];
        // A log of one pair of doublets may leave a model that is not validated.
        let is_done = matches!(here.status.code(), Some(0 | 4));
        let is_same = here.status.code() == wine.status.code() && here.stdout == wine.stdout;
        let text = String::from_utf8_lossy(&wine.stdout);
        ensure!(is_done && is_same, "{words}: another answer under Wine:\n{text}");
        eprintln!("Windows: {words}: the same {} bytes", text.len());
    }
    Ok(())
}

/// The dashboard's page and everything that it names.
fn serves_the_page() -> Result<()> {
    let client = Client::of(DASHBOARD)?;
    let mut serve = wine(&format!("serve --listen {DASHBOARD}"));
    let _serving = serve.silent().begin()?;
    patiently(PATIENCE, "a page under Wine", || Ok(client.get("/").ok()))?;
    let files = client.page()?;
    for (name, text) in &files {
        let expected = shell().read_file(format!("crates/seatrial-dash/dist/{name}"))?;
        ensure!(*text == expected, "{name} is served with other bytes");
    }
    eprintln!("Windows: the dashboard serves its page and {} files", files.len());
    Ok(())
}

/// A trial under Wine on a vehicle of this machine; its logbook gives the same estimates here.
fn tries_over_mavlink() -> Result<()> {
    let mut vehicle = here(&format!("sim serve --udp {VEHICLE}"));
    let _vehicle = vehicle.silent().begin()?;
    let words = "--full-rudder-deg 14.9 --plan plan.toml --logbook mavlink.db";
    let trial =
        wine(&format!("trial --yes --json --vehicle mavlink:udp:{VEHICLE} {words}")).read()?;
    let trial: Value = serde_json::from_str(&trial)?;
    let a22 = &trial["runs"][0]["identification"]["refined"]["a22_per_s"];
    let mut replay = here("replay --json ../wine/mavlink.db");
    let replay: Value = serde_json::from_str(&replay.read()?)?;
    ensure!(
        replay["identical"] == true,
        "the logbook of a trial under Wine gives other estimates here"
    );
    eprintln!("Windows: a trial over MAVLink, a22 {a22} 1/s; replayed here bit for bit");
    Ok(())
}

/// Ctrl-C in a console aborts a trial, and the vehicle is handed back.
fn is_interrupted() -> Result<()> {
    let mut console = in_own_prefix(command!(
        "script -qec 'wine seatrial.exe trial --yes --realtime --logbook broken_off.db' /dev/null"
    ));
    console.env("TERM", "xterm").stdin(Stdio::piped()).stdout(Stdio::null());
    let mut trial = console.begin()?;
    let logbook = folder("wine/broken_off.db");
    patiently(PATIENCE, "a logbook under Wine", || Ok(logbook.exists().then_some(())))?;
    std::thread::sleep(Duration::from_secs(5));
    trial.0.stdin.take().context("no keyboard")?.write_all(b"\x03")?;
    let status = trial.0.wait()?;
    ensure!(status.code() == Some(5), "a trial that Ctrl-C ends: {status}");
    eprintln!("Windows: Ctrl-C in a console aborts a trial");
    Ok(())
}

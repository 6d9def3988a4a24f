//! The command for Windows: built with mingw, packed, and held under Wine against the command of this machine.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::archive::{self, WINDOWS};
use crate::http::Client;
use crate::run_cargo;
use crate::steps::{run, skipped};
use crate::target::{binary, in_target, root};
use crate::toolchain::{has_library, no_library};

const COMPILER: &str = "x86_64-w64-mingw32-gcc";
/// A library of Windows 10 that Debian 12's Wine lacks.
const RANDOM: &str = "xtask/src/windows_random.c";
const EXE: &str = "seatrial.exe";
/// Longest that anything may take to answer.
const PATIENCE: Duration = Duration::from_secs(120);

/// A short trial.
const PLAN: &str = include_str!("../../crates/seatrial-cli/tests/short_plan.toml");

/// Builds, packs and tries it.
pub fn check() -> Result<(), String> {
    if let Some(missing) = missing() {
        return skipped("Windows", &missing);
    }
    let exe = build()?;
    let zip = archive::zipped(&exe)?;
    let bytes = std::fs::metadata(&zip).map_or(0, |file| file.len());
    eprintln!("== {} of {:.1} MB", zip.display(), bytes as f64 / 1e6);
    run_cargo("build --quiet -p seatrial-cli")?;
    let both = Both::prepare(&exe)?;
    both.says_the_same()?;
    both.serves_the_page()?;
    both.tries_over_mavlink()?;
    both.is_interrupted()
}

fn missing() -> Option<String> {
    let runs = |name: &str| Command::new(name).arg("--version").output().is_ok();
    if !has_library(WINDOWS) {
        return Some(no_library(WINDOWS));
    }
    [(COMPILER, "gcc-mingw-w64-x86-64"), ("wine", "wine")]
        .into_iter()
        .find(|(program, _)| !runs(program))
        .map(|(program, package)| format!("{program} is missing: Debian's {package}"))
}

/// The command, without its symbols.
fn build() -> Result<PathBuf, String> {
    run_cargo(&format!(
        "build --quiet --release -p seatrial-cli --target {WINDOWS}"
    ))?;
    let exe = in_target(WINDOWS).join("release/seatrial.exe");
    let strip = "x86_64-w64-mingw32-strip";
    run(Command::new(strip).arg(&exe), strip).map(|()| exe)
}

/// The command of Windows and that of this machine, each in a folder of its own with the same files.
struct Both {
    folder: PathBuf,
}

/// A process that ends with this.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Both {
    fn prepare(exe: &Path) -> Result<Self, String> {
        let folder = in_target("windows");
        let _ = std::fs::remove_dir_all(&folder);
        let both = Self { folder };
        for side in ["here", "wine"] {
            let folder = both.folder.join(side);
            std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
            both.write_logs(&folder)?;
        }
        let wine = both.folder.join("wine");
        std::fs::copy(exe, wine.join(EXE)).map_err(|error| error.to_string())?;
        both.compile(
            RANDOM,
            &["-shared", "-o", "wine/bcryptprimitives.dll"],
            &["-ladvapi32"],
        )?;
        // The first program of a fresh prefix waits for Wine's set-up.
        let version = both
            .wine(&["--version"])
            .output()
            .map_err(|error| error.to_string())?;
        expect(&version, 0, "seatrial --version")?;
        Ok(both)
    }

    fn here(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(binary());
        command
            .args(arguments)
            .current_dir(self.folder.join("here"));
        command
    }

    fn wine(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("wine");
        command
            .arg(EXE)
            .args(arguments)
            .current_dir(self.folder.join("wine"));
        self.in_own_prefix(&mut command);
        command
    }

    fn in_own_prefix(&self, command: &mut Command) {
        command.env("WINEPREFIX", self.folder.join("prefix"));
        command.env("WINEDEBUG", "-all").env_remove("DISPLAY");
    }

    /// A simulated trial as CSV, Parquet and MCAP.
    fn write_logs(&self, folder: &Path) -> Result<(), String> {
        for name in ["run.csv", "run.parquet", "run.mcap"] {
            let made = ["sim", "log", "--seed", "1", "--out", name];
            let made = self.here(&made).current_dir(folder).output();
            expect(&made.map_err(|error| error.to_string())?, 0, name)?;
        }
        std::fs::write(folder.join("plan.toml"), PLAN).map_err(|error| error.to_string())
    }

    /// Both print equal bytes for a trial and for a model from each format.
    fn says_the_same(&self) -> Result<(), String> {
        let trial: Vec<&str> = "trial --yes --json --seed 7 --plan plan.toml"
            .split(' ')
            .collect();
        let logs = ["run.csv", "run.parquet", "run.mcap"];
        let identify = logs.map(|log| vec!["identify", "--json", log]);
        for arguments in std::iter::once(trial).chain(identify) {
            let title = arguments.join(" ");
            let [here, wine] =
                [self.here(&arguments), self.wine(&arguments)].map(|mut c| c.output());
            let [here, wine] = [here, wine].map(|said| said.map_err(|error| error.to_string()));
            let (here, wine) = (here?, wine?);
            // A log of one pair of doublets may leave a model that is not validated.
            let is_done = matches!(here.status.code(), Some(0 | 4));
            if !is_done || here.status.code() != wine.status.code() || here.stdout != wine.stdout {
                let text = String::from_utf8_lossy(&wine.stdout).into_owned();
                return Err(format!("{title}: another answer under Wine:\n{text}"));
            }
            eprintln!("Windows: {title}: the same {} bytes", wine.stdout.len());
        }
        Ok(())
    }

    /// The dashboard's page and everything that it names.
    fn serves_the_page(&self) -> Result<(), String> {
        let address = "127.0.0.1:18042";
        let client = Client::of(address);
        let serve = ["serve", "--listen", address];
        let mut serve = self.wine(&serve);
        let _serving = begin(serve.stdout(Stdio::null()).stderr(Stdio::null()))?;
        let page = patiently(|| client.get("/").ok())?;
        let names = page.split('"').filter(|name| name.starts_with("./assets/"));
        let names: Vec<&str> = names.collect();
        if names.is_empty() {
            return Err(format!("no page is served:\n{page}"));
        }
        for name in &names {
            let file = root().join("crates/seatrial-dash/dist").join(name);
            let expected = std::fs::read_to_string(&file).map_err(|error| error.to_string())?;
            if client.get(&name[1..])? != expected {
                return Err(format!("{name} is served with other bytes"));
            }
        }
        eprintln!(
            "Windows: the dashboard serves its page and {} files",
            names.len()
        );
        Ok(())
    }

    /// A trial under Wine on a vehicle of this machine; its logbook gives the same estimates here.
    fn tries_over_mavlink(&self) -> Result<(), String> {
        let address = "127.0.0.1:18550";
        let mut vehicle = self.here(&["sim", "mavlink", "--udp", address]);
        let _vehicle = begin(vehicle.stdout(Stdio::null()).stderr(Stdio::null()))?;
        let trial = format!(
            "trial --yes --json --vehicle mavlink:udp:{address} --full-rudder-deg 14.9 --plan plan.toml --logbook mavlink.db"
        );
        let trial: Vec<&str> = trial.split(' ').collect();
        let said = self.wine(&trial).output();
        let said = said.map_err(|error| error.to_string())?;
        expect(&said, 0, "a trial over MAVLink")?;
        let document = json(&said)?;
        let a22 = &document["runs"][0]["identification"]["refined"]["a22_per_s"];
        let logbook = self.folder.join("wine/mavlink.db").display().to_string();
        let replay = self.here(&["replay", "--json", &logbook]).output();
        let replay = replay.map_err(|error| error.to_string())?;
        expect(&replay, 0, "replay")?;
        if json(&replay)?["identical"] != true {
            return Err("the logbook of a trial under Wine gives other estimates here".into());
        }
        eprintln!("Windows: a trial over MAVLink, a22 {a22} 1/s; replayed here bit for bit");
        Ok(())
    }

    fn compile(&self, source: &str, options: &[&str], libraries: &[&str]) -> Result<(), String> {
        let mut gcc = Command::new(COMPILER);
        gcc.args(["-std=c99", "-O2", "-Wall", "-Werror"])
            .args(options);
        gcc.arg(root().join(source)).args(libraries);
        run(
            gcc.current_dir(&self.folder),
            format!("{source} does not compile"),
        )
    }

    /// Ctrl-C in a console aborts a trial, and the vehicle is handed back.
    fn is_interrupted(&self) -> Result<(), String> {
        let trial = format!("wine {EXE} trial --yes --realtime --logbook broken_off.db");
        let mut console = Command::new("script");
        console
            .args(["-qec", &trial, "/dev/null"])
            .env("TERM", "xterm");
        console.current_dir(self.folder.join("wine"));
        self.in_own_prefix(&mut console);
        let mut trial = begin(console.stdin(Stdio::piped()).stdout(Stdio::null()))?;
        let logbook = self.folder.join("wine/broken_off.db");
        patiently(|| logbook.exists().then_some(()))?;
        std::thread::sleep(Duration::from_secs(5));
        let mut keyboard = trial.0.stdin.take().ok_or("no keyboard")?;
        keyboard
            .write_all(b"\x03")
            .map_err(|error| error.to_string())?;
        let status = trial.0.wait().map_err(|error| error.to_string())?;
        match status.code() {
            Some(5) => {
                eprintln!("Windows: Ctrl-C in a console aborts a trial");
                Ok(())
            }
            _ => Err(format!("a trial that Ctrl-C ends: {status}")),
        }
    }
}

fn begin(command: &mut Command) -> Result<Running, String> {
    command
        .spawn()
        .map(Running)
        .map_err(|error| error.to_string())
}

fn expect(said: &Output, code: i32, what: &str) -> Result<(), String> {
    match said.status.code() == Some(code) {
        true => Ok(()),
        false => Err(format!(
            "{what}: {}\n{}",
            said.status,
            String::from_utf8_lossy(&said.stderr)
        )),
    }
}

fn json(said: &Output) -> Result<Value, String> {
    serde_json::from_slice(&said.stdout).map_err(|error| error.to_string())
}

fn patiently<T>(ask: impl Fn() -> Option<T>) -> Result<T, String> {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        if let Some(answer) = ask() {
            return Ok(answer);
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    Err("no answer under Wine".into())
}

//! Commands, files and waiting, each with a message that says what failed.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use walkdir::WalkDir;
use xshell::Shell;

use crate::workspace::target;

/// A [`Command`] of the words between blanks. `{value}` stands for a value, `{list...}` for as many words as the list has.
macro_rules! command {
    ($words:literal) => {{
        let shell = $crate::shell::shell();
        std::process::Command::from(xshell::cmd!(shell, $words))
    }};
}
pub(crate) use command;

/// Reads and writes files. Its commands build into one folder.
pub fn shell() -> Shell {
    let shell = Shell::new().expect("the working folder is there");
    shell.set_var("CARGO_TARGET_DIR", target());
    shell
}

/// What can be done with a command. [`end_all`] ends those that run.
pub trait Run {
    /// The command itself.
    fn command(&mut self) -> &mut Command;

    /// Runs it; what it prints is seen. An error where it fails.
    fn run(&mut self) -> Result<()> {
        let output = wait_for(self.command())?;
        succeeded(self.command(), &output).map(drop)
    }

    /// What it prints to its standard output. An error where it fails.
    fn read(&mut self) -> Result<String> {
        let output = self.outcome()?;
        succeeded(self.command(), &output)
    }

    /// How it ends, with what it prints.
    fn outcome(&mut self) -> Result<Output> {
        let command = self.command().stdin(Stdio::null());
        wait_for(command.stdout(Stdio::piped()).stderr(Stdio::piped()))
    }

    /// Whether it is there and does not fail.
    fn works(&mut self) -> bool {
        self.read().is_ok()
    }

    /// Keeps to itself what it prints.
    fn silent(&mut self) -> &mut Command {
        self.command().stdout(Stdio::null()).stderr(Stdio::null())
    }

    /// Begins it and does not wait.
    fn begin(&mut self) -> Result<Running> {
        let command = self.command();
        command.spawn().map(Running).with_context(|| words(command))
    }
}

impl Run for Command {
    fn command(&mut self) -> &mut Command {
        self
    }
}

fn succeeded(command: &Command, output: &Output) -> Result<String> {
    let said = String::from_utf8_lossy(&output.stdout);
    if output.status.success() {
        return Ok(said.into_owned());
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    bail!("{}: {}\n{said}{errors}", words(command), output.status)
}

/// The processes that commands wait for; `None` once all are to end.
static RUNNING: Mutex<Option<Vec<u32>>> = Mutex::new(Some(Vec::new()));

fn wait_for(command: &mut Command) -> Result<Output> {
    let child = {
        let mut running = RUNNING.lock().expect("no panic");
        let running = running.as_mut().context("another step has failed")?;
        let child = command.spawn().with_context(|| words(command))?;
        running.push(child.id());
        child
    };
    let id = child.id();
    let output = child.wait_with_output();
    if let Some(running) = RUNNING.lock().expect("no panic").as_mut() {
        running.retain(|other| *other != id);
    }
    output.with_context(|| words(command))
}

/// Ends every command that is waited for; no other begins.
pub fn end_all() {
    let running = RUNNING.lock().expect("no panic").take();
    running.into_iter().flatten().for_each(ask_to_end);
}

/// Whether [`end_all`] was called.
pub fn is_over() -> bool {
    RUNNING.lock().expect("no panic").is_none()
}

/// Asks a process to end, by the shell's own `kill`: the smallest systems have no program of that name.
pub fn ask_to_end(process: impl Display) {
    let kill = format!("kill -TERM {process}");
    // One that has ended already cannot be asked.
    let _ = Command::new("sh").args(["-c", &kill]).status();
}

/// A command as it is typed.
pub fn words(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    words.join(" ")
}

/// A process that ends with this.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Asks until there is an answer; an error where there is none in time.
pub fn patiently<T>(
    patience: Duration,
    what: &str,
    mut ask: impl FnMut() -> Result<Option<T>>,
) -> Result<T> {
    let begun = Instant::now();
    while begun.elapsed() < patience {
        if let Some(answer) = ask()? {
            return Ok(answer);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    bail!("{what}: not in {} s", patience.as_secs())
}

/// An empty folder where anything was before.
pub fn empty_folder(path: &Path) -> Result<()> {
    shell().remove_path(path)?;
    Ok(shell().create_dir(path).map(drop)?)
}

/// Copies a file, and makes the folder that it goes to.
pub fn put(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<()> {
    let to = to.as_ref();
    shell().create_dir(to.parent().unwrap_or(to))?;
    Ok(shell().copy_file(from, to)?)
}

/// Whether a program is there and tells its version.
pub fn has(program: &str) -> bool {
    command!("{program} --version").works()
}

/// Fails where something took longer than its goal, s.
pub fn in_time(what: &str, seconds: f64, goal_s: f64) -> Result<()> {
    eprintln!("== {what} in {seconds:.1} s");
    ensure!(seconds < goal_s, "{what}: more than {goal_s} s");
    Ok(())
}

/// Every file of a folder and of those in it with this suffix, or with any where it is empty, sorted.
pub fn files(folder: &Path, suffix: &str) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in WalkDir::new(folder).sort_by_file_name() {
        let entry = entry?;
        let is_named =
            suffix.is_empty() || entry.path().extension().is_some_and(|own| own == suffix);
        if is_named && entry.file_type().is_file() {
            files.push(entry.into_path());
        }
    }
    Ok(files)
}

/// Prints a file's place and size.
pub fn tell_size(file: &Path) -> Result<()> {
    let bytes = std::fs::metadata(file).with_context(|| file.display().to_string())?.len();
    let megabytes = bytes as f64 / 1e6;
    eprintln!("== {} of {megabytes:.1} MB", file.display());
    Ok(())
}

//! Whether a binary still gives the answers of another one, bit for bit.

mod cases;
mod document;
mod manifest;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use cases::Case;
use document::Document;
use manifest::Manifest;

use crate::target::in_target;

const HELP: &str = "\
Records what a seatrial binary answers to every log of the data and to simulated trials, and compares with what another one answered

usage: cargo xtask same-answers [--binary PATH] [--out DIR] [--against DIR|FILE] [--quick] [--jobs N]

  --binary PATH    the binary [default: release/seatrial where cargo builds]
  --out DIR        where the documents and manifest.txt go [default: same-answers there]
  --against DIR    the --out of another binary: tells which field differs first
  --against FILE   a manifest: tells only which documents differ
  --quick          39 documents in half a minute, for work in progress, instead of 456 in four minutes
  --jobs N         processes at a time [default: 2]

The data are those of SEATRIAL_DATA or ../shared/data. Paths, times that a computation took, versions and dates are left out.
Sentences for people are hashed apart: where only they differ, this is said and is no failure.

Exit code 0: the answers are the same; 4: some differ.

Example, while working on a change:
  cargo build --release -p seatrial-cli
  cargo xtask same-answers --quick --against validation/2026-11-25-same-answers/manifest.txt";

struct Options {
    binary: PathBuf,
    out: PathBuf,
    against: Option<PathBuf>,
    quick: bool,
    jobs: usize,
}

/// Runs `cargo xtask same-answers` with the arguments after it.
pub fn run(arguments: &[&str]) -> ExitCode {
    if arguments.iter().any(|a| ["--help", "-h"].contains(a)) {
        println!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let options = match Options::parse(arguments) {
        Ok(options) => options,
        Err(message) => {
            eprintln!("same-answers: {message}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    match record_and_compare(&options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(4),
        Err(message) => {
            eprintln!("same-answers: {message}");
            ExitCode::FAILURE
        }
    }
}

impl Options {
    fn parse(arguments: &[&str]) -> Result<Self, String> {
        let mut options = Self {
            binary: in_target("release/seatrial"),
            out: in_target("same-answers"),
            against: None,
            quick: false,
            jobs: 2,
        };
        let mut rest = arguments.iter().copied();
        while let Some(argument) = rest.next() {
            if argument == "--quick" {
                options.quick = true;
                continue;
            }
            let value = rest
                .next()
                .ok_or(format!("{argument} is not known or has no value"))?;
            match argument {
                "--binary" => options.binary = value.into(),
                "--out" => options.out = value.into(),
                "--against" => options.against = Some(value.into()),
                "--jobs" => {
                    let jobs = value.parse().ok().filter(|jobs| *jobs > 0);
                    options.jobs = jobs.ok_or(format!("--jobs {value} is not a count"))?;
                }
                _ => return Err(format!("{argument} is not known")),
            }
        }
        options.binary = absolute(&options.binary)?;
        options.out = absolute(&options.out)?;
        Ok(options)
    }
}

fn absolute(path: &Path) -> Result<PathBuf, String> {
    std::path::absolute(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn record_and_compare(options: &Options) -> Result<bool, String> {
    let data = std::env::var_os("SEATRIAL_DATA").map_or("../shared/data".into(), PathBuf::from);
    let data = data
        .canonicalize()
        .map_err(|error| format!("{}: {error}", data.display()))?;
    let cases = cases::all(&data, options.quick)?;
    // What is compared with is read first: `--out` may be the same folder.
    let before = options.against.as_deref().map(Manifest::read).transpose()?;
    let documents = answers(options, &data, &cases)?;
    let _ = std::fs::remove_dir_all(options.out.join("work"));
    let now = Manifest::of(&documents);
    document::write_all(&options.out, &documents)?;
    now.write(&options.out.join("manifest.txt"))?;
    println!(
        "{} documents of {} in {}",
        documents.len(),
        options.binary.display(),
        options.out.display()
    );
    Ok(before.is_none_or(|before| manifest::compare(&before, &now, &documents, !options.quick)))
}

/// The documents of every case, sorted by name.
fn answers(options: &Options, data: &Path, cases: &[Case]) -> Result<Vec<Document>, String> {
    let next = AtomicUsize::new(0);
    let documents = Mutex::new(Vec::new());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..options.jobs {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    match answer(options, data, case) {
                        Ok(made) => documents.lock().expect("no panic").extend(made),
                        Err(failure) => failures.lock().expect("no panic").push(failure),
                    }
                }
            });
        }
    });
    let failures = failures.into_inner().expect("no panic");
    if !failures.is_empty() {
        return Err(failures.join("\n"));
    }
    let mut documents = documents.into_inner().expect("no panic");
    documents.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(documents)
}

/// Runs the commands of a case one after the other in a folder of its own.
fn answer(options: &Options, data: &Path, case: &Case) -> Result<Vec<Document>, String> {
    let name = &case.commands[0].0;
    let folder = options
        .out
        .join("work")
        .join(name.replace(['/', ' ', ':'], "_"));
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut documents = Vec::new();
    for (name, arguments) in &case.commands {
        let output = Command::new(&options.binary)
            .args(arguments)
            .current_dir(&folder)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| format!("{}: {error}", options.binary.display()))?;
        let exit = output
            .status
            .code()
            .ok_or(format!("{name}: {}", output.status))?;
        documents.push(Document::new(name, exit, &output.stdout, data)?);
    }
    std::fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(documents)
}

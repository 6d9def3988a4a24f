//! Whether a binary still gives the answers of another one, bit for bit.

mod cases;
mod document;
mod manifest;

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::{Context, Result};

use crate::shell::{Run, command, empty_folder, shell};
use crate::workspace::{data, in_target, root};
use cases::Case;
use document::Document;
use manifest::Manifest;

/// Records what a binary answers to every log of the data and to simulated trials, and compares with what another one answered
///
/// The data are those of SEATRIAL_DATA or ../shared/data. Paths, times that a computation took, versions and dates are left out.
/// Sentences for people are hashed apart: where only they differ, this is said and is no failure.
///
/// Exit code 0: the answers are the same; 4: some differ.
///
/// While working on a change, after cargo build --release -p seatrial-cli:
/// cargo xtask same-answers --quick --against validation/2026-11-25-same-answers/manifest.txt
#[derive(clap::Args)]
pub struct Options {
    /// The binary [default: release/seatrial where cargo builds]
    #[arg(long, value_name = "PATH", value_parser = absolute)]
    binary: Option<PathBuf>,
    /// Where the documents and manifest.txt go [default: same-answers there]
    #[arg(long, value_name = "DIR", value_parser = absolute)]
    out: Option<PathBuf>,
    /// The --out of another binary: tells which field differs first; or a manifest: tells only which documents differ
    #[arg(long, value_name = "DIR|FILE", value_parser = absolute)]
    against: Option<PathBuf>,
    /// 39 documents in half a minute, for work in progress, instead of 516 in four minutes
    #[arg(long)]
    quick: bool,
    /// Processes at a time
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..))]
    jobs: u8,
}

/// A path as seen from where the command is typed.
fn absolute(path: &str) -> std::io::Result<PathBuf> {
    std::path::absolute(path)
}

/// Records and compares. `true`: the answers are the same, or were not compared.
pub fn run(options: &Options) -> Result<bool> {
    let data = data();
    let data = data.canonicalize().with_context(|| data.display().to_string())?;
    let or_in_target = |path: &Option<PathBuf>, otherwise: &str| {
        path.clone().unwrap_or_else(|| in_target(otherwise))
    };
    let binary = or_in_target(&options.binary, "release/seatrial");
    let out = or_in_target(&options.out, "same-answers");
    let cases = cases::all(&data, options.quick)?;
    // What is compared with is read first: `--out` may be the same folder.
    let before = options.against.as_deref().map(Manifest::read).transpose()?;
    let left = Mutex::new(cases.iter());
    let next = || left.lock().expect("no panic").next();
    let mut documents = Vec::new();
    std::thread::scope(|scope| {
        let all_of_one = || {
            let answers = std::iter::from_fn(next).map(|case| answer(&binary, &out, &data, case));
            answers.collect::<Result<Vec<_>>>()
        };
        let jobs: Vec<_> = (0..options.jobs).map(|_| scope.spawn(all_of_one)).collect();
        for job in jobs {
            documents.extend(job.join().expect("no panic")?.into_iter().flatten());
        }
        anyhow::Ok(())
    })?;
    documents.sort_by(|a, b| a.name.cmp(&b.name));
    shell().remove_path(out.join("work"))?;
    let now = Manifest::of(&documents);
    for document in &documents {
        let text = format!("{:#}\n", document.value);
        shell().write_file(out.join(format!("{}.json", document.name)), text)?;
    }
    now.write(&out.join("manifest.txt"))?;
    println!("{} documents of {} in {}", documents.len(), binary.display(), out.display());
    Ok(before.is_none_or(|before| manifest::compare(&before, &now, &documents, !options.quick)))
}

/// Runs the commands of a case one after the other in a folder of its own.
fn answer(binary: &Path, out: &Path, data: &Path, case: &Case) -> Result<Vec<Document>> {
    let (first, _) = &case[0];
    let folder = out.join("work").join(first.replace(['/', ' ', ':'], "_"));
    empty_folder(&folder)?;
    let documents = case.iter().map(|(name, words)| {
        let arguments = words.split(' ').map(|word| match word.split_once('/') {
            Some(("DATA", file)) => data.join(file),
            Some(("ROOT", file)) => root().join(file),
            _ => PathBuf::from(word),
        });
        let mut command = command!("{binary} {arguments...}");
        let output = command.current_dir(&folder).outcome()?;
        let exit = output.status.code();
        let exit = exit.with_context(|| format!("{words}: {}", output.status))?;
        Document::new(name, exit, &output.stdout, data)
    });
    let documents = documents.collect::<Result<Vec<_>>>()?;
    shell().remove_path(&folder)?;
    Ok(documents)
}

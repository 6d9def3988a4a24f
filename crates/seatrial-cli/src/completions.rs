//! `seatrial completions`: a script with which a shell completes verbs and options, and pages for `man`.

use std::path::{Path, PathBuf};

use clap_complete::{Shell, generate};
use serde::Serialize;

use crate::output::{Exit, Failure, Output, OutputPath};

/// Print a script with which a shell completes verbs and options, or write the pages for `man`.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Examples, for bash and for man:
  seatrial completions bash > seatrial.bash && . ./seatrial.bash
  seatrial completions --man man/man1

`man -M man seatrial-identify` shows a page.")]
pub struct Args {
    /// The shell.
    #[arg(required_unless_present = "man")]
    shell: Option<Shell>,
    /// Write a page for `man` of the program and of each verb into this folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "shell")]
    man: Option<OutputPath>,
}

/// `completions --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    shell: String,
    script: String,
}

/// `completions --man --json`.
#[derive(Serialize)]
struct Pages {
    schema: &'static str,
    pages: Vec<PathBuf>,
}

/// Runs the verb for this command.
pub fn run(args: &Args, command: clap::Command, output: &Output) -> Result<Exit, Failure> {
    match (args.shell, &args.man) {
        (Some(shell), _) => script(shell, command, output),
        (None, Some(folder)) => man(folder, command, output),
        (None, None) => Err(Failure::usage("completions: name a shell, or a folder with --man")),
    }
    .map(|()| Exit::Done)
}

fn script(shell: Shell, mut command: clap::Command, output: &Output) -> Result<(), Failure> {
    let mut script = Vec::new();
    generate(shell, &mut command, "seatrial", &mut script);
    let document = Document {
        schema: "seatrial.completions.v1",
        shell: shell.to_string(),
        script: String::from_utf8(script).map_err(Failure::internal)?,
    };
    output.print(&document, || document.script.clone())
}

/// Writes `seatrial.1`, `seatrial-identify.1` and so on.
fn man(folder: &Path, command: clap::Command, output: &Output) -> Result<(), Failure> {
    let not_saved =
        |error: std::io::Error| Failure::not_saved(format!("{}: {error}", folder.display()));
    // The library writes over what is there.
    let made = tempfile::tempdir().map_err(not_saved)?;
    clap_mangen::generate_to(command, made.path()).map_err(not_saved)?;
    std::fs::create_dir_all(folder).map_err(not_saved)?;
    let mut pages = Vec::new();
    for entry in std::fs::read_dir(made.path()).map_err(not_saved)? {
        let entry = entry.map_err(not_saved)?;
        let page = folder.join(entry.file_name());
        output.save(&page, std::fs::read(entry.path()).map_err(not_saved)?)?;
        pages.push(page);
    }
    pages.sort();
    let document = Pages { schema: "seatrial.man.v1", pages };
    output.print(&document, || {
        format!(
            "{} pages in {}: man -l {}",
            document.pages.len(),
            folder.display(),
            folder.join("seatrial.1").display()
        )
    })
}

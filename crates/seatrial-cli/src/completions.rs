//! `seatrial completions`: a script with which a shell completes verbs and options.

use clap_complete::{Shell, generate};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};

/// Print a script with which a shell completes verbs and options.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Example, for bash:
  seatrial completions bash > seatrial.bash && . ./seatrial.bash")]
pub struct Args {
    /// The shell.
    shell: Shell,
}

/// `completions --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    shell: String,
    script: String,
}

/// Runs the verb for this command.
pub fn run(args: &Args, mut command: clap::Command, output: &Output) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut command, "seatrial", &mut script);
    let document = Document {
        schema: "seatrial.completions.v1",
        shell: args.shell.to_string(),
        script: String::from_utf8(script).map_err(Failure::internal)?,
    };
    output.print(&document, || document.script.clone())?;
    Ok(Exit::Done)
}

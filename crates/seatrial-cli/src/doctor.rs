//! `seatrial doctor`: what is wrong with the set-up of this machine.

use std::fmt::Write as _;
use std::path::PathBuf;

use seatrial_app::trials::set_up::{Finding, look};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::screen::{labelled, width};

/// Look for what is wrong with the set-up of this machine: folder, logbook, earlier trials, ports.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Exit code 0: nothing is wrong; 4: something is, and what to do is said.

Example:
  seatrial doctor")]
pub struct Args {
    /// The logbook that trials are kept in.
    #[arg(long, value_name = "FILE", default_value = "seatrial.db")]
    logbook: PathBuf,
}

/// `doctor --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    version: &'static str,
    findings: Vec<Finding>,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let document = Document {
        schema: "seatrial.doctor.v1",
        version: env!("CARGO_PKG_VERSION"),
        findings: look(&args.logbook, links()),
    };
    output.print(&document, || text(&document, width()))?;
    Ok(Exit::done_if(document.findings.iter().all(|f| f.is_good)))
}

fn text(document: &Document, width: usize) -> String {
    let mut text = format!("seatrial {}\n", document.version);
    for finding in &document.findings {
        let sign = if finding.is_good { "ok " } else { "BAD" };
        text += &labelled(&format!("{sign}  {:10}", finding.what), &finding.found, width);
        if !finding.action.is_empty() {
            text += &labelled(&format!("{:15}", ""), &finding.action, width);
        }
    }
    let wrong = document.findings.iter().filter(|f| !f.is_good).count();
    let _ = match wrong {
        0 => writeln!(text, "Nothing is wrong. Next: seatrial demo"),
        1 => writeln!(text, "1 thing is wrong."),
        _ => writeln!(text, "{wrong} things are wrong."),
    };
    text
}

/// What this build can talk to.
fn links() -> String {
    let built = [
        (true, "MAVLink"),
        (cfg!(feature = "ros2"), "ROS 2 over DDS"),
        (cfg!(feature = "ros2-zenoh"), "ROS 2 over zenoh"),
        (cfg!(feature = "foxglove"), "Foxglove"),
    ];
    let names: Vec<&str> = built.iter().filter(|b| b.0).map(|b| b.1).collect();
    format!("this build has {}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_is_wrong_is_counted() {
        let wrong = || Finding::bad("logbook", "seatrial.db: no logbook", "Move it away.");
        let document = |findings| Document { schema: "", version: "1", findings };
        let printed = text(&document(vec![wrong(), wrong()]), 80);
        assert!(
            printed.contains("BAD  logbook") && printed.contains("2 things are wrong."),
            "{printed}"
        );
        let printed = text(&document(vec![Finding::good("folder", "here")]), 80);
        assert!(printed.contains("Nothing is wrong."), "{printed}");
    }
}

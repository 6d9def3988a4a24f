//! `seatrial doctor`: what is wrong with the set-up of this machine.

use std::fmt::Write as _;
use std::net::TcpListener;
use std::path::{Path, PathBuf};

use seatrial_logbook::Logbook;
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::screen::{labelled, width};

/// Where the dashboard listens without an option.
const DASHBOARD: &str = "127.0.0.1:8042";

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

/// Something that was looked at.
#[derive(Debug, PartialEq, Serialize)]
struct Finding {
    what: &'static str,
    is_good: bool,
    found: String,
    /// What to do; empty where nothing is wrong.
    action: String,
}

impl Finding {
    fn good(what: &'static str, found: impl Into<String>) -> Self {
        Self {
            what,
            is_good: true,
            found: found.into(),
            action: String::new(),
        }
    }

    fn bad(what: &'static str, found: impl Into<String>, action: impl Into<String>) -> Self {
        Self {
            what,
            is_good: false,
            found: found.into(),
            action: action.into(),
        }
    }
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
    let mut findings = vec![
        folder(&args.logbook),
        logbook(&args.logbook),
        earlier_trial(&args.logbook),
        dashboard(),
        Finding::good("links", links()),
    ];
    findings.extend(serial_ports());
    let document = Document {
        schema: "seatrial.doctor.v1",
        version: env!("CARGO_PKG_VERSION"),
        findings,
    };
    output.print(&document, || text(&document, width()))?;
    Ok(match document.findings.iter().all(|f| f.is_good) {
        true => Exit::Done,
        false => Exit::Rejected,
    })
}

fn text(document: &Document, width: usize) -> String {
    let mut text = format!("seatrial {}\n", document.version);
    for finding in &document.findings {
        let sign = if finding.is_good { "ok " } else { "BAD" };
        text += &labelled(
            &format!("{sign}  {:10}", finding.what),
            &finding.found,
            width,
        );
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

/// Can a logbook be written where it is to be?
fn folder(logbook: &Path) -> Finding {
    let folder = match logbook.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let probe = folder.join(format!(".seatrial-doctor-{}", std::process::id()));
    let written = std::fs::write(&probe, "seatrial doctor");
    // A probe that was written can be removed, or is named in the answer.
    let removed = written.and_then(|()| std::fs::remove_file(&probe));
    match removed {
        Ok(()) => Finding::good("folder", format!("{} can be written to", folder.display())),
        Err(error) => Finding::bad(
            "folder",
            format!("{}: {error}", folder.display()),
            "Go to a folder of your own, or name one with --logbook FILE.",
        ),
    }
}

fn logbook(path: &Path) -> Finding {
    if !path.exists() {
        return Finding::good(
            "logbook",
            format!("{} is made by the first trial", path.display()),
        );
    }
    match Logbook::open_read_only(path).and_then(|logbook| logbook.campaigns()) {
        Ok(campaigns) => Finding::good(
            "logbook",
            format!("{}: {} campaigns", path.display(), campaigns.len()),
        ),
        Err(error) => Finding::bad(
            "logbook",
            error.to_string(),
            "Name another logbook with --logbook FILE, or move this file away.",
        ),
    }
}

/// Was a trial on an autopilot cut short before it could put everything back?
fn earlier_trial(logbook: &Path) -> Finding {
    let left = logbook.with_extension("restore.toml");
    match left.exists() {
        false => Finding::good("vehicle", "no trial was cut short"),
        true => Finding::bad(
            "vehicle",
            format!("{}: a trial was cut short", left.display()),
            format!(
                "Put the vehicle back: seatrial vehicle restore {} --vehicle VEHICLE",
                left.display()
            ),
        ),
    }
}

fn dashboard() -> Finding {
    match TcpListener::bind(DASHBOARD) {
        Ok(_) => Finding::good("dashboard", format!("{DASHBOARD} is free")),
        Err(error) => Finding::bad(
            "dashboard",
            format!("{DASHBOARD}: {error}"),
            "Stop what listens there, or serve elsewhere: seatrial serve --listen 127.0.0.1:8043",
        ),
    }
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

/// Serial ports of autopilots: may they be opened?
fn serial_ports() -> Vec<Finding> {
    let Ok(devices) = std::fs::read_dir("/dev") else {
        return Vec::new();
    };
    let is_autopilot = |name: &str| name.starts_with("ttyACM") || name.starts_with("ttyUSB");
    let ports = devices.filter_map(Result::ok).filter(|device| {
        let name = device.file_name();
        is_autopilot(&name.to_string_lossy())
    });
    ports
        .map(|port| {
            let path = port.path();
            match std::fs::OpenOptions::new().read(true).write(true).open(&path) {
                Ok(_) => Finding::good("serial", format!("{} can be opened", path.display())),
                Err(error) => Finding::bad(
                    "serial",
                    format!("{}: {error}", path.display()),
                    "Add yourself to the group that owns it (on most systems dialout), and log in again.",
                ),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_is_wrong_is_found_and_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("seatrial.db");
        assert!(super::folder(&path).is_good && logbook(&path).is_good);
        assert!(earlier_trial(&path).is_good);
        std::fs::write(&path, "no logbook".repeat(99)).expect("written");
        std::fs::write(folder.path().join("seatrial.restore.toml"), "").expect("written");
        let findings = vec![
            super::folder(&folder.path().join("none/seatrial.db")),
            logbook(&path),
            earlier_trial(&path),
        ];
        assert!(findings.iter().all(|f| !f.is_good && !f.action.is_empty()));
        let document = Document {
            schema: "",
            version: "1",
            findings,
        };
        let text = text(&document, 80);
        assert!(text.contains("3 things are wrong."), "{text}");
        assert!(text.contains("seatrial vehicle restore"), "{text}");
    }
}

//! What is wrong with the set-up of this machine: folder, logbook, earlier trials, ports.

use std::net::TcpListener;
use std::path::Path;

use seatrial_logbook::{Error, Logbook, Verification};
use serde::Serialize;

/// Where the dashboard listens without an option.
const DASHBOARD: &str = "127.0.0.1:8042";

/// Something that was looked at.
#[derive(Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: &'static str,
    /// Is it as it must be?
    pub is_good: bool,
    /// What was found.
    pub found: String,
    /// What to do; empty where nothing is wrong.
    pub action: String,
}

impl Finding {
    /// A finding that all is well.
    pub fn good(what: &'static str, found: impl Into<String>) -> Self {
        Self { what, is_good: true, found: found.into(), action: String::new() }
    }

    /// Something is wrong.
    pub fn bad(what: &'static str, found: impl Into<String>, action: impl Into<String>) -> Self {
        Self { what, is_good: false, found: found.into(), action: action.into() }
    }
}

/// Looks at this machine, whose trials are kept in this logbook. `links` is what the program can talk to.
pub fn look(path: &Path, links: String) -> Vec<Finding> {
    let mut findings = vec![
        folder(path),
        logbook(path),
        earlier_trial(path),
        dashboard(),
        Finding::good("links", links),
    ];
    findings.extend(serial_ports());
    findings
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

/// Can the logbook be read, where there is one?
fn logbook(path: &Path) -> Finding {
    if !path.exists() {
        return Finding::good("logbook", format!("{} is made by the first trial", path.display()));
    }
    let looked = || -> Result<_, Error> {
        let logbook = Logbook::open_read_only(path)?;
        Ok((logbook.verify()?, logbook.entries()?))
    };
    match looked() {
        Ok((found, _)) if !found.is_whole() => Finding::bad(
            "logbook",
            what_is_wrong(path, &found),
            "See what can be trusted: seatrial logbook --verify. Keep trials in a new file: --logbook FILE.",
        ),
        Ok((_, campaigns)) => Finding::good(
            "logbook",
            format!(
                "{}: {} campaign{}",
                path.display(),
                campaigns.len(),
                if campaigns.len() == 1 { "" } else { "s" }
            ),
        ),
        Err(error) => Finding::bad(
            "logbook",
            error.to_string(),
            "Name another logbook with --logbook FILE, or move this file away.",
        ),
    }
}

fn what_is_wrong(path: &Path, found: &Verification) -> String {
    match found.damage.first() {
        Some(damage) => format!("{}: damaged: {}: {}", path.display(), damage.place, damage.found),
        None => found.missing.clone().unwrap_or_default(),
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

/// Is the dashboard's address free?
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
    fn exact_what_is_wrong_is_found() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("seatrial.db");
        assert!(folder(&path).is_good && logbook(&path).is_good);
        assert!(earlier_trial(&path).is_good);
        std::fs::write(&path, "no logbook".repeat(99)).expect("written");
        std::fs::write(place.path().join("seatrial.restore.toml"), "").expect("written");
        let findings =
            [folder(&place.path().join("none/seatrial.db")), logbook(&path), earlier_trial(&path)];
        assert!(findings.iter().all(|f| !f.is_good && !f.action.is_empty()));
        assert!(findings[2].action.contains("seatrial vehicle restore"));
    }

    #[test]
    fn exact_a_damaged_logbook_is_found() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("seatrial.db");
        drop(Logbook::open(&path).expect("made"));
        assert!(logbook(&path).is_good);
        // A log that holds nothing of this logbook: what stood in it is gone.
        std::fs::write(place.path().join("seatrial.db-wal"), "no log").expect("written");
        let found = logbook(&path);
        assert!(!found.is_good && found.found.contains("-wal"), "{found:?}");
    }
}

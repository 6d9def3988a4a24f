//! Identifies a log of any format: `cargo run -p seatrial-app --example identify_log -- run.csv`, or, without a log, one of
//! a simulated vehicle.

mod simulated_log;

use std::error::Error;
use std::path::{Path, PathBuf};

use seatrial_app::{IdentifiedLog, Options, identify_log};

fn main() {
    run(std::env::args_os().nth(1).map(PathBuf::from)).unwrap();
}

/// Identifies this log, or that of a simulated vehicle.
pub fn run(log: Option<PathBuf>) -> Result<IdentifiedLog, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let log = match log {
        Some(log) => log,
        None => {
            let log = folder.path().join("run.csv");
            simulated_log::write(&log)?;
            log
        }
    };
    identified(&log)
}

fn identified(log: &Path) -> Result<IdentifiedLog, Box<dyn Error>> {
    // Columns, units, windows and the estimator have defaults; set what the log does not tell.
    let found = identify_log(log, &Options::default())?;
    for speed in found.models.iter().flatten() {
        let Some(identification) = &speed.identification else {
            continue;
        };
        let model = identification.model();
        println!(
            "{} m/s: a22 {:.3} 1/s, b2 {:.3} 1/s^2, accepted: {}",
            speed.surge_speed_m_s.map_or("unknown".into(), |speed| format!("{speed:.2}")),
            model.a22_per_s,
            model.b2_per_s2,
            speed.verdict.accepted
        );
    }
    for reason in &found.verdict().reasons {
        println!("{}: {}", reason.kind(), reason.text);
    }
    // What `seatrial identify LOG --json` prints.
    println!("{}", serde_json::to_string_pretty(&found.document())?);
    Ok(found)
}

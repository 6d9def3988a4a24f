//! Writes lying logs and their truth to a folder: `cargo run -p seatrial-lab --example lying_logs -- FOLDER SEEDS`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use seatrial_lab::lies::KINDS;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().unwrap_or_else(|| "lying_logs".into()));
    let seeds: u64 = args.next().map_or(Ok(1), |seeds| seeds.parse())?;
    write(&folder, seeds)
}

/// Logs of every kind with the seeds from 1 on, and `truth.csv`.
pub fn write(folder: &Path, seeds: u64) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let mut truth = String::from(
        "kind,decidability,seed,a22_per_s,b2_per_s2,full_rudder_rad,from,to,validate_from,validate_to\n",
    );
    for kind in &KINDS {
        for seed in 1..=seeds {
            let log = kind.log(seed);
            fs::write(folder.join(format!("{}_{seed}.csv", kind.name)), &log.csv)?;
            let ([from, to], [validate_from, validate_to]) = (log.training_s, log.validation_s);
            truth += &format!(
                "{},{:?},{seed},{},{},{},{from},{to},{validate_from},{validate_to}\n",
                kind.name,
                kind.decidability,
                log.truth.a22_per_s,
                log.truth.b2_per_s2,
                log.truth.full_rudder_rad,
            );
        }
    }
    fs::write(folder.join("truth.csv"), truth)?;
    Ok(())
}

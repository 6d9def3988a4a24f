//! A command that reads the formats of this program and all built-in ones: `helm LOG` identifies one log, `helm LOG LOG ...` works through
//! many and writes a table.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use seatrial_app::{Options, fleet, identify_log};
use seatrial_extending::helm;

fn main() -> Result<(), Box<dyn Error>> {
    let logs: Vec<String> = std::env::args().skip(1).collect();
    match logs.as_slice() {
        [log] => identify(Path::new(log)),
        logs => work_through(logs, Path::new("table.parquet")),
    }
}

fn identify(log: &Path) -> Result<(), Box<dyn Error>> {
    let mut options = Options::default();
    options.reading.channels.formats = helm::formats();
    let found = identify_log(log, &options)?;
    println!("{}", found.verdict().outcome().name());
    for speed in found.models.iter().flatten() {
        if let Some(identification) = &speed.identification {
            let model = identification.model();
            println!(
                "a22 {:.3} 1/s, b2 {:.3} 1/s^2",
                model.a22_per_s, model.b2_per_s2
            );
        }
    }
    Ok(())
}

fn work_through(logs: &[String], table: &Path) -> Result<(), Box<dyn Error>> {
    let mut options = fleet::Options::default();
    options.channels.formats = helm::formats();
    let job = fleet::Job {
        sources: fleet::find(logs)?.sources,
        options,
        out: table.to_path_buf(),
        workers: 1,
        resume: false,
    };
    job.run(|_| ControlFlow::Continue(()))?;
    Ok(())
}

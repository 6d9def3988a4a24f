//! A command that reads the formats of this program and all built-in ones: `helm LOG` identifies a log.

use std::error::Error;
use std::path::Path;

use seatrial_app::{Options, identify_log};
use seatrial_extending::helm;

fn main() -> Result<(), Box<dyn Error>> {
    let log = std::env::args().nth(1).ok_or("usage: helm LOG")?;
    identify(Path::new(&log))
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

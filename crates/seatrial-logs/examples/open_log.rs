//! Prints what is found in a log: the columns that are read, their units, the warnings and the span of the samples.
//!
//! `cargo run -p seatrial-logs --example open_log -- FILE`

use std::error::Error;
use std::path::{Path, PathBuf};

use seatrial_core::RudderUnit;
use seatrial_logs::{ChannelChoice, open};

fn main() -> Result<(), Box<dyn Error>> {
    let log = std::env::args_os().nth(1).map(PathBuf::from);
    describe(&log.ok_or("expected the name of a log")?)
}

/// Opens a log, says how it is read, and reads it to its end.
pub fn describe(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut log = open(path, &ChannelChoice::default())?;
    let description = log.description();
    println!("format: {:?}", description.format);
    for channel in &description.channels {
        println!(
            "{} from {} [{}, {:?}]",
            channel.quantity, channel.column, channel.unit, channel.unit_source
        );
    }
    match description.rudder_unit {
        RudderUnit::Rad => println!("the rudder is an angle"),
        RudderUnit::FullRudder => {
            println!("the rudder is a fraction of full; its angle is not known")
        }
    }
    for warning in &description.warnings {
        println!("warning: {warning}");
    }

    let samples = log.by_ref().collect::<Result<Vec<_>, _>>()?;
    if let [first, .., last] = samples.as_slice() {
        println!("{} samples from {} s to {} s", samples.len(), first.time_s, last.time_s);
    }
    for warning in log.warnings() {
        println!("warning: {warning}");
    }
    Ok(())
}

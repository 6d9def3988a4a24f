//! Identifies a log of a format of one's own: `cargo run -p seatrial --example own_log_format`.
//!
//! What a reader has to give is samples in SI units: time, heading to starboard, and the rudder that acts from the sample's
//! time until the next one. `seatrial-logs` reads the usual formats.

use std::error::Error;
use std::fmt::Write as _;

use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial::{Identification, Record, Sample, Window};
use seatrial_core::YawModel;
use seatrial_core::model::YawState;

fn main() {
    let found = run().unwrap();
    println!("{:?}", found.model());
    for reason in &found.verdict.reasons {
        println!("{}: {}", reason.kind(), reason.text);
    }
}

/// Reads the log and identifies it.
pub fn run() -> Result<Identification, Box<dyn Error>> {
    let record = read(&a_log())?;
    let validation =
        ValidationData { record: &record, window: Window { from_s: 16.5, to_s: 33.0 } };
    let training = Window { from_s: 0.0, to_s: 16.5 };
    let settings = IdentifySettings::default();
    Ok(identify(&record, training, Some(validation), &settings)?)
}

/// A line of this format: `MILLISECONDS|HEADING|RUDDER`, the heading in tenths of a degree from 0 to 3599, the rudder in
/// hundredths of a degree, positive to port.
fn read(text: &str) -> Result<Record, Box<dyn Error>> {
    text.lines().map(sample).collect()
}

fn sample(line: &str) -> Result<Sample<f64>, Box<dyn Error>> {
    let fields: Vec<i32> = line.split('|').map(str::parse).collect::<Result<_, _>>()?;
    let [milliseconds, tenths, hundredths] = fields[..] else {
        return Err(format!("{line}: expected MILLISECONDS|HEADING|RUDDER").into());
    };
    Ok(Sample {
        time_s: f64::from(milliseconds) / 1000.0,
        heading_rad: (f64::from(tenths) / 10.0).to_radians(),
        // A rudder to starboard turns the vehicle to starboard, and is positive here.
        rudder_rad: -(f64::from(hundredths) / 100.0).to_radians(),
        ..Sample::default()
    })
}

/// Two doublets of a vehicle with a22 = -1.07/s and b2 = 1.08/s^2.
fn a_log() -> String {
    let vehicle = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut state = YawState::default();
    let mut text = String::new();
    for k in 0..660 {
        let hundredths = match k % 330 {
            40..80 => -1490,
            80..120 => 1490,
            _ => 0,
        };
        let degrees = f64::to_degrees(state.heading_rad).rem_euclid(360.0);
        let tenths = (10.0 * degrees).round() as i32 % 3600;
        writeln!(text, "{}|{tenths}|{hundredths}", 50 * k).expect("a string takes all");
        let rudder_rad = -(f64::from(hundredths) / 100.0).to_radians();
        state = vehicle.advance(state, rudder_rad, 0.05);
    }
    text
}

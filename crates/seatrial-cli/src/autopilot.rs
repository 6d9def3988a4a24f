//! The options of autopilots that speak MAVLink, and who attends a vehicle at a terminal.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::mpsc::channel;
use std::time::Duration;

use seatrial::FullRudder;
use seatrial_app::trials::order::VehicleError;
use seatrial_app::trials::vehicles::{Attendant, MavlinkOptions};
use seatrial_links::autopilot::{Profile, SteeringOutputs};
use seatrial_links::handover::{Change, Check};

use crate::interrupt::is_asked;
use crate::output::{Failure, say, say_laid_out};
use crate::screen::{labelled, width};
use crate::standard_error;

/// How an autopilot is reached.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "An autopilot behind MAVLink")]
pub struct LinkArgs {
    /// Our system id; the autopilot's MAV_GCS_SYSID must be the same.
    #[arg(long, value_name = "ID", default_value_t = 255)]
    system_id: u8,
    /// System id of the vehicle [default: the first autopilot that is heard].
    #[arg(long, value_name = "ID")]
    vehicle_id: Option<u8>,
    /// Kind of autopilot [default: as it says].
    #[arg(long, value_name = "KIND", value_parser = parse_profile)]
    profile: Option<Profile>,
    /// Rudder angle at full steering, degrees; assumed to be 35 where it is not given. Parameters that are exported for the
    /// autopilot do not depend on it; angles, b2 and gains in rad do.
    #[arg(long, value_name = "DEG")]
    full_rudder_deg: Option<f64>,
    /// Outputs that steer, as in 1 or 1,-2 where the second turns against the first [default: as the parameters say].
    #[arg(long, value_name = "OUTPUTS", value_delimiter = ',', allow_hyphen_values = true)]
    steering_outputs: Vec<i8>,
    /// Shortest, neutral and longest pulse of the steering outputs, us.
    #[arg(long, value_name = "US", value_delimiter = ',', default_values_t = [1100.0, 1500.0, 1900.0])]
    pulses_us: Vec<f64>,
    /// There is no remote control: a change of mode from a ground station takes the vehicle over.
    #[arg(long)]
    without_rc: bool,
    /// Lowest charge of the battery, percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 20)]
    lowest_battery: i8,
    /// Rudder per heading error while a heading is held.
    #[arg(long, value_name = "GAIN", default_value_t = 0.4)]
    heading_gain: f64,
    /// A key of 32 bytes or 64 hexadecimal digits: every frame is signed, and none without a signature is taken.
    #[arg(long, value_name = "FILE")]
    signing_key: Option<PathBuf>,
}

/// A kind of autopilot by its name.
pub fn parse_profile(text: &str) -> Result<Profile, String> {
    match text {
        "rover" => Ok(Profile::Rover),
        "sub" => Ok(Profile::Sub),
        "px4" => Ok(Profile::Px4),
        "generic" => Ok(Profile::Generic),
        _ => Err("expected rover, sub, px4 or generic".into()),
    }
}

impl LinkArgs {
    /// The rudder at full steering.
    pub fn full_rudder(&self) -> Result<FullRudder, Failure> {
        Ok(self.options()?.full_rudder())
    }

    /// What these options say of the autopilot.
    pub fn options(&self) -> Result<MavlinkOptions, Failure> {
        let full_rudder_deg =
            self.full_rudder_deg.map(|degrees| number("--full-rudder-deg", degrees, 90.0));
        Ok(MavlinkOptions {
            system_id: self.system_id,
            vehicle_id: self.vehicle_id,
            profile: self.profile,
            full_rudder_rad: full_rudder_deg.transpose()?.map(f64::to_radians),
            outputs: self.outputs()?,
            without_remote_control: self.without_rc,
            lowest_battery_percent: self.lowest_battery,
            heading_gain: number("--heading-gain", self.heading_gain, 10.0)?,
            signing_key: self.signing_key.clone(),
        })
    }

    fn outputs(&self) -> Result<Option<SteeringOutputs>, Failure> {
        if self.steering_outputs.is_empty() {
            return Ok(None);
        }
        let is_output = |output: &i8| (1..=16).contains(&output.unsigned_abs());
        if !self.steering_outputs.iter().all(is_output) {
            return Err(Failure::usage(
                "--steering-outputs: expected outputs from 1 to 16, negative where one turns the other way",
            ));
        }
        let pulses_us = match self.pulses_us[..] {
            [low, trim, high] if 0.0 < low && low < trim && trim < high => [low, trim, high],
            _ => {
                return Err(Failure::usage(
                    "--pulses-us: expected three rising numbers, as in 1100,1500,1900",
                ));
            }
        };
        Ok(Some(SteeringOutputs { outputs: self.steering_outputs.clone(), pulses_us }))
    }
}

/// The address of a vehicle behind MAVLink.
pub fn address(vehicle: &str) -> Result<&str, Failure> {
    vehicle.strip_prefix("mavlink:").ok_or_else(|| {
        Failure::usage(format!(
            "--vehicle {vehicle}: expected mavlink:udp:HOST:PORT, mavlink:udpout:HOST:PORT, mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD"
        ))
    })
}

/// A setting that must be positive and below a limit.
fn number(name: &str, value: f64, limit: f64) -> Result<f64, Failure> {
    if value > 0.0 && value < limit {
        return Ok(value);
    }
    Err(Failure::usage(format!("{name} {value}: expected a number above 0 and below {limit}")))
}

/// Between two looks whether the program is asked to end while the operator thinks.
const LOOK: Duration = Duration::from_millis(50);

/// The operator at the terminal.
pub struct AtTerminal;

impl Attendant for AtTerminal {
    fn tell(&self, text: &str) {
        say(text);
    }

    fn check(&self, check: &Check) {
        say_laid_out(&check_line(check.passed, &check.name, &check.text));
    }

    fn change(&self, change: &Change) {
        say_laid_out(&change_line(change));
    }

    fn agrees(&self) -> Result<bool, VehicleError> {
        agrees("Take this vehicle, change what is listed and move it? [y/N] ")
    }
}

/// Asks the operator at the terminal, until the program is asked to end.
pub fn agrees(question: &'static str) -> Result<bool, VehicleError> {
    if !std::io::stdin().is_terminal() {
        return Err(VehicleError::refused(
            "a vehicle that moves or changes must be agreed to: say --yes",
        ));
    }
    standard_error::write(move || {
        let _ = write!(std::io::stderr(), "{question}");
    });
    let (answer, answered) = channel();
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = std::io::stdin().read_line(&mut line);
        // Nobody waits any more where the program was asked to end.
        let _ = answer.send(read.map(|_| line));
    });
    loop {
        match answered.recv_timeout(LOOK) {
            Ok(read) => {
                let line = read.map_err(VehicleError::internal)?;
                return Ok(["y", "yes"].contains(&line.trim().to_lowercase().as_str()));
            }
            Err(_) if is_asked() => return Ok(false),
            Err(_) => {}
        }
    }
}

/// A check for people, by its parts.
pub fn check_line(is_passed: bool, name: &str, text: &str) -> String {
    let mark = if is_passed { "ok      " } else { "REFUSED " };
    labelled(&format!("{mark}{name:15} "), text, width()).trim_end().to_owned()
}

/// A change until the hand-back, for people.
pub fn change_line(change: &Change) -> String {
    let text = format!("{} -> {} until the hand-back: {}", change.from, change.to, change.why);
    labelled(&format!("change  {:15} ", change.name), &text, width()).trim_end().to_owned()
}

//! `seatrial sim serve --ardupilot-json`: the sea under an autopilot's own firmware.

use seatrial_app::trials::vehicles::ardupilot_json::{Options, Simulation, Traffic};
use seatrial_links::ardupilot_json::channel::Channel;
use serde::Serialize;

use crate::interrupt::interrupted;
use crate::output::{Exit, Failure, Output, say};

/// The physics side of ArduPilot's JSON simulation interface.
#[derive(clap::Args, Debug)]
#[group(id = "physics", conflicts_with = "autopilot")]
#[command(next_help_heading = "As the sea under ArduPilot's firmware")]
pub struct Args {
    /// Play the sea under an autopilot's own firmware.
    #[arg(long)]
    ardupilot_json: bool,
    /// Where to listen.
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.0.0.1:9002")]
    listen: String,
    /// Channel of the rudder, or several.
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',', default_value = "1")]
    rudder: Vec<Channel>,
    /// Channel of the throttle, or several; below the trim the propeller stands still.
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',', default_value = "3")]
    throttle: Vec<Channel>,
    /// Channel of the elevator, or several.
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    elevator: Vec<Channel>,
    /// Steps a second instead of ArduPilot's SIM_RATE_HZ.
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u16).range(1..))]
    rate: Option<u16>,
    /// End after so many frames.
    #[arg(long, value_name = "N")]
    frames: Option<u64>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    vehicle: &'a str,
    seed: u64,
    #[serde(flatten)]
    traffic: Traffic,
    time_s: f64,
}

/// Runs until it is interrupted.
pub fn run(vehicle: &str, seed: u64, args: &Args, output: &Output) -> Result<Exit, Failure> {
    let mut simulation = Simulation::new(Options {
        vehicle: vehicle.to_owned(),
        seed,
        listen: args.listen.clone(),
        rudder: args.rudder.clone(),
        throttle: args.throttle.clone(),
        elevator: args.elevator.clone(),
        rate_hz: args.rate,
        frames: args.frames,
    })?;
    let stop = interrupted().map_err(Failure::internal)?;
    simulation.serve(&stop, &mut |line| say(line))?;
    let document = Document {
        schema: "seatrial.ardupilot_json.v1",
        vehicle,
        seed,
        traffic: simulation.traffic(),
        time_s: simulation.time_s(),
    };
    output.print(&document, || simulation.to_string())?;
    Ok(Exit::Done)
}

//! `seatrial sim ardupilot-json`: the sea under an autopilot's own firmware.

use seatrial_app::vehicles::ardupilot_json::{Options, Simulation, Traffic};
use seatrial_links::ardupilot_json::channel::Channel;
use serde::Serialize;

use crate::interrupt::interrupted;
use crate::output::{Exit, Failure, Output, say};

/// The physics side of ArduPilot's JSON simulation interface.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Time goes on by one frame for every new frame of ArduPilot, however long that takes. A channel is written as \
NUMBER[:MIN:TRIM:MAX] in us; MIN above MAX reverses it. A pulse of 0 is the trim. Several, with commas between them, are \
thrusters that share it: it is their mean. Without --elevator, and where it has none, the vehicle holds its depth itself. Ends \
with Ctrl-C.

ArduPilot sends to port 9002 of the address after JSON:, here as a rover that steers with channel 1 and drives with 3:
  sim_vehicle.py -v Rover --model JSON:127.0.0.1
and as ArduSub's vectored frame, with the options
  --rudder 1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900
  --throttle 1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900

Example:
  seatrial sim ardupilot-json --vehicle sim:remus100 --rudder 4 --elevator 2 \\
      --throttle 3:1000:1000:2000 --frames 0")]
pub struct Args {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, value_name = "VEHICLE", default_value = "sim:starfish-6dof")]
    vehicle: String,
    /// Seed of disturbance and waves.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where to listen.
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.0.0.1:9002")]
    listen: String,
    /// Channel of the rudder, or several.
    #[arg(
        long,
        value_name = "CHANNELS",
        value_delimiter = ',',
        default_value = "1"
    )]
    rudder: Vec<Channel>,
    /// Channel of the throttle, or several; below the trim the propeller stands still.
    #[arg(
        long,
        value_name = "CHANNELS",
        value_delimiter = ',',
        default_value = "3"
    )]
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
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let mut simulation = Simulation::new(Options {
        vehicle: args.vehicle.clone(),
        seed: args.seed,
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
        vehicle: &args.vehicle,
        seed: args.seed,
        traffic: simulation.traffic(),
        time_s: simulation.time_s(),
    };
    output.print(&document, || simulation.to_string())?;
    Ok(Exit::Done)
}

//! `seatrial sim serve`: a simulated vehicle that speaks MAVLink.

use seatrial_app::trials::simulator;
use seatrial_app::trials::vehicles::signing;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use seatrial_links::autopilot::{Profile, Speaker, Station};
use seatrial_sim::SimulatedVehicle;
use serde::Serialize;

use crate::autopilot::parse_profile;
use crate::interrupt::interrupted;
use crate::output::{Exit, Failure, Output, say};

/// What the autopilot is and whom it talks to.
#[derive(clap::Args, Debug)]
#[group(id = "autopilot")]
#[command(next_help_heading = "As an autopilot over MAVLink")]
pub struct Args {
    /// Kind of autopilot: rover, sub or px4, whose rudder is output 1.
    #[arg(long, value_name = "KIND", default_value = "rover", value_parser = parse_profile)]
    profile: Profile,
    /// Send to a ground station that listens there.
    #[arg(
        long,
        value_name = "HOST:PORT",
        default_value = "127.0.0.1:14550",
        conflicts_with = "tcp"
    )]
    udp: String,
    /// Listen there for a ground station instead.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// How much faster than a real vehicle.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    speed: f64,
    /// Stop after this time of the vehicle, s.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Sign every frame with this key and take none without a signature.
    #[arg(long, value_name = "FILE")]
    signing_key: Option<PathBuf>,
}

#[derive(Serialize)]
struct Simulator {
    schema: &'static str,
    vehicle: String,
    steps: u64,
    seconds: f64,
}

/// Plays the vehicle until it is stopped.
pub fn run(vehicle: &str, seed: u64, args: &Args, output: &Output) -> Result<Exit, Failure> {
    if !(args.speed > 0.0 && args.speed <= 1000.0) {
        return Err(Failure::usage("--speed: expected a number above 0, at most 1000"));
    }
    if args.profile == Profile::Generic {
        return Err(Failure::usage("--profile: expected rover, sub or px4"));
    }
    let config = simulator::config(vehicle)?;
    let helm = config.helm();
    let interval_s = helm.timing.sample_interval_s;
    let simulated = simulator::vehicle(vehicle, seed)?;
    let signing = signing(args.signing_key.as_deref(), 1)?;
    let mut speaker =
        Speaker::new(simulated, args.profile, interval_s, helm.rudder_limit_rad, signing);
    speaker.speed = args.speed;
    let mut station = station(args)?;
    say(format!(
        "full rudder is {:.1} degrees; --full-rudder-deg of the trial must say so",
        helm.rudder_limit_rad.to_degrees()
    ));
    let steps = play(&mut speaker, &mut station, args, interval_s)?;
    let played = Simulator {
        schema: "seatrial.simulated_mavlink.v1",
        vehicle: vehicle.to_owned(),
        steps,
        seconds: steps as f64 * interval_s,
    };
    output.print(&played, || {
        format!("{}: {} steps, {:.0} s", played.vehicle, played.steps, played.seconds)
    })?;
    Ok(Exit::Done)
}

fn station(args: &Args) -> Result<Station, Failure> {
    let (place, station) = match &args.tcp {
        Some(place) => (place, Station::tcp(place)),
        None => (&args.udp, Station::udp(&args.udp)),
    };
    station.map_err(|error| Failure::input(format!("{place}: {error}")))
}

/// Steps the vehicle in its time until it is stopped; how many steps it made.
fn play(
    speaker: &mut Speaker<SimulatedVehicle>,
    station: &mut Station,
    args: &Args,
    interval_s: f64,
) -> Result<u64, Failure> {
    let stop = interrupted().map_err(Failure::internal)?;
    let start = Instant::now();
    let mut buffer = vec![0; 1 << 16];
    let mut steps = 0_u64;
    let seconds = |steps: u64| steps as f64 * interval_s;
    while !stop.load(Ordering::Relaxed) && args.seconds.is_none_or(|s| seconds(steps) < s) {
        let due = Duration::from_secs_f64(seconds(steps) / args.speed);
        // What has come is heard also by a vehicle that is late: it is not lost.
        loop {
            let left = due.saturating_sub(start.elapsed());
            let length = station.receive(&mut buffer, left);
            speaker.receive(&buffer[..length]);
            if left.is_zero() && length == 0 {
                break;
            }
        }
        let Ok(sent) = speaker.step();
        let Some(sent) = sent else {
            break;
        };
        station.send(&sent);
        steps += 1;
    }
    Ok(steps)
}

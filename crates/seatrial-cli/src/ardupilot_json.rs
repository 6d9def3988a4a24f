//! `seatrial sim ardupilot-json`: the sea under an autopilot's own firmware.

use seatrial_app::simulated;
use std::fmt;
use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use seatrial_links::ardupilot_json::channel::{Channel, mean_deflection};
use seatrial_links::ardupilot_json::{SensorFrame, ServoFrame};
use seatrial_sim::six_dof::commands::Commands;
use seatrial_sim::{Driven, SimulatedConfig};
use serde::Serialize;

use crate::output::{Exit, Failure, Output, say};

/// Time between status lines.
const STATUS_EVERY: Duration = Duration::from_secs(5);
/// Longest wait for a packet before the operator is listened to.
const WAIT: Duration = Duration::from_millis(100);
/// More than any packet of the interface.
const PACKET_BYTES: usize = 1024;

/// The physics side of ArduPilot's JSON simulation interface.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Time goes on by one frame for every new frame of ArduPilot, however long that takes. A channel is written as
NUMBER[:MIN:TRIM:MAX] in us; MIN above MAX reverses it. A pulse of 0 is the trim. Several, with commas between them, are
thrusters that share it: it is their mean. Without --elevator, and where it has none, the vehicle holds its depth itself. Ends
with Ctrl-C.

ArduPilot sends to port 9002 of the address after JSON:, here as a rover that steers with channel 1 and drives with 3:
  sim_vehicle.py -v Rover --model JSON:127.0.0.1
and as ArduSub's vectored frame, with the options
  --rudder 1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900
  --throttle 1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900

Example:
  seatrial sim ardupilot-json --vehicle sim:remus100 --rudder 4 --elevator 2 --throttle 3:1000:1000:2000 --frames 0")]
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

/// What was exchanged.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Traffic {
    frames: u64,
    repeated: u64,
    lost: u64,
    resets: u64,
    bad_packets: u64,
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

/// One vehicle and whoever drives it.
struct Simulation<'a> {
    args: &'a Args,
    start: Driven,
    vehicle: Driven,
    limits_rad: [f64; 2],
    last: Option<(ServoFrame, String)>,
    commands: Commands,
    traffic: Traffic,
}

/// Runs until it is interrupted.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let config = simulated::config(&args.vehicle)?;
    let start = Driven::new(&config, args.seed).map_err(Failure::input)?;
    let mut simulation = Simulation {
        args,
        vehicle: start.clone(),
        start,
        limits_rad: limits_rad(&config),
        last: None,
        commands: Commands::default(),
        traffic: Traffic::default(),
    };
    simulation.serve()?;
    let document = Document {
        schema: "seatrial.ardupilot_json.v1",
        vehicle: &args.vehicle,
        seed: args.seed,
        traffic: simulation.traffic,
        time_s: simulation.vehicle.kinematics().time_s,
    };
    output.print(&document, || simulation.to_string())?;
    Ok(Exit::Done)
}

/// The largest angles of rudder and elevator, rad.
fn limits_rad(config: &SimulatedConfig) -> [f64; 2] {
    match config {
        SimulatedConfig::FirstOrder(config) => [config.rudder_limit_rad, 0.0],
        SimulatedConfig::SixDof(config) => [config.rudder.limit_rad, config.elevator.limit_rad],
    }
}

impl Simulation<'_> {
    fn serve(&mut self) -> Result<(), Failure> {
        let place = &self.args.listen;
        let not_there = |error| Failure::input(format!("--listen {place}: {error}"));
        let socket = UdpSocket::bind(place).map_err(not_there)?;
        socket.set_read_timeout(Some(WAIT)).map_err(not_there)?;
        let address = socket.local_addr().map_err(not_there)?;
        say(format!("{} listens on {address}", self.args.vehicle));
        let stop = Arc::new(AtomicBool::new(false));
        let handler = Arc::clone(&stop);
        ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
            .map_err(Failure::internal)?;
        let mut packet = [0; PACKET_BYTES];
        let mut said = Instant::now();
        let is_over = |traffic: &Traffic| self.args.frames.is_some_and(|n| traffic.frames >= n);
        let mut traffic = self.traffic;
        while !stop.load(Ordering::Relaxed) && !is_over(&traffic) {
            // Nothing, or a peer that is gone: neither ends the sea.
            if let Ok((length, peer)) = socket.recv_from(&mut packet)
                && let Some(reply) = self.reply(&packet[..length])
                && let Err(error) = socket.send_to(reply.as_bytes(), peer)
            {
                say(format!("{peer}: {error}"));
            }
            traffic = self.traffic;
            if said.elapsed() >= STATUS_EVERY {
                said = Instant::now();
                say(&*self);
            }
        }
        Ok(())
    }

    /// What a packet is answered with; `None` where it is none of ArduPilot's.
    fn reply(&mut self, packet: &[u8]) -> Option<&str> {
        let frame = ServoFrame::parse(packet).ok();
        let commands = frame.as_ref().and_then(|frame| self.commands(frame));
        let (Some(frame), Some(commands)) = (frame, commands) else {
            self.traffic.bad_packets += 1;
            return None;
        };
        match self.last.as_ref().map(|(last, _)| last.count) {
            Some(last) if frame.count == last => self.traffic.repeated += 1,
            last => {
                if let Some(last) = last {
                    self.follow(last, frame.count);
                }
                self.commands = commands;
                let rate_hz = self.args.rate.unwrap_or(frame.rate_hz);
                self.vehicle.advance(&commands, 1.0 / f64::from(rate_hz));
                self.traffic.frames += 1;
                let line = self.line();
                self.last = Some((frame, line));
            }
        }
        self.last.as_ref().map(|(_, line)| line.as_str())
    }

    /// Counts frames that never came; a count that goes back is an autopilot that starts anew.
    fn follow(&mut self, last: u32, count: u32) {
        if count < last {
            self.vehicle = self.start.clone();
            self.traffic.resets += 1;
        } else {
            self.traffic.lost += u64::from(count - last - 1);
        }
    }

    fn commands(&self, frame: &ServoFrame) -> Option<Commands> {
        let [rudder_rad, elevator_rad] = self.limits_rad;
        Some(Commands {
            rudder_rad: rudder_rad * mean_deflection(&self.args.rudder, frame)?,
            elevator_rad: match self.args.elevator[..] {
                [] => None,
                ref channels => Some(elevator_rad * mean_deflection(channels, frame)?),
            },
            thrust: mean_deflection(&self.args.throttle, frame)?.max(0.0),
        })
    }

    fn line(&self) -> String {
        let motion = self.vehicle.kinematics();
        SensorFrame {
            time_s: motion.time_s,
            gyro_rad_s: motion.angular_velocity_rad_s,
            accelerometer_m_s2: motion.specific_force_m_s2,
            position_m: motion.position_m,
            attitude_rad: motion.attitude_rad,
            velocity_m_s: motion.velocity_m_s,
        }
        .line()
    }
}

impl fmt::Display for Simulation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let motion = self.vehicle.kinematics();
        let [north, east, depth] = motion.position_m;
        let [x, y, z] = motion.velocity_m_s;
        let Traffic {
            frames,
            repeated,
            lost,
            resets,
            bad_packets,
        } = self.traffic;
        write!(
            f,
            "{:.1} s: heading {:.0} deg, {:.2} m/s, depth {depth:.1} m, {north:.0} m north, {east:.0} m east; rudder {:.1} deg, \
             thrust {:.0} %; {frames} frames, {repeated} repeated, {lost} lost, {resets} resets, {bad_packets} bad packets",
            motion.time_s,
            motion.attitude_rad[2].to_degrees().rem_euclid(360.0),
            (x * x + y * y + z * z).sqrt(),
            self.commands.rudder_rad.to_degrees(),
            100.0 * self.commands.thrust,
        )
    }
}

//! `seatrial sim ardupilot-json`: the sea under an autopilot's own firmware.

use seatrial_app::simulated;
use std::fmt;
use std::net::UdpSocket;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use seatrial_links::ardupilot_json::{SensorFrame, ServoFrame};
use seatrial_sim::SimulatedConfig;
use seatrial_sim::six_dof::DrivenVehicle;
use seatrial_sim::six_dof::commands::Commands;
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
thrusters that share it: it is their mean. Without --elevator the vehicle holds its depth itself. Ends with Ctrl-C.

ArduPilot sends to port 9002 of the address after JSON:, here as a rover that steers with channel 1 and drives with 3:
  sim_vehicle.py -v Rover --model JSON:127.0.0.1
and as ArduSub's vectored frame, with the options
  --rudder 1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900
  --throttle 1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900

Example:
  seatrial sim ardupilot-json --vehicle sim:remus100 --rudder 4 --elevator 2 --throttle 3:1000:1000:2000 --frames 0")]
pub struct Args {
    /// The vehicle: sim:starfish-6dof, sim:remus100, or sim:FILE.toml of six degrees of freedom.
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

/// A servo channel and its pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Channel {
    number: usize,
    /// Least, middle and greatest deflection, us.
    pulses_us: [f64; 3],
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!("{text}: expected NUMBER or NUMBER:MIN:TRIM:MAX in us, as in 1:1100:1500:1900")
        };
        let numbers: Vec<u16> = text
            .split(':')
            .map(|part| part.parse().map_err(|_| expected()))
            .collect::<Result<_, _>>()?;
        let (number, pulses_us) = match numbers[..] {
            [number] => (number, [1000, 1500, 2000]),
            [number, min, trim, max] => (number, [min, trim, max]),
            _ => return Err(expected()),
        };
        if !(1..=32).contains(&number) {
            return Err(format!("{text}: channels are 1 to 32"));
        }
        let pulses_us = pulses_us.map(f64::from);
        let [min, trim, max] = pulses_us;
        let in_order = (min <= trim && trim < max) || (min >= trim && trim > max);
        if !in_order {
            return Err(format!("{text}: the trim has to lie between MIN and MAX"));
        }
        Ok(Self {
            number: usize::from(number),
            pulses_us,
        })
    }
}

impl Channel {
    /// The deflection of a frame, -1 to 1; `None` where the frame does not have the channel.
    fn deflection(&self, frame: &ServoFrame) -> Option<f64> {
        let [min, trim, max] = self.pulses_us;
        let pulse_us = match frame.pwm_us(self.number)? {
            0 => trim,
            pulse_us => f64::from(pulse_us),
        };
        let off = pulse_us - trim;
        let towards_max = off * (max - trim) >= 0.0;
        Some(match towards_max {
            true => (off / (max - trim)).min(1.0),
            false if min == trim => 0.0,
            false => (-off / (min - trim)).max(-1.0),
        })
    }
}

/// What thrusters do together, -1 to 1; `None` where the frame does not have one of them.
fn mean_deflection(channels: &[Channel], frame: &ServoFrame) -> Option<f64> {
    let deflections = channels.iter().map(|channel| channel.deflection(frame));
    let sum = deflections.sum::<Option<f64>>()?;
    Some(sum / channels.len() as f64)
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
    start: DrivenVehicle,
    vehicle: DrivenVehicle,
    limits_rad: [f64; 2],
    last: Option<(ServoFrame, String)>,
    commands: Commands,
    traffic: Traffic,
}

/// Runs until it is interrupted.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let SimulatedConfig::SixDof(config) = simulated::config(&args.vehicle)? else {
        return Err(Failure::usage(format!(
            "--vehicle {}: it only turns; take sim:starfish-6dof, sim:remus100 or a file with a table vehicle",
            args.vehicle
        )));
    };
    let start = DrivenVehicle::new(config.as_ref().clone(), args.seed).map_err(Failure::input)?;
    let mut simulation = Simulation {
        args,
        vehicle: start.clone(),
        start,
        limits_rad: [config.rudder.limit_rad, config.elevator.limit_rad],
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

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(pulse_us: u16) -> ServoFrame {
        let words = [18458_u16, 50, 0, 0].into_iter().chain([pulse_us; 16]);
        let packet: Vec<u8> = words.flat_map(u16::to_le_bytes).collect();
        ServoFrame::parse(&packet).unwrap()
    }

    #[test]
    fn exact_deflections_of_a_channel() {
        let of = |channel: &str, pulse_us| {
            let channel: Channel = channel.parse().unwrap();
            channel.deflection(&frame(pulse_us))
        };
        for (channel, pulse_us, expected) in [
            ("1", 1500, 0.0),
            ("1", 1750, 0.5),
            ("1", 800, -1.0),
            ("1", 0, 0.0),
            ("4:1100:1600:1900", 1750, 0.5),
            ("4:1100:1600:1900", 1350, -0.5),
            ("4:1900:1500:1100", 1900, -1.0),
            ("4:1900:1500:1100", 1300, 0.5),
            ("3:1000:1000:2000", 1250, 0.25),
            ("3:1000:1000:2000", 900, 0.0),
        ] {
            assert_eq!(
                of(channel, pulse_us),
                Some(expected),
                "{channel} {pulse_us}"
            );
        }
        assert_eq!(of("17", 1500), None);
    }

    /// ArduSub's horizontal thrusters at a yaw of 0.2 and a thrust of 0.3.
    #[test]
    fn exact_thrusters_that_share_rudder_and_throttle() {
        let mut words = [1500_u16; 20];
        words[..4].copy_from_slice(&[18458, 50, 0, 0]);
        words[4..8].copy_from_slice(&[1460, 1300, 1540, 1700]);
        let packet: Vec<u8> = words.into_iter().flat_map(u16::to_le_bytes).collect();
        let frame = ServoFrame::parse(&packet).unwrap();
        let shared = |text: &str| {
            let channels: Vec<Channel> = text.split(',').map(|c| c.parse().unwrap()).collect();
            mean_deflection(&channels, &frame).unwrap()
        };
        let yaw = shared("1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900");
        let forward = shared("1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900");
        // Few roundings.
        assert!((yaw - 0.2).abs() < 1e-12 && (forward - 0.3).abs() < 1e-12);
    }

    #[test]
    fn cli_channels_that_make_no_sense_are_refused() {
        for text in [
            "",
            "x",
            "0",
            "33",
            "1:1000",
            "1:1000:2100:2000",
            "1:1500:1500:1500",
        ] {
            assert!(text.parse::<Channel>().is_err(), "{text}");
        }
    }
}

//! The physics side of ArduPilot's JSON simulation interface: the sea under an autopilot's own firmware.

use std::fmt;
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use seatrial_links::ardupilot_json::channel::{Channel, mean_deflection};
use seatrial_links::ardupilot_json::{SensorFrame, ServoFrame};
use seatrial_sim::six_dof::commands::Commands;
use seatrial_sim::{Driven, SimulatedConfig};
use serde::Serialize;

use crate::trials::order::VehicleError;
use crate::trials::simulator;

/// Time between status lines.
const STATUS_EVERY: Duration = Duration::from_secs(5);
/// Longest wait for a packet before the operator is listened to.
const WAIT: Duration = Duration::from_millis(100);
/// More than any packet of the interface.
const PACKET_BYTES: usize = 1024;

/// Which vehicle, where, and which channels drive it.
#[derive(Clone, Debug)]
pub struct Options {
    /// The simulated vehicle by its name.
    pub vehicle: String,
    /// Seed of disturbance and waves.
    pub seed: u64,
    /// Where to listen, `ADDR:PORT`.
    pub listen: String,
    /// Channels of the rudder; several are thrusters that share it.
    pub rudder: Vec<Channel>,
    /// Channels of the throttle; below the trim the propeller stands still.
    pub throttle: Vec<Channel>,
    /// Channels of the elevator; none: the vehicle holds its depth itself.
    pub elevator: Vec<Channel>,
    /// Steps a second instead of ArduPilot's.
    pub rate_hz: Option<u16>,
    /// End after so many frames.
    pub frames: Option<u64>,
}

/// What was exchanged.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Traffic {
    /// Frames that moved the vehicle on.
    pub frames: u64,
    /// Frames that came again.
    pub repeated: u64,
    /// Frames that never came.
    pub lost: u64,
    /// Times that the autopilot started anew.
    pub resets: u64,
    /// Packets that were none of ArduPilot's.
    pub bad_packets: u64,
}

/// One vehicle and whoever drives it.
pub struct Simulation {
    options: Options,
    start: Driven,
    vehicle: Driven,
    limits_rad: [f64; 2],
    last: Option<(ServoFrame, String)>,
    commands: Commands,
    traffic: Traffic,
}

/// The largest angles of rudder and elevator, rad.
fn limits_rad(config: &SimulatedConfig) -> [f64; 2] {
    match config {
        SimulatedConfig::FirstOrder(config) => [config.rudder_limit_rad, 0.0],
        SimulatedConfig::SixDof(config) => [config.rudder.limit_rad, config.elevator.limit_rad],
    }
}

impl Simulation {
    /// The vehicle at rest.
    pub fn new(options: Options) -> Result<Self, VehicleError> {
        let config = simulator::config(&options.vehicle)?;
        let start = Driven::new(&config, options.seed).map_err(VehicleError::unreachable)?;
        Ok(Self {
            vehicle: start.clone(),
            start,
            limits_rad: limits_rad(&config),
            last: None,
            commands: Commands::default(),
            traffic: Traffic::default(),
            options,
        })
    }

    /// What was exchanged so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// The vehicle's time, s.
    pub fn time_s(&self) -> f64 {
        self.vehicle.kinematics().time_s
    }

    /// Answers ArduPilot until `stop` is set or so many frames as wanted have come. `tell` is told where it listens, then
    /// every five seconds how it goes.
    pub fn serve(
        &mut self,
        stop: &AtomicBool,
        tell: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), VehicleError> {
        let place = &self.options.listen;
        let not_there = |error| VehicleError::unreachable(format!("--listen {place}: {error}"));
        let socket = UdpSocket::bind(place).map_err(not_there)?;
        socket.set_read_timeout(Some(WAIT)).map_err(not_there)?;
        let address = socket.local_addr().map_err(not_there)?;
        tell(&format_args!("{} listens on {address}", self.options.vehicle));
        let mut packet = [0; PACKET_BYTES];
        let mut reported = Instant::now();
        let frames = self.options.frames.unwrap_or(u64::MAX);
        while !stop.load(Ordering::Relaxed) && self.traffic.frames < frames {
            // Nothing, or a peer that is gone: neither ends the sea.
            if let Ok((length, peer)) = socket.recv_from(&mut packet)
                && let Some(reply) = self.reply(&packet[..length])
                && let Err(error) = socket.send_to(reply.as_bytes(), peer)
            {
                tell(&format_args!("{peer}: {error}"));
            }
            if reported.elapsed() >= STATUS_EVERY {
                reported = Instant::now();
                tell(self);
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
                let rate_hz = self.options.rate_hz.unwrap_or(frame.rate_hz);
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
            rudder_rad: rudder_rad * mean_deflection(&self.options.rudder, frame)?,
            elevator_rad: match self.options.elevator[..] {
                [] => None,
                ref channels => Some(elevator_rad * mean_deflection(channels, frame)?),
            },
            thrust: mean_deflection(&self.options.throttle, frame)?.max(0.0),
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

impl fmt::Display for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let motion = self.vehicle.kinematics();
        let [north, east, depth] = motion.position_m;
        let [x, y, z] = motion.velocity_m_s;
        let Traffic { frames, repeated, lost, resets, bad_packets } = self.traffic;
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

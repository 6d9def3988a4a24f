//! A vehicle that speaks MAVLink as ArduPilot's Rover, ArduSub or PX4 do, for trying ground stations and this program without a vehicle.

mod defaults;
mod guided;
mod report;
mod station;

use std::collections::BTreeMap;

use seatrial_core::{Action, Steering, Vehicle};

use super::{Profile, REAL32};
use crate::link::message::{
    CommandAck, CommandLong, ManualControl, ParamValue, RcChannelsOverride, Statustext, Text,
    Timesync,
};
use crate::link::{Decoder, Encoder, Message, Sender, Signing};
use defaults::{HALF_US, STICKS, TRIM_US, parameters, resting_mode};
use guided::Guided;
pub use station::Station;

/// A vehicle that speaks MAVLink: an autopilot like ArduPilot's Rover, ArduSub or PX4 around a [`Vehicle`], in the vehicle's
/// own time.
///
/// In its manual mode, steering and throttle follow RC_CHANNELS_OVERRIDE (Rover) or MANUAL_CONTROL of the ground station
/// whose system id is MAV_GCS_SYSID (PX4: of any), and are neutral RC_OVERRIDE_TIME (PX4: COM_RC_LOSS_T) after the last of
/// them. In GUIDED, Rover steers to the heading of SET_ATTITUDE_TARGET for 3 s by its own parameters; in ALT_HOLD, ArduSub does so for
/// 5 s, MANUAL_CONTROL giving the thrust. In any other mode, and without a target, the vehicle holds its heading. ArduSub without a remote control keeps the last of them until FS_PILOT_TIMEOUT,
/// and does then what FS_PILOT_INPUT says.
pub struct Speaker<V> {
    vehicle: V,
    profile: Profile,
    full_rudder_rad: f64,
    interval_s: f64,
    signing: Option<Signing>,
    encoder: Encoder,
    decoder: Decoder,
    out: Vec<u8>,
    parameters: BTreeMap<String, f32>,
    steps: u64,
    clock_s: f64,
    overridden: Option<(f64, [u16; 8])>,
    /// Steering and thrust of a joystick, as fractions of full, and when.
    joystick: Option<(f64, [f64; 2])>,
    station_s: Option<f64>,
    looks_for_station_s: f64,
    station_lost_s: Option<f64>,
    held_heading_rad: f64,
    heading_rad: f64,
    guided: Guided,
    failsafe: bool,
    /// Its mode, `custom_mode` of its heartbeats.
    pub mode: u32,
    /// Is it armed?
    pub is_armed: bool,
    /// The remote control's sticks, us.
    pub sticks_us: [u16; STICKS],
    /// Does it hear one?
    pub has_remote_control: bool,
    /// Charge of its battery, percent.
    pub battery_percent: i8,
    /// How much faster than a real vehicle it is played: its ground station's heartbeats come no faster, and are waited for so much longer.
    pub speed: f64,
}

impl<V: Vehicle<f64>> Speaker<V> {
    /// A vehicle of this kind whose samples are `interval_s` apart.
    pub fn new(
        vehicle: V,
        profile: Profile,
        interval_s: f64,
        full_rudder_rad: f64,
        signing: Option<Signing>,
    ) -> Self {
        let parameters = parameters(profile, interval_s);
        Self {
            vehicle,
            profile,
            full_rudder_rad,
            interval_s,
            signing,
            encoder: Encoder::new(Sender { system: 1, component: 1 }),
            decoder: Decoder::default(),
            out: Vec::new(),
            parameters,
            steps: 0,
            clock_s: 0.0,
            overridden: None,
            joystick: None,
            station_s: None,
            looks_for_station_s: 0.0,
            station_lost_s: None,
            held_heading_rad: f64::NAN,
            heading_rad: f64::NAN,
            guided: Guided::default(),
            failsafe: false,
            mode: resting_mode(profile),
            is_armed: true,
            sticks_us: [TRIM_US as u16; STICKS],
            has_remote_control: true,
            battery_percent: 90,
            speed: 1.0,
        }
    }

    /// One of its parameters.
    pub fn parameter(&self, name: &str) -> Option<f32> {
        self.parameters.get(name).copied()
    }

    /// All of them.
    pub fn parameters(&self) -> impl Iterator<Item = (String, f32)> + '_ {
        self.parameters.iter().map(|(name, value)| (name.clone(), *value))
    }

    /// As its owner sets it.
    pub fn set_parameter(&mut self, name: &str, value: f32) {
        self.parameters.insert(name.into(), value);
    }

    /// Steering that it asks its rudder for, as a fraction of full.
    pub fn steering(&self) -> f64 {
        self.guided.asked.map_or_else(|| self.fraction(0), |[steering, _]| steering)
    }

    /// Thrust that it asks its propeller for, as a fraction of full.
    pub fn thrust(&self) -> f64 {
        self.guided.asked.map_or_else(|| self.fraction(2), |[_, thrust]| thrust)
    }

    /// Its heading, rad.
    pub fn heading_rad(&self) -> f64 {
        self.heading_rad
    }

    /// Is a failsafe on?
    pub fn is_critical(&self) -> bool {
        self.failsafe
    }

    /// Does it steer as it is asked to?
    pub fn is_steered(&self) -> bool {
        let is_direct = self.profile.steering_mode() == Some(self.mode);
        self.is_armed && (is_direct || self.guided.asked.is_some())
    }

    /// Takes in what was sent to it; what it answers comes with the next step.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next(self.signing.as_mut(), self.clock_s) {
            if let Some(message) = frame.message() {
                self.hear(frame.sender, &message);
            }
        }
    }

    /// One sample on: everything that it sends. `None`: the vehicle has no more.
    pub fn step(&mut self) -> Result<Option<Vec<u8>>, V::Error> {
        let Some(sample) = self.vehicle.next_sample()? else {
            return Ok(None);
        };
        self.clock_s = sample.time_s;
        self.watch_station();
        self.watch_pilot();
        self.report(&sample);
        self.steps += 1;
        self.heading_rad = sample.heading_rad;
        if !self.held_heading_rad.is_finite() {
            self.held_heading_rad = sample.heading_rad;
        }
        self.guide(&sample);
        let is_steered = self.is_steered();
        // ArduSub comes back to the heading on which it was put into its mode.
        let is_led = self.profile == Profile::Sub && self.guided.asked.is_some();
        let steering = if is_steered {
            if !is_led {
                self.held_heading_rad = sample.heading_rad;
            }
            Steering::Rudder(self.steering() * self.full_rudder_rad)
        } else {
            Steering::HoldHeading(self.held_heading_rad)
        };
        let thrust = self.thrust();
        self.vehicle.act(&Action {
            steering,
            thrust: (is_steered && thrust > 0.0).then_some(thrust),
            outcome: None,
        })?;
        Ok(Some(std::mem::take(&mut self.out)))
    }

    fn send(&mut self, message: impl Into<Message>) {
        let frame = self.encoder.encode(&message.into(), self.signing.as_mut(), self.clock_s);
        self.out.extend(frame);
    }

    fn number(&self, name: &str) -> f64 {
        self.parameters.get(name).copied().unwrap_or(0.0).into()
    }

    /// The pulse of an input: the remote control's, or a recent override of it.
    fn input_us(&self, channel: usize) -> u16 {
        let valid_s = self.number("RC_OVERRIDE_TIME");
        match self.overridden {
            Some((given_s, pulses)) if self.clock_s - given_s <= valid_s => {
                match pulses.get(channel) {
                    None | Some(0 | &u16::MAX) => self.sticks_us[channel],
                    Some(pulse) => *pulse,
                }
            }
            _ => self.sticks_us[channel],
        }
    }

    /// What is asked for on a channel, 0 steering or 2 thrust, as a fraction of full.
    fn fraction(&self, channel: usize) -> f64 {
        if self.profile == Profile::Rover {
            return self.stick(channel);
        }
        let valid_s = match self.profile {
            Profile::Px4 => self.number("COM_RC_LOSS_T"),
            Profile::Sub if !self.has_remote_control => self.number("FS_PILOT_TIMEOUT"),
            _ => self.number("RC_OVERRIDE_TIME"),
        };
        match self.joystick {
            Some((given_s, asked)) if self.clock_s - given_s <= valid_s => asked[channel / 2],
            _ => 0.0,
        }
    }

    /// A stick as a fraction of full, out of its dead zone, in steps of the pulse that carries it to the output.
    fn stick(&self, channel: usize) -> f64 {
        let dead_us = self.number(if channel == 0 { "RC1_DZ" } else { "RC3_DZ" });
        let off_us = f64::from(self.input_us(channel)) - TRIM_US;
        let beyond_us = (off_us.abs() - dead_us).max(0.0);
        let fraction = (beyond_us / (HALF_US - dead_us)).min(1.0) * off_us.signum();
        (fraction * HALF_US).round() / HALF_US
    }

    fn hear(&mut self, sender: Sender, message: &Message) {
        let is_obeyed =
            self.parameter("MAV_GCS_SYSID").is_none_or(|system| f32::from(sender.system) == system);
        match *message {
            Message::Heartbeat(_) if is_obeyed => self.station_s = Some(self.clock_s),
            Message::RcChannelsOverride(RcChannelsOverride { pulses, .. }) if is_obeyed => {
                self.overridden = Some((self.clock_s, pulses));
                if self.profile == Profile::Sub && pulses[3] == 0 {
                    self.joystick = None;
                }
                // An override is a sign of life too.
                self.station_s = Some(self.clock_s);
            }
            Message::ManualControl(control) if is_obeyed => self.take_joystick(control),
            // No sign of life: Rover goes by heartbeats and sticks.
            Message::SetAttitudeTarget(target) if is_obeyed => self.take_target(&target),
            Message::ParamRequestRead(request) => {
                let name = request.name.text();
                if self.parameters.contains_key(&name) {
                    self.tell(&name);
                }
            }
            Message::ParamRequestList(_) => {
                let names: Vec<String> = self.parameters.keys().cloned().collect();
                names.iter().for_each(|name| self.tell(name));
            }
            Message::ParamSet(set) => {
                let name = set.name.text();
                if let Some(value) = self.parameters.get_mut(&name) {
                    *value = set.value;
                    self.tell(&name);
                }
            }
            Message::CommandLong(command) => self.take_command(&command),
            Message::Timesync(question) if question.there_ns == 0 => {
                let there_ns = (self.clock_s * 1e9) as i64 + 1;
                self.send(Timesync { there_ns, here_ns: question.here_ns });
            }
            _ => {}
        }
    }

    fn take_joystick(&mut self, ManualControl { x, y, z, r, .. }: ManualControl) {
        let full = |axis: i16| f64::from(axis) / 1000.0;
        let asked = match self.profile {
            Profile::Px4 => [full(y), 2.0 * full(z) - 1.0],
            _ => [full(r), full(x)],
        };
        self.joystick = Some((self.clock_s, asked));
        if self.profile == Profile::Sub {
            let pulse = |axis: i16| (TRIM_US + HALF_US * full(axis)).round() as u16;
            let mut pulses = [TRIM_US as u16; 8];
            (pulses[3], pulses[4]) = (pulse(r), pulse(x));
            self.overridden = Some((self.clock_s, pulses));
        }
        self.station_s = Some(self.clock_s);
    }

    fn take_command(&mut self, command: &CommandLong) {
        if command.command == 176 {
            let (main, sub) = (command.param2 as u32, command.param3 as u32);
            self.mode = match self.profile {
                Profile::Px4 => main << 16 | sub << 24,
                _ => main,
            };
            self.held_heading_rad = f64::NAN;
            self.failsafe = false;
            self.beat();
        }
        self.send(CommandAck { command: command.command, result: 0 });
    }

    fn tell(&mut self, name: &str) {
        let index = self.parameters.keys().position(|key| key == name).unwrap_or(0);
        self.send(ParamValue {
            value: self.parameters.get(name).copied().unwrap_or(0.0),
            count: self.parameters.len() as u16,
            index: index as u16,
            name: Text::from(name),
            kind: REAL32,
        });
    }

    /// Like ArduPilot's Rover: ten times a second while that is enabled; once it is not, what was lost last stays lost.
    fn watch_station(&mut self) {
        if self.number("FS_GCS_ENABLE") != 0.0 && self.clock_s >= self.looks_for_station_s {
            self.looks_for_station_s = self.clock_s + 0.1;
            let longest_s = self.number("FS_GCS_TIMEOUT") * self.speed;
            let is_lost = self.station_s.is_some_and(|heard_s| self.clock_s - heard_s > longest_s);
            self.station_lost_s = is_lost.then(|| self.station_lost_s.unwrap_or(self.clock_s));
            self.failsafe &= is_lost;
        }
        let is_due = self
            .station_lost_s
            .is_some_and(|lost_s| self.clock_s - lost_s > self.number("FS_TIMEOUT"));
        if is_due && !self.failsafe {
            (self.failsafe, self.mode) = (true, resting_mode(self.profile));
            self.send(Statustext { severity: 2, text: Text::from("GCS Failsafe") });
            self.beat();
        }
    }

    /// Like ArduSub, whose remote control counts as a pilot.
    fn watch_pilot(&mut self) {
        let given_s = self.joystick.map_or(0.0, |(given_s, _)| given_s);
        let is_lost = self.clock_s - given_s > self.number("FS_PILOT_TIMEOUT");
        let action = self.number("FS_PILOT_INPUT");
        if self.profile == Profile::Sub && !self.has_remote_control && is_lost && action != 0.0 {
            self.failsafe = true;
            self.is_armed &= action != 2.0;
        }
    }
}

//! Autopilots that speak MAVLink, as a [`Vehicle`].
//!
//! Everything passes through a [`Wire`], which also gives the time: a link to the world, or a made-up vehicle in made-up
//! time. [`Autopilot::inspect`] looks without touching, [`Autopilot::take_control`] takes the rudder and proves that it
//! answers, [`Autopilot::hand_back`] undoes it all; so does dropping it. Whatever ends the trial from the vehicle's side, a
//! [`Stop`], releases the controls as soon as the message that tells it is read.

mod hand_back;
mod heard;
mod preflight;
mod profile;
mod sampler;
mod speaker;
mod stop;
mod taking;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};

use crate::ardupilot::Parameters;
use crate::link::message::{self, CommandLong, ParamRequestRead, ParamSet, Text};
use crate::link::{Damage, Decoder, Encoder, Message, Sender, Signing, Wire};
pub use hand_back::{Backup, HandBack, Stored};
pub use preflight::{Change, Check, Preflight};
pub use profile::{Profile, SteeringOutputs};
pub use speaker::Speaker;
pub use stop::Stop;

use heard::Heard;
use profile::{Demand, Rudder};
use sampler::Sampler;

/// Between our heartbeats, s.
const HEARTBEAT_S: f64 = 1.0;
/// A demand is repeated after this time without a sample, s.
const REPEAT_S: f64 = 0.1;
/// Silence that ends the trial, s.
const SILENCE_S: f64 = 0.7;
/// Longest wait for bytes at a time, s.
const WAIT_S: f64 = 0.02;
/// Between two questions that are not answered, s.
const ASK_AGAIN_S: f64 = 0.3;
/// An output this near to what was asked for follows, as a fraction of full.
const FOLLOWS: f64 = 0.15;
/// Demands so old may still be on their way, s.
const ON_THE_WAY_S: f64 = 1.5;
/// A rudder that does not follow for so long ends the trial, s.
const NOT_FOLLOWED_S: f64 = 1.0;

/// How a vehicle is reached and what is asked of it.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Our system id; autopilots obey one only.
    pub system_id: u8,
    /// The vehicle's system id [first that is heard].
    pub vehicle: Option<u8>,
    /// The kind of autopilot [as it says].
    pub profile: Option<Profile>,
    /// Rudder at full steering, rad.
    pub full_rudder_rad: f64,
    /// Outputs that steer [as its parameters say].
    pub outputs: Option<SteeringOutputs>,
    /// Time between samples, s.
    pub sample_interval_s: f64,
    /// Smallest charge of the battery, percent.
    pub lowest_battery_percent: i8,
    /// The pilot has no remote control: only a change of mode takes the vehicle over.
    pub without_remote_control: bool,
    /// Rudder per heading error while a heading is held.
    pub heading_gain: f64,
    /// Rudder per yaw rate while a heading is held, s.
    pub yaw_rate_gain_s: f64,
    /// Largest rudder while a heading is held, rad.
    pub heading_rudder_rad: f64,
    /// Thrust while the rudder's sense is tried, as a fraction of full.
    pub trying_thrust: f64,
    /// b2 is expected to be negative.
    pub is_reversed: bool,
    /// Limits that the trial has been given, for the preflight; `None` refuses it.
    pub envelope: Option<String>,
    /// Becomes true when the operator wants the vehicle back.
    pub abort: Arc<AtomicBool>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            system_id: 255,
            vehicle: None,
            profile: None,
            full_rudder_rad: 35_f64.to_radians(),
            outputs: None,
            sample_interval_s: 0.05,
            lowest_battery_percent: 20,
            without_remote_control: false,
            heading_gain: 0.4,
            yaw_rate_gain_s: 0.4,
            heading_rudder_rad: 0.2,
            trying_thrust: 0.5,
            is_reversed: false,
            envelope: None,
            abort: Arc::default(),
        }
    }
}

/// An autopilot behind a wire.
pub struct Autopilot<W: Wire> {
    wire: W,
    settings: Settings,
    signing: Option<Signing>,
    decoder: Decoder,
    encoder: Encoder,
    received: Vec<u8>,
    heard: Heard,
    parameters: Parameters,
    /// MAV_PARAM_TYPE of each.
    kinds: BTreeMap<String, u8>,
    sampler: Sampler,
    rudder: Option<Rudder>,
    /// Outputs act this much earlier than they say, s.
    earlier_s: f64,
    /// What is asked for while the controls are ours.
    demand: Option<Demand>,
    demanded_s: f64,
    /// When what was asked for, lately.
    demands: VecDeque<(f64, f64)>,
    followed_s: f64,
    beat_s: f64,
    /// Are the vehicle's doings a reason to give it back?
    on_guard: bool,
    stopped: Option<Stop>,
    last: Option<Sample<f64>>,
    backup: Option<Backup>,
}

impl<W: Wire> Autopilot<W> {
    /// Behind this wire.
    pub fn new(wire: W, settings: Settings, signing: Option<Signing>) -> Self {
        let sender = Sender {
            system: settings.system_id,
            // MAV_COMP_ID_MISSIONPLANNER, as ground stations have.
            component: 190,
        };
        Self {
            wire,
            signing,
            decoder: Decoder::default(),
            encoder: Encoder::new(sender),
            received: Vec::new(),
            heard: Heard::default(),
            parameters: Parameters::default(),
            kinds: BTreeMap::new(),
            sampler: Sampler::default(),
            rudder: None,
            earlier_s: 0.0,
            demand: None,
            demanded_s: f64::NEG_INFINITY,
            demands: VecDeque::new(),
            followed_s: 0.0,
            beat_s: f64::NEG_INFINITY,
            on_guard: false,
            stopped: None,
            last: None,
            backup: None,
            settings,
        }
    }

    /// Why the vehicle was given back, if its doings were the reason.
    pub fn stopped(&self) -> Option<&Stop> {
        self.stopped.as_ref()
    }

    /// What came that was no good.
    pub fn damage(&self) -> Damage {
        self.decoder.damage()
    }

    /// The wire.
    pub fn wire(&mut self) -> &mut W {
        &mut self.wire
    }

    fn profile(&self) -> Profile {
        self.settings.profile.unwrap_or_else(|| {
            let heartbeat = self.heard.heartbeat.as_ref();
            heartbeat.map_or(Profile::Generic, Profile::of)
        })
    }

    fn system(&self) -> u8 {
        self.heard.vehicle.map_or(0, |vehicle| vehicle.system)
    }

    fn component(&self) -> u8 {
        self.heard.vehicle.map_or(0, |vehicle| vehicle.component)
    }

    fn send(&mut self, message: impl Into<Message>) {
        let now_s = self.wire.now_s();
        let signing = self.signing.as_mut();
        let frame = self.encoder.encode(&message.into(), signing, now_s);
        self.wire.send(&frame);
    }

    /// Sends what is due, waits for bytes until then at most, and hears what has come.
    fn pump(&mut self, until_s: f64) {
        let now_s = self.wire.now_s();
        if now_s - self.beat_s >= HEARTBEAT_S {
            self.beat_s = now_s;
            self.send(message::Heartbeat {
                custom_mode: 0,
                // A ground station, without an autopilot.
                kind: 6,
                autopilot: 8,
                base_mode: 0,
                system_status: 4,
                mavlink_version: 3,
            });
            self.send(message::Timesync {
                there_ns: 0,
                here_ns: (now_s * 1e9) as i64,
            });
        }
        if self.settings.abort.load(Ordering::Relaxed) {
            self.stop_on_guard(Stop::Operator);
        }
        if now_s - self.demanded_s >= REPEAT_S {
            self.send_demand();
        }
        self.wire.receive(&mut self.received, until_s);
        self.decoder.push(&self.received);
        self.received.clear();
        let now_s = self.wire.now_s();
        while let Some(frame) = self.decoder.next(self.signing.as_mut(), now_s) {
            if let Some(message) = frame.message() {
                self.hear(frame.sender, &message, now_s);
            }
        }
    }

    fn hear(&mut self, sender: Sender, message: &Message, now_s: f64) {
        if sender.system == self.settings.system_id {
            if matches!(message, Message::Heartbeat(_)) {
                self.heard.has_double = true;
                self.stop_on_guard(Stop::SecondStation(sender.system));
            }
            return;
        }
        if !self
            .heard
            .is_vehicle(sender, message, self.settings.vehicle)
        {
            return;
        }
        self.wire.is_vehicle();
        self.heard.take(message, now_s);
        match *message {
            Message::ParamValue(parameter) => {
                let is_integer = parameter.kind != REAL32 && self.profile() == Profile::Px4;
                let value = if is_integer {
                    f64::from(parameter.value.to_bits() as i32)
                } else {
                    f64::from(parameter.value)
                };
                let name = parameter.name.text();
                if self.kinds.len() < MOST_PARAMETERS {
                    self.kinds.insert(name.clone(), parameter.kind);
                }
                self.parameters.insert(name, value);
            }
            Message::Attitude(attitude) => {
                if self.sampler.is_restarted(attitude.time_boot_ms) {
                    self.stop_on_guard(Stop::Rebooted);
                    self.sampler = Sampler::default();
                }
                self.sampler.attitude(attitude);
            }
            Message::ServoOutputRaw(servo) if servo.port == 0 => self.hear_servo(&servo, now_s),
            Message::VfrHud(hud) => self.sampler.ground_speed(hud.ground_speed_m_s.into()),
            Message::GlobalPositionInt(position) => {
                let velocity = [position.north_cm_s, position.east_cm_s];
                let velocity = velocity.map(|speed| f64::from(speed) / 100.0);
                self.sampler.velocity(position.time_boot_ms, velocity);
            }
            Message::LocalPositionNed(local) => {
                let place = [local.north_m.into(), local.east_m.into()];
                self.sampler.position(local.time_boot_ms, place);
                if !self.profile().is_boat() {
                    let depth_m = local.down_m.into();
                    self.sampler.depth(local.time_boot_ms, depth_m);
                }
            }
            _ => {}
        }
        if self.on_guard
            && let Some(stop) = self.heard.danger(self.profile(), &self.settings)
        {
            self.stop_on_guard(stop);
        }
    }

    fn hear_servo(&mut self, servo: &message::ServoOutputRaw, now_s: f64) {
        let Some(rudder) = &self.rudder else {
            return;
        };
        let pulse = |number: usize| match number {
            1..=8 => f64::from(servo.pulses[number - 1]),
            9..=16 => f64::from(servo.more_pulses[number - 9]),
            _ => f64::NAN,
        };
        let found = rudder.fraction(pulse);
        let rudder_rad = found * self.settings.full_rudder_rad;
        self.sampler
            .rudder(servo.time_us, self.earlier_s, rudder_rad);
        let follows = self
            .demands
            .iter()
            .any(|(_, asked)| (asked - found).abs() < FOLLOWS);
        if follows || self.demand.is_none() {
            self.followed_s = now_s;
        } else if now_s - self.followed_s > NOT_FOLLOWED_S {
            let asked = self.demand.map_or(0.0, |demand| demand.steer);
            self.stop_on_guard(Stop::NotFollowed { asked, found });
        }
    }

    fn stop_on_guard(&mut self, stop: Stop) {
        if self.on_guard && self.stopped.is_none() {
            self.stopped = Some(stop);
            self.let_go();
        }
    }

    fn ask(&mut self, demand: Demand) {
        self.demand = Some(demand);
        self.sampler.thrust = Some(demand.thrust);
        self.send_demand();
    }

    fn send_demand(&mut self) {
        let Some(demand) = self.demand else {
            return;
        };
        let now_s = self.wire.now_s();
        self.demanded_s = now_s;
        self.demands.push_back((now_s, demand.steer));
        while self
            .demands
            .front()
            .is_some_and(|(asked_s, _)| now_s - asked_s > ON_THE_WAY_S)
        {
            self.demands.pop_front();
        }
        let message = self
            .profile()
            .demand(demand, &self.parameters, self.system());
        self.send(message);
    }

    /// Pumps until `done` or for this long on our clock. `true`: done.
    fn wait(&mut self, longest_s: f64, mut done: impl FnMut(&mut Self) -> bool) -> bool {
        let end_s = self.wire.now_s() + longest_s;
        loop {
            if done(self) {
                return true;
            }
            let now_s = self.wire.now_s();
            if now_s >= end_s {
                return false;
            }
            self.pump((now_s + WAIT_S).min(end_s));
        }
    }

    /// Asks with `question` until `done` or for this long.
    fn insist(
        &mut self,
        longest_s: f64,
        mut question: impl FnMut(&mut Self),
        mut done: impl FnMut(&mut Self) -> bool,
    ) -> bool {
        let mut asked_s = f64::NEG_INFINITY;
        self.wait(longest_s, |autopilot| {
            if done(autopilot) {
                return true;
            }
            let now_s = autopilot.wire.now_s();
            if now_s - asked_s >= ASK_AGAIN_S {
                asked_s = now_s;
                question(autopilot);
            }
            false
        })
    }

    fn ask_parameter(&mut self, name: &str) {
        let (target_system, target_component) = (self.system(), self.component());
        self.send(ParamRequestRead {
            index: -1,
            target_system,
            target_component,
            name: Text::from(name),
        });
    }

    /// Sets a parameter and reads it back. `true`: it is so.
    fn set_parameter(&mut self, name: &str, stored: Stored, longest_s: f64) -> bool {
        let wanted = stored.number();
        self.parameters.insert(name.into(), f64::NAN);
        self.insist(
            longest_s,
            |autopilot| {
                let (target_system, target_component) = (autopilot.system(), autopilot.component());
                autopilot.send(ParamSet {
                    value: stored.value(),
                    target_system,
                    target_component,
                    name: Text::from(name),
                    kind: stored.kind,
                });
            },
            |autopilot| autopilot.parameters.get(name) == Some(wanted),
        )
    }

    fn command(&mut self, command: u16, [param1, param2, param3]: [f32; 3]) {
        let (target_system, target_component) = (self.system(), self.component());
        self.send(CommandLong {
            param1,
            param2,
            param3,
            param4: 0.0,
            param5: 0.0,
            param6: 0.0,
            param7: 0.0,
            command,
            target_system,
            target_component,
            confirmation: 0,
        });
    }

    /// Sets a mode and waits until a heartbeat has it. `true`: it is so.
    fn set_mode(&mut self, mode: u32, longest_s: f64) -> bool {
        // A heartbeat from before may still be on its way, so it is the next one that counts.
        self.insist(
            longest_s,
            |autopilot| {
                let [main, sub] = match autopilot.profile() {
                    Profile::Px4 => [(mode >> 16) & 0xff, mode >> 24],
                    _ => [mode, 0],
                };
                // MAV_CMD_DO_SET_MODE, with a mode of the autopilot's own.
                autopilot.command(176, [1.0, main as f32, sub as f32]);
            },
            |autopilot| autopilot.heard.mode() == Some(mode),
        )
    }

    /// MAV_CMD_SET_MESSAGE_INTERVAL: 0 is the autopilot's default.
    fn set_interval(&mut self, id: u32, interval_s: f64) {
        self.command(511, [id as f32, (interval_s * 1e6) as f32, 0.0]);
    }

    /// Our own heading hold, for a vehicle whose rudder we have: delta = -(K (psi - psi_d) + D r), within its limit.
    fn holding_rudder_rad(&self, heading_rad: f64) -> f64 {
        let Some(sample) = &self.last else {
            return 0.0;
        };
        let settings = &self.settings;
        let error_rad = Real::wrapped(sample.heading_rad - heading_rad);
        let rate_rad_s = sample.yaw_rate_rad_s.unwrap_or(0.0);
        let sense = if settings.is_reversed { -1.0 } else { 1.0 };
        let rudder_rad =
            -sense * (settings.heading_gain * error_rad + settings.yaw_rate_gain_s * rate_rad_s);
        let limit_rad = settings.heading_rudder_rad;
        if rudder_rad.is_finite() {
            rudder_rad.clamp(-limit_rad, limit_rad)
        } else {
            0.0
        }
    }
}

/// The most parameters that are kept.
const MOST_PARAMETERS: usize = 8192;
/// MAV_PARAM_TYPE_REAL32.
const REAL32: u8 = 9;

impl<W: Wire> Vehicle<f64> for Autopilot<W> {
    type Error = Stop;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Stop> {
        let mut heard_s = self.wire.now_s();
        let mut count = self.sampler.count;
        loop {
            if let Some(stop) = self.stopped.clone().filter(|stop| !stop.is_pilot()) {
                return Err(stop);
            }
            if let Some(sample) = self.sampler.take() {
                self.last = Some(sample);
                return Ok(Some(sample));
            }
            let now_s = self.wire.now_s();
            if count != self.sampler.count {
                (heard_s, count) = (now_s, self.sampler.count);
            }
            if now_s - heard_s > SILENCE_S {
                self.stop_on_guard(Stop::Silence(now_s - heard_s));
                return Err(Stop::Silence(now_s - heard_s));
            }
            self.pump(now_s + WAIT_S);
        }
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Stop> {
        if self.stopped.is_some() || self.demand.is_none() {
            return Ok(());
        }
        let rudder_rad = match action.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            Steering::HoldHeading(heading_rad) => self.holding_rudder_rad(heading_rad),
        };
        self.ask(Demand {
            steer: rudder_rad / self.settings.full_rudder_rad,
            thrust: action.thrust.unwrap_or(0.0),
        });
        if action.outcome.is_some() {
            self.let_go();
        }
        Ok(())
    }

    fn is_taken_over(&self) -> bool {
        self.stopped.as_ref().is_some_and(Stop::is_pilot)
    }
}

impl<W: Wire> Drop for Autopilot<W> {
    fn drop(&mut self) {
        if self.backup.is_some() || self.demand.is_some() {
            self.hand_back();
        }
    }
}

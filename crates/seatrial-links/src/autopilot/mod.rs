//! Autopilots that speak MAVLink, as a [`Vehicle`](seatrial_core::Vehicle).
//!
//! Everything passes through a [`Wire`], which also gives the time: a link to the world, or a made-up vehicle in made-up
//! time. [`Autopilot::inspect`] looks without touching, [`Autopilot::take_control`] takes the rudder and proves that it
//! answers, [`Autopilot::hand_back`] undoes it all; so does dropping it. [`AutopilotThread`] keeps the link alive while nobody waits. Whatever ends the trial from the vehicle's side, a
//! [`Stop`], releases the controls as soon as the message that tells it is read.

mod autopilot_thread;
pub mod cascade;
mod controls;
mod hand_back;
mod heading;
mod health;
mod heard;
mod overrides;
mod parameters;
mod preflight;
mod profile;
mod rates;
mod response;
mod sampler;
mod speaker;
mod steering;
mod stop;
mod taking;
mod talk;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial_mavlink::ardupilot::Parameters;

use crate::handover::Following;
use crate::link::{Damage, Decoder, Encoder, Sender, Signing, Wire};
pub use autopilot_thread::AutopilotThread;
pub use hand_back::{Backup, HandBack, ParameterValue, PutBack};
pub use heading::{Ahead, HeadingControl};
pub use profile::{Profile, SteeringOutputs};
pub use response::Response;
pub use speaker::{Speaker, Station};
pub use stop::Stop;

use heading::Course;
use heard::Heard;
use profile::{Demand, Rudder};
use sampler::Sampler;

/// A demand is repeated after this time without a sample, s.
const REPEAT_S: f64 = 0.1;
/// MAV_CMD_DO_SET_MODE, with a mode of the autopilot's own.
const SET_MODE: u16 = 176;
/// MAV_PARAM_TYPE_REAL32.
const REAL32: u8 = 9;

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
    /// That angle is not known.
    pub is_full_rudder_assumed: bool,
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
    /// The most steering and thrust that are asked for together, fractions of full added up.
    pub most_asked: f64,
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
            is_full_rudder_assumed: true,
            outputs: None,
            sample_interval_s: 0.05,
            lowest_battery_percent: 20,
            without_remote_control: false,
            heading_gain: 0.4,
            yaw_rate_gain_s: 0.4,
            heading_rudder_rad: 0.2,
            trying_thrust: 0.5,
            most_asked: 1.5,
            is_reversed: false,
            envelope: None,
            abort: Arc::default(),
        }
    }
}

impl Settings {
    /// The angle at full steering, for people.
    fn full_rudder_text(&self) -> String {
        let degrees = self.full_rudder_rad.to_degrees();
        match self.is_full_rudder_assumed {
            true => format!(
                "full steering is ASSUMED to be {degrees:.1} degrees of rudder; measure it and give --full-rudder-deg DEG: an error of this angle makes rudder angles, b2 and gains in rad wrong by the same share, parameters for the autopilot stay right"
            ),
            false => format!("full steering is {degrees:.1} degrees of rudder, as given"),
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
    /// Output of a full stick, as a fraction of the outputs' full.
    stick_gain: f64,
    /// Outputs act this much earlier than they say, s.
    earlier_s: f64,
    /// White noise of the yaw rate, rad/s, where it has been looked at.
    rate_noise_rad_s: Option<f64>,
    /// What is asked for while the controls are ours.
    demand: Option<Demand>,
    /// What is asked for while the autopilot steers to our headings.
    course: Option<Course>,
    demanded_s: f64,
    /// The heading that is held with it, rad.
    held_heading_rad: Option<f64>,
    /// When the trial last took a sample or asked for something.
    attended_s: f64,
    following: Following,
    beat_s: f64,
    /// The vehicle's clock at a heartbeat, s.
    beat_clock_s: f64,
    /// A failsafe acts soon after the last heartbeat.
    beats_quickly: bool,
    /// When bytes were last looked for, and since when without a break.
    pumped_s: f64,
    resumed_s: f64,
    /// When an attitude last came.
    heard_s: f64,
    response: Response,
    /// Does what the vehicle does end the trial?
    on_guard: bool,
    stopped: Option<Stop>,
    /// Do we keep silent to prove what becomes of the rudder then?
    is_proving: bool,
    backup: Option<Backup>,
    /// What the hand-back has reached that was not the trial's.
    handed_back: Option<HandBack>,
}

impl<W: Wire> Autopilot<W> {
    /// Behind this wire.
    pub fn new(wire: W, settings: Settings, signing: Option<Signing>) -> Self {
        let heard_s = wire.now_s();
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
            stick_gain: 1.0,
            earlier_s: 0.0,
            rate_noise_rad_s: None,
            demand: None,
            course: None,
            demanded_s: f64::NEG_INFINITY,
            held_heading_rad: None,
            attended_s: 0.0,
            following: Following::default(),
            beat_s: f64::NEG_INFINITY,
            beat_clock_s: f64::NEG_INFINITY,
            beats_quickly: false,
            pumped_s: f64::NEG_INFINITY,
            resumed_s: 0.0,
            heard_s,
            response: Response::default(),
            on_guard: false,
            stopped: None,
            is_proving: false,
            backup: None,
            handed_back: None,
            settings,
        }
    }

    /// Rudder at full steering, rad.
    pub fn full_rudder_rad(&self) -> f64 {
        self.settings.full_rudder_rad
    }

    /// Why the vehicle was given back before the end of the trial, if it was.
    pub fn stopped(&self) -> Option<&Stop> {
        self.stopped.as_ref()
    }

    /// What came that was no good.
    pub fn damage(&self) -> Damage {
        self.decoder.damage()
    }

    /// How long commands took.
    pub fn response(&self) -> &Response {
        &self.response
    }

    /// The wire.
    pub fn wire(&mut self) -> &mut W {
        &mut self.wire
    }

    /// What the autopilot says that it runs, by its kind.
    pub fn firmware(&self) -> String {
        self.profile().name().to_owned()
    }

    fn profile(&self) -> Profile {
        let chosen = self.settings.profile.or(self.heard.profile);
        chosen.unwrap_or(Profile::Generic)
    }

    fn system(&self) -> u8 {
        self.heard.vehicle.map_or(0, |vehicle| vehicle.system)
    }

    fn component(&self) -> u8 {
        self.heard.vehicle.map_or(0, |vehicle| vehicle.component)
    }
}

impl<W: Wire> Drop for Autopilot<W> {
    fn drop(&mut self) {
        if self.backup.is_some() || self.demand.is_some() || self.course.is_some() {
            self.hand_back();
        }
    }
}

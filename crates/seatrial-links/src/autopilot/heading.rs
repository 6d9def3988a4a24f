//! The autopilot's own heading controller: asked for a heading and a speed, its gains changed and read back.
//!
//! Rover does it in GUIDED by SET_ATTITUDE_TARGET, which it forgets 3 s after the last one. Its ground station failsafe is set to hold
//! the vehicle sooner.
//!
//! ArduSub does it in ALT_HOLD by SET_ATTITUDE_TARGET without thrust (`ModeAlthold::run_pre`, `GCS_MAVLINK_Sub::handle_message`),
//! which it forgets after 5 s; the thrust ahead is MANUAL_CONTROL's, which it forgets by RC_OVERRIDE_TIME or FS_PILOT_TIMEOUT. Any
//! other mode forgets the heading at once.

use std::io;

use seatrial_core::CascadeSettings;

use super::cascade;
use super::hand_back::Backup;
use super::profile::Demand;
use super::{Autopilot, ParameterValue, Profile};
use crate::handover::{Change, Check, Controls, Preflight};
use crate::link::Wire;
use crate::link::message::SetAttitudeTarget;

/// Roll, pitch and yaw rates are not given; attitude and thrust are.
pub(super) const RATES_IGNORED: u8 = 0b111;
/// Thrust is not given.
pub(super) const THRUST_IGNORED: u8 = 0b100_0000;
/// Longest wait for parameters that tell how the heading is controlled, s.
const PARAMETERS_S: f64 = 6.0;
/// Longest wait for one that not every firmware has, s.
const OPTIONAL_S: f64 = 1.5;
/// Longest wait for one change, s.
const CHANGE_S: f64 = 6.0;
/// The autopilot's ground station failsafe acts this long after our last heartbeat, s.
const STATION_S: f64 = 0.3;
/// Interval at which the autopilot looks for heartbeats, s; it acts one look after it has missed them.
const LOOK_S: f64 = 0.1;
/// FS_ACTION that holds the vehicle.
const HOLD: f64 = 2.0;
/// A vehicle that was heard so long ago is asked for nothing again, s.
const HEARD_S: f64 = 0.1;
/// Without FS_GCS_TIMEOUT it is the last heading that Rover forgets, after this long, s.
const LONGEST_TIMEOUT_S: f64 = 3.0;
/// The frequency of the autopilot's loop where it does not say, Hz: Rover's and Sub's as they come.
const LOOP_RATE_HZ: f64 = 50.0;
const SUB_LOOP_RATE_HZ: f64 = 400.0;
/// MOT_SPD_SCA_BASE where a firmware has none, m/s.
const SCALING_SPEED_M_S: f64 = 1.0;
/// The autopilot forgets a stick after this long, s: a vehicle that nobody steers must not go on ahead.
const STICK_S: f64 = 0.4;

/// ArduSub's parameters that the loop foreseen knows nothing of: the feed-forward of the rate is on, the others are off.
const FEED_FORWARD: &str = "ATC_RATE_FF_ENAB";
const SUB_LIMITS: [&str; 4] =
    [FEED_FORWARD, "ATC_RAT_YAW_SMAX", "ATC_RAT_YAW_PDMX", "ATC_RAT_YAW_NEF"];

/// Why an autopilot of this kind is not commissioned, and what to do.
fn no_headings(profile: Profile) -> String {
    let why = match profile {
        Profile::Px4 => {
            "PX4's rover takes headings from a program on board over DDS, not over MAVLink, and its submarine has not been tried"
        }
        _ => "no message is known that asks it for a heading",
    };
    let export = match profile {
        Profile::Px4 => "seatrial gains --export px4 --out gains.params",
        _ => "seatrial gains",
    };
    format!(
        "{why}: `{export}` writes what its model gives, to be loaded with a ground station and tried by hand"
    )
}

/// A heading that is asked of the autopilot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    heading_rad: f64,
    /// Speed as a fraction of the autopilot's default, or thrust as a fraction of full.
    drive: f64,
}

/// How the autopilot controls its heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadingControl {
    /// Its gains, filters and limits.
    pub settings: CascadeSettings<f64>,
    /// Between two of its loops, s.
    pub loop_interval_s: f64,
    /// How it goes ahead meanwhile.
    pub ahead: Ahead,
    /// White noise of its yaw rate before it is taken, rad/s; `None`: too little came.
    pub rate_noise_rad_s: Option<f64>,
}

/// How an autopilot that steers to headings goes ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ahead {
    /// At a speed that it keeps.
    Speed {
        /// Its default speed, m/s; `None`: it says none.
        default_m_s: Option<f64>,
        /// Above this speed it divides its steering by the speed over this one, m/s; 0: never.
        scaling_m_s: f64,
    },
    /// By a stick of ours, whose full is this share of the thrusters'. They steer, too.
    Stick {
        /// The share.
        gain: f64,
    },
}

impl HeadingControl {
    /// The settings at a speed. The outputs reach full only after the speed has scaled the steering down.
    pub fn settings_at(&self, surge_speed_m_s: Option<f64>) -> CascadeSettings<f64> {
        let steering_limit = match self.ahead {
            Ahead::Speed { .. } => 1.0 / self.output_scale(surge_speed_m_s),
            Ahead::Stick { .. } => 1.0,
        };
        CascadeSettings { steering_limit, ..self.settings }
    }

    /// Its default speed, m/s, where it keeps one and says so.
    pub fn default_speed_m_s(&self) -> Option<f64> {
        match self.ahead {
            Ahead::Speed { default_m_s, .. } => default_m_s,
            Ahead::Stick { .. } => None,
        }
    }

    /// White noise of its yaw rate, rad/s, where that of a still vehicle tells it: no engine and no wave shakes a submarine.
    pub fn rate_noise_under_way_rad_s(&self) -> Option<f64> {
        match self.ahead {
            Ahead::Speed { .. } => None,
            Ahead::Stick { .. } => self.rate_noise_rad_s,
        }
    }

    /// What the outputs make of its steering at a speed, in fractions of full stick.
    pub fn output_scale(&self, surge_speed_m_s: Option<f64>) -> f64 {
        match (self.ahead, surge_speed_m_s) {
            (Ahead::Speed { scaling_m_s, .. }, Some(speed))
                if speed > scaling_m_s && scaling_m_s > 0.0 =>
            {
                scaling_m_s / speed
            }
            (Ahead::Speed { .. }, _) => 1.0,
            (Ahead::Stick { gain }, _) => 1.0 / gain,
        }
    }

    /// The share of its steering that a thrust, a fraction of full stick, takes.
    pub fn steering_taken(&self, thrust: Option<f64>) -> f64 {
        match self.ahead {
            Ahead::Speed { .. } => 0.0,
            Ahead::Stick { gain } => gain * thrust.unwrap_or(0.0),
        }
    }

    /// What [`Autopilot::steer_to`] is asked for to go at the speed, m/s, or by the thrust, a fraction of full stick, of a model.
    pub fn drive(&self, surge_speed_m_s: Option<f64>, thrust: Option<f64>) -> f64 {
        match self.ahead {
            Ahead::Speed { default_m_s, .. } => {
                surge_speed_m_s.zip(default_m_s).map_or(1.0, |(speed, default)| speed / default)
            }
            Ahead::Stick { .. } => thrust.unwrap_or(0.0),
        }
    }
}

impl<W: Wire> Autopilot<W> {
    /// Looks at the vehicle as before a trial, and at how it controls its heading.
    pub fn inspect_heading(&mut self) -> (Preflight, Option<HeadingControl>) {
        let mut found = self.inspect();
        if !found.checks.iter().any(|check| check.name == "parameters") {
            return (found, None);
        }
        if self.profile().heading_mode().is_none() {
            found.check("heading mode", false, no_headings(self.profile()));
            return (found, None);
        }
        let control = self.heading_control();
        match &control {
            Ok(_) => found.check("steering gains", true, "read"),
            Err(name) => found.check("steering gains", false, format!("no answer for {name}")),
        }
        match self.profile() {
            Profile::Sub => self.check_sticks(&mut found),
            _ => self.check_timeout(&mut found),
        }
        (found, control.ok())
    }

    fn heading_control(&mut self) -> Result<HeadingControl, &'static str> {
        let profile = self.profile();
        let needed: Vec<&str> = cascade::needed_names(profile).collect();
        self.read_named(&needed, PARAMETERS_S);
        let more: &[&str] = match profile {
            Profile::Sub => &SUB_LIMITS,
            _ => &["CRUISE_SPEED", "WP_SPEED", "MOT_SPD_SCA_BASE", "FS_GCS_TIMEOUT", "FS_TIMEOUT"],
        };
        let all: Vec<&str> = cascade::names(profile).chain(more.iter().copied()).collect();
        self.read_named(&all, OPTIONAL_S);
        let parameters = &self.parameters;
        let settings = cascade::settings(profile, |name| parameters.get(name))?;
        let positive = |name: &str| parameters.get(name).filter(|value| *value > 0.0);
        let (loop_rate_hz, ahead) = match profile {
            Profile::Sub => (SUB_LOOP_RATE_HZ, Ahead::Stick { gain: self.stick_gain }),
            _ => (
                LOOP_RATE_HZ,
                Ahead::Speed {
                    default_m_s: positive("WP_SPEED").or(positive("CRUISE_SPEED")),
                    scaling_m_s: parameters.get("MOT_SPD_SCA_BASE").unwrap_or(SCALING_SPEED_M_S),
                },
            ),
        };
        Ok(HeadingControl {
            settings,
            loop_interval_s: 1.0 / positive("SCHED_LOOP_RATE").unwrap_or(loop_rate_hz),
            ahead,
            rate_noise_rad_s: self.rate_noise_rad_s,
        })
    }

    /// ArduSub: the thrust ahead ends soon after the last stick, and its loop is the one that is foreseen.
    fn check_sticks(&mut self, found: &mut Preflight) {
        let mut names = vec!["RC_OVERRIDE_TIME"];
        names.extend((!self.heard.has_sticks()).then_some("FS_PILOT_TIMEOUT"));
        for name in names {
            let why = "without us the thrust ahead ends after this long";
            let Some(change) = self.change(name, STICK_S, why) else {
                continue;
            };
            found.changes.retain(|change| change.name != name);
            if !(change.from > 0.0 && change.from <= STICK_S) {
                found.changes.push(change);
            }
        }
        let other = SUB_LIMITS.iter().find_map(|name| {
            let value = self.parameters.get(name)?;
            let expected = f64::from(*name == FEED_FORWARD);
            (value != expected).then(|| {
                format!("{name} is {value}: set it to {expected}, gains are foreseen for that")
            })
        });
        let text = format!(
            "without us the autopilot goes no further ahead after {STICK_S} s; it keeps our last heading for 5 s, then the one on which it was taken"
        );
        found.check("heading mode", other.is_none(), other.unwrap_or(text));
    }

    fn check_timeout(&mut self, found: &mut Preflight) {
        let mut change = |name: &str, to: f64, is_so: fn(f64, f64) -> bool, why: &'static str| {
            let change = self.change(name, to, why)?;
            let is_changed = found.changes.iter().any(|change| change.name == name);
            if !is_changed && !is_so(change.from, to) {
                found.changes.push(change);
            }
            Some(())
        };
        let soon = "the autopilot holds the vehicle this long after our last heartbeat";
        let stops_s = match change("FS_GCS_TIMEOUT", STATION_S, |from, to| from <= to, soon) {
            Some(()) => STATION_S + 2.0 * LOOK_S,
            None => LONGEST_TIMEOUT_S,
        };
        change("FS_TIMEOUT", 0.0, |from, to| from <= to, "and waits no longer");
        let holds = "a failsafe holds the vehicle";
        change("FS_ACTION", HOLD, |from, to| from == to, holds);
        let text = format!("without us the autopilot holds the vehicle after {stops_s} s");
        found.check("heading mode", true, text);
    }

    /// Takes the vehicle in the mode in which it steers to headings by itself. Its gains are part of the backup, which `keep`
    /// puts where it survives this program before anything is changed. Unless every check passes the vehicle must be
    /// handed back.
    pub fn take_heading(
        &mut self,
        changes: &[Change],
        keep: &mut dyn FnMut(&Backup) -> io::Result<()>,
    ) -> Vec<Check> {
        let mut found = Preflight::default();
        let changed = changes.iter().map(|change| change.name.clone());
        let gains = cascade::names(self.profile()).map(String::from);
        let names = changed.chain(gains);
        if !self.back_up(self.heard.mode(), names, keep, &mut found) {
            return found.checks;
        }
        self.heard.is_guided = true;
        self.beats_quickly = true;
        if !self.make_changes(changes, &mut found) {
            return found.checks;
        }
        self.enter_guided(&mut found);
        found.checks
    }

    fn enter_guided(&mut self, found: &mut Preflight) {
        let Some(mode) = self.profile().heading_mode() else {
            found.check("mode", false, "no mode steers to headings");
            return;
        };
        let is_set = self.set_mode(mode, CHANGE_S);
        let name = self.profile().mode_text(mode);
        let text = match is_set {
            true => format!("{name}, in which the autopilot steers to the heading that we ask for"),
            false => {
                format!("it does not go into mode {name}, in which it would steer to headings")
            }
        };
        found.check("mode", is_set, text);
        if let Some((heading_rad, _)) = self.sampler.newest_heading().filter(|_| is_set) {
            self.heard.our_mode = Some(mode);
            self.note_sticks();
            if self.heard.is_critical() {
                // The failsafe of a submarine that nobody steers ends with that.
                self.steer_to(heading_rad, 0.0);
                self.wait(CHANGE_S, |autopilot| !autopilot.heard.is_critical());
            }
            self.guard();
            self.steer_to(heading_rad, 0.0);
        }
        if let Some(stop) = self.stopped.as_ref() {
            found.check("vehicle", false, stop.to_string());
        }
        self.sampler.skip();
    }

    /// Asks for a heading and a drive of [`HeadingControl::drive`] until something else is asked for.
    pub fn steer_to(&mut self, heading_rad: f64, drive: f64) {
        if self.stopped.is_some() || !self.heard.is_guided {
            return;
        }
        self.attended_s = self.wire.now_s();
        self.course = Some(Course { heading_rad, drive });
        self.send_course();
    }

    /// The course again, while the vehicle is heard: one that is not must stop soon.
    pub(super) fn repeat_course(&mut self) {
        if self.wire.now_s() - self.heard_s <= HEARD_S {
            self.send_course();
        }
    }

    fn send_course(&mut self) {
        let Some(Course { heading_rad, drive }) = self.course else {
            return;
        };
        self.demanded_s = self.wire.now_s();
        let (profile, system) = (self.profile(), self.system());
        if profile == Profile::Sub {
            self.send_heading(heading_rad, None);
            let ahead = Demand { steer: 0.0, thrust: drive };
            self.send(profile.demand(ahead, &self.parameters, system));
        } else {
            self.send_heading(heading_rad, Some(drive));
        }
    }

    /// ArduSub, which remembers the last heading for a while, is given the one that it has.
    pub(super) fn hold_here(&mut self) {
        if let Some((heading_rad, _)) = self.sampler.newest_heading()
            && self.profile() == Profile::Sub
        {
            self.send_heading(heading_rad, None);
        }
    }

    fn send_heading(&mut self, heading_rad: f64, thrust: Option<f64>) {
        let half = 0.5 * heading_rad;
        let (target_system, target_component) = (self.system(), self.component());
        self.send(SetAttitudeTarget {
            time_boot_ms: (1e3 * self.wire.now_s()) as u64 as u32,
            quaternion: [half.cos() as f32, 0.0, 0.0, half.sin() as f32],
            roll_rate_rad_s: 0.0,
            pitch_rate_rad_s: 0.0,
            yaw_rate_rad_s: 0.0,
            thrust: thrust.unwrap_or(0.0).clamp(0.0, 1.0) as f32,
            target_system,
            target_component,
            type_mask: match thrust {
                Some(_) => RATES_IGNORED,
                None => RATES_IGNORED | THRUST_IGNORED,
            },
        });
    }

    /// Writes a parameter of the backup and reads it back. `true`: it is so.
    pub fn write_parameter(&mut self, name: &str, value: f64) -> bool {
        let before = self.backup.as_ref().and_then(|b| b.parameters.get(name));
        let Some(stored) = before.copied() else {
            return false;
        };
        let stored = ParameterValue { number: value, ..stored };
        self.set_parameter(name, stored, CHANGE_S)
    }

    /// The gains as they were when the vehicle was taken.
    pub fn gains_before(&self) -> Backup {
        let parameters = self.backup.iter().flat_map(|backup| {
            let gains =
                cascade::all_names().filter_map(|name| backup.parameters.get_key_value(name));
            gains.map(|(name, stored)| (name.clone(), *stored))
        });
        Backup { system: self.system(), mode: None, parameters: parameters.collect() }
    }

    /// The gains stay as they are when the vehicle is handed back. What is still put back then; `None` where something has ended
    /// the commission.
    pub fn keep_gains(&mut self) -> Option<Backup> {
        let backup = self.backup.as_mut().filter(|_| self.stopped.is_none())?;
        for name in cascade::all_names() {
            backup.parameters.remove(name);
        }
        Some(backup.clone())
    }
}

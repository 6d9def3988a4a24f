//! The autopilot's own heading controller: asked for a heading and a speed, its gains changed and read back.
//!
//! Rover does it in GUIDED by SET_ATTITUDE_TARGET, which it forgets 3 s after the last one. Its ground station failsafe is set to hold
//! the vehicle sooner.

use std::io;

use seatrial_core::CascadeSettings;

use super::cascade;
use super::hand_back::Backup;
use super::{Autopilot, Profile, Stored};
use crate::handover::{Change, Check, Controls, Preflight};
use crate::link::Wire;
use crate::link::message::SetAttitudeTarget;

/// Roll, pitch and yaw rates are not given; attitude and thrust are.
const RATES_IGNORED: u8 = 0b111;
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
/// The frequency of the autopilot's loop where it does not say, Hz: Rover's as it comes.
const LOOP_RATE_HZ: f64 = 50.0;
/// MOT_SPD_SCA_BASE where a firmware has none, m/s.
const SCALING_SPEED_M_S: f64 = 1.0;

/// A heading that is asked of the autopilot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    heading_rad: f64,
    /// Speed as a fraction of the autopilot's default.
    speed: f64,
}

/// How the autopilot controls its heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadingControl {
    /// Its gains, filters and limits.
    pub settings: CascadeSettings<f64>,
    /// Between two of its loops, s.
    pub loop_interval_s: f64,
    /// Its default speed, m/s; `None`: it says none.
    pub default_speed_m_s: Option<f64>,
    /// Above this speed it divides its steering by the speed over this one, m/s; 0: never.
    pub scaling_speed_m_s: f64,
}

impl HeadingControl {
    /// The settings at a speed. The outputs reach full only after the speed has scaled the steering down.
    pub fn settings_at(&self, surge_speed_m_s: Option<f64>) -> CascadeSettings<f64> {
        CascadeSettings {
            steering_limit: 1.0 / self.output_scale(surge_speed_m_s),
            ..self.settings
        }
    }

    /// What the outputs make of its steering at a speed.
    pub fn output_scale(&self, surge_speed_m_s: Option<f64>) -> f64 {
        match surge_speed_m_s {
            Some(speed) if speed > self.scaling_speed_m_s && self.scaling_speed_m_s > 0.0 => {
                self.scaling_speed_m_s / speed
            }
            _ => 1.0,
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
        if self.profile() != Profile::Rover {
            let text = format!(
                "{} cannot be asked for a heading from outside by seatrial; ArduPilot's Rover can",
                self.profile().name()
            );
            found.check("heading mode", false, text);
            return (found, None);
        }
        // Overrides are not used.
        found
            .changes
            .retain(|change| change.name != "RC_OVERRIDE_TIME");
        let control = self.heading_control();
        match &control {
            Ok(_) => found.check("steering gains", true, "read"),
            Err(name) => found.check("steering gains", false, format!("no answer for {name}")),
        }
        self.check_timeout(&mut found);
        (found, control.ok())
    }

    fn heading_control(&mut self) -> Result<HeadingControl, &'static str> {
        let needed: Vec<&str> = cascade::needed_names().collect();
        self.read_all(&needed, PARAMETERS_S);
        let speeds = [
            "CRUISE_SPEED",
            "WP_SPEED",
            "MOT_SPD_SCA_BASE",
            "FS_GCS_TIMEOUT",
            "FS_TIMEOUT",
        ];
        let all: Vec<&str> = cascade::names().chain(speeds).collect();
        self.read_all(&all, OPTIONAL_S);
        let parameters = &self.parameters;
        let settings = cascade::settings(|name| parameters.get(name))?;
        let positive = |name: &str| parameters.get(name).filter(|value| *value > 0.0);
        Ok(HeadingControl {
            settings,
            loop_interval_s: 1.0 / positive("SCHED_LOOP_RATE").unwrap_or(LOOP_RATE_HZ),
            default_speed_m_s: positive("WP_SPEED").or(positive("CRUISE_SPEED")),
            scaling_speed_m_s: parameters
                .get("MOT_SPD_SCA_BASE")
                .unwrap_or(SCALING_SPEED_M_S),
        })
    }

    /// Asks for parameters that have not been read until they have, or for this long.
    fn read_all(&mut self, names: &[&str], longest_s: f64) {
        let missing = |autopilot: &Self| -> Vec<String> {
            let is_missing = |name: &&&str| autopilot.parameters.get(name).is_none();
            names
                .iter()
                .filter(is_missing)
                .map(|n| n.to_string())
                .collect()
        };
        self.insist(
            longest_s,
            |autopilot| {
                let missing = missing(autopilot);
                missing
                    .iter()
                    .for_each(|name| autopilot.ask_parameter(name));
            },
            |autopilot| missing(autopilot).is_empty(),
        );
    }

    fn check_timeout(&mut self, found: &mut Preflight) {
        let mut change = |name: &str, to: f64, is_so: fn(f64, f64) -> bool, why: &'static str| {
            let from = self.parameters.get(name)?;
            let is_changed = found.changes.iter().any(|change| change.name == name);
            if !is_changed && !is_so(from, to) {
                let name = name.into();
                found.changes.push(Change {
                    name,
                    from,
                    to,
                    why,
                });
            }
            Some(())
        };
        let soon = "the autopilot holds the vehicle this long after our last heartbeat";
        let stops_s = match change("FS_GCS_TIMEOUT", STATION_S, |from, to| from <= to, soon) {
            Some(()) => STATION_S + 2.0 * LOOK_S,
            None => LONGEST_TIMEOUT_S,
        };
        change(
            "FS_TIMEOUT",
            0.0,
            |from, to| from <= to,
            "and waits no longer",
        );
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
        let gains = cascade::names().map(String::from);
        let backup = Backup {
            system: self.system(),
            mode: self.heard.mode(),
            parameters: changed
                .chain(gains)
                .filter_map(|name| {
                    let stored = self.stored(&name)?;
                    Some((name, stored))
                })
                .collect(),
        };
        if let Err(error) = keep(&backup) {
            found.check("backup", false, error.to_string());
            return found.checks;
        }
        self.backup = Some(backup);
        self.heard.is_guided = true;
        self.beats_quickly = true;
        for change in changes {
            if !self.write_parameter(&change.name, change.to) {
                let text = format!("{} could not be set to {}", change.name, change.to);
                found.check("parameters", false, text);
                return found.checks;
            }
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
        let text = match is_set {
            true => format!("{mode}, in which the autopilot steers to the heading that we ask for"),
            false => {
                format!("it does not go into mode {mode}, in which it would steer to headings")
            }
        };
        found.check("mode", is_set, text);
        if let Some((heading_rad, _)) = self.sampler.newest_heading().filter(|_| is_set) {
            self.heard.our_mode = Some(mode);
            self.note_sticks();
            self.guard();
            self.steer_to(heading_rad, 0.0);
        }
        if let Some(stop) = self.stopped.as_ref() {
            found.check("vehicle", false, stop.to_string());
        }
        self.sampler.skip();
    }

    /// Asks for a heading and a speed, a fraction of the autopilot's default, until something else is asked for.
    pub fn steer_to(&mut self, heading_rad: f64, speed: f64) {
        if self.stopped.is_some() || !self.heard.is_guided {
            return;
        }
        self.attended_s = self.wire.now_s();
        self.course = Some(Course { heading_rad, speed });
        self.send_course();
    }

    /// The course again, while the vehicle is heard: one that is not must stop soon.
    pub(super) fn repeat_course(&mut self) {
        if self.wire.now_s() - self.heard_s <= HEARD_S {
            self.send_course();
        }
    }

    fn send_course(&mut self) {
        let Some(course) = self.course else {
            return;
        };
        self.demanded_s = self.wire.now_s();
        let half = 0.5 * course.heading_rad;
        let (target_system, target_component) = (self.system(), self.component());
        self.send(SetAttitudeTarget {
            time_boot_ms: (1e3 * self.wire.now_s()) as u64 as u32,
            quaternion: [half.cos() as f32, 0.0, 0.0, half.sin() as f32],
            roll_rate_rad_s: 0.0,
            pitch_rate_rad_s: 0.0,
            yaw_rate_rad_s: 0.0,
            thrust: course.speed.clamp(0.0, 1.0) as f32,
            target_system,
            target_component,
            type_mask: RATES_IGNORED,
        });
    }

    /// Writes a parameter of the backup and reads it back. `true`: it is so.
    pub fn write_parameter(&mut self, name: &str, value: f64) -> bool {
        let before = self.backup.as_ref().and_then(|b| b.parameters.get(name));
        let Some(stored) = before.copied() else {
            return false;
        };
        let stored = Stored {
            number: value,
            ..stored
        };
        self.set_parameter(name, stored, CHANGE_S)
    }

    /// The gains as they were when the vehicle was taken.
    pub fn gains_before(&self) -> Backup {
        let parameters = self.backup.iter().flat_map(|backup| {
            let gains = cascade::names().filter_map(|name| backup.parameters.get_key_value(name));
            gains.map(|(name, stored)| (name.clone(), *stored))
        });
        Backup {
            system: self.system(),
            mode: None,
            parameters: parameters.collect(),
        }
    }

    /// The gains stay as they are when the vehicle is handed back. What is still put back then.
    pub fn keep_gains(&mut self) -> Backup {
        let Some(backup) = &mut self.backup else {
            return Backup::default();
        };
        for name in cascade::names() {
            backup.parameters.remove(name);
        }
        backup.clone()
    }
}

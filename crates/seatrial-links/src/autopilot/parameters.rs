//! The vehicle's parameters: which are read, and which a trial changes so that the autopilot lets go in time.

use super::{Autopilot, Profile};
use crate::handover::{Change, Controls, Preflight};
use crate::link::Wire;

/// Longest wait for all parameters, s.
const PARAMETERS_S: f64 = 15.0;
/// Longest wait for parameters that not every firmware has, s.
const OPTIONAL_S: f64 = 3.0;
/// Parameters asked for at a time.
const ASKED_AT_ONCE: usize = 16;
/// After this long without us the autopilot must have let go, s.
pub(super) const LONGEST_OVERRIDE_S: f64 = 1.0;
/// What an override is set to last, s.
const OVERRIDE_S: f64 = 0.8;

impl<W: Wire> Autopilot<W> {
    /// Reads every parameter that matters; returns the names of those that were not answered for.
    pub(super) fn read_parameters(&mut self) -> Vec<String> {
        let profile = self.profile();
        let mut names: Vec<String> = profile.parameters().iter().map(|n| (*n).into()).collect();
        let missing = |autopilot: &Self, names: &[String]| -> Vec<String> {
            let is_missing = |name: &&String| autopilot.parameters.get(name).is_none();
            names.iter().filter(is_missing).cloned().collect()
        };
        if profile.is_ardupilot() {
            names.extend((1..=16).map(|n| format!("SERVO{n}_FUNCTION")));
        }
        let read = |autopilot: &mut Self, names: &[String], longest_s: f64| {
            let mut round = 0;
            autopilot.insist(
                longest_s,
                |autopilot| {
                    let missing = missing(autopilot, names);
                    let start = round * ASKED_AT_ONCE % missing.len().max(1);
                    round += 1;
                    for name in missing
                        .iter()
                        .cycle()
                        .skip(start)
                        .take(ASKED_AT_ONCE.min(missing.len()))
                    {
                        autopilot.ask_parameter(name);
                    }
                },
                |autopilot| missing(autopilot, names).is_empty(),
            );
        };
        read(self, &names, PARAMETERS_S);
        if profile.is_ardupilot() {
            let used = |function: f64| {
                matches!(function as u32, 21 | 26 | 33..=36 | 70 | 73 | 74 | 79 | 80)
            };
            let mut more = Vec::new();
            for number in 1..=16 {
                let function = self.parameters.get(&format!("SERVO{number}_FUNCTION"));
                if function.is_some_and(used) {
                    more.extend(
                        ["MIN", "TRIM", "MAX", "REVERSED"].map(|w| format!("SERVO{number}_{w}")),
                    );
                }
            }
            if profile == Profile::Sub {
                more.extend((1..=4).map(|n| format!("MOT_{n}_DIRECTION")));
            }
            read(self, &more, PARAMETERS_S);
            names.extend(more);
            if profile == Profile::Sub {
                let optional = ["JS_GAIN_DEFAULT", "FS_PILOT_TIMEOUT"].map(String::from);
                read(self, &optional, OPTIONAL_S);
            }
            // One of them, by the age of the firmware.
            let station = ["MAV_GCS_SYSID", "SYSID_MYGCS"];
            self.insist(
                PARAMETERS_S,
                |autopilot| {
                    station
                        .iter()
                        .for_each(|name| autopilot.ask_parameter(name))
                },
                |autopilot| {
                    station
                        .iter()
                        .any(|name| autopilot.parameters.get(name).is_some())
                },
            );
        }
        missing(self, &names)
    }

    pub(super) fn check_failsafes(&mut self, found: &mut Preflight) {
        let profile = self.profile();
        let change = |name: &str, to: f64, why: &'static str| {
            let from = self.parameters.get(name)?;
            Some(Change {
                name: name.into(),
                from,
                to,
                why,
            })
        };
        if profile.is_ardupilot() {
            let seconds = self.parameters.get("RC_OVERRIDE_TIME").unwrap_or(f64::NAN);
            if !(seconds > 0.0 && seconds <= LONGEST_OVERRIDE_S) {
                let why = "the autopilot lets go of the rudder this long after our last command";
                found
                    .changes
                    .extend(change("RC_OVERRIDE_TIME", OVERRIDE_S, why));
            }
        }
        if profile == Profile::Rover {
            if self.parameters.get("FS_GCS_ENABLE") == Some(0.0) {
                let why = "the autopilot acts when this program is gone";
                found.changes.extend(change("FS_GCS_ENABLE", 1.0, why));
            }
            if self.parameters.get("FS_ACTION") == Some(0.0) {
                found
                    .changes
                    .extend(change("FS_ACTION", 2.0, "a failsafe holds the vehicle"));
            }
        }
        if profile == Profile::Sub {
            // Without a remote control it is not the override's end that makes the sticks neutral.
            let has_sticks = self.heard.has_sticks();
            let seconds = self.parameters.get("FS_PILOT_TIMEOUT");
            if !has_sticks && seconds.is_some_and(|seconds| seconds > LONGEST_OVERRIDE_S) {
                let why = "without a remote control it is this that lets go of the rudder";
                found
                    .changes
                    .extend(change("FS_PILOT_TIMEOUT", OVERRIDE_S, why));
            }
            if !has_sticks && self.parameters.get("FS_PILOT_INPUT") != Some(1.0) {
                let why = "1 makes the controls neutral after FS_PILOT_TIMEOUT and does not disarm";
                found.changes.extend(change("FS_PILOT_INPUT", 1.0, why));
            }
            let action = self.parameters.get("FS_GCS_ENABLE").unwrap_or(0.0);
            found.check(
                "failsafe",
                action >= 2.0,
                format!("FS_GCS_ENABLE is {action}; 2 and above does something when this program is gone, and what is yours to say"),
            );
        }
        if profile == Profile::Px4 {
            let seconds = self.parameters.get("COM_RC_LOSS_T").unwrap_or(f64::NAN);
            if !(seconds > 0.0 && seconds <= LONGEST_OVERRIDE_S) {
                let why = "the autopilot lets go of the rudder this long after our last command";
                found
                    .changes
                    .extend(change("COM_RC_LOSS_T", OVERRIDE_S, why));
            }
        }
    }
}

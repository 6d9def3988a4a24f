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
        if profile.is_ardupilot() {
            names.extend((1..=16).map(|n| format!("SERVO{n}_FUNCTION")));
        }
        self.read_named(&names, PARAMETERS_S);
        if profile.is_ardupilot() {
            let mut more = self.output_parameters();
            if profile == Profile::Sub {
                more.extend((1..=4).map(|n| format!("MOT_{n}_DIRECTION")));
            }
            self.read_named(&more, PARAMETERS_S);
            names.extend(more);
            if profile == Profile::Sub {
                self.read_named(&["JS_GAIN_DEFAULT", "FS_PILOT_TIMEOUT"], OPTIONAL_S);
            }
            self.read_station();
        }
        self.missing(&names)
    }

    fn missing(&self, names: &[impl AsRef<str>]) -> Vec<String> {
        let names = names.iter().map(AsRef::as_ref);
        let missing = names.filter(|name| self.parameters.get(name).is_none());
        missing.map(String::from).collect()
    }

    /// Asks for these parameters, some at a time, until all have come or the time is over.
    pub(super) fn read_named(&mut self, names: &[impl AsRef<str>], longest_s: f64) {
        let mut round = 0;
        self.insist(
            longest_s,
            |autopilot| {
                let missing = autopilot.missing(names);
                let start = round * ASKED_AT_ONCE % missing.len().max(1);
                round += 1;
                for name in
                    missing.iter().cycle().skip(start).take(ASKED_AT_ONCE.min(missing.len()))
                {
                    autopilot.ask_parameter(name);
                }
            },
            |autopilot| autopilot.missing(names).is_empty(),
        );
    }

    /// Names of the parameters of outputs that steer or drive.
    fn output_parameters(&self) -> Vec<String> {
        let used =
            |function: f64| matches!(function as u32, 21 | 26 | 33..=36 | 70 | 73 | 74 | 79 | 80);
        let mut names = Vec::new();
        for number in 1..=16 {
            let function = self.parameters.get(&format!("SERVO{number}_FUNCTION"));
            if function.is_some_and(used) {
                let of_output = ["MIN", "TRIM", "MAX", "REVERSED"];
                names.extend(of_output.map(|w| format!("SERVO{number}_{w}")));
            }
        }
        names
    }

    /// Whom the autopilot takes for its ground station: one of two names, by the age of the firmware.
    fn read_station(&mut self) {
        let station = ["MAV_GCS_SYSID", "SYSID_MYGCS"];
        let asks = |autopilot: &mut Self| station.iter().for_each(|n| autopilot.ask_parameter(n));
        let is_known = |autopilot: &mut Self| autopilot.missing(&station).len() < station.len();
        self.insist(PARAMETERS_S, asks, is_known);
    }

    pub(super) fn check_failsafes(&mut self, found: &mut Preflight) {
        let profile = self.profile();
        if profile.is_ardupilot() {
            self.limit_override("RC_OVERRIDE_TIME", found);
        }
        match profile {
            Profile::Rover => self.check_failsafes_of_rover(found),
            Profile::Sub => self.check_failsafes_of_sub(found),
            Profile::Px4 => self.limit_override("COM_RC_LOSS_T", found),
            Profile::Generic => {}
        }
    }

    pub(super) fn change(&self, name: &str, to: f64, why: &'static str) -> Option<Change> {
        let from = self.parameters.get(name)?;
        Some(Change { name: name.into(), from, to, why: why.into() })
    }

    /// Has the autopilot let go of the rudder soon after our last command.
    fn limit_override(&self, name: &str, found: &mut Preflight) {
        let seconds = self.parameters.get(name).unwrap_or(f64::NAN);
        if !(seconds > 0.0 && seconds <= LONGEST_OVERRIDE_S) {
            let why = "the autopilot lets go of the rudder this long after our last command";
            found.changes.extend(self.change(name, OVERRIDE_S, why));
        }
    }

    fn check_failsafes_of_rover(&self, found: &mut Preflight) {
        if self.parameters.get("FS_GCS_ENABLE") == Some(0.0) {
            let why = "the autopilot acts when this program is gone";
            found.changes.extend(self.change("FS_GCS_ENABLE", 1.0, why));
        }
        if self.parameters.get("FS_ACTION") == Some(0.0) {
            let why = "a failsafe holds the vehicle";
            found.changes.extend(self.change("FS_ACTION", 2.0, why));
        }
    }

    fn check_failsafes_of_sub(&self, found: &mut Preflight) {
        // Without a remote control it is not the override's end that makes the sticks neutral.
        let has_sticks = self.heard.has_sticks();
        let seconds = self.parameters.get("FS_PILOT_TIMEOUT");
        if !has_sticks && seconds.is_some_and(|seconds| seconds > LONGEST_OVERRIDE_S) {
            let why = "without a remote control it is this that lets go of the rudder";
            let change = self.change("FS_PILOT_TIMEOUT", OVERRIDE_S, why);
            found.changes.extend(change);
        }
        if !has_sticks && self.parameters.get("FS_PILOT_INPUT") != Some(1.0) {
            let why = "1 makes the controls neutral after FS_PILOT_TIMEOUT and does not disarm";
            let change = self.change("FS_PILOT_INPUT", 1.0, why);
            found.changes.extend(change);
        }
        let action = self.parameters.get("FS_GCS_ENABLE").unwrap_or(0.0);
        found.check(
            "failsafe",
            action >= 2.0,
            format!("FS_GCS_ENABLE is {action}; 2 and above does something when this program is gone, and what is yours to say"),
        );
    }
}

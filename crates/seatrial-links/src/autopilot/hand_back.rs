//! Giving a vehicle back: controls released, mode and parameters as they were, read back.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use seatrial_mavlink::ardupilot::Pulse;
use serde::{Deserialize, Serialize};

use super::cascade::{self, decimal};
use super::profile::Demand;
use super::{Autopilot, Profile, REAL32, SET_MODE};
use crate::handover::{Controls, NEUTRAL};
use crate::link::{Message, Wire};

/// Longest wait for a mode or a parameter, s.
const RESTORE_S: f64 = 6.0;
/// Some looks of a vehicle at whether it hears us, s. Rover's are 0.1 s apart.
const LOOKS_S: f64 = 0.6;
/// Longest wait for a failsafe to end now that we are heard again, s.
const FAILSAFE_S: f64 = 4.0;
/// Longest wait for a vehicle that is silent, s.
const RECONNECT_S: f64 = 10.0;
/// `SERVOn_FUNCTION` of the throttle, and of the horizontal thrusters of ArduSub's vectored frames.
const THROTTLE: &[f64] = &[70.0];
const SUB_THRUSTERS: &[f64] = &[33.0, 34.0, 35.0, 36.0];

/// The parameters that a trial or a commission changes until the hand-back, besides the gains of the heading controller.
/// Each with the values that an autopilot takes, and somewhat more.
const CHANGED: [(&str, RangeInclusive<f64>); 8] = [
    ("COM_RC_LOSS_T", 0.0..=60.0),
    ("FS_ACTION", 0.0..=10.0),
    ("FS_GCS_ENABLE", 0.0..=10.0),
    ("FS_GCS_TIMEOUT", 0.0..=300.0),
    ("FS_PILOT_INPUT", 0.0..=10.0),
    ("FS_PILOT_TIMEOUT", 0.0..=60.0),
    ("FS_TIMEOUT", 0.0..=300.0),
    ("RC_OVERRIDE_TIME", -1.0..=300.0),
];

/// MAV_PARAM_TYPE.
const KINDS: RangeInclusive<u8> = 1..=10;

/// A parameter as it was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterValue {
    /// Its value.
    pub number: f64,
    /// MAV_PARAM_TYPE.
    pub kind: u8,
    /// Is it sent bit by bit, as PX4 does with integers?
    #[serde(default)]
    pub is_bits: bool,
}

impl ParameterValue {
    /// As it is sent.
    pub(super) fn value(&self) -> f32 {
        if self.is_bits { f32::from_bits(self.number as i32 as u32) } else { self.number as f32 }
    }

    /// As it is read back.
    pub(super) fn number(&self) -> f64 {
        if self.is_bits { self.number } else { decimal(self.number as f32) }
    }
}

/// What is put back at the end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backup {
    /// System id of the vehicle.
    pub system: u8,
    /// Its mode, `custom_mode` of its heartbeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterValue>,
}

/// What a hand-back has reached.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HandBack {
    /// The rudder output was seen neutral; `None`: the pilot or the autopilot steers already.
    pub rudder_neutral: Option<bool>,
    /// The throttle output was seen neutral; `None` where it is not known.
    pub throttle_neutral: Option<bool>,
    /// The mode is as before; `None`: the pilot or the autopilot chose another, which stays.
    pub mode_restored: Option<bool>,
    /// Parameters that are as before.
    pub restored: Vec<String>,
    /// Parameters that could not be put back or read back.
    pub not_restored: Vec<String>,
    /// What each parameter was before and is now, where it was put back from a backup.
    pub values: Vec<PutBack>,
}

/// A parameter that was put back.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PutBack {
    /// Its name.
    pub name: String,
    /// What it was before; `None` where the autopilot did not say.
    pub from: Option<f64>,
    /// What it is now.
    pub to: f64,
}

impl Backup {
    /// Names in it that neither a trial nor a commission ever changes: somebody else has written them there.
    pub fn foreign_names(&self) -> Vec<&str> {
        let is_ours = |name: &&str| range_of(name).is_some();
        let names = self.parameters.keys().map(String::as_str);
        names.filter(|name| !is_ours(name)).collect()
    }

    /// What in it no autopilot had: the mode, or a parameter with its value.
    pub fn impossible_values(&self) -> Vec<String> {
        let mode = self.mode.filter(|mode| !is_mode(*mode));
        let wrong = |(name, stored): (&String, &ParameterValue)| {
            let range = range_of(name).unwrap_or(f64::MIN..=f64::MAX);
            let is_possible = range.contains(&stored.number) && KINDS.contains(&stored.kind);
            (!is_possible).then(|| format!("{name} = {}, type {}", stored.number, stored.kind))
        };
        let parameters = self.parameters.iter().filter_map(wrong);
        let mode = mode.map(|mode| format!("mode = {mode}"));
        mode.into_iter().chain(parameters).collect()
    }
}

/// The values of a parameter that a trial or a commission changes; `None` of any other.
fn range_of(name: &str) -> Option<RangeInclusive<f64>> {
    let known = CHANGED.into_iter().find(|(changed, _)| *changed == name);
    known.map(|(_, range)| range).or_else(|| cascade::most_of(name).map(|most| 0.0..=most))
}

/// ArduPilot numbers its modes; PX4 keeps the main mode in the third byte and a mode of that in the fourth.
fn is_mode(mode: u32) -> bool {
    let [low, second, main, sub] = mode.to_le_bytes();
    match (second, main, sub) {
        (0, 0, 0) => low < 64,
        (0, 1.., _) => low == 0 && main < 32 && sub < 32,
        _ => false,
    }
}

impl HandBack {
    /// A vehicle that does not answer.
    fn nothing(backup: &Backup) -> Self {
        Self {
            rudder_neutral: Some(false),
            throttle_neutral: Some(false),
            mode_restored: backup.mode.map(|_| false),
            restored: Vec::new(),
            not_restored: backup.parameters.keys().cloned().collect(),
            values: Vec::new(),
        }
    }

    /// Is something left that can be restored later?
    pub fn needs_restoring(&self) -> bool {
        !self.not_restored.is_empty() || self.mode_restored == Some(false)
    }

    /// Is everything as before?
    pub fn is_complete(&self) -> bool {
        self.not_restored.is_empty()
            && self.mode_restored != Some(false)
            && self.rudder_neutral != Some(false)
            && self.throttle_neutral != Some(false)
    }
}

impl<W: Wire> Autopilot<W> {
    /// Gives up the controls at once.
    pub(super) fn let_go(&mut self) {
        self.on_guard = false;
        if self.demand.is_some() || self.course.is_some() {
            self.release_controls();
        }
    }

    pub(super) fn release_controls(&mut self) {
        // Without a release, or a remote control to release to, the last demand would stay; a pilot who has one has his own.
        // Nobody steers a vehicle that is disarmed, and whoever forged that has not disarmed it: neutral is right for both.
        let is_pilots = self.is_pilots() && self.stopped != Some(super::Stop::Disarmed);
        if self.heard.is_guided {
            self.release_course(is_pilots);
            return;
        }
        self.release_sticks(is_pilots);
        self.demand = None;
        self.sampler.thrust = None;
    }

    fn release_sticks(&mut self, is_pilots: bool) {
        let release = self.give_to_sticks();
        if release.is_none() || !is_pilots {
            let (profile, system) = (self.profile(), self.system());
            self.send(profile.demand(Demand::default(), &self.parameters, system));
        }
        if let Some(release) = release {
            self.send(release);
        }
    }

    /// Does the pilot have the vehicle? A stick alone does nothing in a mode in which the autopilot steers.
    fn is_pilots(&self) -> bool {
        self.stopped.as_ref().is_some_and(|stop| {
            let is_in_vain = self.heard.is_guided && matches!(stop, super::Stop::PilotStick(_));
            stop.is_pilot() && !is_in_vain
        })
    }

    /// The autopilot, which steers by itself, does nothing from now on; a pilot has chosen what it does.
    fn release_course(&mut self, is_pilots: bool) {
        if !is_pilots {
            self.hold_here();
        }
        self.course = None;
        if self.profile() == Profile::Sub {
            self.release_sticks(is_pilots);
        }
        if let Some(mode) = self.profile().idle_mode().filter(|_| !is_pilots) {
            self.heard.our_mode = Some(mode);
            self.command(SET_MODE, [1.0, mode as f32, 0.0]);
        }
    }

    /// What gives the controls to the remote control. ArduSub without one keeps the last stick that it has seen, which must
    /// be a neutral one.
    fn give_to_sticks(&self) -> Option<Message> {
        let profile = self.profile();
        let has_effect = profile != Profile::Sub || self.heard.has_sticks();
        profile.release(self.system()).filter(|_| has_effect)
    }

    /// Releases the controls, puts back mode and parameters, and reads everything back. Where that was done already, the result.
    pub fn hand_back(&mut self) -> HandBack {
        self.let_go();
        let mut done = HandBack::default();
        let Some(backup) = self.backup.take() else {
            return self.handed_back.take().unwrap_or_default();
        };
        self.release_repeatedly(Self::release_controls);
        let heartbeats = self.heard.heartbeats;
        let is_heard = self.wait(RECONNECT_S, |autopilot| autopilot.heard.heartbeats > heartbeats);
        if !is_heard {
            // Nothing can be read back, the last that was heard least of all.
            return HandBack::nothing(&backup);
        }
        if self.heard.is_guided {
            // The autopilot goes on with its own gains.
            self.restore_parameters(&backup, self.stopped.is_some(), &mut done);
        }
        self.restore_mode(&backup, &mut done);
        if !self.heard.is_guided {
            self.restore_parameters(&backup, self.stopped.is_some(), &mut done);
        }
        for (id, _) in self.wanted_messages() {
            self.set_interval(id, 0.0);
        }
        self.heard.our_mode = None;
        self.heard.is_guided = false;
        self.beats_quickly = false;
        done
    }

    /// Waits for neutral controls and puts the mode back, unless the pilot or the autopilot has chosen another.
    fn restore_mode(&mut self, backup: &Backup, done: &mut HandBack) {
        let mode = self.heard.mode();
        let is_heading_mode = self.heard.is_guided && mode == self.profile().heading_mode();
        let is_ours =
            self.heard.our_mode.is_none() || mode == self.heard.our_mode || is_heading_mode;
        if !is_ours || self.is_pilots() {
            return;
        }
        // Sub holds its heading in the mode in which it idles.
        let steers = self.heard.is_guided && self.profile() == Profile::Sub;
        done.rudder_neutral =
            (!steers).then(|| self.wait(2.0, |autopilot| autopilot.is_rudder_neutral()));
        done.throttle_neutral = match steers {
            true => None,
            false => self.wait_for_throttle(),
        };
        let is_as_before = backup.mode == self.heard.mode();
        if let Some(mode) = backup.mode.filter(|_| self.heard.is_guided || !is_as_before) {
            done.mode_restored = Some(is_as_before || self.set_mode(mode, RESTORE_S));
        }
    }

    /// What [`restore`](Self::restore) of a backup would write: each parameter as it is now and as it would be. `None`: the vehicle
    /// is not heard.
    pub fn look_at(&mut self, backup: &Backup) -> Option<Vec<PutBack>> {
        self.is_there(backup).then(|| {
            self.ask_for(backup);
            let parameters = backup.parameters.iter();
            let values = parameters.map(|(name, stored)| PutBack {
                name: name.clone(),
                from: self.parameters.get(name),
                to: stored.number(),
            });
            values.collect()
        })
    }

    fn is_there(&mut self, backup: &Backup) -> bool {
        // Another autopilot may be heard first.
        self.settings.vehicle = Some(backup.system);
        self.beats_quickly = backup.parameters.contains_key("FS_GCS_TIMEOUT");
        self.wait(RECONNECT_S, |autopilot| {
            autopilot.heard.vehicle.is_some_and(|vehicle| vehicle.system == backup.system)
        })
    }

    fn ask_for(&mut self, backup: &Backup) {
        for name in backup.parameters.keys() {
            self.insist(
                LOOKS_S,
                |autopilot| autopilot.ask_parameter(name),
                |autopilot| autopilot.parameters.get(name).is_some(),
            );
        }
    }

    /// Puts back what a backup holds, on a vehicle that nobody conducts a trial with.
    pub fn restore(&mut self, backup: &Backup) -> HandBack {
        let mut done = HandBack::default();
        if !self.is_there(backup) {
            return HandBack::nothing(backup);
        }
        // The last override of a trial that was killed would live again with a longer RC_OVERRIDE_TIME.
        self.release_repeatedly(|autopilot| {
            if let Some(release) = autopilot.profile().release(autopilot.system()) {
                autopilot.send(release);
            }
        });
        // What is overwritten is reported.
        self.ask_for(backup);
        self.restore_parameters(backup, true, &mut done);
        let profile = self.profile();
        let has_gains = cascade::all_names().any(|name| backup.parameters.contains_key(name));
        let left_behind = match has_gains {
            true => profile.heading_mode(),
            false => profile.steering_mode(),
        };
        // Only from the mode that we left behind: any other is somebody's choice since.
        let is_left_behind = self.heard.mode().is_some() && self.heard.mode() == left_behind;
        if let Some(mode) = backup.mode.filter(|_| is_left_behind) {
            done.mode_restored = Some(self.set_mode(mode, RESTORE_S));
        }
        self.beats_quickly = false;
        done
    }

    fn restore_parameters(&mut self, backup: &Backup, was_away: bool, done: &mut HandBack) {
        // ArduPilot's Rover does not look whether we are back once that failsafe is disabled, and stays critical, or
        // becomes it where it has taken note of our absence.
        if was_away && backup.parameters.contains_key("FS_GCS_ENABLE") {
            self.wait(LOOKS_S, |_| false);
            self.wait(FAILSAFE_S, |autopilot| !autopilot.heard.is_critical());
        }
        // What enables a failsafe comes after what it goes by.
        let is_last = |(name, _): &(&String, &ParameterValue)| name.as_str() == "FS_GCS_ENABLE";
        let parameters = backup.parameters.iter();
        let (last, first): (Vec<_>, Vec<_>) = parameters.partition(is_last);
        for (name, stored) in first.into_iter().chain(last) {
            let from = self.parameters.get(name).filter(|value| value.is_finite());
            if self.set_parameter(name, *stored, RESTORE_S) {
                done.values.push(PutBack { name: name.clone(), from, to: stored.number() });
                done.restored.push(name.clone());
            } else {
                done.not_restored.push(name.clone());
            }
        }
    }

    fn wait_for_throttle(&mut self) -> Option<bool> {
        let functions = match self.profile() {
            Profile::Sub => SUB_THRUSTERS,
            _ => THROTTLE,
        };
        let thrusters = functions.iter().map(|function| {
            let number = self.parameters.output_with(*function, 8)?;
            let pulse = Pulse::of(&self.parameters, &format!("SERVO{number}"));
            Some((number, pulse))
        });
        let thrusters = thrusters.collect::<Option<Vec<_>>>()?;
        self.heard.outputs?;
        Some(self.wait(2.0, |autopilot| {
            let outputs = autopilot.heard.outputs.unwrap_or_default();
            thrusters.iter().all(|(number, pulse)| {
                let pulse_us = f64::from(outputs[number - 1]);
                // No pulse is no thrust.
                pulse_us == 0.0 || pulse.fraction(pulse_us).abs() < NEUTRAL
            })
        }))
    }

    /// A parameter as it is now.
    pub(super) fn stored(&self, name: &str) -> Option<ParameterValue> {
        let kind = self.kinds.get(name).copied().unwrap_or(REAL32);
        Some(ParameterValue {
            number: self.parameters.get(name)?,
            kind,
            is_bits: kind != REAL32 && self.profile() == Profile::Px4,
        })
    }
}

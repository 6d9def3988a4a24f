//! Taking the vehicle: parameters, mode, and the proof that the rudder answers and that the autopilot lets go of it.

use std::io;

use super::parameters::LONGEST_OVERRIDE_S;
use super::profile::Demand;
use super::{Autopilot, Backup, Stop};
use crate::handover::{
    Change, Check, Controls, LostProcess, Preflight, Wiggle, prove_rudder, prove_that_it_lets_go,
};
use crate::link::Wire;

/// Longest wait for one change, s.
const CHANGE_S: f64 = 6.0;
/// Longest wait for the first report of the remote control, s. Some autopilots report it only where there is one.
const STICKS_S: f64 = 2.0;

impl<W: Wire> Autopilot<W> {
    /// Takes the vehicle: changes its parameters and mode, proves that the rudder answers, with the right sense, and that
    /// the autopilot lets go when nothing is heard from us. `keep` puts the backup where it survives this program. Unless
    /// every check passes the vehicle must be handed back.
    pub fn take_control(
        &mut self,
        changes: &[Change],
        keep: &mut dyn FnMut(&Backup) -> io::Result<()>,
    ) -> Vec<Check> {
        let mut found = Preflight::default();
        let mode = self.heard.mode();
        let mode = mode.filter(|_| self.profile().steering_mode().is_some());
        let names = changes.iter().map(|change| change.name.clone());
        let is_taken = self.back_up(mode, names, keep, &mut found)
            && self.make_changes(changes, &mut found)
            && self.enter_mode(&mut found);
        if !is_taken {
            return found.checks;
        }
        self.wiggle(&mut found);
        if found.is_passed() {
            self.prove_lost_process(&mut found);
        }
        if let Some(stop) = self.stopped.as_ref() {
            found.check("vehicle", false, stop.to_string());
        }
        self.sampler.skip();
        found.checks
    }

    /// Keeps the mode and these parameters as they are, to be put back. `false`: they could not be kept.
    pub(super) fn back_up(
        &mut self,
        mode: Option<u32>,
        names: impl Iterator<Item = String>,
        keep: &mut dyn FnMut(&Backup) -> io::Result<()>,
        found: &mut Preflight,
    ) -> bool {
        let stored = names.filter_map(|name| self.stored(&name).map(|stored| (name, stored)));
        let backup = Backup { system: self.system(), mode, parameters: stored.collect() };
        if let Err(error) = keep(&backup) {
            found.check("backup", false, error.to_string());
            return false;
        }
        self.backup = Some(backup);
        true
    }

    /// Changes parameters of the backup. `false`: one could not be changed.
    pub(super) fn make_changes(&mut self, changes: &[Change], found: &mut Preflight) -> bool {
        changes.iter().all(|change| {
            let is_set = self.write_parameter(&change.name, change.to);
            if !is_set {
                let text = format!("{} could not be set to {}", change.name, change.to);
                found.check("parameters", false, text);
            }
            is_set
        })
    }

    fn enter_mode(&mut self, found: &mut Preflight) -> bool {
        let Some(mode) = self.profile().steering_mode() else {
            self.heard.our_mode = self.heard.mode();
            self.note_sticks();
            self.guard();
            return true;
        };
        let is_set = self.set_mode(mode, CHANGE_S);
        let name = self.profile().mode_text(mode);
        found.check(
            "mode",
            is_set,
            match is_set {
                true => format!("{name}, in which the rudder follows us"),
                false => {
                    format!("it does not go into mode {name}, in which the rudder would follow us")
                }
            },
        );
        if is_set {
            self.heard.our_mode = Some(mode);
            self.note_sticks();
            if self.heard.is_critical() {
                // The failsafe of a vehicle that nobody steers ends with that.
                self.ask(Demand::default());
                self.wait(CHANGE_S, |autopilot| !autopilot.heard.is_critical());
            }
            self.guard();
        }
        is_set
    }

    /// Notes where the pilot's sticks are: one that leaves its place later takes the vehicle over.
    pub(super) fn note_sticks(&mut self) {
        self.wait(STICKS_S, |autopilot| autopilot.heard.remote_control.is_some());
        self.heard.note_sticks();
    }

    pub(super) fn guard(&mut self) {
        self.heard.failsafe = None;
        self.following.over(self.heard.clock.map(|(round_trip_s, _)| round_trip_s));
        self.following.restart(self.wire.now_s());
        self.on_guard = true;
    }

    fn wiggle(&mut self, found: &mut Preflight) {
        // What was asked for takes a round trip to be seen.
        let late_s = self.round_trip_s();
        let wiggle = Wiggle {
            thrust: self.settings.trying_thrust,
            straight_s: 3.0,
            side_s: 2.0 + 2.0 * late_s,
            full_rudder_rad: self.settings.full_rudder_rad,
            is_reported: true,
            is_reversed: self.settings.is_reversed,
            echo_hint: "that our system id is obeyed, the mode, that it is armed, whether the output is reversed",
            sense_hint: "whether the output is reversed, or rudder_sense in the plan",
        };
        prove_rudder(self, &wiggle, found);
        self.drive(0.0, 0.0, 1.0 + late_s);
    }

    fn round_trip_s(&self) -> f64 {
        self.heard.clock.map_or(0.0, |(round_trip_s, _)| round_trip_s)
    }

    /// What a lost process would do: the autopilot must let go of the rudder by itself.
    fn prove_lost_process(&mut self, found: &mut Preflight) {
        let late_s = self.round_trip_s();
        let process = LostProcess {
            who: "the autopilot",
            deflected_s: 1.0 + 2.0 * late_s,
            longest_s: LONGEST_OVERRIDE_S + late_s + 0.3,
            remedy: "set its timeout and failsafe",
        };
        if !prove_that_it_lets_go(self, &process, found) {
            return;
        }
        self.ask(Demand::default());
        // Its failsafe may have changed the mode, as it should; a heartbeat tells.
        self.wait(1.2, |autopilot| autopilot.heard.is_critical());
        self.is_proving = false;
        if self.stopped.is_some() {
            return;
        }
        let is_failsafe = self.heard.is_critical() || self.heard.failsafe.is_some();
        let moved = self.heard.mode().filter(|_| !is_failsafe);
        let moved = moved.filter(|mode| self.heard.our_mode.is_some_and(|ours| ours != *mode));
        if let Some(mode) = moved {
            self.on_guard = true;
            self.stop_on_guard(Stop::PilotMode(mode));
            return;
        }
        if let Some(mode) = self.heard.our_mode.filter(|_| is_failsafe) {
            let is_back = self.set_mode(mode, CHANGE_S)
                && self.wait(CHANGE_S, |autopilot| !autopilot.heard.is_critical());
            if !is_back {
                found.check("mode", false, "it did not come back from its failsafe");
            }
        }
        self.guard();
    }
}

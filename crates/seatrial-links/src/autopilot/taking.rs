//! Taking the vehicle: parameters, mode, and the proof that the rudder answers and that the autopilot lets go of it.

use std::io;

use seatrial_core::Sample;

use super::hand_back::NEUTRAL;
use super::preflight::LONGEST_OVERRIDE_S;
use super::profile::Demand;
use super::{Autopilot, Backup, Change, Check, Preflight, Stop, Stored};
use crate::link::Wire;
use crate::wiggle::late_mean;

/// Longest wait for one change, s.
const CHANGE_S: f64 = 6.0;
/// The small wiggle, as a fraction of full rudder.
const WIGGLE: f64 = 0.2;
/// An echo may differ from what was asked for by this, as a fraction of full.
const ECHO: f64 = 0.05;
/// A yaw rate that tells the rudder's sense, rad/s.
const TELLING_RATE_RAD_S: f64 = 0.01;

impl<W: Wire> Autopilot<W> {
    /// Takes the vehicle: changes its parameters and mode, proves that the rudder answers, with the right sense, and that
    /// the autopilot lets go when nothing is heard from us. `keep` puts the backup where it survives this program. Unless
    /// every check passes the vehicle must be handed back.
    pub fn take_control(
        &mut self,
        changes: &[Change],
        keep: &mut dyn FnMut(&Backup) -> io::Result<()>,
    ) -> Vec<Check> {
        let mut found = Preflight {
            vehicle: String::new(),
            checks: Vec::new(),
            changes: Vec::new(),
        };
        let backup = Backup {
            system: self.system(),
            mode: self
                .heard
                .mode()
                .filter(|_| self.profile().steering_mode().is_some()),
            parameters: changes
                .iter()
                .filter_map(|change| Some((change.name.clone(), self.stored(&change.name)?)))
                .collect(),
        };
        if let Err(error) = keep(&backup) {
            found.check("backup", false, error.to_string());
            return found.checks;
        }
        let before = backup.parameters.clone();
        self.backup = Some(backup);
        for change in changes {
            let stored = before.get(&change.name).map(|stored| Stored {
                number: change.to,
                ..*stored
            });
            let is_set =
                stored.is_some_and(|stored| self.set_parameter(&change.name, stored, CHANGE_S));
            if !is_set {
                let text = format!("{} could not be set to {}", change.name, change.to);
                found.check("parameters", false, text);
                return found.checks;
            }
        }
        if !self.enter_mode(&mut found) {
            return found.checks;
        }
        self.wiggle(&mut found);
        if found.is_passed() {
            self.fall_silent(&mut found);
        }
        if let Some(stop) = self.stopped.as_ref() {
            found.check("vehicle", false, stop.to_string());
        }
        self.sampler.skip();
        found.checks
    }

    fn enter_mode(&mut self, found: &mut Preflight) -> bool {
        let Some(mode) = self.profile().steering_mode() else {
            self.heard.our_mode = self.heard.mode();
            self.heard.note_sticks();
            self.guard();
            return true;
        };
        let is_set = self.set_mode(mode, CHANGE_S);
        found.check(
            "mode",
            is_set,
            match is_set {
                true => format!("{mode}, in which the rudder follows us"),
                false => {
                    format!("it does not go into mode {mode}, in which the rudder would follow us")
                }
            },
        );
        if is_set {
            self.heard.our_mode = Some(mode);
            self.heard.note_sticks();
            if self.heard.is_critical() {
                // The failsafe of a vehicle that nobody steers ends with that.
                self.ask(Demand::default());
                self.wait(CHANGE_S, |autopilot| !autopilot.heard.is_critical());
            }
            self.guard();
        }
        is_set
    }

    fn guard(&mut self) {
        self.heard.failsafe = None;
        self.followed_s = self.wire.now_s();
        self.on_guard = true;
    }

    /// Asks for the same for so long on the vehicle's clock; the samples of that time.
    fn drive(&mut self, steer: f64, thrust: f64, duration_s: f64) -> Vec<Sample<f64>> {
        self.sampler.skip();
        let mut samples: Vec<Sample<f64>> = Vec::new();
        if self.stopped.is_some() {
            return samples;
        }
        let end_s = self.wire.now_s() + 2.0 * duration_s + 3.0;
        self.ask(Demand { steer, thrust });
        while self.wire.now_s() < end_s && self.stopped.is_none() {
            let now_s = self.wire.now_s();
            self.pump(now_s + 0.02);
            while let Some(sample) = self.sampler.take() {
                samples.push(sample);
                if self.stopped.is_none() {
                    self.ask(Demand { steer, thrust });
                }
            }
            let first_s = samples.first().map(|sample| sample.time_s);
            let last_s = samples.last().map(|sample| sample.time_s);
            if first_s
                .zip(last_s)
                .is_some_and(|(first, last)| last - first >= duration_s)
            {
                break;
            }
        }
        samples
    }

    fn wiggle(&mut self, found: &mut Preflight) {
        let full_rad = self.settings.full_rudder_rad;
        let thrust = self.settings.trying_thrust;
        // What was asked for takes a round trip to be seen.
        let late_s = self
            .heard
            .clock
            .map_or(0.0, |(round_trip_s, _)| round_trip_s);
        let mut answers = Vec::new();
        self.drive(0.0, thrust, 3.0);
        for steer in [WIGGLE, -WIGGLE] {
            let samples = self.drive(steer, thrust, 2.0 + 2.0 * late_s);
            let echo = late_mean(&samples, |sample| sample.rudder_rad / full_rad);
            let rate_rad_s = late_mean(&samples, |sample| sample.yaw_rate_rad_s.unwrap_or(0.0));
            let follows = (echo - steer).abs() < ECHO;
            found.check(
                "echo",
                follows,
                format!(
                    "rudder output {echo:+.3} of full for {steer:+.3} asked{}",
                    if follows { "" } else { ": is our system id obeyed, is the mode right, is it armed, is the output reversed?" }
                ),
            );
            answers.push(rate_rad_s);
        }
        let turned_rad_s = answers[0] - answers[1];
        let sense = if self.settings.is_reversed { -1.0 } else { 1.0 };
        let tells = turned_rad_s.abs() > 2.0 * TELLING_RATE_RAD_S;
        found.check(
            "rudder sense",
            !tells || turned_rad_s * sense > 0.0,
            match tells {
                true => format!(
                    "yaw rate {:+.3} and {:+.3} rad/s to the two sides",
                    answers[0], answers[1]
                ),
                false => "too slow to tell; the trial itself watches it".into(),
            },
        );
        self.drive(0.0, 0.0, 1.0 + late_s);
    }

    /// What a lost process would do: the autopilot must let go of the rudder by itself.
    fn fall_silent(&mut self, found: &mut Preflight) {
        let late_s = self
            .heard
            .clock
            .map_or(0.0, |(round_trip_s, _)| round_trip_s);
        self.drive(WIGGLE, 0.0, 1.0 + 2.0 * late_s);
        if self.stopped.is_some() {
            return;
        }
        (self.on_guard, self.is_proving) = (false, true);
        self.demand = None;
        let start_s = self.sampler.clock_s();
        let longest_s = LONGEST_OVERRIDE_S + late_s + 0.3;
        let is_over = |autopilot: &mut Self| {
            autopilot.is_rudder_neutral() || autopilot.sampler.clock_s() - start_s > longest_s
        };
        self.wait(2.0 * longest_s + 1.0, is_over);
        let took_s = self.sampler.clock_s() - start_s;
        let lets_go = self.is_rudder_neutral();
        found.check(
            "lost process",
            lets_go,
            match lets_go {
                true => format!("without us the autopilot let go of the rudder within {took_s:.1} s"),
                false => format!(
                    "without us the autopilot still held the rudder after {took_s:.1} s, more than {NEUTRAL} of full: set its timeout and failsafe"
                ),
            },
        );
        self.ask(Demand::default());
        // Its failsafe may have changed the mode, as it should; a heartbeat tells.
        self.wait(1.2, |autopilot| autopilot.heard.is_critical());
        self.is_proving = false;
        let is_failsafe = self.heard.is_critical() || self.heard.failsafe.is_some();
        let moved = self.heard.mode().filter(|_| !is_failsafe);
        let moved = moved.filter(|mode| self.heard.our_mode.is_some_and(|ours| ours != *mode));
        if let Some(stop) = self.missed.take().or(moved.map(Stop::PilotMode)) {
            self.on_guard = true;
            self.stop_on_guard(stop);
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

//! Before the vehicle is taken: what must be so, and the proof that the rudder answers and is let go of.

use seatrial_core::Sample;

use super::{Demand, Graph, RosVehicle};
use crate::handover::{
    CONNECT_S, Check, Controls, LostProcess, Preflight, SLOWER, Wiggle, prove_rudder,
    prove_that_it_lets_go,
};

/// Time over which rates are measured, s.
const RATES_S: f64 = 2.0;
/// The clock of the stamps may run this much faster or slower than ours.
const CLOCK_RATE: f64 = 0.1;
/// A measured rudder must come at least so often in a sample: it is held from one message to the next.
const RUDDERS_PER_SAMPLE: f64 = 2.0;
/// Longest wait for the vehicle's own service, s.
const ENABLE_S: f64 = 5.0;
/// How long each side of the wiggle lasts, and the straight run before, s.
const WIGGLE_S: f64 = 1.5;
/// How long the rudder is deflected before we fall silent, s.
const DEFLECTED_S: f64 = 0.5;
/// After this and its own timeout the vehicle must have let go, s.
const LETS_GO_S: f64 = 0.5;

impl<G: Graph> RosVehicle<G> {
    /// Looks at the vehicle without touching its controls.
    pub fn inspect(&mut self) -> Preflight {
        let mut found = Preflight::begin();
        let source = match (&self.description.imu, &self.description.odometry) {
            (Some(imu), _) => imu.topic.clone(),
            (None, Some(odometry)) => odometry.topic.clone(),
            (None, None) => String::new(),
        };
        if !self.wait(CONNECT_S, |vehicle| vehicle.sampler.count > 0) {
            let way = match &self.description.zenoh {
                Some(zenoh) => format!("what is connected to {}", zenoh.endpoint),
                None => "the addresses and whether it is reliable".into(),
            };
            let text = format!(
                "nothing came on {source} for {CONNECT_S} s: check its name and type, domain {}, {way}",
                self.description.domain
            );
            found.check("samples", false, text);
            return found;
        }
        found.vehicle = format!("ROS 2, domain {}, samples of {source}", self.description.domain);
        self.check_rates(&mut found);
        let is_matched = self.wait(CONNECT_S / 2.0, |vehicle| {
            let matched = vehicle.graph.matched();
            matched.not_heard.is_empty()
                && (matched.has_enable || vehicle.description.enable.is_none())
        });
        let matched = self.graph.matched();
        let heard = match matched.not_heard.is_empty() {
            true => "somebody subscribes to rudder and thrust".into(),
            false => format!(
                "nobody subscribes to {} with this type and quality of service",
                matched.not_heard.join(" and ")
            ),
        };
        found.check("commands", matched.not_heard.is_empty(), heard);
        let alone = match matched.shared.is_empty() {
            true => "nobody else publishes rudder or thrust".into(),
            false => format!(
                "somebody else publishes on {}: both would steer; stop it, or wait until a program that was killed is forgotten",
                matched.shared.join(" and ")
            ),
        };
        found.check("alone", matched.shared.is_empty(), alone);
        if let Some(enable) = &self.description.enable {
            let text = match is_matched || matched.has_enable {
                true => format!("{} is there", enable.service),
                false => format!("the service {} is not there", enable.service),
            };
            found.check("enable", matched.has_enable, text);
        }
        let envelope = self.settings.envelope.clone();
        let text = envelope
            .clone()
            .unwrap_or_else(|| "no plan was given: its envelope must be yours".into());
        found.check("envelope", envelope.is_some(), text);
        found
    }

    fn check_rates(&mut self, found: &mut Preflight) {
        self.sampler.skip();
        let begin =
            (self.graph.now_s(), self.sampler.clock_s(), self.sampler.count, self.sampler.rudders);
        self.wait(RATES_S, |_| false);
        let (begin_s, stamp_s, count, rudders) = begin;
        let span_s = self.graph.now_s() - begin_s;
        let samples_hz = (self.sampler.count - count) as f64 / span_s;
        let wanted_hz = 1.0 / self.settings.sample_interval_s;
        let is_fast = samples_hz * SLOWER >= wanted_hz;
        let text = format!(
            "{samples_hz:.1} samples a second{}",
            match is_fast {
                true => String::new(),
                false => format!(
                    ", the plan has {wanted_hz:.1}: a faster source, or a longer sample_interval_s in the plan"
                ),
            }
        );
        found.check("samples", is_fast, text);

        self.check_clock(found, stamp_s, span_s);
        self.check_heading(found);

        let Some(feedback) = &self.description.feedback else {
            let text = "no feedback: the command is taken to be the rudder, and that the vehicle lets go of it by itself is not proven";
            found.check("rudder", true, text);
            return;
        };
        let rudders_hz = (self.sampler.rudders - rudders) as f64 / span_s;
        let is_measured = rudders_hz >= RUDDERS_PER_SAMPLE * samples_hz;
        let text = match is_measured {
            true => format!("measured {rudders_hz:.1} times a second"),
            false => format!(
                "{} has the rudder {rudders_hz:.1} times a second: expected {RUDDERS_PER_SAMPLE} in a sample, since what acts between two messages is not known; without [feedback] the command is taken",
                feedback.topic
            ),
        };
        found.check("rudder", is_measured, text);
    }

    /// `stamp_s` is where the stamps stood `span_s` ago.
    fn check_clock(&self, found: &mut Preflight, stamp_s: f64, span_s: f64) {
        let rate = (self.sampler.clock_s() - stamp_s) / span_s;
        let is_sane = (rate - 1.0).abs() < CLOCK_RATE && stamp_s > 0.0;
        let text = match is_sane {
            true => format!("stamps run {rate:.3} times as fast as our clock"),
            false => format!(
                "stamps run {rate:.3} times as fast as our clock, from {stamp_s:.3} s: expected the time of the measurement in header.stamp"
            ),
        };
        found.check("clock", is_sane, text);
    }

    fn check_heading(&mut self, found: &mut Preflight) {
        let mut newest: Option<Sample<f64>> = None;
        while let Some(sample) = self.sampler.take() {
            newest = Some(sample);
        }
        let is_oriented = newest.is_some_and(|sample| sample.heading_rad.is_finite());
        let text = match newest.filter(|_| is_oriented) {
            Some(sample) => format!(
                "{:.1} degrees, turning {:+.3} rad/s",
                sample.heading_rad.to_degrees().rem_euclid(360.0),
                sample.yaw_rate_rad_s.unwrap_or(f64::NAN)
            ),
            None => "the orientation is no unit quaternion, or said to be unknown".into(),
        };
        found.check("heading", is_oriented, text);
    }

    /// Pumps until somebody calls the enable service, or the operator gives up. `true`: agreed to.
    pub fn is_agreed_to(&mut self) -> bool {
        let abort = self.settings.abort.clone();
        let is_over = |vehicle: &mut Self| {
            vehicle.is_agreed || abort.load(std::sync::atomic::Ordering::Relaxed)
        };
        self.wait(f64::INFINITY, is_over);
        self.is_agreed
    }

    /// Takes the vehicle: has it give its controls away, proves that the rudder answers with the right sense, and, where the
    /// rudder is measured, that the vehicle lets go of it when nothing is heard from us. Unless every check passes the vehicle
    /// must be handed back.
    pub fn take_control(&mut self) -> Vec<Check> {
        let mut found = Preflight::default();
        self.is_taken = true;
        self.guard();
        if self.enable(true, ENABLE_S) == Some(false) {
            let text = "the vehicle's service did not answer, or refused";
            found.check("enable", false, text);
            return found.checks;
        }
        self.wiggle(&mut found);
        if found.is_passed() && self.description.feedback.is_some() {
            self.prove_lost_process(&mut found);
        }
        if let Some(stop) = &self.stopped {
            found.check("vehicle", false, stop.to_string());
        }
        self.sampler.skip();
        found.checks
    }

    fn guard(&mut self) {
        self.following.restart(self.graph.now_s());
        self.on_guard = true;
    }

    fn wiggle(&mut self, found: &mut Preflight) {
        let wiggle = Wiggle {
            thrust: self.settings.trying_thrust,
            straight_s: WIGGLE_S,
            side_s: WIGGLE_S,
            full_rudder_rad: self.description.rudder.limit_rad,
            is_reported: self.description.feedback.is_some(),
            is_reversed: self.settings.is_reversed,
            echo_hint: "units_per_rad and trim_units, and whether somebody else steers",
            sense_hint: "the sign of units_per_rad, the frame, or rudder_sense in the plan",
        };
        prove_rudder(self, &wiggle, found);
    }

    /// What a lost process would do: the vehicle must let go of the rudder by itself.
    fn prove_lost_process(&mut self, found: &mut Preflight) {
        let process = LostProcess {
            who: "the vehicle",
            deflected_s: DEFLECTED_S,
            longest_s: self.description.command_timeout_s + LETS_GO_S,
            remedy: "have the vehicle time out commands, and say how fast in command_timeout_s",
        };
        if prove_that_it_lets_go(self, &process, found) {
            self.ask(Demand::default());
            self.guard();
        }
    }
}

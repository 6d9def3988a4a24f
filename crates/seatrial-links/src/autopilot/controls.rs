//! An autopilot's controls, for the hand-over.

use seatrial_core::Sample;

use super::Autopilot;
use super::profile::Demand;
use crate::handover::{Controls, NEUTRAL, WAIT_S};
use crate::link::Wire;

impl<W: Wire> Controls for Autopilot<W> {
    fn now_s(&self) -> f64 {
        self.wire.now_s()
    }

    fn clock_s(&self) -> f64 {
        self.sampler.clock_s()
    }

    fn pump_until(&mut self, until_s: f64) {
        // A trial that waits is not held up.
        self.attended_s = self.wire.now_s();
        self.pump(until_s);
    }

    /// The duration is on the clock of the samples.
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
            self.pump(now_s + WAIT_S);
            while let Some(sample) = self.sampler.take() {
                samples.push(sample);
                if self.stopped.is_none() {
                    self.ask(Demand { steer, thrust });
                }
            }
            let first_s = samples.first().map(|sample| sample.time_s);
            let last_s = samples.last().map(|sample| sample.time_s);
            if first_s.zip(last_s).is_some_and(|(first, last)| last - first >= duration_s) {
                break;
            }
        }
        samples
    }

    fn fall_silent(&mut self) {
        (self.on_guard, self.is_proving) = (false, true);
        self.demand = None;
    }

    fn release(&mut self) {
        self.release_controls();
    }

    fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    fn is_rudder_neutral(&self) -> bool {
        let full_rad = self.settings.full_rudder_rad;
        self.sampler
            .last_rudder_rad()
            .is_some_and(|rudder_rad| (rudder_rad / full_rad).abs() < NEUTRAL)
    }
}

//! The controls of a vehicle on ROS 2, for the hand-over.

use seatrial_core::Sample;

use super::{Demand, Graph, RosVehicle};
use crate::handover::{Controls, NEUTRAL};

impl<G: Graph> Controls for RosVehicle<G> {
    fn now_s(&self) -> f64 {
        self.graph.now_s()
    }

    fn clock_s(&self) -> f64 {
        self.graph.now_s()
    }

    fn pump_until(&mut self, until_s: f64) {
        self.pump(until_s);
    }

    fn drive(&mut self, steer: f64, thrust: f64, duration_s: f64) -> Vec<Sample<f64>> {
        self.sampler.skip();
        let mut samples = Vec::new();
        if self.stopped.is_none() {
            self.ask(Demand { rudder_rad: steer * self.description.rudder.limit_rad, thrust });
        }
        self.wait(duration_s, |vehicle| {
            while let Some(sample) = vehicle.sampler.take() {
                samples.push(sample);
            }
            vehicle.stopped.is_some()
        });
        samples
    }

    fn fall_silent(&mut self) {
        self.demand = None;
    }

    fn release(&mut self) {
        self.graph.command(Demand::default());
        let now_s = self.graph.now_s();
        self.sampler.asked(now_s, 0.0);
        self.sampler.thrust = None;
    }

    fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    fn is_rudder_neutral(&self) -> bool {
        let near_rad = NEUTRAL * self.description.rudder.limit_rad;
        let last_rad = self.sampler.last_rudder_rad();
        last_rad.is_some_and(|rudder_rad| rudder_rad.abs() < near_rad)
    }
}

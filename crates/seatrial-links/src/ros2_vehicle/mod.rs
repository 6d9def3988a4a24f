//! Vehicles on ROS 2, as a [`Vehicle`].
//!
//! Everything passes through a [`Graph`], which also gives the time: DDS, zenoh, or a made-up vehicle in made-up time.
//! [`RosVehicle::inspect`] looks without touching, [`RosVehicle::take_control`] takes the rudder and proves that it answers,
//! [`RosVehicle::hand_back`] undoes it; so does dropping it. Whatever ends the trial from the vehicle's side, a [`Stop`], makes
//! rudder and thrust neutral as soon as it is known.

mod controls;
mod description;
mod estimates;
mod graph;
mod join;
#[cfg(any(feature = "ros2", feature = "ros2-zenoh"))]
mod middleware;
mod middleware_error;
mod preflight;
mod sampler;
mod stop;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial_core::{Action, Sample, Steering, Vehicle};
use serde::Serialize;

pub use description::{
    Actuator, Command, CommandType, Description, Enable, Feedback, FeedbackType, Frame,
    InvalidDescription, Middleware, Odometry, RudderCommand, Source, ThrustCommand, Zenoh,
    ZenohMode,
};
pub use estimates::{ESTIMATE_TOPIC, EstimateTopic, TimedEstimate};
pub use graph::{Demand, Diagnosis, Graph, GraphPeers, Heard, Motion};
pub use join::{JoinError, VehicleTopics, join};
pub use middleware_error::MiddlewareError;
pub use stop::Stop;

use crate::handover::{Controls, FOLLOWS, Following, HeadingHold, SILENCE_S, WAIT_S};
use sampler::Sampler;

/// Name, below the namespace, of the services that give the vehicle to the trial and take it back.
pub const ENABLE_SERVICE: &str = "/seatrial/enable";
/// Name of the service that ends the trial.
pub const ABORT_SERVICE: &str = "/seatrial/abort";

/// Between two looks at who subscribes and publishes, s.
const LOOK_S: f64 = 0.25;
/// Between two diagnoses, s.
const DIAGNOSE_S: f64 = 1.0;
/// Sample intervals of silence that end the trial, where they are longer than [`SILENCE_S`].
const SILENCE_INTERVALS: f64 = 3.5;
/// Longest wait for the measured rudder or a service at the hand-back, s.
const HAND_BACK_S: f64 = 2.0;

/// What is asked of a vehicle besides its description.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Time between samples, s.
    pub sample_interval_s: f64,
    /// Rudder per heading error while a heading is held.
    pub heading_gain: f64,
    /// Rudder per yaw rate while a heading is held, s.
    pub yaw_rate_gain_s: f64,
    /// Largest rudder while a heading is held, rad.
    pub heading_rudder_rad: f64,
    /// Thrust while the rudder's sense is tried, as a fraction of full.
    pub trying_thrust: f64,
    /// b2 is expected to be negative.
    pub is_reversed: bool,
    /// Limits that the trial has been given, for the preflight; `None` refuses it.
    pub envelope: Option<String>,
    /// Becomes true when the operator wants the vehicle back.
    pub abort: Arc<AtomicBool>,
}

/// What a hand-back has reached.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HandBack {
    /// The measured rudder was seen neutral; `None` where none is measured.
    pub rudder_neutral: Option<bool>,
    /// The vehicle's own service has taken the controls back; `None` where it has none.
    pub disabled: Option<bool>,
}

impl HandBack {
    /// Was everything seen that can be?
    pub fn is_complete(&self) -> bool {
        self.rudder_neutral != Some(false) && self.disabled != Some(false)
    }
}

/// A vehicle behind a graph.
pub struct RosVehicle<G: Graph> {
    graph: G,
    description: Description,
    settings: Settings,
    sampler: Sampler,
    /// What is asked for while the controls are ours.
    demand: Option<Demand>,
    demanded_s: f64,
    following: Following,
    looked_s: f64,
    diagnosed_s: f64,
    /// What the vehicle's own service has answered.
    answered: Option<bool>,
    is_agreed: bool,
    /// Does what the vehicle does end the trial?
    on_guard: bool,
    /// Has it to be given back?
    is_taken: bool,
    stopped: Option<Stop>,
    last: Option<Sample<f64>>,
}

impl<G: Graph> RosVehicle<G> {
    /// Behind this graph.
    pub fn new(graph: G, description: Description, settings: Settings) -> Self {
        let has_depth = description.odometry.as_ref().is_some_and(|odometry| odometry.depth);
        let is_measured = description.feedback.is_some();
        Self {
            sampler: Sampler::new(description.frame, has_depth, is_measured),
            graph,
            description,
            settings,
            demand: None,
            demanded_s: f64::NEG_INFINITY,
            following: Following::default(),
            looked_s: f64::NEG_INFINITY,
            diagnosed_s: f64::NEG_INFINITY,
            answered: None,
            is_agreed: false,
            on_guard: false,
            is_taken: false,
            stopped: None,
            last: None,
        }
    }

    /// Why the vehicle was given back before the end of the trial, if it was.
    pub fn stopped(&self) -> Option<&Stop> {
        self.stopped.as_ref()
    }

    /// One of our names, in the namespace of the description.
    pub fn named(&self, name: &str) -> String {
        self.description.named(name)
    }

    /// The graph.
    pub fn graph(&mut self) -> &mut G {
        &mut self.graph
    }

    /// Sends what is due, waits until a time at most, and hears what has come.
    fn pump(&mut self, until_s: f64) {
        let now_s = self.graph.now_s();
        if self.settings.abort.load(Ordering::Relaxed) {
            self.stop_on_guard(Stop::Operator);
        }
        if now_s - self.looked_s >= LOOK_S {
            self.looked_s = now_s;
            self.look();
        }
        if now_s - self.diagnosed_s >= DIAGNOSE_S {
            self.diagnose();
        }
        // Well within what the vehicle waits for.
        if now_s - self.demanded_s >= 0.25 * self.description.command_timeout_s {
            self.send_demand();
        }
        let mut heard = self.graph.receive(until_s);
        while let Some((came_s, what)) = heard {
            self.hear(came_s, what);
            heard = self.graph.receive(f64::NEG_INFINITY);
        }
    }

    fn look(&mut self) {
        if !self.on_guard {
            return;
        }
        let matched = self.graph.matched();
        if let Some(topic) = matched.not_heard.into_iter().next() {
            self.stop_on_guard(Stop::NotHeard(topic));
        }
        if let Some(topic) = matched.shared.into_iter().next() {
            self.stop_on_guard(Stop::SecondPublisher(topic));
        }
    }

    fn hear(&mut self, came_s: f64, heard: Heard) {
        match heard {
            Heard::Imu(motion) => self.hear_sample(came_s, motion),
            Heard::Odometry(motion) if self.description.imu.is_none() => {
                self.hear_sample(came_s, motion);
            }
            Heard::Odometry(motion) => self.sampler.odometry(motion),
            Heard::Rudder { stamp_s, units } => {
                if let Some(feedback) = &self.description.feedback {
                    let rudder_rad = feedback.rudder_rad(units);
                    self.sampler.measured(came_s, stamp_s, rudder_rad);
                    self.follow(came_s, rudder_rad);
                }
            }
            Heard::Abort => self.stop_on_guard(Stop::Called(self.description.named(ABORT_SERVICE))),
            Heard::Enable(true) => self.is_agreed = true,
            Heard::Enable(false) => {
                self.is_agreed = false;
                self.stop_on_guard(Stop::Called(self.description.named(ENABLE_SERVICE)));
            }
            Heard::Answered(is_done) => self.answered = Some(is_done),
        }
    }

    fn hear_sample(&mut self, came_s: f64, motion: Motion) {
        if self.sampler.is_set_back(motion.stamp_s) {
            let back_s = self.sampler.clock_s() - motion.stamp_s;
            self.stop_on_guard(Stop::ClockSetBack(back_s));
            self.sampler.forget();
        }
        self.sampler.motion(came_s, motion);
    }

    fn follow(&mut self, now_s: f64, found_rad: f64) {
        let near_rad = FOLLOWS * self.description.rudder.limit_rad;
        let Some(demand) = self.demand else {
            self.following.restart(now_s);
            return;
        };
        if self.following.is_lost(now_s, found_rad, near_rad) {
            self.stop_on_guard(Stop::NotFollowed { asked_rad: demand.rudder_rad, found_rad });
        }
    }

    fn stop_on_guard(&mut self, stop: Stop) {
        if self.on_guard && self.stopped.is_none() {
            self.stopped = Some(stop);
            self.let_go();
            self.diagnose();
        }
    }

    fn diagnose(&mut self) {
        self.diagnosed_s = self.graph.now_s();
        let stopped = self.stopped.as_ref();
        let message = match (stopped, self.demand) {
            (Some(stop), _) => format!("given back: {stop}"),
            (None, Some(_)) => "the trial has rudder and thrust".into(),
            (None, None) => "the trial does not have the controls".into(),
        };
        let number =
            |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.4}"));
        let values = vec![
            ("samples", self.sampler.count.to_string()),
            ("rudder asked for, rad", number(self.demand.map(|d| d.rudder_rad))),
            ("rudder, rad", number(self.sampler.last_rudder_rad())),
            ("thrust", number(self.demand.map(|d| d.thrust))),
        ];
        self.graph.diagnose(&Diagnosis {
            is_error: stopped.is_some_and(|stop| !stop.is_asked()),
            message,
            values,
        });
    }

    fn ask(&mut self, demand: Demand) {
        self.demand = Some(demand);
        self.sampler.thrust = Some(demand.thrust);
        self.send_demand();
    }

    fn send_demand(&mut self) {
        let Some(demand) = self.demand else {
            return;
        };
        self.graph.command(demand);
        let now_s = self.graph.now_s();
        self.demanded_s = now_s;
        self.sampler.asked(now_s, demand.rudder_rad);
        self.following.asked(now_s, demand.rudder_rad);
    }

    /// Calls the vehicle's own service until it answers or for this long. `None`: it has none.
    fn enable(&mut self, is_on: bool, longest_s: f64) -> Option<bool> {
        self.description.enable.as_ref()?;
        self.answered = None;
        self.insist(
            longest_s,
            |vehicle| vehicle.graph.enable(is_on),
            |vehicle| vehicle.answered.is_some(),
        );
        Some(self.answered == Some(true))
    }

    /// Makes rudder and thrust neutral at once.
    fn let_go(&mut self) {
        self.on_guard = false;
        if self.demand.take().is_some() {
            self.release();
        }
    }

    /// Makes rudder and thrust neutral, has the vehicle take its controls back, and looks whether it has.
    pub fn hand_back(&mut self) -> HandBack {
        self.let_go();
        let mut done = HandBack::default();
        if !self.is_taken {
            return done;
        }
        self.is_taken = false;
        self.release_repeatedly(Self::release);
        if self.description.feedback.is_some() {
            let rudders = self.sampler.rudders;
            // One that was measured after the release.
            done.rudder_neutral = Some(self.wait(HAND_BACK_S, |vehicle| {
                vehicle.sampler.rudders > rudders && vehicle.is_rudder_neutral()
            }));
        }
        done.disabled = self.enable(false, HAND_BACK_S);
        self.diagnose();
        done
    }

    fn holding_rudder_rad(&self, heading_rad: f64) -> f64 {
        let Some(sample) = &self.last else {
            return 0.0;
        };
        let hold = HeadingHold {
            gain: self.settings.heading_gain,
            yaw_rate_gain_s: self.settings.yaw_rate_gain_s,
            largest_rad: self.settings.heading_rudder_rad,
            is_reversed: self.settings.is_reversed,
        };
        let rate_rad_s = sample.yaw_rate_rad_s.unwrap_or(0.0);
        hold.rudder_rad(sample.heading_rad, rate_rad_s, heading_rad)
    }
}

impl<G: Graph> Vehicle<f64> for RosVehicle<G> {
    type Error = Stop;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Stop> {
        let longest_s = (SILENCE_INTERVALS * self.settings.sample_interval_s).max(SILENCE_S);
        let mut heard_s = self.graph.now_s();
        let mut count = self.sampler.count;
        loop {
            if let Some(stop) = self.stopped.clone().filter(|stop| !stop.is_asked()) {
                return Err(stop);
            }
            if let Some(sample) = self.sampler.take() {
                self.last = Some(sample);
                return Ok(Some(sample));
            }
            let now_s = self.graph.now_s();
            if count != self.sampler.count {
                (heard_s, count) = (now_s, self.sampler.count);
            }
            if now_s - heard_s > longest_s {
                self.stop_on_guard(Stop::Silence(now_s - heard_s));
                return Err(Stop::Silence(now_s - heard_s));
            }
            self.pump(now_s + WAIT_S);
        }
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Stop> {
        if self.stopped.is_some() || self.demand.is_none() {
            return Ok(());
        }
        if action.outcome.is_some() {
            self.let_go();
            return Ok(());
        }
        let rudder_rad = match action.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            Steering::HoldHeading(heading_rad) => self.holding_rudder_rad(heading_rad),
        };
        self.ask(Demand { rudder_rad, thrust: action.thrust.unwrap_or(0.0) });
        Ok(())
    }

    fn is_live(&self) -> bool {
        true
    }

    fn is_taken_over(&self) -> bool {
        self.stopped.as_ref().is_some_and(Stop::is_asked)
    }
}

impl<G: Graph> Drop for RosVehicle<G> {
    fn drop(&mut self) {
        self.hand_back();
    }
}

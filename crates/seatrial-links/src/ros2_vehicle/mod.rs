//! Vehicles on ROS 2, as a [`Vehicle`].
//!
//! Everything passes through a [`Graph`], which also gives the time: DDS, zenoh, or a made-up vehicle in made-up time.
//! [`RosVehicle::inspect`] looks without touching, [`RosVehicle::take_control`] takes the rudder and proves that it answers,
//! [`RosVehicle::hand_back`] undoes it; so does dropping it. Whatever ends the trial from the vehicle's side, a [`Stop`], makes
//! rudder and thrust neutral as soon as it is known.

#[cfg(feature = "ros2")]
mod dds;
mod description;
mod estimates;
mod join;
mod preflight;
mod sampler;
mod stop;
#[cfg(any(feature = "ros2", feature = "ros2-zenoh"))]
mod wire;
#[cfg(feature = "ros2-zenoh")]
mod zenoh;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};
use serde::Serialize;

#[cfg(feature = "ros2-zenoh")]
pub use self::zenoh::OverZenoh;
#[cfg(feature = "ros2")]
pub use dds::Dds;
pub use description::{
    Command, CommandType, Description, Enable, Feedback, FeedbackType, Frame, Middleware, Odometry,
    RudderCommand, Source, ThrustCommand, Zenoh, ZenohMode,
};
pub use estimates::{ESTIMATE_TOPIC, EstimateTopic, TimedEstimate};
pub use join::{JoinError, Joined, join};
pub use stop::Stop;

use sampler::Sampler;

/// Name of the services that give the vehicle to the trial and take it back.
pub const ENABLE_SERVICE: &str = "/seatrial/enable";
/// Name of the service that ends the trial.
pub const ABORT_SERVICE: &str = "/seatrial/abort";
#[cfg(any(feature = "ros2", feature = "ros2-zenoh"))]
const DIAGNOSTICS_TOPIC: &str = "/diagnostics";

/// Longest wait for something to come at a time, s.
const WAIT_S: f64 = 0.02;
/// Between two questions that are not answered, s.
const ASK_AGAIN_S: f64 = 0.3;
/// Between two looks at who subscribes and publishes, s.
const LOOK_S: f64 = 0.25;
/// Between two diagnoses, s.
const DIAGNOSE_S: f64 = 1.0;
/// Silence that ends the trial, s, or so many intervals where they are longer.
const SILENCE_S: f64 = 0.7;
const SILENCE_INTERVALS: f64 = 3.5;
/// A measured rudder this near to what was asked for follows, as a fraction of full.
const FOLLOWS: f64 = 0.15;
/// Demands so old may still be on their way to the rudder, s.
const ON_THE_WAY_S: f64 = 1.5;
/// A rudder that does not follow for so long ends the trial, s.
const NOT_FOLLOWED_S: f64 = 1.0;
/// A measured rudder this near to amidships is neutral, as a fraction of full.
const NEUTRAL: f64 = 0.05;
/// Times that the neutral command is sent, 0.1 s apart: each may be lost.
const RELEASES: u32 = 5;
/// Longest wait for the measured rudder or a service at the hand-back, s.
const HAND_BACK_S: f64 = 2.0;

/// Something that came from the vehicle or an operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// An attitude.
    Imu(Motion),
    /// An attitude with position and speed.
    Odometry(Motion),
    /// A measured rudder in the units of the description, with its stamp where it has one, s.
    Rudder {
        /// When it was measured.
        stamp_s: Option<f64>,
        /// In units of the description.
        units: f64,
    },
    /// Somebody called [`ABORT_SERVICE`].
    Abort,
    /// Somebody called [`ENABLE_SERVICE`].
    Enable(bool),
    /// The vehicle's own service has answered: has it done as it was asked?
    Answered(bool),
}

/// Where a vehicle is and how it moves, in the axes of its description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Of the message's header, s.
    pub stamp_s: f64,
    /// Attitude w, x, y, z.
    pub quaternion: [f64; 4],
    /// About the body's vertical axis, rad/s.
    pub turn_rate_rad_s: f64,
    /// x, y, z, m.
    pub position_m: Option<[f64; 3]>,
    /// Along the body's first axis, m/s.
    pub speed_m_s: Option<f64>,
}

/// What is asked of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Rudder, rad.
    pub rudder_rad: f64,
    /// Thrust as a fraction of full.
    pub thrust: f64,
}

/// Who takes our commands and who gives others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Matched {
    /// Topics of commands to which nobody subscribes.
    pub not_heard: Vec<String>,
    /// Topics of commands on which somebody else publishes.
    pub shared: Vec<String>,
    /// Is the vehicle's own service there?
    pub has_enable: bool,
}

/// How it stands, for whoever watches diagnostics.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Is the vehicle given back for a reason that nobody chose?
    pub is_error: bool,
    /// In a sentence.
    pub message: String,
    /// Names and values.
    pub values: Vec<(&'static str, String)>,
}

/// The next of what threads of a middleware have heard, with the time since the beginning when it came, s; waited for so long, s.
#[cfg(any(feature = "ros2", feature = "ros2-zenoh"))]
fn next_heard(
    heard: &std::sync::mpsc::Receiver<(std::time::Instant, Heard)>,
    begin: std::time::Instant,
    wait_s: f64,
) -> Option<(f64, Heard)> {
    let received = match std::time::Duration::try_from_secs_f64(wait_s) {
        Ok(wait) => heard.recv_timeout(wait).ok(),
        Err(_) => heard.try_recv().ok(),
    };
    let (came, heard) = received?;
    Some((came.saturating_duration_since(begin).as_secs_f64(), heard))
}

/// The topics and services of a vehicle.
pub trait Graph {
    /// Our clock, s.
    fn now_s(&self) -> f64;
    /// The next that has come, with the time on our clock when it came; waits for it until a time at most.
    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)>;
    /// Publishes a demand.
    fn command(&mut self, demand: Demand);
    /// Calls the vehicle's own service; the answer is [`Heard::Answered`].
    fn enable(&mut self, is_on: bool);
    /// Who is there?
    fn matched(&self) -> Matched;
    /// Publishes a diagnosis.
    fn diagnose(&mut self, diagnosis: &Diagnosis);
}

impl<G: Graph + ?Sized> Graph for Box<G> {
    fn now_s(&self) -> f64 {
        (**self).now_s()
    }
    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)> {
        (**self).receive(until_s)
    }
    fn command(&mut self, demand: Demand) {
        (**self).command(demand);
    }
    fn enable(&mut self, is_on: bool) {
        (**self).enable(is_on);
    }
    fn matched(&self) -> Matched {
        (**self).matched()
    }
    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        (**self).diagnose(diagnosis);
    }
}

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
    /// When what was asked for, lately.
    demands: VecDeque<(f64, f64)>,
    followed_s: f64,
    looked_s: f64,
    diagnosed_s: f64,
    /// What the vehicle's own service has answered.
    answered: Option<bool>,
    is_agreed: bool,
    /// Are the vehicle's doings a reason to give it back?
    on_guard: bool,
    /// Has it to be given back?
    is_taken: bool,
    stopped: Option<Stop>,
    last: Option<Sample<f64>>,
}

impl<G: Graph> RosVehicle<G> {
    /// Behind this graph.
    pub fn new(graph: G, description: Description, settings: Settings) -> Self {
        let has_depth = description
            .odometry
            .as_ref()
            .is_some_and(|odometry| odometry.depth);
        let is_measured = description.feedback.is_some();
        Self {
            sampler: Sampler::new(description.frame, has_depth, is_measured),
            graph,
            description,
            settings,
            demand: None,
            demanded_s: f64::NEG_INFINITY,
            demands: VecDeque::new(),
            followed_s: 0.0,
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

    /// Why the vehicle was given back, if its doings were the reason.
    pub fn stopped(&self) -> Option<&Stop> {
        self.stopped.as_ref()
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
            Heard::Abort => self.stop_on_guard(Stop::Called(ABORT_SERVICE.into())),
            Heard::Enable(true) => self.is_agreed = true,
            Heard::Enable(false) => {
                self.is_agreed = false;
                self.stop_on_guard(Stop::Called(ENABLE_SERVICE.into()));
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
        let follows = self
            .demands
            .iter()
            .any(|(_, asked_rad)| (asked_rad - found_rad).abs() < near_rad);
        if follows || self.demand.is_none() {
            self.followed_s = now_s;
        } else if now_s - self.followed_s > NOT_FOLLOWED_S {
            let asked_rad = self.demand.map_or(0.0, |demand| demand.rudder_rad);
            self.stop_on_guard(Stop::NotFollowed {
                asked_rad,
                found_rad,
            });
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
            (
                "rudder asked for, rad",
                number(self.demand.map(|d| d.rudder_rad)),
            ),
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
        self.demands.push_back((now_s, demand.rudder_rad));
        let is_old = |(asked_s, _): &(f64, f64)| now_s - asked_s > ON_THE_WAY_S;
        while self.demands.front().is_some_and(is_old) {
            self.demands.pop_front();
        }
    }

    /// Pumps until `done` or for this long on our clock. `true`: done.
    fn wait(&mut self, longest_s: f64, mut done: impl FnMut(&mut Self) -> bool) -> bool {
        let end_s = self.graph.now_s() + longest_s;
        loop {
            if done(self) {
                return true;
            }
            let now_s = self.graph.now_s();
            if now_s >= end_s {
                return false;
            }
            self.pump((now_s + WAIT_S).min(end_s));
        }
    }

    /// Calls the vehicle's own service until it answers or for this long. `None`: it has none.
    fn enable(&mut self, is_on: bool, longest_s: f64) -> Option<bool> {
        self.description.enable.as_ref()?;
        self.answered = None;
        let mut asked_s = f64::NEG_INFINITY;
        self.wait(longest_s, |vehicle| {
            if vehicle.answered.is_some() {
                return true;
            }
            let now_s = vehicle.graph.now_s();
            if now_s - asked_s >= ASK_AGAIN_S {
                asked_s = now_s;
                vehicle.graph.enable(is_on);
            }
            false
        });
        Some(self.answered == Some(true))
    }

    /// Makes rudder and thrust neutral at once.
    fn let_go(&mut self) {
        self.on_guard = false;
        if self.demand.take().is_some() {
            self.release();
        }
    }

    fn release(&mut self) {
        self.graph.command(Demand::default());
        let now_s = self.graph.now_s();
        self.sampler.asked(now_s, 0.0);
        self.sampler.thrust = None;
    }

    fn is_rudder_neutral(&self) -> bool {
        let near_rad = NEUTRAL * self.description.rudder.limit_rad;
        let last_rad = self.sampler.last_rudder_rad();
        last_rad.is_some_and(|rudder_rad| rudder_rad.abs() < near_rad)
    }

    /// Makes rudder and thrust neutral, has the vehicle take its controls back, and looks whether it has.
    pub fn hand_back(&mut self) -> HandBack {
        self.let_go();
        let mut done = HandBack::default();
        if !self.is_taken {
            return done;
        }
        self.is_taken = false;
        for _ in 0..RELEASES {
            self.release();
            self.wait(0.1, |_| false);
        }
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

    /// Our own heading hold, for a vehicle whose rudder we have: delta = -(K (psi - psi_d) + D r), within its limit.
    fn holding_rudder_rad(&self, heading_rad: f64) -> f64 {
        let Some(sample) = &self.last else {
            return 0.0;
        };
        let settings = &self.settings;
        let error_rad = Real::wrapped(sample.heading_rad - heading_rad);
        let rate_rad_s = sample.yaw_rate_rad_s.unwrap_or(0.0);
        let sense = if settings.is_reversed { -1.0 } else { 1.0 };
        let rudder_rad =
            -sense * (settings.heading_gain * error_rad + settings.yaw_rate_gain_s * rate_rad_s);
        let limit_rad = settings.heading_rudder_rad;
        if rudder_rad.is_finite() {
            rudder_rad.clamp(-limit_rad, limit_rad)
        } else {
            0.0
        }
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
        self.ask(Demand {
            rudder_rad,
            thrust: action.thrust.unwrap_or(0.0),
        });
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

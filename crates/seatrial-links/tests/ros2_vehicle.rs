//! Trials on a vehicle on ROS 2 in made-up time: what befalls it, and what it is then asked for.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::campaign::Campaign;
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::{AbortReason, List, Outcome, Plan, YawModel};
use seatrial_links::ros2_vehicle::{
    Actuator, CommandType, Demand, Description, Diagnosis, Enable, Feedback, FeedbackType, Frame,
    Graph, GraphPeers, Heard, Middleware, Motion, Odometry, RosVehicle, RudderCommand, Settings,
    Stop, ThrustCommand,
};

const INTERVAL_S: f64 = 0.05;
const STEP_S: f64 = 0.005;
const TIMEOUT_S: f64 = 0.5;
/// The heading is measured to within this, rad.
const NOISE_RAD: f64 = 0.004;
const MODEL: YawModel<f64> = YawModel { a22_per_s: -1.07, b2_per_s2: 1.08, c0_rad_per_s2: 0.012 };

/// What befalls the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mishap {
    None,
    /// It is not heard any more.
    Mute,
    /// It no longer subscribes.
    Deaf,
    /// Somebody else publishes, too.
    Shared,
    /// Its clock is set back.
    Clock,
    /// Its rudder jams.
    Jammed,
    /// Somebody calls a service.
    Abort,
    Disable,
    /// The operator stops the trial.
    Operator,
}

const MISHAPS: [Mishap; 8] = [
    Mishap::Mute,
    Mishap::Deaf,
    Mishap::Shared,
    Mishap::Clock,
    Mishap::Jammed,
    Mishap::Abort,
    Mishap::Disable,
    Mishap::Operator,
];

/// A first-order vehicle, and what it was asked for.
struct Sea {
    now_s: f64,
    next_sample_s: f64,
    clock_s: f64,
    yaw_rad: f64,
    rate_rad_s: f64,
    draws: u64,
    rudder_rad: f64,
    demand: Demand,
    demanded_s: f64,
    waiting: VecDeque<Heard>,
    mishap: Mishap,
    at_s: f64,
    has_happened: bool,
    abort: Arc<AtomicBool>,
    /// The last time that something else than neutral was asked for.
    steered_s: f64,
    enables: Vec<bool>,
    diagnoses: Vec<String>,
    /// The rudder turns against the command.
    is_reversed: bool,
    /// It does not let go by itself.
    is_endless: bool,
}

impl Sea {
    fn new(mishap: Mishap, at_s: f64, abort: &Arc<AtomicBool>) -> Self {
        Self {
            now_s: 100.0,
            next_sample_s: 100.0,
            clock_s: 1.7e9,
            yaw_rad: 0.4,
            rate_rad_s: 0.0,
            draws: 0,
            rudder_rad: 0.0,
            demand: Demand::default(),
            demanded_s: f64::NEG_INFINITY,
            waiting: VecDeque::new(),
            mishap,
            at_s,
            has_happened: false,
            abort: Arc::clone(abort),
            steered_s: 0.0,
            enables: Vec::new(),
            diagnoses: Vec::new(),
            is_reversed: false,
            is_endless: false,
        }
    }

    fn is(&self, mishap: Mishap) -> bool {
        self.has_happened && self.mishap == mishap
    }

    fn step(&mut self) {
        self.now_s += STEP_S;
        if self.now_s >= self.at_s && !self.has_happened {
            self.has_happened = true;
            match self.mishap {
                Mishap::Clock => self.clock_s -= 50.0,
                Mishap::Abort => self.waiting.push_back(Heard::Abort),
                Mishap::Disable => self.waiting.push_back(Heard::Enable(false)),
                Mishap::Operator => self.abort.store(true, Ordering::Relaxed),
                _ => {}
            }
        }
        let is_silent = self.now_s - self.demanded_s > TIMEOUT_S;
        if !self.is(Mishap::Jammed) {
            let sign = if self.is_reversed { -1.0 } else { 1.0 };
            self.rudder_rad = match is_silent && !self.is_endless {
                true => 0.0,
                false => sign * self.demand.rudder_rad,
            };
        }
        let acceleration = MODEL.a22_per_s * self.rate_rad_s
            + MODEL.b2_per_s2 * self.rudder_rad
            + MODEL.c0_rad_per_s2;
        self.yaw_rad -= (self.rate_rad_s + 0.5 * STEP_S * acceleration) * STEP_S;
        self.rate_rad_s += acceleration * STEP_S;
        if self.is(Mishap::Mute) {
            return;
        }
        let stamp_s = self.clock_s + self.now_s;
        self.waiting.push_back(Heard::Rudder {
            stamp_s: Some(stamp_s),
            units: -self.rudder_rad.to_degrees(),
        });
        if self.now_s >= self.next_sample_s {
            self.next_sample_s += INTERVAL_S;
            self.draws += 1;
            // The golden ratio's multiples are spread evenly, and none follows from the one before.
            let draw = (self.draws.pow(2) as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
            let half = 0.5 * (self.yaw_rad + 2.0 * NOISE_RAD * draw);
            self.waiting.push_back(Heard::Odometry(Motion {
                stamp_s,
                quaternion: [half.cos(), 0.0, 0.0, half.sin()],
                turn_rate_rad_s: -self.rate_rad_s,
                position_m: Some([3.0, 4.0, -5.0]),
                speed_m_s: Some(1.2 * self.demand.thrust),
            }));
        }
    }
}

impl Graph for Sea {
    fn now_s(&self) -> f64 {
        self.now_s
    }

    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)> {
        while self.waiting.is_empty() && self.now_s < until_s {
            self.step();
        }
        Some((self.now_s, self.waiting.pop_front()?))
    }

    fn command(&mut self, demand: Demand) {
        if demand != Demand::default() {
            self.steered_s = self.now_s;
        }
        self.demand = demand;
        self.demanded_s = self.now_s;
    }

    fn enable(&mut self, is_on: bool) {
        self.enables.push(is_on);
        self.waiting.push_back(Heard::Answered(true));
    }

    fn matched(&self) -> GraphPeers {
        let command = || vec!["/rudder".to_string()];
        GraphPeers {
            not_heard: if self.is(Mishap::Deaf) { command() } else { Vec::new() },
            shared: if self.is(Mishap::Shared) { command() } else { Vec::new() },
            has_enable: true,
        }
    }

    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        self.diagnoses.push(diagnosis.message.clone());
    }
}

fn description() -> Description {
    Description {
        domain: 0,
        namespace: String::new(),
        addresses: Vec::new(),
        zenoh: None,
        listens_on_all_addresses: false,
        services: Middleware::FastRtps,
        frame: Frame::Enu,
        command_timeout_s: TIMEOUT_S,
        odometry: Some(Odometry { topic: "/odom".into(), reliable: false, depth: true }),
        imu: None,
        rudder: RudderCommand {
            topic: Some("/rudder".into()),
            kind: CommandType::Float64,
            field: None,
            units_per_rad: -57.3,
            trim_units: 0.0,
            limit_rad: 0.4,
        },
        thrust: Some(ThrustCommand {
            topic: "/thrust".into(),
            kind: CommandType::Float64,
            field: None,
            units_at_full: 1.0,
            neutral_units: 0.0,
        }),
        actuators: BTreeMap::new(),
        feedback: Some(Feedback {
            topic: "/joint_states".into(),
            kind: FeedbackType::JointState,
            joint: Some("rudder".into()),
            units_per_rad: -(1_f64.to_degrees()),
            trim_units: 0.0,
            reliable: false,
        }),
        enable: Some(Enable { service: "/boat/enable".into() }),
    }
}

fn plan() -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[0.6]).unwrap(), ..Plan::paper() }
}

fn vehicle(mishap: Mishap, at_s: f64) -> RosVehicle<Sea> {
    let abort = Arc::new(AtomicBool::new(false));
    let settings = Settings {
        sample_interval_s: INTERVAL_S,
        heading_gain: 0.4,
        yaw_rate_gain_s: 0.4,
        heading_rudder_rad: 0.2,
        trying_thrust: 0.6,
        is_reversed: false,
        envelope: Some("in these tests".into()),
        abort: Arc::clone(&abort),
    };
    RosVehicle::new(Sea::new(mishap, at_s, &abort), description(), settings)
}

fn about() -> Campaign {
    Campaign::of("ros2", &Plan::paper())
}

/// Looked at and taken.
fn taken(mishap: Mishap, at_s: f64) -> RosVehicle<Sea> {
    let mut vehicle = vehicle(mishap, at_s);
    let preflight = vehicle.inspect();
    assert!(preflight.is_passed(), "{preflight:?}");
    assert_eq!(vehicle.graph().steered_s, 0.0, "a look touches nothing");
    let checks = vehicle.take_control();
    assert!(checks.iter().all(|check| check.passed), "{checks:?}");
    vehicle
}

#[test]
fn recover_the_model_of_a_vehicle_on_ros_2() {
    let mut vehicle = taken(Mishap::None, 1e9);
    let conducted = conduct(&mut vehicle, plan(), about(), &mut NoWatch).unwrap();
    assert_eq!(conducted.fault, None);
    let campaign = conducted.campaign;
    assert_eq!(campaign.outcome, Some(Outcome::Finished));
    let run = &campaign.runs[0];
    let found = run.identification.as_ref().unwrap().model();
    for (found, truth) in found.theta().into_iter().zip(MODEL.theta()) {
        // What the noise of the heading leaves of 16 s; a sample too early or too late would be 8 %.
        assert!((found / truth - 1.0).abs() < 0.05, "{found} {truth}");
    }
    let sample = run.record.samples[0];
    assert_eq!(sample.north_m, Some(4.0));
    assert_eq!(sample.east_m, Some(3.0));
    assert_eq!(sample.depth_m, Some(5.0));
    let done = vehicle.hand_back();
    assert!(done.is_complete() && done.rudder_neutral == Some(true));
    assert_eq!(vehicle.graph().demand, Demand::default());
    assert_eq!(vehicle.graph().enables, [true, false]);
}

/// Whatever befalls the vehicle at whatever time: rudder and thrust are neutral within a second of what can be known, the
/// vehicle's service takes the controls back, and what was measured until then is kept.
#[test]
fn io_every_mishap_ends_in_a_hand_back() {
    for mishap in MISHAPS {
        // While it settles, in the training doublet, in the doublet of the validation.
        for after_s in [6.0, 14.5, 31.0] {
            let mut vehicle = taken(mishap, 1e9);
            let begin_s = vehicle.graph().now_s;
            vehicle.graph().at_s = begin_s + after_s;
            let conducted = conduct(&mut vehicle, plan(), about(), &mut NoWatch).unwrap();
            let outcome = conducted.campaign.outcome;
            let kept: usize =
                conducted.campaign.runs.iter().map(|run| run.record.samples.len()).sum();
            let asked = [Mishap::Abort, Mishap::Disable, Mishap::Operator].contains(&mishap);
            let reason = match asked {
                true => AbortReason::Operator,
                false => AbortReason::LinkLost,
            };
            let at = format!("{mishap:?} after {after_s} s");
            assert_eq!(outcome, Some(Outcome::Aborted(reason)), "{at}");
            let stop = vehicle.stopped().cloned();
            let is_right = match mishap {
                Mishap::Mute => matches!(stop, Some(Stop::Silence(_))),
                Mishap::Deaf => matches!(stop, Some(Stop::NotHeard(_))),
                Mishap::Shared => matches!(stop, Some(Stop::SecondPublisher(_))),
                Mishap::Clock => matches!(stop, Some(Stop::ClockSetBack(_))),
                Mishap::Jammed => matches!(stop, Some(Stop::NotFollowed { .. })),
                _ => stop.as_ref().is_some_and(Stop::is_asked),
            };
            // A jam can only be told once another rudder is asked for.
            assert!(is_right || mishap == Mishap::Jammed, "{at}: {stop:?}");
            let known_s = match mishap {
                // 0.7 s of silence are the way to know it.
                Mishap::Mute => 0.75,
                Mishap::Jammed => 20.0,
                _ => 0.3,
            };
            let sea = vehicle.graph();
            assert!(
                sea.steered_s - sea.at_s <= known_s,
                "{at}: steered until {:.2} s after it",
                sea.steered_s - sea.at_s
            );
            assert!(kept as f64 > 0.9 * after_s / INTERVAL_S, "{at}: {kept} samples");
            vehicle.hand_back();
            let sea = vehicle.graph();
            assert_eq!(sea.demand, Demand::default(), "{at}");
            assert_eq!(sea.enables.first(), Some(&true), "{at}");
            assert_eq!(sea.enables.last(), Some(&false), "{at}");
        }
    }
}

#[test]
fn io_a_vehicle_that_steers_wrongly_is_refused() {
    for (name, change) in [
        ("rudder sense", (|sea| sea.is_reversed = true) as fn(&mut Sea)),
        ("lost process", |sea| sea.is_endless = true),
    ] {
        let mut vehicle = vehicle(Mishap::None, 1e9);
        change(vehicle.graph());
        assert!(vehicle.inspect().is_passed());
        let checks = vehicle.take_control();
        let refused: Vec<&str> =
            checks.iter().filter(|check| !check.passed).map(|check| check.name.as_str()).collect();
        assert!(refused.contains(&name), "{checks:?}");
        vehicle.hand_back();
        assert_eq!(vehicle.graph().demand, Demand::default());
        assert_eq!(vehicle.graph().enables.last(), Some(&false));
    }
}

#[test]
fn io_a_vehicle_that_cannot_be_used_is_refused_untouched() {
    for (mishap, name) in
        [(Mishap::Mute, "samples"), (Mishap::Deaf, "commands"), (Mishap::Shared, "alone")]
    {
        let mut vehicle = vehicle(mishap, 0.0);
        let preflight = vehicle.inspect();
        let refused = preflight.checks.iter().find(|check| !check.passed);
        assert_eq!(refused.map(|check| check.name.as_str()), Some(name), "{preflight:?}");
        vehicle.hand_back();
        assert_eq!(vehicle.graph().steered_s, 0.0);
        assert!(vehicle.graph().enables.is_empty());
    }
}

/// Signs and units of commands, two of them in one message.
#[test]
fn exact_commands_are_in_the_units_of_the_description() {
    let mut description = description();
    description.rudder.units_per_rad = -100.0;
    description.rudder.trim_units = 2.0;
    let thrust = description.thrust.as_mut().unwrap();
    (thrust.units_at_full, thrust.neutral_units) = (1900.0, 1500.0);
    let demand = Demand { rudder_rad: 0.25, thrust: 0.5 };
    assert_eq!(
        numbers(&description, demand),
        [("/rudder".into(), vec![-23.0]), ("/thrust".into(), vec![1700.0])]
    );
    description.rudder.topic = Some("/cmd_vel".into());
    description.rudder.kind = CommandType::Twist;
    let thrust = description.thrust.as_mut().unwrap();
    (thrust.topic, thrust.kind) = ("/cmd_vel".into(), CommandType::Twist);
    assert_eq!(description.check(), Ok(()));
    let commands = description.commands(demand);
    assert_eq!(commands.len(), 1);
    assert_eq!(commands[0].numbers, [1700.0, 0.0, 0.0, 0.0, 0.0, -23.0]);
    // More than full is full.
    let full = Demand { rudder_rad: 9.0, thrust: 9.0 };
    assert_eq!(description.commands(full)[0].numbers[5], 2.0 - 100.0 * 0.4);
    assert_eq!(description.commands(full)[0].numbers[0], 1900.0);
}

fn numbers(description: &Description, demand: Demand) -> Vec<(String, Vec<f64>)> {
    let commands = description.commands(demand).into_iter();
    commands.map(|command| (command.topic, command.numbers)).collect()
}

/// A boat that steers by its two thrusters, and a pair of fins that turn opposite ways, in one message.
#[test]
fn exact_thrusters_and_fins_are_commanded_together() {
    let mut description: Description = toml::from_str(
        "command_timeout_s = 0.5
        odometry.topic = '/odom'
        rudder.limit_rad = 0.4
        [actuators.left]
        topic = '/left'
        units_per_rad = 100.0
        units_at_full = 250.0
        [actuators.right]
        topic = '/right'
        units_per_rad = -100.0
        units_at_full = 250.0
        [actuators.upper_fin]
        topic = '/fins'
        type = 'std_msgs/Float64MultiArray'
        field = 'data[0]'
        units_per_rad = 1.0
        [actuators.lower_fin]
        topic = '/fins'
        type = 'std_msgs/Float64MultiArray'
        field = 'data[1]'
        units_per_rad = -1.0
        neutral_units = 0.5
        ",
    )
    .unwrap();
    assert_eq!(description.check(), Ok(()));
    let demand = Demand { rudder_rad: 0.25, thrust: 0.5 };
    assert_eq!(
        numbers(&description, demand),
        [
            ("/fins".into(), vec![0.25, 0.25]),
            ("/left".into(), vec![150.0]),
            ("/right".into(), vec![100.0])
        ]
    );
    description.actuators.retain(|name, _| name.ends_with("fin"));
    let error = description.check().unwrap_err().to_string();
    assert!(error.contains("nothing drives"), "{error}");
    let fin = description.actuators["upper_fin"].clone();
    let twice = Actuator { units_at_full: Some(1.0), ..fin };
    description.actuators.insert("third".into(), twice);
    let error = description.check().unwrap_err().to_string();
    assert!(error.contains("different fields"), "{error}");
}

#[test]
fn io_a_description_that_makes_no_sense_is_refused() {
    let error_of = |change: fn(&mut Description)| {
        let mut description = description();
        change(&mut description);
        description.check().unwrap_err().to_string()
    };
    for (expected, error) in [
        ("rudder.topic", error_of(|d| d.rudder.topic = Some("rudder".into()))),
        ("enable.service", error_of(|d| d.enable = Some(Enable { service: "/a//b".into() }))),
        ("rudder.field", error_of(|d| d.rudder.field = Some("angular.z".into()))),
        ("the same type", error_of(|d| d.thrust.as_mut().unwrap().topic = "/rudder".into())),
        ("nothing drives", error_of(|d| d.thrust = None)),
        ("nothing steers", error_of(|d| d.rudder.topic = None)),
        ("namespace", error_of(|d| d.namespace = "boat".into())),
        ("[odometry] or [imu]", error_of(|d| d.odometry = None)),
        ("feedback.joint", error_of(|d| d.feedback.as_mut().unwrap().joint = None)),
        ("rudder.units_per_rad", error_of(|d| d.rudder.units_per_rad = 0.0)),
        ("command_timeout_s", error_of(|d| d.command_timeout_s = f64::NAN)),
        ("domain", error_of(|d| d.domain = 200)),
        ("neutral_units", error_of(|d| d.thrust.as_mut().unwrap().neutral_units = 1.0)),
    ] {
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

//! Vehicles on ROS 2: what a file says of them, what is told before one is taken, the hand-back.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial_core::{Plan, RudderSense};
use seatrial_io::RowWriter;
use seatrial_io::autopilot::Preflight;
use seatrial_io::ros2_vehicle::{
    Description, ENABLE_SERVICE, Graph, HandBack, RosVehicle, Settings, Zenoh,
};

use crate::autopilot::{limits, line, refuse, text};
use crate::output::{Failure, say};

/// A vehicle on ROS 2.
pub type OnRos2 = RosVehicle<Box<dyn Graph>>;

/// A vehicle's domain, and where estimates are shown in it.
type Joined = (Box<dyn Graph>, Box<dyn RowWriter>);

/// Rudder per heading error and per yaw rate while a heading is held, and its share of the plan's largest rudder.
const HEADING_GAIN: f64 = 0.4;
const YAW_RATE_GAIN_S: f64 = 0.4;
const HEADING_RUDDER: f64 = 0.8;

/// The vehicle of a file, and where estimates are shown.
fn open(
    path: &Path,
    plan: &Plan<f64>,
    is_given: bool,
    abort: &Arc<AtomicBool>,
) -> Result<(OnRos2, Box<dyn RowWriter>), Failure> {
    let wrong = |error: String| Failure::input(format!("{}: {error}", path.display()));
    let read = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let description: Description =
        toml::from_str(&read).map_err(|error| wrong(format!("not a vehicle on ROS 2: {error}")))?;
    description.check().map_err(wrong)?;
    if plan.rudder_limit_rad > description.rudder.limit_rad {
        return Err(Failure::usage(format!(
            "the plan's rudder_limit_rad is {} rad, more than rudder.limit_rad, {} rad, of {}",
            plan.rudder_limit_rad,
            description.rudder.limit_rad,
            path.display()
        )));
    }
    let settings = Settings {
        sample_interval_s: plan.sample_interval_s,
        heading_gain: HEADING_GAIN,
        yaw_rate_gain_s: YAW_RATE_GAIN_S,
        heading_rudder_rad: HEADING_RUDDER * plan.rudder_limit_rad,
        trying_thrust: plan.thrusts.first().copied().unwrap_or_default(),
        is_reversed: plan.envelope.rudder_sense == RudderSense::Negative,
        envelope: is_given.then(|| limits(plan)),
        abort: Arc::clone(abort),
    };
    let (graph, estimates) = join(path, &description)?;
    Ok((RosVehicle::new(graph, description, settings), estimates))
}

/// Joins the domain of a vehicle.
fn join(path: &Path, description: &Description) -> Result<Joined, Failure> {
    let (feature, joined) = match &description.zenoh {
        None => ("ros2", over_dds(description)),
        Some(zenoh) => ("ros2-zenoh", over_zenoh(description, zenoh)),
    };
    let missing = || {
        Failure::usage(format!(
            "--vehicle ros2:{}: this seatrial was built without; build it with --features {feature}",
            path.display()
        ))
    };
    let joined = joined.ok_or_else(missing)?;
    joined.map_err(|error| Failure::input(format!("{}: {error}", path.display())))
}

#[cfg(feature = "ros2")]
fn over_dds(description: &Description) -> Option<Result<Joined, String>> {
    let joined = seatrial_io::ros2_vehicle::Dds::open(description.clone()).and_then(|mut graph| {
        let estimates = graph.estimates()?;
        Ok((Box::new(graph) as _, Box::new(estimates) as _))
    });
    Some(joined)
}

#[cfg(not(feature = "ros2"))]
fn over_dds(_description: &Description) -> Option<Result<Joined, String>> {
    None
}

#[cfg(feature = "ros2-zenoh")]
fn over_zenoh(description: &Description, zenoh: &Zenoh) -> Option<Result<Joined, String>> {
    let opened = seatrial_io::ros2_vehicle::OverZenoh::open(description.clone(), zenoh);
    let joined = opened.and_then(|mut graph| {
        let estimates = graph.estimates()?;
        Ok((Box::new(graph) as _, Box::new(estimates) as _))
    });
    Some(joined)
}

#[cfg(not(feature = "ros2-zenoh"))]
fn over_zenoh(_description: &Description, _zenoh: &Zenoh) -> Option<Result<Joined, String>> {
    None
}

/// Looks at the vehicle of a file.
pub fn inspect(path: &Path, plan: &Plan<f64>, is_given: bool) -> Result<Preflight, Failure> {
    let (mut vehicle, _) = open(path, plan, is_given, &Arc::default())?;
    Ok(vehicle.inspect())
}

/// Looks at the vehicle of a file, has somebody agree, and takes it. Whatever fails, it is handed back.
pub fn take(
    path: &Path,
    plan: &Plan<f64>,
    is_given: bool,
    is_agreed: bool,
    abort: &Arc<AtomicBool>,
) -> Result<(OnRos2, Box<dyn RowWriter>), Failure> {
    let (mut vehicle, estimates) = open(path, plan, is_given, abort)?;
    let preflight = vehicle.inspect();
    text(&preflight).lines().for_each(say);
    refuse(&preflight.checks)?;
    if !is_agreed {
        say(format!(
            "the vehicle will move; agree to it by calling {ENABLE_SERVICE} (std_srvs/SetBool) with true"
        ));
        if !vehicle.is_agreed_to() {
            return Err(Failure::aborted("not agreed to; nothing was moved"));
        }
    }
    let checks = vehicle.take_control();
    checks.iter().map(line).for_each(say);
    if let Err(failure) = refuse(&checks) {
        hand_back(&mut vehicle).iter().for_each(say);
        return Err(failure);
    }
    Ok((vehicle, estimates))
}

/// Hands a vehicle back; what could not be seen of it.
pub fn hand_back(vehicle: &mut OnRos2) -> Option<String> {
    let done = vehicle.hand_back();
    if let Some(stop) = vehicle.stopped().filter(|stop| stop.is_asked()) {
        say(stop);
    }
    say(told(&done));
    let incomplete = "the vehicle was not seen to take its rudder back: look after it";
    (!done.is_complete()).then(|| incomplete.into())
}

/// A hand-back for people.
fn told(done: &HandBack) -> String {
    let rudder = match done.rudder_neutral {
        Some(true) => "seen neutral",
        Some(false) => "NOT SEEN NEUTRAL",
        None => "asked to be neutral, not measured",
    };
    let controls = match done.disabled {
        Some(true) => "; the vehicle has taken its controls back",
        Some(false) => "; the vehicle has NOT ANSWERED that it takes its controls back",
        None => "",
    };
    format!("handed back: thrust asked to be neutral; rudder {rudder}{controls}")
}

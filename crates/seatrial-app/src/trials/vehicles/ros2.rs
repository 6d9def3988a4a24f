//! Vehicles on ROS 2: their description file, preflight, taking one, handing it back.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::FullRudder;
use seatrial::preview::{Budget, Prior};
use seatrial_core::{Plan, RudderSense};
use seatrial_links::ros2_vehicle::{
    self, Description, ENABLE_SERVICE, EstimateTopic, Graph, HandBack, JoinError, Settings,
    TimedEstimate, join,
};
use seatrial_logs::{Row, RowWriter};

use super::attendant::tell_all;
use super::{Attendant, limits, no_prior, refuse};
use crate::trials::order::{Preflight, Terms, TrialVehicle, VehicleError, VehicleLease, taken};

type RosVehicle = ros2_vehicle::RosVehicle<Box<dyn Graph>>;

/// Rows of a trial that go to the topic of estimates.
struct Estimates(EstimateTopic);

impl RowWriter for Estimates {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        let Some(estimate) = row.estimate else {
            return Ok(());
        };
        self.0.publish(&TimedEstimate {
            time_s: row.sample.time_s,
            model: estimate.model,
            half_widths: estimate.half_widths,
            step_norm: estimate.step_norm,
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(())
    }
}

/// Rudder per heading error and per yaw rate while a heading is held, and its share of the plan's largest rudder.
const HEADING_GAIN: f64 = 0.4;
const YAW_RATE_GAIN_S: f64 = 0.4;
const HEADING_RUDDER: f64 = 0.8;

/// What a file says of its vehicle.
fn described(path: &Path) -> Result<Description, VehicleError> {
    let wrong = |error: String| VehicleError::unreachable(format!("{}: {error}", path.display()));
    let read = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let description: Description =
        toml::from_str(&read).map_err(|error| wrong(format!("not a vehicle on ROS 2: {error}")))?;
    description.check().map_err(|error| wrong(error.to_string()))?;
    Ok(description)
}

/// The vehicle of a file, and where estimates are shown.
fn open(
    path: &Path,
    plan: &Plan<f64>,
    is_given: bool,
    abort: &Arc<AtomicBool>,
) -> Result<(RosVehicle, Box<dyn RowWriter>), VehicleError> {
    let description = described(path)?;
    if plan.rudder_limit_rad > description.rudder.limit_rad {
        return Err(VehicleError::setting(format!(
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
    let (graph, estimates) = join(&description).map_err(|error| match error {
        JoinError::NotBuilt { .. } => {
            VehicleError::setting(format!("--vehicle ros2:{}: {error}", path.display()))
        }
        JoinError::Middleware(error) => {
            VehicleError::unreachable(format!("{}: {error}", path.display()))
        }
    })?;
    let vehicle = RosVehicle::new(graph, description, settings);
    Ok((vehicle, Box::new(Estimates(estimates))))
}

/// Looks at the vehicle of a file.
pub fn inspect(path: &Path, plan: &Plan<f64>, is_given: bool) -> Result<Preflight, VehicleError> {
    let (mut vehicle, _) = open(path, plan, is_given, &Arc::default())?;
    Ok(vehicle.inspect())
}

/// A vehicle described by a file that trials may be run on.
pub struct OnRos2 {
    name: String,
    file: PathBuf,
    attendant: Arc<dyn Attendant>,
}

impl OnRos2 {
    /// The vehicle of a file.
    pub fn new(name: &str, file: &str, attendant: Arc<dyn Attendant>) -> Self {
        Self { name: name.into(), file: file.into(), attendant }
    }

    /// Looks at the vehicle, has somebody agree, and takes it. Whatever fails, it is handed back.
    fn taken(&self, terms: &Terms) -> Result<(RosVehicle, Box<dyn RowWriter>), VehicleError> {
        let (mut vehicle, estimates) =
            open(&self.file, terms.plan, terms.plan_is_given, terms.stop)?;
        let preflight = vehicle.inspect();
        let attendant = self.attendant.as_ref();
        tell_all(attendant, &preflight);
        refuse(&preflight.checks)?;
        if !terms.is_agreed {
            attendant.tell(&format!(
                "the vehicle will move; agree to it by calling {} (std_srvs/SetBool) with true",
                vehicle.named(ENABLE_SERVICE)
            ));
            if !vehicle.is_agreed_to() {
                return Err(VehicleError::refused("not agreed to; nothing was moved"));
            }
        }
        let checks = vehicle.take_control();
        checks.iter().for_each(|check| attendant.check(check));
        if let Err(refused) = refuse(&checks) {
            let left = hand_back(&mut vehicle, attendant);
            left.iter().for_each(|line| attendant.tell(line));
            return Err(refused);
        }
        Ok((vehicle, estimates))
    }
}

impl TrialVehicle for OnRos2 {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &str {
        "a vehicle on ROS 2: it moves"
    }

    fn is_simulated(&self) -> bool {
        false
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        let description = described(&self.file).ok()?;
        Some(FullRudder { angle_rad: description.rudder.limit_rad, is_assumed: false })
    }

    fn prior(&self, _: &Plan<f64>, _: &Budget) -> Result<Prior, VehicleError> {
        no_prior(&self.name)
    }

    fn inspect(&self, plan: &Plan<f64>) -> Result<Preflight, VehicleError> {
        inspect(&self.file, plan, true)
    }

    fn take(&self, terms: &Terms) -> Result<Box<dyn VehicleLease>, VehicleError> {
        let (vehicle, estimates) = self.taken(terms)?;
        let attendant = Arc::clone(&self.attendant);
        let hand_back = move |vehicle: &mut _| hand_back(vehicle, attendant.as_ref());
        Ok(taken(vehicle, hand_back, Some(estimates), None))
    }
}

/// Hands a vehicle back; what was not seen to be put back.
fn hand_back(vehicle: &mut RosVehicle, attendant: &dyn Attendant) -> Option<String> {
    let done = vehicle.hand_back();
    if let Some(stop) = vehicle.stopped().filter(|stop| stop.is_asked()) {
        attendant.tell(&stop.to_string());
    }
    attendant.tell(&hand_back_text(&done));
    let incomplete = "the vehicle was not seen to take its rudder back: look after it";
    (!done.is_complete()).then(|| incomplete.into())
}

/// A hand-back for people.
fn hand_back_text(done: &HandBack) -> String {
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

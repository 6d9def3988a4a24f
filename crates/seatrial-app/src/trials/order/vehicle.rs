//! Vehicles as a trial sees them: before it has taken one, and until it hands it back.

use std::fmt::{self, Display};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::FullRudder;
use seatrial::preview::{Budget, Preview, Prior, preview_within};
use seatrial_core::{AbortReason, Action, Axis, Outcome, Plan, Sample, Vehicle};
use seatrial_links::handover::Preflight;
use seatrial_logs::RowWriter;

use crate::Error;

/// A vehicle that a trial can be run on: a simulator, an autopilot, a graph of topics. Whoever links the crates of a kind
/// of vehicle provides it.
pub trait TrialVehicle: Send + Sync {
    /// `sim:starfish`, `mavlink:udp:0.0.0.0:14550`.
    fn name(&self) -> &str;

    /// What it is, for people.
    fn description(&self) -> &str;

    /// Is it a simulator? Anything else moves.
    fn is_simulated(&self) -> bool;

    /// Can it be steered on this axis?
    fn has_axis(&self, axis: Axis) -> bool {
        axis.is_yaw()
    }

    /// Its rudder at full steering, where it is known or had to be assumed.
    fn full_rudder(&self) -> Option<FullRudder>;

    /// Time constant with which its rudder follows the command that it reports, s, where it knows it; 0 where it does not, or reports the
    /// rudder itself.
    fn rudder_lag_s(&self) -> f64 {
        0.0
    }

    /// The file of the faults that it meets, where it is simulated with any.
    fn scenario(&self) -> Option<String> {
        None
    }

    /// What is believed of it before its trial, as long as the budget is wanted.
    fn prior(&self, plan: &Plan<f64>, budget: &Budget) -> Result<Prior, VehicleError>;

    /// Looks whether it would refuse a trial, without touching its controls.
    fn inspect(&self, plan: &Plan<f64>) -> Result<Preflight, VehicleError>;

    /// Takes it for a trial. Where this fails, it has been handed back.
    fn take(&self, terms: &Terms) -> Result<Box<dyn VehicleLease>, VehicleError>;
}

/// What a vehicle is taken for.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// The plan of the trial.
    pub plan: &'a Plan<f64>,
    /// Was the plan given, or is it the default?
    pub plan_is_given: bool,
    /// Seed of a simulated vehicle.
    pub seed: u64,
    /// Has somebody agreed that the vehicle moves? If not, the vehicle's own way to ask is used.
    pub is_agreed: bool,
    /// Set when the operator wants the vehicle back.
    pub stop: &'a Arc<AtomicBool>,
}

/// A vehicle that a trial has taken, until it is handed back.
pub trait VehicleLease: Vehicle<f64, Error = VehicleFault> {
    /// Hands it back; what could not be put back.
    fn hand_back(&mut self) -> Option<String>;

    /// Where the vehicle itself shows the estimates of its trial.
    fn rows(&mut self) -> Option<Box<dyn RowWriter>> {
        None
    }

    /// What its autopilot says that it runs.
    fn firmware(&self) -> Option<String> {
        None
    }
}

/// What went wrong with a vehicle during its trial.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct VehicleFault(String);

/// Why a vehicle cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VehicleError {
    /// Its name, a setting or the plan does not fit it.
    #[error("{0}")]
    Setting(String),
    /// The vehicle cannot be read, made or reached.
    #[error("{0}")]
    Unreachable(String),
    /// It, or whoever was asked, refused the trial; nothing was changed or all was put back.
    #[error("{0}")]
    Refused(String),
    /// A fault of the program or of its machine.
    #[error("{0}")]
    Internal(String),
}

impl From<VehicleError> for Error {
    fn from(error: VehicleError) -> Self {
        match error {
            VehicleError::Setting(message) => Self::Setting(message),
            VehicleError::Unreachable(message) => Self::Input(message),
            VehicleError::Refused(message) | VehicleError::Internal(message) => {
                Self::Rejected(message)
            }
        }
    }
}

impl VehicleError {
    /// Its name, a setting or the plan does not fit it.
    pub fn setting(message: impl Display) -> Self {
        Self::Setting(message.to_string())
    }

    /// The vehicle cannot be read, made or reached.
    pub fn unreachable(message: impl Display) -> Self {
        Self::Unreachable(message.to_string())
    }

    /// It, or whoever was asked, refused the trial.
    pub fn refused(message: impl Display) -> Self {
        Self::Refused(message.to_string())
    }

    /// A fault of the program or of its machine.
    pub fn internal(message: impl Display) -> Self {
        Self::Internal(message.to_string())
    }
}

/// A vehicle with the function that hands it back, where it shows estimates, and what its autopilot says that it runs.
pub fn taken<V>(
    vehicle: V,
    hand_back: impl FnMut(&mut V) -> Option<String> + 'static,
    rows: Option<Box<dyn RowWriter>>,
    firmware: Option<String>,
) -> Box<dyn VehicleLease>
where
    V: Vehicle<f64> + 'static,
    V::Error: Display,
{
    Box::new(Lease { vehicle, hand_back, rows, firmware })
}

struct Lease<V, H> {
    vehicle: V,
    hand_back: H,
    rows: Option<Box<dyn RowWriter>>,
    firmware: Option<String>,
}

impl<V: Vehicle<f64>, H> Vehicle<f64> for Lease<V, H>
where
    V::Error: Display,
{
    type Error = VehicleFault;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, VehicleFault> {
        self.vehicle.next_sample().map_err(fault)
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), VehicleFault> {
        self.vehicle.act(action).map_err(fault)
    }

    fn is_live(&self) -> bool {
        self.vehicle.is_live()
    }

    fn is_taken_over(&self) -> bool {
        self.vehicle.is_taken_over()
    }

    fn ended_for(&self) -> Option<AbortReason> {
        self.vehicle.ended_for()
    }
}

fn fault(error: impl Display) -> VehicleFault {
    VehicleFault(error.to_string())
}

impl<V, H> VehicleLease for Lease<V, H>
where
    V: Vehicle<f64>,
    V::Error: Display,
    H: FnMut(&mut V) -> Option<String>,
{
    fn hand_back(&mut self) -> Option<String> {
        (self.hand_back)(&mut self.vehicle)
    }

    fn rows(&mut self) -> Option<Box<dyn RowWriter>> {
        self.rows.take()
    }

    fn firmware(&self) -> Option<String> {
        self.firmware.clone()
    }
}

/// Refuses a plan of an axis that the vehicle cannot be steered on.
pub(super) fn check_axis(vehicle: &dyn TrialVehicle, axis: Axis) -> Result<(), VehicleError> {
    if vehicle.has_axis(axis) {
        return Ok(());
    }
    Err(VehicleError::setting(format!(
        "{} cannot be steered in {}; sim:starfish-6dof and sim:remus100 can",
        vehicle.name(),
        axis.angle()
    )))
}

/// What a plan will do on a vehicle, found out within a budget.
pub fn previewed(
    vehicle: &dyn TrialVehicle,
    plan: &Plan<f64>,
    budget: &Budget,
) -> Result<Preview, VehicleError> {
    if plan.axis == Axis::Pitch {
        return Err(VehicleError::setting("a plan for pitch: nothing is foreseen of it"));
    }
    let prior = vehicle.prior(plan, budget)?;
    preview_within(plan, &prior, budget).map_err(VehicleError::setting)
}

/// The checklist before a trial: the vehicle, the plan on the vehicle expected, and whether another trial runs.
pub fn preflight(
    vehicle: &dyn TrialVehicle,
    plan: &Plan<f64>,
    is_free: bool,
    budget: &Budget,
) -> Result<Preflight, VehicleError> {
    let mut found = vehicle.inspect(plan)?;
    if let Err(error) = check_axis(vehicle, plan.axis) {
        found.check("axis", false, error.to_string());
    }
    match previewed(vehicle, plan, budget) {
        Ok(preview) => {
            let passed = preview.outcome == Some(Outcome::Finished);
            found.check("plan", passed, plan_text(&preview));
        }
        Err(error) => found.check("plan", true, format!("not previewed: {error}")),
    }
    let text = match is_free {
        true => "no trial runs",
        false => "a trial runs; wait for its end or abort it",
    };
    found.check("free", is_free, text);
    Ok(found)
}

fn plan_text(preview: &Preview) -> String {
    match preview.outcome {
        Some(Outcome::Finished) => format!("the plan takes {:.0} s", preview.duration_s),
        Some(Outcome::Aborted(reason)) => format!(
            "on the expected vehicle it is aborted: {reason}; change the plan or its envelope"
        ),
        None => "the plan does not end".into(),
    }
}

impl fmt::Debug for dyn TrialVehicle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

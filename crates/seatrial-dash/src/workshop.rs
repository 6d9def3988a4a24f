//! What the server does not know itself: vehicles and log formats. Whoever starts it brings them.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::preview::Preview;
use seatrial::{Campaign, Record, Window};
use seatrial_app::conduct::{Conducted, Watch};
use seatrial_core::{Plan, YawModel};
use serde_json::Value;

use crate::api::{LogReading, Preflight, VehicleForm};

/// Vehicles by name and logs of any format. Each failure is a sentence for the operator.
pub trait Workshop: Send + Sync + 'static {
    /// The vehicles that may be asked for.
    fn vehicles(&self) -> Vec<VehicleForm>;
    /// What a plan will do on one of them.
    fn preview(&self, vehicle: &str, plan: &Plan<f64>) -> Result<Preview, String>;
    /// A look at one of them before a trial, without touching it.
    fn preflight(&self, vehicle: &str, plan: &Plan<f64>) -> Result<Preflight, String>;
    /// Takes one of them for a trial.
    fn take(&self, order: &Take) -> Result<Box<dyn Craft>, String>;
    /// Identifies a model from a log, read as asked for.
    fn identify(&self, log: &Path, reading: &LogReading) -> Result<ReadLog, String>;
    /// Says what is in a log, read as asked for.
    fn inspect(&self, log: &Path, reading: &LogReading) -> Result<ReadLog, String>;
}

/// What a vehicle is taken for.
#[derive(Clone, Debug)]
pub struct Take {
    /// Its name.
    pub vehicle: String,
    /// The plan.
    pub plan: Plan<f64>,
    /// Was the plan given, or is it the default?
    pub plan_is_given: bool,
    /// Seed of a simulated vehicle.
    pub seed: u64,
    /// Set when the operator wants the vehicle back.
    pub stop: Arc<AtomicBool>,
}

/// A vehicle that is ours until it is handed back.
pub trait Craft: Send {
    /// Conducts a trial on it.
    fn conduct(
        &mut self,
        plan: Plan<f64>,
        about: Campaign,
        watch: &mut dyn Watch,
    ) -> Result<Conducted<String>, String>;
    /// Hands it back; what could not be put back.
    fn hand_back(&mut self) -> Option<String>;
}

/// A log that was read, and what was made of it.
#[derive(Clone, Debug)]
pub struct ReadLog {
    /// The document of the verb.
    pub document: Value,
    /// The samples.
    pub record: Record,
    /// The model and the window that it was validated on.
    pub validated: Option<(YawModel<f64>, Window)>,
}

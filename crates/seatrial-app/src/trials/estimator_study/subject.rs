//! What a study runs many times: trials of a simulated vehicle by their seeds.

use std::fmt::Display;

use seatrial_sim::{SimulatedConfig, Truth};

use crate::Error;
use crate::trials::order::VehicleError;
use crate::trials::simulator;
use crate::workers::Workers;

/// Trials of a simulated vehicle, each with a seed of its own.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The vehicle by its name.
    pub vehicle: String,
    /// What it is made from.
    pub config: SimulatedConfig,
    /// Trials; of each cell where the study has cells.
    pub runs: u64,
    /// Seed of the first.
    pub seed: u64,
}

impl Subject {
    /// Trials of the vehicle of this name.
    pub fn new(vehicle: &str, runs: u64, seed: u64) -> Result<Self, VehicleError> {
        Ok(Self { vehicle: vehicle.to_owned(), config: simulator::config(vehicle)?, runs, seed })
    }

    /// What each trial gives, by its seed; `None` leaves it out.
    pub fn each<T: Send>(
        &self,
        workers: &Workers,
        trial: impl Fn(u64) -> Option<T> + Sync,
    ) -> Vec<T> {
        workers.each(self.runs, |run| trial(self.seed.wrapping_add(run)))
    }

    /// The truth at a thrust of a vehicle that is made like this.
    pub fn truth(&self, config: &SimulatedConfig, thrust: f64) -> Result<Truth, Error> {
        let truth = config.truth(thrust).map_err(|error| self.input(error))?;
        truth.ok_or_else(|| self.input(format!("no yaw model is known at thrust {thrust}")))
    }

    /// An error of the vehicle.
    pub fn input(&self, what: impl Display) -> Error {
        Error::Input(format!("{}: {what}", self.vehicle))
    }
}

//! What a study runs many times, trials of a simulated vehicle by their seeds, and how near the truth their estimates come.

use std::fmt::Display;

use seatrial::Campaign;
use seatrial_core::Plan;
use seatrial_sim::{SimulatedConfig, Truth};
use serde::Serialize;

use crate::trial_run::{VehicleError, rehearse};
use crate::workers::Workers;
use crate::{Error, simulated};

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
        Ok(Self {
            vehicle: vehicle.to_owned(),
            config: simulated::config(vehicle)?,
            runs,
            seed,
        })
    }

    /// What each trial gives, by its seed; `None` leaves it out.
    pub(crate) fn each<T: Send>(
        &self,
        workers: &Workers,
        trial: impl Fn(u64) -> Option<T> + Sync,
    ) -> Vec<T> {
        workers.each(self.runs, |run| trial(self.seed.wrapping_add(run)))
    }

    /// The campaign of a trial of a vehicle that is made like this.
    pub(crate) fn campaign(
        &self,
        config: &SimulatedConfig,
        plan: Plan<f64>,
        seed: u64,
    ) -> Option<Campaign> {
        let mut vehicle = config.vehicle(seed).ok()?;
        let conducted = rehearse(&mut vehicle, &self.vehicle, seed, plan);
        Some(conducted.ok()?.campaign)
    }

    /// The truth at a thrust of a vehicle that is made like this.
    pub(crate) fn truth(&self, config: &SimulatedConfig, thrust: f64) -> Result<Truth, Error> {
        let truth = config.truth(thrust).map_err(|error| self.input(error))?;
        truth.ok_or_else(|| self.input(format!("no yaw model is known at thrust {thrust}")))
    }

    /// An error of the vehicle.
    pub(crate) fn input(&self, what: impl Display) -> Error {
        Error::Input(format!("{}: {what}", self.vehicle))
    }

    /// An error where no trial gave what the study is of.
    pub(crate) fn none(&self, what: &str) -> Error {
        Error::Rejected(format!("{}: no trial gave a {what}", self.vehicle))
    }
}

/// How near estimates come to the truth, and how often their 95 % intervals hold it; `None` without any estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Mean of the estimates less the truth.
    pub bias: Option<f64>,
    /// Root of their mean squared error.
    pub rms_error: Option<f64>,
    /// Share of them whose interval holds the truth.
    pub coverage: Option<f64>,
}

/// An estimate, its 95 % interval and the truth.
pub(crate) type Estimated = (f64, Option<[f64; 2]>, f64);

impl Coverage {
    /// Of these estimates; one without an interval does not hold the truth.
    pub(crate) fn of(estimates: &[Estimated]) -> Self {
        let count = estimates.len() as f64;
        let mean = |of: fn(&Estimated) -> f64| {
            (count > 0.0).then(|| estimates.iter().map(of).sum::<f64>() / count)
        };
        let error = |(value, _, truth): &Estimated| value - truth;
        Self {
            bias: mean(error),
            rms_error: mean(|(value, _, truth)| (value - truth) * (value - truth)).map(f64::sqrt),
            coverage: mean(|(_, interval, truth)| {
                let holds = interval.is_some_and(|[low, high]| low <= *truth && *truth <= high);
                f64::from(u8::from(holds))
            }),
        }
    }
}

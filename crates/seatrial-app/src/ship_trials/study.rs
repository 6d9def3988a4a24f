//! How often the predicted intervals of manoeuvres hold those of the true vehicle.

use seatrial::Campaign;
use seatrial::sea_trials::ship_manoeuvres::Index;
use seatrial_core::{List, Plan};
use seatrial_sim::identified::{IdentifiedSpeed, IdentifiedVehicle};
use seatrial_sim::{SimulatedConfig, Truth};
use serde::Serialize;

use super::conducted::Conducted;
use super::{DRAWS, Wanted, predicted};
use crate::Error;
use crate::conduct::{Unwatched, conduct};
use crate::models::Models;
use crate::vehicle_file::Stated;
use crate::workers::Workers;

/// Largest rudder of the predicted manoeuvres, rad: enough for the 20/20.
const RUDDER_LIMIT_RAD: f64 = 0.6;

/// Trials of a simulated vehicle of first order, each with a seed of its own.
#[derive(Clone, Debug)]
pub struct ManoeuvreStudy {
    /// The vehicle by its name.
    pub vehicle: String,
    /// What it is made from.
    pub config: SimulatedConfig,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Trials.
    pub runs: u64,
    /// Seed of the first.
    pub seed: u64,
}

/// `study manoeuvres --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ManoeuvreCoverage {
    /// `seatrial.manoeuvre_study.v1`
    pub schema: &'static str,
    /// The vehicle by its name.
    pub vehicle: String,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Trials that gave an accepted model.
    pub models: usize,
    /// Trials that gave none.
    pub without_model: u64,
    /// Each figure.
    pub indices: Vec<IndexCoverage>,
}

/// One figure over all trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IndexCoverage {
    /// The manoeuvre.
    pub manoeuvre: String,
    /// The figure.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is on the true vehicle.
    pub truth: f64,
    /// Mean of the predicted less the truth.
    pub bias: f64,
    /// Root of the mean squared error of the predicted.
    pub rms_error: f64,
    /// Share of the trials whose 95 % interval holds the truth.
    pub coverage: f64,
}

impl ManoeuvreStudy {
    /// Runs it.
    pub fn run(&self, workers: &Workers) -> Result<ManoeuvreCoverage, Error> {
        let failure = |error| Error::Input(format!("{}: {error}", self.vehicle));
        if !self.config.is_first_order() {
            return Err(Error::Setting(format!(
                "{}: its true figures follow from a yaw model; choose a vehicle of first order, sim:starfish or sim:FILE.toml",
                self.vehicle
            )));
        }
        let truth = self
            .config
            .truth(self.thrust)
            .map_err(failure)?
            .ok_or_else(|| {
                Error::Input(format!(
                    "{}: no yaw model at thrust {}",
                    self.vehicle, self.thrust
                ))
            })?;
        let found = workers.each(self.runs, |run| {
            self.trial(&truth, self.seed.wrapping_add(run))
        });
        let models: Vec<&(Vec<Index>, Vec<Index>)> = found.iter().flatten().collect();
        let Some((_, first)) = models.first() else {
            return Err(Error::Rejected(format!(
                "{}: no trial gave a model",
                self.vehicle
            )));
        };
        let stops = |index: &&Index| !index.manoeuvre.starts_with("inertia");
        let indices = first
            .iter()
            .filter(stops)
            .map(|index| coverage(index, &models));
        Ok(ManoeuvreCoverage {
            schema: "seatrial.manoeuvre_study.v1",
            vehicle: self.vehicle.clone(),
            thrust: self.thrust,
            models: models.len(),
            without_model: self.runs - models.len() as u64,
            indices: indices.collect(),
        })
    }

    /// The figures predicted from a trial, and those of the true vehicle; `None` without an accepted model.
    fn trial(&self, truth: &Truth, seed: u64) -> Option<Option<(Vec<Index>, Vec<Index>)>> {
        let found = || {
            let mut vehicle = self.config.vehicle(seed).ok()?;
            let plan = Plan {
                thrusts: List::from_slice(&[self.thrust])?,
                ..Plan::paper()
            };
            let about = Campaign {
                seed: Some(seed),
                rudder_limit_rad: RUDDER_LIMIT_RAD,
                ..Campaign::of(&self.vehicle, &plan)
            };
            let campaign = conduct(&mut vehicle, plan, about, &mut Unwatched)
                .ok()?
                .campaign;
            let models = Models::of_trial(self.vehicle.clone(), &campaign).ok()?;
            let identified = Stated::default().vehicle(&models).ok()?;
            let wanted = Wanted {
                thrust: Some(self.thrust),
                length_m: None,
                draws: DRAWS,
                seed,
                zig_zag_rad: None,
                own_error: None,
            };
            let predicted = predicted(&identified, &wanted).ok()?.indices;
            Some((predicted, self.figures_of(truth, &identified)))
        };
        Some(found())
    }

    /// The figures of the truth: the identified vehicle with the true model, speed, and no lag.
    fn figures_of(&self, truth: &Truth, identified: &IdentifiedVehicle) -> Vec<Index> {
        let mut vehicle = identified.clone();
        let servo = match &self.config {
            SimulatedConfig::FirstOrder(config) => config.servo,
            SimulatedConfig::SixDof(_) => Default::default(),
        };
        vehicle.rudder.lag_s = servo.time_constant_s;
        vehicle.rudder.rate_limit_rad_s = servo.rate_limit_rad_s;
        vehicle.speeds = vec![
            IdentifiedSpeed {
                surge_speed_m_s: truth.surge_speed_m_s,
                ..identified.speeds[0]
            }
            .with_model(&truth.model),
        ];
        Conducted::of(&vehicle, self.thrust, None).indices()
    }
}

fn coverage(index: &Index, models: &[&(Vec<Index>, Vec<Index>)]) -> IndexCoverage {
    let same = |other: &&Index| (&other.manoeuvre, other.name) == (&index.manoeuvre, index.name);
    let found: Vec<(&Index, f64)> = models
        .iter()
        .filter_map(|(predicted, truth)| {
            Some((predicted.iter().find(same)?, truth.iter().find(same)?.value))
        })
        .collect();
    let count = found.len() as f64;
    let mean = |of: &dyn Fn(f64) -> f64| {
        let errors = found
            .iter()
            .map(|(predicted, truth)| predicted.value - truth);
        errors.map(of).sum::<f64>() / count
    };
    let held = found.iter().filter(|(predicted, truth)| {
        predicted
            .interval_95
            .is_some_and(|[low, high]| low <= *truth && *truth <= high)
    });
    IndexCoverage {
        manoeuvre: index.manoeuvre.clone(),
        name: index.name,
        unit: index.unit,
        truth: index.value,
        bias: mean(&|error| error),
        rms_error: mean(&|error| error * error).sqrt(),
        coverage: held.count() as f64 / count,
    }
}

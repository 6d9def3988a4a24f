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
use crate::models::Models;
use crate::studies::subject::{Coverage, Estimated, Subject};
use crate::vehicle_file::Stated;
use crate::workers::Workers;

/// Largest rudder of the predicted manoeuvres, rad: enough for the 20/20.
const RUDDER_LIMIT_RAD: f64 = 0.6;

/// Trials of a simulated vehicle of first order, and the manoeuvres that each predicts.
#[derive(Clone, Debug)]
pub struct ManoeuvreStudy {
    /// The vehicle and its trials.
    pub subject: Subject,
    /// Thrust as a fraction of full.
    pub thrust: f64,
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
    /// How near the predicted come to the truth.
    #[serde(flatten)]
    pub accuracy: Coverage,
}

impl ManoeuvreStudy {
    /// Runs it.
    pub fn run(&self, workers: &Workers) -> Result<ManoeuvreCoverage, Error> {
        let subject = &self.subject;
        if !subject.config.is_first_order() {
            return Err(Error::Setting(format!(
                "{}: its true figures follow from a yaw model; choose a vehicle of first order, sim:starfish or sim:FILE.toml",
                subject.vehicle
            )));
        }
        let truth = subject.truth(&subject.config, self.thrust)?;
        let found = subject.each(workers, |seed| self.trial(&truth, seed));
        let models: Vec<&(Vec<Index>, Vec<Index>)> = found.iter().flatten().collect();
        let Some((_, first)) = models.first() else {
            return Err(subject.none("model"));
        };
        let stops = |index: &&Index| !index.manoeuvre.starts_with("inertia");
        let indices = first
            .iter()
            .filter(stops)
            .map(|index| coverage(index, &models));
        Ok(ManoeuvreCoverage {
            schema: "seatrial.manoeuvre_study.v1",
            vehicle: subject.vehicle.clone(),
            thrust: self.thrust,
            models: models.len(),
            without_model: subject.runs - models.len() as u64,
            indices: indices.collect(),
        })
    }

    /// The figures predicted from a trial, and those of the true vehicle; `None` without an accepted model.
    fn trial(&self, truth: &Truth, seed: u64) -> Option<Option<(Vec<Index>, Vec<Index>)>> {
        let found = || {
            let subject = &self.subject;
            let plan = Plan {
                thrusts: List::from_slice(&[self.thrust])?,
                ..Plan::paper()
            };
            let campaign = Campaign {
                rudder_limit_rad: RUDDER_LIMIT_RAD,
                ..subject.campaign(&subject.config, plan, seed)?
            };
            let models = Models::of_trial(subject.vehicle.clone(), &campaign).ok()?;
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
        let servo = match &self.subject.config {
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
    let found: Vec<Estimated> = models
        .iter()
        .filter_map(|(predicted, truth)| {
            let predicted = predicted.iter().find(same)?;
            let truth = truth.iter().find(same)?.value;
            Some((predicted.value, predicted.interval_95, truth))
        })
        .collect();
    IndexCoverage {
        manoeuvre: index.manoeuvre.clone(),
        name: index.name,
        unit: index.unit,
        truth: index.value,
        accuracy: Coverage::of(&found),
    }
}

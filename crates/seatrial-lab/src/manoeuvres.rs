//! `seatrial-lab manoeuvres`: how often the predicted intervals of manoeuvres hold those of the true vehicle.

use seatrial::Campaign;
use seatrial::sea_trials::ship_manoeuvres::Index;
use seatrial_app::models::Models;
use seatrial_app::ship_trials::{DRAWS, ManoeuvreRequest, figures, predicted};
use seatrial_app::trials::estimator_study::Subject;
use seatrial_app::vehicle_file::VehicleOverrides;
use seatrial_app::workers::Workers;
use seatrial_cli::output::Failure;
use seatrial_cli::table::Table;
use seatrial_core::{List, Plan};
use seatrial_sim::identified::{IdentifiedSpeed, IdentifiedVehicle};
use seatrial_sim::{SimulatedConfig, Truth};
use serde::Serialize;

use crate::coverage::{Coverage, Estimated, campaign, none};
use crate::runner::{Found, Study};

/// Largest rudder of the predicted manoeuvres, rad: enough for the 20/20.
const RUDDER_LIMIT_RAD: f64 = 0.6;

/// Trials of a simulated vehicle, the manoeuvres predicted from each, and how often their intervals hold those of the truth.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial-lab manoeuvres --runs 4")]
pub struct ManoeuvreStudy {
    /// The vehicle, of first order: sim:starfish or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Thrust as a fraction of full.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.8)]
    thrust: f64,
    /// Trials.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
}

/// `manoeuvres --json`.
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

impl Study for ManoeuvreStudy {
    type Found = ManoeuvreCoverage;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.runs)
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<ManoeuvreCoverage, Failure> {
        let subject = Subject::new(&self.vehicle, self.runs, seed)?;
        if !subject.config.is_first_order() {
            return Err(Failure::usage(format!(
                "{}: its true figures follow from a yaw model; choose a vehicle of first order, sim:starfish or sim:FILE.toml",
                subject.vehicle
            )));
        }
        let truth = subject.truth(&subject.config, self.thrust)?;
        let found = subject.each(workers, |seed| Some(self.trial(&subject, &truth, seed)));
        let models: Vec<&(Vec<Index>, Vec<Index>)> = found.iter().flatten().collect();
        let Some((_, first)) = models.first() else {
            return Err(none(&subject, "model").into());
        };
        let stops = |index: &&Index| !index.manoeuvre.starts_with("inertia");
        let indices = first.iter().filter(stops).map(|index| coverage(index, &models));
        Ok(ManoeuvreCoverage {
            schema: "seatrial.manoeuvre_study.v1",
            vehicle: subject.vehicle.clone(),
            thrust: self.thrust,
            models: models.len(),
            without_model: subject.runs - models.len() as u64,
            indices: indices.collect(),
        })
    }
}

impl ManoeuvreStudy {
    /// The figures predicted from a trial, and those of the true vehicle; `None` without an accepted model.
    fn trial(
        &self,
        subject: &Subject,
        truth: &Truth,
        seed: u64,
    ) -> Option<(Vec<Index>, Vec<Index>)> {
        let plan = Plan { thrusts: List::from_slice(&[self.thrust])?, ..Plan::paper() };
        let campaign = Campaign {
            rudder_limit_rad: RUDDER_LIMIT_RAD,
            ..campaign(subject, &subject.config, plan, seed)?
        };
        let models = Models::of_trial(subject.vehicle.clone(), &campaign).ok()?;
        let identified = VehicleOverrides::default().vehicle(&models).ok()?;
        let wanted = ManoeuvreRequest {
            thrust: Some(self.thrust),
            length_m: None,
            draws: DRAWS,
            seed,
            zig_zag_rad: None,
            own_error: None,
        };
        let predicted = predicted(&identified, &wanted).ok()?.indices;
        Some((predicted, self.figures_of(&subject.config, truth, &identified)))
    }

    /// The figures of the truth: the identified vehicle with the true model, speed, and no lag.
    fn figures_of(
        &self,
        config: &SimulatedConfig,
        truth: &Truth,
        identified: &IdentifiedVehicle,
    ) -> Vec<Index> {
        let mut vehicle = identified.clone();
        let servo = match config {
            SimulatedConfig::FirstOrder(config) => config.servo,
            SimulatedConfig::SixDof(_) => Default::default(),
        };
        vehicle.rudder.lag_s = servo.time_constant_s;
        vehicle.rudder.rate_limit_rad_s = servo.rate_limit_rad_s;
        vehicle.speeds = vec![
            IdentifiedSpeed { surge_speed_m_s: truth.surge_speed_m_s, ..identified.speeds[0] }
                .with_model(&truth.model),
        ];
        figures(&vehicle, self.thrust)
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

impl Found for ManoeuvreCoverage {
    fn text(&self) -> String {
        let mut table = Table::under(
            "manoeuvre | figure | truth | bias | rms error | unit | coverage [of 95 %]",
        );
        for index in &self.indices {
            let [bias, rms_error, coverage] = index.accuracy.cells(3);
            table.row(vec![
                index.manoeuvre.clone(),
                index.name.into(),
                format!("{:.3}", index.truth),
                bias,
                rms_error,
                index.unit.into(),
                coverage,
            ]);
        }
        format!(
            "{} at {:.0} % thrust: {} models, {} trials without one\n{table}",
            self.vehicle,
            100.0 * self.thrust,
            self.models,
            self.without_model
        )
    }
}

//! Monte Carlo accuracy of estimators on a simulated vehicle, for Python and for the lab.

mod subject;

use seatrial::identify::cramer_rao::Noise;
use seatrial::study::{Cell, Estimator, Experiment, Outcome, Truth, accuracy, convergence};
use seatrial_core::{List, Plan, Trial};
use seatrial_sim::plant::Disturbance;
use serde::Serialize;

use crate::Error;
use crate::workers::Workers;
pub use subject::Subject;

/// Which estimators are studied on what.
#[derive(Clone, Debug)]
pub struct EstimatorStudy {
    /// The vehicle and its runs of each cell.
    pub subject: Subject,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Compass noise of the cells, standard deviation, degrees; empty: the vehicle's own.
    pub noises_deg: Vec<f64>,
    /// Disturbance of the cells, standard deviation, rad/s^2, and correlation time, s; empty: the vehicle's own.
    pub disturbances: Vec<(f64, f64)>,
    /// The estimators; empty: refined, output error and instrumental variable.
    pub estimators: Vec<Estimator>,
    /// Also the time until half widths of a22 and b2 are under this share.
    pub width: Option<f64>,
}

/// `study --json`.
#[derive(Clone, Debug, Serialize)]
pub struct EstimatorAccuracy {
    /// `seatrial.study.v1`
    pub schema: &'static str,
    /// The vehicle by its name.
    pub vehicle: String,
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Runs of each cell.
    pub runs_per_cell: u64,
    /// The first seed.
    pub seed: u64,
    /// Every combination of compass noise and disturbance.
    pub cells: Vec<Cell>,
}

impl EstimatorStudy {
    /// How many runs there will be.
    pub fn runs_of_all(&self) -> u64 {
        let cells = self.noises_deg.len().max(1) * self.disturbances.len().max(1);
        self.subject.runs * cells as u64
    }

    /// Studies the estimators.
    pub fn run(mut self, workers: &Workers) -> Result<EstimatorAccuracy, Error> {
        let own = self.subject.config.helm();
        if self.noises_deg.is_empty() {
            self.noises_deg = vec![own.sensors.compass.noise_rad.to_degrees()];
        }
        if self.disturbances.is_empty() {
            let own = own.disturbance;
            self.disturbances = vec![(own.standard_deviation_rad_s2, own.correlation_time_s)];
        }
        if self.estimators.is_empty() {
            self.estimators = Estimator::ALL[..3].to_vec();
        }
        let plan = self.plan()?;
        let mut cells = Vec::new();
        for &noise_deg in &self.noises_deg {
            for &disturbance in &self.disturbances {
                cells.push(self.cell(plan, noise_deg, disturbance, workers)?);
            }
        }
        Ok(EstimatorAccuracy {
            schema: "seatrial.study.v1",
            vehicle: self.subject.vehicle,
            thrust: self.thrust,
            runs_per_cell: self.subject.runs,
            seed: self.subject.seed,
            cells,
        })
    }

    fn plan(&self) -> Result<Plan<f64>, Error> {
        let plan = Plan {
            thrusts: List::from_slice(&[self.thrust]).unwrap_or_default(),
            max_repeats: 0,
            ..Plan::paper()
        };
        Trial::new(plan).map_err(|_| {
            Error::Setting(format!(
                "--thrust {}: expected a fraction of full thrust, above 0 and at most 1",
                self.thrust
            ))
        })?;
        Ok(plan)
    }

    fn cell(
        &self,
        plan: Plan<f64>,
        noise_deg: f64,
        (strength_rad_s2, time_s): (f64, f64),
        workers: &Workers,
    ) -> Result<Cell, Error> {
        let noise = Noise {
            heading_rad: noise_deg.to_radians(),
            disturbance_rad_s2: strength_rad_s2,
            disturbance_time_s: time_s,
        };
        let subject = &self.subject;
        let config = subject.config.disturbed(
            noise.heading_rad,
            Disturbance {
                standard_deviation_rad_s2: noise.disturbance_rad_s2,
                correlation_time_s: noise.disturbance_time_s,
            },
        );
        let true_model = subject.truth(&config, self.thrust)?;
        // Refuses what a vehicle cannot be made of before the threads start.
        let made = config.vehicle(subject.seed);
        made.map_err(|error| subject.input(error))?;
        let truth =
            Truth { model: true_model.model, noise, rudder_limit_rad: plan.rudder_limit_rad };
        let has_bound = config.is_first_order() && noise.heading_rad > 0.0;
        let outcomes = subject.each(workers, |seed| {
            let mut vehicle = config.vehicle(seed).ok()?;
            let experiment = Experiment::of(&mut vehicle, plan)?;
            let estimators = &self.estimators;
            Some(Outcome::of(&experiment, &truth, estimators, has_bound, self.width))
        });
        Ok(Cell {
            compass_noise_deg: noise_deg,
            disturbance_rad_s2: strength_rad_s2,
            disturbance_time_s: time_s,
            runs: outcomes.len(),
            aborted: subject.runs - outcomes.len() as u64,
            estimators: accuracy(&outcomes, &truth, &self.estimators),
            convergence: self.width.and_then(|width| convergence(&outcomes, width)),
        })
    }
}

//! `seatrial-lab estimators`: Monte Carlo accuracy of estimators on a simulated vehicle.

use seatrial::study::{Accuracy, Convergence, Estimator, QuantityAccuracy};
use seatrial_app::trials::estimator_study::{EstimatorAccuracy, EstimatorStudy, Subject};
use seatrial_app::workers::Workers;
use seatrial_cli::output::{Failure, Output, OutputPath};
use seatrial_cli::table::{Table, number};
use seatrial_report::render_study;

use crate::runner::{Found, Study, named};

/// Most runs of a cell.
const MOST_RUNS: u64 = 1_000_000;

/// Bias, efficiency against the Cramer-Rao bound and coverage of estimators on a simulated vehicle.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Every run is a simulated settling and training stage with a seed of its own; every combination of --noise-deg and \
--disturbance is a cell. The bound is computed for each run's own rudder record, with the noise known to it. An \
efficiency is known to about sqrt(2/runs), a coverage to about sqrt(0.05/runs).

Example:
  seatrial-lab estimators --runs 50 --noise-deg 0.5 --disturbance 0 --disturbance 0.005,2")]
pub struct Estimators {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Thrust as a fraction of full.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.8)]
    thrust: f64,
    /// Runs of each cell.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=MOST_RUNS))]
    runs: u64,
    /// Compass noise, standard deviation in degrees; repeatable [default: 0.5].
    #[arg(long, value_name = "DEG", value_parser = not_negative, allow_hyphen_values = true)]
    noise_deg: Vec<f64>,
    /// Yaw acceleration disturbance, standard deviation in rad/s^2 and correlation time in s; 0 for none;
    /// repeatable [default: the vehicle's own].
    #[arg(long, value_name = "RAD_S2,S", value_parser = disturbance, allow_hyphen_values = true)]
    disturbance: Vec<(f64, f64)>,
    /// Estimators; repeatable [default: refined, output-error, instrumental-variable].
    #[arg(long, value_parser = named(&Estimator::ALL, Estimator::name))]
    estimator: Vec<Estimator>,
    /// Also the time until the half widths of the 95 % intervals of a22 and b2 are under this share, such as 0.1,
    /// against the time that the bound allows.
    #[arg(long, value_name = "SHARE", value_parser = share, allow_hyphen_values = true)]
    width: Option<f64>,
    /// Write the page of the study.
    #[arg(long, value_name = "FILE.html")]
    report: Option<OutputPath>,
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("expected a number not below 0".into()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("expected a share above 0 and below 1, such as 0.1".into()),
    }
}

fn disturbance(text: &str) -> Result<(f64, f64), String> {
    let expected = || "expected 0, or RAD_S2,S such as 0.005,2".to_string();
    let (strength, time_s) = match text.split_once(',') {
        Some((strength, time_s)) => (not_negative(strength), not_negative(time_s)),
        None => (not_negative(text), Ok(1.0)),
    };
    match (strength, time_s) {
        (Ok(strength), Ok(time_s)) if time_s > 0.0 && (strength == 0.0 || text.contains(',')) => {
            Ok((strength, time_s))
        }
        _ => Err(expected()),
    }
}

impl Estimators {
    fn study(&self, seed: u64) -> Result<EstimatorStudy, Failure> {
        Ok(EstimatorStudy {
            subject: Subject::new(&self.vehicle, self.runs, seed)?,
            thrust: self.thrust,
            noises_deg: self.noise_deg.clone(),
            disturbances: self.disturbance.clone(),
            estimators: self.estimator.clone(),
            width: self.width,
        })
    }
}

impl Study for Estimators {
    type Found = EstimatorAccuracy;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.study(0)?.runs_of_all())
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<EstimatorAccuracy, Failure> {
        Ok(self.study(seed)?.run(workers)?)
    }

    fn save(&self, found: &EstimatorAccuracy, output: &Output) -> Result<(), Failure> {
        let Some(path) = &self.report else {
            return Ok(());
        };
        let title = format!("{} at {:.0} % thrust", self.vehicle, 100.0 * self.thrust);
        output.save(path, render_study(&title, self.runs, &found.cells))
    }
}

impl Found for EstimatorAccuracy {
    fn text(&self) -> String {
        let mut text = format!(
            "{} at {:.0} % thrust, {} runs a cell, seeds from {}\n",
            self.vehicle,
            100.0 * self.thrust,
            self.runs_per_cell,
            self.seed
        );
        for cell in &self.cells {
            text += &format!("\nCompass noise {} deg, ", cell.compass_noise_deg);
            text += &if cell.disturbance_rad_s2 > 0.0 {
                format!(
                    "disturbance {} rad/s^2 for {} s\n",
                    cell.disturbance_rad_s2, cell.disturbance_time_s
                )
            } else {
                "no disturbance\n".into()
            };
            if cell.aborted > 0 {
                text += &format!("{} runs were aborted before they trained.\n", cell.aborted);
            }
            let mut table = Table::under(
                "estimator |  | truth | bias | deviation | bound | efficiency | coverage [of 95 %] | models | \
                not [refused]",
            );
            for accuracy in &cell.estimators {
                for (i, quantity) in accuracy.quantities.iter().enumerate() {
                    table.row(row(accuracy, quantity, i == 0));
                }
            }
            text += &table.to_string();
            if let Some(convergence) = &cell.convergence {
                text += &convergence_text(convergence);
            }
        }
        text
    }
}

fn convergence_text(convergence: &Convergence) -> String {
    format!(
        "95 % half widths of a22 and b2 under {:.0} % after {:.2} s, where the bound allows {:.2} s: {:.2} times ({} of {} runs)\n",
        100.0 * convergence.width,
        convergence.found_s,
        convergence.bound_s,
        convergence.found_s / convergence.bound_s,
        convergence.reached,
        convergence.possible
    )
}

fn row(accuracy: &Accuracy, quantity: &QuantityAccuracy, is_first: bool) -> Vec<String> {
    let first = |text: String| if is_first { text } else { String::new() };
    let small = |value: f64| format!("{value:.2e}");
    vec![
        first(accuracy.estimator.name().into()),
        format!("{}, {}", quantity.name, quantity.unit),
        format!("{:.4}", quantity.truth),
        small(quantity.bias),
        small(quantity.standard_deviation),
        quantity.bound.map_or_else(|| "-".into(), small),
        number(quantity.efficiency, 2),
        number(quantity.coverage, 3),
        first(accuracy.models.to_string()),
        first(number(accuracy.not_refused, 3)),
    ]
}

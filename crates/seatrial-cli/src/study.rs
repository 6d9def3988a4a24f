//! `seatrial study`: Monte Carlo accuracy of estimators on a simulated vehicle.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use indicatif::ProgressBar;
use seatrial::identify::cramer_rao::Noise;
use seatrial::study::{
    Accuracy, Cell, Convergence, Estimator, Experiment, Outcome, QuantityAccuracy, Truth, accuracy,
    convergence,
};
use seatrial_core::{List, Plan};
use seatrial_report::render_study;
use seatrial_sim::SimulatedConfig;
use seatrial_sim::plant::Disturbance;
use serde::Serialize;

use crate::commission_study;
use crate::fault_matrix;
use crate::lying_logs;
use crate::output::{Exit, Failure, Output};
use crate::parallel;
use crate::table::Table;
use crate::vehicle;

/// Most runs of a cell.
const MOST_RUNS: u64 = 1_000_000;

/// Bias, efficiency against the Cramer-Rao bound and coverage of estimators on a simulated vehicle.
#[derive(clap::Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Every run is a simulated settling and training stage with a seed of its own; every combination of --noise-deg and
--disturbance is a cell. The bound is computed for each run's own rudder record, with the noise known to it. An
efficiency is known to about sqrt(2/runs), a coverage to about sqrt(0.05/runs).

Example:
  seatrial study --runs 50 --noise-deg 0.5 --disturbance 0 --disturbance 0.005,2"
)]
pub struct Args {
    #[command(subcommand)]
    what: Option<What>,
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Thrust as a fraction of full.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.8)]
    thrust: f64,
    /// Runs of each cell.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=MOST_RUNS))]
    runs: u64,
    /// Seed of the first run; the same seed gives the same study.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Compass noise, standard deviation in degrees; repeatable [default: 0.5].
    #[arg(long, value_name = "DEG", value_parser = not_negative, allow_hyphen_values = true)]
    noise_deg: Vec<f64>,
    /// Yaw acceleration disturbance, standard deviation in rad/s^2 and correlation time in s; 0 for none;
    /// repeatable [default: the vehicle's own].
    #[arg(long, value_name = "RAD_S2,S", value_parser = disturbance, allow_hyphen_values = true)]
    disturbance: Vec<(f64, f64)>,
    /// Estimators; repeatable [default: refined, output-error, instrumental-variable].
    #[arg(long, value_parser = estimator)]
    estimator: Vec<Estimator>,
    /// Also the time until the half widths of the 95 % intervals of a22 and b2 are under this share, such as 0.1,
    /// against the time that the bound allows.
    #[arg(long, value_name = "SHARE", value_parser = share, allow_hyphen_values = true)]
    width: Option<f64>,
    /// Write the page of the study.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
}

/// Other studies.
#[derive(Debug, clap::Subcommand)]
enum What {
    Faults(fault_matrix::Args),
    Lies(lying_logs::Args),
    Commission(commission_study::Args),
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

fn estimator(text: &str) -> Result<Estimator, String> {
    let names = Estimator::ALL.map(Estimator::name);
    Estimator::ALL
        .into_iter()
        .find(|estimator| estimator.name() == text)
        .ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

/// `study --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    vehicle: String,
    thrust: f64,
    runs_per_cell: u64,
    seed: u64,
    cells: Vec<Cell>,
}

/// Studies the estimators.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    match &args.what {
        Some(What::Faults(args)) => return fault_matrix::run(args, output),
        Some(What::Lies(args)) => return lying_logs::run(args, output),
        Some(What::Commission(args)) => return commission_study::run(args, output),
        None => {}
    }
    let base = vehicle::config(&args.vehicle)?;
    let own = base.helm();
    let noises_deg = if args.noise_deg.is_empty() {
        vec![own.sensors.compass.noise_rad.to_degrees()]
    } else {
        args.noise_deg.clone()
    };
    let disturbances = if args.disturbance.is_empty() {
        let own = own.disturbance;
        vec![(own.standard_deviation_rad_s2, own.correlation_time_s)]
    } else {
        args.disturbance.clone()
    };
    let study = Study {
        plan: plan(args.thrust)?,
        seed: args.seed,
        runs: args.runs,
        threads: parallel::threads(args.threads),
        estimators: if args.estimator.is_empty() {
            Estimator::ALL[..3].to_vec()
        } else {
            args.estimator.clone()
        },
        progress: parallel::progress(args.runs * (noises_deg.len() * disturbances.len()) as u64),
    };
    let mut cells = Vec::new();
    for &noise_deg in &noises_deg {
        for &disturbance in &disturbances {
            cells.push(study.cell(&base, args, noise_deg, disturbance)?);
        }
    }
    study.progress.finish_and_clear();
    let document = Document {
        schema: "seatrial.study.v1",
        vehicle: args.vehicle.clone(),
        thrust: args.thrust,
        runs_per_cell: args.runs,
        seed: args.seed,
        cells,
    };
    output.print(&document, || text(&document))?;
    if let Some(path) = &args.report {
        let title = format!("{} at {:.0} % thrust", args.vehicle, 100.0 * args.thrust);
        std::fs::write(path, render_study(&title, args.runs, &document.cells))
            .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))?;
    }
    Ok(Exit::Done)
}

fn plan(thrust: f64) -> Result<Plan<f64>, Failure> {
    let plan = Plan {
        thrusts: List::from_slice(&[thrust]).unwrap_or_default(),
        max_repeats: 0,
        ..Plan::paper()
    };
    plan.check().map_err(|_| {
        Failure::usage(format!(
            "--thrust {thrust}: expected a fraction of full thrust, above 0 and at most 1"
        ))
    })?;
    Ok(plan)
}

struct Study {
    plan: Plan<f64>,
    seed: u64,
    runs: u64,
    threads: usize,
    estimators: Vec<Estimator>,
    progress: ProgressBar,
}

impl Study {
    fn cell(
        &self,
        base: &SimulatedConfig,
        args: &Args,
        noise_deg: f64,
        (strength_rad_s2, time_s): (f64, f64),
    ) -> Result<Cell, Failure> {
        let noise = Noise {
            heading_rad: noise_deg.to_radians(),
            disturbance_rad_s2: strength_rad_s2,
            disturbance_time_s: time_s,
        };
        let config = base.disturbed(
            noise.heading_rad,
            Disturbance {
                standard_deviation_rad_s2: noise.disturbance_rad_s2,
                correlation_time_s: noise.disturbance_time_s,
            },
        );
        let failure = |error| Failure::input(format!("{}: {error}", args.vehicle));
        let true_model = config.truth(args.thrust).map_err(failure)?.ok_or_else(|| {
            Failure::input(format!(
                "{}: no yaw model is known at thrust {}",
                args.vehicle, args.thrust
            ))
        })?;
        // Refuses what a vehicle cannot be made of before the threads start.
        config.vehicle(self.seed).map_err(failure)?;
        let truth = Truth {
            model: true_model.model,
            noise,
            rudder_limit_rad: self.plan.rudder_limit_rad,
        };
        let has_bound = config.is_first_order() && noise.heading_rad > 0.0;
        let outcomes = self.outcomes(&config, &truth, has_bound, args.width);
        Ok(Cell {
            compass_noise_deg: noise_deg,
            disturbance_rad_s2: strength_rad_s2,
            disturbance_time_s: time_s,
            runs: outcomes.len(),
            aborted: self.runs - outcomes.len() as u64,
            estimators: accuracy(&outcomes, &truth, &self.estimators),
            convergence: args.width.and_then(|width| convergence(&outcomes, width)),
        })
    }

    /// The outcomes in the order of their seeds, from all threads.
    fn outcomes(
        &self,
        config: &SimulatedConfig,
        truth: &Truth,
        has_bound: bool,
        width: Option<f64>,
    ) -> Vec<Outcome> {
        parallel::each(self.runs, self.threads, &self.progress, |run| {
            let mut vehicle = config.vehicle(self.seed.wrapping_add(run)).ok()?;
            let experiment = Experiment::of(&mut vehicle, self.plan)?;
            Some(Outcome::of(
                &experiment,
                truth,
                &self.estimators,
                has_bound,
                width,
            ))
        })
    }
}

fn text(document: &Document) -> String {
    let mut text = format!(
        "{} at {:.0} % thrust, {} runs a cell, seeds from {}\n",
        document.vehicle,
        100.0 * document.thrust,
        document.runs_per_cell,
        document.seed
    );
    for cell in &document.cells {
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
        let mut table = Table::new(&[
            ("estimator", ""),
            ("", ""),
            ("truth", ""),
            ("bias", ""),
            ("deviation", ""),
            ("bound", ""),
            ("efficiency", ""),
            ("coverage", "of 95 %"),
            ("models", ""),
            ("accepted", ""),
        ]);
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
    let or_dash = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
    };
    let small = |value: f64| format!("{value:.2e}");
    vec![
        first(accuracy.estimator.name().into()),
        format!("{}, {}", quantity.name, quantity.unit),
        format!("{:.4}", quantity.truth),
        small(quantity.bias),
        small(quantity.standard_deviation),
        quantity.bound.map_or_else(|| "-".into(), small),
        or_dash(quantity.efficiency, 2),
        or_dash(quantity.coverage, 3),
        first(accuracy.models.to_string()),
        first(or_dash(accuracy.accepted, 3)),
    ]
}

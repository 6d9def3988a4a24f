//! `seatrial-lab surge`: how often the intervals of a trial's surge hold the truth.

use seatrial::motions::surge::{Coefficient, SurgeEstimate};
use seatrial_app::trials::estimator_study::Subject;
use seatrial_app::workers::Workers;
use seatrial_cli::output::Failure;
use seatrial_cli::table::{Table, number};
use seatrial_core::{List, Plan, Trial};
use seatrial_sim::SimulatedConfig;
use serde::Serialize;

use crate::coverage::{Coverage, Estimated, campaign, none};
use crate::runner::{Found, Study};

/// Trials of a simulated vehicle, the surge of each, and how often its intervals hold what a trial without noise finds.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial-lab surge --vehicle sim:remus100 --runs 4")]
pub struct SurgeStudy {
    /// The vehicle: sim:starfish-6dof, sim:remus100, sim:starfish or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish-6dof")]
    vehicle: String,
    /// A thrust of the trial, as a fraction of full; repeatable [default: 0.6 to 1 by tenths].
    #[arg(long, value_name = "FRACTION")]
    thrust: Vec<f64>,
    /// Trials.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
}

/// `surge --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurgeCoverage {
    /// `seatrial.surge_study.v1`
    pub schema: &'static str,
    /// The vehicle by its name.
    pub vehicle: String,
    /// Thrusts of the trial, fractions of full.
    pub thrusts: Vec<f64>,
    /// Trials whose records have a surge.
    pub trials: usize,
    /// Each coefficient.
    pub coefficients: Vec<CoefficientCoverage>,
    /// Largest error of the steady speed at the greatest thrust, a share of it.
    pub largest_top_speed_error: f64,
    /// What the simulator takes for 63 % of the way from the least thrust to the greatest, s.
    pub time_constant_s: Option<f64>,
    /// Root of the mean squared error of the estimated one, a share of it, and the largest.
    pub time_constant_errors: Option<[f64; 2]>,
}

/// One coefficient over all trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoefficientCoverage {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// What a trial in still water with exact sensors finds.
    pub truth: Option<f64>,
    /// Trials that identified it.
    pub identified: usize,
    /// How near the identified come to the truth.
    #[serde(flatten)]
    pub accuracy: Coverage,
}

/// Thrusts of the trial where none is given, fractions of full.
const THRUSTS: [f64; 5] = [0.6, 0.7, 0.8, 0.9, 1.0];

impl Study for SurgeStudy {
    type Found = SurgeCoverage;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.runs)
    }

    /// There is no true l of a vehicle of six degrees of freedom, whose drag and screw are not of this form: the truth is what a
    /// trial of the same plan finds from which noise and disturbance are kept: the best fit of the form at the same speeds.
    fn run(&self, seed: u64, workers: &Workers) -> Result<SurgeCoverage, Failure> {
        let subject = Subject::new(&self.vehicle, self.runs, seed)?;
        let plan = self.plan()?;
        let surge = |config: &SimulatedConfig, seed: u64| {
            SurgeEstimate::of(&campaign(&subject, config, plan, seed)?)
        };
        let truth = surge(&subject.config.noise_free(), 0)
            .ok_or_else(|| subject.input("a trial without noise gives no surge"))?;
        let found = subject.each(workers, |seed| surge(&subject.config, seed));
        if found.is_empty() {
            return Err(none(&subject, "surge").into());
        }
        let time_constant_s = self.time_constant_s(&subject, &truth)?;
        Ok(SurgeCoverage {
            schema: "seatrial.surge_study.v1",
            vehicle: subject.vehicle.clone(),
            thrusts: self.thrusts().to_vec(),
            trials: found.len(),
            coefficients: coefficients(&truth)
                .iter()
                .enumerate()
                .map(|(k, (name, unit, truth))| {
                    let each = found.iter().map(|found| coefficients(found)[k].2.clone());
                    coverage(name.clone(), unit, truth, &each.collect::<Vec<_>>())
                })
                .collect(),
            largest_top_speed_error: top_speed_error(&truth, &found),
            time_constant_errors: time_constant_s.and_then(|s| time_errors(s, &found)),
            time_constant_s,
        })
    }
}

impl SurgeStudy {
    fn thrusts(&self) -> &[f64] {
        match self.thrust.is_empty() {
            true => &THRUSTS,
            false => &self.thrust,
        }
    }

    fn plan(&self) -> Result<Plan<f64>, Failure> {
        let refused = |what: String| Failure::usage(format!("--thrust: {what}"));
        let thrusts = List::from_slice(self.thrusts())
            .ok_or_else(|| refused(format!("{} are too many", self.thrusts().len())))?;
        let plan = Plan { thrusts, ..Plan::paper() };
        Trial::new(plan)
            .map_err(|error| refused(format!("{} must be {}", error.field, error.requirement)))?;
        Ok(plan)
    }

    /// Of a vehicle of six degrees of freedom the simulator's own, from its own thrust to full; of others that of the truth.
    fn time_constant_s(
        &self,
        subject: &Subject,
        truth: &SurgeEstimate,
    ) -> Result<Option<f64>, Failure> {
        let (config, thrusts) = (&subject.config, self.thrusts());
        let least = thrusts.iter().copied().fold(f64::INFINITY, f64::min);
        let is_same_step = least == config.helm().initial_thrust && thrusts.contains(&1.0);
        match config.is_first_order() || !is_same_step {
            true => Ok(time_constant_s(truth)),
            false => Ok(config
                .surge_time_constant_s()
                .map(Some)
                .map_err(|error| subject.input(error))?),
        }
    }
}

/// The time from the least thrust to the greatest.
fn time_constant_s(found: &SurgeEstimate) -> Option<f64> {
    let slowest = found.speeds.first()?.surge_speed_m_s.value?;
    let fastest = found.speeds.last()?.surge_speed_m_s.value?;
    found.time_to_63_percent_s(slowest, fastest)
}

fn time_errors(truth_s: f64, found: &[SurgeEstimate]) -> Option<[f64; 2]> {
    let errors: Vec<f64> =
        found.iter().filter_map(|found| Some(time_constant_s(found)? / truth_s - 1.0)).collect();
    let largest = errors.iter().map(|error| error.abs()).reduce(f64::max)?;
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    Some([(squares / errors.len() as f64).sqrt(), largest])
}

fn top_speed_error(truth: &SurgeEstimate, found: &[SurgeEstimate]) -> f64 {
    let top =
        |surge: &SurgeEstimate| surge.speeds.last().and_then(|speed| speed.surge_speed_m_s.value);
    let true_m_s = top(truth).unwrap_or(f64::NAN);
    found.iter().filter_map(|found| Some((top(found)? / true_m_s - 1.0).abs())).fold(0.0, f64::max)
}

/// The coefficients with name and unit.
fn coefficients(surge: &SurgeEstimate) -> Vec<(String, &'static str, Coefficient)> {
    let mut all = vec![
        ("speed over thrust".to_owned(), "m/s", surge.speed_per_thrust_m_s.clone()),
        ("dead band".to_owned(), "", surge.dead_band.clone()),
        ("drag length".to_owned(), "m", surge.drag_length_m.clone()),
        ("lag of the thrust".to_owned(), "s", surge.thrust_lag_s.clone()),
        ("turning drag".to_owned(), "m", surge.turning_drag_m.clone()),
    ];
    all.extend(surge.speeds.iter().map(|speed| {
        let name = format!("steady speed at {:.0} %", 100.0 * speed.thrust);
        (name, "m/s", speed.surge_speed_m_s.clone())
    }));
    all
}

fn coverage(
    name: String,
    unit: &'static str,
    truth: &Coefficient,
    found: &[Coefficient],
) -> CoefficientCoverage {
    // What the truth does not tell from 0 is 0.
    let true_value = truth.value.unwrap_or(0.0);
    let identified: Vec<Estimated> = found
        .iter()
        .filter_map(|found| Some((found.value?, Some(found.interval_95?), true_value)))
        .collect();
    CoefficientCoverage {
        name,
        unit,
        truth: truth.value,
        identified: identified.len(),
        accuracy: Coverage::of(&identified),
    }
}

impl Found for SurgeCoverage {
    fn text(&self) -> String {
        let mut table = Table::under(
            "coefficient | truth | unit | identified [of all] | bias | rms error | coverage [of 95 %]",
        );
        for found in &self.coefficients {
            let [bias, rms_error, coverage] = found.accuracy.cells(4);
            table.row(vec![
                found.name.clone(),
                number(found.truth, 4),
                found.unit.into(),
                format!("{:.3}", found.identified as f64 / self.trials as f64),
                bias,
                rms_error,
                coverage,
            ]);
        }
        let time = match (self.time_constant_s, self.time_constant_errors) {
            (Some(truth_s), Some([rms, largest])) => format!(
                "Time constant: {truth_s:.2} s, estimated with an error of {:.1} % rms, at most {:.1} %.\n",
                100.0 * rms,
                100.0 * largest
            ),
            _ => "No time constant.\n".to_owned(),
        };
        format!(
            "{}: {} trials\n{table}\n{time}Speed at the greatest thrust: error at most {:.2} %.\n",
            self.vehicle,
            self.trials,
            100.0 * self.largest_top_speed_error
        )
    }
}

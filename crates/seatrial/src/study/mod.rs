//! Monte Carlo study: how far estimators are from the truth, from the bound and from their own intervals.

mod compare;

use seatrial_core::heading_loop::{HeadingLoop, LoopTiming};
use seatrial_core::turning::{Side, Turn};
use seatrial_core::{Event, HeadingGain, Plan, Sample, Stage, Trial, Vehicle, YawModel};
use serde::Serialize;

use crate::identification::{Outcome as VerdictOutcome, Refined};
use crate::identify::cramer_rao::{Noise, cramer_rao_bound};
use crate::identify::output_error::output_error;
use crate::identify::refined::refined_estimate;
use crate::identify::whole_record::robust_estimate_behind;
use crate::identify::{IdentifySettings, identify};
use crate::propagation::{NORMAL_95, interval_95};
use crate::record::{Record, Window};
pub use compare::{ComparedMethod, Comparison, Disagreement, MethodResult, compare, split};

/// Damping ratio of the heading loop whose gain is studied: critical.
const DAMPING_RATIO: f64 = 1.0;

/// An estimator that can be studied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Estimator {
    /// What `identify` reports: the model that goes to the controller.
    Refined,
    /// The refined estimate of a rudder that is known to act at once.
    RefinedWithoutLag,
    /// Output error with its covariance for correlated residuals.
    OutputError,
    /// The recursive instrumental variable, as it runs on the vehicle.
    InstrumentalVariable,
    /// Recursive least squares with the same filters.
    LeastSquares,
    /// The paper's equations to the letter.
    Paper,
}

/// How often in a time constant of the vehicle it is looked whether intervals are narrow enough.
const LOOKS_PER_TIME_CONSTANT: f64 = 10.0;

/// The refined estimate is first looked at after this share of the bound's time.
const FIRST_LOOK: f64 = 0.7;

impl TimeToWidth {
    /// `None` where even the bound allows no such intervals.
    fn of(samples: &[Sample<f64>], truth: &Truth, share: f64) -> Option<Self> {
        let start_s = samples.first()?.time_s;
        let whole_s = samples.last()?.time_s - start_s;
        let look_s = 1.0 / (LOOKS_PER_TIME_CONSTANT * truth.model.a22_per_s.abs());
        let [a22, b2, _] = truth.model.theta().map(f64::abs);
        let reached = |from_s: f64, is_narrow: &dyn Fn(&[Sample<f64>]) -> bool| {
            let looks = ((whole_s - from_s) / look_s).max(0.0) as u32;
            let mut times = (0..=looks).map(|look| from_s + f64::from(look) * look_s);
            times.find(|time_s| {
                let until = samples.partition_point(|s| s.time_s - start_s <= *time_s);
                is_narrow(&samples[..until])
            })
        };
        let bound_s = reached(look_s, &|samples| {
            cramer_rao_bound(samples, truth.model, truth.noise).is_some_and(|bound| {
                let half_width = |i: usize| NORMAL_95 * bound[(i, i)].sqrt();
                half_width(0) <= share * a22 && half_width(1) <= share * b2
            })
        })?;
        let found_s = reached(FIRST_LOOK * bound_s, &|samples| {
            refined_estimate(samples, None).is_ok_and(|refined| {
                let half_width = |[low, high]: [f64; 2]| 0.5 * (high - low);
                let model = &refined.model;
                half_width(refined.interval_95.a22_per_s) <= share * model.a22_per_s.abs()
                    && half_width(refined.interval_95.b2_per_s2) <= share * model.b2_per_s2.abs()
            })
        });
        Some(Self { bound_s, found_s })
    }
}

/// What is true of the simulated vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The yaw model.
    pub model: YawModel<f64>,
    /// Noise and disturbance.
    pub noise: Noise,
    /// Largest rudder angle, rad: that of the turning rate studied.
    pub rudder_limit_rad: f64,
}

/// A simulated run: what the vehicle logged and which part of it is for training.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Settling and training.
    pub record: Record,
    /// The training stage.
    pub training: Window,
}

impl Experiment {
    /// A trial up to the end of its first training stage; `None` where it was aborted before, or the plan has none.
    pub fn of<V: Vehicle<f64>>(vehicle: &mut V, plan: Plan<f64>) -> Option<Self> {
        let mut trial = Trial::new(plan).ok()?;
        let mut record = Record::default();
        let mut training_from_s = None;
        while let Ok(Some(sample)) = vehicle.next_sample() {
            let action = trial.step(&sample);
            while let Some(event) = trial.take_event() {
                let Event::StageStarted { stage, time_s } = event else {
                    continue;
                };
                match (stage, training_from_s) {
                    (Stage::Train, _) => training_from_s = Some(time_s),
                    (Stage::Validate, Some(from_s)) => {
                        let training = Window { from_s, to_s: time_s };
                        return Some(Self { record, training });
                    }
                    _ => {}
                }
            }
            record.samples.push(sample);
            vehicle.act(&action).ok()?;
            if action.outcome.is_some() {
                return None;
            }
        }
        None
    }
}

/// What an estimator made of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    model: YawModel<f64>,
    /// 95 % intervals of [`QUANTITIES`].
    interval_95: [Option<[f64; 2]>; QUANTITIES.len()],
    not_refused: Option<bool>,
}

/// When the half widths of the 95 % intervals of a22 and b2 are both under a share of the parameter, s from the start of
/// training.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TimeToWidth {
    /// By the Cramer-Rao bound: an unbiased estimator that knows the noise.
    bound_s: f64,
    /// By the refined estimate of the samples so far; `None` where the stage ends before.
    found_s: Option<f64>,
}

/// All that is kept of one run.
#[derive(Clone, Debug)]
pub struct Outcome {
    time_to_width: Option<TimeToWidth>,
    /// Cramer-Rao bound on the variances of a22, b2 and C0 for this very run, where there is one.
    bound: Option<[f64; 3]>,
    /// One for each estimator, `None` where it gave no model.
    estimates: Vec<Option<Estimate>>,
}

/// Names and units of what is studied: the parameters, and what is computed from them.
pub const QUANTITIES: [(&str, &str); 6] = [
    ("a22", "1/s"),
    ("b2", "1/s^2"),
    ("C0", "rad/s^2"),
    ("K_p", "rad/rad"),
    ("delay margin with that K_p", "s"),
    ("yaw rate at full rudder", "rad/s"),
];

/// The quantities of a model; `None` where the model has none.
fn quantities(model: &YawModel<f64>, rudder_limit_rad: f64) -> [Option<f64>; QUANTITIES.len()] {
    let [a22, b2, c0] = model.theta();
    let gain = HeadingGain::design(model, DAMPING_RATIO).ok();
    let margins = gain.and_then(|gain| {
        let steered = HeadingLoop::new(model, gain.proportional_gain).ok()?;
        steered.margins(LoopTiming::default()).ok()
    });
    let turn = Turn::new(model, rudder_limit_rad, Side::Starboard).ok();
    [
        Some(a22),
        Some(b2),
        Some(c0),
        gain.map(|g| g.proportional_gain),
        margins.and_then(|m| m.delay_margin_s),
        turn.map(|t| t.yaw_rate_rad_s),
    ]
}

impl Estimator {
    /// Every estimator.
    pub const ALL: [Self; 6] = [
        Self::Refined,
        Self::OutputError,
        Self::InstrumentalVariable,
        Self::RefinedWithoutLag,
        Self::LeastSquares,
        Self::Paper,
    ];

    /// The name that people type.
    ///
    /// ```
    /// use seatrial::study::Estimator;
    ///
    /// assert_eq!(Estimator::InstrumentalVariable.name(), "instrumental-variable");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Refined => "refined",
            Self::RefinedWithoutLag => "refined-without-lag",
            Self::OutputError => "output-error",
            Self::InstrumentalVariable => "instrumental-variable",
            Self::LeastSquares => "least-squares",
            Self::Paper => "paper",
        }
    }

    fn estimate(self, experiment: &Experiment, rudder_limit_rad: f64) -> Option<Estimate> {
        let without_interval =
            |model| Estimate { model, interval_95: [None; QUANTITIES.len()], not_refused: None };
        let carried = |model: &YawModel<f64>, covariance: &[[f64; 3]; 3]| {
            core::array::from_fn(|i| {
                interval_95(model, covariance, |m| quantities(m, rudder_limit_rad)[i])
            })
        };
        let of_refined = |refined: &Refined| {
            let mut intervals = carried(&refined.model, &refined.covariance);
            let own = refined.interval_95;
            intervals[0] = Some(own.a22_per_s);
            intervals[1] = Some(own.b2_per_s2);
            intervals[2] = Some(own.c0_rad_per_s2);
            Estimate { interval_95: intervals, ..without_interval(refined.model) }
        };
        let identified = |settings: &IdentifySettings| {
            identify(&experiment.record, experiment.training, None, settings).ok()
        };
        match self {
            Self::Refined => {
                let found = identified(&IdentifySettings::default())?;
                Some(Estimate {
                    not_refused: Some(found.verdict.outcome() != VerdictOutcome::DoNotUse),
                    ..of_refined(&found.refined?)
                })
            }
            Self::RefinedWithoutLag => {
                let samples = experiment.record.window(experiment.training);
                let found = robust_estimate_behind(samples, Some(0.0)).ok()?;
                Some(of_refined(&found.refined))
            }
            Self::OutputError => {
                let samples = experiment.record.window(experiment.training);
                let found = output_error(samples, None).ok()?;
                Some(Estimate {
                    interval_95: carried(&found.model, &found.covariance),
                    ..without_interval(found.model)
                })
            }
            Self::InstrumentalVariable => {
                let found = identified(&IdentifySettings::default())?;
                Some(without_interval(found.online.model))
            }
            Self::LeastSquares => {
                let found = identified(&IdentifySettings::default())?;
                Some(without_interval(found.online.least_squares.model))
            }
            Self::Paper => {
                let found = identified(&IdentifySettings::paper())?;
                Some(without_interval(found.online.model))
            }
        }
    }
}

impl Outcome {
    /// Runs the estimators on a simulated run. `has_bound`: the truth is of first order with this very noise. `width`: the
    /// share of a22 and b2 until which the time is taken.
    pub fn of(
        experiment: &Experiment,
        truth: &Truth,
        estimators: &[Estimator],
        has_bound: bool,
        width: Option<f64>,
    ) -> Self {
        let samples: &[Sample<f64>] = experiment.record.window(experiment.training);
        let bound =
            has_bound.then(|| cramer_rao_bound(samples, truth.model, truth.noise)).flatten();
        Self {
            time_to_width: width
                .filter(|_| has_bound)
                .and_then(|share| TimeToWidth::of(samples, truth, share)),
            bound: bound.map(|bound| core::array::from_fn(|i| bound[(i, i)])),
            estimates: estimators
                .iter()
                .map(|estimator| estimator.estimate(experiment, truth.rudder_limit_rad))
                .collect(),
        }
    }
}

/// One noise and one disturbance, studied.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Standard deviation of the compass noise, deg.
    pub compass_noise_deg: f64,
    /// Standard deviation of the yaw acceleration disturbance, rad/s^2.
    pub disturbance_rad_s2: f64,
    /// Its time constant, s.
    pub disturbance_time_s: f64,
    /// Runs whose training stage was played to its end.
    pub runs: usize,
    /// Runs that the trial aborted before.
    pub aborted: u64,
    /// One for each estimator.
    pub estimators: Vec<Accuracy>,
    /// How soon the refined estimate's intervals are narrow, where it was asked for and there is a bound.
    pub convergence: Option<Convergence>,
}

/// The time until the half widths of the 95 % intervals of a22 and b2 are under a share of the parameter, s from the
/// start of training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// The share.
    pub width: f64,
    /// Runs in which the bound allows it.
    pub possible: usize,
    /// Runs in which the refined estimate reached it.
    pub reached: usize,
    /// Mean time by the bound over the runs that reached it, s.
    pub bound_s: f64,
    /// Mean time of the refined estimate, s.
    pub found_s: f64,
}

/// How soon intervals are narrow; `None` where they never are.
pub fn convergence(outcomes: &[Outcome], width: f64) -> Option<Convergence> {
    let times: Vec<TimeToWidth> = outcomes.iter().filter_map(|o| o.time_to_width).collect();
    let reached: Vec<(f64, f64)> =
        times.iter().filter_map(|time| Some((time.bound_s, time.found_s?))).collect();
    let (bounds, found): (Vec<f64>, Vec<f64>) = reached.into_iter().unzip();
    Some(Convergence {
        width,
        possible: times.len(),
        reached: found.len(),
        bound_s: mean(&bounds)?,
        found_s: mean(&found)?,
    })
}

/// The study of one estimator under one disturbance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// Which estimator.
    pub estimator: Estimator,
    /// Runs that gave a model.
    pub models: usize,
    /// Share of the models that the verdict does not refuse, where the estimator has one: nothing is held out to validate on.
    pub not_refused: Option<f64>,
    /// One for each of [`QUANTITIES`].
    pub quantities: Vec<QuantityAccuracy>,
}

/// How one quantity was estimated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityAccuracy {
    /// Its name.
    pub name: &'static str,
    /// Its unit; that of truth, bias and deviations.
    pub unit: &'static str,
    /// The true value.
    pub truth: f64,
    /// Mean error.
    pub bias: f64,
    /// Standard deviation of the estimates.
    pub standard_deviation: f64,
    /// Root mean square of the errors.
    pub rms_error: f64,
    /// The least standard deviation that an unbiased estimator can have on these very runs.
    pub bound: Option<f64>,
    /// Bound over mean square error.
    pub efficiency: Option<f64>,
    /// Share of the 95 % intervals that hold the truth; an estimator without interval has none.
    pub coverage: Option<f64>,
    /// Mean half width of the interval.
    pub half_width: Option<f64>,
}

/// From the outcomes of many runs to the accuracy of each estimator.
pub fn accuracy(outcomes: &[Outcome], truth: &Truth, estimators: &[Estimator]) -> Vec<Accuracy> {
    let true_values = quantities(&truth.model, truth.rudder_limit_rad);
    estimators
        .iter()
        .enumerate()
        .map(|(e, &estimator)| {
            let found: Vec<(&Outcome, Estimate)> = outcomes
                .iter()
                .filter_map(|outcome| Some((outcome, outcome.estimates[e]?)))
                .collect();
            let verdicts: Vec<f64> = found
                .iter()
                .filter_map(|(_, estimate)| estimate.not_refused)
                .map(|not_refused| f64::from(u8::from(not_refused)))
                .collect();
            let quantities = true_values.iter().enumerate().filter_map(|(i, value)| {
                QuantityAccuracy::of(i, (*value)?, &found, truth.rudder_limit_rad)
            });
            Accuracy {
                estimator,
                models: found.len(),
                not_refused: mean(&verdicts),
                quantities: quantities.collect(),
            }
        })
        .collect()
}

impl QuantityAccuracy {
    fn of(
        i: usize,
        truth: f64,
        found: &[(&Outcome, Estimate)],
        rudder_limit_rad: f64,
    ) -> Option<Self> {
        let errors: Vec<f64> = found
            .iter()
            .filter_map(|(_, estimate)| quantities(&estimate.model, rudder_limit_rad)[i])
            .map(|value| value - truth)
            .collect();
        let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
        let (bias, mean_square) = (mean(&errors)?, mean(&squares)?);
        let bounds: Vec<f64> =
            found.iter().filter_map(|(outcome, _)| outcome.bound?.get(i).copied()).collect();
        let intervals: Vec<[f64; 2]> =
            found.iter().filter_map(|(_, estimate)| estimate.interval_95[i]).collect();
        let holding: Vec<f64> = intervals
            .iter()
            .map(|[low, high]| f64::from(u8::from((*low..=*high).contains(&truth))))
            .collect();
        let half_widths: Vec<f64> = intervals.iter().map(|[l, h]| 0.5 * (h - l)).collect();
        let bound = mean(&bounds);
        let (name, unit) = QUANTITIES[i];
        Some(Self {
            name,
            unit,
            truth,
            bias,
            standard_deviation: (mean_square - bias * bias).max(0.0).sqrt(),
            rms_error: mean_square.sqrt(),
            bound: bound.map(f64::sqrt),
            efficiency: bound.map(|bound| bound / mean_square),
            coverage: mean(&holding),
            half_width: mean(&half_widths),
        })
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(a22: f64, interval: [f64; 2], bound: f64) -> Outcome {
        let mut interval_95 = [None; QUANTITIES.len()];
        interval_95[0] = Some(interval);
        Outcome {
            time_to_width: None,
            bound: Some([bound; 3]),
            estimates: vec![Some(Estimate {
                model: YawModel::from_theta([a22, 2.0, 0.0]),
                interval_95,
                not_refused: Some(a22 < -0.95),
            })],
        }
    }

    #[test]
    fn exact_mean_times_are_of_the_runs_that_reached() {
        let took = |bound_s: f64, found_s: Option<f64>| Outcome {
            time_to_width: Some(TimeToWidth { bound_s, found_s }),
            ..outcome(-1.0, [-1.1, -0.9], 0.01)
        };
        let outcomes = [took(4.0, Some(5.0)), took(6.0, Some(6.0)), took(9.0, None)];
        let found = convergence(&outcomes, 0.1).unwrap();
        assert_eq!((found.possible, found.reached), (3, 2));
        assert_eq!((found.bound_s, found.found_s), (5.0, 5.5));
        assert_eq!(convergence(&[], 0.1), None);
    }

    #[test]
    fn exact_bias_efficiency_and_coverage() {
        let truth = Truth {
            model: YawModel::from_theta([-1.0, 2.0, 0.0]),
            noise: Noise { heading_rad: 0.01, disturbance_rad_s2: 0.0, disturbance_time_s: 1.0 },
            rudder_limit_rad: 0.26,
        };
        let outcomes = [
            outcome(-1.1, [-1.2, -0.9], 0.005),
            outcome(-0.9, [-0.95, -0.85], 0.015),
            Outcome { time_to_width: None, bound: None, estimates: vec![None] },
        ];
        let studied = accuracy(&outcomes, &truth, &[Estimator::Refined]);
        assert_eq!((studied[0].models, studied[0].not_refused), (2, Some(0.5)));
        let a22 = &studied[0].quantities[0];
        // Rounding of a few sums.
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12);
        close(a22.bias, 0.0);
        close(a22.rms_error, 0.1);
        close(a22.standard_deviation, 0.1);
        close(a22.efficiency.unwrap(), 1.0);
        close(a22.coverage.unwrap(), 0.5);
        close(a22.half_width.unwrap(), 0.1);
        let b2 = &studied[0].quantities[1];
        assert_eq!((b2.rms_error, b2.coverage), (0.0, None));
    }
}

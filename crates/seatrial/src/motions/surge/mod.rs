//! How speed follows thrust: each coefficient with its interval, or why the record does not tell it.

mod design;
mod fit;
mod model;
mod noise;
mod parts;

use nalgebra::{DMatrix, Matrix2, Vector2};
use seatrial_core::model::YawState;
use serde::Serialize;

use crate::campaign::{Campaign, Run, Stage};
use crate::propagation::NORMAL_95;
use fit::{FreeParameters, SurgeFit, fitted};
use parts::{Instant, Part};

pub use design::{ExpectedRun, ExpectedSurge, SurgeBelief};
pub use model::{SurgeModel, SurgePoint};

/// The widest interval of l that counts, as a factor to either side.
const WIDEST: f64 = 1.5;
/// Change of speed at the start of a part from which it determines l, as a fraction of the speed.
const CHANGE: f64 = 0.05;
/// Last part of a settling stage, s, whose mean speed the fit begins with.
const STEADY_S: f64 = 3.0;
/// Steps of the way from one speed to another.
const STEP_S: f64 = 0.01;

/// The surge of a trial.
///
/// ```text
/// w'  = (u_s(p) - w)/lag                 the speed that the screw is for
/// u'  = (w |w| - u |u|)/l - d r^2        r: yaw rate, measured or else that of the run's model
/// u_s = s (p - p0)                       over the thrusts p of the trial
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | s, p0 | `speed_per_thrust_m_s`, `dead_band` | m/s, 1 |
/// | l | `drag_length_m` | m |
/// | lag | `thrust_lag_s` | s |
/// | d | `turning_drag_m` | m |
///
/// u_s of each thrust, l, lag and d together, by least squares of the speed over settling stages and, where the yaw rate was measured or
/// the run has an accepted model, its doublets; s and p0 then by least squares from the u_s. The truth of a coefficient is the best fit of this form to the same
/// manoeuvres without noise: about it intervals hold 95 % of what noise makes of the answer (their equations and sources: `surge_estimate/noise.rs`).
/// That speed is linear in thrust and drag in its square is not in them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurgeEstimate {
    /// `seatrial.surge.v1`
    pub schema: &'static str,
    /// s, m/s.
    pub speed_per_thrust_m_s: Coefficient,
    /// p0.
    pub dead_band: Coefficient,
    /// l, m.
    pub drag_length_m: Coefficient,
    /// Lag of the thrust behind its command, s.
    pub thrust_lag_s: Coefficient,
    /// d, m.
    pub turning_drag_m: Coefficient,
    /// The steady speed of each thrust, slowest first.
    pub speeds: Vec<SteadySpeed>,
    /// Root of the mean squared difference between measured and fitted speed, m/s.
    pub rms_residual_m_s: f64,
    /// Noise of the speed, m/s, from differences of neighbouring readings.
    pub noise_m_s: f64,
    /// Is the noise independent from reading to reading? Else intervals come from the correlated residuals and are rather too wide.
    pub noise_is_white: bool,
}

/// The steady speed of a thrust.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SteadySpeed {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The speed, m/s.
    pub surge_speed_m_s: Coefficient,
}

/// A number of the surge, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coefficient {
    /// Its value; absent where the record does not tell it.
    pub value: Option<f64>,
    /// What holds the truth in 95 % of trials.
    pub interval_95: Option<[f64; 2]>,
    /// `identified`, or why not and what would tell it.
    pub verdict: String,
}

impl Coefficient {
    fn found(value: f64, error: f64) -> Self {
        let half = NORMAL_95 * error;
        Self {
            value: Some(value),
            interval_95: Some([value - half, value + half]),
            verdict: "identified".into(),
        }
    }

    fn not_below_0(self) -> Self {
        let interval_95 = self.interval_95.map(|ends| ends.map(|end| end.max(0.0)));
        Self { value: self.value.map(|value| value.max(0.0)), interval_95, ..self }
    }

    fn missing(what_to_do: &str) -> Self {
        Self {
            value: None,
            interval_95: None,
            verdict: format!("not identifiable from this record: {what_to_do}"),
        }
    }
}

/// The change of thrust that tells how fast the speed follows, of trials whose greatest thrust this is: from and to, fractions of full.
///
/// ```
/// use seatrial::motions::surge::step_wanted;
///
/// // Down from a trial at full thrust, up from one at 30 %.
/// assert_eq!(step_wanted(1.0), [1.0, 0.4]);
/// assert_eq!(step_wanted(0.3), [0.3, 1.0]);
/// ```
pub fn step_wanted(greatest_thrust: f64) -> [f64; 2] {
    let low = (0.4 * greatest_thrust).max(0.05);
    match greatest_thrust >= 0.5 {
        true => [greatest_thrust, low],
        false => [greatest_thrust, 1.0],
    }
}

impl SurgeEstimate {
    /// The surge of a trial; `None` where its records have no speed.
    pub fn of(campaign: &Campaign) -> Option<Self> {
        let mut thrusts: Vec<f64> = Vec::new();
        let with_speed = |run: &&Run| part_of(run, 0, 0).settling > 1;
        let runs: Vec<&Run> = campaign.runs.iter().filter(with_speed).collect();
        for run in &runs {
            if !thrusts.contains(&run.thrust) {
                thrusts.push(run.thrust);
            }
        }
        thrusts.sort_by(f64::total_cmp);
        let place = |thrust: f64| thrusts.iter().position(|other| *other == thrust);
        let mut before = None;
        let mut parts = Vec::new();
        for run in &runs {
            let thrust = place(run.thrust)?;
            parts.push(part_of(run, thrust, before.unwrap_or(thrust)));
            before = Some(thrust);
        }
        know_yaw_rate_noise(&mut parts, &runs);
        let steady_m_s: Vec<f64> = (0..thrusts.len())
            .map(|k| steady_m_s(parts.iter().rfind(|part| part.thrust == k)?))
            .collect::<Option<_>>()?;
        let fitted = best_fit(&parts, &steady_m_s)?;
        Some(Self::from_fit(&fitted, &thrusts))
    }

    fn from_fit(fitted: &SurgeFit, thrusts: &[f64]) -> Self {
        let covariance = fitted.steady_covariance();
        let speeds: Vec<f64> =
            (0..thrusts.len()).map(|k| fitted.parameters.steady_m_s(k)).collect();
        let [slope, dead_band] = line(thrusts, &speeds, &covariance).unwrap_or_else(|| {
            let one = Coefficient::missing("it has one thrust; add another");
            [one.clone(), one]
        });
        let greatest = thrusts.last().copied().unwrap_or(1.0);
        let [from, to] = step_wanted(greatest).map(|thrust| 100.0 * thrust);
        let step = format!("add a step from {from:.0} to {to:.0} %");
        let length = fitted.length_error().filter(|error| NORMAL_95 * error < libm::log(WIDEST));
        let found = fitted.parameters.length_m();
        let factor = |error: f64| libm::exp(NORMAL_95 * error);
        Self {
            schema: "seatrial.surge.v1",
            speed_per_thrust_m_s: slope,
            dead_band,
            drag_length_m: match length {
                Some(error) => Coefficient {
                    interval_95: Some([found / factor(error), found * factor(error)]),
                    ..Coefficient::found(found, error)
                },
                None => Coefficient::missing(&step),
            },
            thrust_lag_s: match fitted.lag_error_s().filter(|_| length.is_some()) {
                Some(error) => Coefficient::found(fitted.parameters.lag_s(), error).not_below_0(),
                None => Coefficient::missing(&step),
            },
            turning_drag_m: match fitted.turning_drag_error_m().filter(|_| length.is_some()) {
                Some(error) => Coefficient::found(fitted.parameters.turning_drag_m(), error),
                None => Coefficient::missing(
                    "no run lost speed in its turns; a U-turn under full rudder tells it",
                ),
            },
            speeds: thrusts
                .iter()
                .enumerate()
                .map(|(k, thrust)| SteadySpeed {
                    thrust: *thrust,
                    surge_speed_m_s: Coefficient::found(speeds[k], covariance[(k, k)].sqrt()),
                })
                .collect(),
            rms_residual_m_s: fitted.rms_residual_m_s,
            noise_m_s: fitted.noise.variance.sqrt(),
            noise_is_white: fitted.noise.is_white,
        }
    }

    /// Time in which the speed makes 63 % of its way from one steady speed to another, s.
    pub fn time_to_63_percent_s(&self, from_m_s: f64, to_m_s: f64) -> Option<f64> {
        let length_m = self.drag_length_m.value?;
        let lag_s = self.thrust_lag_s.value.unwrap_or(0.0);
        let reached = 1.0 - libm::exp(-1.0);
        let (mut speed_m_s, mut time_s) = (from_m_s, 0.0);
        let way_m_s = to_m_s - from_m_s;
        let most_s = 100.0 * (lag_s + length_m / (from_m_s.abs() + to_m_s.abs()));
        while (speed_m_s - from_m_s) / way_m_s < reached && time_s < most_s {
            let left = match lag_s > 0.0 {
                true => libm::exp(-(time_s + 0.5 * STEP_S) / lag_s),
                false => 0.0,
            };
            let towards_m_s = to_m_s - way_m_s * left;
            speed_m_s +=
                STEP_S * (towards_m_s * towards_m_s.abs() - speed_m_s * speed_m_s.abs()) / length_m;
            time_s += STEP_S;
        }
        (time_s < most_s).then_some(time_s)
    }
}

/// The fit with all that the record tells apart from 0.
fn best_fit(parts: &[Part], steady_m_s: &[f64]) -> Option<SurgeFit> {
    let has_change = parts.iter().any(changes_speed);
    let turns = parts.iter().any(|part| part.instants.len() > part.settling);
    let mut varied = FreeParameters {
        length: has_change,
        lag: has_change && changes_thrust(parts),
        turning_drag: has_change && turns,
    };
    let found = fitted(parts, steady_m_s, varied)?;
    let drag_m = found.parameters.turning_drag_m();
    let is_lost = found.turning_drag_error_m().is_some_and(|error| drag_m > NORMAL_95 * error);
    if is_lost || !varied.turning_drag {
        return Some(found);
    }
    varied.turning_drag = false;
    fitted(parts, steady_m_s, varied)
}

/// s and p0 by least squares, in which every thrust counts the same: where the speeds lie on no line, the answer does not hang on
/// the noise.
fn line(
    thrusts: &[f64],
    speeds_m_s: &[f64],
    covariance: &DMatrix<f64>,
) -> Option<[Coefficient; 2]> {
    if thrusts.len() < 2 {
        return None;
    }
    let at = |k: usize| Vector2::new(1.0, thrusts[k]);
    let (mut normal, mut right, mut middle) =
        (Matrix2::zeros(), Vector2::zeros(), Matrix2::zeros());
    for (i, speed_m_s) in speeds_m_s.iter().enumerate() {
        normal += at(i) * at(i).transpose();
        right += *speed_m_s * at(i);
        for k in 0..thrusts.len() {
            middle += covariance[(i, k)] * at(i) * at(k).transpose();
        }
    }
    let inverse = normal.try_inverse()?;
    let [offset, slope] = (inverse * right).into();
    let covariance = inverse * middle * inverse;
    let dead_band = -offset / slope;
    let gradient = Vector2::new(-1.0 / slope, offset / (slope * slope));
    let error = (gradient.transpose() * covariance * gradient)[(0, 0)].sqrt();
    Some([
        Coefficient::found(slope, covariance[(1, 1)].sqrt()),
        Coefficient::found(dead_band, error),
    ])
}

/// Does its speed change by more than noise in the beginning?
fn changes_speed(part: &Part) -> bool {
    let first = part.instants.first().map(|at| at.surge_speed_m_s);
    let steady = steady_m_s(part);
    first.zip(steady).is_some_and(|(first, steady)| (steady - first).abs() > CHANGE * steady.abs())
}

/// Does a part follow one of another thrust? The thrust before a trial is not known, and with it not what the thrust lags behind.
fn changes_thrust(parts: &[Part]) -> bool {
    parts.iter().any(|part| part.thrust != part.before)
}

/// The noise of the yaw rates that were measured, the same in all parts.
fn know_yaw_rate_noise(parts: &mut [Part], runs: &[&Run]) {
    let series: Vec<Vec<f64>> = parts
        .iter()
        .zip(runs)
        .filter(|(_, run)| yaw_rate_is_measured(run))
        .map(|(part, _)| part.instants.iter().map(|at| at.yaw_rate_rad_s).collect())
        .collect();
    let variance = noise::yaw_rate_variance(&series);
    for (part, run) in parts.iter_mut().zip(runs) {
        if yaw_rate_is_measured(run) {
            part.yaw_rate_variance = variance;
        }
    }
}

fn yaw_rate_is_measured(run: &Run) -> bool {
    run.record.samples.iter().all(|s| s.yaw_rate_rad_s.is_some())
}

/// The mean speed over the last seconds before the first turn, m/s.
fn steady_m_s(part: &Part) -> Option<f64> {
    let straight = &part.instants[..part.settling];
    let end_s = straight.last()?.time_s;
    let late = straight.iter().filter(|at| at.time_s >= end_s - STEADY_S);
    let late: Vec<f64> = late.map(|at| at.surge_speed_m_s).collect();
    Some(late.iter().sum::<f64>() / late.len() as f64)
}

/// The settling stage of a run and, where its yaw rate is known, its doublets; with the yaw rate that was measured or, where some
/// sample has none, that of an accepted model under its rudder, 0 while the run settles.
fn part_of(run: &Run, thrust: usize, before: usize) -> Part {
    let mut part =
        Part { thrust, before, settling: 0, yaw_rate_variance: 0.0, instants: Vec::new() };
    let Some(settle) = run.stage(Stage::Settle) else {
        return part;
    };
    let model =
        run.identification.as_ref().filter(|_| run.verdict.accepted).map(|found| found.model());
    let is_measured = yaw_rate_is_measured(run);
    let mut state = YawState::default();
    let mut last_rudder_rad = 0.0;
    for sample in &run.record.samples {
        let has_settled = sample.time_s >= settle.to_s;
        if has_settled && model.is_none() && !is_measured {
            break;
        }
        let last_s = part.instants.last().map(|last| last.time_s);
        let known = sample.surge_speed_m_s.filter(|speed| speed.is_finite());
        let Some(surge_speed_m_s) =
            known.filter(|_| last_s.is_none_or(|last| sample.time_s > last))
        else {
            continue;
        };
        if let (Some(model), Some(last_s), true) = (&model, last_s, has_settled) {
            state = model.advance(state, last_rudder_rad, sample.time_s - last_s);
        }
        last_rudder_rad = sample.rudder_rad;
        let measured = sample.yaw_rate_rad_s.filter(|_| is_measured);
        part.settling += usize::from(!has_settled);
        part.instants.push(Instant {
            time_s: sample.time_s,
            surge_speed_m_s,
            yaw_rate_rad_s: measured.unwrap_or(state.yaw_rate_rad_s),
        });
    }
    part
}

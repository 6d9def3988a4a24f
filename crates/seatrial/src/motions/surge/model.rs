//! Surge: the speed that a thrust gives, and how long it takes, from the settling stages of a trial.

use nalgebra::{DMatrix, DVector};
use seatrial_core::Sample;
use seatrial_core::model::YawState;
use serde::Serialize;

use crate::campaign::{Campaign, Run, Stage};

/// Change of speed from which a settling stage determines how fast it changes, as a fraction of the speed.
const CHANGE: f64 = 0.05;
/// Last part of a settling stage, s, whose mean speed is the steady one.
const STEADY_S: f64 = 3.0;

/// Speed over thrust.
///
/// ```text
/// u_s = s (p - p0)                      steady: the force goes with (p - p0)^2, the drag with u^2
/// u'  = (u_s^2 - u^2)/l                 on the way there
/// T   = l/(2 u_s)                       near u_s
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | p | thrust setting, a fraction of full | 1 |
/// | u, u_s | forward speed, steady | m/s |
/// | s, p0 | `speed_per_thrust_m_s`, `dead_band` | m/s, 1 |
/// | l | `drag_length_m`: mass over drag per speed squared | m |
/// | T | [`time_constant_s`](SurgeModel::time_constant_s) | s |
///
/// A percentage of thrust sets a screw's speed, so that force and drag balance at a speed linear in it. s and p0 by
/// least squares over the thrusts. 1/l by least squares over the settling stages that begin with a
/// change of speed, of the integral, which needs no derivative of a noisy speed:
///
/// ```text
/// u(t) = u(0) + (u_s^2/l) t - (1/l) integral of u^2 dt
/// ```
///
/// with u(0) and u_s^2/l of each stage and one l for all. A turn costs speed. Drift and the force that it takes go with the
/// yaw rate:
///
/// ```text
/// u'  = (u_s^2 - u^2)/l - d r^2
/// u_t = u_s/sqrt(1 + l d/R^2)           steady on a circle of radius R = u_t/r
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | r | yaw rate of the run's model under its rudder | rad/s |
/// | d | `turning_drag_m` | m |
///
/// d by least squares over the doublets of training and validation, of the same integral with l known. Valid between the least and the greatest thrust; the lag of the
/// screw itself is in l.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurgeModel {
    /// s, m/s.
    pub speed_per_thrust_m_s: f64,
    /// p0.
    pub dead_band: f64,
    /// Root of the mean squared residual of the speeds, m/s.
    pub rms_residual_m_s: f64,
    /// l, m; `None` where no stage began with a change of speed.
    pub drag_length_m: Option<f64>,
    /// d, m; `None` where no accepted run turned.
    pub turning_drag_m: Option<f64>,
    /// What it was fitted to, in order of thrust.
    pub points: Vec<SurgePoint>,
}

/// The steady speed at a thrust.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurgePoint {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Mean forward speed at the end of the settling stage, m/s.
    pub steady_speed_m_s: f64,
}

impl SurgeModel {
    /// The model of a trial; `None` under two thrusts with a speed.
    pub fn of(campaign: &Campaign) -> Option<Self> {
        let mut points: Vec<SurgePoint> = Vec::new();
        for run in &campaign.runs {
            let Some(steady_speed_m_s) = steady_speed_m_s(&settling(run)) else {
                continue;
            };
            points.retain(|point| point.thrust != run.thrust);
            points.push(SurgePoint { thrust: run.thrust, steady_speed_m_s });
        }
        points.sort_by(|a, b| a.thrust.total_cmp(&b.thrust));
        let n = points.len() as f64;
        let mean = |of: fn(&SurgePoint) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (thrust, speed) = (mean(|p| p.thrust), mean(|p| p.steady_speed_m_s));
        let product: f64 =
            points.iter().map(|p| (p.thrust - thrust) * (p.steady_speed_m_s - speed)).sum();
        let square: f64 = points.iter().map(|p| (p.thrust - thrust).powi(2)).sum();
        let speed_per_thrust_m_s = product / square;
        let dead_band = thrust - speed / speed_per_thrust_m_s;
        if points.len() < 2 || !dead_band.is_finite() {
            return None;
        }
        let residual =
            |p: &SurgePoint| p.steady_speed_m_s - speed_per_thrust_m_s * (p.thrust - dead_band);
        let squares: f64 = points.iter().map(|p| residual(p).powi(2)).sum();
        let stages: Vec<Vec<[f64; 2]>> = campaign
            .runs
            .iter()
            .map(settling)
            .filter(|stage| begins_with_a_change(stage))
            .collect();
        let drag_length_m = drag_length_m(&stages);
        let turning = || {
            let runs = campaign.accepted_runs();
            let doublets: Vec<Vec<Turning>> = runs.iter().flat_map(|run| doublets(run)).collect();
            turning_drag_m(&doublets, drag_length_m?)
        };
        Some(Self {
            speed_per_thrust_m_s,
            dead_band,
            rms_residual_m_s: (squares / n).sqrt(),
            turning_drag_m: turning(),
            drag_length_m,
            points,
        })
    }

    /// The mean speed over a turn that begins at `surge_speed_m_s` straight ahead, follows a circle of this radius and lasts
    /// so long, m/s:
    ///
    /// ```text
    /// u_t + (u_s - u_t) (T/t) (1 - e^{-t/T})
    /// ```
    ///
    /// ```
    /// use seatrial::motions::surge::SurgeModel;
    ///
    /// let surge = SurgeModel {
    ///     speed_per_thrust_m_s: 2.0,
    ///     dead_band: 0.1,
    ///     rms_residual_m_s: 0.0,
    ///     drag_length_m: Some(6.0),
    ///     turning_drag_m: Some(2.0),
    ///     points: Vec::new(),
    /// };
    /// // u/sqrt(1 + l d/R^2) in a turn of 2 m that lasts, nearly u in a short one.
    /// let mean_m_s = |lasts_s| surge.mean_speed_in_turn_m_s(1.0, 2.0, lasts_s);
    /// assert!(mean_m_s(1e4).is_some_and(|speed_m_s| (speed_m_s - 0.5).abs() < 1e-3));
    /// assert!(mean_m_s(0.01) > Some(0.99));
    /// ```
    pub fn mean_speed_in_turn_m_s(
        &self,
        surge_speed_m_s: f64,
        radius_m: f64,
        lasts_s: f64,
    ) -> Option<f64> {
        let wider = self.drag_length_m? * self.turning_drag_m? / (radius_m * radius_m);
        let steady_m_s = surge_speed_m_s / (1.0 + wider).sqrt();
        let part = self.time_constant_s(surge_speed_m_s)? / lasts_s;
        let still_lost = part * (1.0 - libm::exp(-1.0 / part));
        Some(steady_m_s + (surge_speed_m_s - steady_m_s) * still_lost)
    }

    /// The steady speed at a thrust, m/s; 0 inside the dead band.
    ///
    /// ```
    /// use seatrial::motions::surge::SurgeModel;
    ///
    /// let surge = SurgeModel {
    ///     speed_per_thrust_m_s: 2.0,
    ///     dead_band: 0.1,
    ///     rms_residual_m_s: 0.0,
    ///     drag_length_m: Some(6.0),
    ///     turning_drag_m: None,
    ///     points: Vec::new(),
    /// };
    /// assert_eq!((surge.speed_m_s(0.6), surge.thrust(1.0)), (1.0, 0.6));
    /// // Nothing moves inside the dead band.
    /// assert_eq!(surge.speed_m_s(0.05), 0.0);
    /// ```
    pub fn speed_m_s(&self, thrust: f64) -> f64 {
        (self.speed_per_thrust_m_s * (thrust - self.dead_band)).max(0.0)
    }

    /// The thrust that keeps a speed.
    pub fn thrust(&self, surge_speed_m_s: f64) -> f64 {
        self.dead_band + surge_speed_m_s / self.speed_per_thrust_m_s
    }

    /// Time constant of small changes about a speed, s.
    ///
    /// ```
    /// use seatrial::motions::surge::SurgeModel;
    ///
    /// let surge = SurgeModel {
    ///     speed_per_thrust_m_s: 2.0,
    ///     dead_band: 0.1,
    ///     rms_residual_m_s: 0.0,
    ///     drag_length_m: Some(6.0),
    ///     turning_drag_m: None,
    ///     points: Vec::new(),
    /// };
    /// // l/(2 u): the faster, the sooner.
    /// assert_eq!([1.0, 2.0].map(|speed_m_s| surge.time_constant_s(speed_m_s)), [Some(3.0), Some(1.5)]);
    /// ```
    pub fn time_constant_s(&self, surge_speed_m_s: f64) -> Option<f64> {
        Some(self.drag_length_m? / (2.0 * surge_speed_m_s))
    }
}

/// An instant of a stage with a doublet.
struct Turning {
    time_s: f64,
    surge_speed_m_s: f64,
    yaw_rate_rad_s: f64,
}

/// Training and validation of a run, with the yaw rate of its model.
fn doublets(run: &Run) -> Vec<Vec<Turning>> {
    let Some(identification) = &run.identification else {
        return Vec::new();
    };
    let model = identification.model();
    let windows = [Stage::Train, Stage::Validate].map(|stage| run.stage(stage));
    let doublet = |window| {
        let samples = run.record.window(window);
        let mut state = YawState::default();
        let mut instants: Vec<Turning> = Vec::new();
        for pair in samples.windows(2) {
            let interval_s = pair[1].time_s - pair[0].time_s;
            if interval_s <= 0.0 {
                continue;
            }
            state = model.advance(state, pair[0].rudder_rad, interval_s);
            instants.push(Turning {
                time_s: pair[1].time_s,
                surge_speed_m_s: pair[1].surge_speed_m_s?,
                yaw_rate_rad_s: state.yaw_rate_rad_s,
            });
        }
        Some(instants)
    };
    windows.into_iter().flatten().filter_map(doublet).collect()
}

/// d by least squares over the stages with one u(0) and u_s^2/l each, m.
fn turning_drag_m(stages: &[Vec<Turning>], drag_length_m: f64) -> Option<f64> {
    let rows = |stage: &Vec<Turning>| {
        let mut last = stage.first()?;
        let start_s = last.time_s;
        let (mut drag, mut turned) = (0.0, 0.0);
        let rows = stage.iter().map(|now| {
            let half_s = 0.5 * (now.time_s - last.time_s);
            let sum = |of: fn(&Turning) -> f64| of(now).powi(2) + of(last).powi(2);
            drag += half_s * sum(|at| at.surge_speed_m_s);
            turned += half_s * sum(|at| at.yaw_rate_rad_s);
            last = now;
            Row {
                after_s: now.time_s - start_s,
                regressor: -turned,
                observed: now.surge_speed_m_s + drag / drag_length_m,
            }
        });
        Some(rows.collect())
    };
    let stages: Vec<Vec<Row>> = stages.iter().map(rows).collect::<Option<_>>()?;
    common_slope(&stages).filter(|found| found.is_finite() && *found > 0.0)
}

/// Time and speed in the settling stage of a run.
fn settling(run: &Run) -> Vec<[f64; 2]> {
    let stage = run.stages.iter().find(|span| span.stage == Stage::Settle);
    let samples = stage.map_or(&[][..], |span| run.record.window(span.window));
    let known = |s: &Sample<f64>| Some([s.time_s, s.surge_speed_m_s?]);
    let finite = |s: &[f64; 2]| s.iter().all(|x| x.is_finite());
    let mut stage: Vec<[f64; 2]> = samples.iter().filter_map(known).filter(finite).collect();
    stage.dedup_by(|next, last| next[0] <= last[0]);
    stage
}

/// The mean over the last seconds of a stage, m/s.
fn steady_speed_m_s(stage: &[[f64; 2]]) -> Option<f64> {
    let [end_s, _] = *stage.last()?;
    let late = stage.iter().filter(|[time_s, _]| *time_s >= end_s - STEADY_S);
    let count = late.clone().count() as f64;
    Some(late.map(|[_, speed]| speed).sum::<f64>() / count)
}

fn begins_with_a_change(stage: &[[f64; 2]]) -> bool {
    let Some((first, last)) = stage.first().zip(steady_speed_m_s(stage)) else {
        return false;
    };
    (last - first[1]).abs() > CHANGE * last.abs()
}

/// l by least squares over the stages, m.
fn drag_length_m(stages: &[Vec<[f64; 2]>]) -> Option<f64> {
    let rows = |stage: &Vec<[f64; 2]>| {
        let [start_s, mut last_m_s] = *stage.first()?;
        let mut last_s = start_s;
        let mut integral = 0.0;
        let row = |&[time_s, speed_m_s]: &[f64; 2]| {
            let interval_s = time_s - last_s;
            integral += 0.5 * interval_s * (speed_m_s * speed_m_s + last_m_s * last_m_s);
            (last_s, last_m_s) = (time_s, speed_m_s);
            Row { after_s: time_s - start_s, regressor: -integral, observed: speed_m_s }
        };
        Some(stage.iter().map(row).collect())
    };
    let stages: Vec<Vec<Row>> = stages.iter().map(rows).collect::<Option<_>>()?;
    let length = 1.0 / common_slope(&stages)?;
    (length.is_finite() && length > 0.0).then_some(length)
}

/// An instant of a stage: `observed` is a constant and a slope over time, both the stage's own, and a slope over
/// `regressor` that all stages share.
struct Row {
    after_s: f64,
    regressor: f64,
    observed: f64,
}

/// The slope that all stages share, by least squares.
fn common_slope(stages: &[Vec<Row>]) -> Option<f64> {
    let rows: usize = stages.iter().map(Vec::len).sum();
    let columns = 2 * stages.len() + 1;
    if stages.is_empty() || rows <= columns {
        return None;
    }
    let mut regressors = DMatrix::zeros(rows, columns);
    let mut observed = DVector::zeros(rows);
    let of_stage =
        stages.iter().enumerate().flat_map(|(k, stage)| stage.iter().map(move |row| (k, row)));
    for (at, (k, row)) in of_stage.enumerate() {
        regressors[(at, 2 * k)] = 1.0;
        regressors[(at, 2 * k + 1)] = row.after_s;
        regressors[(at, columns - 1)] = row.regressor;
        observed[at] = row.observed;
    }
    let transposed = regressors.transpose();
    let solution = (&transposed * &regressors).cholesky()?.solve(&(transposed * observed));
    Some(solution[columns - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u = u_s tanh(u_s t/l + c) solves u' = (u_s^2 - u^2)/l.
    fn stage(from_m_s: f64, to_m_s: f64, length_m: f64) -> Vec<[f64; 2]> {
        let ratio: f64 = from_m_s / to_m_s;
        (0..240)
            .map(|k| {
                let time_s = 5.0 + 0.05 * f64::from(k);
                let way = (to_m_s * (time_s - 5.0) / length_m).tanh();
                [time_s, to_m_s * (ratio + way) / (1.0 + ratio * way)]
            })
            .collect()
    }

    #[test]
    fn exact_drag_length_of_quadratic_drag() {
        let stages = [stage(1.0, 1.4, 9.0), stage(1.4, 1.7, 9.0)];
        let found = drag_length_m(&stages).unwrap();
        // The trapezoidal rule: (0.05 s)^2/12 of the curvature.
        assert!((found / 9.0 - 1.0).abs() < 1e-3, "{found}");
        assert_eq!(drag_length_m(&[]), None);
    }

    /// u' = (u_s^2 - u^2)/l - d r^2 under a doublet's turn, in steps of 10 ms.
    #[test]
    fn exact_turning_drag_and_the_speed_that_it_costs() {
        let (steady_m_s, length_m, drag_m): (f64, f64, f64) = (1.6, 9.0, 0.9);
        let slower = |u: f64, r: f64| (steady_m_s * steady_m_s - u * u) / length_m - drag_m * r * r;
        let mut speed = steady_m_s;
        let stage: Vec<Turning> = (0..1650)
            .map(|k| {
                let time_s = 0.01 * f64::from(k);
                let yaw_rate_rad_s = if (2.0..6.0).contains(&time_s) { 0.2 } else { 0.0 };
                let before_m_s = speed;
                speed += 0.01 * slower(speed, yaw_rate_rad_s);
                Turning { time_s, surge_speed_m_s: before_m_s, yaw_rate_rad_s }
            })
            .collect();
        let found = turning_drag_m(&[stage], length_m).unwrap();
        // Euler's steps of 10 ms against a time constant of 3 s.
        assert!((found / drag_m - 1.0).abs() < 0.01, "{found}");
        let surge = SurgeModel {
            speed_per_thrust_m_s: 2.0,
            dead_band: 0.0,
            rms_residual_m_s: 0.0,
            drag_length_m: Some(length_m),
            turning_drag_m: Some(drag_m),
            points: Vec::new(),
        };
        let radius_m = 8.0;
        let mut speed = steady_m_s;
        let mut way_m = 0.0;
        for _ in 0..1500 {
            way_m += 0.01 * speed;
            speed += 0.01 * slower(speed, speed / radius_m);
        }
        let mean = surge.mean_speed_in_turn_m_s(steady_m_s, radius_m, 15.0).unwrap();
        // The way there is taken to be exponential: a tenth of the 6 % lost.
        assert!((mean / (way_m / 15.0) - 1.0).abs() < 0.006, "{mean} {way_m}");
        assert_eq!(turning_drag_m(&[], length_m), None);
    }

    #[test]
    fn exact_only_a_change_of_speed_counts() {
        assert!(begins_with_a_change(&stage(1.0, 1.4, 9.0)));
        assert!(!begins_with_a_change(&stage(1.4, 1.4, 9.0)));
        assert!(!begins_with_a_change(&[]));
    }
}

//! Repeated trials: how much the estimates scatter against what their intervals say.

use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::turning::Side;
use seatrial_core::{HeadingGain, SchedulePoint, YawModel};
use serde::Serialize;

use super::u_turn::mean_radius_m;
use crate::campaign::{Campaign, Run};
use crate::identification::Intervals;
use crate::propagation::NORMAL_95;

/// The trials at one thrust.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialsAtThrust {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// The model of the first trial.
    pub model: YawModel<f64>,
    /// Mean speed of its training stage, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Trials that ended with an accepted model, and all.
    pub accepted: [usize; 2],
    /// Seconds of training until the estimate had converged, of each trial that did.
    pub converged_s: Vec<f64>,
    /// R^2 of heading on validation data, of each trial.
    pub r2_heading: Vec<f64>,
}

impl TrialsAtThrust {
    pub(super) fn of(trials: &[Campaign], thrust: f64) -> Option<Self> {
        let runs = accepted_at(trials, thrust);
        let found = || runs.iter().filter_map(|(_, run)| run.identification.as_ref());
        Some(Self {
            thrust,
            model: found().next()?.model(),
            surge_speed_m_s: runs.first()?.1.surge_speed_m_s,
            accepted: [runs.len(), trials.len()],
            converged_s: found().filter_map(|i| i.online.convergence.detected_s).collect(),
            r2_heading: found().filter_map(|i| i.validation?.r2_heading).collect(),
        })
    }
}

/// The trials of one thrust beside each other (section VI-B).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Repeatability {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// One entry a trial.
    pub repeats: Vec<Repeat>,
    /// Spread of a22, 1/s.
    pub a22_per_s: Spread,
    /// Spread of b2, 1/s^2.
    pub b2_per_s2: Spread,
    /// Least and greatest K_p, rad/rad.
    pub proportional_gain: [f64; 2],
    /// Least and greatest R (50), m.
    pub u_turn_mean_radius_m: [f64; 2],
}

/// One of the repeated trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Repeat {
    /// Its seed.
    pub seed: Option<u64>,
    /// The model.
    pub model: YawModel<f64>,
    /// 95 % intervals.
    pub interval_95: Intervals,
    /// K_p (57), rad/rad.
    pub proportional_gain: f64,
    /// R (50), m.
    pub u_turn_mean_radius_m: f64,
}

/// A parameter over the repeated trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation between the trials.
    pub standard_deviation: f64,
    /// Standard deviation that the intervals state: the root of the mean square.
    pub stated: f64,
    /// Intervals that hold the mean.
    pub intervals_with_mean: usize,
}

impl Spread {
    fn of(values: &[(f64, [f64; 2])]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|(value, _)| value).sum::<f64>() / n;
        let squares: f64 = values.iter().map(|(v, _)| (v - mean) * (v - mean)).sum();
        let stated: f64 =
            values.iter().map(|(_, [low, high])| (0.5 * (high - low) / NORMAL_95).powi(2)).sum();
        let holds = |[low, high]: [f64; 2]| low <= mean && mean <= high;
        Self {
            mean,
            standard_deviation: (squares / (n - 1.0)).sqrt(),
            stated: (stated / n).sqrt(),
            intervals_with_mean: values.iter().filter(|(_, i)| holds(*i)).count(),
        }
    }
}

impl Repeatability {
    /// `None` where fewer than two trials have a model with intervals at the thrust.
    pub(super) fn of(
        trials: &[Campaign],
        thrust: f64,
        rudder_limit_rad: f64,
        side: Side,
        damping_ratio: f64,
    ) -> Option<Self> {
        let runs = accepted_at(trials, thrust);
        let repeats: Vec<Repeat> = runs
            .iter()
            .filter_map(|(seed, run)| {
                let refined = run.identification.as_ref()?.refined.as_ref()?;
                let model = refined.model;
                Some(Repeat {
                    seed: *seed,
                    model,
                    interval_95: refined.interval_95,
                    proportional_gain: HeadingGain::design(&model, damping_ratio)
                        .ok()?
                        .proportional_gain,
                    u_turn_mean_radius_m: mean_radius_m(
                        &model,
                        rudder_limit_rad,
                        side,
                        run.surge_speed_m_s?,
                    )?,
                })
            })
            .collect();
        if repeats.len() < 2 {
            return None;
        }
        let spread = |of: fn(&Repeat) -> (f64, [f64; 2])| {
            Spread::of(&repeats.iter().map(of).collect::<Vec<_>>())
        };
        let range = |of: fn(&Repeat) -> f64| {
            let values = || repeats.iter().map(of);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        Some(Self {
            thrust,
            a22_per_s: spread(|r| (r.model.a22_per_s, r.interval_95.a22_per_s)),
            b2_per_s2: spread(|r| (r.model.b2_per_s2, r.interval_95.b2_per_s2)),
            proportional_gain: range(|r| r.proportional_gain),
            u_turn_mean_radius_m: range(|r| r.u_turn_mean_radius_m),
            repeats,
        })
    }
}

fn accepted_at(trials: &[Campaign], thrust: f64) -> Vec<(Option<u64>, &Run)> {
    let runs = trials.iter().filter_map(|campaign| {
        let run = campaign.accepted_runs().into_iter().find(|run| run.thrust == thrust)?;
        Some((campaign.seed, run))
    });
    runs.collect()
}

/// R^2 of b2 = k V^2 + c; `None` under three speeds.
pub(super) fn authority_r2(points: &[SchedulePoint<f64>]) -> Option<f64> {
    let fit = AuthorityFit::new(points, AuthorityForm::WithConstant).ok()?;
    let known: Vec<f64> =
        points.iter().filter(|p| p.surge_speed_m_s.is_some()).map(|p| p.model.b2_per_s2).collect();
    let n = known.len() as f64;
    let mean = known.iter().sum::<f64>() / n;
    let variance = known.iter().map(|b2| (b2 - mean) * (b2 - mean)).sum::<f64>() / n;
    (known.len() > 2).then(|| 1.0 - fit.rms_residual_per_s2 * fit.rms_residual_per_s2 / variance)
}

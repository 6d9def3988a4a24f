//! The cheapest change of thrust that makes the surge identifiable.

use std::cmp::Ordering;

use seatrial_core::{InvalidSetting, List, Outcome, Plan, Stage};
use serde::Serialize;

use super::{Budget, Prior, PriorSpeed, SpeedRun, duration_s, play};
use crate::motions::surge::{ExpectedRun, ExpectedSurge, SurgeBelief};

/// What the drag length may be, as parts of the one believed in: of all the widest interval counts.
const LENGTHS: [f64; 3] = [0.5, 1.0, 2.0];
/// What the lag of the thrust may be, as parts of the time constant of the speed.
const LAGS: [f64; 2] = [0.0, 0.2];
/// Runs whose costs differ by less, s, cost the same.
const SAME_COST_S: f64 = 0.5;
/// A drag length within this factor, and a lag within this part of the time constant of the speed, are known well: of equally cheap runs that
/// tell them so, the one with the better steering model is taken.
const WELL: f64 = 1.1;
const LAG_WELL: f64 = 0.1;

/// Samples of all plans that are tried, which are kept until one is chosen.
const MOST_SAMPLES: usize = 2 * Budget::OWN_SAMPLES;

/// Does a plan tell how the speed follows the thrust, and what makes it tell?
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurgeStep {
    /// What is believed of the surge.
    pub believed: SurgeBelief,
    /// What the plan tells without a further run.
    pub without: ExpectedSurge,
    /// The run that makes drag length and lag identifiable; absent where they are, or where none does.
    pub added: Option<AddedRun>,
}

/// A run that is added to a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AddedRun {
    /// Its thrust, a fraction of full.
    pub thrust: f64,
    /// Its place among the runs of the plan, from 0.
    pub place: usize,
    /// The greatest change of thrust that it makes, from and to, fractions of full.
    pub step: [f64; 2],
    /// What the trial lasts longer, s. A run whose model is not expected to be accepted is repeated, and counts as often.
    pub cost_s: f64,
    /// What the trial then tells.
    pub with: ExpectedSurge,
}

impl SurgeStep {
    /// Will the trial tell drag length and lag?
    pub fn is_identified(&self) -> bool {
        self.added.map_or(self.without, |added| added.with).is_identified()
    }
}

/// The run that makes drag length and lag identifiable in the least time, of runs at the thrusts of `others` at every place in the plan.
///
/// Each plan is played on the vehicle believed in; what its record tells are the intervals of [`ExpectedSurge`], the widest over drag
/// lengths of half to twice the believed one, l = 2 T u with the time constant T of the prior and the greatest speed u, and over lags of
/// 0 and T/5. `None` where a speed is not known. Measured: 0.02 s for a plan of one speed and 16 thrusts.
pub fn surge_step(
    plan: &Plan<f64>,
    prior: &Prior,
    others: &[PriorSpeed],
    noise_m_s: f64,
) -> Result<Option<SurgeStep>, InvalidSetting> {
    let speeds = prior.speeds.iter().map(|speed| speed.surge_speed_m_s);
    let Some(fastest_m_s) =
        speeds.collect::<Option<Vec<f64>>>().and_then(|all| all.into_iter().reduce(f64::max))
    else {
        return Ok(None);
    };
    let believed = SurgeBelief {
        drag_length_m: 2.0 * prior.surge_time_constant_s * fastest_m_s,
        thrust_lag_s: 0.0,
        noise_m_s,
    };
    let budget = Budget::of(MOST_SAMPLES);
    let (_, played) = play(plan, prior, &budget)?;
    let without = expected(prior, &played, &believed);
    let mut found = SurgeStep { believed, without, added: None };
    if !without.is_identified() {
        let now_s = duration_s(&played);
        let mut tried = with_one_more(plan, prior, others, now_s, &budget)?;
        tried.sort_by(|a, b| a.added.cost_s.total_cmp(&b.added.cost_s));
        found.added = cheapest(&tried, &believed, prior.surge_time_constant_s);
    }
    Ok(Some(found))
}

/// A plan with one more run.
struct PlanCandidate {
    /// `with` is not known yet.
    added: AddedRun,
    prior: Prior,
    played: Vec<SpeedRun>,
    /// Relative half width of the 95 % interval of a22 that the run will tell.
    a22_width: f64,
}

/// Every plan with one more run that ends within its envelope.
fn with_one_more(
    plan: &Plan<f64>,
    prior: &Prior,
    others: &[PriorSpeed],
    now_s: f64,
    budget: &Budget,
) -> Result<Vec<PlanCandidate>, InvalidSetting> {
    let mut tried = Vec::new();
    for other in others {
        for place in 0..=prior.speeds.len() {
            let mut prior = prior.clone();
            prior.speeds.insert(place, *other);
            let thrusts: Vec<f64> = prior.speeds.iter().map(|speed| speed.thrust).collect();
            let Some(list) = List::from_slice(&thrusts) else {
                continue;
            };
            let longer = Plan { thrusts: list, ..*plan };
            let played = match play(&longer, &prior, budget) {
                Ok((Some(Outcome::Finished), played)) => played,
                Err(error) if budget.is_spent() => return Err(error),
                _ => continue,
            };
            let preview = played[place].preview(other, plan, prior.heading_rad);
            let is_accepted = preview.expected.is_some_and(|found| found.is_enough());
            let times = match is_accepted {
                true => 1.0,
                false => 1.0 + f64::from(plan.max_repeats),
            };
            let added = AddedRun {
                thrust: other.thrust,
                place,
                step: greatest_step(&thrusts, place),
                cost_s: times * (duration_s(&played) - now_s),
                with: ExpectedSurge::default(),
            };
            let a22_width = preview.expected.and_then(|found| found.relative_half_width_95[0]);
            tried.push(PlanCandidate {
                added,
                prior,
                played,
                a22_width: a22_width.unwrap_or(f64::INFINITY),
            });
        }
    }
    Ok(tried)
}

/// The greater of the changes to a run and from it.
fn greatest_step(thrusts: &[f64], place: usize) -> [f64; 2] {
    let to = place.checked_sub(1).map(|k| [thrusts[k], thrusts[place]]);
    let from = thrusts.get(place + 1).map(|next| [thrusts[place], *next]);
    let size = |step: &[f64; 2]| (step[1] - step[0]).abs();
    let steps = [to, from].into_iter().flatten();
    steps.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or([thrusts[place]; 2])
}

/// Of those that make drag length and lag identifiable the cheapest; of equally cheap ones the one that tells l best, then the lag and, where
/// they tell both well, a22.
fn cheapest(
    tried: &[PlanCandidate],
    believed: &SurgeBelief,
    time_constant_s: f64,
) -> Option<AddedRun> {
    let mut most_s = f64::INFINITY;
    let mut found: Vec<(AddedRun, f64)> = Vec::new();
    for one in tried {
        if one.added.cost_s > most_s {
            break;
        }
        let with = expected(&one.prior, &one.played, believed);
        if with.is_identified() {
            most_s = most_s.min(one.added.cost_s + SAME_COST_S);
            found.push((AddedRun { with, ..one.added }, one.a22_width));
        }
    }
    let key = |(added, a22_width): &(AddedRun, f64)| {
        let factor = added.with.drag_length_factor_95.unwrap_or(f64::INFINITY);
        let lag_s = added.with.thrust_lag_half_width_95_s;
        let lag_s = lag_s.unwrap_or(f64::INFINITY);
        [factor.max(WELL), lag_s.max(LAG_WELL * time_constant_s), *a22_width]
    };
    let best = found.into_iter().min_by(|a, b| {
        let pairs = key(a).into_iter().zip(key(b));
        pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b)))
    });
    best.map(|(added, _)| added)
}

/// What a trial will tell, whatever the surge may be.
fn expected(prior: &Prior, played: &[SpeedRun], believed: &SurgeBelief) -> ExpectedSurge {
    let runs: Vec<ExpectedRun> =
        prior.speeds.iter().zip(played).map(|(speed, run)| run.expected(speed)).collect();
    let first_m_s = prior.speed_before_m_s.or_else(|| runs.first().map(|run| run.surge_speed_m_s));
    let first_m_s = first_m_s.unwrap_or_default();
    let of = |length: f64, lag: f64| {
        let belief = SurgeBelief {
            drag_length_m: length * believed.drag_length_m,
            thrust_lag_s: lag * prior.surge_time_constant_s,
            ..*believed
        };
        ExpectedSurge::of(&runs, first_m_s, &belief)
    };
    LENGTHS
        .iter()
        .flat_map(|length| LAGS.map(|lag| of(*length, lag)))
        .reduce(ExpectedSurge::wider)
        .unwrap_or_default()
}

impl SpeedRun {
    fn expected(&self, speed: &PriorSpeed) -> ExpectedRun {
        let train_s = self.begin_s(Stage::Train);
        ExpectedRun {
            thrust: speed.thrust,
            surge_speed_m_s: speed.surge_speed_m_s.unwrap_or_default(),
            settling: self.samples.iter().filter(|s| s.time_s < train_s).count(),
            samples: self.samples.clone(),
        }
    }
}

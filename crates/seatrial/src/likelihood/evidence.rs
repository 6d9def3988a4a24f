//! Every hypothesis of the table fitted to a record: the search, with warm starts from one structure to the next.

use nalgebra::DVector;

use super::fit::{Fit, Problem};
use super::hypothesis::{Disturbance, Noise, Parameter, Scale, Structure};
use super::leg::Leg;
use super::search::Effort;
use super::steering_model::SteeringModel;

/// Dampings that a first look tries, between the slowest that a record shows and the fastest that its comparisons do.
const FIRST_DAMPINGS: usize = 11;

/// Log of what is believed of no disturbance, of a drift of one of its strengths, and of a sea of one strength and the usual time constant: half
/// of all records have none, 15 % drift, 35 % are of a sea; each strength is as likely as the next.
const LOG_CALM: f64 = -0.693;
const LOG_DRIFT: f64 = -4.988;
const LOG_SEA: f64 = -5.777;

/// Nodes of a grid within so much log evidence of the best are kept.
const KEPT: f64 = 7.0;

/// Believed log2 of a sea's time constant in time constants of the vehicle: mean and deviation.
const SEA_TIME: [f64; 2] = [1.0, 2.5];

/// log2 steps of a sea's time constant, and the nodes to either side.
const TIME_STEP: f64 = 1.5;
const TIMES: i32 = 3;

/// log2 of the weakest and the strongest sea, and of the weakest and strongest drift.
const SEAS: [i32; 2] = [-12, 14];
const DRIFTS: [i32; 2] = [-9, 12];

/// A structure under a disturbance, fitted at each strength that matters.
#[derive(Clone, Debug)]
pub struct Hypothesis<'a> {
    /// What is disturbed.
    pub problem: Problem<'a>,
    /// By what.
    pub disturbance: Disturbance,
    /// Log weight and fit at each node, the best first.
    pub nodes: Vec<(f64, Fit)>,
}

impl Hypothesis<'_> {
    /// The fit of the greatest evidence.
    pub fn best(&self) -> &Fit {
        &self.nodes[0].1
    }

    /// The model of the fit of the greatest evidence.
    pub fn steering_model(&self) -> SteeringModel {
        let fit = self.best();
        let offset_rad_s2 = self.problem.start_of(&fit.x, 0).offset_rad_s2;
        SteeringModel::new(&self.problem.vehicle(&fit.x), offset_rad_s2)
    }

    /// Log evidence of all nodes together.
    pub fn log_evidence(&self) -> f64 {
        log_sum(self.nodes.iter().map(|(log, _)| *log))
    }

    /// Share of each node.
    pub fn shares(&self) -> Vec<f64> {
        shares(self.nodes.iter().map(|(log, _)| *log))
    }
}

/// Log of the sum of what these are the logs of.
pub fn log_sum(logs: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    most + libm::log(logs.map(|log| libm::exp(log - most)).sum::<f64>())
}

/// What each is of the sum of what these are the logs of.
pub fn shares(logs: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    let weights = logs.map(|log| libm::exp(log - most));
    let total: f64 = weights.clone().sum();
    weights.map(|weight| weight / total).collect()
}

/// What a structure leaves to those that start from it.
struct Solution<'a> {
    problem: Problem<'a>,
    calm: DVector<f64>,
    sea: DVector<f64>,
    sea_node: (i32, i32),
    drift_node: i32,
}

/// Fits these structures, each after its parent, under every disturbance. Empty where the record determines nothing.
///
/// `interval_s` is the usual interval between samples of the record.
pub fn hypotheses<'a>(
    legs: &'a [Leg],
    interval_s: f64,
    structures: &[Structure],
    disturbances: &[Disturbance],
) -> Vec<Hypothesis<'a>> {
    let Some([calm, whitened]) = first_looks(legs, interval_s) else {
        return Vec::new();
    };
    let scale = Scale::of(legs, interval_s, calm.0, calm.1);
    let mut solutions: Vec<Solution> = Vec::new();
    let mut all = Vec::new();
    for structure in structures {
        let problem = Problem::new(legs, *structure, scale);
        let parent = nearest_parent(structure, &solutions);
        let found = Search {
            problem: &problem,
            parent,
            whitened: [whitened.0 / calm.0, whitened.1 / calm.1],
        }
        .run(disturbances);
        if let Some((hypotheses, solution)) = found {
            all.extend(hypotheses);
            solutions.push(solution);
        }
    }
    all
}

/// The solution of the structure's parent, or of the parent's where that was not asked for.
fn nearest_parent<'s, 'a>(
    structure: &Structure,
    solutions: &'s [Solution<'a>],
) -> Option<&'s Solution<'a>> {
    let parent = structure.parent()?;
    let found = solutions.iter().find(|s| s.problem.structure == parent);
    found.or_else(|| nearest_parent(&parent, solutions))
}

/// Rate and authority to start from by output error, and by a fit under a disturbance.
fn first_looks(legs: &[Leg], interval_s: f64) -> Option<[(f64, f64); 2]> {
    let longest_s = legs.iter().map(Leg::duration_s).fold(0.0, f64::max);
    let coarsest_s =
        legs.iter().map(|leg| leg.duration_s() / (leg.len().max(2) - 1) as f64).fold(0.0, f64::max);
    let (slowest, fastest) = (libm::log(3.0 / longest_s), libm::log(0.5 / coarsest_s));
    let look = |is_whitened: bool| {
        let of = |k: usize| {
            let share = k as f64 / (FIRST_DAMPINGS - 1) as f64;
            let rate = libm::exp(slowest + share * (fastest - slowest));
            let scale = Scale::of(legs, interval_s, rate, rate);
            let problem = Problem::new(legs, Structure::FIRST_ORDER, scale);
            let noise = match is_whitened {
                true => Noise { sea: [0.6 * rate * rate, 2.0 / rate], ..Noise::NONE },
                false => Noise::NONE,
            };
            let (cost, there) = problem.linear_cost(&problem.first_guess(), &noise)?;
            Some((cost, rate, there[1] * rate))
        };
        let best = (0..FIRST_DAMPINGS).filter_map(of).min_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.2 != 0.0 && best.2.is_finite()).then_some((best.1, best.2))
    };
    Some([look(false)?, look(true)?])
}

/// The search of one structure.
struct Search<'s, 'a> {
    problem: &'s Problem<'a>,
    parent: Option<&'s Solution<'a>>,
    /// The whitened look's rate and authority over those of the scale.
    whitened: [f64; 2],
}

impl<'a> Search<'_, 'a> {
    fn run(&self, disturbances: &[Disturbance]) -> Option<(Vec<Hypothesis<'a>>, Solution<'a>)> {
        let problem = self.problem;
        let calm = self.calm()?;
        let asks = |disturbance| disturbances.contains(&disturbance);
        let drift = match asks(Disturbance::Drift) {
            true => self.drifts(&calm.x),
            false => Vec::new(),
        };
        let sea = match asks(Disturbance::Sea) {
            true => self.seas(&calm.x),
            false => Vec::new(),
        };
        let drift_node = drift.first().map_or(0, |(node, _)| *node);
        let sea_node = sea.first().map_or((-3, 0), |(node, _)| *node);
        let sea_x = sea.first().map_or_else(|| calm.x.clone(), |(_, fit)| fit.x.clone());
        let drift: Vec<(f64, Fit)> =
            drift.into_iter().map(|(_, fit)| (fit.log_evidence + LOG_DRIFT, fit)).collect();
        let (calm, drift) = match sea.is_empty() {
            true => (calm, drift),
            false => self.restarted(&sea_x, calm, drift),
        };
        let sea: Vec<(f64, Fit)> = sea
            .into_iter()
            .map(|((_, time), fit)| {
                let from = (log2_time(time) - SEA_TIME[0]) / SEA_TIME[1];
                (fit.log_evidence - 0.5 * from * from + LOG_SEA, fit)
            })
            .collect();
        let solution = Solution {
            problem: problem.clone(),
            calm: calm.x.clone(),
            sea: sea_x,
            sea_node,
            drift_node,
        };
        let of = |disturbance, nodes: Vec<(f64, Fit)>| Hypothesis {
            problem: problem.clone(),
            disturbance,
            nodes: best_first(nodes),
        };
        let mut found = Vec::new();
        if asks(Disturbance::None) {
            found.push(of(Disturbance::None, vec![(calm.log_evidence + LOG_CALM, calm)]));
        }
        for (disturbance, nodes) in [(Disturbance::Drift, drift), (Disturbance::Sea, sea)] {
            if !nodes.is_empty() {
                found.push(of(disturbance, nodes));
            }
        }
        Some((found, solution))
    }

    /// The whitened fit finds optima that output error does not: calm and drift start once more from its optimum.
    fn restarted(
        &self,
        sea: &DVector<f64>,
        calm: Fit,
        drift: Vec<(f64, Fit)>,
    ) -> (Fit, Vec<(f64, Fit)>) {
        const CLEARLY: f64 = 0.1;
        let effort = Effort { steps: 12, ..Effort::WHOLE };
        let again = |noise| self.problem.fit(sea, noise, effort);
        let better = again(Noise::NONE).filter(|f| f.log_evidence > calm.log_evidence + CLEARLY);
        let drift_again = drift.first().and_then(|(log, fit)| {
            let better = again(fit.noise)?;
            let found = better.log_evidence + LOG_DRIFT;
            (found > log + CLEARLY).then(|| vec![(found, better)])
        });
        (better.unwrap_or(calm), drift_again.unwrap_or(drift))
    }

    /// Output error from every start.
    fn calm(&self) -> Option<Fit> {
        let problem = self.problem;
        let mut starts = self.starts(|solution| &solution.calm);
        if starts.len() > 3 {
            let brief = Effort { steps: 6, tolerance: 1e-2 };
            let mut fits: Vec<Fit> =
                starts.iter().filter_map(|x| problem.fit(x, Noise::NONE, brief)).collect();
            fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            starts = fits.into_iter().take(2).map(|fit| fit.x).collect();
        }
        starts
            .iter()
            .filter_map(|x| problem.fit(x, Noise::NONE, Effort::WHOLE))
            .max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// Scaled parameters to start from.
    fn starts(&self, of: for<'s> fn(&'s Solution<'a>) -> &'s DVector<f64>) -> Vec<DVector<f64>> {
        let problem = self.problem;
        let guess = problem.first_guess();
        let Some(parent) = self.parent else {
            let mut other = guess.clone();
            other[0] *= self.whitened[0];
            other[1] *= self.whitened[1];
            return vec![guess, other];
        };
        let mut x = guess;
        problem.from_parent(&mut x, &parent.problem, of(parent));
        let mut starts = vec![x];
        for (i, parameter) in problem.parameters.iter().enumerate() {
            if parent.problem.parameters.contains(parameter) || parameter.row().starts.is_empty() {
                continue;
            }
            starts = starts
                .iter()
                .flat_map(|x| {
                    parameter.row().starts.iter().map(move |value| {
                        let mut x = x.clone();
                        x[i] = *value;
                        x
                    })
                })
                .collect();
        }
        starts.extend(self.gear_start(&starts[0]));
        starts
    }

    /// Damping and rate or play of the gear by a first look at both, without a shift: a gear that never arrives looks like a slow vehicle or a late
    /// record, and play has corners.
    fn gear_start(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        let parameters = &self.problem.parameters;
        let is_of_a_gear = |p: &Parameter| matches!(p, Parameter::RateLimit | Parameter::Play);
        let limit = parameters.iter().position(is_of_a_gear)?;
        let shift = parameters.iter().position(|p| *p == Parameter::Shift)?;
        let looks = (0..FIRST_DAMPINGS)
            .flat_map(|damping| (-3..=3).map(move |size| [damping as i32, size]));
        looks
            .filter_map(|[damping, size]| {
                let mut x = x.clone();
                x[0] = libm::exp2(f64::from(damping) - 2.0);
                x[limit] = 0.5 * f64::from(size);
                x[shift] = 0.0;
                self.problem.linear_cost(&x, &Noise::NONE)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, x)| x)
    }

    /// Nodes of the strength of a drift, those that matter, the best first.
    fn drifts(&self, start: &DVector<f64>) -> Vec<(i32, Fit)> {
        let rate = self.problem.scale.rate_per_s;
        let mut nodes: Vec<(i32, Fit)> = Vec::new();
        let effort = Effort { steps: 8, tolerance: 1e-2 };
        let mut at = |nodes: &mut Vec<(i32, Fit)>, k: i32| {
            if !(DRIFTS[0]..=DRIFTS[1]).contains(&k) || nodes.iter().any(|(node, _)| *node == k) {
                return;
            }
            let from = nodes.first().map_or(start, |(_, fit)| &fit.x);
            let noise = Noise { drift: libm::exp2(f64::from(k)) * rate.sqrt(), ..Noise::NONE };
            if let Some(fit) = self.problem.fit(from, noise, effort) {
                nodes.push((k, fit));
                nodes.sort_by(|a, b| b.1.log_evidence.total_cmp(&a.1.log_evidence));
            }
        };
        match self.parent {
            Some(parent) => at(&mut nodes, parent.drift_node),
            None => [-6, -3, 0, 3, 6, 9].into_iter().for_each(|k| at(&mut nodes, k)),
        }
        climb(&mut nodes, &mut at, |k| vec![k - 1, k + 1]);
        kept(nodes)
    }

    /// A fit under a middling sea from the better of output error's optimum and the parent's, or the whitened look's.
    fn sea_start(&self, calm: &DVector<f64>) -> Option<Fit> {
        let rate = self.problem.scale.rate_per_s;
        let mut starts = self.starts(|solution| &solution.sea);
        let other = match self.parent {
            Some(_) => starts.swap_remove(0),
            None => starts.swap_remove(1),
        };
        let middling = Noise { sea: [rate * rate, 2.0 / rate], ..Noise::NONE };
        let brief = Effort { steps: 10, ..Effort::NODE };
        [calm, &other]
            .into_iter()
            .filter_map(|x| self.problem.fit(x, middling, brief))
            .max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// Nodes of strength and time constant of a sea, those that matter, the best first.
    fn seas(&self, calm: &DVector<f64>) -> Vec<((i32, i32), Fit)> {
        let rate = self.problem.scale.rate_per_s;
        let Some(start) = self.sea_start(calm) else {
            return Vec::new();
        };
        let mut nodes: Vec<((i32, i32), Fit)> = Vec::new();
        let mut at = |nodes: &mut Vec<((i32, i32), Fit)>, (strength, time): (i32, i32)| {
            let is_within =
                (SEAS[0]..=SEAS[1]).contains(&strength) && (-TIMES..=TIMES).contains(&time);
            if !is_within || nodes.iter().any(|(node, _)| *node == (strength, time)) {
                return;
            }
            let from = nodes.first().map_or(&start.x, |(_, fit)| &fit.x);
            let noise = Noise {
                sea: [
                    libm::exp2(f64::from(strength)) * rate * rate,
                    libm::exp2(log2_time(time)) / rate,
                ],
                ..Noise::NONE
            };
            if let Some(fit) = self.problem.fit(from, noise, Effort::NODE) {
                nodes.push(((strength, time), fit));
                nodes.sort_by(|a, b| b.1.log_evidence.total_cmp(&a.1.log_evidence));
            }
        };
        match self.parent {
            Some(parent) => at(&mut nodes, parent.sea_node),
            None => [-6, -3, 0, 3, 6].into_iter().for_each(|k| at(&mut nodes, (k, 0))),
        }
        climb(&mut nodes, &mut at, |(k, t)| vec![(k + 1, t), (k - 1, t), (k, t + 1), (k, t - 1)]);
        if let Some(&((k, t), _)) = nodes.first() {
            for node in [
                (k + 1, t + 1),
                (k - 1, t + 1),
                (k + 1, t - 1),
                (k - 1, t - 1),
                (k + 2, t),
                (k - 2, t),
            ] {
                at(&mut nodes, node);
            }
        }
        kept(nodes)
    }
}

/// log2 of a sea's time constant in time constants of the vehicle.
fn log2_time(node: i32) -> f64 {
    SEA_TIME[0] + TIME_STEP * f64::from(node)
}

/// Goes on from the best node until its neighbours are no better.
fn climb<N: Copy + PartialEq>(
    nodes: &mut Vec<(N, Fit)>,
    at: &mut impl FnMut(&mut Vec<(N, Fit)>, N),
    neighbours: impl Fn(N) -> Vec<N>,
) {
    const MOST: usize = 12;
    for _ in 0..MOST {
        let Some(best) = nodes.first().map(|(node, _)| *node) else {
            return;
        };
        neighbours(best).into_iter().for_each(|node| at(nodes, node));
        if nodes.first().is_some_and(|(node, _)| *node == best) {
            return;
        }
    }
}

fn kept<N>(mut nodes: Vec<(N, Fit)>) -> Vec<(N, Fit)> {
    let most = nodes.first().map_or(0.0, |(_, fit)| fit.log_evidence);
    nodes.retain(|(_, fit)| fit.log_evidence > most - KEPT);
    nodes
}

fn best_first(mut nodes: Vec<(f64, Fit)>) -> Vec<(f64, Fit)> {
    nodes.sort_by(|a, b| b.0.total_cmp(&a.0));
    nodes
}

#[cfg(test)]
mod tests {
    use seatrial_core::Sample;

    use super::super::steering_model::SteeringState;
    use super::*;
    use crate::draw::Draw;

    const INTERVAL_S: f64 = 0.1;

    /// A minute of a model with 0.06 deg of compass noise.
    fn leg(model: &SteeringModel) -> Leg {
        const LEVELS_RAD: [f64; 6] = [0.3, -0.3, 0.15, -0.15, 0.3, 0.0];
        let at = |k: usize| Sample {
            time_s: k as f64 * INTERVAL_S,
            rudder_rad: LEVELS_RAD[k / 33 % 6],
            ..Sample::default()
        };
        let mut samples: Vec<Sample<f64>> = (0..600).map(at).collect();
        let mut draw = Draw::new(1);
        let states = model.simulate(&samples, SteeringState::default());
        for (sample, state) in samples.iter_mut().zip(states) {
            sample.heading_rad = state.heading_rad + 1e-3 * draw.normal();
        }
        Leg::new(&samples, 1)
    }

    /// A structure explains a record of its own vehicle clearly better than the one that it starts from.
    #[test]
    fn recover_each_structure_of_the_table() {
        const CLEARLY: f64 = 5.0;
        let [rate, authority] = [0.8, 0.5];
        let plain =
            SteeringModel { a22_per_s: -rate, b2_per_s2: authority, ..SteeringModel::default() };
        let scale = Scale::of(&[leg(&plain)], INTERVAL_S, rate, authority);
        for (structure, _, words) in &Structure::TABLE[1..] {
            let parameters = structure.parameters();
            let far = |p: &Parameter| {
                let deviation = p.row().prior_deviation.unwrap_or(1.0);
                p.row().starts.last().copied().unwrap_or(deviation)
            };
            let scaled: Vec<f64> = parameters.iter().map(far).collect();
            let model = SteeringModel::new(&scale.vehicle(&parameters, &scaled), 0.0);
            let mut chain: Vec<_> =
                std::iter::successors(Some(*structure), Structure::parent).collect();
            chain.reverse();
            let legs = [leg(&model)];
            let all = hypotheses(&legs, INTERVAL_S, &chain, &[Disturbance::None]);
            let [.., parent, own] = &all[..] else { panic!("{words}: {}", all.len()) };
            let lead = own.log_evidence() - parent.log_evidence();
            println!("{words}: {lead}");
            assert!(lead > CLEARLY, "{words}: {lead} over {}", parent.problem.structure.in_words());
        }
    }
}

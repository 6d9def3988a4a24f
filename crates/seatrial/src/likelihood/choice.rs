//! The choice between hypotheses: prediction of data left out, and what is left of evidence.

use super::evidence::{Hypothesis, hypotheses, shares};
use super::hypothesis::{Disturbance, Parameter, Structure};
use super::left_out::{blocks, free_run_rad2, heading_variance_rad2, without};
use super::leg::Leg;
use super::sea_test::{NEGLIGIBLE, SeaTest, sea_test};
use crate::draw::Draw;
use crate::record::{between_gaps, duration_s, median_interval_s};
use nalgebra::DVector;
use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

/// Standard errors by which a hypothesis may predict worse than the best: 1 throws true seas out, 2 keeps false ones.
const WORSE: f64 = 1.5;

/// Log mean square by which a hypothesis may predict worse, whatever the blocks' scatter.
const NEGLIGIBLY_WORSE: f64 = 0.02;

/// Standard errors and log mean square by which no sea predicts worse than the best: one that does has eaten a hull. Tankers' zig-zags had 3 to 6
/// and 0.6 to 2.7; without the second a delayed rudder of `examples/hulls` was taken for a hull.
const SURELY_WORSE: f64 = 2.5;
const BADLY: f64 = 0.5;

/// Draws of the Bayesian bootstrap over blocks.
const BOOTSTRAP: usize = 400;

/// Most comparisons of a record, so that a contest stays a matter of a second.
const MOST_COMPARISONS: usize = 200;

/// Fewest comparisons of a record.
const LEAST_COMPARISONS: usize = 20;

/// A hypothesis as documents show it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeighedHypothesis {
    /// Structure and disturbance in words.
    pub name: String,
    /// The structure.
    pub structure: Structure,
    /// The disturbance.
    pub disturbance: Disturbance,
    /// Share of the weight.
    pub weight: f64,
    /// Mean log of the mean square error, rad^2, on data left out.
    pub score: f64,
}

/// The whole table against samples of one record. `None` where they determine nothing.
///
/// Headings are averaged to at most 200 comparisons. `legs` keeps what the contest borrows.
pub fn contest_of<'a>(samples: &[Sample<f64>], legs: &'a mut Vec<Leg>) -> Option<Contest<'a>> {
    *legs = legs_of(&[samples]);
    let interval_s = duration_s(samples) / (samples.len().max(2) - 1) as f64;
    let structures = Structure::TABLE.map(|(structure, ..)| structure);
    contest_among(legs, interval_s, &structures, &Disturbance::ALL)
}

/// Hulls under a drifting heading against samples of one record or of several, which are apart by gaps.
pub fn contest_of_hulls<'a>(
    samples: &[Sample<f64>],
    legs: &'a mut Vec<Leg>,
) -> Option<Contest<'a>> {
    let usual_s = median_interval_s(samples)?;
    let parts: Vec<&[Sample<f64>]> =
        between_gaps(samples).filter(|part| part.len() > LEAST_COMPARISONS).collect();
    *legs = legs_of(&parts);
    contest_among(legs, usual_s, &Structure::HULLS, &[Disturbance::Drift])
}

fn legs_of(parts: &[&[Sample<f64>]]) -> Vec<Leg> {
    let total: usize = parts.iter().map(|part| part.len()).sum();
    let block = total.div_ceil(MOST_COMPARISONS * parts.len().max(1));
    parts.iter().map(|part| Leg::new(part, block)).collect()
}

fn contest_among<'a>(
    legs: &'a [Leg],
    interval_s: f64,
    structures: &[Structure],
    disturbances: &[Disturbance],
) -> Option<Contest<'a>> {
    if legs.iter().map(Leg::len).sum::<usize>() < LEAST_COMPARISONS {
        return None;
    }
    Contest::of(legs, interval_s, structures, disturbances)
}

/// A hypothesis in the contest.
#[derive(Clone, Debug)]
pub struct Candidate<'a> {
    /// Structure, disturbance and fits.
    pub hypothesis: Hypothesis<'a>,
    /// Scaled parameters without each block.
    pub without: Vec<DVector<f64>>,
    /// Log of the mean square of the free run over each block, with an error that nobody cares for.
    pub scores: Vec<f64>,
    /// Least R^2 of the heading over the blocks.
    pub least_r2: f64,
    /// Mean score less that of the best, and its standard error.
    pub behind: [f64; 2],
    /// How far a sea lies from its own draws.
    pub sea_test: Option<SeaTest>,
    /// Share of the weight.
    pub weight: f64,
}

/// All hypotheses of a record with their weights.
#[derive(Clone, Debug)]
pub struct Contest<'a> {
    /// Every hypothesis, in the order of the table.
    pub candidates: Vec<Candidate<'a>>,
}

impl Candidate<'_> {
    /// Mean score over the blocks: log mean square of what was left out.
    pub fn score(&self) -> f64 {
        self.scores.iter().sum::<f64>() / self.scores.len().max(1) as f64
    }

    /// Is it no sea, or one that its own draws explain?
    pub fn passes_as_a_sea(&self) -> bool {
        self.sea_test.is_none_or(|test| test.is_a_sea())
    }

    /// Is it a first-order vehicle, whose gear lags at most, in a sea that its own draws explain?
    pub fn is_of_first_order_in_a_sea(&self) -> bool {
        self.hypothesis.disturbance == Disturbance::Sea
            && self.passes_as_a_sea()
            && !self.is_of_another_structure()
    }

    /// Is its hull, or its gear but for a lag, not that of first order?
    pub fn is_of_another_structure(&self) -> bool {
        self.hypothesis.problem.structure.exceeds_a_lag()
    }

    /// Does it predict so much worse than the best that no sea is why?
    pub fn predicts_badly(&self) -> bool {
        let [behind, error] = self.behind;
        behind > BADLY.max(SURELY_WORSE * error)
    }

    /// Does it predict about as well as the best, and do its own draws explain it where it is a sea?
    fn remains(&self) -> bool {
        let [behind, error] = self.behind;
        self.passes_as_a_sea() && (behind <= WORSE * error || behind < NEGLIGIBLY_WORSE)
    }
}

impl<'a> Contest<'a> {
    /// Of a record. `None` where it determines nothing.
    pub fn of(
        legs: &'a [Leg],
        interval_s: f64,
        structures: &[Structure],
        disturbances: &[Disturbance],
    ) -> Option<Self> {
        let all = hypotheses(legs, interval_s, structures, disturbances);
        let tests: Vec<Option<SeaTest>> = all.iter().map(|h| sea_test_of(h, &all)).collect();
        let candidates: Vec<Candidate> = all
            .into_iter()
            .zip(tests)
            .map(|(hypothesis, sea_test)| Candidate::new(hypothesis, sea_test))
            .collect();
        candidates.iter().find(|c| c.passes_as_a_sea())?;
        let mut contest = Self { candidates };
        contest.weigh();
        Some(contest)
    }

    /// The contest without the hypotheses of a sea.
    #[must_use]
    pub fn calm(mut self) -> Self {
        self.candidates.retain(|c| c.hypothesis.disturbance != Disturbance::Sea);
        self.weigh();
        self
    }

    /// The contest of first-order vehicles in a sea alone, weighed by evidence: what a sea does to a free run tells none of them from another.
    #[must_use]
    pub fn in_a_sea(mut self) -> Self {
        self.candidates.retain(Candidate::is_of_first_order_in_a_sea);
        let weights = by_evidence(&self.candidates, |_| true);
        self.take(&weights);
        self
    }

    /// A sea that is left is weighed by evidence; else each hypothesis by how often it would predict best.
    fn weigh(&mut self) {
        let best = (self.candidates.iter())
            .filter(|c| c.passes_as_a_sea())
            .min_by(|a, b| a.score().total_cmp(&b.score()))
            .map_or_else(Vec::new, |c| c.scores.clone());
        for candidate in &mut self.candidates {
            candidate.behind = mean_and_error(&candidate.scores, &best);
        }
        let is_sea = |c: &Candidate| c.hypothesis.disturbance == Disturbance::Sea;
        let weights = match self.candidates.iter().any(|c| c.remains() && is_sea(c)) {
            true => by_evidence(&self.candidates, |c| c.remains()),
            false => by_prediction(&self.candidates),
        };
        self.take(&weights);
    }

    fn take(&mut self, weights: &[f64]) {
        let total: f64 = weights.iter().sum();
        for (candidate, weight) in self.candidates.iter_mut().zip(weights) {
            candidate.weight = weight / total.max(f64::MIN_POSITIVE);
        }
    }

    /// The hypothesis with the most weight.
    pub fn heaviest(&self) -> &Candidate<'a> {
        let heavier = |a: &&Candidate, b: &&Candidate| a.weight.total_cmp(&b.weight);
        self.candidates.iter().max_by(heavier).unwrap_or(&self.candidates[0])
    }

    /// The hypothesis that is handed over to predict: the heaviest where the gear differs from first order; else sway and yaw with damping that
    /// grows, fitted to a drifting heading.
    ///
    /// Their priors take sway and the growth of the damping out where the record does not ask for them. On 196 pairs of records of eight ships
    /// and conditions this one predicts headings with R^2 0.94 in the mean, the heaviest with 0.92 where that is a hull.
    pub fn predictor(&self) -> &Candidate<'a> {
        let heaviest = self.heaviest();
        let structure = heaviest.hypothesis.problem.structure;
        let is_general = |c: &&Candidate| {
            c.hypothesis.problem.structure == Structure::SWAY_QUADRATIC
                && c.hypothesis.disturbance == Disturbance::Drift
        };
        match self.candidates.iter().find(is_general) {
            Some(general) if !structure.has_own_gear() => general,
            _ => heaviest,
        }
    }

    /// Hypotheses of at least a hundredth of the weight, the heaviest first.
    pub fn weighed(&self) -> Vec<WeighedHypothesis> {
        const LEAST: f64 = 0.01;
        let mut weighed: Vec<WeighedHypothesis> = (self.candidates.iter())
            .filter(|c| c.weight >= LEAST)
            .map(|c| {
                let (structure, disturbance) =
                    (c.hypothesis.problem.structure, c.hypothesis.disturbance);
                WeighedHypothesis {
                    name: format!("{}, {disturbance}", structure.in_words()),
                    structure,
                    disturbance,
                    weight: c.weight,
                    score: c.score(),
                }
            })
            .collect();
        weighed.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        weighed
    }

    /// Do data left out ask for play of the gear? Not where a hypothesis without play predicts them about as well.
    pub fn asks_for_play(&self) -> bool {
        let predicts = |has_play: bool| {
            let is_of =
                |c: &Candidate| c.hypothesis.problem.structure.has(Parameter::Play) == has_play;
            self.candidates.iter().any(|c| is_of(c) && c.remains())
        };
        predicts(true) && !predicts(false)
    }

    /// Log evidence by which the best structure beyond first order leads.
    pub fn lead_over_first_order(&self) -> f64 {
        let best = |is_beyond: bool| {
            let all = self.candidates.iter().map(|c| &c.hypothesis);
            let of = all.filter(|h| h.problem.structure.exceeds_first_order() == is_beyond);
            of.map(Hypothesis::log_evidence).fold(f64::NEG_INFINITY, f64::max)
        };
        best(true) - best(false)
    }
}

impl<'a> Candidate<'a> {
    fn new(hypothesis: Hypothesis<'a>, sea_test: Option<SeaTest>) -> Self {
        let problem = &hypothesis.problem;
        let negligible = (NEGLIGIBLE * problem.scale.heading_rad).powi(2);
        let blocks = blocks(problem);
        let without: Vec<DVector<f64>> =
            blocks.iter().map(|block| without(problem, hypothesis.best(), block)).collect();
        let squares: Vec<f64> = (blocks.iter().zip(&without))
            .map(|(block, x)| free_run_rad2(problem, x, block))
            .collect();
        let least_r2 = (blocks.iter().zip(&squares))
            .map(|(block, square)| 1.0 - square / heading_variance_rad2(problem, block))
            .fold(1.0, f64::min);
        let scores = squares.iter().map(|square| libm::log(square + negligible));
        Self {
            without,
            scores: scores.collect(),
            least_r2,
            behind: [0.0; 2],
            sea_test,
            weight: 0.0,
            hypothesis,
        }
    }
}

/// `None` of what is no sea, and where no output error of the same structure was asked for.
fn sea_test_of(hypothesis: &Hypothesis, all: &[Hypothesis]) -> Option<SeaTest> {
    if hypothesis.disturbance != Disturbance::Sea {
        return None;
    }
    let problem = &hypothesis.problem;
    let is_mate = |h: &&Hypothesis| {
        h.problem.structure == problem.structure && h.disturbance == Disturbance::None
    };
    let mate = all.iter().find(is_mate)?;
    sea_test(problem, mate.best(), hypothesis.best())
}

fn mean_and_error(scores: &[f64], best: &[f64]) -> [f64; 2] {
    let apart: Vec<f64> = scores.iter().zip(best).map(|(a, b)| a - b).collect();
    let n = apart.len() as f64;
    if apart.len() < 2 {
        return [apart.first().copied().unwrap_or(0.0), 1.0];
    }
    let mean = apart.iter().sum::<f64>() / n;
    let variance = apart.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, (variance / n).sqrt()]
}

fn by_evidence(candidates: &[Candidate], is_in: impl Fn(&Candidate) -> bool) -> Vec<f64> {
    let logs = |c: &Candidate| match is_in(c) {
        true => c.hypothesis.log_evidence(),
        false => f64::NEG_INFINITY,
    };
    shares(candidates.iter().map(logs))
}

/// How often each would have been the best predictor: a Bayesian bootstrap over the blocks (Rubin 1981).
fn by_prediction(candidates: &[Candidate]) -> Vec<f64> {
    let blocks = candidates.first().map_or(0, |c| c.scores.len());
    let stays = |c: &&Candidate| {
        let [behind, error] = c.behind;
        c.remains() && (behind <= error || behind < NEGLIGIBLY_WORSE)
    };
    let mut wins = vec![0.0; candidates.len()];
    let mut draw = Draw::new(0);
    for _ in 0..BOOTSTRAP {
        let shares: Vec<f64> = (0..blocks).map(|_| -libm::log(1.0 - draw.uniform())).collect();
        let score =
            |c: &Candidate| -> f64 { c.scores.iter().zip(&shares).map(|(s, w)| s * w).sum() };
        let best = candidates
            .iter()
            .enumerate()
            .filter(|(_, c)| stays(c))
            .min_by(|a, b| score(a.1).total_cmp(&score(b.1)));
        if let Some((winner, _)) = best {
            wins[winner] += 1.0;
        }
    }
    wins
}

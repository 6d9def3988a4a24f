//! The search for the hypotheses that carry weight.

use seatrial_core::refine::DISTURBANCE_TIME_CONSTANTS;

use super::hypothesis::{CAUTIOUS, EXPECTED, Hypothesis, Prior, STRENGTH_RATIO};
use super::noise::Noise;
use super::peak::Search;
use super::record::{A22, Point, Record};

/// The priors that hypotheses are averaged under.
const PRIORS: [Prior; 2] = [EXPECTED, CAUTIOUS];

/// Most strengths looked at either way.
const MOST_STRENGTHS: i32 = 20;

/// A disturbance of more than this share of the rudder's effect explains any record.
const LARGEST_SHARE: f64 = 1.0;

/// A disturbance of less than this share is none.
const SMALLEST_SHARE: f64 = 1e-4;

/// No disturbance that is expected is below this share.
const UNEXPECTED_SHARE: f64 = 2e-3;

/// A log likelihood this far below the best of its time constant has no weight.
const UNLIKELY: f64 = 7.0;

/// A hypothesis whose log weight is this far below the heaviest under each prior moves neither estimate nor interval.
const NEGLIGIBLE: f64 = 10.0;

/// What a disturbance may add to the log evidence of none or of its stronger neighbour, if neither has weight.
const SURPRISE: f64 = 3.0;

/// Log of what lag and shift make of a record's evidence where all disturbances are looked at with a lag, too.
const NO_LAG: f64 = -2.0;

/// Passes of Gauss and Newton: the first search, and one from its neighbour.
const FIRST_PASSES: u32 = 25;
const MORE_PASSES: u32 = 8;

/// The hypotheses found so far.
#[derive(Clone, Debug)]
pub struct HypothesisSearch {
    /// All that were looked at.
    pub all: Vec<Hypothesis>,
    /// Log weight of the heaviest under each prior.
    heaviest: [f64; PRIORS.len()],
}

impl HypothesisSearch {
    /// Nothing yet.
    pub fn nothing() -> Self {
        Self::of(Vec::new())
    }

    fn of(all: Vec<Hypothesis>) -> Self {
        let of_each = |prior| all.iter().map(move |h: &Hypothesis| h.log_weight(prior));
        Self {
            heaviest: PRIORS
                .each_ref()
                .map(|prior| of_each(prior).fold(f64::NEG_INFINITY, f64::max)),
            all,
        }
    }

    fn push(&mut self, hypothesis: Hypothesis) {
        for (heaviest, prior) in self.heaviest.iter_mut().zip(&PRIORS) {
            *heaviest = heaviest.max(hypothesis.log_weight(prior));
        }
        self.all.push(hypothesis);
    }

    /// Log of the weight that kind, share and evidence would have beside the heaviest, under the prior that gives it more.
    fn log_weight(&self, prompt: bool, share: f64, log_evidence: f64) -> f64 {
        let beside = |(prior, heaviest): (&Prior, &f64)| {
            prior.log_of(prompt, share) + log_evidence - heaviest
        };
        let priors = PRIORS.iter().zip(&self.heaviest);
        priors.map(beside).fold(f64::NEG_INFINITY, f64::max)
    }

    fn is_negligible(&self, hypothesis: &Hypothesis) -> bool {
        let Hypothesis { peak, share, .. } = hypothesis;
        self.log_weight(peak.prompt, *share, hypothesis.log_evidence) < -NEGLIGIBLE
    }

    /// The peak under one noise, found more closely where it carries weight.
    fn find(&mut self, search: &mut Search, noise: Noise, passes: u32) -> Option<Hypothesis> {
        let record = search.record();
        let peak = search
            .peak(noise, passes, |peak| !self.is_negligible(&Hypothesis::of(*peak, record)))?;
        let hypothesis = Hypothesis::of(peak, record);
        self.push(hypothesis);
        Some(hypothesis)
    }

    /// A rudder that acts at once or with the known delay; the hypothesis without a disturbance. `None` where the record determines
    /// no vehicle.
    pub fn prompt_rudder(
        &mut self,
        record: &Record,
        start: &Point,
        block: usize,
    ) -> Option<Hypothesis> {
        let mut search = Search::new(record, start, block, true);
        let calm = self.find(&mut search, none(start), FIRST_PASSES)?;
        self.disturbed(&search, &calm);
        Some(calm)
    }

    /// A rudder that may lag. Where lag and shift make the record clearly less likely, in a calm sea and in the heaviest disturbance of
    /// each time constant for a prompt rudder, only disturbances are looked at that may carry weight with a lag, too.
    pub fn lagging_rudder(
        &mut self,
        record: &Record,
        start: &Point,
        block: usize,
        prompt: Option<&Hypothesis>,
    ) -> Option<Hypothesis> {
        let mut disturbed: Vec<Hypothesis> =
            self.all.iter().filter(|h| h.share > 0.0).copied().collect();
        let mut search = Search::new(record, start, block, false);
        let calm = self.find(&mut search, none(start), FIRST_PASSES)?;
        let Some(prompt) = prompt else {
            self.disturbed(&search, &calm);
            return Some(calm);
        };
        let mut of_lag = calm.log_evidence - prompt.log_evidence;
        let in_calm = search.clone();
        let mut heaviest = heaviest_of_each_time_constant(&disturbed);
        heaviest.retain(|h| !self.is_negligible(h));
        for prompt in &heaviest {
            if let Some(lagging) = self.find(&mut search, prompt.peak.noise, MORE_PASSES) {
                of_lag = of_lag.max(lagging.log_evidence - prompt.log_evidence);
            }
            disturbed.retain(|h| h.peak.noise != prompt.peak.noise);
        }
        if of_lag > NO_LAG {
            let mut kept = std::mem::take(&mut self.all);
            kept.retain(|h| h.peak.prompt || h.share == 0.0);
            *self = Self::of(kept);
            self.disturbed(&in_calm, &calm);
            return Some(calm);
        }
        for prompt in &disturbed {
            let expected = prompt.log_evidence + of_lag + SURPRISE;
            if self.log_weight(false, prompt.share, expected) > -NEGLIGIBLE {
                self.find(&mut search, prompt.peak.noise, MORE_PASSES);
            }
        }
        Some(calm)
    }

    /// The peaks of all disturbances that carry weight: for each time constant by octaves of strength.
    fn disturbed(&mut self, calm_search: &Search, calm: &Hypothesis) {
        let record = calm_search.record();
        let scale = record.rate_scale(calm.peak.point.0[A22]);
        for ratio in DISTURBANCE_TIME_CONSTANTS {
            self.of_time_constant(calm_search, &Strengths::new(calm, scale, ratio));
        }
    }

    /// By octaves from the middle strength to the stronger and to the weaker ones.
    fn of_time_constant(&mut self, calm_search: &Search, strengths: &Strengths) {
        let mut search = calm_search.clone();
        let noise = strengths.noise(strengths.middle(), strengths.calm);
        let Some(middle) = self.find(&mut search, noise, MORE_PASSES) else {
            return;
        };
        let mut likeliest = middle.log_evidence;
        let weaker = 1.0 / STRENGTH_RATIO;
        for ratio in [STRENGTH_RATIO, weaker] {
            let mut search = search.clone();
            let mut last = middle;
            for _ in 0..MOST_STRENGTHS {
                if ratio == weaker && self.none_weaker(&last, strengths.calm) {
                    break;
                }
                let noise = strengths.noise(last.peak.noise.relative * ratio, &last);
                let Some(next) = self.find(&mut search, noise, MORE_PASSES) else {
                    break;
                };
                likeliest = likeliest.max(next.log_evidence);
                let is_last = match ratio == weaker {
                    true => next.share < SMALLEST_SHARE,
                    false => next.share > LARGEST_SHARE,
                };
                let is_falling = next.log_evidence < last.log_evidence;
                let is_unlikely = next.log_evidence < likeliest - UNLIKELY;
                if is_last || is_unlikely || (is_falling && self.is_negligible(&next)) {
                    break;
                }
                last = next;
            }
        }
    }

    /// Has a disturbance that is weaker than the last one no weight? Where it is almost none the prior knows it.
    fn none_weaker(&self, last: &Hypothesis, calm: &Hypothesis) -> bool {
        let most = last.log_evidence.max(calm.log_evidence) + SURPRISE;
        let share = last.share / STRENGTH_RATIO;
        share < UNEXPECTED_SHARE && self.log_weight(last.peak.prompt, share, most) < -NEGLIGIBLE
    }
}

/// Of the disturbances of each time constant the one that weighs most in the interval.
fn heaviest_of_each_time_constant(disturbed: &[Hypothesis]) -> Vec<Hypothesis> {
    let of_one =
        disturbed.chunk_by(|a, b| a.peak.noise.time_constant_s == b.peak.noise.time_constant_s);
    let heavier = |a: &&Hypothesis, b: &&Hypothesis| {
        a.log_weight(&CAUTIOUS).total_cmp(&b.log_weight(&CAUTIOUS))
    };
    of_one.filter_map(|of_one| of_one.iter().max_by(heavier).copied()).collect()
}

/// No disturbance.
fn none(start: &Point) -> Noise {
    Noise { relative: 0.0, time_constant_s: 1.0, a22_per_s: start.0[A22] }
}

/// Disturbances of one time constant.
struct Strengths<'a> {
    calm: &'a Hypothesis,
    scale: f64,
    time_constant_s: f64,
}

impl<'a> Strengths<'a> {
    fn new(calm: &'a Hypothesis, scale: f64, ratio: f64) -> Self {
        Self { calm, scale, time_constant_s: ratio / scale }
    }

    /// Where disturbance and noise move the heading alike.
    fn middle(&self) -> f64 {
        0.1 * self.scale * self.scale
    }

    /// Of a vehicle whose damping is that of a neighbour.
    fn noise(&self, relative: f64, neighbour: &Hypothesis) -> Noise {
        let a22_per_s = neighbour.peak.point.0[A22];
        Noise {
            relative,
            time_constant_s: self.time_constant_s,
            a22_per_s: a22_per_s.clamp(-3.0 * self.scale, -0.3 * self.scale),
        }
    }
}

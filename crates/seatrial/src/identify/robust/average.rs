//! The average over all disturbances, with and without a lag.

use seatrial_core::refine::quantile;

use super::hypothesis::{Hypothesis, Prior};
use super::hypothesis_search::HypothesisSearch;
use super::record::{A22, B2, DELAY, PARAMETERS, Point, Record};
use crate::likelihood::evidence::{log_sum, shares};

/// Hypotheses of less weight move no end of an interval by a millionth of its width.
const LEAST_WEIGHT: f64 = 1e-9;

/// All hypotheses of a record.
#[derive(Clone, Debug)]
pub struct Hypotheses {
    /// At least one.
    pub all: Vec<Hypothesis>,
    /// Output error with a lag: no disturbance.
    pub white: Hypothesis,
    /// Samples of a comparison.
    pub block: usize,
}

impl Hypotheses {
    /// `None` where the record determines no vehicle.
    pub fn of(record: &Record) -> Option<Self> {
        let start = record.start()?;
        Self::from_start(record, &start, record.block(start.0[A22]))
    }

    /// [`of`](Self::of) with comparisons of so many samples: evidence of one record is compared only where it is of as many comparisons.
    pub fn of_comparisons(record: &Record, block: usize) -> Option<Self> {
        Self::from_start(record, &record.start()?, block)
    }

    fn from_start(record: &Record, start: &Point, block: usize) -> Option<Self> {
        let mut found = HypothesisSearch::nothing();
        let prompt = found.prompt_rudder(record, start, block);
        let lagging = match record.known_delay_s {
            Some(_) => None,
            None => found.lagging_rudder(record, start, block, prompt.as_ref()),
        };
        let white = lagging.or(prompt)?;
        Some(Self { all: found.all, white, block })
    }

    /// Log of the probability of the record under a prior.
    pub fn log_evidence(&self, prior: &Prior) -> f64 {
        log_sum(self.all.iter().map(|h| h.log_weight(prior)))
    }

    fn weights(&self, prior: &Prior) -> Vec<f64> {
        shares(self.all.iter().map(|h| h.log_weight(prior)))
    }

    /// The mean of a quantity.
    pub fn mean_of(&self, prior: &Prior, quantity: impl Fn(&Hypothesis) -> f64) -> f64 {
        let weights = self.weights(prior);
        self.all.iter().zip(weights).map(|(h, w)| w * quantity(h)).sum()
    }

    /// The mean of all parameters.
    pub fn mean(&self, prior: &Prior) -> [f64; PARAMETERS] {
        let weights = self.weights(prior);
        core::array::from_fn(|i| self.all.iter().zip(&weights).map(|(h, w)| w * h.mean[i]).sum())
    }

    /// Mean square distance from an estimate.
    pub fn covariance(
        &self,
        prior: &Prior,
        about: &[f64; PARAMETERS],
    ) -> [[f64; PARAMETERS]; PARAMETERS] {
        let weights = self.weights(prior);
        let of = |i: usize, j: usize| {
            let terms = self.all.iter().zip(&weights).map(|(h, w)| {
                w * (h.covariance[i][j] + (h.mean[i] - about[i]) * (h.mean[j] - about[j]))
            });
            terms.sum()
        };
        core::array::from_fn(|i| core::array::from_fn(|j| of(i, j)))
    }

    /// The 2.5 and 97.5 % points of a parameter, each hypothesis with so much more variance.
    pub fn interval_95(&self, prior: &Prior, parameter: usize, more: f64) -> [f64; 2] {
        let weighted: Vec<(f64, &Hypothesis)> = (self.weights(prior).into_iter().zip(&self.all))
            .filter(|(weight, _)| *weight > LEAST_WEIGHT)
            .collect();
        let total: f64 = weighted.iter().map(|(weight, _)| weight).sum();
        let normals = || {
            weighted.iter().map(|(weight, h)| {
                let variance = h.covariance[parameter][parameter] + more;
                let deviation = variance.max(f64::MIN_POSITIVE).sqrt();
                (weight / total, h.mean[parameter], deviation)
            })
        };
        [0.025, 0.975].map(|share| quantile(normals, share))
    }

    /// The most probable one.
    pub fn likeliest(&self, prior: &Prior) -> &Hypothesis {
        let weights = self.weights(prior);
        let best = (self.all.iter().zip(weights)).max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(&self.white, |(hypothesis, _)| hypothesis)
    }

    /// The one of a kind under which the record is likeliest.
    pub fn likeliest_of(&self, is_of_kind: impl Fn(&Hypothesis) -> bool) -> Option<&Hypothesis> {
        let of_kind = self.all.iter().filter(|h| is_of_kind(h));
        of_kind.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// Standard deviation of lag and shift together if the rudder lags, s, whatever is believed of that.
    pub fn delay_deviation_s(&self) -> f64 {
        let lagging = self.likeliest_of(|h| !h.peak.prompt).unwrap_or(&self.white);
        lagging.covariance[DELAY][DELAY].sqrt()
    }

    /// d[a22, b2] / d delay, 1/s^2 and 1/s^3.
    pub fn lag_slope(&self) -> [f64; 2] {
        let lagging = self.likeliest_of(|h| !h.peak.prompt).unwrap_or(&self.white);
        let of_delay = &lagging.covariance[DELAY];
        [A22, B2].map(|i| of_delay[i] / of_delay[DELAY])
    }
}

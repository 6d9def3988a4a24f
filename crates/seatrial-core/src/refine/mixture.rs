//! The average over all disturbances.

use core::f64::consts::{FRAC_1_SQRT_2, TAU};

use libm::{erfc, exp, log, sqrt};

use super::interpolated::{Near, PeakGuess};
use super::{DISTURBANCE_TIME_CONSTANTS, Disturbance, Peak, RefineFailure, Series, Span};
use crate::{List, YawModel};

/// Ratio between neighbouring strengths of the disturbance.
const STRENGTH_RATIO: f64 = 2.0;

/// Most strengths looked at either way: beyond, a disturbance explains a record such as one with spikes equally well
/// whatever its strength.
const MOST_STRENGTHS: usize = 24;

/// No disturbance, and for each time constant the one in the middle and those to either side.
const MOST_HYPOTHESES: usize = 1 + DISTURBANCE_TIME_CONSTANTS.len() * (1 + 2 * MOST_STRENGTHS);

/// A log likelihood this far below the best has no weight.
const NEGLIGIBLE: f64 = 8.0;

/// A disturbance that changes the log likelihood by less is so weak that what it changes goes with the square of its strength, but for the
/// fourth power.
const WEAK: f64 = 0.5;

/// So far below, it has none under any prior, and its peak may be read off roughly.
const OF_INTEREST: f64 = 50.0;

/// One that is foreseen to be so far below need not be looked at.
const CERTAINLY_NEGLIGIBLE: f64 = 10.0;

/// A disturbance that changes the log likelihood by less is as good as none.
const VANISHED: f64 = 0.02;

/// The refined estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// The model: the mean of the mixture.
    pub model: YawModel<f64>,
    /// 95 % interval of a22, 1/s.
    pub a22_per_s: [f64; 2],
    /// 95 % interval of b2, 1/s^2.
    pub b2_per_s2: [f64; 2],
    /// 95 % interval of C0, rad/s^2.
    pub c0_rad_per_s2: [f64; 2],
    /// 95 % interval of the offset angle, rad; `None` where that of b2 holds 0.
    pub delta0_rad: Option<[f64; 2]>,
    /// Covariance of [a22, b2, C0].
    pub covariance: [[f64; 3]; 3],
    /// Standard deviation of the heading noise, rad.
    pub heading_noise_rad: f64,
    /// Standard deviation of the yaw acceleration disturbance, rad/s^2.
    pub disturbance_rad_s2: f64,
}

/// A disturbance and what the record says if it is the true one.
#[derive(Clone, Copy, Debug, Default)]
struct Hypothesis {
    /// Its standard deviation over the rudder's effect, b2 times the rudder's amplitude; 0 for none.
    share: f64,
    /// Log of the probability of the record.
    log_evidence: f64,
    disturbance_rad_s2: f64,
    heading_noise_rad: f64,
    mean: [f64; 3],
    covariance: [[f64; 3]; 3],
}

impl Hypothesis {
    fn of(peak: &Peak, rudder_amplitude_rad: f64) -> Self {
        let heading_noise_rad = sqrt(peak.fit.noise_variance_rad2);
        let disturbance_rad_s2 = peak.disturbance.relative * heading_noise_rad;
        let [b2, _] = peak.fit.linear;
        let (mean, covariance) = peak.normal();
        Self {
            share: disturbance_rad_s2 / (b2.abs() * rudder_amplitude_rad),
            log_evidence: peak.fit.log_likelihood + 0.5 * log(peak.variance),
            disturbance_rad_s2,
            heading_noise_rad,
            mean,
            covariance,
        }
    }

    /// Mean and variance of the I-th of [a22, b2, C0].
    fn parameter<const I: usize>(&self) -> (f64, f64) {
        (self.mean[I], self.covariance[I][I])
    }

    /// Mean and variance of delta0 = C0/b2 by the delta method.
    fn offset_angle(&self) -> (f64, f64) {
        let [_, b2, c0] = self.mean;
        let gradient = [0.0, -c0 / (b2 * b2), 1.0 / b2];
        let rows = self.covariance.iter().zip(gradient);
        let variance = rows.map(|(row, g)| {
            let row: f64 = row.iter().zip(gradient).map(|(c, h)| c * h).sum();
            g * row
        });
        (c0 / b2, variance.sum())
    }
}

/// What is believed of the disturbance before a record is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisturbancePrior {
    /// Probability of none.
    none: f64,
    /// Median of its standard deviation over the rudder's effect.
    median_share: f64,
    /// Standard deviation of the logarithm of that share.
    log_deviation: f64,
}

impl DisturbancePrior {
    /// The prior that the estimate is the mean under: seven of ten records hold no disturbance, the others one of
    /// 2 % of the rudder's effect, within a factor of two.
    pub const EXPECTED: Self = Self { none: 0.7, median_share: 0.02, log_deviation: 0.7 };

    /// The prior of the interval, which should also hold for a record that is worse than expected.
    pub const CAUTIOUS: Self = Self { none: 0.3, median_share: 0.05, log_deviation: 1.0 };

    /// Log of the prior of one disturbance among [`DISTURBANCE_TIME_CONSTANTS`] and strengths of which each is `ratio` times the one
    /// before, times `probability`, that of all else that the hypothesis says.
    ///
    /// `share` is the disturbance's standard deviation over the rudder's effect, 0 for none.
    ///
    /// ```
    /// use seatrial_core::refine::DisturbancePrior;
    ///
    /// let log_of = |share| DisturbancePrior::EXPECTED.log_of(share, 2.0, 1.0);
    /// assert_eq!(log_of(0.0), 0.7_f64.ln());
    /// // The median share is the likeliest.
    /// assert!(log_of(0.02) > log_of(0.01) && log_of(0.02) > log_of(0.04));
    /// ```
    pub fn log_of(&self, share: f64, ratio: f64, probability: f64) -> f64 {
        if share == 0.0 {
            return log(probability * self.none);
        }
        let off = log(share / self.median_share) / self.log_deviation;
        let step = log(ratio) / (self.log_deviation * sqrt(TAU));
        let any = (1.0 - self.none) / DISTURBANCE_TIME_CONSTANTS.len() as f64;
        log(probability * any * step) - 0.5 * off * off
    }
}

/// The likelihood's peaks over all disturbances.
#[derive(Clone, Debug)]
pub struct Hypotheses {
    all: List<Hypothesis, MOST_HYPOTHESES>,
    likeliest: Peak,
}

impl Hypotheses {
    /// The mixture for a record; `start` is any model of the vehicle.
    pub fn of(record: Series<'_>, start: Option<YawModel<f64>>) -> Result<Self, RefineFailure> {
        let span = Span::of(record.heading_rad.len(), record.interval_s.iter().sum())?;
        let damping_per_s = span.first_damping(record, start)?;
        let record = span.prepare(record, damping_per_s)?;
        let scale = span.rate_scale(damping_per_s);
        let none = Peak::find(&record, Disturbance::NONE, damping_per_s, scale)
            .ok_or(RefineFailure::NotExcited)?;
        let scale = span.rate_scale(none.a22_per_s);
        let rudder_amplitude_rad = record.rudder_amplitude_rad();
        let mut hypotheses = Self { all: List::default(), likeliest: none };
        hypotheses.add(&none, rudder_amplitude_rad);
        let mut nearest = none;
        for ratio in DISTURBANCE_TIME_CONSTANTS {
            let search = StrengthSearch {
                record: &record,
                scale,
                time_constant_s: ratio / scale,
                none,
                likeliest: hypotheses.likeliest.fit.log_likelihood,
            };
            let middle =
                search.for_each_peak(&nearest, |peak| hypotheses.add(peak, rudder_amplitude_rad));
            nearest = middle.unwrap_or(nearest);
        }
        Ok(hypotheses)
    }

    fn add(&mut self, peak: &Peak, rudder_amplitude_rad: f64) {
        if peak.fit.log_likelihood > self.likeliest.fit.log_likelihood {
            self.likeliest = *peak;
        }
        // The search looks at no more than there is room for.
        let _ = self.all.push(Hypothesis::of(peak, rudder_amplitude_rad));
    }

    /// The one most likely disturbance.
    pub fn likeliest(&self) -> &Peak {
        &self.likeliest
    }

    /// The average over all.
    pub fn refinement(&self) -> Refinement {
        let mean = self.under(&DisturbancePrior::EXPECTED).mean();
        let cautious = self.under(&DisturbancePrior::CAUTIOUS);
        let a22_per_s = cautious.interval_95(Hypothesis::parameter::<0>);
        let b2_per_s2 = cautious.interval_95(Hypothesis::parameter::<1>);
        let c0_rad_per_s2 = cautious.interval_95(Hypothesis::parameter::<2>);
        let has_authority = b2_per_s2[0] * b2_per_s2[1] > 0.0;
        Refinement {
            model: YawModel::from_theta(mean),
            a22_per_s,
            b2_per_s2,
            c0_rad_per_s2,
            delta0_rad: has_authority.then(|| cautious.interval_95(Hypothesis::offset_angle)),
            covariance: cautious.covariance_about(mean),
            heading_noise_rad: cautious.mean_of(|h| h.heading_noise_rad),
            disturbance_rad_s2: cautious.mean_of(|h| h.disturbance_rad_s2),
        }
    }

    /// From priors and likelihoods to probabilities.
    fn under(&self, prior: &DisturbancePrior) -> Mixture<'_> {
        let log_of = |h: &Hypothesis| prior.log_of(h.share, STRENGTH_RATIO, 1.0) + h.log_evidence;
        let best = self.all.iter().map(log_of).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = self.all.iter().map(|h| exp(log_of(h) - best)).sum();
        let mut weights = [0.0; MOST_HYPOTHESES];
        for (weight, hypothesis) in weights.iter_mut().zip(self.all.iter()) {
            *weight = exp(log_of(hypothesis) - best) / total;
        }
        Mixture { weights, hypotheses: &self.all }
    }
}

/// The hypotheses with their probabilities.
struct Mixture<'a> {
    weights: [f64; MOST_HYPOTHESES],
    hypotheses: &'a [Hypothesis],
}

impl Mixture<'_> {
    fn weighted(&self) -> impl Iterator<Item = (f64, &Hypothesis)> {
        self.weights.iter().copied().zip(self.hypotheses)
    }

    fn mean_of(&self, value: impl Fn(&Hypothesis) -> f64) -> f64 {
        self.weighted().map(|(weight, h)| weight * value(h)).sum()
    }

    /// Mean of [a22, b2, C0].
    fn mean(&self) -> [f64; 3] {
        core::array::from_fn(|i| self.mean_of(|h| h.mean[i]))
    }

    /// Mean square distance of [a22, b2, C0] from an estimate.
    fn covariance_about(&self, estimate: [f64; 3]) -> [[f64; 3]; 3] {
        core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                self.mean_of(|h| {
                    let off = |k: usize| h.mean[k] - estimate[k];
                    h.covariance[i][j] + off(i) * off(j)
                })
            })
        })
    }

    /// The 2.5 and 97.5 % points of a quantity whose mean and variance each hypothesis gives.
    fn interval_95(&self, moments: impl Fn(&Hypothesis) -> (f64, f64)) -> [f64; 2] {
        let normals = || {
            let with_weight = |(weight, _): &(f64, &Hypothesis)| *weight > NO_WEIGHT;
            self.weighted().filter(with_weight).map(|(weight, h)| {
                let (mean, variance) = moments(h);
                (weight, mean, sqrt(variance))
            })
        };
        [0.025, 0.975].map(|share| quantile(normals, share))
    }
}

/// Hypotheses of less weight do not move a point of the mixture.
const NO_WEIGHT: f64 = 1e-12;

/// Where a mixture of normal distributions, given as weight, mean and standard deviation, reaches a share: by Newton's method, within
/// bounds that halve where it leaves them. The weights add up to 1; no number without a distribution.
///
/// ```
/// use seatrial_core::refine::quantile;
///
/// let normals = [(0.25, -1.0, 0.1), (0.75, 3.0, 0.1)];
/// let median = quantile(|| normals.into_iter(), 0.5);
/// // A third of the second distribution is below.
/// assert!((median - (3.0 - 0.0430727)).abs() < 1e-6);
/// assert!(quantile(|| [].into_iter(), 0.5).is_nan());
/// ```
pub fn quantile<I: Iterator<Item = (f64, f64, f64)>>(normals: impl Fn() -> I, share: f64) -> f64 {
    const MOST_STEPS: u32 = 60;
    /// In standard deviations: the step after that is the square of it.
    const NEAR: f64 = 1e-5;
    let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
    let [mut total, mut total_square] = [0.0; 2];
    for (weight, mean, deviation) in normals() {
        low = low.min(mean - 8.0 * deviation);
        high = high.max(mean + 8.0 * deviation);
        total += weight * mean;
        total_square += weight * (mean * mean + deviation * deviation);
    }
    let deviation = sqrt((total_square - total * total).max(0.0));
    let mut point = total + (if share < 0.5 { -2.0 } else { 2.0 }) * deviation;
    for _ in 0..MOST_STEPS {
        if !(low < point && point < high) {
            point = 0.5 * (low + high);
        }
        let [mut below, mut density] = [0.0; 2];
        for (weight, mean, deviation) in normals() {
            let off = (point - mean) / deviation;
            below += weight * standard_normal_below(off);
            density += weight * exp(-0.5 * off * off) / (deviation * sqrt(TAU));
        }
        if below < share {
            low = point;
        } else {
            high = point;
        }
        let step = (share - below) / density;
        point += step;
        if step.abs() <= NEAR * deviation {
            break;
        }
    }
    point
}

fn standard_normal_below(x: f64) -> f64 {
    0.5 * erfc(-x * FRAC_1_SQRT_2)
}

/// All strengths of a disturbance of one time constant that carry weight.
struct StrengthSearch<'a> {
    record: &'a Series<'a>,
    scale: f64,
    time_constant_s: f64,
    none: Peak,
    /// The greatest log likelihood that was found.
    likeliest: f64,
}

impl StrengthSearch<'_> {
    /// By octaves from where disturbance and noise move the heading alike over a time constant of the vehicle: first to the
    /// stronger ones, then to the weaker ones.
    ///
    /// Returns the peak where it began, which `nearest` is expected to be near.
    fn for_each_peak(&self, nearest: &Peak, mut take: impl FnMut(&Peak)) -> Option<Peak> {
        let middle = 0.1 * self.scale * self.scale;
        let first = self.at(middle, self.none.a22_per_s, nearest.into())?;
        take(&first);
        let mut likeliest = first.fit.log_likelihood;
        let mut above = [None; 2];
        for ratio in [STRENGTH_RATIO, 1.0 / STRENGTH_RATIO] {
            let mut last = first;
            let [mut before, mut second] = above;
            for _ in 0..MOST_STRENGTHS {
                let foreseen = self.foreseen(&last, before.as_ref(), second.as_ref());
                if foreseen.is_some_and(|next| likeliest - next > CERTAINLY_NEGLIGIBLE) {
                    break;
                }
                let expected = match &before {
                    Some(before) => PeakGuess::after(before, &last),
                    None => PeakGuess::from(&last),
                };
                let relative = last.disturbance.relative * ratio;
                let read_off = before
                    .filter(|before| ratio < 1.0 && self.are_weak(&last, before))
                    .map(|before| Peak::at_half_the_strength(&self.none, &last, &before))
                    .filter(Peak::is_one);
                let found = || self.at(relative, last.a22_per_s, expected);
                let Some(peak) = read_off.or_else(found) else {
                    break;
                };
                likeliest = likeliest.max(peak.fit.log_likelihood);
                let vanished = ratio < 1.0 && self.gain(&peak) < VANISHED;
                if likeliest - peak.fit.log_likelihood > NEGLIGIBLE || vanished {
                    break;
                }
                take(&peak);
                (second, before, last) = (before, Some(last), peak);
                if let Some(place) = above.iter_mut().find(|place| place.is_none()) {
                    *place = Some(peak);
                }
            }
        }
        Some(first)
    }

    /// The log likelihood of the next disturbance, by the differences of the last three; no less than without any.
    fn foreseen(&self, last: &Peak, before: Option<&Peak>, second: Option<&Peak>) -> Option<f64> {
        let [a, b, c] = [second?, before?, last].map(|peak| peak.fit.log_likelihood);
        Some((c + (c - b) + 0.5 * (c - 2.0 * b + a)).max(self.none.fit.log_likelihood))
    }

    fn are_weak(&self, last: &Peak, before: &Peak) -> bool {
        let [of_last, of_before] =
            [last, before].map(|peak| peak.fit.log_likelihood - self.none.fit.log_likelihood);
        of_before.abs() < WEAK && (of_before - 4.0 * of_last).abs() < 0.5 * of_before.abs()
    }

    /// By how much a disturbance changes the log likelihood.
    fn gain(&self, peak: &Peak) -> f64 {
        (peak.fit.log_likelihood - self.none.fit.log_likelihood).abs()
    }

    fn at(&self, relative: f64, start_per_s: f64, expected: PeakGuess) -> Option<Peak> {
        let disturbance = Disturbance { relative, time_constant_s: self.time_constant_s };
        let near = Near {
            start_per_s,
            expected,
            scale_per_s: self.scale,
            of_interest: self.likeliest - OF_INTEREST,
        };
        near.peak(self.record, disturbance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against halving a bracket until nothing is left of it.
    #[test]
    fn exact_points_of_a_mixture() {
        let normals = [(0.7, -1.0, 0.1), (0.24, -0.8, 0.5), (0.06, 3.0, 2.0)];
        for share in [0.025, 0.35, 0.5, 0.975] {
            let (mut low, mut high) = (-20.0, 20.0);
            for _ in 0..80 {
                let middle: f64 = 0.5 * (low + high);
                let shares = normals.map(|(weight, mean, deviation)| {
                    weight * standard_normal_below((middle - mean) / deviation)
                });
                match shares.iter().sum::<f64>() < share {
                    true => low = middle,
                    false => high = middle,
                }
            }
            let found = quantile(|| normals.into_iter(), share);
            // A step of 1e-5 deviations is the last, and what is left of it its square.
            assert!((found - low).abs() < 1e-8, "{share} {found} {low}");
        }
    }
}

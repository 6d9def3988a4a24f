//! The best estimate from a stored record: restricted likelihood averaged over the disturbance.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::{Sample, YawModel};
use statrs::distribution::{ContinuousCDF, Normal};

use super::output_error::OutputError;
use super::peak::{DISTURBANCE_TIME_CONSTANTS, Peak, RefineFailure, Span, liveliest};
use super::second_order::SecondOrder;
use super::whitening::{Disturbance, Prepared};
use crate::identification::{Intervals, Refined};
use crate::propagation::NORMAL_95;

/// Ratio between neighbouring strengths of the disturbance.
const STRENGTH_RATIO: f64 = 2.0;

/// Most strengths looked at either way: beyond, a disturbance explains a record such as one with spikes equally well
/// whatever its strength.
const MOST_STRENGTHS: usize = 24;

/// The prior that the estimate is the mean under: seven of ten records hold no disturbance, the others one of
/// 2 % of the rudder's effect, within a factor of two.
const EXPECTED: Prior = Prior {
    none: 0.7,
    median_share: 0.02,
    log_deviation: 0.7,
};

/// The prior of the interval, which should also hold for a record that is worse than expected.
const CAUTIOUS: Prior = Prior {
    none: 0.3,
    median_share: 0.05,
    log_deviation: 1.0,
};

/// A log likelihood this far below the best has no weight.
const NEGLIGIBLE: f64 = 8.0;

/// Estimates a22, b2 and C0 with intervals that mean what they say, from a whole record.
///
/// ```text
/// p(theta | record) = sum over (q, tau) of  w(q, tau) N(theta_hat(q, tau), V(q, tau))
/// w(q, tau) ~ prior(q) exp(l(a22_hat; q, tau)) sqrt(v)
/// ```
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | q | standard deviation of the yaw acceleration disturbance over that of the heading noise | 1/s^2 |
/// | tau | time constant of the disturbance, a first-order Gauss-Markov process | s |
/// | l | restricted log likelihood of [`Prepared::fit`], largest in a22 at a22_hat with curvature -1/v | |
///
/// The most likely (q, tau) alone gives intervals that are too narrow under disturbance, because 16 s of
/// record do not determine the disturbance; the average over both does not. The mean of the mixture is the
/// estimate, its 2.5 and 97.5 % points, under a prior that expects more disturbance, the interval.
///
/// The interval assumes white heading noise, a disturbance that forgets its past exponentially, a first-order
/// yaw model and a rudder that acts when the record says. Of a record of more than 10 000 samples only the
/// liveliest stretch is used. `samples` are finite and increase in time; headings
/// may be wrapped; a sample's rudder acts until the next. `start` is any model of the vehicle, for instance
/// the online estimate.
pub fn refine(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<Refined, RefineFailure> {
    Ok(Peaks::of(samples, start)?.refined())
}

/// The model and its covariance with the least prediction error of a Kalman filter: the one most likely disturbance, where
/// [`refine`] averages over all. Cheaper to explain, but its interval takes the disturbance for known.
pub fn prediction_error(
    samples: &[Sample<f64>],
    start: Option<YawModel<f64>>,
) -> Result<(YawModel<f64>, Matrix3<f64>), RefineFailure> {
    let (centre, covariance) = Peaks::of(samples, start)?
        .all
        .iter()
        .max_by(|a, b| a.fit.log_likelihood.total_cmp(&b.fit.log_likelihood))
        .ok_or(RefineFailure::NotExcited)?
        .normal();
    Ok((YawModel::from_theta(centre.into()), covariance))
}

/// A disturbance of more than this share of the rudder's own effect may be none: the model may miss something.
const LARGE_DISTURBANCE_SHARE: f64 = 0.1;

/// The share of the rudder's effect, b2 times its amplitude, that the disturbance would have to have.
///
/// Sway or a slow servo pass for a disturbance that follows the rudder, against the assumption of the
/// interval, and the likelihood fits the next instant rather than the manoeuvre. [`second_order::fit`](super::second_order::fit) tells them
/// from a strong disturbance.
pub fn disturbance_share(refined: &Refined, rudder_amplitude_rad: f64) -> f64 {
    refined.disturbance_rad_s2 / (refined.model.b2_per_s2.abs() * rudder_amplitude_rad)
}

/// Is a [`disturbance_share`] so large that the model may miss something?
pub fn is_large_share(share: f64) -> bool {
    share > LARGE_DISTURBANCE_SHARE
}

/// The yaw model of a first-order vehicle whose rudder lags, in place of the refined one, which takes the lag for
/// damping and a disturbance.
pub fn behind_the_lag(refined: &Refined, lagging: &SecondOrder) -> Refined {
    let model = YawModel::from_theta([
        lagging.model.a22_per_s,
        lagging.model.b2_per_s2,
        lagging.model.c0_rad_per_s2,
    ]);
    around(refined, model, lagging.covariance.into(), "rudder_lag")
}

/// The online estimate in place of the refined one, for a record of a vehicle that is not of first order.
///
/// The instrument weighs the manoeuvre's own frequencies and is least wrong there (mean R^2 of fresh headings
/// 0.88 against 0.84 on the six-degree-of-freedom REMUS 100, of yaw rate 0.97 against 0.82 on the
/// free-running tanker KVLCC2). Its interval is that of output error with residuals correlated in time,
/// widened by the distance between the two estimates.
pub fn around_online(refined: &Refined, online: YawModel<f64>, simulated: &OutputError) -> Refined {
    let shift = Vector3::from(online.theta()) - Vector3::from(simulated.model.theta());
    let covariance = Matrix3::from(simulated.covariance) + shift * shift.transpose();
    around(refined, online, covariance, "instrumental_variable")
}

/// The same model when something else leaves it uncertain, too.
pub(super) fn widened(refined: &Refined, more: &Matrix3<f64>) -> Refined {
    let interval = |[low, high]: [f64; 2], variance: f64| {
        let (middle, half_width) = (0.5 * (low + high), 0.5 * (high - low));
        let half_width = half_width.hypot(NORMAL_95 * variance.sqrt());
        [middle - half_width, middle + half_width]
    };
    let Intervals {
        a22_per_s,
        b2_per_s2,
        c0_rad_per_s2,
        delta0_rad,
    } = refined.interval_95;
    let (_, of_delta0) = offset_angle(&refined.model.theta().into(), more);
    Refined {
        interval_95: Intervals {
            a22_per_s: interval(a22_per_s, more[(0, 0)]),
            b2_per_s2: interval(b2_per_s2, more[(1, 1)]),
            c0_rad_per_s2: interval(c0_rad_per_s2, more[(2, 2)]),
            delta0_rad: delta0_rad.map(|delta0| interval(delta0, of_delta0)),
        },
        covariance: (Matrix3::from(refined.covariance) + more).into(),
        ..refined.clone()
    }
}

/// Another model with normal intervals in place of the refined one.
pub(super) fn around(
    refined: &Refined,
    model: YawModel<f64>,
    covariance: Matrix3<f64>,
    method: &str,
) -> Refined {
    Refined {
        method: method.into(),
        model,
        delta0_rad: model.delta0_rad(),
        interval_95: normal_intervals(&model, &covariance),
        covariance: covariance.into(),
        ..refined.clone()
    }
}

/// 1.96 standard deviations either side.
pub(crate) fn normal_intervals(model: &YawModel<f64>, covariance: &Matrix3<f64>) -> Intervals {
    let interval = |value: f64, variance: f64| {
        let half_width = NORMAL_95 * variance.sqrt();
        [value - half_width, value + half_width]
    };
    let [a22_per_s, b2_per_s2, c0_rad_per_s2] =
        core::array::from_fn(|i| interval(model.theta()[i], covariance[(i, i)]));
    let has_authority = b2_per_s2[0] * b2_per_s2[1] > 0.0;
    let (delta0, delta0_variance) = offset_angle(&Vector3::from(model.theta()), covariance);
    Intervals {
        a22_per_s,
        b2_per_s2,
        c0_rad_per_s2,
        delta0_rad: has_authority.then(|| interval(delta0, delta0_variance)),
    }
}

/// What is believed of the disturbance before a record is seen.
struct Prior {
    /// Probability of none.
    none: f64,
    /// Median of its standard deviation over the rudder's effect, b2 times the rudder's amplitude.
    median_share: f64,
    /// Standard deviation of the logarithm of that share.
    log_deviation: f64,
}

impl Prior {
    /// The log prior of a peak among octaves of strength and [`DISTURBANCE_TIME_CONSTANTS`].
    fn log_of(&self, peak: &Peak, rudder_amplitude_rad: f64) -> f64 {
        if peak.disturbance == Disturbance::NONE {
            return self.none.ln();
        }
        let disturbance = peak.disturbance.relative * peak.fit.noise_variance_rad2.sqrt();
        let share = disturbance / (peak.fit.linear[0].abs() * rudder_amplitude_rad);
        let off = (share / self.median_share).ln() / self.log_deviation;
        let octave = STRENGTH_RATIO.ln() / (self.log_deviation * core::f64::consts::TAU.sqrt());
        ((1.0 - self.none) * octave / DISTURBANCE_TIME_CONSTANTS.len() as f64).ln()
            - 0.5 * off * off
    }
}

/// The likelihood's peaks over all disturbances.
struct Peaks {
    all: Vec<Peak>,
    rudder_amplitude_rad: f64,
}

impl Peaks {
    fn of(samples: &[Sample<f64>], start: Option<YawModel<f64>>) -> Result<Self, RefineFailure> {
        let samples = liveliest(samples);
        let span = Span::of(samples)?;
        let damping_per_s = span.first_damping(samples, start)?;
        let record = &span.prepare(samples, damping_per_s)?;
        let scale = span.rate_scale(damping_per_s);
        let none = Peak::find(record, Disturbance::NONE, damping_per_s, scale)
            .ok_or(RefineFailure::NotExcited)?;
        let scale = span.rate_scale(none.a22_per_s);
        let mut all = vec![none];
        for ratio in DISTURBANCE_TIME_CONSTANTS {
            let search = StrengthSearch {
                record,
                scale,
                time_constant_s: ratio / scale,
                none,
            };
            all.extend(search.peaks());
        }
        Ok(Self {
            all,
            rudder_amplitude_rad: record.rudder_amplitude_rad(),
        })
    }

    /// From priors and likelihoods to probabilities.
    fn under(&self, prior: &Prior) -> Mixture {
        let logs: Vec<f64> = self
            .all
            .iter()
            .map(|peak| {
                prior.log_of(peak, self.rudder_amplitude_rad)
                    + peak.fit.log_likelihood
                    + 0.5 * peak.variance.ln()
            })
            .collect();
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = logs.iter().map(|log| (log - best).exp()).sum();
        Mixture {
            peaks: logs
                .iter()
                .zip(&self.all)
                .map(|(log, peak)| ((log - best).exp() / total, *peak))
                .collect(),
        }
    }

    fn refined(&self) -> Refined {
        let mean = self.under(&EXPECTED).mean();
        let cautious = self.under(&CAUTIOUS);
        let model = YawModel::from_theta(mean.into());
        let [a22_per_s, b2_per_s2, c0_rad_per_s2] = core::array::from_fn(|i| {
            cautious.interval_95(|peak| {
                let (centre, own) = peak.normal();
                (centre[i], own[(i, i)])
            })
        });
        let has_authority = b2_per_s2[0] * b2_per_s2[1] > 0.0;
        Refined {
            method: "averaged_restricted_likelihood".into(),
            model,
            delta0_rad: model.delta0_rad(),
            interval_95: Intervals {
                a22_per_s,
                b2_per_s2,
                c0_rad_per_s2,
                delta0_rad: has_authority.then(|| {
                    cautious.interval_95(|peak| {
                        let (centre, own) = peak.normal();
                        offset_angle(&centre, &own)
                    })
                }),
            },
            covariance: cautious.covariance_about(mean).into(),
            heading_noise_rad: cautious.mean_of(|p| p.fit.noise_variance_rad2.sqrt()),
            disturbance_rad_s2: cautious
                .mean_of(|p| p.disturbance.relative * p.fit.noise_variance_rad2.sqrt()),
        }
    }
}

/// The peaks with their probabilities.
struct Mixture {
    peaks: Vec<(f64, Peak)>,
}

impl Mixture {
    fn mean_of(&self, value: impl Fn(&Peak) -> f64) -> f64 {
        self.peaks
            .iter()
            .map(|(weight, peak)| weight * value(peak))
            .sum()
    }

    /// Mean of [a22, b2, C0].
    fn mean(&self) -> Vector3<f64> {
        self.peaks
            .iter()
            .map(|(weight, peak)| *weight * peak.normal().0)
            .sum()
    }

    /// Mean square distance of [a22, b2, C0] from an estimate.
    fn covariance_about(&self, estimate: Vector3<f64>) -> Matrix3<f64> {
        self.peaks
            .iter()
            .map(|(weight, peak)| {
                let (centre, own) = peak.normal();
                let off = centre - estimate;
                *weight * (own + off * off.transpose())
            })
            .sum()
    }

    /// The 2.5 and 97.5 % points of a quantity whose mean and variance each peak gives.
    fn interval_95(&self, moments: impl Fn(&Peak) -> (f64, f64)) -> [f64; 2] {
        let normals: Vec<(f64, f64, f64)> = self
            .peaks
            .iter()
            .map(|(weight, peak)| {
                let (mean, variance) = moments(peak);
                (*weight, mean, variance.sqrt())
            })
            .collect();
        let widest = |side: f64| {
            normals
                .iter()
                .map(|(_, mean, deviation)| side * (mean + side * 8.0 * deviation))
                .fold(f64::NEG_INFINITY, f64::max)
                * side
        };
        let quantile = |share: f64| {
            let (mut low, mut high) = (widest(-1.0), widest(1.0));
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let below: f64 = normals
                    .iter()
                    .map(|(weight, mean, deviation)| {
                        weight * standard_normal_below((middle - mean) / deviation)
                    })
                    .sum();
                if below < share {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        [quantile(0.025), quantile(0.975)]
    }
}

/// Mean and variance of delta0 = C0/b2 by the delta method.
fn offset_angle(mean: &Vector3<f64>, covariance: &Matrix3<f64>) -> (f64, f64) {
    let gradient = Vector3::new(0.0, -mean[2] / (mean[1] * mean[1]), 1.0 / mean[1]);
    (
        mean[2] / mean[1],
        (gradient.transpose() * covariance * gradient)[(0, 0)],
    )
}

fn standard_normal_below(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// All strengths of a disturbance of one time constant that carry weight.
struct StrengthSearch<'a> {
    record: &'a Prepared,
    scale: f64,
    time_constant_s: f64,
    none: Peak,
}

impl StrengthSearch<'_> {
    fn peaks(&self) -> Vec<Peak> {
        let Some(first) = self.strongest() else {
            return Vec::new();
        };
        let mut peaks = vec![first];
        for ratio in [STRENGTH_RATIO, 1.0 / STRENGTH_RATIO] {
            let mut last = first;
            for _ in 0..MOST_STRENGTHS {
                let relative = last.disturbance.relative * ratio;
                let Some(peak) = self.at(relative, last.a22_per_s) else {
                    break;
                };
                let lost = first.fit.log_likelihood - peak.fit.log_likelihood;
                let vanished = ratio < 1.0
                    && (peak.fit.log_likelihood - self.none.fit.log_likelihood).abs() < 0.02;
                if lost > NEGLIGIBLE || vanished {
                    break;
                }
                peaks.push(peak);
                last = peak;
            }
        }
        peaks
    }

    /// The most likely strength on a grid of octaves, by climbing from where disturbance and noise move the
    /// heading alike over a time constant of the vehicle.
    fn strongest(&self) -> Option<Peak> {
        let mut best = self.at(0.1 * self.scale * self.scale, self.none.a22_per_s)?;
        for ratio in [STRENGTH_RATIO, 1.0 / STRENGTH_RATIO] {
            for _ in 0..MOST_STRENGTHS {
                let relative = best.disturbance.relative * ratio;
                let Some(peak) = self.at(relative, best.a22_per_s) else {
                    break;
                };
                if peak.fit.log_likelihood < best.fit.log_likelihood + 1e-3 {
                    break;
                }
                best = peak;
            }
        }
        Some(best)
    }

    fn at(&self, relative: f64, start_per_s: f64) -> Option<Peak> {
        let disturbance = Disturbance {
            relative,
            time_constant_s: self.time_constant_s,
        };
        Peak::find(self.record, disturbance, start_per_s, self.scale)
    }
}

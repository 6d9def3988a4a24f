//! The best estimate from a stored record: restricted likelihood averaged over the disturbance.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::{Sample, YawModel};
use statrs::distribution::{ContinuousCDF, Normal};

use super::output_error::OutputError;
use super::whitening::{Disturbance, Fit, Prepared};
use crate::identification::{Intervals, Refined};

/// Comparisons per time constant of the vehicle: more tell nothing new.
const COMPARISONS_PER_TIME_CONSTANT: f64 = 20.0;

/// Of a longer record only the stretch of this many samples in which the rudder moves most is refined: about
/// a second of work.
const MOST_SAMPLES: usize = 10_000;

/// Two initial conditions, three parameters and a noise level need some comparisons each.
const LEAST_COMPARISONS: usize = 15;

/// Time constants of the disturbance that are averaged over, in time constants of the vehicle.
const DISTURBANCE_TIME_CONSTANTS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Ratio between neighbouring strengths of the disturbance.
const STRENGTH_RATIO: f64 = 2.0;

/// Prior probability of no disturbance; the rest is spread evenly over the logarithm of its strength,
/// this many doublings wide.
const PRIOR_NONE: f64 = 0.05;
const PRIOR_DOUBLINGS: f64 = 12.0;

/// Half width of a 95 % interval in standard deviations.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// A log likelihood this far below the best has no weight.
const NEGLIGIBLE: f64 = 8.0;

/// Why a record cannot be refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RefineFailure {
    /// Fewer comparisons than parameters can bear.
    #[error("{found} comparisons, at least {LEAST_COMPARISONS} are needed")]
    TooShort {
        /// Comparisons found.
        found: usize,
    },
    /// The responses to rudder, offset and initial state cannot be told apart.
    #[error("the rudder's response cannot be told from the offset and the initial state")]
    NotExcited,
}

/// Estimates a22, b2 and C0 with intervals that mean what they say, from a whole record.
///
/// ```text
/// p(theta | record) = sum over (q, tau) of  w(q, tau) N(theta_hat(q, tau), V(q, tau))
/// w(q, tau) ~ prior(q, tau) exp(l(a22_hat; q, tau)) sqrt(v)
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
/// estimate, its 2.5 and 97.5 % points the interval.
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
    let samples = liveliest(samples);
    let span = Span::of(samples)?;
    let damping = span.first_damping(samples, start)?;
    let record = span.prepare(samples, damping)?;
    let mixture = Mixture::over_disturbances(&record, damping, &span)?;
    Ok(mixture.refined())
}

/// A disturbance of more than this share of the rudder's own effect is none: the model misses something.
const LARGEST_DISTURBANCE_SHARE: f64 = 0.1;

/// Where the record shows more than a first-order model: the share of the rudder's effect, b2 times its
/// amplitude, that the disturbance would have to have.
///
/// Sway or a slow servo then pass for a disturbance that follows the rudder, against the assumption of the
/// interval, and the likelihood fits the next instant rather than the manoeuvre.
pub fn structural_mismatch(refined: &Refined, rudder_amplitude_rad: f64) -> Option<f64> {
    let rudder_effect = refined.model.b2_per_s2.abs() * rudder_amplitude_rad;
    let share = refined.disturbance_rad_s2 / rudder_effect;
    (share > LARGEST_DISTURBANCE_SHARE).then_some(share)
}

/// The online estimate in place of the refined one, for a record with a [`structural_mismatch`].
///
/// The instrument weighs the manoeuvre's own frequencies and is least wrong there (mean R^2 of fresh headings
/// 0.88 against 0.84 on the six-degree-of-freedom REMUS 100, of yaw rate 0.97 against 0.82 on the
/// free-running tanker KVLCC2). Its interval is that of output error with residuals correlated in time,
/// widened by the distance between the two estimates.
pub fn around_online(refined: &Refined, online: YawModel<f64>, simulated: &OutputError) -> Refined {
    let shift = Vector3::from(online.theta()) - Vector3::from(simulated.model.theta());
    let covariance = Matrix3::from(simulated.covariance) + shift * shift.transpose();
    let interval = |value: f64, variance: f64| {
        let half_width = NORMAL_95 * variance.sqrt();
        [value - half_width, value + half_width]
    };
    let [a22_per_s, b2_per_s2, c0_rad_per_s2] =
        core::array::from_fn(|i| interval(online.theta()[i], covariance[(i, i)]));
    let has_authority = b2_per_s2[0] * b2_per_s2[1] > 0.0;
    let (delta0, delta0_variance) = offset_angle(&Vector3::from(online.theta()), &covariance);
    Refined {
        method: "instrumental_variable".into(),
        model: online,
        delta0_rad: online.delta0_rad(),
        interval_95: Intervals {
            a22_per_s,
            b2_per_s2,
            c0_rad_per_s2,
            delta0_rad: has_authority.then(|| interval(delta0, delta0_variance)),
        },
        covariance: covariance.into(),
        ..refined.clone()
    }
}

/// The stretch of [`MOST_SAMPLES`] in which the rudder varies most, on a grid of half its length.
pub(super) fn liveliest(samples: &[Sample<f64>]) -> &[Sample<f64>] {
    let variance = |stretch: &[Sample<f64>]| {
        let n = stretch.len() as f64;
        let mean = stretch.iter().map(|s| s.rudder_rad).sum::<f64>() / n;
        stretch
            .iter()
            .map(|s| (s.rudder_rad - mean).powi(2))
            .sum::<f64>()
            / n
    };
    samples
        .windows(MOST_SAMPLES)
        .step_by(MOST_SAMPLES / 2)
        .max_by(|a, b| variance(a).total_cmp(&variance(b)))
        .unwrap_or(samples)
}

/// Length and sampling of a record, s.
pub(super) struct Span {
    duration_s: f64,
    interval_s: f64,
}

impl Span {
    pub(super) fn of(samples: &[Sample<f64>]) -> Result<Self, RefineFailure> {
        match (samples.first(), samples.last()) {
            (Some(first), Some(last)) if samples.len() >= LEAST_COMPARISONS => {
                let duration_s = last.time_s - first.time_s;
                Ok(Self {
                    duration_s,
                    interval_s: duration_s / (samples.len() - 1) as f64,
                })
            }
            _ => Err(RefineFailure::TooShort {
                found: samples.len(),
            }),
        }
    }

    /// In blocks of a twentieth of the vehicle's time constant.
    pub(super) fn prepare(
        &self,
        samples: &[Sample<f64>],
        a22_per_s: f64,
    ) -> Result<Prepared, RefineFailure> {
        let per_time_constant = 1.0 / (self.rate_scale(a22_per_s) * self.interval_s);
        let block = per_time_constant / COMPARISONS_PER_TIME_CONSTANT;
        let record = Prepared::new(samples, block as usize);
        if record.blocks() < LEAST_COMPARISONS {
            return Err(RefineFailure::TooShort {
                found: record.blocks(),
            });
        }
        Ok(record)
    }

    /// |a22|, but no slower than what the record can show, 1/s.
    pub(super) fn rate_scale(&self, a22_per_s: f64) -> f64 {
        a22_per_s.abs().max(2.0 / self.duration_s)
    }

    /// The damping that output error prefers among a logarithmic grid and the start.
    pub(super) fn first_damping(
        &self,
        samples: &[Sample<f64>],
        start: Option<YawModel<f64>>,
    ) -> Result<f64, RefineFailure> {
        let slowest = 0.5 / self.duration_s;
        let fastest = 0.3 / self.interval_s;
        let points = 16;
        let grid = (0..points)
            .map(|i| -slowest * (fastest / slowest).powf(f64::from(i) / f64::from(points - 1)));
        let coarse = self.prepare(samples, start.map_or(0.0, |m| m.a22_per_s.min(0.0)))?;
        grid.chain(start.map(|m| m.a22_per_s))
            .chain([slowest])
            .filter_map(|a22| {
                let fit = coarse.fit(a22, Disturbance::NONE)?;
                Some((a22, fit.log_likelihood))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(a22, _)| a22)
            .ok_or(RefineFailure::NotExcited)
    }
}

/// The likelihood at one disturbance, largest in a22.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    disturbance: Disturbance,
    pub(super) a22_per_s: f64,
    /// -1 / second derivative of the log likelihood.
    variance: f64,
    pub(super) fit: Fit,
    /// d[b2, C0]/d a22.
    slope: [f64; 2],
    /// Newton steps taken.
    pub(super) iterations: u32,
}

/// The log likelihood around one a22, as the parabola through three points of J = exp(-2 l / n).
struct Parabola {
    centre: Fit,
    gradient: f64,
    curvature: f64,
    slope: [f64; 2],
}

impl Parabola {
    fn around(
        record: &Prepared,
        disturbance: Disturbance,
        a22_per_s: f64,
        spread: f64,
    ) -> Option<Self> {
        let centre = record.fit(a22_per_s, disturbance)?;
        let below = record.fit(a22_per_s - spread, disturbance)?;
        let above = record.fit(a22_per_s + spread, disturbance)?;
        let n = record.blocks() as f64;
        let cost = |fit: &Fit| (-2.0 * (fit.log_likelihood - centre.log_likelihood) / n).exp();
        Some(Self {
            centre,
            gradient: (cost(&above) - cost(&below)) / (2.0 * spread),
            curvature: (cost(&above) - 2.0 + cost(&below)) / (spread * spread),
            slope: core::array::from_fn(|i| (above.linear[i] - below.linear[i]) / (2.0 * spread)),
        })
    }
}

impl Peak {
    /// Newton's method on J(a22) = exp(-2 l / n), which is nearly quadratic also where noise-free data make l
    /// the logarithm of almost nothing.
    pub(super) fn find(
        record: &Prepared,
        disturbance: Disturbance,
        start_per_s: f64,
        scale_per_s: f64,
    ) -> Option<Self> {
        const MOST_STEPS: u32 = 15;
        let mut a22_per_s = start_per_s;
        let mut spread = 0.02 * scale_per_s;
        for iterations in 1..=MOST_STEPS {
            let parabola = Parabola::around(record, disturbance, a22_per_s, spread)?;
            let convex = parabola.curvature > 0.0;
            let step = if convex {
                -parabola.gradient / parabola.curvature
            } else {
                -0.3 * scale_per_s * parabola.gradient.signum()
            };
            let variance = 2.0 / (record.blocks() as f64 * parabola.curvature);
            let better = |step: &f64| {
                record
                    .fit(a22_per_s + step, disturbance)
                    .is_some_and(|fit| fit.log_likelihood > parabola.centre.log_likelihood)
            };
            let limited = step.clamp(-0.5 * scale_per_s, 0.5 * scale_per_s);
            let helpful = [1.0, 0.5, 0.25, 0.06]
                .map(|part| part * limited)
                .into_iter()
                .find(better);
            let arrived = convex && step.abs() < 0.02 * variance.sqrt();
            match helpful {
                Some(step) if !arrived => a22_per_s += step,
                _ if convex => {
                    return Some(Self {
                        disturbance,
                        a22_per_s,
                        variance,
                        fit: parabola.centre,
                        slope: parabola.slope,
                        iterations,
                    });
                }
                _ => return None,
            }
            if convex {
                spread = (0.5 * variance.sqrt()).clamp(1e-6 * scale_per_s, 0.1 * scale_per_s);
            }
        }
        None
    }

    /// Mean and covariance of [a22, b2, C0] here: those of (b2, C0) given a22, and a22's own.
    pub(super) fn normal(&self) -> (Vector3<f64>, Matrix3<f64>) {
        let mean = Vector3::new(self.a22_per_s, self.fit.linear[0], self.fit.linear[1]);
        let along = Vector3::new(1.0, self.slope[0], self.slope[1]);
        let mut covariance = self.variance * along * along.transpose();
        for i in 0..2 {
            for j in 0..2 {
                covariance[(i + 1, j + 1)] +=
                    self.fit.noise_variance_rad2 * self.fit.scaled_covariance[(i, j)];
            }
        }
        (mean, covariance)
    }
}

/// The peaks over all disturbances with their weights.
struct Mixture {
    peaks: Vec<(f64, Peak)>,
}

impl Mixture {
    fn over_disturbances(
        record: &Prepared,
        damping_per_s: f64,
        span: &Span,
    ) -> Result<Self, RefineFailure> {
        let scale = span.rate_scale(damping_per_s);
        let none = Peak::find(record, Disturbance::NONE, damping_per_s, scale)
            .ok_or(RefineFailure::NotExcited)?;
        let scale = span.rate_scale(none.a22_per_s);
        let mut peaks = vec![(PRIOR_NONE.ln(), none)];
        let prior =
            ((1.0 - PRIOR_NONE) / (PRIOR_DOUBLINGS * DISTURBANCE_TIME_CONSTANTS.len() as f64)).ln();
        for ratio in DISTURBANCE_TIME_CONSTANTS {
            let search = StrengthSearch {
                record,
                scale,
                time_constant_s: ratio / scale,
                none,
            };
            peaks.extend(search.peaks().into_iter().map(|peak| (prior, peak)));
        }
        Ok(Self::weighted(peaks))
    }

    /// From log priors to probabilities.
    fn weighted(peaks: Vec<(f64, Peak)>) -> Self {
        let logs: Vec<f64> = peaks
            .iter()
            .map(|(prior, peak)| prior + peak.fit.log_likelihood + 0.5 * peak.variance.ln())
            .collect();
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = logs.iter().map(|log| (log - best).exp()).sum();
        Self {
            peaks: logs
                .iter()
                .zip(peaks)
                .map(|(log, (_, peak))| ((log - best).exp() / total, peak))
                .collect(),
        }
    }

    fn mean_of(&self, value: impl Fn(&Peak) -> f64) -> f64 {
        self.peaks
            .iter()
            .map(|(weight, peak)| weight * value(peak))
            .sum()
    }

    fn refined(&self) -> Refined {
        let mut mean = Vector3::zeros();
        for (weight, peak) in &self.peaks {
            mean += *weight * peak.normal().0;
        }
        let mut covariance = Matrix3::zeros();
        for (weight, peak) in &self.peaks {
            let (centre, own) = peak.normal();
            let off = centre - mean;
            covariance += *weight * (own + off * off.transpose());
        }
        let model = YawModel::from_theta(mean.into());
        let [a22_per_s, b2_per_s2, c0_rad_per_s2] = core::array::from_fn(|i| {
            self.interval_95(|peak| {
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
                    self.interval_95(|peak| {
                        let (centre, own) = peak.normal();
                        offset_angle(&centre, &own)
                    })
                }),
            },
            covariance: covariance.into(),
            heading_noise_rad: self.mean_of(|p| p.fit.noise_variance_rad2.sqrt()),
            disturbance_rad_s2: self
                .mean_of(|p| p.disturbance.relative * p.fit.noise_variance_rad2.sqrt()),
        }
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
            while let Some(peak) = self.at(last.disturbance.relative * ratio, last.a22_per_s) {
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
            while let Some(peak) = self.at(best.disturbance.relative * ratio, best.a22_per_s) {
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

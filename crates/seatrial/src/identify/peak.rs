//! The likelihood of a record at one disturbance, largest in the damping: what output error and the
//! refinement share.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::{Sample, YawModel};

use super::whitening::{Disturbance, Fit, Prepared};

/// Comparisons per time constant of the vehicle: more tell nothing new.
const COMPARISONS_PER_TIME_CONSTANT: f64 = 20.0;

/// Time constants of a disturbance that are looked at, in time constants of the vehicle.
pub(super) const DISTURBANCE_TIME_CONSTANTS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Of a longer record only the stretch of this many samples in which the rudder moves most is refined: about
/// a second of work.
const MOST_SAMPLES: usize = 10_000;

/// Two initial conditions, three parameters and a noise level need some comparisons each.
const LEAST_COMPARISONS: usize = 15;

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
    pub(super) disturbance: Disturbance,
    pub(super) a22_per_s: f64,
    /// -1 / second derivative of the log likelihood.
    pub(super) variance: f64,
    pub(super) fit: Fit,
    /// d[b2, C0]/d a22.
    slope: [f64; 2],
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
        for _ in 0..MOST_STEPS {
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

//! The likelihood of a record at one disturbance, largest in the damping: what output error and the
//! refinement share.

use libm::{exp, log, sqrt};

use super::{Disturbance, LEAST_COMPARISONS, RefineFailure, Series, SteeringFit};
use crate::{Real, YawModel};

/// Comparisons per time constant of the vehicle: more tell nothing new.
const COMPARISONS_PER_TIME_CONSTANT: f64 = 20.0;

/// Time constants of a disturbance that are looked at, in time constants of the vehicle.
pub const DISTURBANCE_TIME_CONSTANTS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Length and sampling of a record, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    duration_s: f64,
    interval_s: f64,
}

impl Span {
    /// The span of `samples` samples over `duration_s`, s. An error where there are too few to compare.
    ///
    /// ```
    /// use seatrial_core::refine::{RefineFailure, Span};
    ///
    /// assert!(Span::of(320, 16.0).is_ok());
    /// assert!(matches!(Span::of(10, 0.5), Err(RefineFailure::TooShort { found: 10 })));
    /// ```
    pub fn of(samples: usize, duration_s: f64) -> Result<Self, RefineFailure> {
        if samples < LEAST_COMPARISONS {
            return Err(RefineFailure::TooShort { found: samples });
        }
        Ok(Self { duration_s, interval_s: duration_s / (samples - 1) as f64 })
    }

    /// The record in blocks of a twentieth of the vehicle's time constant.
    pub fn prepare<'a>(
        &self,
        record: Series<'a>,
        a22_per_s: f64,
    ) -> Result<Series<'a>, RefineFailure> {
        let per_time_constant = 1.0 / (self.rate_scale(a22_per_s) * self.interval_s);
        let block = per_time_constant / COMPARISONS_PER_TIME_CONSTANT;
        let record = Series { block: (block as usize).max(1), ..record };
        if record.blocks() < LEAST_COMPARISONS {
            return Err(RefineFailure::TooShort { found: record.blocks() });
        }
        Ok(record)
    }

    /// |a22|, but no slower than what the record can show, 1/s.
    ///
    /// ```
    /// use seatrial_core::refine::{RefineFailure, Span};
    ///
    /// let span = Span::of(320, 16.0)?;
    /// assert_eq!(span.rate_scale(-1.07), 1.07);
    /// // 16 s do not show a time constant of an hour.
    /// assert!(span.rate_scale(-1.0 / 3600.0) > 1.0 / 1000.0);
    /// # Ok::<(), RefineFailure>(())
    /// ```
    pub fn rate_scale(&self, a22_per_s: f64) -> f64 {
        a22_per_s.abs().max(2.0 / self.duration_s)
    }

    /// The damping that output error prefers among a logarithmic grid and the start, 1/s.
    pub fn first_damping(
        &self,
        record: Series<'_>,
        start: Option<YawModel<f64>>,
    ) -> Result<f64, RefineFailure> {
        const POINTS: usize = 16;
        let slowest = 0.5 / self.duration_s;
        let fastest = 0.3 / self.interval_s;
        let ratio = exp(log(fastest / slowest) / (POINTS - 1) as f64);
        let mut grid = [0.0; POINTS];
        let mut damping_per_s = -slowest;
        for point in &mut grid {
            *point = damping_per_s;
            damping_per_s *= ratio;
        }
        let coarse = self.prepare(record, start.map_or(0.0, |m| m.a22_per_s.min(0.0)))?;
        // The last one may be unstable.
        let others = [start.map_or(slowest, |m| m.a22_per_s), slowest];
        grid.as_chunks::<4>()
            .0
            .iter()
            .flat_map(|dampings| likelihoods(&coarse, *dampings))
            .chain(likelihoods(&coarse, others))
            .filter_map(|(a22, log_likelihood)| Some((a22, log_likelihood?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(a22, _)| a22)
            .ok_or(RefineFailure::NotExcited)
    }
}

/// Dampings and their log likelihoods without disturbance.
fn likelihoods<const N: usize>(
    record: &Series<'_>,
    a22_per_s: [f64; N],
) -> [(f64, Option<f64>); N] {
    let fits = record.steering_fits(a22_per_s, Disturbance::NONE);
    core::array::from_fn(|i| (a22_per_s[i], fits[i].map(|fit| fit.log_likelihood)))
}

/// The likelihood at one disturbance, largest in a22.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// The disturbance.
    pub disturbance: Disturbance,
    /// Where it is largest, 1/s.
    pub a22_per_s: f64,
    /// -1 / second derivative of the log likelihood.
    pub variance: f64,
    /// The other parameters there.
    pub fit: SteeringFit,
    /// d[b2, C0]/d a22.
    pub(super) slope: [f64; 2],
}

/// The log likelihood around one a22, as the parabola through three points of J = exp(-2 l / n).
struct Parabola {
    centre: SteeringFit,
    gradient: f64,
    curvature: f64,
    slope: [f64; 2],
}

impl Parabola {
    fn around(
        record: &Series<'_>,
        disturbance: Disturbance,
        a22_per_s: f64,
        spread: f64,
    ) -> Option<Self> {
        // Three would do: four fill the processor's vector.
        let dampings = [a22_per_s - spread, a22_per_s, a22_per_s + spread, a22_per_s];
        let [Some(below), Some(centre), Some(above), _] =
            record.steering_fits(dampings, disturbance)
        else {
            return None;
        };
        let n = record.blocks() as f64;
        let cost = |fit: &SteeringFit| exp(-2.0 * (fit.log_likelihood - centre.log_likelihood) / n);
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
    pub fn find(
        record: &Series<'_>,
        disturbance: Disturbance,
        start_per_s: f64,
        scale_per_s: f64,
    ) -> Option<Self> {
        const MOST_STEPS: u32 = 15;
        let mut a22_per_s = start_per_s;
        let mut spread = 0.02 * scale_per_s;
        let mut here = Parabola::around(record, disturbance, a22_per_s, spread)?;
        for _ in 0..MOST_STEPS {
            let variance = 2.0 / (record.blocks() as f64 * here.curvature);
            let convex = here.curvature > 0.0;
            let step = if convex {
                spread = (0.5 * sqrt(variance)).max(1e-5 * scale_per_s).min(0.1 * scale_per_s);
                -here.gradient / here.curvature
            } else {
                -0.3 * scale_per_s * here.gradient.signum()
            };
            let limited = step.limited_to(0.5 * scale_per_s);
            let better = |part: f64| {
                let a22_per_s = a22_per_s + part * limited;
                let there = Parabola::around(record, disturbance, a22_per_s, spread)?;
                (there.centre.log_likelihood > here.centre.log_likelihood)
                    .then_some((a22_per_s, there))
            };
            let arrived = convex && step.abs() < 0.02 * sqrt(variance);
            let next = match arrived {
                true => None,
                false => [1.0, 0.5, 0.25, 0.06].into_iter().find_map(better),
            };
            match next {
                Some(next) => (a22_per_s, here) = next,
                None if convex => {
                    return Some(Self {
                        disturbance,
                        a22_per_s,
                        variance,
                        fit: here.centre,
                        slope: here.slope,
                    });
                }
                None => return None,
            }
        }
        None
    }

    /// Mean and covariance of [a22, b2, C0] here: those of (b2, C0) given a22, and a22's own.
    pub fn normal(&self) -> ([f64; 3], [[f64; 3]; 3]) {
        let [b2, c0] = self.fit.linear;
        let along = [1.0, self.slope[0], self.slope[1]];
        let mut covariance = along.map(|a| along.map(|b| self.variance * a * b));
        for i in 0..2 {
            for j in 0..2 {
                covariance[i + 1][j + 1] +=
                    self.fit.noise_variance_rad2 * self.fit.scaled_covariance[i][j];
            }
        }
        ([self.a22_per_s, b2, c0], covariance)
    }
}

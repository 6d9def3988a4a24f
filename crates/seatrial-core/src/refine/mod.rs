//! The best estimate from a whole training stage, with intervals, in bounded memory.
//!
//! Like the trial it needs no heap: a [`StageRecord`] keeps the stage, 24 bytes a sample, and [`refine`] its
//! [`Hypotheses`], 25 kB, on the stack. It computes in double precision, since the likelihoods of neighbouring dampings
//! cannot be told apart in single precision, and takes some forty passes over the record, each for four dampings: 6 million instructions
//! for 330 samples, two to three times as many where the clock jitters. It belongs behind the stage, not into the control loop.
//!
//! A peak of the likelihood is found to about 0.02 standard deviations of a22, which is 0.01 of the half width of an interval. Of 200
//! simulated stages of all kinds, estimates and ends of intervals are within 0.025 of that half width of what Newton's method at every
//! disturbance gives, and nine in ten within 0.006. Where the rudder was too small to learn from, they may differ by more.

mod cholesky;
mod failure;
mod interpolated;
mod lanes;
mod mixture;
mod peak;
mod record;
mod responses;
mod series;
mod whitening;

pub use failure::{LEAST_COMPARISONS, RefineFailure};
pub use mixture::{DisturbancePrior, Hypotheses, Refinement, quantile};
pub use peak::{DISTURBANCE_TIME_CONSTANTS, Peak, Span};
pub use record::{Full, StageRecord, mean_rudder_rad};
pub use series::{Fit, Series, SteeringFit};
pub use whitening::Disturbance;

use crate::YawModel;

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
/// | l | restricted log likelihood of [`Series::fit`], largest in a22 at a22_hat with curvature -1/v | |
///
/// The most likely (q, tau) alone gives intervals that are too narrow under disturbance, because 16 s of
/// record do not determine the disturbance; the average over both does not. The mean of the mixture is the
/// estimate, its 2.5 and 97.5 % points, under a prior that expects more disturbance, the interval.
///
/// The interval assumes white heading noise, a disturbance that forgets its past exponentially, a first-order
/// yaw model and a rudder that acts when the record says. `start` is any model of the vehicle, for instance the online
/// estimate. `record` is taken in blocks of a twentieth of the vehicle's time constant, whatever its own.
///
/// ```
/// use seatrial_core::Sample;
/// use seatrial_core::YawModel;
/// use seatrial_core::model::YawState;
/// use seatrial_core::refine::{StageRecord, refine};
///
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// let vehicle = YawModel::from_theta([-1.07, 1.08, 0.012]);
/// let (mut state, mut record) = (YawState::<f64>::default(), StageRecord::<400>::new(0.05));
/// for k in 0..320 {
///     let rudder_rad = match k {
///         40..80 => 0.26,
///         80..120 => -0.26,
///         _ => 0.0,
///     };
///     // A compass with steps of 0.001 rad.
///     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
///     let sample =
///         Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Sample::default() };
///     record.push(&sample).map_err(|_| "the record is full")?;
///     state = vehicle.advance(state, rudder_rad, 0.05);
/// }
/// let found = refine(record.series(), None)?;
/// let [low, high] = found.b2_per_s2;
/// assert!(low < 1.08 && 1.08 < high && high - low < 0.05);
/// # Ok(())
/// # }
/// ```
pub fn refine(
    record: Series<'_>,
    start: Option<YawModel<f64>>,
) -> Result<Refinement, RefineFailure> {
    Hypotheses::of(record, start).map(|hypotheses| hypotheses.refinement())
}

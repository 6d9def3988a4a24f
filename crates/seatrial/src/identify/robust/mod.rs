//! The estimate that holds in the world: lag, timing, disturbance and error of the model in one restricted likelihood, beside the
//! nearest simulation.
//!
//! ```text
//! psi(t) = b2 psi_b(t; a22, T_l, tau) + C0 psi_c(t; a22) + psi0 + r0 psi_r(t; a22) + delta_f psi_f(t; a22, T_l) + (d) + noise
//! T_l delta_a' = delta(t - tau) - delta_a,  r' = a22 r + b2 delta_a + C0 + d,  psi' = r,  d' = -d/tau_d + white
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | a22, b2, C0 | yaw model, (5) of the paper |
//! | T_l, tau | lag of the rudder, and how late its record acts: at most about a sample interval either way |
//! | delta_f | b2 times the distance of the first rudder from its record |
//! | d, tau_d | yaw acceleration of the sea, first-order Gauss-Markov, and its time constant |
//!
//! Each hypothesis (acts at once or lags; no disturbance or one of a strength and a time constant) is linearised around its own peak,
//! whitened by a Kalman filter and solved with beliefs on lag and timing: a normal distribution of all parameters and the probability
//! of the record. The estimate is the mean over all hypotheses, its interval holds under more cautious beliefs, a heading is never
//! believed to more than what its resolution and its timing allow, and 1 % of a22 is error of the model. Restricted likelihood:
//! Harville (1977); averaging by Laplace's method: Kass and Raftery (1995).
//!
//! A record that is likelier of a rudder with play has intervals that hold the estimate behind it, too.
//! A disturbance that follows the yaw rate is the hull's: then the model is the nearest simulation, as [`estimate`] says.
//! Hypotheses without weight are left out or found roughly, which moves an end of an interval by less than a tenth of its half width, nine in
//! ten by less than a hundredth (`parity_of_estimates_with_a_search_for_every_peak`).
//! Valid for sample intervals up to a fifth of the vehicle's time constant. 1 to 2 ms for 330 samples, linear in the record.

pub mod average;
pub mod belief;
pub mod edges;
pub mod estimate;
pub mod even;
pub mod hypothesis;
pub mod hypothesis_search;
pub mod linearised;
pub mod misfit;
pub mod nearest;
pub mod noise;
pub mod normal;
pub mod peak;
pub mod play;
pub mod record;
pub mod response;
pub mod symmetric;

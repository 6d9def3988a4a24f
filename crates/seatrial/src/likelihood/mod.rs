//! The engine: hypotheses about a vehicle, its steering gear and what disturbs it compete on data left out.
//!
//! ```text
//! act  = gear(command(t - tau)),   T_l act' = command - act,   |act'| <= rho
//! r'   = -(d0 + d2 |r|) r + k v + b act + c + d,   v' = r - v/T_v,   psi' = r,   y = psi + e
//! ```
//!
//! | symbol | identifier | unit | meaning |
//! |---|---|---|---|
//! | tau, T_l, rho | `shift_s`, `lag_s`, `rate_limit_rad_s` | s, s, rad/s | time by which the record of the rudder is late, lag and rate limit of the gear |
//! | d0, d2 | `damping_per_s`, `quadratic_per_rad` | 1/s, 1/rad | damping, and how it grows with the yaw rate |
//! | k, T_v | `coupling_per_s2`, `sway_s` | 1/s^2, s | what sway does to yaw, and how long sway remembers |
//! | b, c | `authority_per_s2`, `offset_rad_s2` | 1/s^2, rad/s^2 | rudder authority, yaw acceleration at neutral rudder |
//! | d | | rad/s^2 | disturbance: none, a random walk of the heading, or a Gauss-Markov yaw acceleration |
//!
//! A hypothesis is a [`Structure`] under a [`Disturbance`]. Each is fitted by Gauss and Newton's method to the innovations of one Kalman
//! filter ([`filter`]), with weak priors; its evidence is the restricted likelihood by Laplace's method (Harville 1977; Kass and Raftery 1995).
//! [`choice`] leaves a fifth of the record out in turn and scores the free run over it: who predicts clearly worse than the best is out, as
//! is a sea whose own draws do not explain how far its estimate lies from that of output error. Where a sea is left, evidence weighs; else
//! the model is wrong in some way, and the weights are how often each hypothesis would predict best (Yao and others 2018).
//!
//! Valid for records of at least 20 comparisons and one stroke of the rudder to either side. Closed loops: a disturbance is then fed
//! back into the rudder, and hypotheses without one are biased. Cost: 0.3 to 1 s a record on one core.

pub mod choice;
pub mod evidence;
pub mod filter;
pub mod fit;
pub mod free_run;
pub mod gear;
pub mod hypothesis;
mod left_out;
pub mod leg;
pub mod motion;
pub mod posterior;
mod sea_test;
pub mod search;
pub mod steering_model;

pub use choice::{Candidate, Contest, WeighedHypothesis, contest_of, contest_of_hulls};
pub use hypothesis::{Disturbance, Structure, Vehicle};
pub(crate) use left_out::BLOCKS;
pub use leg::Leg;
pub use steering_model::SteeringModel;

//! The engine: hypotheses about a vehicle, its steering gear and what disturbs it compete on data left out.
//!
//! ```text
//! r' = hull(r, v) + b gear(rudder) + c + d,   psi' = r,   y = psi + e
//! ```
//!
//! [`SteeringModel`] says what hull and gear do, and the symbols. d is a disturbance: none, a random walk of the heading, or a Gauss-Markov yaw
//! acceleration.
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
pub use hypothesis::{Disturbance, Parameter, Structure, Vehicle};
pub(crate) use left_out::BLOCKS;
pub use leg::Leg;
pub use steering_model::SteeringModel;

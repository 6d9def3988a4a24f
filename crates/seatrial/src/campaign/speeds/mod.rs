//! What the models of several speeds, or of several turn rates, tell together.

mod agreement;
mod amplitude;
mod difference;
mod over_speed;
mod verdict;

pub(super) use agreement::load_change;
pub use agreement::{SpeedResult, contradictions};
pub use amplitude::{
    Finding, LEAST_SPREAD, OverAmplitude, SeenModel, ValueInterval, seen_amplitude_rad_s,
    yaw_rate_amplitude_rad_s,
};
pub use difference::{Difference, ParameterDifference, ThrustDifference};
pub use over_speed::{Coefficient, OverSpeed, SpeedEstimate, SpeedLaw, over_speed, share};
pub use verdict::{Part, missing, remarks, whole};

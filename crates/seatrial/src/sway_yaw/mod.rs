//! Sway and yaw with cross-flow damping and a lagging rudder: the model, and why a record supports it.

pub(crate) mod model;
pub(crate) mod order;
mod residual_tests;

pub use model::{SecondOrderNomoto, SwayYawModel, SwayYawState};
pub use order::{ModelOrder, SecondOrder, Structure, SwayYawIntervals};
pub use residual_tests::{ResidualTest, ResidualTests};

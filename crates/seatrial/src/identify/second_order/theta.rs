//! The parameters of a sway-yaw model, in the order of every vector and matrix of this folder.

use crate::sway_yaw::SwayYawModel;

/// Parameters: a22, b2, C0, a21, a11, k, T_d, psi0, r0.
pub(super) const PARAMETERS: usize = 9;
pub(super) const A22: usize = 0;
pub(super) const B2: usize = 1;
pub(super) const C0: usize = 2;
pub(super) const A21: usize = 3;
pub(super) const A11: usize = 4;
pub(super) const CROSS_FLOW: usize = 5;
pub(super) const LAG: usize = 6;
pub(super) const HEADING: usize = 7;
pub(super) const YAW_RATE: usize = 8;

/// The parameters of the model and its state at the first sample, where sway has not begun.
pub(super) type Theta = [f64; PARAMETERS];

pub(super) fn model_of(theta: &Theta) -> SwayYawModel {
    SwayYawModel {
        a22_per_s: theta[A22],
        b2_per_s2: theta[B2],
        c0_rad_per_s2: theta[C0],
        a21_per_s2: theta[A21],
        a11_per_s: theta[A11],
        cross_flow_per_rad_s: theta[CROSS_FLOW],
        rudder_lag_s: theta[LAG],
    }
}

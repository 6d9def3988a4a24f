//! Attitude quaternions as angles.

use crate::Real;

/// Names of the angles of [`euler_rad`] as columns.
pub const EULER: [&str; 3] = ["roll", "pitch", "yaw"];

/// Roll, pitch and yaw of a unit quaternion w, x, y, z that turns the body into the earth frame.
///
/// ```text
/// roll  = atan2(2 (w x + y z), 1 - 2 (x^2 + y^2))
/// pitch = asin(2 (w y - z x))
/// yaw   = atan2(2 (w z + x y), 1 - 2 (y^2 + z^2))
/// ```
///
/// The frames decide the signs: with x forward, y starboard, z down in north, east, down they are this
/// crate's. A quaternion of zeros, as before the estimator's start, gives NaN.
///
/// ```
/// use core::f64::consts::FRAC_1_SQRT_2;
/// use seatrial_core::attitude::euler_rad;
///
/// // A quarter turn about the axis that points down: heading 90 deg.
/// let [roll, pitch, yaw] = euler_rad([FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
/// assert_eq!((roll, pitch), (0.0, 0.0));
/// assert!((yaw.to_degrees() - 90.0).abs() < 1e-9);
/// assert!(euler_rad([0.0; 4])[2].is_nan());
/// ```
pub fn euler_rad([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    if w * w + x * x + y * y + z * z < 0.5 {
        return [f64::NAN; 3];
    }
    let sine = Real::min(Real::max(2.0 * (w * y - z * x), -1.0), 1.0);
    [
        Real::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        Real::atan2(sine, Real::sqrt(1.0 - sine * sine)),
        Real::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_turn_about_one_axis_is_that_angle() {
        let (cos, sin) = (Real::cos(0.3), Real::sin(0.3));
        for (axis, quaternion) in
            [(0, [cos, sin, 0.0, 0.0]), (1, [cos, 0.0, sin, 0.0]), (2, [cos, 0.0, 0.0, sin])]
        {
            let mut expected = [0.0; 3];
            expected[axis] = 0.6;
            for (found, expected) in euler_rad(quaternion).iter().zip(expected) {
                // A few roundings.
                assert!((found - expected).abs() < 1e-15);
            }
        }
        assert!(euler_rad([0.0; 4])[0].is_nan());
    }
}

//! Lift and drag of a fin with stall.

use serde::{Deserialize, Serialize};

/// Oswald efficiency of a fin.
const OSWALD_EFFICIENCY: f64 = 0.9;
/// Half the width over which lift goes over to that of a flat plate, rad.
const STALL_HALF_WIDTH_RAD: f64 = 0.1;

/// A fin as a wing.
///
/// ```text
/// C_L = (1 - s) C_La a + s 2 sgn(a) sin^2 a cos a
/// C_D = C_D0 + (1 - s) (C_La a)^2/(pi e AR) + s 2 |sin a|^3
/// s   = 3 t^2 - 2 t^3,  t = (|a| - a_s + h)/(2 h) between 0 and 1
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | a | `angle_rad` | rad |
/// | C_La | `lift_slope_per_rad` | 1/rad |
/// | AR | `aspect_ratio` | 1 |
/// | C_D0 | `profile_drag` | 1 |
/// | a_s, h | `stall_rad`, 0.1 rad | rad |
/// | e | 0.9 | 1 |
///
/// Source: Beard and McLain, Small Unmanned Aircraft (2012), section 4.2, with a cubic blend of finite width. The
/// fully stalled fin is a flat plate with a normal force of 2 sin^2 a. Valid for every angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foil {
    /// Area, m^2.
    pub area_m2: f64,
    /// Lift slope, 1/rad.
    pub lift_slope_per_rad: f64,
    /// Effective aspect ratio.
    pub aspect_ratio: f64,
    /// Drag coefficient without lift.
    pub profile_drag: f64,
    /// Angle of stall, rad.
    pub stall_rad: f64,
}

impl Foil {
    /// C_L and C_D.
    pub fn coefficients(&self, angle_rad: f64) -> [f64; 2] {
        let attached = self.lift_slope_per_rad * angle_rad;
        let induced =
            attached * attached / (core::f64::consts::PI * OSWALD_EFFICIENCY * self.aspect_ratio);
        let t = ((angle_rad.abs() - self.stall_rad) / (2.0 * STALL_HALF_WIDTH_RAD) + 0.5)
            .clamp(0.0, 1.0);
        let stalled = t * t * (3.0 - 2.0 * t);
        if stalled == 0.0 {
            return [attached, self.profile_drag + induced];
        }
        let (sine, cosine) = (libm::sin(angle_rad), libm::cos(angle_rad));
        let plate = 2.0 * sine.abs() * sine;
        [
            (1.0 - stalled) * attached + stalled * plate * cosine,
            self.profile_drag + (1.0 - stalled) * induced + stalled * plate * sine,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOIL: Foil = Foil {
        area_m2: 0.0067,
        lift_slope_per_rad: 3.0,
        aspect_ratio: 2.2,
        profile_drag: 0.02,
        stall_rad: 0.4,
    };

    #[test]
    fn exact_linear_below_stall_and_plate_beyond() {
        assert_eq!(FOIL.coefficients(0.2)[0], 3.0 * 0.2);
        let [lift, drag] = FOIL.coefficients(-1.0);
        let sine = 1.0_f64.sin();
        assert!((lift + 2.0 * sine * sine * 1.0_f64.cos()).abs() < 1e-15);
        assert!((drag - 0.02 - 2.0 * sine.powi(3)).abs() < 1e-15);
    }

    #[test]
    fn prop_lift_is_odd_drag_is_even_and_both_are_continuous() {
        let mut before = FOIL.coefficients(-core::f64::consts::PI);
        for k in -31_415..=31_415 {
            let angle = f64::from(k) * 1e-4;
            let [lift, drag] = FOIL.coefficients(angle);
            let mirrored = FOIL.coefficients(-angle);
            assert_eq!([-lift, drag], mirrored);
            assert!(drag >= 0.02);
            // The steepest slope in the blend is under 12 per rad.
            assert!((lift - before[0]).abs() < 12e-4 && (drag - before[1]).abs() < 12e-4);
            before = [lift, drag];
        }
    }
}

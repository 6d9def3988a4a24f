//! Tables II, III, IV and V as printed.

use seatrial_core::YawModel;

use super::PrintedNumber;

/// One row of Table II, III or V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Thrust, percent of full.
    pub thrust_percent: u32,
    /// Speed, m/s, two digits after the point. Table III has the speeds of Table II.
    pub surge_speed_m_s: f64,
    /// a22, 1/s, two digits.
    pub a22_per_s: f64,
    /// b2, 1/s^2, two digits.
    pub b2_per_s2: f64,
    /// C0, rad/s^2, four digits.
    pub c0_rad_per_s2: f64,
    /// delta0, rad, three digits.
    pub delta0_rad: f64,
    /// R^2 of heading on the validation run, three digits.
    pub r2: f64,
}

const fn row(
    thrust_percent: u32,
    surge_speed_m_s: f64,
    [a22_per_s, b2_per_s2, c0_rad_per_s2]: [f64; 3],
    delta0_rad: f64,
    r2: f64,
) -> Row {
    Row { thrust_percent, surge_speed_m_s, a22_per_s, b2_per_s2, c0_rad_per_s2, delta0_rad, r2 }
}

/// Online estimates with DVL and sidescan payload.
pub const TABLE_II: [Row; 5] = [
    row(60, 1.07, [-0.95, 0.60, 0.0072], 0.012, 0.780),
    row(70, 1.36, [-1.12, 0.87, 0.0107], 0.012, 0.916),
    row(80, 1.63, [-1.07, 1.08, 0.0120], 0.011, 0.890),
    row(90, 1.92, [-1.14, 1.37, 0.0054], 0.004, 0.900),
    row(100, 2.19, [-1.21, 1.77, 0.0049], 0.003, 0.852),
];

/// The offline method on the runs of Table II.
pub const TABLE_III: [Row; 5] = [
    row(60, 1.07, [-0.98, 0.61, 0.0078], 0.013, 0.888),
    row(70, 1.36, [-1.20, 0.88, 0.0125], 0.014, 0.741),
    row(80, 1.63, [-1.19, 1.12, 0.0149], 0.013, 0.756),
    row(90, 1.92, [-1.32, 1.48, 0.0072], 0.005, 0.957),
    row(100, 2.19, [-1.42, 1.85, 0.0073], 0.004, 0.941),
];

/// Iterations of the simplex search, last column of Table III.
pub const TABLE_III_ITERATIONS: [u32; 5] = [103, 81, 67, 137, 125];

/// Online estimates with DVL and thin-line array payload; 80 % was run twice.
pub const TABLE_V: [Row; 6] = [
    row(60, 1.05, [-1.28, 0.65, 0.0129], 0.016, 0.614),
    row(70, 1.32, [-1.51, 1.04, 0.0169], 0.020, 0.977),
    row(80, 1.60, [-1.70, 1.41, 0.0274], 0.019, 0.973),
    row(80, 1.60, [-1.54, 1.30, 0.0273], 0.021, 0.848),
    row(90, 1.87, [-1.69, 1.85, 0.0163], 0.009, 0.911),
    row(100, 2.13, [-1.48, 2.02, 0.0312], 0.016, 0.911),
];

/// K_p, last column of Table V, two digits.
pub const TABLE_V_GAINS: [f64; 6] = [1.26, 1.09, 1.02, 0.91, 0.77, 0.54];

/// The rudder limit of the STARFISH vehicle, rad.
pub const RUDDER_LIMIT_RAD: f64 = 0.26;

impl Row {
    /// The model with C0 as printed.
    pub fn model(&self) -> YawModel<f64> {
        YawModel::from_theta([self.a22_per_s, self.b2_per_s2, self.c0_rad_per_s2])
    }

    pub(super) fn speed(&self) -> PrintedNumber {
        printed(self.surge_speed_m_s, 2)
    }

    pub(super) fn a22(&self) -> PrintedNumber {
        printed(self.a22_per_s, 2)
    }

    pub(super) fn b2(&self) -> PrintedNumber {
        printed(self.b2_per_s2, 2)
    }

    pub(super) fn c0(&self) -> PrintedNumber {
        printed(self.c0_rad_per_s2, 4)
    }

    pub(super) fn delta0(&self) -> PrintedNumber {
        printed(self.delta0_rad, 3)
    }

    pub(super) fn r2(&self) -> PrintedNumber {
        printed(self.r2, 3)
    }
}

pub(super) const fn printed(value: f64, decimals: i32) -> PrintedNumber {
    PrintedNumber { value, decimals }
}

/// A number that is exact: a setting, or a coefficient of a printed equation.
pub(super) const fn exact(value: f64) -> PrintedNumber {
    PrintedNumber { value, decimals: i32::MAX }
}

//! The propeller in its inflow.

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

/// A screw behind the hull, its characteristics linear in the advance ratio.
///
/// ```text
/// X = (1 - t) rho D^4 (K_T0 n |n| + K_T1 |n| V_a/D),   V_a = (1 - w) u
/// K = c rho D^5 (K_Q0 n |n| + K_Q1 |n| V_a/D)
/// n = n_full (thrust - b)/(1 - b),  0 up to b
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | D | `diameter_m` | m | |
/// | n, n_full | shaft speed, `full_speed_rev_s` | rev/s | ahead |
/// | K_T0, K_T1 | `thrust_coefficients` | 1 | thrust at rest, its change per advance ratio |
/// | K_Q0, K_Q1 | `torque_coefficients` | 1 | the same of the torque |
/// | t | `thrust_deduction` | 1 | |
/// | w | `wake_fraction` | 1 | |
/// | c | `torque_on_hull` | 1 | share of the torque that rolls the hull; its sign is the hand of the screw |
/// | b | `dead_band` | 1 | thrust setting up to which the shaft stands still |
/// | u | surge speed through the water | m/s | forward |
///
/// Source: Fossen (2021), section 9.3 and its model of the REMUS 100. Astern (n < 0) the inflow is left out
/// there; here n is never negative, since thrust is 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Propeller {
    /// Diameter, m.
    pub diameter_m: f64,
    /// K_T0 and K_T1.
    pub thrust_coefficients: [f64; 2],
    /// K_Q0 and K_Q1.
    pub torque_coefficients: [f64; 2],
    /// t.
    pub thrust_deduction: f64,
    /// w.
    pub wake_fraction: f64,
    /// c.
    pub torque_on_hull: f64,
    /// Shaft speed at full thrust, rev/s.
    pub full_speed_rev_s: f64,
    /// Thrust setting up to which the shaft stands still.
    pub dead_band: f64,
    /// Time constant of the shaft speed, s.
    pub time_constant_s: f64,
}

impl Propeller {
    /// The shaft speed that a thrust setting, as a fraction of full, asks for, rev/s.
    pub fn shaft_speed_rev_s(&self, thrust: f64) -> f64 {
        self.full_speed_rev_s * ((thrust - self.dead_band) / (1.0 - self.dead_band)).max(0.0)
    }

    /// The shaft speed `interval_s` later.
    pub fn advance(&self, shaft_rev_s: f64, thrust: f64, interval_s: f64) -> f64 {
        let wanted = self.shaft_speed_rev_s(thrust);
        if self.time_constant_s > 0.0 {
            shaft_rev_s - libm::expm1(-interval_s / self.time_constant_s) * (wanted - shaft_rev_s)
        } else {
            wanted
        }
    }

    /// Force and moment at a surge speed through the water.
    pub fn force(
        &self,
        density_kg_m3: f64,
        surge_speed_m_s: f64,
        shaft_rev_s: f64,
    ) -> Vector6<f64> {
        let inflow = (1.0 - self.wake_fraction) * surge_speed_m_s / self.diameter_m;
        let characteristic = |[at_rest, slope]: [f64; 2]| {
            (at_rest * shaft_rev_s + slope * inflow) * shaft_rev_s.abs()
        };
        let d4 = self.diameter_m.powi(4);
        let thrust_n = density_kg_m3 * d4 * characteristic(self.thrust_coefficients);
        let torque_n_m =
            density_kg_m3 * d4 * self.diameter_m * characteristic(self.torque_coefficients);
        Vector6::new(
            (1.0 - self.thrust_deduction) * thrust_n,
            0.0,
            0.0,
            self.torque_on_hull * torque_n_m,
            0.0,
            0.0,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_dof::remus100;

    #[test]
    fn exact_bollard_pull_and_inflow() {
        let propeller = remus100::config().propeller;
        let density = 1026.0;
        let n = 1525.0 / 60.0;
        assert_eq!(propeller.shaft_speed_rev_s(1.0), n);
        let rest = propeller.force(density, 0.0, n)[0];
        let d4 = 0.14_f64.powi(4);
        assert!((rest - 0.9 * density * d4 * 0.4566 * n * n).abs() < 1e-9);
        // At the advance ratio of 2.5 m/s the coefficients are those that the slopes were made from.
        let ahead = propeller.force(density, 2.5, n)[0];
        assert!((ahead - 0.9 * density * d4 * 0.1798 * n * n).abs() < 0.01);
        assert_eq!(propeller.force(density, 2.0, 0.0), Vector6::zeros());
    }
}

//! Least squares of the yaw model from sums of products.

use seatrial_core::YawModel;

/// Rows that are added up before their sums go to the totals, so that rounding does not grow with the record.
const BLOCK: usize = 128;

/// The normal equations of psi''_f = a22 psi'_f + b2 delta_f + C0.
///
/// ```text
/// Theta = (sum phi phi^T)^-1 sum phi psi''_f,   phi = [psi'_f, delta_f, 1]       (15), (32)-(34)
/// ```
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | psi''_f | filtered yaw acceleration | rad/s^2 |
/// | psi'_f | filtered yaw rate | rad/s |
/// | delta_f | filtered rudder | rad |
///
/// Nine numbers are kept and a row costs no division. The condition number is squared, unlike in
/// [`BatchLeastSquares`](super::batch::BatchLeastSquares): 10 to 1000 for a vehicle that was excited, so that at least
/// half of the digits of `f64` are left.
#[derive(Clone, Copy, Debug, Default)]
pub struct NormalEquations {
    sums: [f64; 8],
    rows: usize,
}

impl NormalEquations {
    /// Adds rows: psi'_f in rad/s and delta_f in rad, and the psi''_f in rad/s^2 that they are to explain.
    #[inline]
    pub fn extend(&mut self, mut rows: impl Iterator<Item = ([f64; 2], f64)>) {
        loop {
            let mut block = [0.0; 8];
            let mut count = 0;
            for ([rate, rudder], acceleration) in rows.by_ref().take(BLOCK) {
                let terms = [
                    rate,
                    rudder,
                    acceleration,
                    rate * rate,
                    rate * rudder,
                    rudder * rudder,
                    rate * acceleration,
                    rudder * acceleration,
                ];
                for (sum, term) in block.iter_mut().zip(terms) {
                    *sum += term;
                }
                count += 1;
            }
            if count == 0 {
                return;
            }
            for (sum, of_block) in self.sums.iter_mut().zip(block) {
                *sum += of_block;
            }
            self.rows += count;
        }
    }

    /// Theta. `None` where the rows do not determine it, or one was not finite.
    pub fn solve(&self) -> Option<YawModel<f64>> {
        let [
            rate,
            rudder,
            acceleration,
            rate2,
            rate_rudder,
            rudder2,
            rate_acceleration,
            rudder_acceleration,
        ] = self.sums;
        // The constant is eliminated first, which centres the sums, then the rate.
        let share = 1.0 / self.rows as f64;
        let (mean_rate, mean_rudder) = (rate * share, rudder * share);
        let rate2 = rate2 - mean_rate * rate;
        let mixed = rate_rudder - mean_rate * rudder;
        let slope = mixed / rate2;
        let rudder2 = rudder2 - mean_rudder * rudder - slope * mixed;
        if !(rate2 > 0.0 && rudder2 > 0.0) {
            return None;
        }
        let by_rate = rate_acceleration - mean_rate * acceleration;
        let by_rudder = rudder_acceleration - mean_rudder * acceleration;
        let b2 = (by_rudder - slope * by_rate) / rudder2;
        let a22 = (by_rate - mixed * b2) / rate2;
        let c0 = (acceleration - a22 * rate - b2 * rudder) * share;
        let theta = [a22, b2, c0];
        let is_finite = theta.iter().all(|parameter| parameter.is_finite());
        is_finite.then(|| YawModel::from_theta(theta))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::batch::BatchLeastSquares;

    #[test]
    fn parity_a_million_rows_stay_with_an_orthogonal_factorisation() {
        let (mut sums, mut rotations) = (NormalEquations::default(), BatchLeastSquares::default());
        let mut random = 1_u64;
        let rows = (0..1_000_000).map(|k| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (random >> 40) as f64 / f64::from(1 << 24) - 0.5;
            let t = f64::from(k) * 0.05;
            let (rate, rudder) = (0.2 * (0.7 * t).sin(), 0.26 * (0.31 * t).cos() - 0.01);
            let acceleration = -1.07 * rate + 1.08 * rudder + 0.012 + 0.1 * noise;
            rotations.add([rate, rudder, 1.0], acceleration);
            ([rate, rudder], acceleration)
        });
        sums.extend(rows);
        let found = sums.solve().unwrap().theta();
        for (found, expected) in found.into_iter().zip(rotations.solve().unwrap().theta()) {
            // A million roundings each, which partly average out.
            assert!((found - expected).abs() < 1e-11, "{found} {expected}");
        }
    }

    #[test]
    fn prop_without_excitation_or_with_not_a_number_there_is_no_model() {
        for (rate, acceleration) in [(0.1, 0.0), (f64::NAN, 0.0), (0.1, f64::NAN)] {
            let mut sums = NormalEquations::default();
            assert_eq!(sums.solve(), None);
            sums.extend(std::iter::repeat_n(([rate, 0.1], acceleration), 300));
            assert_eq!(sums.solve(), None);
        }
    }
}

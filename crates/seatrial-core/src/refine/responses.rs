//! How the heading answers rudder, offset and initial yaw rate.

use super::lanes::Lanes;
use crate::model::{Discretisation, PHI_SERIES_BELOW};

/// [`Discretisation`] of one interval for several dampings.
#[derive(Clone, Copy, Debug)]
pub struct Step<const N: usize> {
    pub decay: Lanes<N>,
    pub rate_gain_s: Lanes<N>,
    pub heading_gain_s2: Lanes<N>,
}

/// A change of the interval by this share of it is the rounding of a clock and makes no other step.
const SAME_INTERVAL: f64 = 1e-9;

/// Below this |a22 h| nine terms of the series of phi2 are exact to rounding: the tenth is less than 4e-16 of the first.
const NINE_TERMS_BELOW: f64 = 1.0 / 8.0;

/// 1/15!, 1/14!, ..., 1/2!: the series of phi2, the highest power first.
const PHI2_SERIES: [f64; 14] = {
    let mut series = [0.0; 14];
    let mut factorial = 1.0;
    let mut k = 2;
    while k <= 15 {
        factorial *= k as f64;
        series[15 - k] = 1.0 / factorial;
        k += 1;
    }
    series
};

impl<const N: usize> Step<N> {
    fn new(a22_per_s: [f64; N], interval_s: f64) -> Self {
        if (a22_per_s.iter()).all(|a22| (a22 * interval_s).abs() < PHI_SERIES_BELOW) {
            return Self::short(a22_per_s, interval_s);
        }
        let steps = a22_per_s.map(|a22| Discretisation::new(a22, interval_s));
        Self {
            decay: Lanes(steps.map(|step| step.decay)),
            rate_gain_s: Lanes(steps.map(|step| step.rate_gain_s)),
            heading_gain_s2: Lanes(steps.map(|step| step.heading_gain_s2)),
        }
    }

    /// The steps by the series of phi2: phi1 = 1 + x phi2, e^x = 1 + x phi1. It multiplies, where the model's own series divides: that one is
    /// the shorter code on a microcontroller, this one takes all lanes together.
    fn short(a22_per_s: [f64; N], interval_s: f64) -> Self {
        let one = Lanes::all(1.0);
        let x = Lanes(a22_per_s) * interval_s;
        let horner = |sum, coefficient: &f64| Lanes::all(*coefficient) + x * sum;
        let [_, _, _, _, _, lowest @ ..] = &PHI2_SERIES;
        let phi2 = match x.0.iter().all(|x| x.abs() < NINE_TERMS_BELOW) {
            true => lowest.iter().fold(Lanes::ZERO, horner),
            false => PHI2_SERIES.iter().fold(Lanes::ZERO, horner),
        };
        let phi1 = one + x * phi2;
        Self {
            decay: one + x * phi1,
            rate_gain_s: phi1 * interval_s,
            heading_gain_s2: phi2 * (interval_s * interval_s),
        }
    }
}

/// The responses of the heading to b2, C0 and r0; that to psi0 is 1.
///
/// The yaw rate that a unit offset has given is the heading that a unit initial yaw rate has: both are the integral of
/// `exp(a22 t)`.
#[derive(Clone, Copy, Debug)]
pub struct Responses<const N: usize> {
    a22_per_s: [f64; N],
    interval_s: f64,
    step: Step<N>,
    pub to_rudder_rad: Lanes<N>,
    rate_to_rudder_rad_s: Lanes<N>,
    pub to_offset_rad: Lanes<N>,
    pub to_rate_rad: Lanes<N>,
}

impl<const N: usize> Responses<N> {
    pub fn new(a22_per_s: [f64; N]) -> Self {
        Self {
            a22_per_s,
            interval_s: 0.0,
            step: Step::new(a22_per_s, 0.0),
            to_rudder_rad: Lanes::ZERO,
            rate_to_rudder_rad_s: Lanes::ZERO,
            to_offset_rad: Lanes::ZERO,
            to_rate_rad: Lanes::ZERO,
        }
    }

    /// The step over an interval: the last one where it was that long.
    pub fn step_over(&self, interval_s: f64) -> Step<N> {
        match (interval_s - self.interval_s).abs() > SAME_INTERVAL * interval_s {
            true => Step::new(self.a22_per_s, interval_s),
            false => self.step,
        }
    }

    /// One interval on, with the rudder held.
    #[inline(never)]
    pub fn advance(&mut self, interval_s: f64, rudder_rad: f64) {
        if (interval_s - self.interval_s).abs() > SAME_INTERVAL * interval_s {
            self.step = Step::new(self.a22_per_s, interval_s);
            self.interval_s = interval_s;
        }
        let Step { decay, rate_gain_s, heading_gain_s2 } = self.step;
        self.to_rudder_rad +=
            rate_gain_s * self.rate_to_rudder_rad_s + heading_gain_s2 * rudder_rad;
        self.rate_to_rudder_rad_s = decay * self.rate_to_rudder_rad_s + rate_gain_s * rudder_rad;
        self.to_offset_rad += rate_gain_s * self.to_rate_rad + heading_gain_s2;
        self.to_rate_rad = decay * self.to_rate_rad + rate_gain_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::YawModel;

    #[test]
    fn exact_responses_are_the_models() {
        let a22_per_s = [-1.07, -0.02, 0.3];
        let mut responses = Responses::new(a22_per_s);
        let models =
            |theta: [f64; 2]| a22_per_s.map(|a22| YawModel::from_theta([a22, theta[0], theta[1]]));
        let mut states = [models([1.0, 0.0]), models([0.0, 1.0]), models([0.0, 0.0])]
            .map(|models| models.map(|model| (model, crate::model::YawState::default())));
        for (_, state) in &mut states[2] {
            state.yaw_rate_rad_s = 1.0;
        }
        for (interval_s, rudder_rad) in [(0.05, 0.26), (0.07, -0.26), (1.3, 0.1), (0.05, 0.0)] {
            responses.advance(interval_s, rudder_rad);
            for (model, state) in states.iter_mut().flatten() {
                *state = model.advance(*state, rudder_rad, interval_s);
            }
        }
        let found = [responses.to_rudder_rad, responses.to_offset_rad, responses.to_rate_rad];
        for lane in 0..3 {
            for (found, expected) in found.iter().zip(&states) {
                // Rounding of a dozen operations on numbers of order 1.
                assert!((found.0[lane] - expected[lane].1.heading_rad).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn exact_short_series_are_the_closed_forms() {
        // To either side of where nine terms are enough.
        for interval_s in [1e-3, 0.1249, 0.1251, 0.4999] {
            let step = Step::new([-1.0, 0.5], interval_s);
            for (lane, a22_per_s) in [-1.0, 0.5].into_iter().enumerate() {
                let expected = Discretisation::new(a22_per_s, interval_s);
                // A few roundings of the last digit.
                let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-15;
                assert!(near(step.decay.0[lane], expected.decay));
                assert!(near(step.rate_gain_s.0[lane], expected.rate_gain_s));
                assert!(near(step.heading_gain_s2.0[lane], expected.heading_gain_s2));
            }
        }
    }
}

//! Gains for an autopilot that leads the vehicle by a heading target of its own and has no F (ArduSub).
//!
//! ```text
//! P = p/B,   I = c alpha P,   A = k/(1/p + T + T_T)
//! r_max = 0.85 rho U/alpha,   a_max = 0.85 (1 - rho) q U,   U = B (1 - taken) - |C0|,   i_max = 1.3 (alpha r_max + |C0|)/B
//! ```
//!
//! so that the integral's zero is about the boat's own pole (c = 1: it is), and the target asks for no more than 85 % of the steering.
//! T_T is that of the filter that was found. Of those that overshoot by less than [`MOST_LED_OVERSHOOT`] it is the one with the least
//! settling time and [`DRIFT`]/A, in which an error goes that no step made.
//!
//! The other symbols are those of the design for Rover.

use seatrial_core::CascadeSettings;

use super::evidence::{Evidence, filter_s};

/// The most that the least favourable boat may overshoot, a fraction of the step.
pub(super) const MOST_LED_OVERSHOOT: f64 = 0.06;
/// p T at most, and what is tried of p/alpha, k, rho, q and c.
const MOST_LED_BANDWIDTH: f64 = 0.6;
const LED_RATE: [f64; 6] = [0.7, 1.0, 1.5, 2.2, 3.3, 5.0];
const LED_ANGLE: [f64; 5] = [0.6, 0.43, 0.3, 0.2, 0.1];
const LED_TURN: [f64; 2] = [0.5, 0.7];
const LED_ONSET: [f64; 4] = [1.0, 0.5, 0.25, 0.12];
const LED_INTEGRAL: [f64; 3] = [1.0, 0.8, 0.6];
/// What the integral may give beyond what a steady turn takes.
const INTEGRAL_SPARE: f64 = 1.3;
/// The share of the steering that the target asks for at most.
const LED_SHARE: f64 = 0.85;
/// Settling is worth so many of 1/A.
pub(super) const DRIFT: f64 = 0.5;

impl Evidence {
    /// The settings for p, k, rho, q and c.
    fn led_candidate(
        &self,
        p: f64,
        [k, rho, q, c]: [f64; 4],
        found: &CascadeSettings<f64>,
    ) -> CascadeSettings<f64> {
        let alpha = -self.model.a22_per_s;
        let authority = self.model.b2_per_s2;
        let trim = self.model.c0_rad_per_s2.abs();
        let spare = LED_SHARE * (authority * (1.0 - self.steering_taken) - trim).max(0.0);
        let body_limit = found.shaping.map_or(0.0, |shaping| shaping.rate_limit_rad_s);
        let rate = rho * spare / alpha;
        let rate_limit_rad_s = match body_limit > 0.0 {
            true => rate.min(body_limit),
            false => rate,
        };
        let late_s = self.lateness_s(found.error_filter_hz) + filter_s(found.target_filter_hz);
        let held = INTEGRAL_SPARE * (alpha * rate_limit_rad_s + trim) / authority;
        CascadeSettings {
            angle_gain_per_s: k / (1.0 / p + late_s),
            feed_forward_s: 0.0,
            rate_gain_s: p / authority,
            rate_integral_gain: c * alpha * p / authority,
            integral_limit: found.integral_limit.max(held.min(1.0)),
            rate_limit_rad_s,
            acceleration_limit_rad_s2: (1.0 - rho) * q * spare,
            rate_derivative_gain_s2: 0.0,
            ..*found
        }
    }

    /// Every one of these.
    pub(super) fn led_candidates(&self, found: &CascadeSettings<f64>) -> Vec<CascadeSettings<f64>> {
        let alpha = -self.model.a22_per_s;
        let most = MOST_LED_BANDWIDTH / self.lateness_s(found.error_filter_hz);
        let mut rates = LED_RATE.map(|share| (share * alpha).min(most)).to_vec();
        rates.dedup();
        let mut candidates = Vec::new();
        for p in rates {
            for k in LED_ANGLE {
                for rho in LED_TURN {
                    let rest = LED_ONSET.iter().flat_map(|q| LED_INTEGRAL.map(|c| (*q, c)));
                    candidates
                        .extend(rest.map(|(q, c)| self.led_candidate(p, [k, rho, q, c], found)));
                }
            }
        }
        candidates
    }
}

#[cfg(test)]
mod tests {
    use super::super::design::propose;
    use super::super::design::tests::evidence;
    use super::super::evidence::NoProposal;
    use super::super::response::Response;
    use super::*;
    use seatrial_core::TargetShaping;

    /// ArduSub's settings as they come, 4.7.
    fn submarine() -> CascadeSettings<f64> {
        CascadeSettings {
            angle_gain_per_s: 6.0,
            rate_gain_s: 0.18,
            rate_integral_gain: 0.018,
            integral_limit: 0.222,
            target_filter_hz: 5.0,
            derivative_filter_hz: 5.0,
            rate_limit_rad_s: 60_f64.to_radians(),
            acceleration_limit_rad_s2: 1100_f64.to_radians(),
            shaping: Some(TargetShaping { time_constant_s: 0.15, rate_limit_rad_s: 0.0 }),
            ..CascadeSettings::default()
        }
    }

    fn under_water(time_constant_s: f64, lag_s: f64) -> Evidence {
        Evidence {
            rate_noise_rad_s: 0.002,
            loop_interval_s: 0.0025,
            steering_taken: 0.4,
            ..evidence(time_constant_s, lag_s)
        }
    }

    /// Whose thrusters lag as long as it takes to turn.
    #[test]
    fn exact_a_submarine_that_cannot_be_led_gets_no_gains() {
        let refused = propose(&under_water(0.3, 0.25), &submarine());
        assert_eq!(refused.unwrap_err(), NoProposal::TooUncertain);
    }

    /// A gyro that is shaken allows none, and says so.
    #[test]
    fn exact_a_shaken_gyro_is_told() {
        let shaken = Evidence { rate_noise_rad_s: 0.2, ..under_water(1.0, 0.1) };
        let refused = propose(&shaken, &submarine()).unwrap_err();
        assert!(matches!(refused, NoProposal::TooNoisy(_)), "{refused}");
    }

    /// A submarine, two fifths of whose thrusters are taken by its way ahead.
    #[test]
    fn prop_the_least_favourable_submarine_steps_without_overshoot() {
        for (time_constant_s, lag_s) in [(0.3, 0.05), (1.0, 0.1), (1.0, 0.3), (4.0, 0.3)] {
            let evidence = under_water(time_constant_s, lag_s);
            let settings = propose(&evidence, &submarine()).unwrap();
            assert!(settings.shaping.is_some() && settings.feed_forward_s == 0.0);
            let test = evidence.test(settings.angle_gain_per_s);
            for boat in evidence.boats() {
                let legs = test.simulate(&boat, &settings, 1);
                let response = Response::measure(&legs, test.step_rad, 0.0, 0.0).unwrap();
                assert!(response.overshoot <= MOST_LED_OVERSHOOT, "{response:?}");
                let slowest_s = 6.0 * (time_constant_s + lag_s) + 4.0;
                let settles_s = response.settling_s;
                assert!(settles_s.is_some_and(|s| s < slowest_s), "{response:?}");
            }
        }
    }
}

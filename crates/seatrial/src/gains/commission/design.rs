//! Gains that hold for every boat that the evidence allows.
//!
//! ```text
//! alpha = -a22,  beta = alpha + B P,   T = T_l + T_d + h + T_E
//! F = alpha/B,   P = p/B,   A = k/(1/beta + T + T_T),   I = 0.2 A beta/B
//! a_max = 0.8 (B - |C0|),   r_max = 0.85 (B - |C0|)/alpha
//! ```
//!
//! p, k and T_T are searched for: of those whose 30 degree step overshoots by less than [`MOST_OVERSHOOT`] and settles for
//! each of the least favourable boats, the one that settles soonest for the slowest of them.
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | T | the delays of the rate loop: rudder, half a loop held, filter of the rate error | s |
//! | h | `loop_interval_s` | s |
//! | T_T | filter of the wanted turn rate, against the noise of the heading | s |
//! | p | damping that feedback of the rate adds, at most what 0.3/T leaves | 1/s |

use seatrial_core::CascadeSettings;

use super::boat::{Boat, StepTest};
use super::evidence::{Evidence, NoProposal, STEP_RAD};
use super::led::{DRIFT, MOST_LED_OVERSHOOT};
use super::response::Response;

/// The most that the least favourable boat may overshoot, a fraction of the step.
const MOST_OVERSHOOT: f64 = 0.04;
/// The most that the noise of the yaw rate may move the rudder, full deflections per second.
const MOST_ACTIVITY_PER_S: f64 = 0.25;
/// beta T at most.
const MOST_BANDWIDTH: f64 = 0.3;
/// p/alpha, k and times of the filter as shares of 1/beta that are tried.
const DAMPING: [f64; 6] = [0.0, 0.3, 0.7, 1.3, 2.2, 4.0];
const ANGLE: [f64; 8] = [0.2, 0.27, 0.33, 0.38, 0.43, 0.48, 0.54, 0.6];
const FILTER: [f64; 2] = [0.0, 0.25];
/// Between two samples by which the rudder's work is counted, s.
const RECORD_S: f64 = 0.05;

impl Evidence {
    /// p, as this share of alpha and no more than the delays leave, 1/s.
    fn added(&self, share: f64, found: &CascadeSettings<f64>) -> f64 {
        let alpha = -self.model.a22_per_s;
        let most = (MOST_BANDWIDTH / self.lateness_s(found.error_filter_hz) - alpha).max(0.0);
        (share * alpha).min(most)
    }

    /// The settings for p, k and a filter of the wanted turn rate with this time constant, as a share of 1/beta; 0: the
    /// filter that was found.
    fn candidate(
        &self,
        added: f64,
        k: f64,
        filter: f64,
        found: &CascadeSettings<f64>,
    ) -> CascadeSettings<f64> {
        let alpha = -self.model.a22_per_s;
        let authority = self.model.b2_per_s2;
        let beta = alpha + added;
        let late_s = self.lateness_s(found.error_filter_hz) + filter / beta;
        let angle_gain_per_s = k / (1.0 / beta + late_s);
        let spare = authority - self.model.c0_rad_per_s2.abs();
        let target_filter_hz = match filter > 0.0 {
            true => beta / (2.0 * std::f64::consts::PI * filter),
            false => found.target_filter_hz,
        };
        CascadeSettings {
            angle_gain_per_s,
            feed_forward_s: alpha / authority,
            rate_gain_s: added / authority,
            rate_integral_gain: 0.2 * angle_gain_per_s * beta / authority,
            rate_derivative_gain_s2: 0.0,
            integral_limit: found.integral_limit,
            target_filter_hz,
            error_filter_hz: found.error_filter_hz,
            derivative_filter_hz: found.derivative_filter_hz,
            rate_limit_rad_s: 0.85 * spare / alpha,
            acceleration_limit_rad_s2: 0.8 * spare,
            steering_limit: found.steering_limit,
            shaping: None,
        }
    }

    /// Every candidate, those that damp least first.
    fn candidates(&self, found: &CascadeSettings<f64>) -> Vec<CascadeSettings<f64>> {
        if found.shaping.is_some() {
            return self.led_candidates(found);
        }
        let mut added = DAMPING.map(|share| self.added(share, found)).to_vec();
        added.dedup();
        let pairs = added.iter().flat_map(|p| ANGLE.map(|k| (*p, k)));
        pairs.flat_map(|(p, k)| FILTER.map(|filter| self.candidate(p, k, filter, found))).collect()
    }
}

/// The settings for a boat whose autopilot has these now. The filter of the rate error and the limit of the integral stay as they are.
///
/// ```
/// use seatrial::gains::commission::{Evidence, NoProposal, propose};
/// use seatrial_core::{CascadeSettings, YawModel};
///
/// let evidence = |a22| Evidence {
///     model: YawModel::from_theta([a22, 1.0, 0.0]),
///     covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]],
///     lag_s: 0.1,
///     delay_s: 0.0,
///     rate_noise_rad_s: 0.002,
///     heading_noise_rad: 0.005,
///     disturbance_rad_s2: 0.0,
///     loop_interval_s: 0.02,
///     steering_taken: 0.0,
/// };
/// assert!(propose(&evidence(-1.0), &CascadeSettings::default())?.angle_gain_per_s > 0.0);
/// let unstable = propose(&evidence(0.1), &CascadeSettings::default());
/// assert_eq!(unstable, Err(NoProposal::CourseUnstable));
/// # Ok::<(), NoProposal>(())
/// ```
pub fn propose(
    evidence: &Evidence,
    found: &CascadeSettings<f64>,
) -> Result<CascadeSettings<f64>, NoProposal> {
    evidence.check()?;
    let boats = evidence.boats();
    let mut best: Option<(f64, CascadeSettings<f64>)> = None;
    let mut none = NoProposal::TooUncertain;
    for settings in evidence.candidates(found) {
        let drift_s = match settings.shaping {
            Some(_) => DRIFT / settings.angle_gain_per_s,
            None => 0.0,
        };
        let soonest_s = best.as_ref().map_or(f64::INFINITY, |(best_s, _)| *best_s);
        let Some(slowest_s) = slowest(evidence, &boats, &settings, soonest_s - drift_s) else {
            continue;
        };
        match is_quiet(evidence, &settings) {
            true => best = Some((slowest_s + drift_s, settings)),
            false => none = NoProposal::TooNoisy(evidence.rate_noise_rad_s.to_degrees()),
        }
    }
    best.map(|(_, settings)| settings).ok_or(none)
}

/// How long the slowest of the boats takes to settle, s. `None` where one overshoots or takes no less than `soonest_s`.
fn slowest(
    evidence: &Evidence,
    boats: &[Boat],
    settings: &CascadeSettings<f64>,
    soonest_s: f64,
) -> Option<f64> {
    let most_overshoot = match settings.shaping {
        Some(_) => MOST_LED_OVERSHOOT,
        None => MOST_OVERSHOOT,
    };
    let test = evidence.test(settings.angle_gain_per_s);
    let mut slowest_s = 0.0_f64;
    for boat in boats {
        if slowest_s >= soonest_s || soonest_s <= 0.0 {
            return None;
        }
        let legs = test.simulate(boat, settings, 1);
        let response = Response::measure(&legs, STEP_RAD, 0.0, 0.0)?;
        slowest_s = slowest_s.max(response.settling_s?);
        if response.overshoot > most_overshoot || slowest_s >= soonest_s {
            return None;
        }
    }
    Some(slowest_s)
}

/// Does the noise leave the rudder in peace?
fn is_quiet(evidence: &Evidence, settings: &CascadeSettings<f64>) -> bool {
    if evidence.rate_noise_rad_s <= 0.0 {
        return true;
    }
    let loops = (RECORD_S / evidence.loop_interval_s).round().max(1.0);
    let test = StepTest {
        sample_interval_s: loops * evidence.loop_interval_s,
        loop_interval_s: evidence.loop_interval_s,
        ..evidence.test(settings.angle_gain_per_s)
    };
    let legs = test.simulate(&evidence.noisy_boat(), settings, 1);
    let response = Response::measure(&legs, STEP_RAD, 0.0, 0.0);
    response.is_some_and(|response| response.activity_per_s < MOST_ACTIVITY_PER_S)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use seatrial_core::YawModel;

    fn found() -> CascadeSettings<f64> {
        CascadeSettings { integral_limit: 1.0, error_filter_hz: 10.0, ..CascadeSettings::default() }
    }

    /// Of a boat whose damping and rudder are known to 5 %.
    pub fn evidence(time_constant_s: f64, lag_s: f64) -> Evidence {
        let authority = 0.8 / time_constant_s;
        let share = |value: f64| (0.05 * value).powi(2);
        Evidence {
            model: YawModel::from_theta([-1.0 / time_constant_s, authority, 0.01 * authority]),
            covariance: [
                [share(1.0 / time_constant_s), 0.0, 0.0],
                [0.0, share(authority), 0.0],
                [0.0; 3],
            ],
            lag_s,
            delay_s: 0.04,
            rate_noise_rad_s: 0.005,
            heading_noise_rad: 0.005,
            disturbance_rad_s2: 0.0,
            loop_interval_s: 0.02,
            steering_taken: 0.0,
        }
    }

    /// Also where the boat is 10 % off and its rudder lags as much more as the design allows for.
    #[test]
    fn prop_the_least_favourable_boat_steps_without_overshoot() {
        for (time_constant_s, lag_s) in [(0.3, 0.0), (0.3, 0.25), (1.0, 0.1), (4.0, 0.3)] {
            let evidence = evidence(time_constant_s, lag_s);
            let settings = propose(&evidence, &found()).unwrap();
            let test = evidence.test(settings.angle_gain_per_s);
            for boat in evidence.boats() {
                let legs = test.simulate(&boat, &settings, 1);
                let response = Response::measure(&legs, STEP_RAD, 0.0, 0.0).unwrap();
                assert!(response.overshoot <= MOST_OVERSHOOT, "{response:?}");
                assert!(response.settling_s.is_some(), "{response:?}");
            }
        }
    }

    /// A noisier gyro gets less feedback of the rate.
    #[test]
    fn prop_noise_of_the_yaw_rate_takes_feedback_away() {
        let quiet = evidence(2.0, 0.05);
        let noisy = Evidence { rate_noise_rad_s: 0.05, ..quiet };
        let gain = |evidence: &Evidence| propose(evidence, &found()).unwrap().rate_gain_s;
        assert!(gain(&noisy) < 0.8 * gain(&quiet));
    }

    #[test]
    fn exact_what_cannot_be_steered_is_refused() {
        let good = evidence(1.0, 0.1);
        let with = |theta| Evidence { model: YawModel::from_theta(theta), ..good };
        let refused = |evidence: Evidence| propose(&evidence, &found()).unwrap_err();
        assert_eq!(refused(with([-0.05, 0.8, 0.0])), NoProposal::CourseUnstable);
        assert_eq!(refused(with([-1.0, -0.8, 0.0])), NoProposal::NoAuthority(-0.8));
        assert!(matches!(refused(with([-1.0, 0.8, 0.5])), NoProposal::OffCentre(_)));
    }
}

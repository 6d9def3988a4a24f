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

use seatrial_core::{CascadeSettings, YawModel};

use super::boat::{Boat, StepTest};
use super::response::Response;

/// The step that gains are designed for: 30 degrees, rad.
const STEP_RAD: f64 = std::f64::consts::FRAC_PI_6;
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
/// A boat is stepped through in this share of its time constant, and in no longer steps, s.
const DENSITY: f64 = 0.02;
const SLOWEST_LOOP_S: f64 = 0.1;
/// Between two samples by which the rudder's work is counted, s.
const RECORD_S: f64 = 0.05;
/// How many standard deviations the least favourable boats are away.
const DEVIATIONS: f64 = 2.0;
/// A rudder may be late by this share more than identified, and by this time where nothing shows.
const LATER: f64 = 0.3;
const LATER_S: f64 = 0.05;

/// What is known of a boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// The model, its steering in fractions of full.
    pub model: YawModel<f64>,
    /// Covariance of a22, B and C0.
    pub covariance: [[f64; 3]; 3],
    /// Lag of the rudder, s.
    pub lag_s: f64,
    /// Its dead time, s.
    pub delay_s: f64,
    /// White noise of the yaw rate, rad/s.
    pub rate_noise_rad_s: f64,
    /// White noise of the heading, rad.
    pub heading_noise_rad: f64,
    /// Between two loops of the autopilot, s.
    pub loop_interval_s: f64,
}

/// Why no gains are proposed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoProposal {
    /// a22 is not negative over its interval.
    #[error(
        "the 95 % interval of a22 holds 0: the boat may not keep a straight course by itself; repeat the trial with a longer manoeuvre"
    )]
    CourseUnstable,
    /// B is not positive over its interval.
    #[error(
        "steering to starboard does not surely turn to starboard (B {0:.3} rad/s^2): reverse the steering output on the autopilot, or repeat the trial"
    )]
    NoAuthority(f64),
    /// The rudder that holds a straight course leaves none to steer with.
    #[error(
        "{0:.0} % of the steering is needed to go straight: trim the steering servo, and repeat the trial"
    )]
    OffCentre(f64),
    /// No pair of gains steps well on every boat that the evidence allows.
    #[error(
        "no gains step without overshoot on every boat that the intervals allow; repeat the trial for narrower intervals"
    )]
    TooUncertain,
}

impl Evidence {
    /// The boat that is most likely.
    pub fn boat(&self) -> Boat {
        Boat {
            model: self.model,
            lag_s: self.lag_s,
            delay_s: self.delay_s,
            ..Boat::default()
        }
    }

    /// The most likely boat with the noise of its gyro and compass.
    pub fn noisy_boat(&self) -> Boat {
        Boat {
            rate_noise_rad_s: self.rate_noise_rad_s,
            heading_noise_rad: self.heading_noise_rad,
            ..self.boat()
        }
    }

    /// Standard deviations of a22 and B.
    pub(super) fn deviations(&self) -> [f64; 2] {
        [0, 1].map(|i| self.covariance[i][i].max(0.0).sqrt())
    }

    /// Boats at the ends of what the evidence allows, the most likely one first.
    fn boats(&self) -> Vec<Boat> {
        let [of_a22, of_b] = self.deviations().map(|deviation| DEVIATIONS * deviation);
        let late = self.boat();
        let later_s = LATER_S.max(LATER * (self.lag_s + self.delay_s));
        let mut boats = vec![late];
        for (a22, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let model = YawModel {
                a22_per_s: self.model.a22_per_s + a22 * of_a22,
                b2_per_s2: self.model.b2_per_s2 + b * of_b,
                ..self.model
            };
            let lag_s = self.lag_s + later_s;
            boats.push(Boat { model, ..late });
            boats.push(Boat {
                model,
                lag_s,
                ..late
            });
        }
        boats
    }

    /// Can such a boat be steered at all?
    pub fn check(&self) -> Result<(), NoProposal> {
        let [of_a22, of_b] = self.deviations().map(|deviation| DEVIATIONS * deviation);
        let YawModel {
            a22_per_s,
            b2_per_s2,
            c0_rad_per_s2,
        } = self.model;
        if a22_per_s + of_a22 >= 0.0 || !a22_per_s.is_finite() {
            return Err(NoProposal::CourseUnstable);
        }
        if b2_per_s2 - of_b <= 0.0 || !b2_per_s2.is_finite() {
            return Err(NoProposal::NoAuthority(b2_per_s2));
        }
        let trim = (c0_rad_per_s2 / b2_per_s2).abs();
        match trim < 0.5 {
            true => Ok(()),
            false => Err(NoProposal::OffCentre(100.0 * trim)),
        }
    }

    /// T, s.
    fn lateness_s(&self, filter_hz: f64) -> f64 {
        let filter_s = match filter_hz > 0.0 {
            true => 1.0 / (2.0 * std::f64::consts::PI * filter_hz),
            false => 0.0,
        };
        self.lag_s + self.delay_s + self.loop_interval_s + filter_s
    }

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
        }
    }

    /// Every candidate, those that damp least first.
    fn candidates(&self, found: &CascadeSettings<f64>) -> Vec<CascadeSettings<f64>> {
        let mut added = DAMPING.map(|share| self.added(share, found)).to_vec();
        added.dedup();
        let pairs = added.iter().flat_map(|p| ANGLE.map(|k| (*p, k)));
        pairs
            .flat_map(|(p, k)| FILTER.map(|filter| self.candidate(p, k, filter, found)))
            .collect()
    }

    /// A step that lets this candidate settle. A slow boat is stepped through in steps of its own time, which a faster loop
    /// could only do better.
    fn test(&self, angle_gain_per_s: f64) -> StepTest {
        let [alpha, authority] = [-self.model.a22_per_s, self.model.b2_per_s2];
        let hold_s = 8.0 / angle_gain_per_s + 8.0 * STEP_RAD * alpha / authority;
        let own_s = (DENSITY / alpha).min(SLOWEST_LOOP_S);
        let loop_interval_s = self.loop_interval_s.max(own_s);
        StepTest {
            step_rad: STEP_RAD,
            settle_s: 0.25 * hold_s,
            hold_s,
            sample_interval_s: loop_interval_s,
            loop_interval_s,
        }
    }
}

/// The settings for a boat whose autopilot has these now. The filter of the rate error and the limit of the integral stay as they are.
pub fn propose(
    evidence: &Evidence,
    found: &CascadeSettings<f64>,
) -> Result<CascadeSettings<f64>, NoProposal> {
    evidence.check()?;
    let boats = evidence.boats();
    let mut best: Option<(f64, CascadeSettings<f64>)> = None;
    for settings in evidence.candidates(found) {
        let soonest_s = best.as_ref().map_or(f64::INFINITY, |(best_s, _)| *best_s);
        let Some(slowest_s) = slowest(evidence, &boats, &settings, soonest_s) else {
            continue;
        };
        if is_quiet(evidence, &settings) {
            best = Some((slowest_s, settings));
        }
    }
    best.map(|(_, settings)| settings)
        .ok_or(NoProposal::TooUncertain)
}

/// How long the slowest of the boats takes to settle, s. `None` where one overshoots or takes no less than `soonest_s`.
fn slowest(
    evidence: &Evidence,
    boats: &[Boat],
    settings: &CascadeSettings<f64>,
    soonest_s: f64,
) -> Option<f64> {
    let test = evidence.test(settings.angle_gain_per_s);
    let mut slowest_s = 0.0_f64;
    for boat in boats {
        let legs = test.simulate(boat, settings, 1);
        let response = Response::measure(&legs, STEP_RAD, 0.0)?;
        slowest_s = slowest_s.max(response.settling_s?);
        if response.overshoot > MOST_OVERSHOOT || slowest_s >= soonest_s {
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
    let response = Response::measure(&legs, STEP_RAD, 0.0);
    response.is_some_and(|response| response.activity_per_s < MOST_ACTIVITY_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::CascadeSettings;

    fn found() -> CascadeSettings<f64> {
        CascadeSettings {
            integral_limit: 1.0,
            error_filter_hz: 10.0,
            ..CascadeSettings::default()
        }
    }

    fn evidence(time_constant_s: f64, lag_s: f64) -> Evidence {
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
            loop_interval_s: 0.02,
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
                let response = Response::measure(&legs, STEP_RAD, 0.0).unwrap();
                assert!(response.overshoot <= MOST_OVERSHOOT, "{response:?}");
                assert!(response.settling_s.is_some(), "{response:?}");
            }
        }
    }

    /// A noisier gyro gets less feedback of the rate.
    #[test]
    fn prop_noise_of_the_yaw_rate_takes_feedback_away() {
        let quiet = evidence(2.0, 0.05);
        let noisy = Evidence {
            rate_noise_rad_s: 0.05,
            ..quiet
        };
        let gain = |evidence: &Evidence| propose(evidence, &found()).unwrap().rate_gain_s;
        assert!(gain(&noisy) < 0.8 * gain(&quiet));
    }

    #[test]
    fn exact_what_cannot_be_steered_is_refused() {
        let good = evidence(1.0, 0.1);
        let with = |theta| Evidence {
            model: YawModel::from_theta(theta),
            ..good
        };
        let refused = |evidence: Evidence| propose(&evidence, &found()).unwrap_err();
        assert_eq!(refused(with([-0.05, 0.8, 0.0])), NoProposal::CourseUnstable);
        assert_eq!(
            refused(with([-1.0, -0.8, 0.0])),
            NoProposal::NoAuthority(-0.8)
        );
        assert!(matches!(
            refused(with([-1.0, 0.8, 0.5])),
            NoProposal::OffCentre(_)
        ));
    }
}

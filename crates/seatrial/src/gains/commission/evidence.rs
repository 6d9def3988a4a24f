//! What is known of a boat, and which boats that allows.

use seatrial_core::YawModel;

use super::boat::{Boat, StepTest};

/// The step that gains are designed for: 30 degrees, rad.
pub(super) const STEP_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// A boat is stepped through in this share of its time constant, and in no longer steps, s.
const DENSITY: f64 = 0.02;
const SLOWEST_LOOP_S: f64 = 0.1;
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
    /// Deviation of what the sea turns it with, rad/s^2.
    pub disturbance_rad_s2: f64,
    /// Between two loops of the autopilot, s.
    pub loop_interval_s: f64,
    /// The share of full steering that is not left where thrusters drive and steer at once.
    pub steering_taken: f64,
}

/// Why no gains are proposed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    /// Gains that do would shake the steering with the noise of the yaw rate, degrees/s.
    #[error(
        "gains that step well would shake the steering: the yaw rate has {0:.2} degrees/s of noise; lower INS_GYRO_FILTER, or find what shakes the autopilot"
    )]
    TooNoisy(f64),
}

impl Evidence {
    /// The boat that is most likely.
    pub fn boat(&self) -> Boat {
        Boat {
            model: self.model,
            lag_s: self.lag_s,
            delay_s: self.delay_s,
            steering_taken: self.steering_taken,
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
    pub(super) fn boats(&self) -> Vec<Boat> {
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
            boats.push(Boat { model, lag_s, ..late });
        }
        boats
    }

    /// Can such a boat be steered at all?
    ///
    /// ```
    /// use seatrial::gains::commission::{Evidence, NoProposal};
    /// use seatrial_core::YawModel;
    ///
    /// let evidence = |b2| Evidence {
    ///     model: YawModel::from_theta([-1.0, b2, 0.0]),
    ///     covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]],
    ///     lag_s: 0.1,
    ///     delay_s: 0.0,
    ///     rate_noise_rad_s: 0.002,
    ///     heading_noise_rad: 0.005,
    ///     disturbance_rad_s2: 0.0,
    ///     loop_interval_s: 0.02,
    ///     steering_taken: 0.0,
    /// };
    /// assert_eq!(evidence(1.0).check(), Ok(()));
    /// // Steering to starboard turns to port.
    /// assert!(matches!(evidence(-1.0).check(), Err(NoProposal::NoAuthority(_))));
    /// ```
    pub fn check(&self) -> Result<(), NoProposal> {
        let [of_a22, of_b] = self.deviations().map(|deviation| DEVIATIONS * deviation);
        let YawModel { a22_per_s, b2_per_s2, c0_rad_per_s2 } = self.model;
        if a22_per_s + of_a22 >= 0.0 || !a22_per_s.is_finite() {
            return Err(NoProposal::CourseUnstable);
        }
        if b2_per_s2 - of_b <= 0.0 || !b2_per_s2.is_finite() {
            return Err(NoProposal::NoAuthority(b2_per_s2));
        }
        let trim = (c0_rad_per_s2 / (b2_per_s2 * (1.0 - self.steering_taken))).abs();
        match trim < 0.5 {
            true => Ok(()),
            false => Err(NoProposal::OffCentre(100.0 * trim)),
        }
    }

    /// T, s.
    pub(super) fn lateness_s(&self, filter_hz: f64) -> f64 {
        self.lag_s + self.delay_s + self.loop_interval_s + filter_s(filter_hz)
    }

    /// A step that lets this candidate settle. A slow boat is stepped through in steps of its own time, which a faster loop
    /// could only do better.
    pub(super) fn test(&self, angle_gain_per_s: f64) -> StepTest {
        let alpha = -self.model.a22_per_s;
        let authority = self.model.b2_per_s2 * (1.0 - self.steering_taken);
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

/// The time constant of a filter, s.
pub(super) fn filter_s(frequency_hz: f64) -> f64 {
    match frequency_hz > 0.0 {
        true => 1.0 / (2.0 * std::f64::consts::PI * frequency_hz),
        false => 0.0,
    }
}

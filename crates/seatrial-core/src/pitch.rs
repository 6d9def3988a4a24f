//! Pitch under the elevator: the model.

use crate::{Real, YawModel};

/// Most that a step of the integration is of the fastest time constant.
const LARGEST_STEP: f64 = 0.1;
/// Most steps in an interval.
const MOST_STEPS: f64 = 1000.0;
/// Pitch with a restoring moment.
///
/// ```text
/// theta' = q
/// q'     = a q + m theta + b delta_e + c
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | theta, q | `pitch_rad`, `pitch_rate_rad_s` | rad, rad/s | bow up |
/// | delta_e | `elevator_rad` | rad | pitches the bow up where b is positive |
/// | a | `damping_per_s` | 1/s | negative for a damped vehicle |
/// | m | `restoring_per_s2` | 1/s^2 | negative where weight below buoyancy rights it |
/// | b | `authority_per_s2` | 1/s^2 | |
/// | c | `offset_rad_per_s2` | rad/s^2 | pitch acceleration level at neutral elevator |
///
/// Source: the yaw model (5)-(7) of the paper carried to the diving plane with the restoring moment
/// of Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, section 4.1. q is theta' at small
/// roll. Heave is to it what sway is to yaw: left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PitchModel<T> {
    /// a, 1/s.
    pub damping_per_s: T,
    /// m, 1/s^2.
    pub restoring_per_s2: T,
    /// b, 1/s^2.
    pub authority_per_s2: T,
    /// c, rad/s^2.
    pub offset_rad_per_s2: T,
}

/// Pitch and pitch rate at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PitchState<T> {
    /// Pitch, rad.
    pub pitch_rad: T,
    /// Pitch rate, rad/s.
    pub pitch_rate_rad_s: T,
}

impl<T: Real> PitchModel<T> {
    /// The model of a parameter vector [a, m, b, c].
    pub fn from_theta([a, m, b, c]: [T; 4]) -> Self {
        Self { damping_per_s: a, restoring_per_s2: m, authority_per_s2: b, offset_rad_per_s2: c }
    }

    /// The parameter vector [a, m, b, c].
    pub fn theta(&self) -> [T; 4] {
        [self.damping_per_s, self.restoring_per_s2, self.authority_per_s2, self.offset_rad_per_s2]
    }

    /// The model whose a, b and c are those of `model`, with the restoring moment m, 1/s^2.
    ///
    /// ```
    /// use seatrial_core::{PitchModel, YawModel};
    ///
    /// let model = PitchModel::righted(&YawModel::from_theta([-1.2, 0.8, 0.01]), -0.3);
    /// assert_eq!(model.theta(), [-1.2, -0.3, 0.8, 0.01]);
    /// assert_eq!(model.without_restoring().theta(), [-1.2, 0.8, 0.01]);
    /// ```
    pub fn righted(model: &YawModel<T>, restoring_per_s2: T) -> Self {
        let [a, b, c] = model.theta();
        Self::from_theta([a, restoring_per_s2, b, c])
    }

    /// a, b and c as a model without restoring moment.
    pub fn without_restoring(&self) -> YawModel<T> {
        let [a, _, b, c] = self.theta();
        YawModel::from_theta([a, b, c])
    }

    /// Damped and not overturned by the flow: a < 0 and m < 0.
    ///
    /// ```
    /// use seatrial_core::PitchModel;
    ///
    /// assert!(PitchModel::from_theta([-1.2, -0.3, 0.8, 0.0]).is_stable());
    /// // The flow overturns it.
    /// assert!(!PitchModel::from_theta([-1.2, 0.3, 0.8, 0.0]).is_stable());
    /// ```
    pub fn is_stable(&self) -> bool {
        self.damping_per_s < T::ZERO && self.restoring_per_s2 < T::ZERO
    }

    /// The state `interval_s` later with the elevator held, by the fourth-order Runge-Kutta method in steps of a tenth
    /// of the fastest time constant: 1e-7 of a step's change.
    ///
    /// ```
    /// use seatrial_core::{PitchModel, PitchState};
    ///
    /// let model = PitchModel::from_theta([-1.2, -0.4, 0.8, 0.0]);
    /// // A held elevator of 0.1 rad ends at a pitch, not at a pitch rate: -b delta/m.
    /// let state = model.advance(PitchState::default(), 0.1, 60.0);
    /// assert!((state.pitch_rad - 0.2_f64).abs() < 1e-6 && state.pitch_rate_rad_s.abs() < 1e-6);
    /// ```
    pub fn advance(&self, state: PitchState<T>, elevator_rad: T, interval_s: T) -> PitchState<T> {
        let fastest_per_s = self.damping_per_s.abs() + self.restoring_per_s2.abs().sqrt();
        let wanted = interval_s * fastest_per_s / T::of(LARGEST_STEP);
        let steps = (wanted + T::of(0.5)).round().max(T::ONE).min(T::of(MOST_STEPS));
        if !steps.is_finite() {
            return state;
        }
        let h = interval_s / steps;
        let input = self.authority_per_s2 * elevator_rad + self.offset_rad_per_s2;
        let rate = |s: PitchState<T>| PitchState {
            pitch_rad: s.pitch_rate_rad_s,
            pitch_rate_rad_s: self.damping_per_s * s.pitch_rate_rad_s
                + self.restoring_per_s2 * s.pitch_rad
                + input,
        };
        let plus = |s: PitchState<T>, k: PitchState<T>, h: T| PitchState {
            pitch_rad: s.pitch_rad + h * k.pitch_rad,
            pitch_rate_rad_s: s.pitch_rate_rad_s + h * k.pitch_rate_rad_s,
        };
        let (half, two, sixth) = (T::of(0.5) * h, T::of(2.0), h / T::of(6.0));
        let mut now = state;
        let mut left = steps;
        while left > T::of(0.5) {
            let k1 = rate(now);
            let k2 = rate(plus(now, k1, half));
            let k3 = rate(plus(now, k2, half));
            let k4 = rate(plus(now, k3, h));
            now = plus(plus(now, k1, sixth), k4, sixth);
            now = plus(plus(now, k2, two * sixth), k3, two * sixth);
            left -= T::ONE;
        }
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Estimator, EstimatorSettings, Intake};

    const MODEL: PitchModel<f64> = PitchModel {
        damping_per_s: -1.4,
        restoring_per_s2: -0.3,
        authority_per_s2: 1.1,
        offset_rad_per_s2: 0.01,
    };

    /// Time, pitch and elevator of a doublet from rest.
    fn record(amplitude_rad: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        let mut state = PitchState { pitch_rad: 0.01 / 0.3, pitch_rate_rad_s: 0.0 };
        (0..530).map(move |k| {
            let elevator_rad = match k {
                240..260 => amplitude_rad,
                260..280 => -amplitude_rad,
                _ => 0.0,
            };
            let sample = (f64::from(k) * 0.05, state.pitch_rad, elevator_rad);
            state = MODEL.advance(state, elevator_rad, 0.05);
            sample
        })
    }

    fn estimator() -> Estimator<f64> {
        let settings =
            EstimatorSettings { has_restoring_moment: true, ..EstimatorSettings::for_lambda(3.0) };
        Estimator::new(settings).unwrap()
    }

    fn estimated(samples: impl Iterator<Item = (f64, f64, f64)>) -> PitchModel<f64> {
        let mut estimator = estimator();
        for (k, (time_s, pitch_rad, elevator_rad)) in samples.enumerate() {
            if k < 200 {
                let _ = estimator.warm(time_s, pitch_rad, elevator_rad);
            } else {
                if k == 280 {
                    estimator.excitation_ended();
                }
                let _ = estimator.update(time_s, pitch_rad, elevator_rad);
            }
        }
        assert!(estimator.instrument().is_some());
        let restoring_per_s2 = estimator.restoring_per_s2().unwrap();
        PitchModel::righted(&estimator.model(), restoring_per_s2)
    }

    /// The closed form of the oscillation, here with m = -4: critically damped at a = -4.
    #[test]
    fn exact_advance_meets_the_closed_form() {
        let model = PitchModel::from_theta([-4.0, -4.0, 0.0, 0.0]);
        let start = PitchState { pitch_rad: 1.0, pitch_rate_rad_s: 0.0 };
        let after = model.advance(start, 0.0, 0.7);
        // (1 + 2t) e^-2t.
        let expected = 2.4 * (-1.4_f64).exp();
        assert!((after.pitch_rad - expected).abs() < 1e-6, "{after:?}");
    }

    #[test]
    fn exact_recovery_without_noise() {
        let found = estimated(record(0.1));
        for (found, truth) in found.theta().iter().zip(MODEL.theta()) {
            // Pitch is not straight between samples: (lambda h)^2/12 = 0.2 %.
            assert!((found - truth).abs() < 0.01 * truth.abs(), "{found} {truth}");
        }
    }

    /// A sample that is not finite, or of the time of the one before, is refused and changes nothing.
    #[test]
    fn prop_unsound_samples_are_ignored() {
        let (mut disturbed, mut reference) = (estimator(), estimator());
        for (time_s, pitch_rad, elevator_rad) in record(0.1) {
            let _ = reference.update(time_s, pitch_rad, elevator_rad);
            let _ = disturbed.update(time_s, pitch_rad, elevator_rad);
            for (time_s, pitch_rad) in [(time_s + 0.01, f64::NAN), (time_s, pitch_rad)] {
                let intake = disturbed.update(time_s, pitch_rad, elevator_rad);
                assert!(matches!(intake, Intake::Rejected(_)), "{intake:?}");
            }
        }
        assert_eq!(disturbed.model(), reference.model());
        assert_eq!(disturbed.restoring_per_s2(), reference.restoring_per_s2());
    }
}

//! A fin's actuator: limit, dead band, lag, rate limit and backlash.

use serde::{Deserialize, Serialize};

use crate::plant::Servo;

/// A servo and the play of its linkage.
///
/// The servo turns its horn towards the command, within the limit, once they differ by more than the dead
/// band, with a first-order lag and no faster than its rate; the fin follows the horn once the play is
/// taken up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Largest angle, rad.
    pub limit_rad: f64,
    /// Lag and rate limit.
    pub servo: Servo,
    /// Error that the servo does not act on, rad.
    pub dead_band_rad: f64,
    /// Play of the linkage from stop to stop, rad.
    pub backlash_rad: f64,
}

/// Where an actuator stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActuatorState {
    /// The servo's horn, rad.
    pub horn_rad: f64,
    /// The fin, rad.
    pub fin_rad: f64,
}

impl Actuator {
    /// The state `interval_s` later under a constant command.
    pub fn advance(
        &self,
        state: ActuatorState,
        command_rad: f64,
        interval_s: f64,
    ) -> ActuatorState {
        // Not `clamp`, which panics where a vehicle that fell apart in the waves has no number any more.
        let within = |value: f64, low: f64, high: f64| value.max(low).min(high);
        let error = within(command_rad, -self.limit_rad, self.limit_rad) - state.horn_rad;
        let acted_on = error - within(error, -self.dead_band_rad, self.dead_band_rad);
        let horn_rad = self.servo.advance(state.horn_rad, state.horn_rad + acted_on, interval_s);
        let play = 0.5 * self.backlash_rad;
        ActuatorState { horn_rad, fin_rad: within(state.fin_rad, horn_rad - play, horn_rad + play) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACTUATOR: Actuator = Actuator {
        limit_rad: 0.26,
        servo: Servo { time_constant_s: 0.1, rate_limit_rad_s: None },
        dead_band_rad: 0.0,
        backlash_rad: 0.0,
    };

    fn after(actuator: Actuator, command_rad: f64, seconds: f64) -> ActuatorState {
        (0..(seconds * 100.0) as u32)
            .fold(ActuatorState::default(), |state, _| actuator.advance(state, command_rad, 0.01))
    }

    #[test]
    fn exact_lag_limit_and_rate() {
        let lagged = after(ACTUATOR, 0.2, 0.1).fin_rad;
        assert!((lagged - 0.2 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
        assert!((after(ACTUATOR, 1.0, 5.0).fin_rad - 0.26).abs() < 1e-12);
        let mut slow = ACTUATOR;
        slow.servo.rate_limit_rad_s = Some(0.5);
        assert!((after(slow, 0.26, 0.1).fin_rad - 0.05).abs() < 1e-12);
    }

    #[test]
    fn exact_dead_band_and_backlash_are_hysteresis() {
        let sticky = Actuator { dead_band_rad: 0.01, backlash_rad: 0.02, ..ACTUATOR };
        assert_eq!(after(sticky, 0.009, 1.0), ActuatorState::default());
        let there = after(sticky, 0.2, 5.0);
        assert!((there.horn_rad - 0.19).abs() < 1e-9 && (there.fin_rad - 0.18).abs() < 1e-9);
        let back = (0..500).fold(there, |state, _| sticky.advance(state, 0.1, 0.01));
        assert!((back.horn_rad - 0.11).abs() < 1e-9 && (back.fin_rad - 0.12).abs() < 1e-9);
    }
}

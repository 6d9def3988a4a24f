//! The vehicle's own depth controller.

use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

/// Depth and pitch by the elevator.
///
/// ```text
/// theta_d = k_z (z - z_d) + k_i integral (z - z_d) dt,   |theta_d| <= theta_max
/// delta_e = k_theta (theta_d - theta)
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | z, z_d | measured depth, `depth_m` | m | down |
/// | theta | measured pitch | rad | bow up |
/// | delta_e | elevator | rad | pitches the bow up |
/// | k_z, k_i | `pitch_per_depth_rad_m`, `pitch_per_integral_rad_m_s` | rad/m, rad/(m s) | |
/// | k_theta | `elevator_per_pitch` | 1 | |
/// | theta_max | `pitch_limit_rad` | rad | |
///
/// The integral takes up the buoyancy; it waits while theta_d is at its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthHold {
    /// Depth to hold, m.
    pub depth_m: f64,
    /// k_z.
    pub pitch_per_depth_rad_m: f64,
    /// k_i.
    pub pitch_per_integral_rad_m_s: f64,
    /// theta_max.
    pub pitch_limit_rad: f64,
    /// k_theta.
    pub elevator_per_pitch: f64,
}

/// A depth controller at work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthHoldState {
    integral_rad: f64,
    last_s: Option<f64>,
}

impl DepthHoldState {
    /// The next sample may have any time.
    pub fn restart_clock(&mut self) {
        self.last_s = None;
    }
}

impl DepthHold {
    /// The elevator for a sample, rad. `None` where depth or pitch is not measured.
    pub fn elevator_rad(&self, state: &mut DepthHoldState, sample: &Sample<f64>) -> Option<f64> {
        let error_m = sample.depth_m? - self.depth_m;
        let pitch_rad = sample.pitch_rad?;
        let interval_s = state.last_s.map_or(0.0, |last_s| sample.time_s - last_s);
        state.last_s = Some(sample.time_s);
        let step_rad = self.pitch_per_integral_rad_m_s * error_m * interval_s;
        let wanted_rad = self.pitch_per_depth_rad_m * error_m + state.integral_rad + step_rad;
        let limited_rad = wanted_rad.max(-self.pitch_limit_rad).min(self.pitch_limit_rad);
        if wanted_rad == limited_rad {
            state.integral_rad += step_rad;
        }
        Some(self.elevator_per_pitch * (limited_rad - pitch_rad))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOLD: DepthHold = DepthHold {
        depth_m: 2.0,
        pitch_per_depth_rad_m: 0.1,
        pitch_per_integral_rad_m_s: 0.01,
        pitch_limit_rad: 0.3,
        elevator_per_pitch: 2.0,
    };

    fn sample(time_s: f64, depth_m: f64) -> Sample<f64> {
        Sample { time_s, depth_m: Some(depth_m), pitch_rad: Some(0.02), ..Sample::default() }
    }

    #[test]
    fn exact_too_deep_lifts_the_bow_more_with_time() {
        let mut state = DepthHoldState::default();
        let mut elevator = |time_s| HOLD.elevator_rad(&mut state, &sample(time_s, 3.0)).unwrap();
        assert!((elevator(0.0) - 2.0 * (0.1 - 0.02)).abs() < 1e-15);
        assert!((elevator(5.0) - 2.0 * (0.1 + 0.05 - 0.02)).abs() < 1e-15);
    }

    #[test]
    fn exact_the_integral_waits_at_the_limit() {
        let mut state = DepthHoldState::default();
        for k in 0..100 {
            let held = HOLD.elevator_rad(&mut state, &sample(f64::from(k), 12.0));
            assert_eq!(held, Some(2.0 * (0.3 - 0.02)));
        }
        let there = HOLD.elevator_rad(&mut state, &sample(100.0, 2.0)).unwrap();
        assert!((there + 2.0 * 0.02).abs() < 1e-15, "{there}");
        let blind = Sample { depth_m: None, ..sample(101.0, 2.0) };
        assert_eq!(HOLD.elevator_rad(&mut state, &blind), None);
    }
}

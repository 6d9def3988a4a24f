//! What a simulated vehicle measures, and when.

use std::f64::consts::PI;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;
use seatrial_core::Real;
use serde::{Deserialize, Serialize};

/// Standard deviations of white noise; 0 is exact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// Compass, rad.
    pub compass_noise_rad: f64,
    /// Smallest step of the compass, rad; 0 is continuous.
    pub compass_resolution_rad: f64,
    /// Yaw rate gyro, rad/s; absent: none is carried.
    pub yaw_rate_noise_rad_s: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_noise_m_s: f64,
    /// Depth, m.
    pub depth_noise_m: f64,
    /// Roll and pitch, rad.
    pub attitude_noise_rad: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Self {
            compass_noise_rad: PI / 360.0,
            compass_resolution_rad: PI / 1800.0,
            yaw_rate_noise_rad_s: Some(0.005),
            surge_speed_noise_m_s: 0.01,
            depth_noise_m: 0.02,
            attitude_noise_rad: 0.005,
        }
    }
}

impl Sensors {
    /// No noise and no steps.
    pub const EXACT: Self = Self {
        compass_noise_rad: 0.0,
        compass_resolution_rad: 0.0,
        yaw_rate_noise_rad_s: Some(0.0),
        surge_speed_noise_m_s: 0.0,
        depth_noise_m: 0.0,
        attitude_noise_rad: 0.0,
    };

    /// Every number by its field.
    pub(crate) fn noises(&self) -> [(&'static str, f64); 6] {
        [
            ("sensors.compass_noise_rad", self.compass_noise_rad),
            (
                "sensors.compass_resolution_rad",
                self.compass_resolution_rad,
            ),
            (
                "sensors.yaw_rate_noise_rad_s",
                self.yaw_rate_noise_rad_s.unwrap_or(0.0),
            ),
            ("sensors.surge_speed_noise_m_s", self.surge_speed_noise_m_s),
            ("sensors.depth_noise_m", self.depth_noise_m),
            ("sensors.attitude_noise_rad", self.attitude_noise_rad),
        ]
    }

    /// The compass reading of a noisy heading, in (-pi, pi].
    pub(crate) fn compass(&self, heading_rad: f64) -> f64 {
        let step = self.compass_resolution_rad;
        let read = if step > 0.0 {
            (heading_rad / step).round() * step
        } else {
            heading_rad
        };
        Real::wrapped(read)
    }
}

/// When samples are taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Timing {
    /// Time between samples, s.
    pub sample_interval_s: f64,
    /// Each sample is taken up to this late, s.
    pub jitter_s: f64,
    /// Part of the instants at which nothing is measured: there the rudder stays as it is.
    pub missing_fraction: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            sample_interval_s: 0.05,
            jitter_s: 0.0,
            missing_fraction: 0.0,
        }
    }
}

/// A source of chance of its own: drawing from one does not move another.
#[derive(Clone, Debug)]
pub struct Chance(Pcg64);

impl Chance {
    /// Independent sources from one seed.
    pub fn sources<const N: usize>(seed: u64) -> [Self; N] {
        let mut root = Pcg64::seed_from_u64(seed);
        std::array::from_fn(|_| Self(Pcg64::from_rng(&mut root)))
    }

    /// A normal deviate with mean 0 and deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }
}

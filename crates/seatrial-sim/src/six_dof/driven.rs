//! A vehicle whose fins and propeller somebody else commands, step by step.

use super::commands::Commands;
use super::config::SixDofConfig;
use super::vehicle::SixDofBody;
use crate::config_error::ConfigError;
use crate::sensors::Chance;

/// True motion in the axes of inertial sensors and maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// Since the start, s.
    pub time_s: f64,
    /// Angular velocity forward, starboard and down, rad/s.
    pub angular_velocity_rad_s: [f64; 3],
    /// Acceleration less gravity forward, starboard and down, m/s^2.
    pub specific_force_m_s2: [f64; 3],
    /// North, east and down, m.
    pub position_m: [f64; 3],
    /// Roll, pitch and heading, rad.
    pub attitude_rad: [f64; 3],
    /// Towards north, east and down, m/s.
    pub velocity_m_s: [f64; 3],
}

/// A vehicle that starts at rest at its depth and heading and goes where it is steered.
///
/// A seed and commands give equal motion, bit for bit, on every platform.
#[derive(Clone, Debug)]
pub struct DrivenVehicle {
    config: SixDofConfig,
    body: SixDofBody,
    disturbance: Chance,
    disturbance_rad_s2: f64,
}

impl DrivenVehicle {
    /// A vehicle in the disturbance and the waves of a seed.
    pub fn new(mut config: SixDofConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        if let Some(waves) = &mut config.sea.waves {
            waves.seed = waves.seed.wrapping_add(seed);
        }
        let [mut disturbance] = Chance::sources(seed);
        Ok(Self {
            disturbance_rad_s2: config.helm.disturbance.standard_deviation_rad_s2
                * disturbance.normal(),
            body: SixDofBody::at_rest(config.clone())?,
            config,
            disturbance,
        })
    }

    /// Goes on.
    pub fn advance(&mut self, commands: &Commands, interval_s: f64) {
        self.body
            .drive(commands, self.disturbance_rad_s2, interval_s);
        self.disturbance_rad_s2 = self.config.helm.disturbance.after(
            self.disturbance_rad_s2,
            interval_s,
            self.disturbance.normal(),
        );
    }

    /// The true state.
    pub fn body(&self) -> &SixDofBody {
        &self.body
    }

    /// What inertial sensors and a map would say.
    pub fn kinematics(&self) -> Kinematics {
        let state = &self.body.state;
        let [_, _, _, roll_rate, pitch_rate, yaw_rate] = state.velocity.into();
        Kinematics {
            time_s: self.body.time_s,
            angular_velocity_rad_s: [roll_rate, pitch_rate, yaw_rate],
            specific_force_m_s2: self
                .body
                .specific_force_m_s2(self.disturbance_rad_s2)
                .into(),
            position_m: state.position_m.into(),
            attitude_rad: state.euler_rad(),
            velocity_m_s: state.drift_m_s().into(),
        }
    }
}

//! The vehicle file: a vehicle as a trial identified it, for simulators, planners and controllers.

mod check;
mod draw;

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;

use seatrial_core::{HeadingGain, YawModel};
use serde::{Deserialize, Serialize};

use crate::config::{HeadingHold, VehicleConfig};
use crate::config_error::ConfigError;
use crate::plant::{Disturbance, Plant, Servo, SpeedPoint, SurgeDrag};
use crate::sensors::{Sensors, Timing};
use crate::vehicle_text::{in_file, is_json};

/// The version of the format that this one reads and writes.
pub const SCHEMA: &str = "seatrial.vehicle.v1";

/// Rudder per heading error of the twin's own heading controller where its model has no gain.
const GAIN_WITHOUT_DESIGN: f64 = 0.3;
/// Correlation time of the disturbance where the file does not say it, in time constants of the yaw.
const DISTURBANCE_TIME: f64 = 2.0;

/// A vehicle as it was identified, with what is not known of it. The page `docs/vehicle-file.md` explains every field.
///
/// ```text
/// psi' = r                                          heading, clockwise positive
/// r'   = a22(u) r + b2(u) d + C0(u)                 yaw rate
/// d'   = (delta(t - delay) - d)/lag                 rudder, |d'| <= rate limit
/// u'   = (u_s(p) - u)/T                             forward speed at thrust p; or
/// u'   = (u_s(p)^2 - u^2)/l - d_r r^2               where the drag length l is known
/// x'   = u cos psi,  y' = u sin psi                 north, east
/// ```
///
/// Between two speeds a22 and C0 are linear in u, b2 in its square, as in a schedule of gains, and u_s is linear in p. Beyond the slowest and the fastest they are the
/// nearest one's, a22 times the ratio of the speeds, b2 and C0 times its square, u_s times the ratio of the thrusts.
///
/// ```
/// let text = r#"
/// schema = "seatrial.vehicle.v1"
/// name = "my boat"
///
/// [rudder]
/// limit_rad = 0.26
/// lag_s = 0.1
///
/// [surge]
/// time_constant_s = 2.5
///
/// [[speed]]
/// thrust = 0.6
/// surge_speed_m_s = 1.07
/// a22_per_s = -0.95
/// b2_per_s2 = 0.60
/// c0_rad_per_s2 = 0.0072
/// "#;
/// let vehicle = seatrial_sim::IdentifiedVehicle::from_toml(text)?;
/// assert_eq!(vehicle.twin().servo.time_constant_s, 0.1);
/// # Ok::<(), seatrial_sim::ConfigError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedVehicle {
    /// [`SCHEMA`].
    pub schema: String,
    /// Name of the vehicle.
    pub name: String,
    /// Interval of the samples that it was identified from, s; the twin measures as often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_interval_s: Option<f64>,
    /// The rudder.
    pub rudder: Rudder,
    /// How the speed follows the thrust.
    pub surge: SurgeLaw,
    /// What the compass and the sea added to the records; absent is that of the simulator `starfish`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseEstimate>,
    /// The yaw model of each speed, slowest first.
    #[serde(rename = "speed")]
    pub speeds: Vec<IdentifiedSpeed>,
    /// Where the numbers come from.
    #[serde(default)]
    pub provenance: Provenance,
}

/// The rudder of an [`IdentifiedVehicle`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rudder {
    /// Largest angle that is commanded, rad.
    pub limit_rad: f64,
    /// Time constant of the lag behind the command, s.
    #[serde(default)]
    pub lag_s: f64,
    /// Dead time before the lag, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Fastest motion, rad/s; absent is unlimited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_limit_rad_s: Option<f64>,
}

/// How the forward speed follows the thrust.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurgeLaw {
    /// T, of small changes about the middle of the speeds, s.
    pub time_constant_s: f64,
    /// l, mass over drag per speed squared, m. With it the drag grows with the square of the speed, and T is not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drag_length_m: Option<f64>,
    /// d_r, speed that a turn costs, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turning_drag_m: Option<f64>,
}

/// What the compass and the sea added to the records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseEstimate {
    /// Standard deviation of the heading, rad.
    pub heading_rad: f64,
    /// Standard deviation of the yaw acceleration that is not the rudder's, rad/s^2.
    pub disturbance_rad_s2: f64,
    /// Its correlation time, s; absent: two time constants of the yaw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disturbance_time_s: Option<f64>,
}

/// The yaw model of a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedSpeed {
    /// Thrust as a fraction of full.
    pub thrust: f64,
    /// Steady forward speed, m/s.
    pub surge_speed_m_s: f64,
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// b2, 1/s^2 per rad of rudder.
    pub b2_per_s2: f64,
    /// C0, rad/s^2.
    #[serde(default)]
    pub c0_rad_per_s2: f64,
    /// Covariance of `[a22, b2, C0]`; absent where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f64; 3]; 3]>,
    /// Largest rudder of the record that the model is of, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seen_rudder_rad: Option<f64>,
}

/// Where the numbers come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Provenance {
    /// The file or logbook, and in it the campaign.
    pub source: String,
    /// The vehicle of the trial, as it was named there.
    pub vehicle: String,
    /// The configuration (payload) of the trial.
    pub configuration: String,
    /// When the trial began, UTC, ISO 8601.
    pub trial_started: String,
    /// The version of seatrial that wrote the file.
    pub software_version: String,
    /// Was the trial run on a simulator?
    pub is_rehearsal: bool,
    /// Numbers that no record determined, each with what was taken.
    pub assumptions: Vec<String>,
    /// What has to be known before the numbers are used.
    pub cautions: Vec<String>,
}

impl IdentifiedSpeed {
    /// The model alone.
    pub fn model(&self) -> YawModel<f64> {
        YawModel::from_theta([self.a22_per_s, self.b2_per_s2, self.c0_rad_per_s2])
    }

    /// With another model.
    pub fn with_model(self, model: &YawModel<f64>) -> Self {
        Self {
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
            ..self
        }
    }

    fn point(&self) -> SpeedPoint {
        SpeedPoint {
            thrust: self.thrust,
            surge_speed_m_s: self.surge_speed_m_s,
            a22_per_s: self.a22_per_s,
            b2_per_s2: self.b2_per_s2,
            c0_rad_per_s2: self.c0_rad_per_s2,
        }
    }
}

impl IdentifiedVehicle {
    /// The largest thrust with a model, as a fraction of full; full without any.
    pub fn fastest_thrust(&self) -> f64 {
        self.speeds.last().map_or(1.0, |speed| speed.thrust)
    }

    /// The vehicle of a TOML text.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let vehicle: Self = toml::from_str(text)?;
        vehicle.check()?;
        Ok(vehicle)
    }

    /// The vehicle of a JSON text, with the names of the TOML file.
    pub fn from_json(text: &str) -> Result<Self, ConfigError> {
        let vehicle: Self = serde_json::from_str(text)?;
        vehicle.check()?;
        Ok(vehicle)
    }

    /// The vehicle of a TOML or JSON file.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        in_file(path, |text| match is_json(text) {
            true => Self::from_json(text),
            false => Self::from_toml(text),
        })
    }

    /// Its file.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Its file as JSON.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The vehicle that the numbers describe, as a simulator plays it: its speeds, rudder and surge, the noise of its records, and
    /// a heading controller designed for its slowest speed.
    pub fn twin(&self) -> VehicleConfig {
        let base = VehicleConfig::starfish();
        let yaw_time_s = self.speeds.first().map_or(1.0, |p| 1.0 / p.a22_per_s.abs());
        let mut sensors = Sensors::default();
        let mut disturbance = base.disturbance;
        if let Some(noise) = &self.noise {
            sensors.compass.noise_rad = noise.heading_rad;
            disturbance = Disturbance {
                standard_deviation_rad_s2: noise.disturbance_rad_s2,
                correlation_time_s: noise
                    .disturbance_time_s
                    .unwrap_or((DISTURBANCE_TIME * yaw_time_s).clamp(1e-3, 1e5)),
            };
        }
        VehicleConfig {
            name: self.name.clone(),
            rudder_limit_rad: self.rudder.limit_rad,
            depth_m: 0.0,
            surge_time_constant_s: self.surge.time_constant_s,
            surge_drag: self.surge.drag_length_m.map(|drag_length_m| SurgeDrag {
                drag_length_m,
                turning_drag_m: self.surge.turning_drag_m.unwrap_or(0.0),
            }),
            initial_thrust: self.speeds.first().map_or(base.initial_thrust, |p| p.thrust),
            heading_hold: self.heading_hold(),
            rudder_delay_s: self.rudder.delay_s,
            servo: Servo {
                time_constant_s: self.rudder.lag_s,
                rate_limit_rad_s: self.rudder.rate_limit_rad_s,
            },
            disturbance,
            sensors,
            timing: Timing {
                sample_interval_s: self.sample_interval_s.unwrap_or(base.timing.sample_interval_s),
                ..base.timing
            },
            has_fins: true,
            speeds: self.speeds.iter().map(IdentifiedSpeed::point).collect(),
            ..base
        }
    }

    /// The moving vehicle, straight ahead at a thrust, without noise or disturbance.
    pub fn plant(&self, thrust: f64) -> Plant {
        self.twin().plant(thrust).in_its_own_steps()
    }

    /// A gain for the lag and dead time of the rudder; one without a design has the sign of b2.
    fn heading_hold(&self) -> HeadingHold {
        let timing = seatrial_core::heading_loop::LoopTiming {
            delay_s: self.rudder.lag_s
                + self.rudder.delay_s
                + self.sample_interval_s.unwrap_or(0.0),
            sample_interval_s: self.sample_interval_s,
        };
        let slowest = self.speeds.first().map(IdentifiedSpeed::model);
        let designed = slowest
            .and_then(|model| HeadingGain::design_delayed(&model, FRAC_1_SQRT_2, timing).ok());
        let side = slowest.map_or(1.0, |model| model.b2_per_s2.signum());
        HeadingHold {
            gain: designed.map_or(side * GAIN_WITHOUT_DESIGN, |gain| gain.proportional_gain),
            rudder_limit_rad: self.rudder.limit_rad,
        }
    }
}

#[cfg(test)]
mod tests;

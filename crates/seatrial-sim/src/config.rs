//! A simulated vehicle as a file.

use serde::{Deserialize, Serialize};

use crate::config_error::{ConfigError, invalid};
use crate::plant::{Disturbance, Plant, Servo, SpeedPoint, Surge, SurgeDrag};
use crate::range::{
    a_number, check, check_not_negative, check_number, check_positive, positive, within,
};
use crate::sensors::{Sensors, Timing};

/// A first-order vehicle.
///
/// Fields that a file leaves out keep the values of [`VehicleConfig::starfish`], but `name` and `speeds`
/// must be there:
///
/// ```
/// let text = r#"
/// name = "small boat"
/// rudder_limit_rad = 0.5
/// depth_m = 0.0
/// surge_time_constant_s = 3.0      # speed after a change of thrust
/// rudder_delay_s = 0.05            # dead time before the servo
/// initial_thrust = 0.5             # its own setting before and after a trial
/// initial_heading_rad = 1.2
///
/// [heading_hold]                   # the vehicle's own: rudder = -gain (heading - wanted heading)
/// gain = 0.4
/// rudder_limit_rad = 0.3
///
/// [servo]
/// time_constant_s = 0.1
/// rate_limit_rad_s = 1.0
///
/// [disturbance]                    # of the yaw acceleration, first-order Gauss-Markov
/// standard_deviation_rad_s2 = 0.005
/// correlation_time_s = 2.0
///
/// [sensors.compass]                # every sensor and its numbers: seatrial_sim::sensors::Sensors
/// noise_rad = 0.01
/// resolution_rad = 0.0017
/// deviation_rad = [0.0, 0.05, 0.0, 0.02, 0.0]   # A to E of the deviation curve
/// latency_s = 0.1
///
/// [sensors.dvl]
/// interval_s = 0.2                 # readings stand until the next
/// dropout_fraction = 0.05
///
/// [timing]
/// sample_interval_s = 0.1
/// jitter_s = 0.02
/// missing_fraction = 0.05
///
/// [[speeds]]                       # the truth, in order of thrust; linear in speed between
/// thrust = 0.5
/// surge_speed_m_s = 1.0
/// a22_per_s = -2.0
/// b2_per_s2 = 1.5
/// c0_rad_per_s2 = 0.01
///
/// [[speeds]]
/// thrust = 1.0
/// surge_speed_m_s = 2.0
/// a22_per_s = -4.0
/// b2_per_s2 = 6.0
/// c0_rad_per_s2 = 0.04
/// "#;
/// let config = seatrial_sim::VehicleConfig::from_toml(text)?;
/// assert_eq!(config.speeds.len(), 2);
/// # Ok::<(), seatrial_sim::ConfigError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleConfig {
    /// Name of the vehicle.
    pub name: String,
    /// Largest rudder angle, rad.
    #[serde(default = "starfish::rudder_limit_rad")]
    pub rudder_limit_rad: f64,
    /// Constant depth, m.
    #[serde(default = "starfish::depth_m")]
    pub depth_m: f64,
    /// Time constant of the speed after a change of thrust, s.
    #[serde(default = "starfish::surge_time_constant_s")]
    pub surge_time_constant_s: f64,
    /// Drag that grows with the square of the speed, in the place of that time constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surge_drag: Option<SurgeDrag>,
    /// Thrust before and after a trial, as a fraction of full.
    #[serde(default = "starfish::initial_thrust")]
    pub initial_thrust: f64,
    /// Heading at the start, rad.
    #[serde(default)]
    pub initial_heading_rad: f64,
    /// The vehicle's own heading controller.
    #[serde(default)]
    pub heading_hold: HeadingHold,
    /// Dead time until a command reaches the servo, s.
    #[serde(default)]
    pub rudder_delay_s: f64,
    /// The rudder servo.
    #[serde(default)]
    pub servo: Servo,
    /// What waves and currents do.
    #[serde(default)]
    pub disturbance: Disturbance,
    /// What the vehicle measures.
    #[serde(default)]
    pub sensors: Sensors,
    /// When it measures.
    #[serde(default)]
    pub timing: Timing,
    /// Is b2 linear in the square of the speed between two points, as that of an identified vehicle? Else it is linear in the speed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub has_fins: bool,
    /// The truth, in order of thrust and speed.
    pub speeds: Vec<SpeedPoint>,
}

/// A proportional heading controller: rudder = -gain (measured heading - wanted heading).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeadingHold {
    /// Rudder per heading error; negative for a vehicle with negative b2.
    pub gain: f64,
    /// Largest rudder it uses, rad.
    pub rudder_limit_rad: f64,
}

impl Default for HeadingHold {
    fn default() -> Self {
        Self { gain: 0.3, rudder_limit_rad: 0.2 }
    }
}

impl HeadingHold {
    fn check(&self) -> Result<(), ConfigError> {
        check_number("heading_hold.gain", self.gain)?;
        check_positive("heading_hold.rudder_limit_rad", self.rudder_limit_rad)
    }
}

/// Steering, instruments and start of any simulated vehicle; a file of a [`VehicleConfig`] has the same fields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HelmConfig {
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// Thrust before and after a trial, as a fraction of full.
    pub initial_thrust: f64,
    /// Heading at the start, rad.
    pub initial_heading_rad: f64,
    /// The vehicle's own heading controller.
    pub heading_hold: HeadingHold,
    /// What nothing else explains.
    pub disturbance: Disturbance,
    /// What the vehicle measures.
    pub sensors: Sensors,
    /// When it measures.
    pub timing: Timing,
}

mod starfish {
    pub fn rudder_limit_rad() -> f64 {
        0.26
    }
    pub fn depth_m() -> f64 {
        2.0
    }
    pub fn surge_time_constant_s() -> f64 {
        2.0
    }
    pub fn initial_thrust() -> f64 {
        0.6
    }
}

impl VehicleConfig {
    /// The STARFISH AUV: the schedule of Table II.
    pub fn starfish() -> Self {
        let point = |[thrust, surge_speed_m_s, a22_per_s, b2_per_s2, c0_rad_per_s2]: [f64; 5]| {
            SpeedPoint { thrust, surge_speed_m_s, a22_per_s, b2_per_s2, c0_rad_per_s2 }
        };
        Self {
            name: "starfish".to_owned(),
            rudder_limit_rad: starfish::rudder_limit_rad(),
            depth_m: starfish::depth_m(),
            surge_time_constant_s: starfish::surge_time_constant_s(),
            surge_drag: None,
            initial_thrust: starfish::initial_thrust(),
            initial_heading_rad: 0.0,
            heading_hold: HeadingHold::default(),
            rudder_delay_s: 0.0,
            servo: Servo::default(),
            disturbance: Disturbance::default(),
            sensors: Sensors::default(),
            timing: Timing::default(),
            has_fins: false,
            speeds: [
                [0.6, 1.07, -0.95, 0.60, 0.0072],
                [0.7, 1.36, -1.12, 0.87, 0.0107],
                [0.8, 1.63, -1.07, 1.08, 0.0120],
                [0.9, 1.92, -1.14, 1.37, 0.0054],
                [1.0, 2.19, -1.21, 1.77, 0.0049],
            ]
            .map(point)
            .to_vec(),
        }
    }

    /// This vehicle in `times` the time: rates of turn and the gyro's noise are divided by `times`, accelerations by its square; angles,
    /// speeds and the other instruments stay. A gyro is chosen for the rates of its vehicle: that of the paper's, 0.3 deg/s, would hide the
    /// 0.2 deg/s of a vehicle of 30 s.
    pub fn slowed(mut self, times: f64) -> Self {
        self.surge_time_constant_s *= times;
        self.disturbance.standard_deviation_rad_s2 /= times * times;
        self.disturbance.correlation_time_s *= times;
        self.sensors.gyro.noise_rad_s /= times;
        for point in &mut self.speeds {
            point.a22_per_s /= times;
            point.b2_per_s2 /= times * times;
            point.c0_rad_per_s2 /= times * times;
        }
        self
    }

    /// The vehicle of a TOML text.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self = toml::from_str(text)?;
        config.check()?;
        Ok(config)
    }

    /// This vehicle in still water with exact sensors.
    pub fn noise_free(self) -> Self {
        Self {
            disturbance: Disturbance { standard_deviation_rad_s2: 0.0, ..self.disturbance },
            sensors: Sensors::EXACT,
            ..self
        }
    }

    /// How its speed follows its thrust.
    pub fn surge(&self) -> Surge {
        Surge { time_constant_s: self.surge_time_constant_s, drag: self.surge_drag }
    }

    /// The moving vehicle, straight ahead at the speed of a thrust.
    pub(crate) fn plant(&self, thrust: f64) -> Plant {
        let (speeds, heading_rad) = (self.speeds.clone(), self.initial_heading_rad);
        Plant::new(speeds, self.surge(), self.servo, thrust, heading_rad)
            .with_fins(self.has_fins)
            .with_rudder_delay(self.rudder_delay_s)
    }

    /// Its steering, instruments and start.
    pub fn helm(&self) -> HelmConfig {
        HelmConfig {
            rudder_limit_rad: self.rudder_limit_rad,
            initial_thrust: self.initial_thrust,
            initial_heading_rad: self.initial_heading_rad,
            heading_hold: self.heading_hold,
            disturbance: self.disturbance,
            sensors: self.sensors,
            timing: self.timing,
        }
    }

    /// Names the first field that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let (servo, rudder_delay_s) = (&self.servo, self.rudder_delay_s);
        check_number("depth_m", self.depth_m)?;
        check_positive("surge_time_constant_s", self.surge_time_constant_s)?;
        check_not_negative("servo.time_constant_s", servo.time_constant_s)?;
        within!(rudder_delay_s, 0.0, 60.0, "s")?;
        check(
            "servo.rate_limit_rad_s",
            servo.rate_limit_rad_s.unwrap_or(f64::INFINITY),
            servo.rate_limit_rad_s.is_none_or(positive),
            "a number from 1e-9 to 1e9 or absent",
        )?;
        self.surge_drag.as_ref().map_or(Ok(()), |drag| {
            let fastest_m_s = self.speeds.last().map_or(0.0, |p| p.surge_speed_m_s);
            drag.check(fastest_m_s)
        })?;
        self.helm().check()?;
        self.check_speeds()
    }

    fn check_speeds(&self) -> Result<(), ConfigError> {
        if self.speeds.is_empty() {
            return Err(invalid("speeds", "a list of at least one speed", "empty"));
        }
        for (k, point) in self.speeds.iter().enumerate() {
            let before = k.checked_sub(1).and_then(|k| self.speeds.get(k));
            let field = |name: &str| format!("speeds[{k}].{name}");
            let (thrust, speed) = (point.thrust, point.surge_speed_m_s);
            if !(thrust > before.map_or(0.0, |p| p.thrust) && thrust <= 1.0) {
                let requirement = "above 0 and the thrust before, and at most 1";
                return Err(invalid(field("thrust"), requirement, thrust));
            }
            if !(speed > before.map_or(0.0, |p| p.surge_speed_m_s) && a_number(speed)) {
                let requirement = "above 0 and the speed before";
                return Err(invalid(field("surge_speed_m_s"), requirement, speed));
            }
            for (name, value) in [
                ("a22_per_s", point.a22_per_s),
                ("b2_per_s2", point.b2_per_s2),
                ("c0_rad_per_s2", point.c0_rad_per_s2),
            ] {
                if !a_number(value) {
                    return Err(invalid(field(name), "a number", value));
                }
            }
        }
        Ok(())
    }
}

impl HelmConfig {
    /// This helm with exact sensors and no disturbance.
    pub fn noise_free(self) -> Self {
        Self {
            disturbance: Disturbance { standard_deviation_rad_s2: 0.0, ..self.disturbance },
            sensors: Sensors::EXACT,
            ..self
        }
    }

    /// Names the first field that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_positive("rudder_limit_rad", self.rudder_limit_rad)?;
        check(
            "initial_thrust",
            self.initial_thrust,
            (0.0..=1.0).contains(&self.initial_thrust),
            "a fraction of full thrust, 0 to 1",
        )?;
        check_number("initial_heading_rad", self.initial_heading_rad)?;
        self.heading_hold.check()?;
        self.disturbance.check()?;
        self.timing.check()?;
        self.sensors.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_starfish_survives_its_own_file() {
        let text = toml::to_string(&VehicleConfig::starfish()).unwrap();
        assert_eq!(VehicleConfig::from_toml(&text).unwrap(), VehicleConfig::starfish());
    }

    #[test]
    fn io_faults_name_the_field() {
        let starfish = VehicleConfig::starfish();
        let mut reversed = starfish.clone();
        reversed.speeds.reverse();
        let mut jumpy = starfish.clone();
        jumpy.timing.jitter_s = 0.05;
        let mut noisy = starfish.clone();
        noisy.sensors.pressure.noise_m = f64::NAN;
        let mut magnetic = starfish.clone();
        magnetic.sensors.compass.deviation_rad[3] = f64::NAN;
        let mut blind = starfish.clone();
        blind.sensors.dvl.range_m = Some([3.0, 1.0]);
        let mut late = starfish.clone();
        late.sensors.gyro.latency_s = 61.0;
        let mut still = starfish.clone();
        still.speeds.clear();
        for (config, field) in [
            (reversed, "speeds[1].thrust"),
            (jumpy, "timing.jitter_s"),
            (noisy, "sensors.pressure.noise_m"),
            (magnetic, "sensors.compass.deviation_rad"),
            (blind, "sensors.dvl.range_m"),
            (late, "sensors.gyro.latency_s"),
            (still, "speeds"),
        ] {
            let message = config.check().unwrap_err().to_string();
            assert!(message.starts_with(&format!("{field} must be")), "{message}");
        }
        let text = format!("rudder = 1\n{}", toml::to_string(&starfish).unwrap());
        let message = VehicleConfig::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains("unknown field `rudder`"), "{message}");
    }
}

//! What a simulated vehicle measures, and when.

use std::f64::consts::PI;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;
use seatrial_core::Real;
use serde::{Deserialize, Serialize};

use crate::config_error::ConfigError;
use crate::range::{a_number, check, check_not_negative, check_number, check_within, within};

/// What a vehicle measures itself with.
///
/// Every sensor has its own rate and latency. One with an `interval_s` measures at multiples of it and its reading stands
/// until the next; one without measures for every sample. A reading arrives `latency_s` after its instant. Noises
/// are standard deviations of white noise, one draw a reading; 0 is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// Heading.
    pub compass: Compass,
    /// Yaw rate.
    pub gyro: Gyro,
    /// Forward speed over ground and height above the bottom.
    pub dvl: Dvl,
    /// Depth.
    pub pressure: Pressure,
    /// Roll and pitch.
    pub attitude: Attitude,
}

/// A magnetic compass.
///
/// ```text
/// m = psi_l - declination,   tau psi_l' = psi - psi_l
/// reading = step round((m + A + B sin m + C cos m + D sin 2m + E cos 2m + noise)/step)
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | psi, m | true and magnetic heading | rad | clockwise |
/// | tau | `lag_s` | s | |
/// | declination | `declination_rad` | rad | magnetic north lies east |
/// | A to E | `deviation_rad` | rad | reads too much; A is the bias of the mounting |
/// | step | `resolution_rad` | rad | |
///
/// Source of the deviation curve: Archibald Smith's approximate coefficients, as in the Admiralty Manual for
/// Deviations of the Compass (1862). Valid while they are small against a radian.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Compass {
    /// Noise, rad.
    pub noise_rad: f64,
    /// Smallest step, rad; 0 is continuous.
    pub resolution_rad: f64,
    /// A, B, C, D and E, rad.
    pub deviation_rad: [f64; 5],
    /// Declination, rad.
    pub declination_rad: f64,
    /// Time constant of its damping, s.
    pub lag_s: f64,
    /// Time between readings, s.
    pub interval_s: f64,
    /// Age of a reading, s.
    pub latency_s: f64,
}

/// A yaw rate gyro.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gyro {
    /// Is one carried?
    pub carried: bool,
    /// Noise, rad/s.
    pub noise_rad_s: f64,
    /// Bias at the start, rad/s.
    pub bias_rad_s: f64,
    /// What its bias walks in a second, standard deviation, rad/s per square root of s.
    pub bias_walk_rad_s_sqrt_s: f64,
    /// Time between readings, s.
    pub interval_s: f64,
    /// Age of a reading, s.
    pub latency_s: f64,
}

/// A Doppler velocity log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dvl {
    /// Noise of the speed, m/s.
    pub noise_m_s: f64,
    /// Noise of the altitude, m.
    pub altitude_noise_m: f64,
    /// Part of the readings that are lost.
    pub dropout_fraction: f64,
    /// Least and greatest height above the bottom from which it sees it, m: elsewhere, and without a bottom, there is no
    /// reading. Absent: it always has the speed.
    pub range_m: Option<[f64; 2]>,
    /// Time between readings, s.
    pub interval_s: f64,
    /// Age of a reading, s.
    pub latency_s: f64,
}

/// A pressure sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pressure {
    /// Noise, m.
    pub noise_m: f64,
    /// Bias, m: reads too deep.
    pub bias_m: f64,
    /// Time between readings, s.
    pub interval_s: f64,
    /// Age of a reading, s.
    pub latency_s: f64,
}

/// Roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Attitude {
    /// Noise of both, rad.
    pub noise_rad: f64,
    /// Time between readings, s.
    pub interval_s: f64,
    /// Age of a reading, s.
    pub latency_s: f64,
}

impl Default for Compass {
    fn default() -> Self {
        Self { noise_rad: PI / 360.0, resolution_rad: PI / 1800.0, ..Sensors::EXACT.compass }
    }
}

impl Default for Gyro {
    fn default() -> Self {
        Self { noise_rad_s: 0.005, ..Sensors::EXACT.gyro }
    }
}

impl Default for Dvl {
    fn default() -> Self {
        Self { noise_m_s: 0.01, ..Sensors::EXACT.dvl }
    }
}

impl Default for Pressure {
    fn default() -> Self {
        Self { noise_m: 0.02, ..Sensors::EXACT.pressure }
    }
}

impl Default for Attitude {
    fn default() -> Self {
        Self { noise_rad: 0.005, ..Sensors::EXACT.attitude }
    }
}

impl Sensors {
    /// Every sensor reads the truth for every sample.
    pub const EXACT: Self = Self {
        compass: Compass {
            noise_rad: 0.0,
            resolution_rad: 0.0,
            deviation_rad: [0.0; 5],
            declination_rad: 0.0,
            lag_s: 0.0,
            interval_s: 0.0,
            latency_s: 0.0,
        },
        gyro: Gyro {
            carried: true,
            noise_rad_s: 0.0,
            bias_rad_s: 0.0,
            bias_walk_rad_s_sqrt_s: 0.0,
            interval_s: 0.0,
            latency_s: 0.0,
        },
        dvl: Dvl {
            noise_m_s: 0.0,
            altitude_noise_m: 0.0,
            dropout_fraction: 0.0,
            range_m: None,
            interval_s: 0.0,
            latency_s: 0.0,
        },
        pressure: Pressure { noise_m: 0.0, bias_m: 0.0, interval_s: 0.0, latency_s: 0.0 },
        attitude: Attitude { noise_rad: 0.0, interval_s: 0.0, latency_s: 0.0 },
    };

    /// Names the first field that is out of range.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        self.compass.check()?;
        self.gyro.check()?;
        self.dvl.check()?;
        self.pressure.check()?;
        self.attitude.check()
    }
}

impl Compass {
    fn check(&self) -> Result<(), ConfigError> {
        let mut deviations = self.deviation_rad.into_iter();
        let too_great = deviations.find(|x| x.is_nan() || x.abs() >= 1.0);
        check_not_negative("sensors.compass.noise_rad", self.noise_rad)?;
        check_not_negative("sensors.compass.resolution_rad", self.resolution_rad)?;
        check_not_negative("sensors.compass.lag_s", self.lag_s)?;
        check_not_negative("sensors.compass.interval_s", self.interval_s)?;
        latency("sensors.compass.latency_s", self.latency_s)?;
        check(
            "sensors.compass.deviation_rad",
            too_great.unwrap_or_default(),
            too_great.is_none(),
            "five angles below 1 rad",
        )?;
        check(
            "sensors.compass.declination_rad",
            self.declination_rad,
            self.declination_rad.abs() <= PI,
            "an angle from -pi to pi",
        )
    }
}

impl Gyro {
    fn check(&self) -> Result<(), ConfigError> {
        check_not_negative("sensors.gyro.noise_rad_s", self.noise_rad_s)?;
        check_not_negative("sensors.gyro.bias_walk_rad_s_sqrt_s", self.bias_walk_rad_s_sqrt_s)?;
        check_not_negative("sensors.gyro.interval_s", self.interval_s)?;
        latency("sensors.gyro.latency_s", self.latency_s)?;
        check_number("sensors.gyro.bias_rad_s", self.bias_rad_s)
    }
}

impl Dvl {
    fn check(&self) -> Result<(), ConfigError> {
        let [near_m, far_m] = self.range_m.unwrap_or([0.0, 1.0]);
        check_not_negative("sensors.dvl.noise_m_s", self.noise_m_s)?;
        check_not_negative("sensors.dvl.altitude_noise_m", self.altitude_noise_m)?;
        check_not_negative("sensors.dvl.range_m", near_m)?;
        check_not_negative("sensors.dvl.interval_s", self.interval_s)?;
        latency("sensors.dvl.latency_s", self.latency_s)?;
        check(
            "sensors.dvl.dropout_fraction",
            self.dropout_fraction,
            (0.0..=1.0).contains(&self.dropout_fraction),
            "a fraction, 0 to 1",
        )?;
        check(
            "sensors.dvl.range_m",
            far_m,
            far_m > near_m && a_number(far_m),
            "the least and then the greatest altitude",
        )
    }
}

impl Pressure {
    fn check(&self) -> Result<(), ConfigError> {
        check_not_negative("sensors.pressure.noise_m", self.noise_m)?;
        check_not_negative("sensors.pressure.interval_s", self.interval_s)?;
        latency("sensors.pressure.latency_s", self.latency_s)?;
        check_number("sensors.pressure.bias_m", self.bias_m)
    }
}

impl Attitude {
    fn check(&self) -> Result<(), ConfigError> {
        check_not_negative("sensors.attitude.noise_rad", self.noise_rad)?;
        check_not_negative("sensors.attitude.interval_s", self.interval_s)?;
        latency("sensors.attitude.latency_s", self.latency_s)
    }
}

fn latency(field: &str, value: f64) -> Result<(), ConfigError> {
    check_within(field, Some(value), [0.0, LONGEST_LATENCY_S], "s", "")
}

impl Compass {
    /// The reading at a heading that its damping lets through, in (-pi, pi].
    pub(crate) fn reading(&self, heading_rad: f64, noise_rad: f64) -> f64 {
        let magnetic_rad = heading_rad - self.declination_rad;
        let read_rad = magnetic_rad + self.deviation(magnetic_rad) + noise_rad;
        let step = self.resolution_rad;
        Real::wrapped(if step > 0.0 { (read_rad / step).round() * step } else { read_rad })
    }

    /// What it reads too much at a magnetic heading, rad.
    pub fn deviation(&self, magnetic_rad: f64) -> f64 {
        let [a, b, c, d, e] = self.deviation_rad;
        let (m, m2) = (magnetic_rad, 2.0 * magnetic_rad);
        a + b * libm::sin(m) + c * libm::cos(m) + d * libm::sin(m2) + e * libm::cos(m2)
    }
}

/// Longest latency, s.
const LONGEST_LATENCY_S: f64 = 60.0;

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

impl Timing {
    /// Names the first field that is out of range.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let timing = self;
        within!(timing.sample_interval_s, 1e-3, 100.0, "s")?;
        check(
            "timing.jitter_s",
            self.jitter_s,
            self.jitter_s >= 0.0 && self.jitter_s < self.sample_interval_s,
            "a number not below 0 and under timing.sample_interval_s",
        )?;
        check(
            "timing.missing_fraction",
            self.missing_fraction,
            (0.0..=0.9).contains(&self.missing_fraction),
            "a fraction, 0 to 0.9",
        )
    }
}

impl Default for Timing {
    fn default() -> Self {
        Self { sample_interval_s: 0.05, jitter_s: 0.0, missing_fraction: 0.0 }
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

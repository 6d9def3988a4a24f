//! Waves: a spectrum as a sum of components.

use core::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::rigid_body::GRAVITY_M_S2;
use crate::config_error::ConfigError;
use crate::range::{check_number, check_within};
use crate::sensors::Chance;

/// Frequencies from this to that multiple of the peak's carry 99.9 % of the energy that reaches a vehicle.
const BAND: [f64; 2] = [0.5, 4.0];
/// Widths of the peak of the JONSWAP spectrum below and above its frequency.
const PEAK_WIDTHS: [f64; 2] = [0.07, 0.09];

/// Long-crested waves in deep water.
///
/// ```text
/// S(w) ~ w^-5 exp(-5/4 (w_p/w)^4) gamma^r,   r = exp(-(w - w_p)^2/(2 s^2 w_p^2)),   integral S = H_s^2/16
/// a_i^2/2 = S(w_i) dw_i,   w_i^2 = g k_i
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | H_s | `significant_height_m` | m |
/// | w_p | 2 pi / `peak_period_s` | rad/s |
/// | gamma | `peak_enhancement` | 1 |
/// | s | 0.07 below w_p, 0.09 above | 1 |
/// | a_i, w_i, k_i | [`Component`] | m, rad/s, 1/m |
///
/// Source: Hasselmann et al. (1973), JONSWAP; with gamma = 1 it is Pierson and Moskowitz (1964). The band is
/// 0.5 to 4 w_p, in intervals of equal ratio with a frequency by chance in each, so that the sea does not repeat; the
/// energy outside is given to the components inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Waves {
    /// Mean height of the highest third, m.
    pub significant_height_m: f64,
    /// Period of the most energetic waves, s.
    pub peak_period_s: f64,
    /// How much the peak stands out: 1 is Pierson-Moskowitz, 3.3 the mean of JONSWAP.
    #[serde(default = "pierson_moskowitz")]
    pub peak_enhancement: f64,
    /// Heading towards which they run, rad.
    #[serde(default)]
    pub towards_rad: f64,
    /// How many components.
    #[serde(default = "components")]
    pub components: u32,
    /// Seed of frequencies and phases; the vehicle's own is added.
    #[serde(default)]
    pub seed: u64,
}

fn pierson_moskowitz() -> f64 {
    1.0
}

fn components() -> u32 {
    40
}

/// One regular wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Amplitude of the surface, m.
    pub amplitude_m: f64,
    /// Angular frequency, rad/s.
    pub frequency_rad_s: f64,
    /// Wave number, 1/m.
    pub wave_number_per_m: f64,
    /// Phase at the origin at time 0, rad.
    pub phase_rad: f64,
}

/// The waves of one seed.
///
/// ```text
/// zeta = a cos p,   p = k (n cos c + e sin c) - w t + phase
/// v = a w exp(-k z) (cos p cos c, cos p sin c, -sin p)
/// ```
///
/// n, e, z: north, east and depth; c: `towards_rad`. Linear theory: what is above the mean surface has the
/// velocity of it.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveField {
    components: Vec<Component>,
    towards: [f64; 2],
}

/// The water's motion in waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveMotion {
    /// North, east and down, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Its change with time at the place, m/s^2.
    pub acceleration_m_s2: Vector3<f64>,
    /// Its change with the place, 1/s: column j is the change towards north, east and down.
    pub gradient_per_s: Matrix3<f64>,
}

impl Waves {
    /// Names the first field that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        for (field, found, range, unit) in [
            ("significant_height_m", self.significant_height_m, [0.0, 30.0], "m"),
            ("peak_period_s", self.peak_period_s, [0.5, 60.0], "s"),
            ("peak_enhancement", self.peak_enhancement, [1.0, 20.0], ""),
            ("components", f64::from(self.components), [1.0, 1000.0], ""),
        ] {
            check_within(&format!("sea.waves.{field}"), Some(found), range, unit, "")?;
        }
        check_number("sea.waves.towards_rad", self.towards_rad)
    }

    /// The sea of its seed.
    pub fn field(&self) -> WaveField {
        let [mut chance] = Chance::sources(self.seed);
        let peak_rad_s = TAU / self.peak_period_s;
        let ratio = (BAND[1] / BAND[0]).powf(1.0 / f64::from(self.components));
        let mut components: Vec<Component> = (0..self.components)
            .map(|i| {
                let from_rad_s = peak_rad_s * BAND[0] * ratio.powi(i as i32);
                let width_rad_s = from_rad_s * (ratio - 1.0);
                let frequency_rad_s = from_rad_s + width_rad_s * chance.uniform();
                Component {
                    amplitude_m: (2.0 * self.shape(frequency_rad_s) * width_rad_s).sqrt(),
                    frequency_rad_s,
                    wave_number_per_m: frequency_rad_s * frequency_rad_s / GRAVITY_M_S2,
                    phase_rad: TAU * chance.uniform(),
                }
            })
            .collect();
        let variance = |components: &[Component]| -> f64 {
            let squares = components.iter().map(|c| c.amplitude_m * c.amplitude_m);
            squares.sum::<f64>() / 2.0
        };
        let wanted = self.significant_height_m * self.significant_height_m / 16.0;
        let scale = (wanted / variance(&components)).sqrt();
        for component in &mut components {
            component.amplitude_m *= scale;
        }
        WaveField {
            components,
            towards: [libm::cos(self.towards_rad), libm::sin(self.towards_rad)],
        }
    }

    /// S but for a factor.
    fn shape(&self, frequency_rad_s: f64) -> f64 {
        let x = frequency_rad_s * self.peak_period_s / TAU;
        let [below, above] = PEAK_WIDTHS;
        let width = if x <= 1.0 { below } else { above };
        let r = libm::exp(-(x - 1.0) * (x - 1.0) / (2.0 * width * width));
        x.powi(-5) * libm::exp(-1.25 * x.powi(-4)) * libm::pow(self.peak_enhancement, r)
    }
}

impl WaveField {
    /// Its components.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The surface above its mean, m.
    pub fn elevation_m(&self, position_m: &Vector3<f64>, time_s: f64) -> f64 {
        let along_m = self.along_m(position_m);
        self.components.iter().map(|c| c.amplitude_m * libm::cos(c.at(along_m, time_s))).sum()
    }

    /// The water's motion at a place, z down from the mean surface.
    pub fn motion(&self, position_m: &Vector3<f64>, time_s: f64) -> WaveMotion {
        let along_m = self.along_m(position_m);
        let depth_m = position_m.z.max(0.0);
        // Velocity along the way of the waves and down, their rates, and their changes along and down.
        let [mut u, mut w, mut u_t, mut w_t, mut u_x, mut u_z] = [0.0; 6];
        for c in &self.components {
            let (sin, cos) = libm::sincos(c.at(along_m, time_s));
            let (omega, k) = (c.frequency_rad_s, c.wave_number_per_m);
            let speed = c.amplitude_m * omega * libm::exp(-k * depth_m);
            u += speed * cos;
            w -= speed * sin;
            u_t += speed * omega * sin;
            w_t += speed * omega * cos;
            u_x -= speed * k * sin;
            u_z -= speed * k * cos;
        }
        // Without sources and without rotation: dw/dz = -du/dx, dw/dx = du/dz.
        let [n, e] = self.towards;
        let vector = |along: f64, down: f64| Vector3::new(along * n, along * e, down);
        let (by_along, by_down) = (vector(u_x, u_z), vector(u_z, -u_x));
        WaveMotion {
            velocity_m_s: vector(u, w),
            acceleration_m_s2: vector(u_t, w_t),
            gradient_per_s: Matrix3::from_columns(&[by_along * n, by_along * e, by_down]),
        }
    }

    fn along_m(&self, position_m: &Vector3<f64>) -> f64 {
        position_m.x * self.towards[0] + position_m.y * self.towards[1]
    }
}

impl Component {
    fn at(&self, along_m: f64, time_s: f64) -> f64 {
        self.wave_number_per_m * along_m - self.frequency_rad_s * time_s + self.phase_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WAVES: Waves = Waves {
        significant_height_m: 0.8,
        peak_period_s: 5.0,
        peak_enhancement: 1.0,
        towards_rad: 0.7,
        components: 60,
        seed: 3,
    };

    #[test]
    fn exact_dispersion_in_deep_water() {
        for c in WAVES.field().components() {
            let k = c.frequency_rad_s * c.frequency_rad_s / GRAVITY_M_S2;
            assert_eq!(c.wave_number_per_m, k);
        }
        // A regular wave of 5 s is 39.0 m long: g T^2/(2 pi).
        let one = Waves { components: 1, ..WAVES }.field().components[0];
        let length_m = TAU / one.wave_number_per_m;
        let period_s = TAU / one.frequency_rad_s;
        assert!((length_m - GRAVITY_M_S2 * period_s * period_s / TAU).abs() < 1e-9);
    }

    /// The energy of the components is H_s^2/16, and the share up to a frequency that of Pierson and Moskowitz:
    /// exp(-5/4 (w_p/w)^4).
    #[test]
    fn exact_variance_of_the_spectrum() {
        for enhancement in [1.0, 3.3] {
            let field = Waves { peak_enhancement: enhancement, ..WAVES }.field();
            let energy = |c: &Component| c.amplitude_m * c.amplitude_m / 2.0;
            let variance: f64 = field.components().iter().map(energy).sum();
            assert!((variance / (0.8 * 0.8 / 16.0) - 1.0).abs() < 1e-12);
            let peak_rad_s = TAU / WAVES.peak_period_s;
            for x in [0.9, 1.2, 2.0] {
                let slow = field.components().iter().filter(|c| c.frequency_rad_s < x * peak_rad_s);
                let share = slow.map(energy).sum::<f64>() / variance;
                if enhancement == 1.0 {
                    let expected =
                        (-1.25 * f64::powi(x, -4)).exp() / (-1.25 * 4.0_f64.powi(-4)).exp();
                    // One component in an interval of 3.5 % holds up to 6 % of the energy.
                    assert!((share - expected).abs() < 0.06, "{x}: {share} {expected}");
                }
            }
        }
        // A record of the surface: 2000 s hold some 400 waves, their mean square known to about 10 %.
        let field = WAVES.field();
        let surface: Vec<f64> =
            (0..20_000).map(|k| field.elevation_m(&Vector3::zeros(), 0.1 * f64::from(k))).collect();
        let square = surface.iter().map(|z| z * z).sum::<f64>() / surface.len() as f64;
        assert!((square / 0.04 - 1.0).abs() < 0.3, "{square}");
    }

    #[test]
    fn exact_orbits_decay_with_depth() {
        let field = Waves { components: 1, ..WAVES }.field();
        let c = field.components[0];
        let speed = |z: f64| field.motion(&Vector3::new(4.0, -3.0, z), 2.0).velocity_m_s.norm();
        let amplitude = c.amplitude_m * c.frequency_rad_s;
        for z in [0.0, 1.0, 5.0, 20.0] {
            // The orbit is a circle: its speed is the same at every instant.
            let expected = amplitude * (-c.wave_number_per_m * z).exp();
            assert!((speed(z) / expected - 1.0).abs() < 1e-12);
        }
    }

    /// Against differences of the velocity; 1e-6 is their truncation.
    #[test]
    fn exact_acceleration_and_gradient() {
        let field = WAVES.field();
        let (place, time_s, h) = (Vector3::new(3.0, -2.0, 1.5), 7.0, 1e-4);
        let velocity = |place: Vector3<f64>, t: f64| field.motion(&place, t).velocity_m_s;
        let motion = field.motion(&place, time_s);
        let by_time = (velocity(place, time_s + h) - velocity(place, time_s - h)) / (2.0 * h);
        assert!((by_time - motion.acceleration_m_s2).norm() < 1e-6);
        for axis in 0..3 {
            let mut off = Vector3::zeros();
            off[axis] = h;
            let by_place =
                (velocity(place + off, time_s) - velocity(place - off, time_s)) / (2.0 * h);
            assert!((by_place - motion.gradient_per_s.column(axis)).norm() < 1e-6);
        }
        // The surface moves with the water.
        let rise = (field.elevation_m(&place, time_s + h) - field.elevation_m(&place, time_s - h))
            / (2.0 * h);
        let surface = Vector3::new(place.x, place.y, 0.0);
        assert!((rise + velocity(surface, time_s).z).abs() < 1e-6);
    }
}

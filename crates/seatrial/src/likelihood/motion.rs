//! The exact step of a hull under a constant push, with sway, a sea and waves.
//!
//! ```text
//! r' = -(d0 + d2 |r|) r + k v + push + d + w,   psi' = r,   v' = r - v/T_v,   d' = -d/T_d,   w'' = -w0^2 w - 2 z w0 w'
//! ```
//!
//! Sway acts as it is in the middle of the step, a disturbance by its mean. Damping that grows with the yaw rate is that of the middle of the step.

use super::hypothesis::{Noise, Vehicle};

/// Heading, yaw rate, sway v and sea d: the states of a hull. With six, waves w and their rate, too.
pub type State<const N: usize = 4> = [f64; N];

/// Where a leg starts, and its offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Heading, rad.
    pub heading_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Sway memory v, rad.
    pub sway_rad: f64,
    /// Yaw acceleration at neutral rudder c, rad/s^2.
    pub offset_rad_s2: f64,
}

impl Start {
    /// The state there.
    pub fn state(&self) -> State {
        [self.heading_rad, self.yaw_rate_rad_s, self.sway_rad, 0.0]
    }
}

/// A step as long as the last but for this share of it is the same: times in binary.
const SAME_STEP: f64 = 1e-9;

/// Steps of a hull and its disturbances.
#[derive(Clone, Debug)]
pub struct Motion {
    vehicle: Vehicle,
    noise: Noise,
    h: f64,
    damping_per_s: f64,
    /// What is left over h of yaw rate, sway and sea, with the integrals.
    left: [f64; 3],
    sway_left: [f64; 3],
    sea_left: [f64; 3],
    wave: [[f64; 2]; 2],
}

impl Motion {
    /// Of a vehicle under a disturbance.
    pub fn new(vehicle: &Vehicle, noise: &Noise) -> Self {
        Self {
            vehicle: *vehicle,
            noise: *noise,
            h: f64::NAN,
            damping_per_s: f64::NAN,
            left: [1.0, 0.0, 0.0],
            sway_left: [1.0, 0.0, 0.0],
            sea_left: [1.0, 0.0, 0.0],
            wave: [[0.0; 2]; 2],
        }
    }

    /// With this damping, 1/s, over steps of h, s.
    pub fn set(&mut self, damping_per_s: f64, h: f64) {
        let is_same = (h - self.h).abs() <= SAME_STEP * h;
        if !is_same {
            self.h = h;
            self.sea_left = decays(1.0 / self.noise.sea[1], h);
            self.wave = wave_over(self.noise.wave, h);
            if self.vehicle.coupling_per_s2 != 0.0 {
                self.sway_left = decays(1.0 / self.vehicle.sway_s, h);
            }
        }
        if !is_same || damping_per_s != self.damping_per_s {
            self.damping_per_s = damping_per_s;
            self.left = decays(damping_per_s, self.h);
        }
    }

    /// One step under a push, rad/s^2.
    #[inline]
    pub fn advance<const N: usize>(&self, x: &mut State<N>, push: f64) {
        let h = self.h;
        let Vehicle { coupling_per_s2: coupling, sway_s, .. } = self.vehicle;
        let mut push = push + self.sea_left[1] / h * x[3];
        if N > 4 {
            let (w, rate) = (x[4], x[5]);
            let [next, next_rate] = self.wave.map(|[of_w, of_rate]| of_w * w + of_rate * rate);
            push += 0.5 * (w + next);
            (x[4], x[5]) = (next, next_rate);
        }
        if coupling != 0.0 {
            push += coupling * (x[2] + 0.5 * h * (x[1] - x[2] / sway_s));
        }
        let [left, once, twice] = self.left;
        let turned_rad = once * x[1] + twice * push;
        if coupling != 0.0 {
            x[2] = self.sway_left[0] * x[2] + self.sway_left[1] / h * turned_rad;
        }
        x[0] += turned_rad;
        x[1] = left * x[1] + once * push;
        x[3] *= self.sea_left[0];
    }

    /// One step of h, s, with damping that grows with the yaw rate: at rest, 1/s, and per yaw rate, 1/rad.
    pub fn turn<const N: usize>(
        &mut self,
        x: &mut State<N>,
        [damping_per_s, growth_per_rad]: [f64; 2],
        push: f64,
        h: f64,
    ) {
        let at = |r: f64| damping_per_s + growth_per_rad * r.abs();
        let damping_per_s = match growth_per_rad == 0.0 {
            true => damping_per_s,
            false => {
                let push = push + self.vehicle.coupling_per_s2 * x[2] + x[3];
                at(x[1] + 0.5 * h * (push - at(x[1]) * x[1]))
            }
        };
        self.set(damping_per_s, h);
        self.advance(x, push);
    }

    /// Over an interval, s, at these angles of the gear over its parts, rad. A run that leaves the numbers stays within 1,000 rad/s.
    pub fn follow(&mut self, x: &mut State, angles: &[f64], offset_rad_s2: f64, interval_s: f64) {
        let part_s = interval_s / angles.len() as f64;
        let Vehicle { damping_per_s, quadratic_per_rad, authority_per_s2, .. } = self.vehicle;
        for angle in angles {
            let push = authority_per_s2 * angle + offset_rad_s2;
            self.turn(x, [damping_per_s, quadratic_per_rad], push, part_s);
            x[1] = x[1].clamp(-1e3, 1e3);
        }
    }
}

impl Vehicle {
    /// Damping of small changes about a yaw rate, rad/s, in 1/s.
    pub(super) fn damping_about(&self, yaw_rate_rad_s: f64) -> f64 {
        self.damping_per_s + 2.0 * self.quadratic_per_rad * yaw_rate_rad_s.abs()
    }
}

/// exp(-a h), (1 - exp(-a h))/a and (h - that)/a.
pub fn decays(damping_per_s: f64, h: f64) -> [f64; 3] {
    let z = (damping_per_s * h).clamp(-0.5, 60.0);
    let left = libm::exp(-z);
    if z.abs() < 1e-3 {
        let once = h * (1.0 - 0.5 * z + z * z / 6.0);
        return [left, once, 0.5 * h * h * (1.0 - z / 3.0)];
    }
    let damping_per_s = z / h;
    let once = (1.0 - left) / damping_per_s;
    [left, once, (h - once) / damping_per_s]
}

/// exp(A h) of the narrow-band disturbance.
fn wave_over([strength, frequency, ratio]: [f64; 3], h: f64) -> [[f64; 2]; 2] {
    if strength == 0.0 {
        return [[0.0; 2]; 2];
    }
    let decay = ratio * frequency;
    let ringing = frequency * (1.0 - ratio * ratio).max(1e-6).sqrt();
    let e = libm::exp(-decay * h);
    let (sin, cos) = (libm::sin(ringing * h), libm::cos(ringing * h));
    [
        [e * (cos + decay / ringing * sin), e * sin / ringing],
        [-e * frequency * frequency / ringing * sin, e * (cos - decay / ringing * sin)],
    ]
}

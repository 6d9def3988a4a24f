//! Innovations of heading and yaw rate of an ordinary log, linear in rudder effect, offset and bias of the gyro.
//!
//! ```text
//! psi' = r,   r' = -(d(u) + d2 |r^|) r + k v + b g(u) delta_a + c g(u) + d + w
//! y = psi + e,   y_r = r + b_r + e_r
//! ```
//!
//! |r^| is the yaw rate that a filter of first order saw until then: damping that grows with the turn stays linear, and depends on no later measurement.
//! The filter of [`crate::likelihood::filter`] is then linear, and its gains do not depend on what is measured: it runs once on
//! the measurements, once on the rudder, the offset and the bias of the gyro each, and b, c and b_r follow by least squares.

use super::record::Legs;
use crate::likelihood::filter::Whitening;
use crate::likelihood::gear::Gear;
use crate::likelihood::hypothesis::Noise;
use crate::likelihood::motion::{Motion, State};
use crate::likelihood::{Leg, Vehicle};

/// How damping and rudder effect go with the speed u over the usual speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpeedLaw {
    /// They do not.
    Constant,
    /// Damping with u, rudder effect and offset with u^2.
    Proportional,
}

impl SpeedLaw {
    fn factors(self, speed: f64) -> [f64; 2] {
        match self {
            Self::Constant => [1.0, 1.0],
            Self::Proportional => [speed, speed * speed],
        }
    }
}

/// What the innovations depend on other than linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The vehicle at the usual speed, but for its rudder authority.
    pub vehicle: Vehicle,
    /// The yaw rate for which the gains are computed where damping grows with it, rad/s.
    pub turning_rad_s: f64,
    /// Noise of the gyro over that of the heading, 1/s.
    pub gyro_noise: f64,
    /// Sea and waves.
    pub noise: Noise,
    /// Time by which the speed is logged late, s.
    pub speed_late_s: f64,
    /// How the speed matters.
    pub law: SpeedLaw,
}

/// Columns: the measurements, rudder, offset, bias of the gyro.
pub const COLUMNS: usize = 4;

/// What the whitened columns of all innovations add up to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Sums of products of the columns.
    pub products: [[f64; COLUMNS]; COLUMNS],
    /// Sum of the logs of the deviations of the innovations.
    pub log_deviations: f64,
    /// Innovations.
    pub count: f64,
}

/// Gains that a comparison changes by a smaller share stay: legs have thousands.
const SETTLED: f64 = 1e-4;

/// Runs the filter over all legs; `took` gets the columns of each innovation and its relative variance.
pub fn each_innovation(
    legs: &Legs,
    point: &Point,
    yaw_rate_rad_s: f64,
    took: impl FnMut(&[f64; COLUMNS], f64),
) {
    match point.noise.wave[0] == 0.0 {
        true => each_of::<4>(legs, point, yaw_rate_rad_s, took),
        false => each_of::<6>(legs, point, yaw_rate_rad_s, took),
    }
}

fn each_of<const STATES: usize>(
    legs: &Legs,
    point: &Point,
    yaw_rate_rad_s: f64,
    mut took: impl FnMut(&[f64; COLUMNS], f64),
) {
    for leg in &legs.legs {
        let mut run = Run::<STATES>::new(leg, point, legs.interval_s, yaw_rate_rad_s);
        for i in 0..leg.len() {
            run.measure(i, &mut took);
            run.advance(i);
        }
    }
}

/// The columns with the linear parameters [b, c, b_r].
pub fn combined(columns: &[f64; COLUMNS], linear: &[f64; COLUMNS - 1]) -> f64 {
    let [data, rudder, offset, bias] = columns;
    data + linear[0] * rudder + linear[1] * offset + linear[2] * bias
}

impl Sums {
    pub fn add(&mut self, errors: &[f64; COLUMNS], variance: f64) {
        for a in 0..COLUMNS {
            for b in a..COLUMNS {
                self.products[a][b] += errors[a] * errors[b] / variance;
            }
        }
        self.log_deviations += 0.5 * libm::log(variance);
        self.count += 1.0;
    }
}

/// A run of the filter over a leg.
pub struct Run<'a, const STATES: usize> {
    leg: &'a Leg,
    point: &'a Point,
    commands: Vec<f64>,
    gear: Gear,
    x: [State<STATES>; COLUMNS],
    filter: Whitening<STATES>,
    motion: Motion,
}

impl<'a, const STATES: usize> Run<'a, STATES> {
    /// At the first comparison of a leg.
    pub fn new(leg: &'a Leg, point: &'a Point, interval_s: f64, yaw_rate_rad_s: f64) -> Self {
        let Point { vehicle, noise, .. } = point;
        let commands = leg.smooth_commands(vehicle.shift_s, interval_s);
        let [wave, frequency, _] = noise.wave;
        // Headings are compared with the first: its own noise is that of the start.
        let wide = 1e4;
        let noise_rad = 1e-3;
        let turning = yaw_rate_rad_s / noise_rad;
        let swaying = match vehicle.coupling_per_s2 != 0.0 {
            true => turning * vehicle.sway_s,
            false => 0.0,
        };
        let deviations = [wide, turning, swaying, noise.sea[0], wave, wave * frequency];
        let mut start = [[0.0; STATES]; STATES];
        for (i, deviation) in deviations.into_iter().enumerate().take(STATES) {
            start[i][i] = deviation * deviation;
        }
        let gyro_noise = (!leg.yaw_rate_rad_s.is_empty()).then_some(point.gyro_noise);
        let mut x = [[0.0; STATES]; COLUMNS];
        x[0][0] = leg.heading_rad.first().copied().unwrap_or(0.0);
        Self {
            gear: Gear::new(vehicle, commands.first().copied().unwrap_or(0.0)),
            commands,
            leg,
            point,
            x,
            filter: Whitening::new(vehicle, noise, start, gyro_noise, SETTLED),
            motion: Motion::new(vehicle, noise),
        }
    }

    /// Takes the measurements of a comparison; `took` gets the columns of each innovation and its variance.
    pub fn measure(&mut self, i: usize, mut took: impl FnMut(&[f64; COLUMNS], f64)) {
        let rate = self.leg.yaw_rate_rad_s.get(i);
        // The bias of the gyro is what is measured too much.
        let measured = [
            Some([self.leg.heading_rad[i], 0.0, 0.0, 0.0]),
            rate.map(|rate| [*rate, 0.0, 0.0, -1.0]),
        ];
        for (state, (gain, measured)) in self.filter.measure().iter().zip(measured).enumerate() {
            let Some(mut columns) = measured else {
                continue;
            };
            for (x, column) in self.x.iter_mut().zip(&mut columns) {
                *column -= x[state];
                gain.correct(x, *column);
            }
            took(&columns, gain.variance);
        }
    }

    /// The yaw rate after the measurements of a comparison, rad/s.
    pub fn yaw_rate_rad_s(&self, linear: &[f64; 3]) -> f64 {
        combined(&self.x.map(|x| x[1]), linear)
    }

    /// Goes on to the next comparison.
    pub fn advance(&mut self, i: usize) {
        let Some(next_s) = self.leg.time_s.get(i + 1) else {
            return;
        };
        let h = next_s - self.leg.time_s[i];
        let Vehicle { damping_per_s, quadratic_per_rad, .. } = self.point.vehicle;
        let usual = damping_per_s + quadratic_per_rad * self.point.turning_rad_s;
        self.filter.advance(usual, h);
        let act = self.gear.advance(self.commands[i], h);
        let [damping, effect] = self.factors(i);
        let turning_rad_s = self.leg.turning_rad_s.get(i).copied().unwrap_or(0.0);
        self.motion.set(damping * damping_per_s + quadratic_per_rad * turning_rad_s, h);
        let pushes = [0.0, effect * act, effect, 0.0];
        for (x, push) in self.x.iter_mut().zip(pushes) {
            self.motion.advance(x, push);
        }
    }

    /// Factors of damping and rudder effect over the interval after a comparison.
    fn factors(&self, i: usize) -> [f64; 2] {
        let law = self.point.law;
        match law {
            SpeedLaw::Constant => law.factors(1.0),
            SpeedLaw::Proportional => law.factors(self.leg.speed_at(i, self.point.speed_late_s)),
        }
    }

    /// A free run over the next comparisons from a state: headings and yaw rates.
    pub fn free(&self, i: usize, until: usize, linear: &[f64; 3]) -> Vec<[f64; 2]> {
        let mut x: State<STATES> =
            core::array::from_fn(|s| combined(&self.x.map(|x| x[s]), linear));
        let (mut gear, mut motion) = (self.gear.clone(), self.motion.clone());
        let vehicle = &self.point.vehicle;
        let mut states = vec![[x[0], x[1]]];
        for k in i..until {
            let h = self.leg.time_s[k + 1] - self.leg.time_s[k];
            let act = gear.advance(self.commands[k], h);
            let [damping, effect] = self.factors(k);
            let damping = [damping * vehicle.damping_per_s, vehicle.quadratic_per_rad];
            motion.turn(&mut x, damping, effect * (linear[0] * act + linear[1]), h);
            states.push([x[0], x[1]]);
        }
        states
    }
}

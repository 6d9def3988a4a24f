//! Innovations of heading and yaw rate of an ordinary log, linear in rudder effect, offset and bias of the gyro.
//!
//! ```text
//! psi' = r,   r' = -(d(u) + d2 |r^|) r + k v + b g(u) delta_a + c g(u) + d + w
//! d' = -d/T_d + noise,   w'' = -w0^2 w - 2 z w0 w' + noise,   v' = r - v/T_v
//! y = psi + e,   y_r = r + b_r + e_r
//! ```
//!
//! |r^| is the yaw rate that a filter of first order saw until then: damping that grows with the turn stays linear, and depends on no later measurement.
//! Variances are relative to that of the heading noise. The filter is linear, and its gains do not depend on what is measured: it runs once on
//! the measurements, once on the rudder, the offset and the bias of the gyro each, and b, c and b_r follow by least squares.

use super::record::{Leg, Legs};
use crate::likelihood::filter::{Gear, decays, product};

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
    /// Damping at the usual speed, 1/s.
    pub damping_per_s: f64,
    /// Time by which the record of the rudder is early, s.
    pub shift_s: f64,
    /// Lag of the gear, s; 0 for none.
    pub lag_s: f64,
    /// Noise of the gyro over that of the heading, 1/s.
    pub gyro_noise: f64,
    /// Deviation of the Gauss-Markov disturbance over the heading noise, 1/s^2, and its time constant, s.
    pub sea: [f64; 2],
    /// Deviation of the narrow-band disturbance over the heading noise, 1/s^2, its frequency, rad/s, and its damping ratio; 0 for none.
    pub wave: [f64; 3],
    /// Time by which the speed is logged late, s.
    pub speed_late_s: f64,
    /// How the speed matters.
    pub law: SpeedLaw,
    /// Damping that grows with the yaw rate, 1/rad, and the mean yaw rate for which the gains are computed, rad/s.
    pub growth: [f64; 2],
    /// Yaw moment per sway, 1/s^2, and time constant of sway, s; 0 for none.
    pub sway: [f64; 2],
    /// Largest rate of the gear, rad/s; infinite for none.
    pub rate_limit_rad_s: f64,
}

/// Columns: the measurements, rudder, offset, bias of the gyro.
pub const COLUMNS: usize = 4;
/// Heading, yaw rate, sea, waves and their rate, sway.
const STATES: usize = 6;
type State = [f64; STATES];
type Square = [[f64; STATES]; STATES];

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

/// Changes of an interval by less than this share keep the gains.
const SAME_INTERVAL: f64 = 0.2;
/// Gains have settled where a step changes them by less than this share.
const SETTLED: f64 = 1e-4;

/// Runs the filter over all legs; `took` gets the columns of each innovation and its relative variance.
pub fn each_innovation(
    legs: &Legs,
    point: &Point,
    yaw_rate_rad_s: f64,
    mut took: impl FnMut(&[f64; COLUMNS], f64),
) {
    for leg in &legs.legs {
        let mut run = Run::new(leg, point, legs.interval_s, yaw_rate_rad_s);
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
pub struct Run<'a> {
    leg: &'a Leg,
    point: &'a Point,
    commands: Vec<f64>,
    gear: Gear,
    x: [State; COLUMNS],
    p: Square,
    transition: Transition,
    gains: [State; 2],
    variances: [f64; 2],
    is_settled: bool,
    step: Step,
}

#[derive(Clone, Copy, Default)]
struct Step {
    damping_per_s: f64,
    h: f64,
    left: f64,
    once: f64,
    twice: f64,
    sea_left: f64,
    sea_mean: f64,
    wave: [[f64; 2]; 2],
    sway: [f64; 2],
    sway_left: f64,
}

impl<'a> Run<'a> {
    /// At the first comparison of a leg.
    pub fn new(leg: &'a Leg, point: &'a Point, interval_s: f64, yaw_rate_rad_s: f64) -> Self {
        let commands = leg.commands(point.shift_s, interval_s);
        let mut p = [[0.0; STATES]; STATES];
        // Headings are compared with the first: its own noise is that of the start.
        let wide = 1e4;
        p[0][0] = wide * wide;
        let noise_rad = 1e-3;
        p[1][1] = (yaw_rate_rad_s / noise_rad).powi(2);
        p[2][2] = point.sea[0].powi(2);
        p[3][3] = point.wave[0].powi(2);
        p[4][4] = (point.wave[0] * point.wave[1]).powi(2);
        if point.sway[0] != 0.0 {
            p[5][5] = p[1][1] * point.sway[1].powi(2);
        }
        let mut x = [[0.0; STATES]; COLUMNS];
        x[0][0] = leg.heading_rad.first().copied().unwrap_or(0.0);
        Self {
            gear: Gear::lagging(
                point.lag_s,
                point.rate_limit_rad_s,
                commands.first().copied().unwrap_or(0.0),
            ),
            commands,
            leg,
            point,
            x,
            p,
            transition: Transition::new(point, interval_s),
            gains: [[0.0; STATES]; 2],
            variances: [1.0; 2],
            is_settled: false,
            step: Step::default(),
        }
    }

    /// Takes the measurements of a comparison; `took` gets the columns of each innovation and its variance.
    pub fn measure(&mut self, i: usize, mut took: impl FnMut(&[f64; COLUMNS], f64)) {
        let has_rate = !self.leg.yaw_rate_rad_s.is_empty();
        if !self.is_settled {
            let before = self.gains;
            self.variances[0] = self.p[0][0] + 1.0;
            self.gains[0] = update(&mut self.p, 0, self.variances[0]);
            if has_rate {
                self.variances[1] = self.p[1][1] + self.point.gyro_noise.powi(2);
                self.gains[1] = update(&mut self.p, 1, self.variances[1]);
            }
            let near = |a: &State, b: &State| {
                a.iter()
                    .zip(b)
                    .all(|(a, b)| (a - b).abs() <= SETTLED * b.abs())
            };
            self.is_settled = near(&before[0], &self.gains[0]) && near(&before[1], &self.gains[1]);
        }
        let mut errors = [0.0; COLUMNS];
        let heading = self.leg.heading_rad[i];
        for (c, x) in self.x.iter_mut().enumerate() {
            errors[c] = if c == 0 { heading } else { 0.0 } - x[0];
            for (state, gain) in x.iter_mut().zip(&self.gains[0]) {
                *state += gain * errors[c];
            }
        }
        took(&errors, self.variances[0]);
        if has_rate {
            let rate = self.leg.yaw_rate_rad_s[i];
            for (c, x) in self.x.iter_mut().enumerate() {
                let measured = match c {
                    0 => rate,
                    // The bias is what is measured too much.
                    3 => -1.0,
                    _ => 0.0,
                };
                errors[c] = measured - x[1];
                for (state, gain) in x.iter_mut().zip(&self.gains[1]) {
                    *state += gain * errors[c];
                }
            }
            took(&errors, self.variances[1]);
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
        if !self.transition.is_near(h) {
            self.transition = Transition::new(self.point, h);
            self.is_settled = false;
        }
        if !self.is_settled {
            self.p = self.transition.propagate(&self.p);
        }
        let act = self.gear.advance(self.commands[i], h);
        let [damping, effect] = self.factors(i);
        let turning_rad_s = self.leg.turning_rad_s.get(i).copied().unwrap_or(0.0);
        let damping = damping * self.point.damping_per_s + self.point.growth[0] * turning_rad_s;
        self.step.update(self.point, damping, h);
        for (c, x) in self.x.iter_mut().enumerate() {
            let push = match c {
                1 => effect * act,
                2 => effect,
                _ => 0.0,
            };
            self.step.advance(x, push);
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
        let mut x: State = core::array::from_fn(|s| combined(&self.x.map(|x| x[s]), linear));
        let mut gear = self.gear.clone();
        let mut step = self.step;
        let mut states = vec![[x[0], x[1]]];
        for k in i..until {
            let h = self.leg.time_s[k + 1] - self.leg.time_s[k];
            let act = gear.advance(self.commands[k], h);
            let [damping, effect] = self.factors(k);
            let damping = damping * self.point.damping_per_s + self.point.growth[0] * x[1].abs();
            step.update(self.point, damping, h);
            step.advance(&mut x, effect * (linear[0] * act + linear[1]));
            states.push([x[0], x[1]]);
        }
        states
    }
}

/// The gain of a measurement of one state, and the covariance after it.
fn update(p: &mut Square, of: usize, variance: f64) -> State {
    let gain: State = core::array::from_fn(|a| p[a][of] / variance);
    let row = p[of];
    for a in 0..STATES {
        for b in 0..STATES {
            p[a][b] -= gain[a] * row[b];
        }
    }
    gain
}

impl Step {
    fn update(&mut self, point: &Point, damping_per_s: f64, h: f64) {
        if h != self.h {
            let z = h / point.sea[1];
            self.sea_left = libm::exp(-z);
            self.sea_mean = (1.0 - self.sea_left) / z;
            self.wave = wave_transition(point, h);
            self.sway = point.sway;
            self.sway_left = match point.sway[0] != 0.0 {
                true => libm::exp(-h / point.sway[1]),
                false => 0.0,
            };
        } else if damping_per_s == self.damping_per_s {
            return;
        }
        (self.damping_per_s, self.h) = (damping_per_s, h);
        [self.left, self.once, self.twice] = decays(damping_per_s, h);
    }

    fn advance(&self, x: &mut State, push: f64) {
        let wave = [
            self.wave[0][0] * x[3] + self.wave[0][1] * x[4],
            self.wave[1][0] * x[3] + self.wave[1][1] * x[4],
        ];
        let push = push + self.sea_mean * x[2] + 0.5 * (x[3] + wave[0]);
        let [coupling, sway_s] = self.sway;
        let push = match coupling != 0.0 {
            // Sway in the middle of the interval.
            true => push + coupling * (x[5] + 0.5 * self.h * (x[1] - x[5] / sway_s)),
            false => push,
        };
        let turned_rad = self.once * x[1] + self.twice * push;
        if coupling != 0.0 {
            let share = (1.0 - self.sway_left) * sway_s / self.h;
            x[5] = self.sway_left * x[5] + share * turned_rad;
        }
        x[0] += turned_rad;
        x[1] = self.left * x[1] + self.once * push;
        x[2] *= self.sea_left;
        [x[3], x[4]] = wave;
    }
}

/// exp(A h) of the narrow-band disturbance.
fn wave_transition(point: &Point, h: f64) -> [[f64; 2]; 2] {
    let [_, frequency, ratio] = point.wave;
    if point.wave[0] == 0.0 {
        return [[0.0; 2]; 2];
    }
    let decay = ratio * frequency;
    let ringing = frequency * (1.0 - ratio * ratio).max(1e-6).sqrt();
    let e = libm::exp(-decay * h);
    let (sin, cos) = (libm::sin(ringing * h), libm::cos(ringing * h));
    [
        [e * (cos + decay / ringing * sin), e * sin / ringing],
        [
            -e * frequency * frequency / ringing * sin,
            e * (cos - decay / ringing * sin),
        ],
    ]
}

/// exp(A h) and the covariance of the noise over an interval.
struct Transition {
    h: f64,
    f: Square,
    q: Square,
}

impl Transition {
    fn new(point: &Point, h: f64) -> Self {
        let [wave, frequency, ratio] = point.wave;
        let mut a: Square = [[0.0; STATES]; STATES];
        a[0][1] = 1.0;
        a[1][1] = -point.damping_per_s - point.growth[0] * point.growth[1];
        (a[1][2], a[1][3], a[1][5]) = (1.0, 1.0, point.sway[0]);
        a[2][2] = -1.0 / point.sea[1];
        a[3][4] = 1.0;
        (a[4][3], a[4][4]) = (-frequency * frequency, -2.0 * ratio * frequency);
        if point.sway[0] != 0.0 {
            (a[5][1], a[5][5]) = (1.0, -1.0 / point.sway[1]);
        }
        let of_sea = 2.0 * point.sea[0].powi(2) / point.sea[1];
        let of_wave = 4.0 * ratio * frequency.powi(3) * wave * wave;
        let mut q = [[0.0; STATES]; STATES];
        // Gauss and Legendre's three points.
        for (at, weight) in [
            (0.112_701_665, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.887_298_335, 5.0 / 18.0),
        ] {
            let f = exponential(&a, at * h);
            for i in 0..STATES {
                for j in 0..STATES {
                    q[i][j] +=
                        weight * h * (of_sea * f[i][2] * f[j][2] + of_wave * f[i][4] * f[j][4]);
                }
            }
        }
        Self {
            h,
            f: exponential(&a, h),
            q,
        }
    }

    fn is_near(&self, h: f64) -> bool {
        (h - self.h).abs() <= SAME_INTERVAL * self.h
    }

    fn propagate(&self, p: &Square) -> Square {
        let half = product(&self.f, p);
        core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                self.q[i][j] + (0..STATES).map(|k| half[i][k] * self.f[j][k]).sum::<f64>()
            })
        })
    }
}

/// By scaling and squaring of a series.
fn exponential(a: &Square, h: f64) -> Square {
    let largest = a.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs())) * h;
    let halvings = libm::ceil(libm::log2(largest.max(0.25) * 4.0)) as i32;
    let h = h / libm::exp2(f64::from(halvings));
    let one: Square =
        core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut f = (1..=5).rev().fold(one, |f, order| {
        let next = product(a, &f);
        core::array::from_fn(|i| {
            core::array::from_fn(|j| one[i][j] + next[i][j] * h / f64::from(order))
        })
    });
    for _ in 0..halvings {
        f = product(&f, &f);
    }
    f
}

//! The one whitening filter: innovations of the heading under a vehicle and a disturbance.
//!
//! ```text
//! x = (psi, r, v, d);  prediction by exact exponential steps;  K = P H'/S,  S = H P H' + 1,  e = (y - psi)/sqrt(S)
//! ```
//!
//! Variances are relative to that of the heading noise. Without a disturbance P is 0 and the filter is output error. Under a drift only
//! the heading is corrected. Gains do not depend on the headings, so that parameters which leave the dynamics alone share them.

use super::hypothesis::Vehicle;
use super::leg::{Leg, PARTS};

/// Strength of a disturbance, relative to the heading noise of one comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// No disturbance.
    None,
    /// Random walk of the heading, 1/sqrt(s).
    Drift {
        /// Its deviation after a second over that of the heading noise, 1/sqrt(s).
        per_sqrt_s: f64,
    },
    /// Gauss-Markov yaw acceleration.
    Sea {
        /// Its standard deviation over that of the heading noise, 1/s^2.
        per_s2: f64,
        /// Its time constant, s.
        time_s: f64,
    },
}

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

/// Heading, yaw rate, sway and disturbance.
pub type State = [f64; 4];
type Square = [[f64; 4]; 4];

/// A gain has settled where a step changes it by less than this share.
const SETTLED: f64 = 1e-9;

/// Gains of the filter at each comparison of a leg.
#[derive(Clone, Debug)]
pub struct Gains {
    gain: Vec<State>,
    deviation: Vec<f64>,
    /// The disturbance's time constant, s.
    time_s: f64,
    /// Sum of the logs of the deviations of the innovations.
    pub log_deviations: f64,
}

/// The innovations of comparisons `from..to` of a leg, rad, each over its deviation.
///
/// `angles` are those of [`angles`] over the whole leg.
pub fn innovations(
    leg: &Leg,
    [from, to]: [usize; 2],
    vehicle: &Vehicle,
    start: &Start,
    gains: Option<&Gains>,
    angles: &[f64],
) -> Vec<f64> {
    let mut errors = Vec::with_capacity(to - from);
    let parts = parts_of(angles, leg);
    let mut x = [start.heading_rad, start.yaw_rate_rad_s, start.sway_rad, 0.0];
    let mut motion = Motion::new(vehicle);
    let mut decay = Decay::of(gains.map_or(f64::INFINITY, |gains| gains.time_s));
    for i in from..to {
        let error = leg.heading_rad[i] - x[0];
        match gains {
            Some(gains) => {
                for (state, gain) in x.iter_mut().zip(&gains.gain[i]) {
                    *state += gain * error;
                }
                errors.push(error / gains.deviation[i]);
            }
            None => errors.push(error),
        }
        if i + 1 == to {
            break;
        }
        let interval_s = leg.time_s[i + 1] - leg.time_s[i];
        let during = &angles[parts * i..parts * (i + 1)];
        motion.follow(&mut x, during, start.offset_rad_s2, interval_s);
        if x[3] != 0.0 {
            x[3] *= decay.over(interval_s);
        }
    }
    errors
}

/// Mean angles of the gear over parts of each interval between comparisons, rad. The gear starts at rest at the leg's beginning.
///
/// Of a thinned leg they are averaged as its headings are: the mean of headings follows the mean of angles.
pub fn angles(leg: &Leg, vehicle: &Vehicle) -> Vec<f64> {
    let commands = vehicle.commands(leg);
    let parts = parts_of(&commands, leg);
    let mut gear = Gear::new(vehicle, commands.first().copied().unwrap_or(0.0));
    let angles = leg.time_s.windows(2).zip(commands.chunks_exact(parts));
    let angles: Vec<f64> = angles
        .flat_map(|(pair, during)| {
            let part_s = (pair[1] - pair[0]) / parts as f64;
            during.iter().map(move |command| (*command, part_s))
        })
        .map(|(command, part_s)| gear.advance(command, part_s))
        .collect();
    leg.averaged(angles, parts)
}

/// Parts of each interval between comparisons.
fn parts_of(angles: &[f64], leg: &Leg) -> usize {
    (angles.len() / leg.len().saturating_sub(1).max(1)).max(1)
}

/// Heading, yaw rate and sway at each comparison of a leg of a free-running vehicle; the fourth is 0.
pub fn simulate(leg: &Leg, vehicle: &Vehicle, start: &Start) -> Vec<State> {
    let angles = angles(leg, vehicle);
    let mut motion = Motion::new(vehicle);
    let mut x = [start.heading_rad, start.yaw_rate_rad_s, start.sway_rad, 0.0];
    let mut states = Vec::with_capacity(leg.len());
    states.extend((!leg.is_empty()).then_some(x));
    let parts = parts_of(&angles, leg);
    for (pair, during) in leg.time_s.windows(2).zip(angles.chunks_exact(parts)) {
        motion.follow(&mut x, during, start.offset_rad_s2, pair[1] - pair[0]);
        states.push(x);
    }
    states
}

/// Overshoot of a heading step under proportional control, how far it is still off at the end, and how far it swings there, shares of
/// the step.
///
/// The controller sees the heading every `interval_s` and turns the rudder within `limit_rad`; it runs for 30 time constants, but at most
/// 6,000 intervals.
pub fn heading_step(
    vehicle: &Vehicle,
    gain: f64,
    step_rad: f64,
    limit_rad: f64,
    interval_s: f64,
) -> [f64; 3] {
    const LENGTH: f64 = 30.0;
    let slowest_s = 1.0 / vehicle.damping_per_s.abs().max(f64::MIN_POSITIVE);
    let of_loop_s = 1.0
        / (gain * vehicle.authority_per_s2)
            .abs()
            .sqrt()
            .max(f64::MIN_POSITIVE);
    let steps = (LENGTH * slowest_s.max(of_loop_s) / interval_s).clamp(100.0, 6_000.0) as usize;
    let part_s = interval_s / PARTS as f64;
    let mut gear = Gear::new(vehicle, 0.0);
    let mut motion = Motion::new(vehicle);
    let mut x: State = [0.0; 4];
    let (mut most, mut off) = (0.0_f64, 0.0_f64);
    let [mut lowest, mut highest] = [f64::INFINITY, f64::NEG_INFINITY];
    for k in 0..steps {
        let command = (gain * (step_rad - x[0])).clamp(-limit_rad, limit_rad);
        for _ in 0..PARTS {
            let act = gear.advance(command, part_s);
            motion.advance(&mut x, vehicle.authority_per_s2 * act, part_s);
        }
        most = most.max(x[0] - step_rad);
        if 4 * k > 3 * steps {
            off = off.max((x[0] - step_rad).abs());
            [lowest, highest] = [lowest.min(x[0]), highest.max(x[0])];
        }
    }
    [most, off, highest - lowest].map(|rad| rad / step_rad)
}

/// exp(-h/T), computed anew only where the interval changes.
#[derive(Clone)]
struct Decay {
    time_s: f64,
    interval_s: f64,
    factor: f64,
}

impl Decay {
    fn of(time_s: f64) -> Self {
        Self {
            time_s,
            interval_s: f64::NAN,
            factor: 1.0,
        }
    }

    fn over(&mut self, interval_s: f64) -> f64 {
        if interval_s != self.interval_s {
            self.interval_s = interval_s;
            self.factor = libm::exp(-interval_s / self.time_s);
        }
        self.factor
    }
}

/// A steering gear that lags, has a largest rate or has play.
#[derive(Clone)]
pub(crate) struct Gear {
    decay: Decay,
    rate_limit_rad_s: f64,
    half_play_rad: f64,
    angle_rad: f64,
}

impl Gear {
    fn new(vehicle: &Vehicle, angle_rad: f64) -> Self {
        Self {
            decay: Decay::of(vehicle.lag_s),
            rate_limit_rad_s: vehicle.rate_limit_rad_s,
            half_play_rad: 0.5 * vehicle.play_rad,
            angle_rad,
        }
    }

    /// A gear without play that lags by so much, s, and has a largest rate, rad/s.
    pub(crate) fn lagging(lag_s: f64, rate_limit_rad_s: f64, angle_rad: f64) -> Self {
        Self {
            decay: Decay::of(lag_s),
            rate_limit_rad_s,
            half_play_rad: 0.0,
            angle_rad,
        }
    }

    /// The mean angle over a part, rad.
    pub(crate) fn advance(&mut self, command_rad: f64, part_s: f64) -> f64 {
        let from = self.angle_rad;
        let command_rad = match self.half_play_rad > 0.0 {
            true => from.clamp(
                command_rad - self.half_play_rad,
                command_rad + self.half_play_rad,
            ),
            false => command_rad,
        };
        let away = from - command_rad;
        let (next, mean) = match self.decay.time_s > 0.0 {
            true => {
                let left = self.decay.over(part_s);
                let mean = command_rad + away * self.decay.time_s / part_s * (1.0 - left);
                (command_rad + away * left, mean)
            }
            false => (command_rad, command_rad),
        };
        let most = self.rate_limit_rad_s * part_s;
        if (next - from).abs() > most {
            self.angle_rad = from + most.copysign(next - from);
            return 0.5 * (from + self.angle_rad);
        }
        self.angle_rad = next;
        if self.rate_limit_rad_s.is_finite() && self.decay.time_s == 0.0 {
            // The way there takes a share of the part.
            let way = (next - from).abs() / most;
            return next - 0.5 * way * (next - from);
        }
        mean
    }
}

/// Exact steps of yaw rate and heading under a constant push, sway from the mean yaw rate.
struct Motion<'a> {
    vehicle: &'a Vehicle,
    damping_per_s: f64,
    part_s: f64,
    /// exp(-alpha h), its integral and the integral of that.
    left: [f64; 3],
    sway: Decay,
}

impl<'a> Motion<'a> {
    fn new(vehicle: &'a Vehicle) -> Self {
        Self {
            vehicle,
            damping_per_s: f64::NAN,
            part_s: f64::NAN,
            left: [1.0, 0.0, 0.0],
            sway: Decay::of(vehicle.sway_s),
        }
    }

    /// Over an interval, s, at these angles of the gear over its parts, rad.
    fn follow(&mut self, x: &mut State, angles: &[f64], offset_rad_s2: f64, interval_s: f64) {
        let part_s = interval_s / angles.len() as f64;
        for angle in angles {
            let push = self.vehicle.authority_per_s2 * angle + offset_rad_s2;
            self.advance(x, push, part_s);
        }
    }

    fn advance(&mut self, x: &mut State, push: f64, h: f64) {
        let vehicle = self.vehicle;
        let push = push + vehicle.coupling_per_s2 * x[2] + x[3];
        let r = x[1];
        let damping = match vehicle.quadratic_per_rad == 0.0 {
            true => vehicle.damping_per_s,
            false => {
                let now = vehicle.damping_per_s + vehicle.quadratic_per_rad * r.abs();
                let middle = r + 0.5 * h * (push - now * r);
                vehicle.damping_per_s + vehicle.quadratic_per_rad * middle.abs()
            }
        };
        if damping != self.damping_per_s || h != self.part_s {
            (self.damping_per_s, self.part_s) = (damping, h);
            self.left = decays(damping, h);
        }
        let [left, once, twice] = self.left;
        x[0] += once * r + twice * push;
        x[1] = (left * r + once * push).clamp(-1e3, 1e3);
        if vehicle.coupling_per_s2 != 0.0 {
            let kept = self.sway.over(h);
            x[2] = kept * x[2] + vehicle.sway_s * (1.0 - kept) * 0.5 * (r + x[1]);
        }
    }
}

/// exp(-a h), (1 - exp(-a h))/a and (h - that)/a.
pub(crate) fn decays(damping_per_s: f64, h: f64) -> [f64; 3] {
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

impl Gains {
    /// Of a leg under a disturbance. A nonlinear vehicle is linearised along the slopes of the heading, rad/s. `None` where nothing
    /// disturbs.
    pub fn of(leg: &Leg, vehicle: &Vehicle, noise: &Noise, slopes_rad_s: &[f64]) -> Option<Self> {
        match *noise {
            Noise::None => None,
            Noise::Drift { per_sqrt_s } => Some(Self::of_drift(leg, per_sqrt_s)),
            Noise::Sea { per_s2, time_s } => Some(Self::of_sea(
                leg,
                vehicle,
                per_s2 * per_s2,
                time_s,
                slopes_rad_s,
            )),
        }
    }

    fn of_drift(leg: &Leg, per_sqrt_s: f64) -> Self {
        let mut gains = Self::new(leg.len(), f64::INFINITY);
        let mut p = 0.0;
        for i in 0..leg.len() {
            gains.push([p / (p + 1.0), 0.0, 0.0, 0.0], p + 1.0);
            if let Some(next_s) = leg.time_s.get(i + 1) {
                p = p / (p + 1.0) + per_sqrt_s * per_sqrt_s * (next_s - leg.time_s[i]);
            }
        }
        gains
    }

    fn of_sea(
        leg: &Leg,
        vehicle: &Vehicle,
        variance: f64,
        time_s: f64,
        slopes_rad_s: &[f64],
    ) -> Self {
        let mut gains = Self::new(leg.len(), time_s);
        let mut p: Square = [[0.0; 4]; 4];
        p[3][3] = variance;
        let mut transition = Transition::default();
        let mut is_settled = false;
        for (i, at_s) in leg.time_s.iter().enumerate() {
            let interval_s = leg.time_s.get(i + 1).map_or(0.0, |next_s| next_s - at_s);
            if is_settled && (transition.interval_s == interval_s || interval_s == 0.0) {
                gains.repeat();
                continue;
            }
            let s = p[0][0] + 1.0;
            let gain: State = core::array::from_fn(|a| p[a][0] / s);
            is_settled = vehicle.quadratic_per_rad == 0.0 && gains.ends_near(&gain);
            gains.push(gain, s);
            if interval_s == 0.0 {
                break;
            }
            let updated: Square =
                core::array::from_fn(|a| core::array::from_fn(|b| p[a][b] - gain[a] * p[0][b]));
            let damping_per_s =
                vehicle.damping_per_s + 2.0 * vehicle.quadratic_per_rad * slopes_rad_s[i].abs();
            transition.update(vehicle, damping_per_s, time_s, interval_s);
            p = transition.propagate(&updated, variance, time_s);
        }
        gains
    }

    fn new(n: usize, time_s: f64) -> Self {
        Self {
            gain: Vec::with_capacity(n),
            deviation: Vec::with_capacity(n),
            time_s,
            log_deviations: 0.0,
        }
    }

    fn push(&mut self, gain: State, variance: f64) {
        self.gain.push(gain);
        self.deviation.push(variance.sqrt());
        self.log_deviations += 0.5 * libm::log(variance);
    }

    fn repeat(&mut self) {
        if let (Some(gain), Some(deviation)) = (self.gain.last(), self.deviation.last()) {
            self.push(*gain, deviation * deviation);
        }
    }

    fn ends_near(&self, gain: &State) -> bool {
        self.gain.last().is_some_and(|last| {
            last.iter()
                .zip(gain)
                .all(|(a, b)| (a - b).abs() <= SETTLED * b.abs())
        })
    }
}

/// exp(A h) of the linearised vehicle with its disturbance.
struct Transition {
    interval_s: f64,
    damping_per_s: f64,
    f: Square,
}

impl Default for Transition {
    fn default() -> Self {
        Self {
            interval_s: f64::NAN,
            damping_per_s: f64::NAN,
            f: [[0.0; 4]; 4],
        }
    }
}

impl Transition {
    fn update(&mut self, vehicle: &Vehicle, damping_per_s: f64, time_s: f64, h: f64) {
        // A change of the damping by a thousandth changes no gain that matters.
        let near = (damping_per_s - self.damping_per_s).abs() <= 1e-3 * damping_per_s.abs();
        if near && h == self.interval_s {
            return;
        }
        (self.damping_per_s, self.interval_s) = (damping_per_s, h);
        let a: Square = [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -damping_per_s, vehicle.coupling_per_s2, 1.0],
            [0.0, 1.0, -1.0 / vehicle.sway_s, 0.0],
            [0.0, 0.0, 0.0, -1.0 / time_s],
        ];
        let one: Square =
            core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
        // Horner: I + A h/1 (I + A h/2 (...)).
        self.f = (1..=5).rev().fold(one, |f, order| {
            let next = product(&a, &f);
            core::array::from_fn(|i| {
                core::array::from_fn(|j| one[i][j] + next[i][j] * h / f64::from(order))
            })
        });
    }

    fn propagate(&self, p: &Square, variance: f64, time_s: f64) -> Square {
        let half = product(&self.f, p);
        let mut next: Square = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..4).map(|k| half[i][k] * self.f[j][k]).sum())
        });
        let h = self.interval_s;
        let (z, white) = (h / time_s, 2.0 * variance / time_s);
        next[3][3] += variance * (1.0 - libm::exp(-2.0 * z));
        let cross = white * h * h / 2.0 / (1.0 + z);
        next[1][3] += cross;
        next[3][1] += cross;
        next[1][1] += white * h * h * h / 3.0 / (1.0 + z);
        next
    }
}

/// The product of two square matrices.
pub(crate) fn product<const N: usize>(a: &[[f64; N]; N], b: &[[f64; N]; N]) -> [[f64; N]; N] {
    core::array::from_fn(|i| core::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

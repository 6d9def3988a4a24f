//! The whitening filter of every record: gains of heading and gyro under a vehicle and what disturbs it.
//!
//! ```text
//! x = (psi, r, v, d, w, w'),   P <- F P F' + Q,   S = P_kk + R,   K = P e_k / S   (recursion in seatrial_core::whitening)
//! F = exp(A h),   Q = integral of exp(A s) G G' exp(A s)' over the step
//! ```
//!
//! Variances are relative to that of the heading noise. Without a disturbance P is 0 and the filter is output error. Under a drift only
//! the heading is corrected. Gains do not depend on what is measured, so that parameters which leave the dynamics alone share them. F and Q are
//! computed over a step so short that five terms of a series and three of Gauss's points are exact to 1e-6, and doubled.

use seatrial_core::whitening::{Covariance, Gain};

use super::hypothesis::{Noise, Vehicle};
use super::leg::{Leg, parts_of};
use super::motion::{Motion, Start, State};

/// Changes of an interval or of the damping by less than these shares keep the transition.
const SAME_INTERVAL: f64 = 0.2;
const SAME_DAMPING: f64 = 1e-3;

/// Gains of a vehicle under disturbances, from one comparison to the next.
pub struct Whitening<const N: usize> {
    vehicle: Vehicle,
    noise: Noise,
    gyro_noise: Option<f64>,
    /// A gain has settled where a comparison changes it by less than this share.
    settled: f64,
    covariance: Covariance<f64, N>,
    transition: Transition<N>,
    /// Gains of heading and gyro.
    gains: [Gain<f64, N>; 2],
    is_settled: bool,
}

impl<const N: usize> Whitening<N> {
    /// From a start as uncertain as this. `gyro_noise`, 1/s, is that of a gyro over that of the heading; gains that a comparison changes by a
    /// share of less than `settled` stay as they are.
    pub fn new(
        vehicle: &Vehicle,
        noise: &Noise,
        start: [[f64; N]; N],
        gyro_noise: Option<f64>,
        settled: f64,
    ) -> Self {
        let none = Gain { gain: [0.0; N], variance: 1.0, precision: 1.0 };
        Self {
            vehicle: *vehicle,
            noise: *noise,
            gyro_noise,
            settled,
            covariance: Covariance(start),
            transition: Transition::NONE,
            gains: [none; 2],
            is_settled: false,
        }
    }

    /// Gains of heading and gyro at the next comparison; that of a gyro which is not there is 0.
    pub fn measure(&mut self) -> &[Gain<f64, N>; 2] {
        if !self.is_settled {
            let before = self.gains;
            self.gains[0] = self.covariance.measure(0, 1.0);
            if let Some(noise) = self.gyro_noise {
                self.gains[1] = self.covariance.measure(1, noise * noise);
            }
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= self.settled * b.abs();
            self.is_settled = (before.iter().zip(&self.gains))
                .all(|(before, now)| before.gain.iter().zip(&now.gain).all(near));
        }
        &self.gains
    }

    /// Over an interval, s, with the damping about the yaw rate there, 1/s.
    pub fn advance(&mut self, damping_per_s: f64, interval_s: f64) {
        if !self.transition.is_near(damping_per_s, interval_s) {
            self.transition =
                Transition::new(&self.vehicle, &self.noise, damping_per_s, interval_s);
            self.is_settled = false;
        }
        if !self.is_settled {
            self.transition.move_on(&mut self.covariance);
        }
    }
}

/// A matrix by its columns.
type Columns<const N: usize> = [[f64; N]; N];

/// F and Q of an interval.
struct Transition<const N: usize> {
    interval_s: f64,
    damping_per_s: f64,
    f: Columns<N>,
    q: [[f64; N]; N],
}

impl<const N: usize> Transition<N> {
    const NONE: Self =
        Self { interval_s: f64::NAN, damping_per_s: f64::NAN, f: [[0.0; N]; N], q: [[0.0; N]; N] };

    /// Without a sea and waves only the heading is uncertain.
    fn new(vehicle: &Vehicle, noise: &Noise, damping_per_s: f64, h: f64) -> Self {
        let Noise { drift, sea: [sea, sea_s], wave: [wave, frequency, ratio] } = *noise;
        let mut transition =
            Self { interval_s: h, damping_per_s, f: core::array::from_fn(unit), q: [[0.0; N]; N] };
        let mut fastest = damping_per_s.abs().max(1.0 / sea_s);
        // A by its columns: what heading, yaw rate, sway, sea and waves do.
        let mut a = [[0.0; N]; N];
        (a[1][0], a[1][1]) = (1.0, -damping_per_s);
        (a[3][1], a[3][3]) = (1.0, -1.0 / sea_s);
        if vehicle.coupling_per_s2 != 0.0 {
            a[1][2] = 1.0;
            (a[2][1], a[2][2]) = (vehicle.coupling_per_s2, -1.0 / vehicle.sway_s);
            let of_sway = vehicle.coupling_per_s2.abs().sqrt();
            fastest = fastest.max(of_sway).max(1.0 / vehicle.sway_s);
        }
        let mut noises = [(3, 2.0 * sea * sea / sea_s), (3, 0.0)];
        if N > 4 && wave != 0.0 {
            (a[4][1], a[4][5]) = (1.0, -frequency * frequency);
            (a[5][4], a[5][5]) = (1.0, -2.0 * ratio * frequency);
            noises[1] = (5, 4.0 * ratio * frequency.powi(3) * wave * wave);
            fastest = fastest.max(frequency);
        }
        if noises.iter().any(|(_, power)| *power > 0.0) {
            transition.integrate(&a, fastest, noises);
        }
        transition.q[0][0] += drift * drift * h;
        transition
    }

    fn integrate(&mut self, a: &Columns<N>, fastest: f64, noises: [(usize, f64); 2]) {
        let halvings = libm::ceil(libm::log2(4.0 * fastest * self.interval_s)).clamp(0.0, 30.0);
        let h = self.interval_s / libm::exp2(halvings);
        self.f = core::array::from_fn(|i| series(a, h, unit(i)));
        // Gauss and Legendre's three points.
        for (at, weight) in
            [(0.112_701_665, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_335, 5.0 / 18.0)]
        {
            for (state, power) in noises.into_iter().filter(|(_, power)| *power > 0.0) {
                let moved = series(a, at * h, unit(state));
                for (row, of_row) in self.q.iter_mut().zip(moved) {
                    for (q, of_column) in row.iter_mut().zip(moved) {
                        *q += weight * h * power * of_row * of_column;
                    }
                }
            }
        }
        for _ in 0..halvings as u32 {
            let mut q = Covariance(self.q);
            self.move_on(&mut q);
            self.q = q.0;
            let f = self.f;
            self.f = f.map(|column| product(&f, &column));
        }
    }

    fn is_near(&self, damping_per_s: f64, interval_s: f64) -> bool {
        (interval_s - self.interval_s).abs() <= SAME_INTERVAL * self.interval_s
            && (damping_per_s - self.damping_per_s).abs() <= SAME_DAMPING * damping_per_s.abs()
    }

    /// F P F' + Q.
    fn move_on(&self, p: &mut Covariance<f64, N>) {
        *p = p.advanced(|x| product(&self.f, &x));
        for (row, of_row) in p.0.iter_mut().zip(&self.q) {
            for (p, q) in row.iter_mut().zip(of_row) {
                *p += q;
            }
        }
    }
}

fn unit<const N: usize>(at: usize) -> [f64; N] {
    core::array::from_fn(|i| f64::from(u8::from(i == at)))
}

fn product<const N: usize>(columns: &Columns<N>, x: &[f64; N]) -> [f64; N] {
    let mut y = [0.0; N];
    for (column, x) in columns.iter().zip(x) {
        for (y, of_column) in y.iter_mut().zip(column) {
            *y += of_column * x;
        }
    }
    y
}

/// exp(A s) x by five terms.
fn series<const N: usize>(a: &Columns<N>, s: f64, x: [f64; N]) -> [f64; N] {
    (1..=5).rev().fold(x, |sum, order| {
        let next = product(a, &sum);
        core::array::from_fn(|i| x[i] + next[i] * s / f64::from(order))
    })
}

/// Gains that a comparison changes by a smaller share stay: derivatives by differences see larger ones.
const SETTLED: f64 = 1e-9;

/// Gains of the filter at each comparison of a leg.
#[derive(Clone, Debug)]
pub struct Gains {
    gains: Vec<(Gain<f64, 4>, f64)>,
    noise: Noise,
    /// Sum of the logs of the deviations of the innovations.
    pub log_deviations: f64,
}

impl Gains {
    /// Of a leg under a disturbance. A nonlinear vehicle is linearised along the slopes of the heading, rad/s. `None` where nothing
    /// disturbs.
    pub fn of(leg: &Leg, vehicle: &Vehicle, noise: &Noise, slopes_rad_s: &[f64]) -> Option<Self> {
        if *noise == Noise::NONE {
            return None;
        }
        let mut start = [[0.0; 4]; 4];
        start[3][3] = noise.sea[0].powi(2);
        let mut filter = Whitening::new(vehicle, noise, start, None, SETTLED);
        let mut found =
            Self { gains: Vec::with_capacity(leg.len()), noise: *noise, log_deviations: 0.0 };
        for (i, at_s) in leg.time_s.iter().enumerate() {
            let [heading, _] = *filter.measure();
            found.gains.push((heading, heading.variance.sqrt()));
            found.log_deviations += 0.5 * libm::log(heading.variance);
            if let Some(next_s) = leg.time_s.get(i + 1) {
                filter.advance(vehicle.damping_about(slopes_rad_s[i]), next_s - at_s);
            }
        }
        Some(found)
    }
}

/// The innovations of comparisons `from..to` of a leg, rad, each over its deviation.
///
/// `angles` are those of [`super::gear::angles`] over the whole leg.
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
    let mut x: State = start.state();
    let noise = gains.map_or(Noise::NONE, |gains| gains.noise);
    let mut motion = Motion::new(vehicle, &noise);
    for i in from..to {
        let heading_rad = leg.heading_rad[i];
        errors.push(match gains {
            Some(Gains { gains, .. }) => {
                let (gain, deviation) = &gains[i];
                let innovation = heading_rad - x[0];
                gain.correct(&mut x, innovation);
                innovation / deviation
            }
            None => heading_rad - x[0],
        });
        if i + 1 == to {
            break;
        }
        let interval_s = leg.time_s[i + 1] - leg.time_s[i];
        let during = &angles[parts * i..parts * (i + 1)];
        motion.follow(&mut x, during, start.offset_rad_s2, interval_s);
    }
    errors
}

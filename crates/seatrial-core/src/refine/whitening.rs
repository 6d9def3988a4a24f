//! A Kalman filter that whitens a heading with a disturbance.

use libm::{exp, log};

use super::lanes::Lanes;
use super::responses::{Responses, Step};
use crate::whitening::{Covariance, Gain};

/// Change of gain and innovation variance, by this share of them, under which the filter counts as steady.
const STEADY: f64 = 1e-7;

/// A change of the interval by this share of it does not change the filter: clock jitter.
pub const SAME_INTERVAL: f64 = 1e-6;

/// A yaw acceleration disturbance as a first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Its standard deviation over that of the heading noise, 1/s^2. 0 for none.
    pub relative: f64,
    /// Its time constant, s.
    pub time_constant_s: f64,
}

impl Disturbance {
    /// Heading noise only: the output error model.
    pub const NONE: Self = Self { relative: 0.0, time_constant_s: 1.0 };
}

/// The filter for the heading and its columns alike, for N dampings. Variances are in units of the heading noise.
///
/// ```text
/// x = [psi, r, d],  psi' = r,  r' = a22 r + d,  d' = -d/tau + white
/// x <- F x,   P <- F P F^T + Q                                           to the next comparison
/// S = P_psi,psi + 1/block, and on by the gains of [`crate::whitening`]
/// ```
#[derive(Clone, Debug)]
pub struct Whitening<const N: usize, const COLUMNS: usize> {
    disturbance: Disturbance,
    noise: f64,
    interval_s: f64,
    transition: Transition<N>,
    process: f64,
    covariance: Covariance<Lanes<N>, 3>,
    gain: Gain<Lanes<N>, 3>,
    states: [[Lanes<N>; 3]; COLUMNS],
    log_variances: LogOfProduct<N>,
    steady: bool,
}

impl<const N: usize, const COLUMNS: usize> Whitening<N, COLUMNS> {
    /// Begins at rest at heading 0.
    pub fn new(disturbance: Disturbance, block: usize) -> Self {
        let [none, variance] = [0.0, disturbance.relative * disturbance.relative].map(Lanes::all);
        Self {
            disturbance,
            noise: 1.0 / block as f64,
            interval_s: f64::NAN,
            transition: Transition {
                step: Step { decay: none, rate_gain_s: none, heading_gain_s2: none },
                memory: 0.0,
            },
            process: 0.0,
            covariance: Covariance([[none; 3], [none; 3], [none, none, variance]]),
            gain: Gain { gain: [none; 3], variance: none, precision: none },
            states: [[none; 3]; COLUMNS],
            log_variances: LogOfProduct::new(),
            steady: false,
        }
    }

    /// Begins with the first two comparisons, from any heading and yaw rate.
    ///
    /// ```text
    /// r = F_rr / F_psi,r (z_1 - z_0 - n_1 + n_0) + (F_psi,r - F_rr F_psi,d / F_psi,r) d      psi = z_1 - n_1
    /// ```
    ///
    /// n is the heading noise, d the disturbance at the first. A unit r0 turns the vehicle by `turned_s` from the first to the second,
    /// s: its square is the determinant of the change from (psi0, r0) to both.
    pub fn begin(
        &mut self,
        first: &[Lanes<N>; COLUMNS],
        second: &[Lanes<N>; COLUMNS],
        turned_s: Lanes<N>,
        interval_s: f64,
        responses: &Responses<N>,
    ) {
        self.set_interval(interval_s, responses);
        let Transition { step, memory } = self.transition;
        let from_headings = step.decay / step.rate_gain_s;
        let from_disturbance = step.rate_gain_s - from_headings * step.heading_gain_s2;
        let power = Lanes::all(self.disturbance.relative * self.disturbance.relative);
        let noise = Lanes::all(self.noise);
        let none = Lanes::ZERO;
        let psi_r = from_headings * noise;
        let r_r = from_headings * from_headings * noise * 2.0
            + from_disturbance * from_disturbance * power;
        let r_d = from_disturbance * power * memory;
        self.covariance = Covariance([[noise, psi_r, none], [psi_r, r_r, r_d], [none, r_d, power]]);
        for ((state, z0), z1) in self.states.iter_mut().zip(first).zip(second) {
            *state = [*z1, from_headings * (*z1 - *z0), none];
        }
        self.log_variances.multiply(turned_s * turned_s);
    }

    /// The innovation of each column at a comparison, `interval_s` after the last.
    #[inline(always)]
    pub fn innovations(
        &mut self,
        columns: &[Lanes<N>; COLUMNS],
        interval_s: f64,
        responses: &Responses<N>,
    ) -> [Lanes<N>; COLUMNS] {
        let jitter_s = (interval_s - self.interval_s).abs();
        if jitter_s > SAME_INTERVAL * interval_s || self.interval_s.is_nan() {
            self.set_interval(interval_s, responses);
        }
        match self.steady {
            true => self.log_variances.again(),
            false => self.update_gain(),
        }
        let mut innovations = *columns;
        for (state, innovation) in self.states.iter_mut().zip(&mut innovations) {
            *state = self.transition.of(*state);
            *innovation -= state[0];
            self.gain.correct(state, *innovation);
        }
        innovations
    }

    /// 1/S of the latest innovations.
    pub fn precision(&self) -> Lanes<N> {
        self.gain.precision
    }

    /// sum log S of all innovations.
    pub fn log_variances(&self) -> [f64; N] {
        self.log_variances.sum().0
    }

    fn set_interval(&mut self, interval_s: f64, responses: &Responses<N>) {
        let memory = exp(-interval_s / self.disturbance.time_constant_s);
        self.transition = Transition { step: responses.step_over(interval_s), memory };
        self.process =
            self.disturbance.relative * self.disturbance.relative * (1.0 - memory * memory);
        self.interval_s = interval_s;
        self.steady = false;
    }

    fn update_gain(&mut self) {
        let transition = self.transition;
        self.covariance = self.covariance.advanced(|state| transition.of(state));
        self.covariance.0[2][2] += Lanes::all(self.process);
        let gain = self.covariance.measure(0, Lanes::all(self.noise));
        let is_same = |new: Lanes<N>, old: Lanes<N>| {
            (new.0.iter().zip(old.0)).all(|(new, old)| (new - old).abs() <= STEADY * new.abs())
        };
        self.steady = is_same(gain.precision, self.gain.precision)
            && (gain.gain.iter().zip(self.gain.gain)).all(|(new, old)| is_same(*new, old));
        self.log_variances.multiply(gain.variance);
        self.gain = gain;
    }
}

/// F: the state one comparison later.
#[derive(Clone, Copy, Debug)]
struct Transition<const N: usize> {
    step: Step<N>,
    memory: f64,
}

impl<const N: usize> Transition<N> {
    /// F x.
    #[inline(always)]
    fn of(&self, [psi, r, d]: [Lanes<N>; 3]) -> [Lanes<N>; 3] {
        let step = &self.step;
        [
            psi + step.rate_gain_s * r + step.heading_gain_s2 * d,
            step.decay * r + step.rate_gain_s * d,
            d * self.memory,
        ]
    }
}

/// log of a product of many factors, without a logarithm for each.
#[derive(Clone, Copy, Debug)]
struct LogOfProduct<const N: usize> {
    product: Lanes<N>,
    /// Factors since the product was looked at.
    factors: u32,
    log: Lanes<N>,
    last: Lanes<N>,
    /// How often the last factor came again.
    again: u32,
}

impl<const N: usize> LogOfProduct<N> {
    /// A product in here can be multiplied by [`Self::UNSEEN`] sensible variances.
    const FAR_FROM_OVERFLOW: core::ops::Range<f64> = 1e-100..1e100;

    /// The product of so many variances of up to 1e25 is less than 1e200.
    const UNSEEN: u32 = 8;

    fn new() -> Self {
        Self {
            product: Lanes::all(1.0),
            factors: 0,
            log: Lanes::ZERO,
            last: Lanes::all(1.0),
            again: 0,
        }
    }

    #[inline(always)]
    fn multiply(&mut self, factor: Lanes<N>) {
        if self.again > 0 {
            self.log += self.last.map(log) * f64::from(self.again);
            self.again = 0;
        }
        self.last = factor;
        self.product *= factor;
        self.factors += 1;
        if self.factors == Self::UNSEEN {
            self.factors = 0;
            let near = |product: &f64| Self::FAR_FROM_OVERFLOW.contains(product);
            if !self.product.0.iter().all(near) {
                self.log += self.product.map(log);
                self.product = Lanes::all(1.0);
            }
        }
    }

    /// Multiplies by the last factor.
    #[inline(always)]
    fn again(&mut self) {
        self.again += 1;
    }

    fn sum(&self) -> Lanes<N> {
        self.log + self.product.map(log) + self.last.map(log) * f64::from(self.again)
    }
}

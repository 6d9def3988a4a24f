//! A Kalman filter that whitens a heading with a disturbance.

use libm::{exp, log};

use super::lanes::Lanes;
use super::responses::{Responses, Step};

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
    pub const NONE: Self = Self {
        relative: 0.0,
        time_constant_s: 1.0,
    };
}

/// The filter for the heading and its columns alike, for N dampings. Variances are in units of the heading noise.
///
/// ```text
/// x = [psi, r, d],  psi' = r,  r' = a22 r + d,  d' = -d/tau + white
/// x <- F x,   P <- F P F^T + Q                                           to the next comparison
/// e = z - x_psi,  S = P_psi,psi + 1/block,  K = P e_psi / S
/// x <- x + K e,   P <- P - K S K^T
/// ```
#[derive(Clone, Debug)]
pub struct Whitening<const N: usize, const COLUMNS: usize> {
    disturbance: Disturbance,
    noise: f64,
    interval_s: f64,
    transition: Transition<N>,
    process: f64,
    covariance: Covariance<N>,
    gain: [Lanes<N>; 3],
    states: [[Lanes<N>; 3]; COLUMNS],
    precision: Lanes<N>,
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
                step: Step {
                    decay: none,
                    rate_gain_s: none,
                    heading_gain_s2: none,
                },
                memory: 0.0,
            },
            process: 0.0,
            covariance: Covariance {
                psi: [none; 3],
                r: [none; 2],
                d: variance,
            },
            gain: [none; 3],
            states: [[none; 3]; COLUMNS],
            precision: none,
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
        self.covariance = Covariance {
            psi: [noise, from_headings * noise, none],
            r: [
                from_headings * from_headings * noise * 2.0
                    + from_disturbance * from_disturbance * power,
                from_disturbance * power * memory,
            ],
            d: power,
        };
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
        let [to_heading, to_rate, to_disturbance] = self.gain;
        let mut innovations = *columns;
        for (state, innovation) in self.states.iter_mut().zip(&mut innovations) {
            let [psi, r, d] = self.transition.of(*state);
            let e = *innovation - psi;
            *innovation = e;
            *state = [
                psi + to_heading * e,
                r + to_rate * e,
                d + to_disturbance * e,
            ];
        }
        innovations
    }

    /// 1/S of the latest innovations.
    pub fn precision(&self) -> Lanes<N> {
        self.precision
    }

    /// sum log S of all innovations.
    pub fn log_variances(&self) -> [f64; N] {
        self.log_variances.sum().0
    }

    fn set_interval(&mut self, interval_s: f64, responses: &Responses<N>) {
        let memory = exp(-interval_s / self.disturbance.time_constant_s);
        self.transition = Transition {
            step: responses.step_over(interval_s),
            memory,
        };
        self.process =
            self.disturbance.relative * self.disturbance.relative * (1.0 - memory * memory);
        self.interval_s = interval_s;
        self.steady = false;
    }

    fn update_gain(&mut self) {
        let mut p = self.transition.of_covariance(&self.covariance);
        p.d += Lanes::all(self.process);
        let variance = p.psi[0] + Lanes::all(self.noise);
        let precision = Lanes::all(1.0) / variance;
        let gain = p.psi.map(|of_psi| of_psi * precision);
        let is_same = |new: Lanes<N>, old: Lanes<N>| {
            (new.0.iter().zip(old.0)).all(|(new, old)| (new - old).abs() <= STEADY * new.abs())
        };
        self.steady = is_same(precision, self.precision)
            && (gain.iter().zip(self.gain)).all(|(new, old)| is_same(*new, old));
        self.precision = precision;
        self.log_variances.multiply(variance);
        self.covariance = p.given(&gain);
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

    /// F P F^T.
    #[inline(always)]
    fn of_covariance(&self, p: &Covariance<N>) -> Covariance<N> {
        let [_, psi_r, psi_d] = p.psi;
        let [r_r, r_d] = p.r;
        // The columns of F P; its rows are those of P F^T.
        let [psi_0, r_0, d_0] = self.of(p.psi);
        let [psi_1, r_1, d_1] = self.of([psi_r, r_r, r_d]);
        let [psi_2, r_2, d_2] = self.of([psi_d, r_d, p.d]);
        let [_, r_r, r_d] = self.of([r_0, r_1, r_2]);
        let [.., d] = self.of([d_0, d_1, d_2]);
        Covariance {
            psi: self.of([psi_0, psi_1, psi_2]),
            r: [r_r, r_d],
            d,
        }
    }
}

/// The symmetric P, above its diagonal.
#[derive(Clone, Copy, Debug)]
struct Covariance<const N: usize> {
    /// Covariances of the heading with heading, yaw rate and disturbance.
    psi: [Lanes<N>; 3],
    /// Covariances of the yaw rate with itself and the disturbance.
    r: [Lanes<N>; 2],
    d: Lanes<N>,
}

impl<const N: usize> Covariance<N> {
    /// P - K S K^T, where K S is the first column of P.
    #[inline(always)]
    fn given(&self, gain: &[Lanes<N>; 3]) -> Self {
        let [k_psi, k_r, k_d] = *gain;
        let [psi_psi, psi_r, psi_d] = self.psi;
        Self {
            psi: [
                psi_psi - k_psi * psi_psi,
                psi_r - k_psi * psi_r,
                psi_d - k_psi * psi_d,
            ],
            r: [self.r[0] - k_r * psi_r, self.r[1] - k_r * psi_d],
            d: self.d - k_d * psi_d,
        }
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

//! A Kalman filter that whitens a heading with a disturbance.

use libm::{exp, log};

use super::lanes::Lanes;
use super::responses::{Responses, Step};

/// Change of the variances of the heading, by this share of them, under which the filter counts as steady.
const STEADY: f64 = 1e-8;

/// A change of the interval by this share of it does not change the filter: clock jitter.
const SAME_INTERVAL: f64 = 1e-6;

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
/// e = z - x_psi,  S = P_psi,psi + 1/block,  K = P e_psi / S
/// x <- F (x + K e),   P <- F (P - K S K^T) F^T + Q
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
    variance: Lanes<N>,
    precision: Lanes<N>,
    log_variances: LogOfProduct<N>,
    steady: bool,
}

impl<const N: usize, const COLUMNS: usize> Whitening<N, COLUMNS> {
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
            variance: none,
            precision: none,
            log_variances: LogOfProduct::new(),
            steady: false,
        }
    }

    /// The gain at one comparison, after which `interval_s` pass.
    #[inline(always)]
    pub fn step(&mut self, interval_s: f64, responses: &Responses<N>) {
        let jitter_s = (interval_s - self.interval_s).abs();
        if jitter_s > SAME_INTERVAL * interval_s || self.interval_s.is_nan() {
            self.set_interval(interval_s, responses);
        }
        if !self.steady {
            self.update_gain();
        }
        self.log_variances.multiply(self.variance);
    }

    /// The innovations of some columns at this comparison; predicts the next.
    #[inline(always)]
    pub fn innovations<const M: usize>(
        &mut self,
        columns: [usize; M],
        means: &[Lanes<N>; COLUMNS],
    ) -> [Lanes<N>; M] {
        let [to_heading, to_rate, to_disturbance] = self.gain;
        let mut innovations = [Lanes::ZERO; M];
        for (column, innovation) in columns.into_iter().zip(&mut innovations) {
            let [psi, r, d] = self.states[column];
            let e = means[column] - psi;
            *innovation = e;
            self.states[column] = self.transition.of([
                psi + to_heading * e,
                r + to_rate * e,
                d + to_disturbance * e,
            ]);
        }
        innovations
    }

    /// 1/S of the latest innovations.
    pub fn precision(&self) -> Lanes<N> {
        self.precision
    }

    /// sum log S of all innovations.
    pub fn log_variances(&self) -> [f64; N] {
        self.log_variances.sum()
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
        let p = &self.covariance;
        let variance = p.psi[0] + Lanes::all(self.noise);
        self.variance = variance;
        self.precision = Lanes::all(1.0) / variance;
        let [psi_psi, psi_r, psi_d] = p.psi;
        self.gain = [
            psi_psi * self.precision,
            psi_r * self.precision,
            psi_d * self.precision,
        ];
        let mut next = self.transition.of_covariance(&p.given(&self.gain));
        next.d += Lanes::all(self.process);
        let is_same = |next: Lanes<N>, now: Lanes<N>| {
            (next.0.iter().zip(now.0)).all(|(next, now)| (next - now).abs() <= STEADY * next)
        };
        self.steady = is_same(next.psi[0], psi_psi) && is_same(next.psi[1], psi_r);
        self.covariance = next;
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
    log: Lanes<N>,
}

impl<const N: usize> LogOfProduct<N> {
    /// A product in here can be multiplied by any sensible variance.
    const FAR_FROM_OVERFLOW: core::ops::Range<f64> = 1e-100..1e100;

    fn new() -> Self {
        Self {
            product: Lanes::all(1.0),
            log: Lanes::ZERO,
        }
    }

    #[inline(always)]
    fn multiply(&mut self, factor: Lanes<N>) {
        self.product *= factor;
        let near = |product: &f64| Self::FAR_FROM_OVERFLOW.contains(product);
        if !self.product.0.iter().all(near) {
            *self = Self {
                product: Lanes::all(1.0),
                log: Lanes(self.sum()),
            };
        }
    }

    fn sum(&self) -> [f64; N] {
        (self.log + self.product.map(log)).0
    }
}

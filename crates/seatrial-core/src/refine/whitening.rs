//! A record whitened by a Kalman filter: the likelihood of a damping and a disturbance.

use libm::{exp, log, sqrt};

use crate::model::{Discretisation, YawState};

/// Columns of the linear model besides the heading: b2, C0, psi0, r0.
const COLUMNS: usize = 4;

/// Change of the innovation variance under which the filter counts as steady.
const STEADY: f64 = 1e-12;

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

/// A record made ready: intervals, unwrapped headings, rudder, in blocks.
///
/// A block of samples is compared by its mean heading. All columns of the model are averaged alike, so the
/// rudder acts exactly whatever the length of a block.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a> {
    /// From each sample to the next, s; 0 for the last.
    pub interval_s: &'a [f64],
    /// Unwrapped headings, rad.
    pub heading_rad: &'a [f64],
    /// The rudder from each sample to the next, rad.
    pub rudder_rad: &'a [f64],
    /// Samples that make one comparison.
    pub block: usize,
}

/// What generalised least squares gives at one damping and one disturbance.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// b2, C0, psi0, r0.
    pub linear: [f64; COLUMNS],
    /// Covariance of `linear` over the variance of the heading noise.
    pub scaled_covariance: [[f64; COLUMNS]; COLUMNS],
    /// Sum of squares of the whitened residual, rad^2.
    pub residual: f64,
    /// Variance of the heading noise of one sample, rad^2.
    pub noise_variance_rad2: f64,
    /// Restricted log likelihood, up to a constant of the record.
    pub log_likelihood: f64,
}

impl Series<'_> {
    /// Number of comparisons.
    pub fn blocks(&self) -> usize {
        self.heading_rad.len() / self.block.max(1)
    }

    /// Half of the rudder's range, rad.
    pub fn rudder_amplitude_rad(&self) -> f64 {
        let (low, high) = self
            .rudder_rad
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rudder| {
                (low.min(*rudder), high.max(*rudder))
            });
        0.5 * (high - low)
    }

    /// Generalised least squares of b2, C0, psi0 and r0 for a given damping and disturbance.
    ///
    /// ```text
    /// psi_k = b2 psi_b + C0 psi_c + psi0 + r0 psi_r + (disturbance) + noise
    /// x = [psi, r, d],  psi' = r,  r' = a22 r + d,  d' = -d/tau + white       the filter's state
    /// e_k = z_k - x_psi,  S_k = P_psi,psi + 1                                 for z = psi and for each column
    /// ```
    ///
    /// The record given a22 is linear in the rest, so one filter whitens the heading and its four columns
    /// alike; b2, C0, psi0, r0 and the noise follow in closed form from the Gram matrix of the
    /// whitened columns. The restricted log likelihood is
    /// -1/2 [(n - 4) log(RSS) + sum log S_k + log |X^T X|].
    ///
    /// `None` where the columns are not independent: nothing to estimate from.
    pub fn fit(&self, a22_per_s: f64, disturbance: Disturbance) -> Option<Fit> {
        let mut whitening = Whitening::new(a22_per_s, disturbance, self.block);
        let mut gram = [[0.0; COLUMNS + 1]; COLUMNS + 1];
        let mut log_variances = 0.0;
        self.for_each_comparison(a22_per_s, |means, block_s| {
            let white = whitening.update(means, block_s);
            log_variances += whitening.log_variance;
            for (i, row) in gram.iter_mut().enumerate() {
                for (element, other) in row.iter_mut().zip(white).skip(i) {
                    *element += white[i] * other;
                }
            }
        });
        self.solve(&gram, log_variances)
    }

    /// The whitened residual of each comparison, rad: white noise where nothing is left to explain.
    pub fn for_each_innovation(
        &self,
        a22_per_s: f64,
        disturbance: Disturbance,
        fit: &Fit,
        mut take: impl FnMut(f64),
    ) {
        let mut whitening = Whitening::new(a22_per_s, disturbance, self.block);
        self.for_each_comparison(a22_per_s, |means, block_s| {
            let white = whitening.update(means, block_s);
            let explained: f64 = white.iter().zip(&fit.linear).map(|(w, l)| w * l).sum();
            take(white[COLUMNS] - explained);
        });
    }

    /// The means over each block of the responses to b2, C0, psi0 and r0, and of the heading, and the length of
    /// the block, s.
    pub fn for_each_comparison(
        &self,
        a22_per_s: f64,
        mut compare: impl FnMut([f64; COLUMNS + 1], f64),
    ) {
        let block = self.block.max(1);
        let share = 1.0 / block as f64;
        let mut columns = Columns::new(a22_per_s);
        let blocks = self
            .interval_s
            .chunks_exact(block)
            .zip(self.heading_rad.chunks_exact(block))
            .zip(self.rudder_rad.chunks_exact(block));
        for ((interval_s, heading_rad), rudder_rad) in blocks {
            let mut sums = [0.0; COLUMNS + 1];
            let mut block_s = 0.0;
            for ((interval_s, heading_rad), rudder_rad) in
                interval_s.iter().zip(heading_rad).zip(rudder_rad)
            {
                let [b, c, psi, r] = columns.now();
                for (sum, value) in sums.iter_mut().zip([b, c, psi, r, *heading_rad]) {
                    *sum += value;
                }
                columns.advance(*interval_s, *rudder_rad);
                block_s += interval_s;
            }
            compare(sums.map(|sum| sum * share), block_s);
        }
    }

    fn solve(&self, gram: &[[f64; COLUMNS + 1]; COLUMNS + 1], log_variances: f64) -> Option<Fit> {
        let degrees_of_freedom = self.blocks().checked_sub(COLUMNS + 1)? as f64;
        let scale: [f64; COLUMNS] = core::array::from_fn(|i| sqrt(gram[i][i]));
        if !scale.iter().all(|s| *s > 0.0) {
            return None;
        }
        let scaled = core::array::from_fn(|i| {
            core::array::from_fn(|j| gram[i.min(j)][i.max(j)] / (scale[i] * scale[j]))
        });
        let factor = Cholesky::of(&scaled)?;
        let right: [f64; COLUMNS] = core::array::from_fn(|i| gram[i][COLUMNS] / scale[i]);
        let solution = factor.solve(right);
        let explained: f64 = right.iter().zip(&solution).map(|(r, s)| r * s).sum();
        let total = gram[COLUMNS][COLUMNS];
        // Rounding of the sums is all that is left of noise-free data.
        let residual = (total - explained).max(f64::EPSILON * f64::EPSILON + 1e-15 * total);
        let log_determinant =
            factor.log_determinant() + 2.0 * scale.iter().map(|s| log(*s)).sum::<f64>();
        let inverse = factor.inverse();
        Some(Fit {
            linear: core::array::from_fn(|i| solution[i] / scale[i]),
            scaled_covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| inverse[i][j] / (scale[i] * scale[j]))
            }),
            residual,
            noise_variance_rad2: residual / degrees_of_freedom,
            log_likelihood: -0.5
                * (degrees_of_freedom * log(residual) + log_variances + log_determinant),
        })
    }
}

/// A = L L^T.
struct Cholesky([[f64; COLUMNS]; COLUMNS]);

impl Cholesky {
    /// `None` where the matrix is not positive definite.
    fn of(matrix: &[[f64; COLUMNS]; COLUMNS]) -> Option<Self> {
        let mut l = [[0.0; COLUMNS]; COLUMNS];
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                let left = matrix[i][j] - below(j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                if j < i {
                    l[i][j] = left / l[j][j];
                } else if j == i && left > 0.0 {
                    l[i][i] = sqrt(left);
                } else if j == i {
                    return None;
                }
            }
        }
        Some(Self(l))
    }

    fn log_determinant(&self) -> f64 {
        (0..COLUMNS).map(|i| 2.0 * log(self.0[i][i])).sum()
    }

    /// A^-1 b.
    fn solve(&self, mut b: [f64; COLUMNS]) -> [f64; COLUMNS] {
        let Self(l) = self;
        for i in 0..COLUMNS {
            b[i] = (b[i] - below(i).map(|k| l[i][k] * b[k]).sum::<f64>()) / l[i][i];
        }
        for i in (0..COLUMNS).rev() {
            let above = (0..COLUMNS).filter(|k| *k > i);
            b[i] = (b[i] - above.map(|k| l[k][i] * b[k]).sum::<f64>()) / l[i][i];
        }
        b
    }

    fn inverse(&self) -> [[f64; COLUMNS]; COLUMNS] {
        core::array::from_fn(|i| {
            self.solve(core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
        })
    }
}

/// Columns left of the j-th, written so that the compiler sees them within bounds.
fn below(j: usize) -> impl Iterator<Item = usize> {
    (0..COLUMNS).filter(move |k| *k < j)
}

/// The responses of the heading to b2, C0, psi0 and r0.
struct Columns {
    a22_per_s: f64,
    step: Discretisation<f64>,
    interval_s: f64,
    to_rudder: YawState<f64>,
    to_offset: YawState<f64>,
    to_rate: YawState<f64>,
}

impl Columns {
    fn new(a22_per_s: f64) -> Self {
        Self {
            a22_per_s,
            step: Discretisation::new(a22_per_s, 0.0),
            interval_s: 0.0,
            to_rudder: YawState::default(),
            to_offset: YawState::default(),
            to_rate: YawState {
                heading_rad: 0.0,
                yaw_rate_rad_s: 1.0,
            },
        }
    }

    fn now(&self) -> [f64; COLUMNS] {
        [
            self.to_rudder.heading_rad,
            self.to_offset.heading_rad,
            1.0,
            self.to_rate.heading_rad,
        ]
    }

    fn advance(&mut self, interval_s: f64, rudder_rad: f64) {
        if interval_s != self.interval_s {
            self.step = Discretisation::new(self.a22_per_s, interval_s);
            self.interval_s = interval_s;
        }
        self.to_rudder = self.step.advance(self.to_rudder, rudder_rad);
        self.to_offset = self.step.advance(self.to_offset, 1.0);
        self.to_rate = self.step.advance(self.to_rate, 0.0);
    }
}

/// One Kalman filter for the heading and its columns. Variances are in units of the heading noise.
struct Whitening {
    a22_per_s: f64,
    disturbance: Disturbance,
    noise: f64,
    covariance: [[f64; 3]; 3],
    states: [[f64; 3]; COLUMNS + 1],
    transition: [[f64; 3]; 3],
    process: f64,
    interval_s: f64,
    gain: [f64; 3],
    deviation: f64,
    variance: f64,
    log_variance: f64,
    steady: bool,
}

impl Whitening {
    fn new(a22_per_s: f64, disturbance: Disturbance, block: usize) -> Self {
        let mut covariance = [[0.0; 3]; 3];
        covariance[2][2] = disturbance.relative * disturbance.relative;
        Self {
            a22_per_s,
            disturbance,
            noise: 1.0 / block as f64,
            covariance,
            states: [[0.0; 3]; COLUMNS + 1],
            transition: [[0.0; 3]; 3],
            process: 0.0,
            interval_s: f64::NAN,
            gain: [0.0; 3],
            deviation: 0.0,
            variance: 0.0,
            log_variance: 0.0,
            steady: false,
        }
    }

    /// Whitens one comparison and predicts the next, `interval_s` later.
    fn update(&mut self, values: [f64; COLUMNS + 1], interval_s: f64) -> [f64; COLUMNS + 1] {
        // Clock jitter of a millionth does not change the filter.
        if (interval_s - self.interval_s).abs() > 1e-6 * interval_s || self.interval_s.is_nan() {
            self.set_interval(interval_s);
        }
        if !self.steady {
            self.update_gain();
        }
        let mut white = [0.0; COLUMNS + 1];
        for ((state, value), white) in self.states.iter_mut().zip(values).zip(&mut white) {
            let innovation = value - state[0];
            *white = innovation / self.deviation;
            let updated: [f64; 3] = core::array::from_fn(|i| state[i] + self.gain[i] * innovation);
            *state = times(&self.transition, &updated);
        }
        white
    }

    fn set_interval(&mut self, interval_s: f64) {
        let step = Discretisation::new(self.a22_per_s, interval_s);
        let memory = exp(-interval_s / self.disturbance.time_constant_s);
        self.transition = [
            [1.0, step.rate_gain_s, step.heading_gain_s2],
            [0.0, step.decay, step.rate_gain_s],
            [0.0, 0.0, memory],
        ];
        self.process =
            self.disturbance.relative * self.disturbance.relative * (1.0 - memory * memory);
        self.interval_s = interval_s;
        self.steady = false;
    }

    /// Riccati step: P <- F (P - K S K^T) F^T + Q.
    fn update_gain(&mut self) {
        let p = &self.covariance;
        let variance = p[0][0] + self.noise;
        self.steady = (variance - self.variance).abs() <= STEADY * variance;
        self.variance = variance;
        self.deviation = sqrt(variance);
        self.log_variance = log(variance);
        self.gain = core::array::from_fn(|i| p[i][0] / variance);
        let updated: [[f64; 3]; 3] =
            core::array::from_fn(|i| core::array::from_fn(|j| p[i][j] - self.gain[i] * p[0][j]));
        let half: [[f64; 3]; 3] = core::array::from_fn(|i| times(&self.transition, &updated[i]));
        // half[i] is F times row i of the symmetric P, so its transpose is F P.
        self.covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let row = &self.transition[j];
                (0..3).map(|l| half[l][i] * row[l]).sum()
            })
        });
        self.covariance[2][2] += self.process;
    }
}

fn times(matrix: &[[f64; 3]; 3], vector: &[f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * vector[j]).sum())
}

//! A record whitened by a Kalman filter: the likelihood of a damping and a disturbance.

use nalgebra::{Cholesky, Matrix4, Vector4};
use seatrial_core::model::{Discretisation, YawState};
use seatrial_core::{LostRudder, Real, Sample};

use crate::record::median_interval_s;

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

/// A training record made ready: intervals, headings relative to the first, rudder, in blocks.
///
/// A block of samples is compared by its mean heading. All columns of the model are averaged alike, so the
/// rudder acts exactly whatever the length of a block.
#[derive(Clone, Debug)]
pub struct Prepared {
    pub(super) interval_s: Vec<f64>,
    pub(super) heading_rad: Vec<f64>,
    pub(super) rudder_rad: Vec<f64>,
    pub(super) block: usize,
}

/// What generalised least squares gives at one damping and one disturbance.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// b2, C0, psi0, r0.
    pub linear: Vector4<f64>,
    /// Covariance of `linear` over the variance of the heading noise.
    pub scaled_covariance: Matrix4<f64>,
    /// Sum of squares of the whitened residual, rad^2.
    pub residual: f64,
    /// Variance of the heading noise of one sample, rad^2.
    pub noise_variance_rad2: f64,
    /// Restricted log likelihood, up to a constant of the record.
    pub log_likelihood: f64,
}

impl Prepared {
    /// `samples` are finite and increase in time; `block` samples are averaged for one comparison.
    pub fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let mut heading_rad = Vec::with_capacity(samples.len());
        let mut last = samples.first().map_or(0.0, |s| s.heading_rad);
        let mut heading = 0.0;
        for sample in samples {
            heading += (sample.heading_rad - last).wrapped();
            last = sample.heading_rad;
            heading_rad.push(heading);
        }
        Self::from_headings(samples, heading_rad, block)
    }

    /// The same with other headings, unwrapped, than those of the samples.
    pub fn from_headings(samples: &[Sample<f64>], heading_rad: Vec<f64>, block: usize) -> Self {
        Self {
            interval_s: samples
                .windows(2)
                .map(|pair| pair[1].time_s - pair[0].time_s)
                .chain([0.0])
                .collect(),
            heading_rad,
            rudder_rad: mean_rudder_rad(samples),
            block: block.max(1),
        }
    }

    /// Number of comparisons.
    pub fn blocks(&self) -> usize {
        self.heading_rad.len() / self.block
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
            let (white, variance) = whitening.update(means, block_s);
            log_variances += variance.ln();
            for (i, row) in gram.iter_mut().enumerate() {
                for (j, element) in row.iter_mut().enumerate().skip(i) {
                    *element += white[i] * white[j];
                }
            }
        });
        self.solve(&gram, log_variances)
    }

    /// The whitened residual of each comparison, rad: white noise where nothing is left to explain.
    pub(super) fn innovations(
        &self,
        a22_per_s: f64,
        disturbance: Disturbance,
        fit: &Fit,
    ) -> Vec<f64> {
        let mut whitening = Whitening::new(a22_per_s, disturbance, self.block);
        let mut innovations = Vec::with_capacity(self.blocks());
        self.for_each_comparison(a22_per_s, |means, block_s| {
            let (white, _) = whitening.update(means, block_s);
            let explained: f64 = white.iter().zip(&fit.linear).map(|(w, l)| w * l).sum();
            innovations.push(white[COLUMNS] - explained);
        });
        innovations
    }

    /// Mean rudder of each comparison, rad.
    pub(super) fn mean_rudder_rad(&self) -> Vec<f64> {
        let mean = |block: &[f64]| block.iter().sum::<f64>() / block.len() as f64;
        self.rudder_rad.chunks_exact(self.block).map(mean).collect()
    }

    /// The means over each block of the responses to b2, C0, psi0 and r0, and of the heading.
    pub(super) fn comparisons(&self, a22_per_s: f64) -> Vec<[f64; COLUMNS + 1]> {
        let mut rows = Vec::with_capacity(self.blocks());
        self.for_each_comparison(a22_per_s, |means, _| rows.push(means));
        rows
    }

    /// The means of the four columns and of the heading over each block, and the length of the block, s.
    fn for_each_comparison(
        &self,
        a22_per_s: f64,
        mut compare: impl FnMut([f64; COLUMNS + 1], f64),
    ) {
        let mut columns = Columns::new(a22_per_s);
        for block in 0..self.blocks() {
            let mut sums = [0.0; COLUMNS + 1];
            let mut block_s = 0.0;
            for k in block * self.block..(block + 1) * self.block {
                let heading = [self.heading_rad[k]];
                for (sum, value) in sums.iter_mut().zip(columns.now().iter().chain(&heading)) {
                    *sum += value;
                }
                columns.advance(self.interval_s[k], self.rudder_rad[k]);
                block_s += self.interval_s[k];
            }
            compare(sums.map(|sum| sum / self.block as f64), block_s);
        }
    }

    fn solve(&self, gram: &[[f64; COLUMNS + 1]; COLUMNS + 1], log_variances: f64) -> Option<Fit> {
        let degrees_of_freedom = self.blocks().checked_sub(COLUMNS + 1)? as f64;
        let normal = Matrix4::from_fn(|i, j| gram[i.min(j)][i.max(j)]);
        let scale = Vector4::from_fn(|i, _| normal[(i, i)].sqrt());
        if !scale.iter().all(|s| *s > 0.0) {
            return None;
        }
        let scaled = Matrix4::from_fn(|i, j| normal[(i, j)] / (scale[i] * scale[j]));
        let factor = Cholesky::new(scaled)?;
        let right = Vector4::from_fn(|i, _| gram[i][COLUMNS] / scale[i]);
        let solution = factor.solve(&right);
        let total = gram[COLUMNS][COLUMNS];
        // Rounding of the sums is all that is left of noise-free data.
        let residual =
            (total - right.dot(&solution)).max(f64::EPSILON * f64::EPSILON + 1e-15 * total);
        let log_determinant =
            2.0 * factor.l().diagonal().map(f64::ln).sum() + 2.0 * scale.map(f64::ln).sum();
        let inverse = factor.inverse();
        Some(Fit {
            linear: solution.component_div(&scale),
            scaled_covariance: Matrix4::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j])),
            residual,
            noise_variance_rad2: residual / degrees_of_freedom,
            log_likelihood: -0.5
                * (degrees_of_freedom * residual.ln() + log_variances + log_determinant),
        })
    }
}

/// The rudder over each interval, rad: held, or, where samples were lost and it moved a little, the mean of what
/// goes to the next sample in equal steps. When it moved far, at an edge of the manoeuvre, nobody knows when, and
/// it counts as held.
pub(super) fn mean_rudder_rad(samples: &[Sample<f64>]) -> Vec<f64> {
    let usual_s = median_interval_s(samples).unwrap_or(0.0);
    let over = |pair: &[Sample<f64>]| {
        let interval_s = pair[1].time_s - pair[0].time_s;
        let moved_rad = pair[1].rudder_rad - pair[0].rudder_rad;
        let lost = LostRudder::Interpolated;
        if lost.hides_edge(interval_s, usual_s, moved_rad) {
            return pair[0].rudder_rad;
        }
        let steps = f64::from(lost.steps(interval_s, usual_s));
        pair[0].rudder_rad + moved_rad * (steps - 1.0) / (2.0 * steps)
    };
    let last = samples.last().map(|s| s.rudder_rad);
    samples.windows(2).map(over).chain(last).collect()
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
    variance: f64,
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
            variance: 0.0,
            steady: false,
        }
    }

    /// Whitens one comparison and predicts the next, `interval_s` later. Gives the white values and the
    /// innovation variance.
    fn update(&mut self, values: [f64; COLUMNS + 1], interval_s: f64) -> ([f64; COLUMNS + 1], f64) {
        // Clock jitter of a millionth does not change the filter.
        if (interval_s - self.interval_s).abs() > 1e-6 * interval_s || self.interval_s.is_nan() {
            self.set_interval(interval_s);
        }
        if !self.steady {
            self.update_gain();
        }
        let deviation = self.variance.sqrt();
        let mut white = [0.0; COLUMNS + 1];
        for ((state, value), white) in self.states.iter_mut().zip(values).zip(&mut white) {
            let innovation = value - state[0];
            *white = innovation / deviation;
            let updated: [f64; 3] = core::array::from_fn(|i| state[i] + self.gain[i] * innovation);
            *state = times(&self.transition, &updated);
        }
        (white, self.variance)
    }

    fn set_interval(&mut self, interval_s: f64) {
        let step = Discretisation::new(self.a22_per_s, interval_s);
        let memory = (-interval_s / self.disturbance.time_constant_s).exp();
        self.transition = [
            [1.0, step.rate_gain_s, step.heading_gain_s2],
            [0.0, step.decay, step.rate_gain_s],
            [0.0, 0.0, memory],
        ];
        self.process = self.disturbance.relative.powi(2) * (1.0 - memory * memory);
        self.interval_s = interval_s;
        self.steady = false;
    }

    /// Riccati step: P <- F (P - K S K^T) F^T + Q.
    fn update_gain(&mut self) {
        let p = &self.covariance;
        let variance = p[0][0] + self.noise;
        self.steady = (variance - self.variance).abs() <= STEADY * variance;
        self.variance = variance;
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

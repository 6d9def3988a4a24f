//! The likelihood of a record under a sway-yaw model and a yaw acceleration disturbance, and its peak.

use nalgebra::{DMatrix, DVector, SMatrix};
use seatrial_core::refine::Disturbance;
use seatrial_core::{LostRudder, Real, Sample};

use crate::identify::record_series::mean_rudder_rad;
use crate::record::median_interval_s;
use crate::sway_yaw::model::{Rudder, Steps, SwayYawModel, SwayYawState};

/// Parameters: a22, b2, C0, a21, a11, k, T_d, psi0, r0.
pub(super) const PARAMETERS: usize = 9;
pub(super) const A22: usize = 0;
pub(super) const B2: usize = 1;
pub(super) const C0: usize = 2;
pub(super) const A21: usize = 3;
pub(super) const A11: usize = 4;
pub(super) const CROSS_FLOW: usize = 5;
pub(super) const LAG: usize = 6;
pub(super) const HEADING: usize = 7;
pub(super) const YAW_RATE: usize = 8;

/// The parameters of the model and its state at the first sample, where sway has not begun.
pub(super) type Theta = [f64; PARAMETERS];

pub(super) fn model_of(theta: &Theta) -> SwayYawModel {
    SwayYawModel {
        a22_per_s: theta[A22],
        b2_per_s2: theta[B2],
        c0_rad_per_s2: theta[C0],
        a21_per_s2: theta[A21],
        a11_per_s: theta[A11],
        cross_flow_per_rad_s: theta[CROSS_FLOW],
        rudder_lag_s: theta[LAG],
    }
}

/// A record in comparisons: means over blocks of samples, as in [`crate::identify::record_series`].
pub(super) struct Comparisons {
    interval_s: Vec<f64>,
    heading_rad: Vec<f64>,
    rudder_rad: Vec<f64>,
    /// Rows of a comparison.
    block: usize,
    /// Were samples lost?
    pub(super) has_gaps: bool,
    floor_rad2: f64,
    /// Sway decays at these rates, 1/s.
    slowest_sway_per_s: f64,
    fastest_sway_per_s: f64,
}

/// A residual of this share of the heading's range is the integration's own: no order is decided by it.
const FLOOR_SHARE: f64 = 1e-6;

/// A sway that remembers for longer than this share of the record cannot be distinguished from a drifting disturbance, one
/// that forgets within a comparison not from damping.
const LONGEST_MEMORY_SHARE: f64 = 1.0 / 8.0;

/// Gradient and curvature of a log likelihood.
pub(super) struct Likelihood {
    /// -1/2 [n log(RSS/n + floor) + sum log S_k].
    pub(super) log: f64,
    /// Whitened residual of each comparison, rad.
    pub(super) innovations: Vec<f64>,
    residual: f64,
    /// X^T e and X^T X of the whitened sensitivities X.
    gradient: SMatrix<f64, PARAMETERS, 1>,
    information: SMatrix<f64, PARAMETERS, PARAMETERS>,
}

/// The largest likelihood of a structure at one disturbance.
pub(super) struct Summit {
    pub(super) theta: Theta,
    pub(super) disturbance: Disturbance,
    pub(super) likelihood: Likelihood,
}

impl Comparisons {
    pub(super) fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let mut heading = 0.0;
        let turns = samples
            .windows(2)
            .map(|pair| Real::wrapped(pair[1].heading_rad - pair[0].heading_rad));
        let heading_rad: Vec<f64> = std::iter::once(0.0)
            .chain(turns)
            .map(|turn| {
                heading += turn;
                heading
            })
            .collect();
        let usual_s = median_interval_s(samples).unwrap_or(0.0);
        let is_gap = |pair: &[Sample<f64>]| {
            let interval_s = pair[1].time_s - pair[0].time_s;
            LostRudder::Interpolated.steps(interval_s, usual_s) > 1
        };
        let duration_s = samples.last().map_or(0.0, |s| s.time_s) - samples[0].time_s;
        Self {
            slowest_sway_per_s: 1.0 / (LONGEST_MEMORY_SHARE * duration_s),
            fastest_sway_per_s: samples.len() as f64 / (block as f64 * duration_s),
            interval_s: samples
                .windows(2)
                .map(|pair| pair[1].time_s - pair[0].time_s)
                .chain([0.0])
                .collect(),
            has_gaps: samples.windows(2).any(is_gap),
            floor_rad2: (FLOOR_SHARE * range(&heading_rad)).powi(2),
            heading_rad,
            rudder_rad: mean_rudder_rad(samples, usual_s),
            block,
        }
    }

    pub(super) fn count(&self) -> usize {
        self.interval_s.len() / self.block
    }

    /// Mean rudder of each comparison, rad.
    pub(super) fn rudder_rad(&self) -> Vec<f64> {
        self.rudder_rad
            .chunks_exact(self.block)
            .map(mean_of)
            .collect()
    }

    /// Largest less smallest heading, rad.
    pub(super) fn range_rad(&self) -> f64 {
        range(&self.heading_rad)
    }

    /// The likelihood of a model and a disturbance d of the yaw acceleration.
    ///
    /// ```text
    /// e_k = z_k - x_psi,  S_k = P_psi,psi + 1
    /// x+ = [F g; 0 m] (x + K e),  F = dx+/dx, g = dx+/d(yaw acceleration) along the simulation
    /// ```
    ///
    /// z is the measured less the simulated heading, and each of its sensitivities: a Kalman filter linearised on the
    /// simulation whitens all of them alike. Sensitivities to parameters that are not `free` may be left out. `None` where the simulation
    /// runs away.
    pub(super) fn likelihood(
        &self,
        theta: &Theta,
        free: &[usize],
        disturbance: Disturbance,
    ) -> Option<Likelihood> {
        let is_linear = !free.contains(&CROSS_FLOW) && theta[CROSS_FLOW] == 0.0;
        let mut simulation = Simulation::new(theta, is_linear, &self.rudder_rad);
        let mut whitening = Whitening::new(disturbance, self.block);
        let mut gram = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
        let mut log_variances = 0.0;
        let mut innovations = Vec::with_capacity(self.count());
        for block in 0..self.count() {
            let mut row = [0.0; COLUMNS];
            let mut passage = Passage::NONE;
            for k in block * self.block..(block + 1) * self.block {
                simulation.add_row(self.heading_rad[k], &mut row);
                passage = simulation
                    .advance(self.interval_s[k], self.rudder_rad[k])
                    .after(&passage);
            }
            row.iter_mut()
                .for_each(|of_row| *of_row /= self.block as f64);
            let (white, variance) = whitening.update(&row, &passage);
            log_variances += variance.ln();
            for (j, of_j) in white.iter().enumerate() {
                for (i, of_i) in white.iter().enumerate() {
                    gram[(i, j)] += of_i * of_j;
                }
            }
            innovations.push(white[PARAMETERS]);
        }
        let residual = gram[(PARAMETERS, PARAMETERS)];
        let n = self.count() as f64;
        let log = -0.5 * (n * (residual / n + self.floor_rad2).ln() + log_variances);
        log.is_finite().then(|| Likelihood {
            log,
            innovations,
            residual,
            gradient: gram.fixed_view::<PARAMETERS, 1>(0, PARAMETERS).into_owned(),
            information: gram.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into_owned(),
        })
    }

    /// Climbs the likelihood in the parameters `free` (Levenberg and Marquardt) from `start`.
    pub(super) fn climb(
        &self,
        start: &Theta,
        free: &[usize],
        disturbance: Disturbance,
        most_steps: u32,
    ) -> Option<Summit> {
        const ARRIVED: f64 = 1e-3;
        /// A step that promises less than this is not tried.
        const WORTH_A_LOOK: f64 = 0.1 * ARRIVED;
        const MOST_DAMPING: f64 = 1e4;
        let mut summit = Summit {
            theta: *start,
            disturbance,
            likelihood: self.likelihood(start, free, disturbance)?,
        };
        let mut damping = 1e-3;
        for _ in 0..most_steps {
            let before = summit.likelihood.log;
            while damping < MOST_DAMPING {
                let (mut theta, promised) = summit.likelihood.step(&summit.theta, free, damping)?;
                if promised < WORTH_A_LOOK {
                    break;
                }
                theta[A11] = theta[A11]
                    .min(-self.slowest_sway_per_s)
                    .max(-self.fastest_sway_per_s);
                match self.likelihood(&theta, free, disturbance) {
                    Some(likelihood) if likelihood.log > before => {
                        summit = Summit {
                            theta,
                            disturbance,
                            likelihood,
                        };
                        damping *= 0.2;
                        break;
                    }
                    _ => damping *= 5.0,
                }
            }
            if summit.likelihood.log - before < ARRIVED {
                break;
            }
        }
        Some(summit)
    }
}

fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn range(values: &[f64]) -> f64 {
    let high = values.iter().copied().fold(f64::MIN, f64::max);
    high - values.iter().copied().fold(f64::MAX, f64::min)
}

impl Likelihood {
    /// A damped Gauss-Newton step, inside what physics allows, and the gain of log likelihood that it promises.
    fn step(&self, theta: &Theta, free: &[usize], damping: f64) -> Option<(Theta, f64)> {
        let (normal, scale) = self.scaled_information(free);
        let right = DVector::from_fn(free.len(), |i, _| self.gradient[free[i]] / scale[i]);
        let damped = &normal + DMatrix::identity(free.len(), free.len()) * damping;
        let step = damped.cholesky()?.solve(&right);
        let explained = 2.0 * right.dot(&step) - step.dot(&(&normal * &step));
        let promised = 0.5 * self.innovations.len() as f64 * explained / self.residual;
        let mut next = *theta;
        for (i, parameter) in free.iter().enumerate() {
            next[*parameter] += step[i] / scale[i];
        }
        next[CROSS_FLOW] = next[CROSS_FLOW].min(0.0);
        next[LAG] = next[LAG].max(0.0);
        Some((next, promised))
    }

    /// Covariance of the parameters `free`, in their order. `None` where the record does not determine them.
    pub(super) fn covariance(&self, free: &[usize]) -> Option<DMatrix<f64>> {
        let degrees_of_freedom = self.innovations.len().checked_sub(free.len() + 1)? as f64;
        let (normal, scale) = self.scaled_information(free);
        let inverse = normal.cholesky()?.inverse();
        let noise = self.residual / degrees_of_freedom;
        Some(DMatrix::from_fn(free.len(), free.len(), |i, j| {
            noise * inverse[(i, j)] / (scale[i] * scale[j])
        }))
    }

    /// Variance of the heading noise of one sample, rad^2.
    pub(super) fn noise_variance_rad2(&self, free: &[usize]) -> f64 {
        self.residual / (self.innovations.len() - free.len().min(self.innovations.len() - 1)) as f64
    }

    /// X^T X with a unit diagonal, and the lengths of the columns of X.
    fn scaled_information(&self, free: &[usize]) -> (DMatrix<f64>, Vec<f64>) {
        let scale: Vec<f64> = free
            .iter()
            .map(|i| self.information[(*i, *i)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let normal = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            self.information[(free[i], free[j])] / (scale[i] * scale[j])
        });
        (normal, scale)
    }
}

/// Sensitivities of the heading to all parameters, and what is left of the measured heading.
const COLUMNS: usize = PARAMETERS + 1;
type Row = [f64; COLUMNS];

/// The simulation of a record with its sensitivities.
struct Simulation {
    model: SwayYawModel,
    steps: Steps,
    rudder: Rudder,
    state: SwayYawState,
    /// Of heading, yaw rate and drift, a row each.
    sensitivities: [[f64; PARAMETERS]; 3],
}

impl Simulation {
    fn new(theta: &Theta, is_linear: bool, rudder_rad: &[f64]) -> Self {
        let mut sensitivities = [[0.0; PARAMETERS]; 3];
        sensitivities[0][HEADING] = 1.0;
        sensitivities[1][YAW_RATE] = 1.0;
        Self {
            model: model_of(theta),
            steps: Steps::new(model_of(theta), is_linear),
            rudder: Rudder::at(rudder_rad.first().copied().unwrap_or(0.0)),
            state: SwayYawState {
                heading_rad: theta[HEADING],
                yaw_rate_rad_s: theta[YAW_RATE],
                drift_rad: 0.0,
            },
            sensitivities,
        }
    }

    /// Adds the sensitivities of the heading, and what is left of the measured one.
    fn add_row(&self, measured_rad: f64, row: &mut Row) {
        for (total, sensitivity) in row.iter_mut().zip(&self.sensitivities[0]) {
            *total += sensitivity;
        }
        row[PARAMETERS] += measured_rad - self.state.heading_rad;
    }

    fn advance(&mut self, interval_s: f64, command_rad: f64) -> Passage {
        if interval_s <= 0.0 {
            return Passage::NONE;
        }
        let mean = self
            .rudder
            .advance(command_rad, interval_s, self.model.rudder_lag_s);
        let step = self.steps.step(self.state, mean.angle_rad, interval_s);
        let (to_state, to_input) = (step.to_state(), step.to_input());
        let to_dynamics = step.to_dynamics();
        let before = self.sensitivities;
        for (i, row) in self.sensitivities.iter_mut().enumerate() {
            let [to_psi, to_r, to_w] = to_state[i];
            for (p, sensitivity) in row.iter_mut().enumerate() {
                *sensitivity = to_psi * before[0][p] + to_r * before[1][p] + to_w * before[2][p];
            }
            for (parameter, column) in [A22, A21, A11, CROSS_FLOW].iter().zip(&to_dynamics) {
                row[*parameter] += column[i];
            }
            row[B2] += mean.angle_rad * to_input[i];
            row[C0] += to_input[i];
            row[LAG] += self.model.b2_per_s2 * mean.to_lag * to_input[i];
        }
        self.state = step.state;
        Passage {
            to_state,
            to_input,
            interval_s,
        }
    }
}

/// How a deviation of the state and a constant yaw acceleration act over some time.
struct Passage {
    to_state: [[f64; 3]; 3],
    to_input: [f64; 3],
    interval_s: f64,
}

impl Passage {
    const NONE: Self = Self {
        to_state: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        to_input: [0.0; 3],
        interval_s: 0.0,
    };

    fn after(&self, earlier: &Self) -> Self {
        let mut both = Self::NONE;
        for (i, [to_psi, to_r, to_w]) in self.to_state.iter().enumerate() {
            let [psi, r, w] = &earlier.to_state;
            for j in 0..3 {
                both.to_state[i][j] = to_psi * psi[j] + to_r * r[j] + to_w * w[j];
            }
            let [psi, r, w] = earlier.to_input;
            both.to_input[i] = to_psi * psi + to_r * r + to_w * w + self.to_input[i];
        }
        both.interval_s = self.interval_s + earlier.interval_s;
        both
    }
}

/// One Kalman filter for the residual and its sensitivities, state [psi, r, w, d]. Variances are in units of
/// the heading noise.
struct Whitening {
    disturbance: Disturbance,
    noise: f64,
    covariance: [[f64; 4]; 4],
    /// psi, r, w and d of every column, a row each.
    states: [Row; 4],
}

impl Whitening {
    fn new(disturbance: Disturbance, block: usize) -> Self {
        let mut covariance = [[0.0; 4]; 4];
        covariance[3][3] = disturbance.relative.powi(2);
        Self {
            disturbance,
            noise: 1.0 / block as f64,
            covariance,
            states: [[0.0; COLUMNS]; 4],
        }
    }

    /// Whitens one comparison and predicts the next. Gives the white row and the innovation variance.
    fn update(&mut self, row: &Row, passage: &Passage) -> (Row, f64) {
        let variance = self.covariance[0][0] + self.noise;
        let mut innovation = *row;
        for (innovation, expected) in innovation.iter_mut().zip(&self.states[0]) {
            *innovation -= expected;
        }
        if self.disturbance.relative > 0.0 {
            let of_heading = self.covariance[0];
            for (i, covariance) in self.covariance.iter_mut().enumerate() {
                let gain = of_heading[i] / variance;
                for (covariance, of_heading) in covariance.iter_mut().zip(&of_heading) {
                    *covariance -= gain * of_heading;
                }
                for (state, innovation) in self.states[i].iter_mut().zip(&innovation) {
                    *state += gain * innovation;
                }
            }
            self.predict(passage);
        }
        let deviation = variance.sqrt();
        innovation
            .iter_mut()
            .for_each(|of_row| *of_row /= deviation);
        (innovation, variance)
    }

    fn predict(&mut self, passage: &Passage) {
        let memory = (-passage.interval_s / self.disturbance.time_constant_s).exp();
        let mut transition = [[0.0; 4]; 4];
        let rows = passage.to_state.iter().zip(&passage.to_input);
        for (row, (to_state, to_input)) in transition.iter_mut().zip(rows) {
            row[..3].copy_from_slice(to_state);
            row[3] = *to_input;
        }
        transition[3][3] = memory;
        self.states = product(&transition, &self.states);
        let moved = transposed(&product(&transition, &self.covariance));
        self.covariance = product(&transition, &moved);
        self.covariance[3][3] += self.disturbance.relative.powi(2) * (1.0 - memory * memory);
    }
}

fn product<const N: usize>(left: &[[f64; 4]; 4], right: &[[f64; N]; 4]) -> [[f64; N]; 4] {
    let mut product = [[0.0; N]; 4];
    for (of_product, of_left) in product.iter_mut().zip(left) {
        for (weight, of_right) in of_left.iter().zip(right) {
            for (total, value) in of_product.iter_mut().zip(of_right) {
                *total += weight * value;
            }
        }
    }
    product
}

fn transposed(matrix: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    core::array::from_fn(|i| core::array::from_fn(|j| matrix[j][i]))
}

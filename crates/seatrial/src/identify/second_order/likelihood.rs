//! The likelihood of a record under a sway-yaw model and a yaw acceleration disturbance, and its peak.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};
use seatrial_core::refine::Disturbance;
use seatrial_core::{LostRudder, Real, Sample};

use crate::identify::record_series::mean_rudder_rad;
use crate::record::median_interval_s;
use crate::sway_yaw::model::{Rudder, SwayYawModel, SwayYawState};

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
        let mean = |block: &[f64]| block.iter().sum::<f64>() / block.len() as f64;
        self.rudder_rad.chunks_exact(self.block).map(mean).collect()
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
    /// simulation whitens all of them alike. `None` where the simulation runs away.
    pub(super) fn likelihood(&self, theta: &Theta, disturbance: Disturbance) -> Option<Likelihood> {
        let mut simulation = Simulation::new(theta, &self.rudder_rad);
        let mut whitening = Whitening::new(disturbance, self.block);
        let mut gram = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
        let mut log_variances = 0.0;
        let mut innovations = Vec::with_capacity(self.count());
        for block in 0..self.count() {
            let mut row = Row::zeros();
            let mut passage = Passage::none();
            for k in block * self.block..(block + 1) * self.block {
                row += simulation.row(self.heading_rad[k]);
                passage = simulation
                    .advance(self.interval_s[k], self.rudder_rad[k])
                    .after(&passage);
            }
            let (white, variance) = whitening.update(&(row / self.block as f64), &passage);
            log_variances += variance.ln();
            gram.ger(1.0, &white, &white, 1.0);
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
        const MOST_DAMPING: f64 = 1e4;
        let mut summit = Summit {
            theta: *start,
            disturbance,
            likelihood: self.likelihood(start, disturbance)?,
        };
        let mut damping = 1e-3;
        for _ in 0..most_steps {
            let before = summit.likelihood.log;
            while damping < MOST_DAMPING {
                let mut theta = summit.likelihood.step(&summit.theta, free, damping)?;
                theta[A11] = theta[A11]
                    .min(-self.slowest_sway_per_s)
                    .max(-self.fastest_sway_per_s);
                match self.likelihood(&theta, disturbance) {
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

fn range(values: &[f64]) -> f64 {
    let high = values.iter().copied().fold(f64::MIN, f64::max);
    high - values.iter().copied().fold(f64::MAX, f64::min)
}

impl Likelihood {
    /// A damped Gauss-Newton step, inside what physics allows.
    fn step(&self, theta: &Theta, free: &[usize], damping: f64) -> Option<Theta> {
        let (normal, scale) = self.scaled_information(free);
        let right = DVector::from_fn(free.len(), |i, _| self.gradient[free[i]] / scale[i]);
        let damped = normal + DMatrix::identity(free.len(), free.len()) * damping;
        let step = damped.cholesky()?.solve(&right);
        let mut next = *theta;
        for (i, parameter) in free.iter().enumerate() {
            next[*parameter] += step[i] / scale[i];
        }
        next[CROSS_FLOW] = next[CROSS_FLOW].min(0.0);
        next[LAG] = next[LAG].max(0.0);
        Some(next)
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
type Row = SVector<f64, COLUMNS>;

/// The simulation of a record with its sensitivities.
struct Simulation {
    model: SwayYawModel,
    rudder: Rudder,
    state: SwayYawState,
    /// Sensitivities of heading, yaw rate and drift, a column each.
    sensitivities: SMatrix<f64, PARAMETERS, 3>,
}

impl Simulation {
    fn new(theta: &Theta, rudder_rad: &[f64]) -> Self {
        let mut sensitivities = SMatrix::zeros();
        sensitivities[(HEADING, 0)] = 1.0;
        sensitivities[(YAW_RATE, 1)] = 1.0;
        Self {
            model: model_of(theta),
            rudder: Rudder::at(rudder_rad.first().copied().unwrap_or(0.0)),
            state: SwayYawState {
                heading_rad: theta[HEADING],
                yaw_rate_rad_s: theta[YAW_RATE],
                drift_rad: 0.0,
            },
            sensitivities,
        }
    }

    fn row(&self, measured_rad: f64) -> Row {
        Row::from_fn(|column, _| match column {
            PARAMETERS => measured_rad - self.state.heading_rad,
            parameter => self.sensitivities[(parameter, 0)],
        })
    }

    fn advance(&mut self, interval_s: f64, command_rad: f64) -> Passage {
        if interval_s <= 0.0 {
            return Passage::none();
        }
        let mean = self
            .rudder
            .advance(command_rad, interval_s, self.model.rudder_lag_s);
        let step = self.model.step(self.state, mean.angle_rad, interval_s);
        let to_input = step.to_input();
        let [to_a22, to_a21, to_a11, to_cross_flow] = step.to_dynamics();
        self.sensitivities *= step.to_state().transpose();
        for (parameter, column) in [
            to_a22,
            mean.angle_rad * to_input,
            to_input,
            to_a21,
            to_a11,
            to_cross_flow,
            self.model.b2_per_s2 * mean.to_lag * to_input,
        ]
        .into_iter()
        .enumerate()
        {
            let mut total = self.sensitivities.row_mut(parameter);
            total += column.transpose();
        }
        self.state = step.state;
        Passage {
            to_state: step.to_state(),
            to_input,
            interval_s,
        }
    }
}

/// How a deviation of the state and a constant yaw acceleration act over some time.
struct Passage {
    to_state: Matrix3<f64>,
    to_input: Vector3<f64>,
    interval_s: f64,
}

impl Passage {
    fn none() -> Self {
        Self {
            to_state: Matrix3::identity(),
            to_input: Vector3::zeros(),
            interval_s: 0.0,
        }
    }

    fn after(&self, earlier: &Self) -> Self {
        Self {
            to_state: self.to_state * earlier.to_state,
            to_input: self.to_state * earlier.to_input + self.to_input,
            interval_s: self.interval_s + earlier.interval_s,
        }
    }
}

/// One Kalman filter for the residual and its sensitivities, state [psi, r, w, d]. Variances are in units of
/// the heading noise.
struct Whitening {
    disturbance: Disturbance,
    noise: f64,
    covariance: Matrix4<f64>,
    /// psi, r, w and d of every column, a column each.
    states: SMatrix<f64, COLUMNS, 4>,
}

impl Whitening {
    fn new(disturbance: Disturbance, block: usize) -> Self {
        let mut covariance = Matrix4::zeros();
        covariance[(3, 3)] = disturbance.relative.powi(2);
        Self {
            disturbance,
            noise: 1.0 / block as f64,
            covariance,
            states: SMatrix::zeros(),
        }
    }

    /// Whitens one comparison and predicts the next. Gives the white row and the innovation variance.
    fn update(&mut self, row: &Row, passage: &Passage) -> (Row, f64) {
        let variance = self.covariance[(0, 0)] + self.noise;
        let innovation = row - self.states.column(0);
        if self.disturbance.relative > 0.0 {
            let gain: Vector4<f64> = self.covariance.column(0) / variance;
            self.states.ger(1.0, &innovation, &gain, 1.0);
            self.covariance -= gain * self.covariance.row(0);
            self.predict(passage);
        }
        (innovation / variance.sqrt(), variance)
    }

    fn predict(&mut self, passage: &Passage) {
        let memory = (-passage.interval_s / self.disturbance.time_constant_s).exp();
        let mut transition = Matrix4::zeros();
        transition
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&passage.to_state);
        transition
            .fixed_view_mut::<3, 1>(0, 3)
            .copy_from(&passage.to_input);
        transition[(3, 3)] = memory;
        self.states *= transition.transpose();
        self.covariance = transition * self.covariance * transition.transpose();
        self.covariance[(3, 3)] += self.disturbance.relative.powi(2) * (1.0 - memory * memory);
    }
}

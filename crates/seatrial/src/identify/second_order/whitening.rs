//! The Kalman filter that whitens residuals and sensitivities under a yaw acceleration disturbance.

use seatrial_core::refine::Disturbance;

use super::passage::Passage;
use super::simulation::{COLUMNS, Row};

/// Change of the innovation variance under which the filter counts as steady where all comparisons are alike.
const STEADY: f64 = 1e-12;

/// One Kalman filter for the residual and its sensitivities, state [psi, r, w, d]. Variances are in units of
/// the heading noise.
pub(super) struct Whitening {
    disturbance: Disturbance,
    noise: f64,
    covariance: [[f64; 4]; 4],
    gain: [f64; 4],
    variance: f64,
    memory: f64,
    is_steady: bool,
    /// psi, r, w and d of every column, a row each.
    states: [Row; 4],
}

impl Whitening {
    pub(super) fn new(disturbance: Disturbance, block: usize) -> Self {
        let mut covariance = [[0.0; 4]; 4];
        covariance[3][3] = disturbance.relative.powi(2);
        Self {
            disturbance,
            noise: 1.0 / block as f64,
            covariance,
            gain: [0.0; 4],
            variance: 1.0 / block as f64,
            memory: 0.0,
            is_steady: false,
            states: [[0.0; COLUMNS]; 4],
        }
    }

    /// Whitens one comparison and predicts the next. Gives the white row and the innovation variance.
    pub(super) fn update(&mut self, row: &Row, passage: &Passage) -> (Row, f64) {
        let mut innovation = *row;
        if self.disturbance.relative > 0.0 {
            for (innovation, expected) in innovation.iter_mut().zip(&self.states[0]) {
                *innovation -= expected;
            }
            if !(self.is_steady && passage.is_same) {
                self.update_gain(passage);
            }
            self.predict(&innovation, passage);
        }
        let precision = 1.0 / self.variance.sqrt();
        (innovation.map(|of_row| of_row * precision), self.variance)
    }

    /// The gain of this comparison, and the covariance of the next.
    fn update_gain(&mut self, passage: &Passage) {
        let variance = self.covariance[0][0] + self.noise;
        let change = (variance - self.variance).abs();
        self.is_steady = passage.is_same && change <= STEADY * variance;
        self.variance = variance;
        let of_heading = self.covariance[0];
        self.gain = of_heading.map(|covariance| covariance / variance);
        for (row, gain) in self.covariance.iter_mut().zip(self.gain) {
            for (covariance, of_heading) in row.iter_mut().zip(&of_heading) {
                *covariance -= gain * of_heading;
            }
        }
        if !passage.is_same {
            self.memory = libm::exp(-passage.interval_s / self.disturbance.time_constant_s);
        }
        let [[s_rr, s_rw], [s_wr, s_ww]] = passage.state;
        let [psi_r, psi_w] = passage.heading_s;
        let [f_psi, f_r, f_w] = passage.to_rate;
        let transition = [
            [1.0, psi_r, psi_w, f_psi],
            [0.0, s_rr, s_rw, f_r],
            [0.0, s_wr, s_ww, f_w],
            [0.0, 0.0, 0.0, self.memory],
        ];
        let moved = transposed(&product(&transition, &self.covariance));
        self.covariance = product(&transition, &moved);
        self.covariance[3][3] +=
            self.disturbance.relative.powi(2) * (1.0 - self.memory * self.memory);
    }

    /// Corrects the states and moves them to the next comparison.
    fn predict(&mut self, innovation: &Row, passage: &Passage) {
        for (column, e) in innovation.iter().enumerate() {
            let [psi, r, w, d]: [f64; 4] =
                core::array::from_fn(|i| self.states[i][column] + self.gain[i] * e);
            let [psi, r, w] = passage.of([psi, r, w], d);
            self.states[0][column] = psi;
            self.states[1][column] = r;
            self.states[2][column] = w;
            self.states[3][column] = self.memory * d;
        }
    }
}

fn product(left: &[[f64; 4]; 4], right: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let mut product = [[0.0; 4]; 4];
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

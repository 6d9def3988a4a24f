//! Heading noise with a yaw acceleration disturbance, and the Kalman filter that whitens it.

use super::response::gains;

/// Change of the innovation variance under which the filter counts as steady.
const STEADY: f64 = 1e-10;

/// A change of the interval by this share of it does not change the filter: clock jitter.
const SAME_INTERVAL: f64 = 1e-6;

/// Heading noise and a first-order Gauss-Markov yaw acceleration that turns a vehicle of this damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the disturbance over that of the heading noise, 1/s^2; 0 for none.
    pub relative: f64,
    /// Time constant of the disturbance, s.
    pub time_constant_s: f64,
    /// a22 through which it turns the vehicle, 1/s.
    pub a22_per_s: f64,
}

/// The filter at one sample. Variances are in units of the heading noise.
#[derive(Clone, Copy, Debug)]
struct Gains {
    /// K, of heading, yaw rate and disturbance.
    gain: [f64; 3],
    /// S.
    variance: f64,
    step: Transition,
}

impl Gains {
    /// At each sample.
    ///
    /// ```text
    /// x = [psi, r, d],  psi' = r,  r' = a22 r + d,  d' = -d/tau_d + white
    /// S = P_psi,psi + 1,  K = P e_psi / S,  P <- F (P - K S K^T) F^T + Q
    /// ```
    fn of(time_s: &[f64], noise: &Noise) -> Vec<Self> {
        let variance = noise.relative * noise.relative;
        let mut p = [[0.0; 3], [0.0; 3], [0.0, 0.0, variance]];
        let mut now = Self {
            gain: [0.0; 3],
            variance: 1.0,
            step: Transition::over(noise, 0.0),
        };
        let mut last_s = f64::NAN;
        let mut is_steady = false;
        let mut gains = Vec::with_capacity(time_s.len());
        for (k, time) in time_s.iter().enumerate() {
            let step_s = time_s.get(k + 1).map_or(last_s, |next| next - time);
            let is_same = (step_s - last_s).abs() <= SAME_INTERVAL * step_s;
            if !is_same {
                now.step = Transition::over(noise, step_s);
                last_s = step_s;
                is_steady = false;
            }
            if !is_steady {
                let s = p[0][0] + 1.0;
                is_steady = (s - now.variance).abs() < STEADY * s && k > 3;
                now.variance = s;
                now.gain = p[0].map(|of_heading| of_heading / s);
                p = now.step.of_covariance(&given(&p, &now.gain), variance);
            }
            gains.push(now);
        }
        gains
    }
}

/// Whitens the columns of `rows` in place; the sum of the logarithms of the innovation variances.
///
/// ```text
/// e = z - x_psi,  x <- F (x + K e);   each column becomes e / sqrt S
/// ```
pub fn whiten<const N: usize>(time_s: &[f64], rows: &mut [[f64; N]], noise: &Noise) -> f64 {
    if noise.relative == 0.0 {
        return 0.0;
    }
    let gains = Gains::of(time_s, noise);
    let mut states = [[0.0; N]; 3];
    let mut log_variances = 0.0;
    let mut last = (f64::NAN, 0.0, 0.0);
    for (row, now) in rows.iter_mut().zip(&gains) {
        if now.variance != last.0 {
            last = (now.variance, now.variance.ln(), now.variance.sqrt().recip());
        }
        let (_, log_variance, scale) = last;
        log_variances += log_variance;
        let step = &now.step;
        let [of_heading, of_rate, of_disturbance] = now.gain;
        for (i, z) in row.iter_mut().enumerate() {
            let e = *z - states[0][i];
            *z = e * scale;
            let psi = states[0][i] + of_heading * e;
            let r = states[1][i] + of_rate * e;
            let d = states[2][i] + of_disturbance * e;
            states[0][i] = psi + step.rate_gain_s * r + step.heading_gain_s2 * d;
            states[1][i] = step.decay * r + step.rate_gain_s * d;
            states[2][i] = step.memory * d;
        }
    }
    log_variances
}

/// P - K S K^T, where K S is the first column of P.
fn given(p: &[[f64; 3]; 3], gain: &[f64; 3]) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| p[i][j] - gain[i] * p[0][j]))
}

/// F: the state one sample later, the disturbance held in between.
#[derive(Clone, Copy, Debug)]
struct Transition {
    decay: f64,
    rate_gain_s: f64,
    heading_gain_s2: f64,
    memory: f64,
}

impl Transition {
    fn over(noise: &Noise, t: f64) -> Self {
        let (rate_gain_s, heading_gain_s2) = gains(noise.a22_per_s, t);
        Self {
            decay: (noise.a22_per_s * t).exp(),
            rate_gain_s,
            heading_gain_s2,
            memory: (-t / noise.time_constant_s).exp(),
        }
    }

    fn matrix(&self) -> [[f64; 3]; 3] {
        [
            [1.0, self.rate_gain_s, self.heading_gain_s2],
            [0.0, self.decay, self.rate_gain_s],
            [0.0, 0.0, self.memory],
        ]
    }

    /// F P F^T + Q.
    fn of_covariance(&self, p: &[[f64; 3]; 3], variance: f64) -> [[f64; 3]; 3] {
        let f = self.matrix();
        let product: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..3).map(|k| f[i][k] * p[k][j]).sum())
        });
        let mut later: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..3).map(|k| product[i][k] * f[j][k]).sum())
        });
        later[2][2] += variance * (1.0 - self.memory * self.memory);
        later
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covariance of three headings under noise and disturbance from their definition, by whitening unit vectors: W^T W is its inverse.
    #[test]
    fn exact_whitening_inverts_the_covariance() {
        let time_s = [0.0, 0.1, 0.25];
        let noise = Noise {
            relative: 40.0,
            time_constant_s: 0.4,
            a22_per_s: -1.5,
        };
        let mut rows: Vec<[f64; 3]> = (0..3)
            .map(|i| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
            .collect();
        let log_determinant = whiten(&time_s, &mut rows, &noise);
        let inverse: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| rows.iter().map(|row| row[i] * row[j]).sum())
        });
        // The disturbance at 0 and at 0.1 s, held in between.
        let (variance, memory) = (1600.0, (-0.1_f64 / 0.4).exp());
        let (of_first, to_second) = gains(-1.5, 0.1);
        let (rate_gain, heading_gain) = gains(-1.5, 0.15);
        let weights = [
            [0.0, 0.0],
            [to_second, 0.0],
            [to_second + rate_gain * of_first, heading_gain],
        ];
        let of = [[variance, variance * memory], [variance * memory, variance]];
        let covariance = |i: usize, j: usize| {
            let mut sum = if i == j { 1.0 } else { 0.0 };
            for k in 0..2 {
                for l in 0..2 {
                    sum += weights[i][k] * of[k][l] * weights[j][l];
                }
            }
            sum
        };
        for i in 0..3 {
            for j in 0..3 {
                let column = inverse.iter().map(|row| row[j]).enumerate();
                let product: f64 = column.map(|(k, value)| covariance(i, k) * value).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                // Rounding.
                assert!((product - expected).abs() < 1e-9, "{i} {j} {product}");
            }
        }
        let determinant = covariance(1, 1) * covariance(2, 2) - covariance(1, 2).powi(2);
        assert!((log_determinant - determinant.ln()).abs() < 1e-9);
    }
}

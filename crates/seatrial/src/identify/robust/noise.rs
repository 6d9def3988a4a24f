//! Heading noise with a yaw acceleration disturbance, and the Kalman filter that whitens it.

use seatrial_core::whitening::{Covariance, Gain};

use super::response::{gains, small_exponential};

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

/// The filter at one sample, by the gains of [`seatrial_core::whitening`]. Variances are in units of the heading noise.
///
/// ```text
/// x = [psi, r, d],  psi' = r,  r' = a22 r + d,  d' = -d/tau_d + white
/// ```
struct Filter<'a> {
    noise: &'a Noise,
    covariance: Covariance<f64, 3>,
    gain: Gain<f64, 3>,
    step: Transition,
    last_s: f64,
    /// A step from which others near it are told.
    known: (f64, Transition),
    samples: usize,
    is_steady: bool,
}

impl<'a> Filter<'a> {
    fn new(noise: &'a Noise) -> Self {
        let mut covariance = Covariance([[0.0; 3]; 3]);
        let gain = covariance.measure(0, 1.0);
        covariance.0[2][2] = noise.relative * noise.relative;
        Self {
            noise,
            covariance,
            gain,
            step: Transition::over(noise, 0.0),
            last_s: f64::NAN,
            known: (f64::NAN, Transition::over(noise, 0.0)),
            samples: 0,
            is_steady: false,
        }
    }

    /// Goes on to the next sample, after which `step_s` pass; none after the last.
    #[inline(always)]
    fn next(&mut self, step_s: Option<f64>) {
        let step_s = step_s.unwrap_or(self.last_s);
        if (step_s - self.last_s).abs() > SAME_INTERVAL * step_s || self.last_s.is_nan() {
            let (known_s, known) = &self.known;
            self.step = match known.followed_by(self.noise, step_s - known_s) {
                Some(step) => step,
                None => {
                    self.known = (step_s, Transition::over(self.noise, step_s));
                    self.known.1
                }
            };
            self.last_s = step_s;
            self.is_steady = false;
        }
        if !self.is_steady {
            let gain = self.covariance.measure(0, 1.0);
            self.is_steady = (gain.variance - self.gain.variance).abs() < STEADY * gain.variance
                && self.samples > 3;
            self.gain = gain;
            let step = self.step;
            self.covariance = self.covariance.advanced(|state| step.of(state));
            let power = self.noise.relative * self.noise.relative;
            self.covariance.0[2][2] += power * (1.0 - step.memory * step.memory);
        }
        self.samples += 1;
    }
}

/// A product of variances as its logarithm.
struct LogProduct {
    log: f64,
    product: f64,
}

impl LogProduct {
    /// Before a product of two such numbers is too large for a float.
    const LARGE: f64 = 1e150;

    const ONE: Self = Self { log: 0.0, product: 1.0 };

    #[inline(always)]
    fn times(&mut self, factor: f64) {
        self.product *= factor;
        if self.product > Self::LARGE {
            self.log += libm::log(self.product);
            self.product = 1.0;
        }
    }

    fn ln(&self) -> f64 {
        self.log + libm::log(self.product)
    }
}

/// The states of the filter for each column.
struct States<const N: usize>([[f64; N]; 3]);

impl<const N: usize> States<N> {
    /// The innovations of a row; the states go on to the next.
    ///
    /// ```text
    /// e = z - x_psi,  x <- F (x + K e)
    /// ```
    #[inline(always)]
    fn innovations(&mut self, row: &[f64; N], now: &Filter) -> [f64; N] {
        let step = &now.step;
        let [of_heading, of_rate, of_disturbance] = now.gain.gain;
        let [headings, rates, disturbances] = &mut self.0;
        let mut innovations = [0.0; N];
        for i in 0..N {
            let e = row[i] - headings[i];
            innovations[i] = e;
            let psi = headings[i] + of_heading * e;
            let r = rates[i] + of_rate * e;
            let d = disturbances[i] + of_disturbance * e;
            headings[i] = psi + step.rate_gain_s * r + step.heading_gain_s2 * d;
            rates[i] = step.decay * r + step.rate_gain_s * d;
            disturbances[i] = step.memory * d;
        }
        innovations
    }
}

/// Whitens the columns of `rows` in place; the sum of the logarithms of the innovation variances.
///
/// Each column becomes e / sqrt S.
pub fn whiten<const N: usize>(time_s: &[f64], rows: &mut [[f64; N]], noise: &Noise) -> f64 {
    if noise.relative == 0.0 {
        return 0.0;
    }
    let mut filter = Filter::new(noise);
    let mut states = States([[0.0; N]; 3]);
    let mut variances = LogProduct::ONE;
    for (k, row) in rows.iter_mut().enumerate() {
        filter.next(time_s.get(k + 1).map(|next_s| next_s - time_s[k]));
        variances.times(filter.gain.variance);
        let scale = filter.gain.precision.sqrt();
        *row = states.innovations(row, &filter);
        for whitened in row.iter_mut() {
            *whitened *= scale;
        }
    }
    variances.ln()
}

/// Products of the whitened columns of rows, of which the elements with i <= j count, and the sum of the logarithms of the innovation
/// variances.
pub fn whitened_products<const N: usize>(
    time_s: &[f64],
    rows: impl Iterator<Item = [f64; N]>,
    noise: &Noise,
) -> ([[f64; N]; N], f64) {
    let mut products = [[0.0; N]; N];
    if noise.relative == 0.0 {
        rows.for_each(|row| add_products(&mut products, &row, 1.0));
        return (products, 0.0);
    }
    let mut filter = Filter::new(noise);
    let mut states = States([[0.0; N]; 3]);
    let mut variances = LogProduct::ONE;
    for (k, row) in rows.enumerate() {
        filter.next(time_s.get(k + 1).map(|next_s| next_s - time_s[k]));
        variances.times(filter.gain.variance);
        let innovations = states.innovations(&row, &filter);
        add_products(&mut products, &innovations, filter.gain.precision);
    }
    (products, variances.ln())
}

/// Columns go by pairs.
#[inline(always)]
fn add_products<const N: usize>(products: &mut [[f64; N]; N], row: &[f64; N], precision: f64) {
    for i in 0..N {
        let of_i = precision * row[i];
        for j in i - i % 2..N {
            products[i][j] += of_i * row[j];
        }
    }
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
            decay: libm::exp(noise.a22_per_s * t),
            rate_gain_s,
            heading_gain_s2,
            memory: libm::exp(-t / noise.time_constant_s),
        }
    }

    #[inline(always)]
    fn of(&self, [psi, r, d]: [f64; 3]) -> [f64; 3] {
        [
            psi + self.rate_gain_s * r + self.heading_gain_s2 * d,
            self.decay * r + self.rate_gain_s * d,
            self.memory * d,
        ]
    }

    /// Over so much more time; `None` where that is too long to be told without an exponential.
    #[inline(always)]
    fn followed_by(&self, noise: &Noise, more_s: f64) -> Option<Self> {
        const LARGEST: f64 = 0.02;
        let reach = more_s.abs() * noise.a22_per_s.abs().max(1.0 / noise.time_constant_s);
        if reach.is_nan() || reach > LARGEST {
            return None;
        }
        let more = small_exponential(noise.a22_per_s, more_s);
        Some(Self {
            decay: self.decay * more.decay,
            rate_gain_s: self.rate_gain_s + self.decay * more.gain_s,
            heading_gain_s2: self.heading_gain_s2
                + self.rate_gain_s * more_s
                + self.decay * more.integral_s2,
            memory: self.memory * small_exponential(-1.0 / noise.time_constant_s, more_s).decay,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covariance of three headings under noise and disturbance from their definition, by whitening unit vectors: W^T W is its inverse.
    #[test]
    fn exact_whitening_inverts_the_covariance() {
        let time_s = [0.0, 0.1, 0.25];
        let noise = Noise { relative: 40.0, time_constant_s: 0.4, a22_per_s: -1.5 };
        let mut rows: Vec<[f64; 3]> =
            (0..3).map(|i| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 })).collect();
        let log_determinant = whiten(&time_s, &mut rows, &noise);
        let inverse: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| rows.iter().map(|row| row[i] * row[j]).sum())
        });
        // The disturbance at 0 and at 0.1 s, held in between.
        let (variance, memory) = (1600.0, (-0.1_f64 / 0.4).exp());
        let (of_first, to_second) = gains(-1.5, 0.1);
        let (rate_gain, heading_gain) = gains(-1.5, 0.15);
        let weights =
            [[0.0, 0.0], [to_second, 0.0], [to_second + rate_gain * of_first, heading_gain]];
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

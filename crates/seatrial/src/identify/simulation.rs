//! The simulated heading with its derivatives to the parameters, and the parameters of the nearest simulation.

use nalgebra::{Matrix5, Vector5};
use seatrial_core::model::{Discretisation, phi};

use super::whitening::Prepared;

/// A search that needs more passes over the record than this finds nothing.
const MOST_PASSES: u32 = 40;

/// Arrived where a step promises less than this share of the cost.
const NEGLIGIBLE_GAIN: f64 = 1e-9;

/// First damping after a step that made it worse, relative to the information's diagonal.
const FIRST_DAMPING: f64 = 1e-3;

/// The [`Discretisation`] and its derivatives to a22.
///
/// ```text
/// x = a22 h,  d e^x/dx = e^x,  phi1' = phi1 - phi2,  phi2' = phi2 - 2 phi3,  phi3(x) = (phi2(x) - 1/2)/x
/// ```
struct Step {
    interval_s: f64,
    now: Discretisation<f64>,
    decay_s: f64,
    rate_gain_s2: f64,
    heading_gain_s3: f64,
}

impl Step {
    fn new(a22_per_s: f64, interval_s: f64) -> Self {
        let x = a22_per_s * interval_s;
        let (phi1, phi2) = phi(x);
        let phi3 = if x.abs() < 0.1 {
            // To x^8/11!, 2e-16.
            (4..=11)
                .rev()
                .fold(1.0, |sum, k| 1.0 + x / f64::from(k) * sum)
                / 6.0
        } else {
            (phi2 - 0.5) / x
        };
        let now = Discretisation::new(a22_per_s, interval_s);
        let squared = interval_s * interval_s;
        Self {
            interval_s,
            decay_s: interval_s * now.decay,
            rate_gain_s2: squared * (phi1 - phi2),
            heading_gain_s3: squared * interval_s * (phi2 - 2.0 * phi3),
            now,
        }
    }
}

/// Heading and yaw rate of a response.
#[derive(Clone, Copy, Default)]
struct Response {
    heading: f64,
    rate: f64,
}

/// What one pass over a record with [a22, b2, C0, psi0, r0] gives.
#[derive(Clone, Copy)]
pub(super) struct Simulation {
    pub parameters: Vector5<f64>,
    /// sum e^2 over the comparisons, rad^2.
    pub residual: f64,
    /// sum g g^T
    pub information: Matrix5<f64>,
    /// sum g e
    gradient: Vector5<f64>,
}

/// Sees g, the derivatives of the simulated heading to [a22, b2, C0, psi0, r0], and e, measured less simulated heading, at
/// every comparison.
///
/// ```text
/// psi+ = psi + G r + H u        r+ = E r + G u            u = b2 delta + C0; to b2: u = delta; to C0: u = 1
/// psi_a+ = psi_a + G r_a + G' r + H' u      r_a+ = E r_a + E' r + G' u      the derivative to a22
/// ```
pub(super) fn compare(
    record: &Prepared,
    parameters: &Vector5<f64>,
    mut see: impl FnMut([f64; 5], f64),
) {
    let [a22, b2, c0, heading0, rate0]: [f64; 5] = (*parameters).into();
    let mut step = Step::new(a22, 0.0);
    let (mut to_damping, mut to_rudder, mut to_offset) = (
        Response::default(),
        Response::default(),
        Response::default(),
    );
    let mut to_rate = Response {
        heading: 0.0,
        rate: 1.0,
    };
    let intervals = record.interval_s.chunks_exact(record.block);
    let headings = record.heading_rad.chunks_exact(record.block);
    let rudders = record.rudder_rad.chunks_exact(record.block);
    let share = 1.0 / record.block as f64;
    for ((intervals, headings), rudders) in intervals.zip(headings).zip(rudders) {
        let mut sums = [0.0; 5];
        for ((&interval_s, &heading), &rudder) in intervals.iter().zip(headings).zip(rudders) {
            let now = [
                to_damping.heading,
                to_rudder.heading,
                to_offset.heading,
                to_rate.heading,
                heading,
            ];
            for (sum, now) in sums.iter_mut().zip(now) {
                *sum += now;
            }
            // A clock's rounding of a billionth is no other interval.
            if (interval_s - step.interval_s).abs() > 1e-9 * interval_s {
                step = Step::new(a22, interval_s);
            }
            let Discretisation {
                decay,
                rate_gain_s,
                heading_gain_s2,
            } = step.now;
            let u = b2 * rudder + c0;
            let rate = b2 * to_rudder.rate + c0 * to_offset.rate + rate0 * to_rate.rate;
            to_damping = Response {
                heading: to_damping.heading
                    + rate_gain_s * to_damping.rate
                    + step.rate_gain_s2 * rate
                    + step.heading_gain_s3 * u,
                rate: decay * to_damping.rate + step.decay_s * rate + step.rate_gain_s2 * u,
            };
            let forced = |of: Response, u: f64| Response {
                heading: of.heading + rate_gain_s * of.rate + heading_gain_s2 * u,
                rate: decay * of.rate + rate_gain_s * u,
            };
            to_rudder = forced(to_rudder, rudder);
            to_offset = forced(to_offset, 1.0);
            to_rate = Response {
                heading: to_rate.heading + rate_gain_s * to_rate.rate,
                rate: decay * to_rate.rate,
            };
        }
        let [to_a22, to_b2, to_c0, to_r0, heading] = sums.map(|sum| sum * share);
        let simulated = heading0 + b2 * to_b2 + c0 * to_c0 + rate0 * to_r0;
        see([to_a22, to_b2, to_c0, 1.0, to_r0], heading - simulated);
    }
}

impl Simulation {
    fn new(record: &Prepared, parameters: Vector5<f64>) -> Self {
        let mut gram = [[0.0; 5]; 5];
        let mut gradient = [0.0; 5];
        let mut residual = 0.0;
        compare(record, &parameters, |g, e| {
            for (i, row) in gram.iter_mut().enumerate() {
                for (element, g_j) in row[..=i].iter_mut().zip(g) {
                    *element += g[i] * g_j;
                }
            }
            for (sum, g) in gradient.iter_mut().zip(g) {
                *sum += g * e;
            }
            residual += e * e;
        });
        Self {
            parameters,
            residual,
            information: Matrix5::from_fn(|i, j| gram[i.max(j)][i.min(j)]),
            gradient: gradient.into(),
        }
    }

    /// Levenberg and Marquardt's step: (A + damping diag A) step = sum g e.
    fn step(&self, damping: f64) -> Option<Vector5<f64>> {
        let scale = self.information.diagonal().map(f64::sqrt);
        let scaled = Matrix5::from_fn(|i, j| {
            let own = if i == j { damping } else { 0.0 };
            self.information[(i, j)] / (scale[i] * scale[j]) + own
        });
        let step = scaled
            .cholesky()?
            .solve(&self.gradient.component_div(&scale));
        Some(step.component_div(&scale))
    }
}

/// The parameters with the least sum of squared heading errors, from a start that is near, and the passes it took (D. W.
/// Marquardt, SIAM Journal on Applied Mathematics 11, 1963). `None` where none is found.
pub(super) fn nearest(record: &Prepared, start: Vector5<f64>) -> Option<(Simulation, u32)> {
    let total: f64 = record.heading_rad.iter().map(|w| w * w).sum();
    let rounding = f64::EPSILON * f64::EPSILON * total * record.heading_rad.len() as f64;
    let mut at = Simulation::new(record, start);
    let mut damping = 0.0;
    for passes in 1..MOST_PASSES {
        let step = at.step(damping)?;
        let promised = step.dot(&at.gradient);
        if promised <= NEGLIGIBLE_GAIN * at.residual + rounding {
            return Some((at, passes));
        }
        let next = Simulation::new(record, at.parameters + step);
        if next.residual < at.residual {
            at = next;
            damping = if damping > FIRST_DAMPING {
                0.1 * damping
            } else {
                0.0
            };
        } else {
            damping = (10.0 * damping).max(FIRST_DAMPING);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::Sample;

    fn record(block: usize) -> Prepared {
        let samples: Vec<Sample<f64>> = (0..120)
            .map(|k| Sample {
                time_s: 0.05 * f64::from(k) + if k > 60 { 0.03 } else { 0.0 },
                heading_rad: 0.3 * (0.05 * f64::from(k)).sin(),
                rudder_rad: if k % 50 < 25 { 0.26 } else { -0.2 },
                ..Sample::default()
            })
            .collect();
        Prepared::new(&samples, block)
    }

    #[test]
    fn exact_sensitivities_are_the_differences_of_simulations() {
        for block in [1, 3] {
            let record = record(block);
            for a22 in [-1.07, -1e-3, 0.0, 0.4, -6.0] {
                let at = Vector5::new(a22, 1.08, 0.012, 0.1, -0.02);
                let residuals = |parameters: Vector5<f64>| {
                    let mut residuals = Vec::new();
                    compare(&record, &parameters, |_, e| residuals.push(e));
                    residuals
                };
                let mut sensitivities = Vec::new();
                compare(&record, &at, |g, _| sensitivities.push(g));
                for i in 0..5 {
                    let spread = 1e-5 * Vector5::ith(i, 1.0);
                    let differences = (residuals(at - spread).into_iter())
                        .zip(residuals(at + spread))
                        .map(|(below, above)| (below - above) / 2e-5);
                    for (found, expected) in sensitivities.iter().map(|g| g[i]).zip(differences) {
                        let scale = expected.abs().max(1.0);
                        // Third derivatives of order 100 times 1e-10, and rounding over 1e-5.
                        assert!(
                            (found - expected).abs() < 1e-8 * scale,
                            "{a22} {i}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}

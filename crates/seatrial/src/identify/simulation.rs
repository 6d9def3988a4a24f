//! The simulated heading with its derivatives to the parameters, and the parameters of the nearest simulation.

use std::ops::Range;

use nalgebra::{Matrix5, Vector5};
use seatrial_core::model::{Discretisation, phi};

use crate::record_series::{RecordSeries, is_same};

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
    now: Discretisation<f64>,
    decay_s: f64,
    rate_gain_s2: f64,
    heading_gain_s3: f64,
}

impl Step {
    fn new(a22_per_s: f64, interval_s: f64) -> Self {
        let x = a22_per_s * interval_s;
        let [phi1, phi2, phi3] = phis(x);
        let decay = libm::exp(x);
        let squared = interval_s * interval_s;
        Self {
            now: Discretisation {
                decay,
                rate_gain_s: interval_s * phi1,
                heading_gain_s2: squared * phi2,
            },
            decay_s: interval_s * decay,
            rate_gain_s2: squared * (phi1 - phi2),
            heading_gain_s3: squared * interval_s * (phi2 - 2.0 * phi3),
        }
    }
}

/// 1/4, ..., 1/16.
const INVERSES: [f64; 13] = {
    let mut inverses = [0.0; 13];
    let mut k = 0;
    while k < inverses.len() {
        inverses[k] = 1.0 / (k + 4) as f64;
        k += 1;
    }
    inverses
};

/// phi1, phi2 and phi3; for a small x from the series of phi3 to x^13, 1e-17, without the cancellation of the others.
fn phis(x: f64) -> [f64; 3] {
    if x.abs() < 0.5 {
        let series = |sum, inverse: &f64| 1.0 + x * inverse * sum;
        let phi3 = INVERSES.iter().rev().fold(1.0, series) / 6.0;
        let phi2 = 0.5 + x * phi3;
        [1.0 + x * phi2, phi2, phi3]
    } else {
        let (phi1, phi2) = phi(x);
        [phi1, phi2, (phi2 - 0.5) / x]
    }
}

/// Heading and yaw rate of a response.
#[derive(Clone, Copy, Default)]
struct Response {
    heading: f64,
    rate: f64,
}

impl Response {
    /// Free, after an interval.
    fn after(self, step: &Discretisation<f64>) -> Self {
        Self {
            heading: self.heading + step.rate_gain_s * self.rate,
            rate: step.decay * self.rate,
        }
    }

    /// After an interval of the acceleration u.
    fn forced(self, step: &Discretisation<f64>, u: f64) -> Self {
        let free = self.after(step);
        Self {
            heading: free.heading + step.heading_gain_s2 * u,
            rate: free.rate + step.rate_gain_s * u,
        }
    }
}

/// Numbers that are added up beside one another.
const LANES: usize = 8;

/// What a record is compared with: the derivatives of the simulated heading to [a22, b2, C0, r0] and e, measured less
/// simulated heading, at every comparison. The derivative to psi0 is one.
///
/// ```text
/// psi+ = psi + G r + H u        r+ = E r + G u            u = b2 delta + C0; to b2: u = delta; to C0: u = 1; to r0: u = 0
/// psi_a+ = psi_a + G r_a + G' r + H' u      r_a+ = E r_a + E' r + G' u      the derivative to a22
/// ```
///
/// The yaw rate that C0 causes is the heading that r0 causes.
pub(super) struct Comparisons<'a> {
    record: &'a RecordSeries,
    /// Samples after one another that come in equal intervals.
    runs: Vec<Range<usize>>,
    /// Behind the last comparison zeros, to a multiple of [`LANES`].
    columns: [Vec<f64>; 5],
}

impl<'a> Comparisons<'a> {
    /// Not simulated yet.
    fn new(record: &'a RecordSeries) -> Self {
        let intervals = &record.interval_s[..record.heading_rad.len() - 1];
        let mut runs: Vec<Range<usize>> = Vec::new();
        for (k, interval_s) in intervals.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if is_same(*interval_s, intervals[run.start]) => run.end = k + 1,
                _ => runs.push(k..k + 1),
            }
        }
        Self {
            record,
            runs,
            columns: Default::default(),
        }
    }

    /// With the simulation of [a22, b2, C0, psi0, r0].
    pub fn of(record: &'a RecordSeries, parameters: &Vector5<f64>) -> Self {
        let mut comparisons = Self::new(record);
        comparisons.simulate(parameters);
        comparisons
    }

    fn simulate(&mut self, parameters: &Vector5<f64>) {
        let [a22, b2, c0, heading0, rate0]: [f64; 5] = (*parameters).into();
        let RecordSeries {
            interval_s,
            heading_rad,
            rudder_rad,
            block,
        } = self.record;
        for column in &mut self.columns {
            column.resize(heading_rad.len(), 0.0);
            column[0] = 0.0;
        }
        self.columns[4][0] = heading_rad[0] - heading0;
        let (mut to_a22, mut to_b2) = (Response::default(), Response::default());
        let mut heading_to_c0 = 0.0;
        let mut to_r0 = Response {
            heading: 0.0,
            rate: 1.0,
        };
        let mut simulated = Response {
            heading: heading0,
            rate: rate0,
        };
        for run in &self.runs {
            let step = Step::new(a22, interval_s[run.start]);
            let now = &step.now;
            let after = run.start + 1..run.end + 1;
            let columns = self.columns.each_mut();
            let [of_a22, of_b2, of_c0, of_r0, errors] = columns.map(|c| &mut c[after.clone()]);
            let signals = rudder_rad[run.clone()].iter().zip(&heading_rad[after]);
            let derivatives = of_a22.iter_mut().zip(of_b2).zip(of_c0).zip(of_r0);
            for (((rudder, heading), (((of_a22, of_b2), of_c0), of_r0)), error) in
                signals.zip(derivatives).zip(errors)
            {
                let u = b2 * rudder + c0;
                let free = to_a22.after(now);
                to_a22 = Response {
                    heading: free.heading
                        + (step.rate_gain_s2 * simulated.rate + step.heading_gain_s3 * u),
                    rate: free.rate + (step.decay_s * simulated.rate + step.rate_gain_s2 * u),
                };
                simulated = simulated.forced(now, u);
                to_b2 = to_b2.forced(now, *rudder);
                heading_to_c0 += now.rate_gain_s * to_r0.heading + now.heading_gain_s2;
                to_r0 = to_r0.after(now);
                *of_a22 = to_a22.heading;
                *of_b2 = to_b2.heading;
                *of_c0 = heading_to_c0;
                *of_r0 = to_r0.heading;
                *error = heading - simulated.heading;
            }
        }
        for column in &mut self.columns {
            if *block > 1 {
                average(column, *block);
            }
            column.resize(column.len().next_multiple_of(LANES), 0.0);
        }
    }

    /// g, the derivatives to [a22, b2, C0, psi0, r0], and e of each comparison.
    pub fn rows(&self) -> impl Iterator<Item = ([f64; 5], f64)> {
        (0..self.record.blocks()).map(|k| {
            let [to_a22, to_b2, to_c0, to_r0, error] = self.columns.each_ref().map(|c| c[k]);
            ([to_a22, to_b2, to_c0, 1.0, to_r0], error)
        })
    }
}

/// The mean of each block of numbers in place of them; what is left of an incomplete one is dropped.
fn average(numbers: &mut Vec<f64>, block: usize) {
    let blocks = numbers.len() / block;
    for k in 0..blocks {
        numbers[k] = numbers[k * block..][..block].iter().sum::<f64>() / block as f64;
    }
    numbers.truncate(blocks);
}

/// Needs columns whose length is a multiple of [`LANES`].
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a
        .as_chunks::<LANES>()
        .0
        .iter()
        .zip(b.as_chunks::<LANES>().0)
    {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    total_of_lanes(sums)
}

/// Needs a column whose length is a multiple of [`LANES`].
fn total(a: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for a in a.as_chunks::<LANES>().0 {
        for k in 0..LANES {
            sums[k] += a[k];
        }
    }
    total_of_lanes(sums)
}

fn total_of_lanes([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// What one pass over a record gives.
#[derive(Clone, Copy)]
pub(super) struct Simulation {
    /// [a22, b2, C0, psi0, r0]
    pub parameters: Vector5<f64>,
    /// sum e^2 over the comparisons, rad^2.
    pub residual: f64,
    /// sum g g^T
    pub information: Matrix5<f64>,
    /// sum g e
    gradient: Vector5<f64>,
}

impl Simulation {
    fn new(comparisons: &mut Comparisons, parameters: Vector5<f64>) -> Self {
        comparisons.simulate(&parameters);
        let [to_a22, to_b2, to_c0, to_r0, error] = &comparisons.columns;
        let aa = dot(to_a22, to_a22);
        let [ab, bb] = [to_a22, to_b2].map(|c| dot(c, to_b2));
        let [ac, bc, cc] = [to_a22, to_b2, to_c0].map(|c| dot(c, to_c0));
        let [ar, br, cr, rr] = [to_a22, to_b2, to_c0, to_r0].map(|c| dot(c, to_r0));
        let [ap, bp, cp, rp] = [to_a22, to_b2, to_c0, to_r0].map(|c| total(c));
        let [ae, be, ce, re] = [to_a22, to_b2, to_c0, to_r0].map(|c| dot(c, error));
        let pp = comparisons.record.blocks() as f64;
        #[rustfmt::skip]
        let information = Matrix5::new(
            aa, ab, ac, ap, ar,
            ab, bb, bc, bp, br,
            ac, bc, cc, cp, cr,
            ap, bp, cp, pp, rp,
            ar, br, cr, rp, rr,
        );
        Self {
            parameters,
            residual: dot(error, error),
            information,
            gradient: Vector5::new(ae, be, ce, total(error), re),
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
///
/// The last step is taken without another pass: what a step promises shrinks at least in geometric progression, and the one
/// after it would promise nothing.
pub(super) fn nearest(record: &RecordSeries, start: Vector5<f64>) -> Option<(Simulation, u32)> {
    // In parts that need not wait for one another.
    let parts = record.heading_rad.chunks(LANES);
    let total: f64 = parts.map(|w| w.iter().map(|w| w * w).sum::<f64>()).sum();
    let rounding = f64::EPSILON * f64::EPSILON * total * record.heading_rad.len() as f64;
    let mut comparisons = Comparisons::new(record);
    let mut at = Simulation::new(&mut comparisons, start);
    let mut damping = 0.0;
    let mut promised_before = f64::INFINITY;
    for passes in 1..MOST_PASSES {
        let step = at.step(damping)?;
        let promised = step.dot(&at.gradient);
        let left = (at.residual - promised).max(0.0);
        let next_promised = promised * promised / promised_before.min(left);
        let negligible = NEGLIGIBLE_GAIN * left + rounding;
        if promised <= negligible || damping == 0.0 && next_promised <= negligible {
            at.parameters += step;
            at.residual = left;
            return Some((at, passes));
        }
        promised_before = promised;
        let next = Simulation::new(&mut comparisons, at.parameters + step);
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

    fn record(block: usize) -> RecordSeries {
        let samples: Vec<Sample<f64>> = (0..120)
            .map(|k| Sample {
                time_s: 0.05 * f64::from(k) + if k > 60 { 0.03 } else { 0.0 },
                heading_rad: 0.3 * (0.05 * f64::from(k)).sin(),
                rudder_rad: if k % 50 < 25 { 0.26 } else { -0.2 },
                ..Sample::default()
            })
            .collect();
        RecordSeries::new(&samples, block)
    }

    #[test]
    fn exact_sensitivities_are_the_differences_of_simulations() {
        for block in [1, 3] {
            let record = record(block);
            for a22 in [-1.07, -1e-3, 0.0, 0.4, -6.0] {
                let at = Vector5::new(a22, 1.08, 0.012, 0.1, -0.02);
                let residuals = |parameters: Vector5<f64>| -> Vec<f64> {
                    let rows = Comparisons::of(&record, &parameters);
                    rows.rows().map(|(_, e)| e).collect()
                };
                let comparisons = Comparisons::of(&record, &at);
                let sensitivities: Vec<[f64; 5]> = comparisons.rows().map(|(g, _)| g).collect();
                for i in 0..5 {
                    let spread = 1e-5 * Vector5::ith(i, 1.0);
                    let differences = residuals(at - spread)
                        .into_iter()
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

    #[test]
    fn exact_the_step_without_a_pass_arrives() {
        let mut record = record(1);
        let truth = Vector5::new(-1.07, 1.08, 0.012, 0.1, -0.02);
        let noise = |k: usize| 0.01 * (7.7 * k as f64).sin();
        let errors: Vec<f64> = Comparisons::of(&record, &truth)
            .rows()
            .map(|(_, e)| e)
            .collect();
        for (k, error) in errors.iter().enumerate() {
            record.heading_rad[k] += noise(k) - error;
        }
        for start in [
            [-1.0, 1.0, 0.01, 0.0, 0.0],
            [-0.5, 1.0, 0.0, 0.0, 0.0],
            [-2.0, 2.0, 0.1, 1.0, 0.2],
        ] {
            let (found, passes) = nearest(&record, Vector5::from(start)).unwrap();
            assert!(passes <= 5, "{passes}");
            let again = Simulation::new(&mut Comparisons::new(&record), found.parameters);
            let off = found.residual / again.residual - 1.0;
            assert!(off.abs() < 1e-9, "{passes}: {off:e}");
            let promised = again.step(0.0).unwrap().dot(&again.gradient) / again.residual;
            assert!(promised < NEGLIGIBLE_GAIN, "{passes}: {promised:e}");
        }
    }
}

//! The model whose simulation is nearest to the heading.

use super::average::Hypotheses;
use super::peak::Search;
use super::record::{A22, B2, C0, PARAMETERS, Record, three};

/// A function of theta and its covariance.
type Moment<'a> = dyn Fn(&[f64; 3], &[[f64; 3]; 3]) -> f64 + 'a;

/// Segments whose scatter tells the error of the nearest simulation.
const SEGMENTS: usize = 10;

/// The mean of the nearest simulations with and without a lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// a22, b2, C0.
    pub theta: [f64; 3],
    /// Covariance of theta from white noise, from errors correlated within a segment, and from the lag.
    pub covariance: [[f64; 3]; 3],
}

impl Nearest {
    /// Output error with lag and shift free, from the hypotheses without a disturbance.
    ///
    /// For a vehicle that is not of first order it predicts new manoeuvres best. It is biased where a controller feeds a disturbance of
    /// the sea back into the rudder.
    pub fn of(record: &Record, hypotheses: &Hypotheses) -> Self {
        const THETA: [usize; 3] = [A22, B2, C0];
        let likeliest = hypotheses.likeliest_of(|h| h.share == 0.0);
        let peak = &likeliest.unwrap_or(&hypotheses.white).peak;
        // The covariance of the very linearisation whose errors are summed: along a lag that trades for damping another one would make
        // the sums of any size.
        let mut search = Search::new(record, &peak.point, hypotheses.block, peak.prompt);
        let here = search.relinearised(peak);
        let around = search.around();
        let precision = 1.0 / (here.noise_rad * here.noise_rad);
        let free = here.covariance_at_the_point();
        let errors = around.rows.iter().map(|row| {
            let influence = THETA.map(|i| {
                let sum: f64 = free[i].iter().zip(row).map(|(c, x)| c * x).sum();
                precision * sum
            });
            influence.map(|influence| influence * row[PARAMETERS])
        });
        let scatter = scatter(errors, around.rows.len());
        let calm: Vec<([f64; 3], [[f64; 3]; 3], f64)> = (hypotheses.all.iter())
            .filter(|h| h.share == 0.0)
            .map(|h| (THETA.map(|i| h.peak.point.0[i]), three(&h.covariance), h.log_evidence))
            .collect();
        let best = calm.iter().map(|c| c.2).fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = calm.iter().map(|c| libm::exp(c.2 - best)).sum();
        let mean_of = |of: &Moment| -> f64 {
            let terms = calm.iter().map(|(theta, own, log)| libm::exp(log - best) * of(theta, own));
            terms.sum::<f64>() / total
        };
        let theta = core::array::from_fn(|i| mean_of(&|theta, _| theta[i]));
        let own: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                mean_of(&|at, own| own[i][j] + (at[i] - theta[i]) * (at[j] - theta[j]))
            })
        });
        Self {
            theta,
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| scatter[i][j] + own[i][j])
            }),
        }
    }
}

/// Covariance of the sum of `errors`, of which there are `count`, from the scatter of their sums over segments.
fn scatter(errors: impl Iterator<Item = [f64; 3]>, count: usize) -> [[f64; 3]; 3] {
    let length = count.div_ceil(SEGMENTS).max(1);
    let mut sums = [[0.0; 3]; SEGMENTS];
    for (k, error) in errors.enumerate() {
        for (sum, error) in sums[k / length].iter_mut().zip(error) {
            *sum += error;
        }
    }
    // Five free parameters make the sums smaller than they are.
    let factor = SEGMENTS as f64 / (SEGMENTS as f64 - 5.0);
    let of = |i: usize, j: usize| factor * sums.iter().map(|s| s[i] * s[j]).sum::<f64>();
    core::array::from_fn(|i| core::array::from_fn(|j| of(i, j)))
}

//! A record as the likelihood takes it, and generalised least squares on it.

use libm::{log, sqrt};

use super::cholesky::Cholesky;
use super::lanes::Lanes;
use super::responses::Responses;
use super::whitening::{Disturbance, SAME_INTERVAL, Whitening};

/// Columns of the linear model besides the heading: b2, C0, psi0, r0.
pub(super) const COLUMNS: usize = 4;

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

/// What generalised least squares gives at one damping and one disturbance, of all parameters or of the first `M` alone.
#[derive(Clone, Copy, Debug)]
pub struct Fit<const M: usize = COLUMNS> {
    /// b2, C0, psi0, r0.
    pub linear: [f64; M],
    /// Covariance of `linear` over the variance of the heading noise.
    pub scaled_covariance: [[f64; M]; M],
    /// Sum of squares of the whitened residual, rad^2.
    pub residual: f64,
    /// Variance of the heading noise of one sample, rad^2.
    pub noise_variance_rad2: f64,
    /// Restricted log likelihood, up to a constant of the record.
    pub log_likelihood: f64,
}

/// [`Fit`] of b2 and C0 alone: the state at the beginning may be any.
pub type SteeringFit = Fit<2>;

impl From<Fit> for SteeringFit {
    fn from(fit: Fit) -> Self {
        let [b2, c0, ..] = fit.linear;
        Self {
            linear: [b2, c0],
            scaled_covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| fit.scaled_covariance[i][j])
            }),
            residual: fit.residual,
            noise_variance_rad2: fit.noise_variance_rad2,
            log_likelihood: fit.log_likelihood,
        }
    }
}

/// Place of the heading among the columns: b2, C0, heading, psi0, r0.
const HEADING: usize = 2;

/// Columns of a comparison: b2, C0, heading, psi0, r0.
type Columns<const N: usize> = [Lanes<N>; COLUMNS + 1];

/// Sums of the products of the first `K` [`Columns`], above the diagonal.
struct Gram<const N: usize, const K: usize>([[Lanes<N>; K]; K]);

impl<const N: usize, const K: usize> Gram<N, K> {
    const ZERO: Self = Self([[Lanes::ZERO; K]; K]);

    #[inline(always)]
    fn add(&mut self, columns: &[Lanes<N>; K], precision: Lanes<N>) {
        for (i, row) in self.0.iter_mut().enumerate() {
            let weighted = columns[i] * precision;
            for j in i..K {
                row[j] += weighted * columns[j];
            }
        }
    }

    /// Adds the products of the innovations of the columns of a comparison.
    #[inline(never)]
    fn add_whitened(
        &mut self,
        whitening: &mut Whitening<N, K>,
        columns: &[Lanes<N>; K],
        interval_s: f64,
        responses: &Responses<N>,
    ) {
        let innovations = whitening.innovations(columns, interval_s, responses);
        self.add(&innovations, whitening.precision());
    }

    /// Equations of `M` columns besides the heading.
    fn of_lane<const M: usize>(&self, lane: usize) -> Equations<M> {
        let of = |i: usize, j: usize| self.0[i.min(j)][i.max(j)].0[lane];
        let place = |i: usize| if i < HEADING { i } else { i + 1 };
        Equations {
            products: core::array::from_fn(|i| core::array::from_fn(|j| of(place(i), place(j)))),
            right: core::array::from_fn(|i| of(place(i), HEADING)),
            total: of(HEADING, HEADING),
        }
    }
}

/// The normal equations of generalised least squares.
struct Equations<const M: usize> {
    products: [[f64; M]; M],
    right: [f64; M],
    total: f64,
}

/// Their solution.
struct Solution<const M: usize> {
    linear: [f64; M],
    scaled_covariance: [[f64; M]; M],
    residual: f64,
    log_determinant: f64,
}

impl<const M: usize> Solution<M> {
    fn fit(self, degrees_of_freedom: f64, log_variances: f64) -> Fit<M> {
        Fit {
            linear: self.linear,
            scaled_covariance: self.scaled_covariance,
            residual: self.residual,
            noise_variance_rad2: self.residual / degrees_of_freedom,
            log_likelihood: -0.5
                * (degrees_of_freedom * log(self.residual) + log_variances + self.log_determinant),
        }
    }
}

impl<const M: usize> Equations<M> {
    /// `None` where the columns are not independent.
    fn solve(&self) -> Option<Solution<M>> {
        let scale: [f64; M] = core::array::from_fn(|i| sqrt(self.products[i][i]));
        if !scale.iter().all(|s| *s > 0.0) {
            return None;
        }
        let scaled = core::array::from_fn(|i| {
            core::array::from_fn(|j| self.products[i][j] / (scale[i] * scale[j]))
        });
        let factor = Cholesky::of(&scaled)?;
        let right: [f64; M] = core::array::from_fn(|i| self.right[i] / scale[i]);
        let solution = factor.solve(right);
        let explained: f64 = right.iter().zip(&solution).map(|(r, s)| r * s).sum();
        let inverse = factor.inverse();
        Some(Solution {
            linear: core::array::from_fn(|i| solution[i] / scale[i]),
            scaled_covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| inverse[i][j] / (scale[i] * scale[j]))
            }),
            // Rounding of the sums is all that is left of noise-free data.
            residual: (self.total - explained)
                .max(f64::EPSILON * f64::EPSILON + 1e-15 * self.total),
            log_determinant: factor.log_determinant()
                + 2.0 * scale.iter().map(|s| log(*s)).sum::<f64>(),
        })
    }
}

impl Series<'_> {
    /// Number of comparisons.
    pub fn blocks(&self) -> usize {
        self.heading_rad.len() / self.block.max(1)
    }

    /// Half of the rudder's range, rad.
    ///
    /// ```
    /// use seatrial_core::refine::Series;
    ///
    /// let series = Series {
    ///     interval_s: &[0.05, 0.05, 0.05, 0.0],
    ///     heading_rad: &[0.0; 4],
    ///     rudder_rad: &[0.0, 0.3, -0.1, 0.0],
    ///     block: 2,
    /// };
    /// assert_eq!((series.rudder_amplitude_rad(), series.blocks()), (0.2, 2));
    /// ```
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
    ///
    /// ```
    /// use seatrial_core::refine::{Disturbance, Series};
    ///
    /// // A rudder that lies still does not tell b2 from C0.
    /// let still =
    ///     Series { interval_s: &[0.05; 40], heading_rad: &[0.1; 40], rudder_rad: &[0.0; 40], block: 1 };
    /// assert!(still.fit(-1.0, Disturbance::NONE).is_none());
    /// ```
    pub fn fit(&self, a22_per_s: f64, disturbance: Disturbance) -> Option<Fit> {
        let [fit] = self.fits([a22_per_s], disturbance);
        fit
    }

    /// [`fit`](Self::fit) at several dampings in one pass over the record.
    fn fits<const N: usize>(
        &self,
        a22_per_s: [f64; N],
        disturbance: Disturbance,
    ) -> [Option<Fit>; N] {
        let mut gram = Gram::<N, { COLUMNS + 1 }>::ZERO;
        let log_variances = if disturbance.relative == 0.0 {
            let precision = self.block.max(1) as f64;
            self.compare(a22_per_s, |means, _, _| gram.add(means, Lanes::all(precision)));
            [-log(precision) * self.blocks() as f64; N]
        } else {
            let mut whitening = Whitening::new(disturbance, self.block);
            self.compare(a22_per_s, |columns, interval_s, responses| {
                gram.add_whitened(&mut whitening, columns, interval_s, responses);
            });
            whitening.log_variances()
        };
        core::array::from_fn(|lane| {
            let solution = gram.of_lane::<COLUMNS>(lane).solve()?;
            Some(solution.fit(self.degrees_of_freedom()?, log_variances[lane]))
        })
    }

    /// b2 and C0 at several dampings in one pass over the record.
    ///
    /// Under a disturbance the state at the beginning needs no columns: the first two headings determine it, and a filter that begins
    /// there has the same restricted likelihood for the other headings.
    pub fn steering_fits<const N: usize>(
        &self,
        a22_per_s: [f64; N],
        disturbance: Disturbance,
    ) -> [Option<SteeringFit>; N] {
        if disturbance.relative == 0.0 || (self.block > 1 && !self.is_even()) {
            let fits = self.fits(a22_per_s, disturbance);
            return fits.map(|fit| fit.map(SteeringFit::from));
        }
        let mut gram = Gram::<N, 3>::ZERO;
        let mut whitening = Whitening::<N, 3>::new(disturbance, self.block);
        let mut before = Before::Nothing;
        self.compare(a22_per_s, |columns, interval_s, responses| {
            let [steering @ .., _, to_rate] = columns;
            match before {
                Before::Two => {
                    gram.add_whitened(&mut whitening, steering, interval_s, responses);
                }
                Before::One(first, first_to_rate) => {
                    let turned_s = *to_rate - first_to_rate;
                    whitening.begin(&first, steering, turned_s, interval_s, responses);
                    before = Before::Two;
                }
                Before::Nothing => before = Before::One(*steering, *to_rate),
            }
        });
        let log_variances = whitening.log_variances();
        core::array::from_fn(|lane| {
            let solution = gram.of_lane::<2>(lane).solve()?;
            Some(solution.fit(self.degrees_of_freedom()?, log_variances[lane]))
        })
    }

    /// Are all intervals the same?
    fn is_even(&self) -> bool {
        let mut intervals = self.interval_s.split_last().map_or(&[][..], |(_, all)| all).iter();
        let Some(first) = intervals.next() else {
            return true;
        };
        intervals.all(|interval_s| (interval_s - first).abs() <= SAME_INTERVAL * first)
    }

    fn degrees_of_freedom(&self) -> Option<f64> {
        self.blocks().checked_sub(COLUMNS + 1).map(|n| n as f64)
    }

    /// The means over each block of the responses to b2, C0, psi0 and r0, and of the heading.
    pub fn for_each_comparison(&self, a22_per_s: f64, mut take: impl FnMut([f64; COLUMNS + 1])) {
        self.compare([a22_per_s], |means, _, _| {
            let [b2, c0, heading, psi0, r0] = means.map(|Lanes([mean])| mean);
            take([b2, c0, psi0, r0, heading]);
        });
    }

    /// Passes the block means for several dampings to `take`, with the length of the block before, s, and the responses.
    #[inline(always)]
    fn compare<const N: usize>(
        &self,
        a22_per_s: [f64; N],
        mut take: impl FnMut(&Columns<N>, f64, &Responses<N>),
    ) {
        let one = Lanes::all(1.0);
        let mut responses = Responses::new(a22_per_s);
        let (mut interval_s, mut rudder_rad) = (0.0, 0.0);
        if self.block <= 1 {
            let samples = self.interval_s.iter().zip(self.heading_rad);
            for ((next_s, heading_rad), next_rad) in samples.zip(self.rudder_rad) {
                responses.advance(interval_s, rudder_rad);
                let columns = [
                    responses.to_rudder_rad,
                    responses.to_offset_rad,
                    Lanes::all(*heading_rad),
                    one,
                    responses.to_rate_rad,
                ];
                take(&columns, interval_s, &responses);
                (interval_s, rudder_rad) = (*next_s, *next_rad);
            }
            return;
        }
        let share = 1.0 / self.block as f64;
        let mut block_s = 0.0;
        let blocks = self
            .interval_s
            .chunks_exact(self.block)
            .zip(self.heading_rad.chunks_exact(self.block))
            .zip(self.rudder_rad.chunks_exact(self.block));
        for ((next_s, heading_rad), next_rad) in blocks {
            let since_last_s = core::mem::take(&mut block_s);
            let [mut to_rudder, mut to_offset, mut to_rate] = [Lanes::ZERO; 3];
            for (next_s, next_rad) in next_s.iter().zip(next_rad) {
                responses.advance(interval_s, rudder_rad);
                to_rudder += responses.to_rudder_rad;
                to_offset += responses.to_offset_rad;
                to_rate += responses.to_rate_rad;
                (interval_s, rudder_rad) = (*next_s, *next_rad);
                block_s += interval_s;
            }
            let heading: f64 = heading_rad.iter().sum();
            let columns = [
                to_rudder * share,
                to_offset * share,
                Lanes::all(heading * share),
                one,
                to_rate * share,
            ];
            take(&columns, since_last_s, &responses);
        }
    }
}

/// What a filter has seen before a comparison.
#[derive(Clone, Copy)]
enum Before<const N: usize> {
    Nothing,
    One([Lanes<N>; 3], Lanes<N>),
    Two,
}

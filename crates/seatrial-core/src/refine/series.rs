//! A record as the likelihood takes it, and generalised least squares on it.

use libm::{log, sqrt};

use super::cholesky::Cholesky;
use super::lanes::Lanes;
use super::responses::Responses;
use super::whitening::{Disturbance, Whitening};

/// Columns of the linear model besides the heading: b2, C0, psi0, r0.
pub(super) const COLUMNS: usize = 4;

/// The columns and the heading.
const ALL: [usize; COLUMNS + 1] = [0, 1, 2, 3, 4];

/// Those that are not of the state at the beginning.
const LASTING: [usize; 3] = [0, 1, 4];

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

/// What generalised least squares gives at one damping and one disturbance.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// b2, C0, psi0, r0.
    pub linear: [f64; COLUMNS],
    /// Covariance of `linear` over the variance of the heading noise.
    pub scaled_covariance: [[f64; COLUMNS]; COLUMNS],
    /// Sum of squares of the whitened residual, rad^2.
    pub residual: f64,
    /// Variance of the heading noise of one sample, rad^2.
    pub noise_variance_rad2: f64,
    /// Restricted log likelihood, up to a constant of the record.
    pub log_likelihood: f64,
}

/// Does the filter still remember the state at the beginning?
///
/// It does until this many comparisons have added no more than a share to the squares of the innovations of psi0 and r0. What
/// they would add later changes no estimate by more than the root of that share of its standard deviation.
struct Memory<const N: usize> {
    squares: [Lanes<N>; 2],
    comparisons: u32,
    holds: bool,
}

impl<const N: usize> Memory<N> {
    const COMPARISONS: u32 = 16;
    const SHARE: f64 = 1e-12;

    fn new() -> Self {
        Self {
            squares: [Lanes::ZERO; 2],
            comparisons: 0,
            holds: true,
        }
    }

    #[inline(always)]
    fn holds_the_beginning(&mut self, gram: &Gram<N>) -> bool {
        self.comparisons += 1;
        if self.holds && self.comparisons.is_multiple_of(Self::COMPARISONS) {
            let squares = [gram.0[2][2], gram.0[3][3]];
            let added = |(now, before): (&Lanes<N>, &Lanes<N>)| {
                let grown = |(now, before): (&f64, &f64)| now - before > Self::SHARE * now;
                now.0.iter().zip(&before.0).any(grown)
            };
            self.holds = squares.iter().zip(&self.squares).any(added);
            self.squares = squares;
        }
        self.holds
    }
}

/// Sums of the products of whitened columns, above the diagonal.
struct Gram<const N: usize>([[Lanes<N>; COLUMNS + 1]; COLUMNS + 1]);

impl<const N: usize> Gram<N> {
    const ZERO: Self = Self([[Lanes::ZERO; COLUMNS + 1]; COLUMNS + 1]);

    /// Adds the products of innovations of these columns.
    #[inline(always)]
    fn add<const M: usize>(
        &mut self,
        columns: [usize; M],
        innovations: &[Lanes<N>; M],
        precision: Lanes<N>,
    ) {
        for (i, of_i) in columns.into_iter().zip(innovations) {
            let weighted = *of_i * precision;
            for (j, of_j) in columns.into_iter().zip(innovations) {
                if j >= i {
                    self.0[i][j] += weighted * *of_j;
                }
            }
        }
    }

    fn of_lane(&self, lane: usize) -> [[f64; COLUMNS + 1]; COLUMNS + 1] {
        self.0.map(|row| row.map(|element| element.0[lane]))
    }
}

impl Series<'_> {
    /// Number of comparisons.
    pub fn blocks(&self) -> usize {
        self.heading_rad.len() / self.block.max(1)
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
        let [fit] = self.fits([a22_per_s], disturbance);
        fit
    }

    /// [`fit`](Self::fit) at several dampings in one pass over the record.
    pub fn fits<const N: usize>(
        &self,
        a22_per_s: [f64; N],
        disturbance: Disturbance,
    ) -> [Option<Fit>; N] {
        let mut gram = Gram::<N>::ZERO;
        let log_variances = if disturbance.relative == 0.0 {
            let precision = Lanes::all(self.block.max(1) as f64);
            self.compare(a22_per_s, |means, _, _| gram.add(ALL, &means, precision));
            [-(self.blocks() as f64) * log(precision.0[0]); N]
        } else {
            let mut whitening = Whitening::<N, { COLUMNS + 1 }>::new(disturbance, self.block);
            let mut memory = Memory::new();
            self.compare(a22_per_s, |means, block_s, responses| {
                whitening.step(block_s, responses);
                if memory.holds_the_beginning(&gram) {
                    let innovations = whitening.innovations(ALL, &means);
                    gram.add(ALL, &innovations, whitening.precision());
                } else {
                    let innovations = whitening.innovations(LASTING, &means);
                    gram.add(LASTING, &innovations, whitening.precision());
                }
            });
            whitening.log_variances()
        };
        core::array::from_fn(|lane| self.solve(&gram.of_lane(lane), log_variances[lane]))
    }

    /// The whitened residual of each comparison, rad: white noise where nothing is left to explain.
    pub fn for_each_innovation(
        &self,
        a22_per_s: f64,
        disturbance: Disturbance,
        fit: &Fit,
        mut take: impl FnMut(f64),
    ) {
        let mut whitening = Whitening::<1, { COLUMNS + 1 }>::new(disturbance, self.block);
        self.compare([a22_per_s], |means, block_s, responses| {
            whitening.step(block_s, responses);
            let [of_columns @ .., of_heading] =
                (whitening.innovations(ALL, &means)).map(|Lanes([e])| e);
            let explained: f64 = of_columns.iter().zip(&fit.linear).map(|(e, l)| e * l).sum();
            let Lanes([precision]) = whitening.precision();
            take((of_heading - explained) * sqrt(precision));
        });
    }

    /// The means over each block of the responses to b2, C0, psi0 and r0, and of the heading.
    pub fn for_each_comparison(&self, a22_per_s: f64, mut take: impl FnMut([f64; COLUMNS + 1])) {
        self.compare([a22_per_s], |means, _, _| {
            take(means.map(|Lanes([mean])| mean));
        });
    }

    /// Passes the block means for several dampings to `take`, with the length of the block, s, and the responses after it.
    #[inline(always)]
    fn compare<const N: usize>(
        &self,
        a22_per_s: [f64; N],
        mut take: impl FnMut([Lanes<N>; COLUMNS + 1], f64, &Responses<N>),
    ) {
        let block = self.block.max(1);
        let share = 1.0 / block as f64;
        let mut responses = Responses::new(a22_per_s);
        let blocks = self
            .interval_s
            .chunks_exact(block)
            .zip(self.heading_rad.chunks_exact(block))
            .zip(self.rudder_rad.chunks_exact(block));
        for ((interval_s, heading_rad), rudder_rad) in blocks {
            let [mut to_rudder, mut to_offset, mut to_rate] = [Lanes::ZERO; 3];
            let mut heading = 0.0;
            let mut block_s = 0.0;
            for ((interval_s, heading_rad), rudder_rad) in
                interval_s.iter().zip(heading_rad).zip(rudder_rad)
            {
                to_rudder += responses.to_rudder_rad;
                to_offset += responses.to_offset_rad;
                to_rate += responses.to_rate_rad;
                heading += heading_rad;
                responses.advance(*interval_s, *rudder_rad);
                block_s += interval_s;
            }
            let [one, heading] = [1.0, heading * share].map(Lanes::all);
            let means = [
                to_rudder * share,
                to_offset * share,
                one,
                to_rate * share,
                heading,
            ];
            take(means, block_s, &responses);
        }
    }

    fn solve(&self, gram: &[[f64; COLUMNS + 1]; COLUMNS + 1], log_variances: f64) -> Option<Fit> {
        let degrees_of_freedom = self.blocks().checked_sub(COLUMNS + 1)? as f64;
        let scale: [f64; COLUMNS] = core::array::from_fn(|i| sqrt(gram[i][i]));
        if !scale.iter().all(|s| *s > 0.0) {
            return None;
        }
        let scaled = core::array::from_fn(|i| {
            core::array::from_fn(|j| gram[i.min(j)][i.max(j)] / (scale[i] * scale[j]))
        });
        let factor = Cholesky::of(&scaled)?;
        let right: [f64; COLUMNS] = core::array::from_fn(|i| gram[i][COLUMNS] / scale[i]);
        let solution = factor.solve(right);
        let explained: f64 = right.iter().zip(&solution).map(|(r, s)| r * s).sum();
        let total = gram[COLUMNS][COLUMNS];
        // Rounding of the sums is all that is left of noise-free data.
        let residual = (total - explained).max(f64::EPSILON * f64::EPSILON + 1e-15 * total);
        let log_determinant =
            factor.log_determinant() + 2.0 * scale.iter().map(|s| log(*s)).sum::<f64>();
        let inverse = factor.inverse();
        Some(Fit {
            linear: core::array::from_fn(|i| solution[i] / scale[i]),
            scaled_covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| inverse[i][j] / (scale[i] * scale[j]))
            }),
            residual,
            noise_variance_rad2: residual / degrees_of_freedom,
            log_likelihood: -0.5
                * (degrees_of_freedom * log(residual) + log_variances + log_determinant),
        })
    }
}

//! Responses of an evenly sampled record as means over comparisons, a step for each comparison instead of one for each sample.
//!
//! ```text
//! x = [delta_a, r, psi]                              the state at the first of the B samples of a comparison
//! x  <- F^B x + sum_i W_i u_(k - m - 1 + i)          i = 0..B
//! B mean(psi) = M x + sum_i V_i u_(k - m - 1 + i)
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | u, k | recorded rudder, rad; number of the comparison's first sample |
//! | m, f | the shift tau in sample intervals h: tau = (m + f) h, 0 <= f < 1 |
//! | F | the state one interval later without rudder |
//! | W_i, V_i, M | weights, made once for each dynamics |
//!
//! Exact, as the steps of [`super::response::responses`] are: over an interval the rudder is constant in two pieces, and what both do is
//! linear in them. Several dynamics go side by side.

use super::response::{Dynamics, Propagation};

/// Parts of an interval shorter than this share of it are none.
const NO_PART: f64 = 1e-8;

/// A sample's time may differ by this share of the interval from its place on an even grid: a fiftieth of what times are believed to.
pub const OFF_THE_GRID: f64 = 4e-4;

/// For each sample the first later one whose rudder is another.
pub fn held_until(rudder_rad: &[f64]) -> Vec<usize> {
    let mut until = vec![rudder_rad.len(); rudder_rad.len()];
    for k in (1..rudder_rad.len()).rev() {
        until[k - 1] = match rudder_rad[k - 1] == rudder_rad[k] {
            true => until[k],
            false => k,
        };
    }
    until
}

type Matrix = [[f64; 3]; 3];

/// x <- A x + b u over some time, x = [delta_a, r, psi].
#[derive(Clone, Copy)]
struct Piece {
    state: Matrix,
    input: [f64; 3],
}

impl Piece {
    fn of(step: &Propagation) -> Self {
        let (e, d) = (step.rudder_decay, step.rate_decay);
        let (to_rate, to_heading) = (step.lag_to_rate_s, step.lag_to_heading_s2);
        Self {
            state: [[e, 0.0, 0.0], [to_rate, d, 0.0], [to_heading, step.rate_gain_s, 1.0]],
            input: [1.0 - e, step.rate_gain_s - to_rate, step.heading_gain_s2 - to_heading],
        }
    }
}

fn times(left: &Matrix, right: &Matrix) -> Matrix {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| (0..3).map(|k| left[i][k] * right[k][j]).sum())
    })
}

fn applied(matrix: &Matrix, vector: &[f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| (0..3).map(|k| matrix[i][k] * vector[k]).sum())
}

/// One number for each set of dynamics that is computed side by side.
type Lanes<const L: usize> = [f64; L];

/// delta_a, r and psi at the end, and the sum of psi over the samples.
type Weights<const L: usize> = [Lanes<L>; 4];

/// Where the rudder of an interval's beginning acts: whole intervals late, and the rest as a share of one.
fn late(shift: f64) -> (i64, f64) {
    let (whole, part) = (shift.floor(), shift - shift.floor());
    match part {
        _ if part > 1.0 - NO_PART => (whole as i64 + 1, 0.0),
        _ if part < NO_PART => (whole as i64, 0.0),
        _ => (whole as i64, part),
    }
}

/// The weights of one dynamics: W and V of each rudder, F^B and M, and m.
struct OfOne {
    of_rudder: Vec<[f64; 4]>,
    of_state: [[f64; 3]; 4],
    whole_shifts: i64,
}

impl OfOne {
    fn new(interval_s: f64, block: usize, dynamics: &Dynamics) -> Self {
        let (whole_shifts, part) = late(dynamics.shift_s / interval_s);
        let over = |share: f64| Piece::of(&Propagation::over(dynamics, share * interval_s));
        let (late, on_time) = (over(part), over(1.0 - part));
        let interval = times(&on_time.state, &late.state);
        let inputs = [applied(&on_time.state, &late.input), on_time.input];
        let mut of_rudder = vec![[0.0; 4]; block + 1];
        // A^j, and the sum of the headings of j samples.
        let mut power: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut sum = [0.0; 3];
        for i in (0..block).rev() {
            for (place, input) in inputs.iter().enumerate() {
                let end = applied(&power, input);
                let of_sum: f64 = sum.iter().zip(input).map(|(s, b)| s * b).sum();
                for (weight, more) in
                    of_rudder[i + place].iter_mut().zip(end.iter().chain([&of_sum]))
                {
                    *weight += more;
                }
            }
            sum = core::array::from_fn(|j| sum[j] + power[2][j]);
            power = times(&power, &interval);
        }
        Self { of_rudder, of_state: [power[0], power[1], power[2], sum], whole_shifts }
    }
}

/// The responses of several dynamics to one rudder, comparison by comparison.
pub struct EvenResponses<'a, const L: usize> {
    rudder_rad: &'a [f64],
    held_until: &'a [usize],
    /// W and V of each rudder that acts in a comparison.
    of_rudder: Vec<Weights<L>>,
    /// Weights of a rudder that is held over the interval.
    of_held: Weights<L>,
    /// F^B and M.
    of_state: [[Lanes<L>; 3]; 4],
    whole: Whole<L>,
    /// How many samples before a comparison the first of these rudders is.
    behind: i64,
    rudder: [Lanes<L>; 3],
    offset: [Lanes<L>; 2],
    rate: [Lanes<L>; 2],
    first: [Lanes<L>; 3],
    next: usize,
    block: usize,
}

/// What a comparison does to the responses to the offset, to the yaw rate and to the first rudder's distance.
struct Whole<const L: usize> {
    rudder_decay: Lanes<L>,
    rate_decay: Lanes<L>,
    rate_gain_s: Lanes<L>,
    heading_gain_s2: Lanes<L>,
    lag_to_rate_s: Lanes<L>,
    lag_to_heading_s2: Lanes<L>,
    /// Sums over the samples of the gains of yaw rate and heading, and of the lag's of heading.
    rate_sum: Lanes<L>,
    heading_sum: Lanes<L>,
    lag_sum: Lanes<L>,
}

impl<const L: usize> Whole<L> {
    fn new(interval_s: f64, block: usize, dynamics: &[Dynamics; L]) -> Self {
        let over = |samples: usize| {
            dynamics.map(|of_lane| Propagation::over(&of_lane, samples as f64 * interval_s))
        };
        let whole = over(block);
        let (mut rate_sum, mut heading_sum, mut lag_sum) = ([0.0; L], [0.0; L], [0.0; L]);
        for step in (0..block).map(over) {
            for lane in 0..L {
                rate_sum[lane] += step[lane].rate_gain_s;
                heading_sum[lane] += step[lane].heading_gain_s2;
                lag_sum[lane] += step[lane].lag_to_heading_s2;
            }
        }
        Self {
            rudder_decay: whole.map(|step| step.rudder_decay),
            rate_decay: whole.map(|step| step.rate_decay),
            rate_gain_s: whole.map(|step| step.rate_gain_s),
            heading_gain_s2: whole.map(|step| step.heading_gain_s2),
            lag_to_rate_s: whole.map(|step| step.lag_to_rate_s),
            lag_to_heading_s2: whole.map(|step| step.lag_to_heading_s2),
            rate_sum,
            heading_sum,
            lag_sum,
        }
    }
}

impl<'a, const L: usize> EvenResponses<'a, L> {
    /// `held_until` is that of `rudder_rad`, of which there is at least one.
    pub fn new(
        rudder_rad: &'a [f64],
        held_until: &'a [usize],
        interval_s: f64,
        block: usize,
        dynamics: &[Dynamics; L],
    ) -> Self {
        let each = dynamics.map(|of_lane| OfOne::new(interval_s, block, &of_lane));
        let shifts = each.iter().map(|one| one.whole_shifts);
        let latest = shifts.clone().max().unwrap_or(0);
        let earliest = shifts.min().unwrap_or(0);
        let apart = usize::try_from(latest - earliest).unwrap_or(0);
        let mut of_rudder = vec![[[0.0; L]; 4]; block + 1 + apart];
        let mut of_held = [[0.0; L]; 4];
        for (lane, one) in each.iter().enumerate() {
            let sooner = usize::try_from(latest - one.whole_shifts).unwrap_or(0);
            for (of_rudder, weights) in of_rudder[sooner..].iter_mut().zip(&one.of_rudder) {
                for i in 0..4 {
                    of_rudder[i][lane] = weights[i];
                    of_held[i][lane] += weights[i];
                }
            }
        }
        Self {
            rudder_rad,
            held_until,
            of_rudder,
            of_held,
            of_state: core::array::from_fn(|i| {
                core::array::from_fn(|j| core::array::from_fn(|lane| each[lane].of_state[i][j]))
            }),
            whole: Whole::new(interval_s, block, dynamics),
            behind: latest + 1,
            rudder: [[rudder_rad[0]; L], [0.0; L], [0.0; L]],
            offset: [[0.0; L]; 2],
            rate: [[1.0; L], [0.0; L]],
            first: [[1.0; L], [0.0; L], [0.0; L]],
            next: 0,
            block,
        }
    }

    /// Means over the next comparison of the responses to b2, C0, psi0, r0 and b2 times the first rudder's distance.
    #[inline(always)]
    pub fn means(&mut self) -> [Lanes<L>; 5] {
        let n = self.block as f64;
        let share = 1.0 / n;
        let of_rudder = self.mean_of_the_rudder();
        let [mut of_offset, mut of_rate, mut of_first] = [[0.0; L]; 3];
        let whole = &self.whole;
        for l in 0..L {
            let (rate, heading) = (self.offset[0][l], self.offset[1][l]);
            of_offset[l] = share * (n * heading + whole.rate_sum[l] * rate + whole.heading_sum[l]);
            self.offset[0][l] = whole.rate_decay[l] * rate + whole.rate_gain_s[l];
            self.offset[1][l] = heading + whole.rate_gain_s[l] * rate + whole.heading_gain_s2[l];
            let (rate, heading) = (self.rate[0][l], self.rate[1][l]);
            of_rate[l] = share * (n * heading + whole.rate_sum[l] * rate);
            self.rate[0][l] = whole.rate_decay[l] * rate;
            self.rate[1][l] = heading + whole.rate_gain_s[l] * rate;
            let (away, rate) = (self.first[0][l], self.first[1][l]);
            let heading = self.first[2][l];
            let sum = n * heading + whole.rate_sum[l] * rate + whole.lag_sum[l] * away;
            of_first[l] = share * sum;
            self.first[0][l] = whole.rudder_decay[l] * away;
            self.first[1][l] = whole.rate_decay[l] * rate + whole.lag_to_rate_s[l] * away;
            self.first[2][l] =
                heading + whole.rate_gain_s[l] * rate + whole.lag_to_heading_s2[l] * away;
        }
        [of_rudder, of_offset, [1.0; L], of_rate, of_first]
    }

    /// The mean over the next comparison of the response to b2 alone.
    #[inline(always)]
    pub fn mean_of_the_rudder(&mut self) -> Lanes<L> {
        let share = 1.0 / self.block as f64;
        self.of_the_rudder().map(|sum| share * sum)
    }

    /// The sum of the headings that the rudder gives, and the state after the comparison.
    #[inline(always)]
    fn of_the_rudder(&mut self) -> Lanes<L> {
        let begin = self.next as i64 - self.behind;
        self.next += self.block;
        let last = self.rudder_rad.len() as i64 - 1;
        let more = self.of_rudder.len() as i64 - 1;
        let at = |i: i64| i.clamp(0, last) as usize;
        let first = at(begin);
        let mut sums = if self.held_until[first] as i64 > (begin + more).min(last) {
            let rudder_rad = self.rudder_rad[first];
            self.of_held.map(|of_held| of_held.map(|weight| weight * rudder_rad))
        } else if begin >= 0 && begin + more <= last {
            let rudders = &self.rudder_rad[first..=first + more as usize];
            weighted(&self.of_rudder, rudders.iter().copied())
        } else {
            let rudders = (0..=more).map(|i| self.rudder_rad[at(begin + i)]);
            weighted(&self.of_rudder, rudders)
        };
        for (sum, of_state) in sums.iter_mut().zip(&self.of_state) {
            for l in 0..L {
                sum[l] += of_state[0][l] * self.rudder[0][l]
                    + of_state[1][l] * self.rudder[1][l]
                    + of_state[2][l] * self.rudder[2][l];
            }
        }
        self.rudder = [sums[0], sums[1], sums[2]];
        sums[3]
    }
}

#[inline(always)]
fn weighted<const L: usize>(
    weights: &[Weights<L>],
    rudders: impl Iterator<Item = f64>,
) -> Weights<L> {
    let mut sums = [[0.0; L]; 4];
    for (weights, rudder) in weights.iter().zip(rudders) {
        for (sum, weights) in sums.iter_mut().zip(weights) {
            for (sum, weight) in sum.iter_mut().zip(weights) {
                *sum += weight * rudder;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::super::response::responses;
    use super::*;
    use crate::record::even_interval_s;

    /// Comparisons of every length and shift against a step for each sample.
    #[test]
    fn exact_means_are_those_of_a_step_for_each_sample() {
        let time_s: Vec<f64> = (0..211).map(|k| 0.05 * f64::from(k)).collect();
        let rudder_rad: Vec<f64> = (0..211)
            .map(|k| match k / 40 % 2 {
                0 => 0.2,
                _ => -0.1 + 0.001 * f64::from(k),
            })
            .collect();
        let held = held_until(&rudder_rad);
        let interval_s = even_interval_s(&time_s, OFF_THE_GRID).unwrap();
        for (block, lag_s, shift_s) in [
            (1, 0.0, 0.0),
            (1, 0.2, 0.013),
            (3, 0.0, 0.05),
            (4, 0.15, -0.02),
            (7, 0.3, 0.12),
            (5, 1e-6, -0.17),
        ] {
            let dynamics = Dynamics { a22_per_s: -0.9, lag_s, shift_s };
            let each = responses(&time_s, &rudder_rad, &dynamics);
            // Beside one that acts three intervals later.
            let later = Dynamics { shift_s: shift_s + 0.15, ..dynamics };
            let both = [dynamics, later];
            let mut even = EvenResponses::new(&rudder_rad, &held, interval_s, block, &both);
            for rows in each.chunks_exact(block) {
                let means = even.means();
                for (i, [found, _]) in means.iter().enumerate() {
                    let expected = rows.iter().map(|row| row[i]).sum::<f64>() / block as f64;
                    // Rounding of two hundred steps.
                    assert!((found - expected).abs() < 1e-11, "{block} {i} {found} {expected}");
                }
            }
        }
    }
}

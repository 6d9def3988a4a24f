//! Was the yaw rate computed from the heading?
//!
//! ```text
//! r_k = sum over 0 < |i| <= p of a_i r_(k+i)  +  sum over |j| <= w of c_j d_(k+j)  +  c,
//! d_k = (psi_(k+1) - psi_k) / (t_(k+1) - t_k)
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | r, psi, t | yaw rate, rad/s, heading, rad, and time, s, of a row |
//! | p, w | neighbours of the yaw rate, and differences of the heading on either side |
//!
//! Differences, polynomials through neighbours, moving means and recursive filters of the heading are all of this form, so that the noise of
//! the heading explains that of the yaw rate to within rounding. The noise of a gyro is in no heading. Where the heading has no noise, its
//! differences are those of the vehicle, and only a column that equals a difference of two rows counts as computed.

use crate::record::{median, turned_rad};
use nalgebra::{DMatrix, DVector};
use seatrial_core::Sample;

/// Neighbours of the yaw rate on one side: those of a filter of third order that runs both ways.
const NEIGHBOURS: usize = 3;
/// Differences of the heading on one side: those of a mean over a second at 20 Hz.
const DIFFERENCES: usize = 20;
/// Rows that are looked at.
const MOST_ROWS: usize = 4000;
/// What the heading leaves of the yaw rate over what its neighbours leave. Of computed columns up to
/// 0.004 is left, of gyros 0.9 or more.
const LARGEST_REST: f64 = 0.1;
/// The correlation of third differences in a row: -0.75 of white noise, -0.67 of a mean of it, 1 without noise.
const NOISE: f64 = -0.4;
/// Of a compass, and by how much more it is of a smoothed heading: half of the way to that, and three deviations of chance.
const WHITE: f64 = -0.75;
const LEAST_SMOOTHED: f64 = 0.035;
const CHANCE: f64 = 1.3;
/// The share of equal neighbours from which the steps of a heading hide its noise.
const MOST_EQUAL: f64 = 0.25;
/// Beyond it there is more motion than noise.
const LEAST_NOISE: f64 = -0.5;
/// Rows apart at which noise has nothing in common.
const MOTION: std::ops::RangeInclusive<usize> = 4..=12;
/// For a normal matrix of columns that depend on each other.
const RIDGE: f64 = 1e-11;

/// Is the yaw rate a function of the heading?
pub(super) fn is_derived(samples: &[Sample<f64>]) -> bool {
    is_difference(samples) || is_filtered(samples)
}

/// Is the yaw rate a filter of the heading's differences, by noise that the two have in common?
fn is_filtered(samples: &[Sample<f64>]) -> bool {
    let slopes = slopes(samples);
    if !is_noisy(&slopes) {
        return false;
    }
    let rates = |at: usize| samples[at].yaw_rate_rad_s.unwrap_or(f64::NAN);
    let reach = DIFFERENCES + 1;
    let every = samples.len().div_ceil(MOST_ROWS).max(1);
    let rows = (reach..samples.len().saturating_sub(reach)).step_by(every);
    let (mut terms, mut targets, mut count) = (Vec::new(), Vec::new(), 0);
    for row in rows {
        let from = terms.len();
        terms.push(1.0);
        for neighbour in 1..=NEIGHBOURS {
            terms.extend([rates(row - neighbour), rates(row + neighbour)]);
        }
        terms.extend_from_slice(&slopes[row - reach..row + DIFFERENCES]);
        terms.push(gradient(&samples[row - 1..=row + 1], &slopes[row - 1..=row]));
        if terms[from..].iter().all(|term| term.is_finite()) && rates(row).is_finite() {
            targets.push(rates(row));
            count += 1;
        } else {
            terms.truncate(from);
        }
    }
    let width = 2 * (NEIGHBOURS + DIFFERENCES + 1) + 1;
    if count < 4 * width {
        return false;
    }
    let terms = DMatrix::from_row_slice(count, width, &terms);
    let targets = DVector::from_vec(targets);
    let own = rest(&terms.columns(0, 1 + 2 * NEIGHBOURS).into_owned(), &targets);
    let both = rest(&terms, &targets);
    matches!((own, both), (Some(own), Some(both)) if both < LARGEST_REST * own)
}

/// The slope in the middle of three rows of a parabola through them.
fn gradient(three: &[Sample<f64>], slopes: &[f64]) -> f64 {
    let [before_s, after_s] = [0, 1].map(|row| three[row + 1].time_s - three[row].time_s);
    (after_s * slopes[0] + before_s * slopes[1]) / (before_s + after_s)
}

/// The median of what a fit of least squares leaves.
fn rest(terms: &DMatrix<f64>, targets: &DVector<f64>) -> Option<f64> {
    let mut normal = terms.tr_mul(terms);
    for place in 0..normal.nrows() {
        normal[(place, place)] *= 1.0 + RIDGE;
    }
    let found = normal.cholesky()?.solve(&terms.tr_mul(targets));
    median((targets - terms * found).iter().map(|r| r.abs()).collect())
}

/// Do differences of a heading alternate as noise does?
fn is_noisy(slopes: &[f64]) -> bool {
    correlation(&third_differences(slopes), 1) < NOISE
}

fn third_differences(slopes: &[f64]) -> Vec<f64> {
    let third = |three: &[f64]| three[2] - 2.0 * three[1] + three[0];
    let thirds = slopes.windows(3).map(third);
    thirds.filter(|third| third.is_finite()).collect()
}

/// The correlation of numbers so many rows apart whose mean is 0.
fn correlation(numbers: &[f64], rows: usize) -> f64 {
    let square: f64 = numbers.iter().map(|number| number * number).sum();
    let later = numbers.iter().skip(rows);
    let lagged: f64 = numbers.iter().zip(later).map(|(one, other)| one * other).sum();
    lagged / square
}

/// Was the heading smoothed, so that the noise of a row is in those behind it, too? Then its differences are as white as the noise of a
/// compass is itself. A heading without noise, or in steps that hide it, may be either.
///
/// ```text
/// rho = (rho_1 - m) / (1 - m),   m = mean of rho_4 to rho_12
/// ```
///
/// `rho_i` is the correlation of third differences i rows apart and m the share that the vehicle's own motion has in them; rho is -0.75 of
/// a compass, and -0.67 behind a filter.
pub fn heading_is_smoothed(samples: &[Sample<f64>]) -> bool {
    let slopes = slopes(samples);
    let equal = slopes.iter().filter(|slope| **slope == 0.0).count();
    if equal as f64 > MOST_EQUAL * slopes.len() as f64 {
        return false;
    }
    let thirds = third_differences(&slopes);
    let motion = MOTION.map(|rows| correlation(&thirds, rows)).sum::<f64>() / MOTION.count() as f64;
    let noise = (correlation(&thirds, 1) - motion) / (1.0 - motion);
    let chance = CHANCE / (thirds.len() as f64).sqrt();
    noise > WHITE + chance.max(LEAST_SMOOTHED) && noise < LEAST_NOISE
}

fn slopes(samples: &[Sample<f64>]) -> Vec<f64> {
    let slope =
        |pair: &[Sample<f64>]| turned_rad(&pair[0], &pair[1]) / (pair[1].time_s - pair[0].time_s);
    samples.windows(2).map(slope).collect()
}

/// Nearly all yaw rates of a column that was computed agree; ends and turns through north may not.
const DERIVED: f64 = 0.95;
/// Rounding of the heading by a larger share of its differences hides how the column was made.
const LARGEST_ROUNDING: f64 = 0.02;
/// Fewer rows tell nothing.
const LEAST_ROWS: usize = 20;
/// Relative; what arithmetic in single precision leaves of a difference.
const ARITHMETIC: f64 = 1e-5;
/// A change is a whole number of steps if it is within so much of one.
const WHOLE: f64 = 0.1;

/// The step to which a column was rounded, from its changes; 0 where they are no whole numbers of a step.
fn resolution(changes: impl Iterator<Item = f64> + Clone) -> f64 {
    let changes = changes.map(f64::abs).filter(|change| *change > 0.0);
    let step = changes.clone().fold(f64::INFINITY, f64::min);
    let is_whole = |change: f64| (change / step - (change / step).round()).abs() < WHOLE;
    let (all, whole) = changes
        .fold((0.0, 0.0), |(all, whole), change| (all + 1.0, whole + f64::from(is_whole(change))));
    if step.is_finite() && whole >= DERIVED * all { step } else { 0.0 }
}

/// Is the yaw rate a difference of the heading over the row before, the next, or both, within the rounding of the heading?
fn is_difference(samples: &[Sample<f64>]) -> bool {
    let slope = |one: &Sample<f64>, other: &Sample<f64>| {
        turned_rad(one, other) / (other.time_s - one.time_s)
    };
    if samples.len() < LEAST_ROWS {
        return false;
    }
    let pairs = || samples.windows(2).map(|pair| (&pair[0], &pair[1]));
    let resolution_rad = resolution(pairs().map(|(one, other)| turned_rad(one, other)));
    let resolution_rad_s = resolution(
        pairs().filter_map(|(one, other)| Some(other.yaw_rate_rad_s? - one.yaw_rate_rad_s?)),
    );
    // The row before and this one, this one and the next, both neighbours.
    let ways = [[0, 1], [1, 2], [0, 2]];
    ways.into_iter().any(|[from, to]| {
        let mut square = 0.0;
        let mut agreeing = 0;
        let mut largest_rounding = 0.0_f64;
        for three in samples.windows(3) {
            let (one, other) = (&three[from], &three[to]);
            let slope = slope(one, other);
            let rounding = 2.0 * resolution_rad / (other.time_s - one.time_s);
            largest_rounding = largest_rounding.max(rounding);
            square += slope * slope;
            let agrees = |rate: f64| {
                (rate - slope).abs() <= rounding + resolution_rad_s + ARITHMETIC * slope.abs()
            };
            agreeing += usize::from(three[1].yaw_rate_rad_s.is_some_and(agrees));
        }
        let count = (samples.len() - 2) as f64;
        largest_rounding < LARGEST_ROUNDING * (square / count).sqrt()
            && agreeing as f64 >= DERIVED * count
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    const ROWS: usize = 1600;
    const INTERVAL_S: f64 = 0.1;

    /// A boat of 2 s and 0.6 1/s in doublets of 20 deg: true headings and yaw rates, rad and rad/s.
    fn boat() -> Vec<[f64; 2]> {
        let (mut heading, mut rate) = (1.5, 0.0);
        let row = |row: usize| {
            let rudder = match row / 40 % 4 {
                0 => 0.35,
                2 => -0.35,
                _ => 0.0,
            };
            let held = libm::exp(-INTERVAL_S / 2.0);
            let end = 0.6 * rudder;
            heading += end * INTERVAL_S + (rate - end) * 2.0 * (1.0 - held);
            rate = end + (rate - end) * held;
            [heading, rate]
        };
        (0..ROWS).map(row).collect()
    }

    /// Rows with headings of this noise, rad, and the rates that a program or an instrument gives.
    fn rows(noise_rad: f64, rates: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> Vec<Sample<f64>> {
        let mut draw = Draw::new(5);
        let (headings, truth): (Vec<f64>, Vec<f64>) = boat()
            .into_iter()
            .map(|[heading, rate]| (heading + noise_rad * draw.normal(), rate))
            .unzip();
        let rates = rates(&headings, &truth);
        let row = |row: usize| Sample {
            time_s: INTERVAL_S * row as f64,
            heading_rad: headings[row],
            // Six digits, as spreadsheets have them.
            yaw_rate_rad_s: Some((rates[row] * 1e6).round() / 1e6),
            ..Sample::default()
        };
        (0..ROWS).map(row).collect()
    }

    fn difference(headings: &[f64]) -> Vec<f64> {
        let last = headings.len() - 1;
        let slope = |row: usize| {
            let (before, after) = (row.saturating_sub(1), (row + 1).min(last));
            (headings[after] - headings[before]) / ((after - before) as f64 * INTERVAL_S)
        };
        (0..=last).map(slope).collect()
    }

    fn low_passed(numbers: &[f64], share: f64) -> Vec<f64> {
        let mut state = numbers[0];
        let follow = |number: &f64| {
            state += share * (number - state);
            state
        };
        numbers.iter().map(follow).collect()
    }

    fn averaged(numbers: &[f64], reach: usize) -> Vec<f64> {
        let mean = |row: usize| {
            let part = &numbers[row.saturating_sub(reach)..(row + reach + 1).min(numbers.len())];
            part.iter().sum::<f64>() / part.len() as f64
        };
        (0..numbers.len()).map(mean).collect()
    }

    #[test]
    fn recover_rates_computed_from_a_heading() {
        type Way = fn(&[f64]) -> Vec<f64>;
        let ways: [(&str, Way); 6] = [
            ("a difference", difference),
            ("a mean of differences", |h| averaged(&difference(h), 5)),
            ("a difference of means", |h| difference(&averaged(h, 8))),
            ("a low pass", |h| low_passed(&difference(h), 0.2)),
            ("two low passes", |h| low_passed(&low_passed(&difference(h), 0.2), 0.2)),
            ("a low pass both ways", |h| {
                let mut once = low_passed(&difference(h), 0.3);
                once.reverse();
                let mut twice = low_passed(&once, 0.3);
                twice.reverse();
                twice
            }),
        ];
        for noise_deg in [0.05_f64, 0.25, 1.0] {
            for (name, way) in ways {
                let rows = rows(noise_deg.to_radians(), |headings, _| way(headings));
                assert!(is_derived(&rows), "{name} of {noise_deg} deg");
            }
        }
    }

    #[test]
    fn recover_a_smoothed_heading_by_its_noise() {
        for noise_deg in [0.05_f64, 0.25, 1.0] {
            let measured = rows(noise_deg.to_radians(), |_, truth| truth.to_vec());
            let smoothed = |smooth: &dyn Fn(&[f64]) -> Vec<f64>| {
                let headings: Vec<f64> = measured.iter().map(|row| row.heading_rad).collect();
                let mut rows = measured.clone();
                for (row, heading_rad) in rows.iter_mut().zip(smooth(&headings)) {
                    row.heading_rad = heading_rad;
                }
                heading_is_smoothed(&rows)
            };
            assert!(!heading_is_smoothed(&measured), "{noise_deg}");
            assert!(smoothed(&|h| low_passed(h, 0.06)), "{noise_deg}");
            assert!(smoothed(&|h| low_passed(h, 0.3)), "{noise_deg}");
            assert!(smoothed(&|h| averaged(h, 8)), "{noise_deg}");
            let whole_rad = noise_deg.to_radians();
            let rounded =
                |h: &[f64]| h.iter().map(|h| (h / whole_rad).round() * whole_rad).collect();
            assert!(!smoothed(&rounded), "{noise_deg}");
        }
        // Without noise it may be either.
        assert!(!heading_is_smoothed(&rows(0.0, |_, truth| truth.to_vec())));
    }

    #[test]
    fn recover_rates_of_a_gyro() {
        for noise_deg in [0.0, 0.01_f64, 0.05, 0.25, 1.0] {
            for gyro_deg_s in [0.0, 0.002_f64, 0.05, 0.3, 1.0] {
                let rows = rows(noise_deg.to_radians(), |_, truth| {
                    let mut draw = Draw::new(6);
                    let noisy = |rate: &f64| rate + gyro_deg_s.to_radians() * draw.normal();
                    truth.iter().map(noisy).collect()
                });
                assert!(!is_derived(&rows), "{gyro_deg_s} deg/s beside {noise_deg} deg");
            }
        }
    }
}

//! Was the heading interpolated between values that are rarer than its rows?
//!
//! ```text
//! c_k = (psi_(k+1) - psi_k) / (t_(k+1) - t_k) - (psi_k - psi_(k-1)) / (t_k - t_(k-1))
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | psi, t | heading, rad, and time, s, of a row |
//! | c | what the slope changes by at a row, rad/s: rounding alone on a straight line, more at a value that was measured |
//!
//! A compass has noise in every row, and a vehicle without noise turns on a curve. Straight lines that all end after the same number of rows
//! are a program's. Where it took the numbers of 359 and 1 deg for far apart, its lines pass through south.

use seatrial_core::{Real, Sample};

use super::doubt::Doubt;
use super::stood::{COMES_BACK, usual};
use super::units::{WRAP, numbers};
use crate::record::{Record, turns_rad};

/// Fewer lines tell nothing.
const LEAST_LINES: usize = 20;
/// The share of lines that are as long as the others; a value on the line through its neighbours makes one twice as long.
const EVEN: f64 = 0.9;
/// Headings so near to north, rad, are beside it, and so many rows beside a sweep are left out and looked at.
const BESIDE_NORTH_RAD: f64 = 0.5;
const SWEEP_ROWS: usize = 5;
/// Relative; what arithmetic leaves of a straight line.
const ARITHMETIC: f64 = 1e-9;
/// The most decimals that a rounded number has, and how far it is then from a whole number of the last.
const MOST_DECIMALS: i32 = 7;
const WHOLE: f64 = 1e-3;

/// Leaves the rows out whose heading was interpolated. The rudder of a row that is kept is the mean until the next.
pub(super) fn leave_out_interpolated(record: &mut Record) {
    let samples = &record.samples;
    let Some(kept) = measured_rows(samples, rounding_rad(record)) else {
        return;
    };
    let first_s = samples[kept[0]].time_s;
    let last_s = samples[kept[kept.len() - 1]].time_s;
    let measured = kept.windows(2).map(|pair| {
        let mut turned = 0.0;
        for rows in samples[pair[0]..=pair[1]].windows(2) {
            turned += rows[0].rudder_rad * (rows[1].time_s - rows[0].time_s);
        }
        let (from, to) = (&samples[pair[0]], &samples[pair[1]]);
        Sample { rudder_rad: turned / (to.time_s - from.time_s), ..*from }
    });
    record.units.heading_every_s = Some((last_s - first_s) / (kept.len() - 1) as f64);
    record.samples = measured.collect();
}

/// The rows in which a heading was measured that is interpolated in the others.
fn measured_rows(samples: &[Sample<f64>], rounding_rad: f64) -> Option<Vec<usize>> {
    let steps: Vec<f64> = turns_rad(samples).collect();
    let is_bend = |at: &usize| {
        let (before, after) = (steps[at - 1], steps[*at]);
        let time_s = |row: usize| samples[row + 1].time_s - samples[row].time_s;
        let bend = after - before * time_s(*at) / time_s(at - 1);
        // Half a step of each of three headings, the middle one twice.
        let limit = 2.0 * rounding_rad + ARITHMETIC * (1.0 + before.abs() + after.abs());
        bend.abs() > limit
    };
    let bends: Vec<usize> = (1..steps.len()).filter(is_bend).collect();
    let mut lengths: Vec<usize> = bends.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if lengths.len() < LEAST_LINES {
        return None;
    }
    let middle = lengths.len() / 2;
    let rows = *lengths.select_nth_unstable(middle).1;
    let even = lengths.iter().filter(|length| **length % rows == 0).count();
    let on_a_line = steps.iter().filter(|step| **step != 0.0).count();
    // A heading that is held is none: it moves in one row of a line.
    let is_interpolated =
        rows > 1 && even as f64 >= EVEN * lengths.len() as f64 && 2 * on_a_line > steps.len();
    is_interpolated.then(|| with_unbent(&bends, rows))
}

/// The last decimal of the headings in the file; 0 where they are not rounded.
fn rounding_rad(record: &Record) -> f64 {
    let unit = &record.units.heading;
    let headings = numbers(record, |sample| sample.heading_rad, unit);
    let is_rounded = |decimals: &i32| {
        let scale = 10_f64.powi(*decimals);
        let is_whole = |number: &f64| (number * scale - (number * scale).round()).abs() < WHOLE;
        headings.iter().all(is_whole)
    };
    let decimals = (0..=MOST_DECIMALS).find(is_rounded);
    decimals.map_or(0.0, |decimals| 10_f64.powi(-decimals) / unit.per_si)
}

/// The rows of the bends, and those between them at which a value lay on the line.
fn with_unbent(bends: &[usize], rows: usize) -> Vec<usize> {
    let between = bends.windows(2).flat_map(|pair| (pair[0]..pair[1]).step_by(rows));
    between.chain(bends.last().copied()).collect()
}

/// The first time at which headings lie between two on either side of north as numbers do.
pub(super) fn through_south(record: &Record) -> Option<Doubt> {
    let turn_rad = std::f64::consts::TAU;
    let headings: Vec<f64> =
        (record.samples.iter()).map(|sample| sample.heading_rad.rem_euclid(turn_rad)).collect();
    let sizes: Vec<f64> = turns_rad(&record.samples).map(f64::abs).collect();
    let usual_rad = usual(&sizes);
    let is_far = |row: usize| sizes[row] > COMES_BACK * usual_rad;
    let passes = |from: &usize| {
        let mut to = *from;
        // Rows from one side of north to the other, each further on than a vehicle turns.
        while to < sizes.len() && is_far(to) {
            to += 1;
        }
        let way = headings[to] - headings[*from];
        let goes_on = |pair: &[f64]| (pair[1] - pair[0]) * way > 0.0;
        to > *from + 1
            && way.abs() > WRAP * turn_rad
            && headings[*from..=to].windows(2).all(goes_on)
    };
    let from = (0..sizes.len())
        .filter(|row| is_far(*row))
        .find(passes)
        .or_else(|| sweep(&headings, COMES_BACK * usual_rad))?;
    Some(Doubt::HeadingThroughSouth { time_s: record.samples[from + 1].time_s })
}

/// The row before a sweep from one side of north to the other through south, while before and behind it the heading goes the other way:
/// a mean over many rows. A vehicle that turns through south goes on so.
fn sweep(headings: &[f64], fast_rad: f64) -> Option<usize> {
    let turn_rad = std::f64::consts::TAU;
    let is_north = |heading: &f64| Real::wrapped(*heading).abs() < BESIDE_NORTH_RAD;
    let change =
        |from: usize, to: usize| Some(Real::wrapped(headings.get(to)? - headings.get(from)?));
    let goes_back = |from: usize, to: &usize| {
        let way = headings[*to] - headings[from];
        let before = change(from.checked_sub(2 * SWEEP_ROWS)?, from - SWEEP_ROWS)?;
        let behind = change(to + SWEEP_ROWS, to + 2 * SWEEP_ROWS)?;
        let rows = (to - from) as f64;
        Some(
            way.abs() > WRAP * turn_rad
                && way.abs() > fast_rad * rows
                && before * way < 0.0
                && behind * way < 0.0,
        )
    };
    let leaves = |row: &usize| is_north(&headings[*row]) && !is_north(&headings[row + 1]);
    (0..headings.len().saturating_sub(1)).filter(leaves).find(|from| {
        let to = (from + 1..headings.len()).find(|row| is_north(&headings[*row]));
        to.is_some_and(|to| goes_back(*from, &to) == Some(true))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;

    const INTERVAL_S: f64 = 0.1;

    /// A turn to and fro through north with the noise of a compass, to a hundredth of a degree.
    fn measured(noise_deg: f64) -> Vec<f64> {
        let mut draw = Draw::new(3);
        let heading = |row: usize| {
            let deg = 40.0 * (0.3 * INTERVAL_S * row as f64).sin() + noise_deg * draw.normal();
            (100.0 * deg).round() / 100.0
        };
        (0..2000).map(heading).collect()
    }

    /// Every so many headings and straight lines between them.
    fn lines(headings: &[f64], rows: usize, of_numbers: bool) -> Vec<f64> {
        let at = |row: usize| {
            let from = row / rows * rows;
            let to = (from + rows).min(headings.len() - 1);
            let number = |row: usize| match of_numbers {
                true => headings[row].rem_euclid(360.0),
                false => headings[row],
            };
            let share = (row - from) as f64 / rows as f64;
            let deg = number(from) + share * (number(to) - number(from));
            (1e4 * deg).round() / 1e4
        };
        (0..headings.len() / rows * rows).map(at).collect()
    }

    fn record(headings_deg: &[f64]) -> Record {
        let sample = |(row, deg): (usize, &f64)| Sample {
            time_s: INTERVAL_S * row as f64,
            heading_rad: deg.rem_euclid(360.0).to_radians(),
            rudder_rad: 0.01 * (row % 10) as f64,
            ..Sample::default()
        };
        let mut record: Record = headings_deg.iter().enumerate().map(sample).collect();
        record.units.heading.per_si = 1.0_f64.to_degrees();
        record
    }

    #[test]
    fn recover_the_rows_of_an_interpolated_heading() {
        for rows in [2, 3, 5, 10, 20] {
            for of_numbers in [false, true] {
                let headings = measured(0.3);
                let mut record = record(&lines(&headings, rows, of_numbers));
                leave_out_interpolated(&mut record);
                let every_s = record.units.heading_every_s.unwrap();
                assert!((every_s - INTERVAL_S * rows as f64).abs() < 1e-9, "{rows}");
                assert!(record.samples.len() > headings.len() / rows - 8, "{rows}");
                for sample in &record.samples {
                    let row = (sample.time_s / INTERVAL_S).round() as usize;
                    let error = Real::wrapped(sample.heading_rad - headings[row].to_radians());
                    assert!(error.abs() < 1e-6, "{rows}");
                }
                assert_eq!(through_south(&record), None);
            }
        }
    }

    #[test]
    fn exact_headings_of_every_row_are_kept() {
        let held: Vec<f64> = (0..2000).map(|row| measured(0.3)[row / 5 * 5]).collect();
        let coarse: Vec<f64> = measured(0.1).iter().map(|deg| deg.round()).collect();
        for headings in [measured(0.0), measured(0.01), measured(0.3), held, coarse] {
            let mut record = record(&headings);
            leave_out_interpolated(&mut record);
            assert_eq!(record.samples.len(), headings.len());
            assert_eq!(through_south(&record), None);
        }
    }

    #[test]
    fn exact_the_rudder_is_the_mean_between_measured_headings() {
        let mut record = record(&lines(&measured(0.3), 10, false));
        leave_out_interpolated(&mut record);
        // The mean of 0 to 0.09.
        assert!((record.samples[3].rudder_rad - 0.045).abs() < 1e-9);
    }

    #[test]
    fn exact_an_interpolated_heading_is_named() {
        let mut record = record(&lines(&measured(0.3), 5, false));
        leave_out_interpolated(&mut record);
        let doubts = super::super::unit_doubts(&record);
        let found = matches!(doubts[..], [Doubt::HeadingInterpolated { every_s }] if (every_s - 5.0 * INTERVAL_S).abs() < 1e-9);
        assert!(found, "{doubts:?}");
    }

    /// A mean over many rows, and a vehicle that turns through south itself.
    #[test]
    fn recover_a_mean_of_many_numbers_about_north() {
        let headings: Vec<f64> = measured(0.1).iter().map(|deg| deg.rem_euclid(360.0)).collect();
        let mean = |row: usize| headings[row..row + 15].iter().sum::<f64>() / 15.0;
        let means: Vec<f64> = (0..headings.len() - 15).map(mean).collect();
        assert!(through_south(&record(&means)).is_some());
        let circles =
            |row: usize| 350.0 + 0.05 * row as f64 + 4.0 * (row as f64 - 900.0).clamp(0.0, 100.0);
        let circling: Vec<f64> = (0..2000).map(|row| circles(row).rem_euclid(360.0)).collect();
        assert_eq!(through_south(&record(&circling)), None);
        let back: Vec<f64> = circling.iter().map(|deg| 360.0 - deg).collect();
        assert_eq!(through_south(&record(&back)), None);
    }

    #[test]
    fn recover_a_mean_of_numbers_about_north() {
        let mut headings: Vec<f64> =
            measured(0.2).iter().map(|deg| deg.rem_euclid(360.0)).collect();
        let north = (1..headings.len())
            .find(|row| (headings[*row] - headings[row - 1]).abs() > 300.0)
            .unwrap();
        headings[north] = 180.0;
        let found = through_south(&record(&headings));
        let time_s = INTERVAL_S * north as f64;
        assert_eq!(found, Some(Doubt::HeadingThroughSouth { time_s }));
    }
}

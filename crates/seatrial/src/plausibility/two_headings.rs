//! Is one of two headings of a log late or smoothed beside the other?
//!
//! ```text
//! s = arg min var(psi(t) - psi'(t - s))
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | psi, psi' | the heading that is read and the other one, rad, unwrapped |
//! | s | the time by which the one that is read is later, s |

use seatrial_core::Sample;

use crate::record::{median_interval_s, unwrapped_rad};

/// The latest heading that is looked for, s, and how many shifts are tried.
const LATEST_S: f64 = 12.0;
const SHIFTS: usize = 120;
/// Rows that are compared.
const MOST_ROWS: usize = 2000;
/// A shift explains that two headings part where so much of their variance is left.
const LEFT: f64 = 0.25;
/// Shifts fit alike that leave so many times the least.
const ALIKE: f64 = 1.5;
/// A heading that is late by less is left to its own tests, s.
const LEAST_S: f64 = 0.1;

/// The time by which the heading of one reading of a log is later than that of another reading, s; `None` where it is not.
///
/// ```
/// use seatrial::Sample;
/// use seatrial::log::heading_later_s;
///
/// let read = |late_s: f64| {
///     let at = |k: i32| 0.1 * f64::from(k);
///     let heading_rad = |time_s: f64| (0.3 * time_s).sin() + 0.5 * (0.71 * time_s).sin();
///     (0..600)
///         .map(|k| Sample {
///             time_s: at(k),
///             heading_rad: heading_rad(at(k) - late_s),
///             ..Sample::default()
///         })
///         .collect::<Vec<_>>()
/// };
/// let late_s = heading_later_s(&read(1.0), &read(0.0));
/// assert!(late_s.is_some_and(|late_s| (late_s - 1.0).abs() < 0.11));
/// assert_eq!(heading_later_s(&read(0.0), &read(0.0)), None);
/// ```
pub fn heading_later_s(read: &[Sample<f64>], other: &[Sample<f64>]) -> Option<f64> {
    let interval_s = median_interval_s(read)?;
    let (read, other) = (unwrapped(read), unwrapped(other));
    let step_s = interval_s.max(LATEST_S / SHIFTS as f64);
    let shifts = ((LATEST_S / step_s) as usize).min(SHIFTS);
    let mut tried: Vec<(f64, f64)> = Vec::new();
    for shift in (0..=shifts).flat_map(|shift| [shift as f64, -(shift as f64)]) {
        let late_s = step_s * shift;
        tried.push((late_s, variance_apart(&read, &other, late_s)));
    }
    let least = tried.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
    // Of a weave that repeats itself, the nearest of all shifts that fit alike.
    let (late_s, left) = *tried.iter().find(|(_, left)| *left <= ALIKE * least)?;
    (late_s > LEAST_S && left < LEFT * tried[0].1).then_some(late_s)
}

/// Times and headings, rad, through north.
fn unwrapped(samples: &[Sample<f64>]) -> Vec<(f64, f64)> {
    let usable = || samples.iter().filter(|s| s.heading_rad.is_finite());
    let first_rad = usable().next().map_or(0.0, |s| s.heading_rad);
    let headings_rad = unwrapped_rad(first_rad, usable().map(|s| s.heading_rad));
    usable().map(|s| s.time_s).zip(headings_rad).collect()
}

fn variance_apart(read: &[(f64, f64)], other: &[(f64, f64)], late_s: f64) -> f64 {
    let every = read.len().div_ceil(MOST_ROWS).max(1);
    let (mut count, mut sum, mut square) = (0.0, 0.0, 0.0);
    for (time_s, heading_rad) in read.iter().step_by(every) {
        // The same rows at every shift.
        let is_inside = time_s - LATEST_S > read[0].0 && time_s + LATEST_S < read[read.len() - 1].0;
        let Some(at) = at(other, time_s - late_s).filter(|_| is_inside) else {
            continue;
        };
        let apart = heading_rad - at;
        (count, sum, square) = (count + 1.0, sum + apart, square + apart * apart);
    }
    match count > 0.0 {
        true => square / count - (sum / count) * (sum / count),
        false => f64::INFINITY,
    }
}

/// On the straight line between two rows.
fn at(rows: &[(f64, f64)], time_s: f64) -> Option<f64> {
    let after = rows.partition_point(|(t, _)| *t < time_s);
    let ((t_0, a), (t_1, b)) = (rows.get(after.checked_sub(1)?)?, rows.get(after)?);
    Some(a + (b - a) * (time_s - t_0) / (t_1 - t_0))
}

#[cfg(test)]
mod tests {
    use seatrial_core::Real;

    use super::*;
    use crate::draw::Draw;

    /// A weave through north with noise, late or smoothed by so much.
    fn weave(late_s: f64, smoothed_s: f64, seed: u64) -> Vec<Sample<f64>> {
        let mut draw = Draw::new(seed);
        let mut state = 0.0;
        (0..2000)
            .map(|row| {
                let time_s = 0.05 * f64::from(row);
                let phase = 0.5 * (time_s - late_s);
                let true_rad = 0.4 * phase.sin() + 0.2 * (2.3 * phase).cos();
                state += (true_rad - state) * (0.05 / smoothed_s.max(0.05));
                Sample {
                    time_s,
                    heading_rad: Real::wrapped(state + 0.004 * draw.normal()),
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn recover_which_of_two_headings_is_late() {
        let sound = weave(0.0, 0.0, 1);
        for (late_s, smoothed_s) in [(1.0, 0.0), (0.3, 0.0), (4.0, 0.0), (0.0, 1.0)] {
            let late = weave(late_s, smoothed_s, 2);
            let found = heading_later_s(&late, &sound).unwrap();
            // A grid of 0.1 s; a low-pass filter is late by its time constant where the vehicle turns slowly, by less where fast.
            assert!((found - late_s - 0.7 * smoothed_s).abs() < 0.2, "{found}");
            assert_eq!(heading_later_s(&sound, &late), None);
        }
        assert_eq!(heading_later_s(&weave(0.0, 0.0, 3), &sound), None);
    }
}

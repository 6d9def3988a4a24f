//! Did the heading stand still while the vehicle turned?
//!
//! A heading that otherwise changes from row to row and is the same for a while was not measured then.

use seatrial_core::Sample;

use super::doubt::Doubt;
use crate::record::turns_rad;

/// Rows and time that are no chance, s.
const LEAST_ROWS: usize = 15;
const LEAST_TIME_S: f64 = 0.7;
/// The share of all other rows in which the heading changes.
const CHANGING: f64 = 0.9;
/// How far the yaw rate says that it turned meanwhile, there and back, rad.
const LEAST_TURN_RAD: f64 = 0.02;
/// Without a yaw rate: the step with which the heading comes back, in usual steps.
pub(super) const COMES_BACK: f64 = 10.0;

/// The longest time for which the heading stood still, where the yaw rate, or the step after it, shows that the vehicle turned.
pub fn heading_stood(samples: &[Sample<f64>]) -> Option<Doubt> {
    let steps: Vec<f64> = turns_rad(samples).map(f64::abs).collect();
    let (from, to) = longest_run(&steps)?;
    let (first, last) = (&samples[from], &samples[to]);
    let for_s = last.time_s - first.time_s;
    let others = steps.len() - (to - from);
    let changing = steps.iter().filter(|step| **step > 0.0).count();
    let is_chance = to - from < LEAST_ROWS || for_s < LEAST_TIME_S;
    if is_chance || (changing as f64) < CHANGING * others as f64 {
        return None;
    }
    let has_turned = match turned_rad(&samples[from..=to]) {
        Some(turned) => turned > LEAST_TURN_RAD,
        None => steps.get(to).is_some_and(|back| *back > COMES_BACK * usual(&steps)),
    };
    has_turned.then_some(Doubt::HeadingStood { from_s: first.time_s, for_s })
}

/// The first and the last row of the longest run of equal headings.
fn longest_run(steps: &[f64]) -> Option<(usize, usize)> {
    let (mut longest, mut begun) = ((0, 0), 0);
    for (row, step) in steps.iter().enumerate() {
        if *step > 0.0 {
            begun = row + 1;
        } else if row + 1 - begun > longest.1 - longest.0 {
            longest = (begun, row + 1);
        }
    }
    (longest.1 > longest.0).then_some(longest)
}

/// The range of the headings that the yaw rate leads through; `None` without one in every row.
fn turned_rad(samples: &[Sample<f64>]) -> Option<f64> {
    let (mut turned, mut low, mut high) = (0.0, 0.0_f64, 0.0_f64);
    for pair in samples.windows(2) {
        let rate = pair[0].yaw_rate_rad_s.filter(|rate| rate.is_finite())?;
        turned += rate * (pair[1].time_s - pair[0].time_s);
        (low, high) = (low.min(turned), high.max(turned));
    }
    Some(high - low)
}

/// The median of the steps that are any.
pub(super) fn usual(steps: &[f64]) -> f64 {
    let mut steps: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn of 0.1 rad/s with noise of 1 mrad, whose heading is held from one time to another.
    fn turn(held: std::ops::Range<f64>, has_rate: bool) -> Vec<Sample<f64>> {
        let mut samples: Vec<Sample<f64>> = Vec::new();
        for row in 0..400 {
            let time_s = 0.05 * f64::from(row);
            let noise = 1e-3 * (1.7 * f64::from(row)).sin();
            let heading_rad = match samples.last() {
                Some(last) if held.contains(&time_s) => last.heading_rad,
                _ => 0.1 * time_s + noise,
            };
            samples.push(Sample {
                time_s,
                heading_rad,
                yaw_rate_rad_s: has_rate.then_some(0.1),
                ..Sample::default()
            });
        }
        samples
    }

    #[test]
    fn exact_a_heading_that_stood_is_found_with_its_time() {
        for has_rate in [true, false] {
            let Some(Doubt::HeadingStood { from_s, for_s }) =
                heading_stood(&turn(5.0..9.0, has_rate))
            else {
                panic!("not found");
            };
            assert!((from_s - 4.95).abs() < 1e-9 && (for_s - 4.0).abs() < 0.06);
            let mut there_and_back = turn(5.0..9.0, true);
            for sample in &mut there_and_back[140..] {
                sample.yaw_rate_rad_s = Some(-0.1);
            }
            assert!(heading_stood(&there_and_back).is_some());
            assert_eq!(heading_stood(&turn(5.0..5.4, has_rate)), None);
            assert_eq!(heading_stood(&turn(0.0..0.0, has_rate)), None);
        }
    }

    /// A vehicle at rest before its manoeuvre, and a compass of coarse steps.
    #[test]
    fn exact_a_heading_that_may_stand_is_no_doubt() {
        let mut samples = turn(0.0..0.0, true);
        for sample in &mut samples[..100] {
            (sample.heading_rad, sample.yaw_rate_rad_s) = (0.0, Some(0.0));
        }
        assert_eq!(heading_stood(&samples), None);
        let mut coarse = turn(0.0..0.0, false);
        for sample in &mut coarse {
            sample.heading_rad = (sample.heading_rad / 0.1).round() * 0.1;
        }
        assert_eq!(heading_stood(&coarse), None);
    }
}

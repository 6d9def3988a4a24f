//! Splits one long manoeuvre at the boundary of two legs: the first part to learn from, the rest to validate on.
//!
//! A zig-zag, a spiral and a random test are one manoeuvre each, and a model that was fitted to all of it was never
//! validated. A leg is the time that the rudder is deflected to one side; after a rest that is longer than any, another begins. Each part holds legs to both sides, because
//! damping, rudder effect and offset cannot be told apart from one side alone.

use seatrial_core::Sample;

use crate::manoeuvre::{Manoeuvre, Stroke};
use crate::record::Window;

/// The share of the manoeuvre that the training part comes nearest to.
const TRAINING_SHARE: f64 = 0.6;

/// A manoeuvre in two parts that meet where a leg begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegSplit {
    /// The first legs, with what the samples hold before them, half open.
    pub training: Window,
    /// The other legs, with what the samples hold after them, half open.
    pub validation: Window,
    /// Number of legs in the training part.
    pub training_legs: usize,
    /// Number of legs in the validation part.
    pub validation_legs: usize,
}

/// Splits the samples of one manoeuvre, whose times increase.
///
/// `None` where it has fewer than two legs for each part, as a doublet has.
///
/// ```
/// use seatrial::Sample;
/// use seatrial::log::split_by_legs;
///
/// // Zig-zag: the rudder changes sides every 10 s.
/// let zig_zag = |legs: u32| {
///     let at = |k: u32| Sample {
///         time_s: f64::from(k),
///         rudder_rad: if k / 10 % 2 == 0 { 0.2 } else { -0.2 },
///         ..Sample::default()
///     };
///     (0..10 * legs).map(at).collect::<Vec<_>>()
/// };
/// let split = split_by_legs(&zig_zag(10)).ok_or("ten legs")?;
/// assert_eq!((split.training_legs, split.validation_legs), (6, 4));
/// assert_eq!(split_by_legs(&zig_zag(2)), None);
/// # Ok::<(), &str>(())
/// ```
pub fn split_by_legs(samples: &[Sample<f64>]) -> Option<LegSplit> {
    let (from_s, last_s) = (samples.first()?.time_s, samples.last()?.time_s);
    let strokes = Manoeuvre::find(samples)?.strokes;
    let longest_s = strokes.iter().map(Stroke::duration_s).fold(0.0, f64::max);
    let mut legs: Vec<&Stroke> = Vec::new();
    let mut before: Option<&Stroke> = None;
    for stroke in &strokes {
        let goes_on = before.is_some_and(|before| {
            let rest_s = stroke.window.from_s - before.window.to_s;
            before.positive == stroke.positive && rest_s <= longest_s
        });
        if !goes_on {
            legs.push(stroke);
        }
        before = Some(stroke);
    }
    let are_of_both_sides = |legs: &[&Stroke]| {
        let is_positive = |leg: &&Stroke| leg.positive;
        legs.iter().any(is_positive) && !legs.iter().all(is_positive)
    };
    let leg_starts_s: Vec<f64> = legs.iter().map(|leg| leg.window.from_s).collect();
    let wanted_s = from_s + TRAINING_SHARE * (last_s - from_s);
    let boundary = (1..legs.len())
        .filter(|at| are_of_both_sides(&legs[..*at]) && are_of_both_sides(&legs[*at..]))
        .min_by(|a, b| {
            (leg_starts_s[*a] - wanted_s).abs().total_cmp(&(leg_starts_s[*b] - wanted_s).abs())
        })?;
    let legs = legs.len();
    let boundary_s = leg_starts_s[boundary];
    Some(LegSplit {
        training: Window { from_s, to_s: boundary_s },
        validation: Window { from_s: boundary_s, to_s: f64::INFINITY },
        training_legs: boundary,
        validation_legs: legs - boundary,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A zig-zag of so many legs of 10 s each, to either side in turn.
    fn zig_zag(legs: usize) -> Vec<Sample<f64>> {
        (0..legs * 100)
            .map(|k| {
                let side = if (k / 100) % 2 == 0 { 1.0 } else { -1.0 };
                Sample { time_s: 0.1 * k as f64, rudder_rad: 0.2 * side, ..Sample::default() }
            })
            .collect()
    }

    #[test]
    fn exact_a_zig_zag_is_split_where_a_leg_begins() {
        let split = split_by_legs(&zig_zag(7)).unwrap();
        assert!((split.training.to_s - 40.0).abs() < 0.15, "{split:?}");
        assert_eq!(split.validation.from_s, split.training.to_s);
        assert_eq!((split.training_legs, split.validation_legs), (4, 3));
    }

    #[test]
    fn exact_each_part_has_legs_to_both_sides() {
        let split = split_by_legs(&zig_zag(4)).unwrap();
        assert_eq!((split.training_legs, split.validation_legs), (2, 2));
    }

    /// Two manoeuvres that end and begin to one side part where the second begins, at which the vehicle does not turn.
    #[test]
    fn exact_a_rest_parts_two_legs_to_one_side() {
        let mut samples = zig_zag(20);
        for sample in &mut samples[700..1200] {
            sample.rudder_rad = 0.0;
        }
        let split = split_by_legs(&samples).unwrap();
        assert!((split.training.to_s - 120.0).abs() < 0.15, "{split:?}");
        assert_eq!((split.training_legs, split.validation_legs), (7, 8));
    }

    #[test]
    fn exact_a_doublet_is_not_split() {
        assert_eq!(split_by_legs(&zig_zag(2)), None);
        assert_eq!(split_by_legs(&zig_zag(3)), None);
        assert_eq!(split_by_legs(&[]), None);
    }
}

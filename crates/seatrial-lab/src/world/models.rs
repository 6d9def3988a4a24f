//! Accepted models beside the truth, one by one and together.
//!
//! Among many thousand 95 % intervals some miss by more than two half widths by chance: of a normal distribution 9 in 100,000. So one
//! model is held to three, where chance leaves 4 in a thousand million, and all together to what chance allows beyond two. C0 is
//! the mean over disturbances that the record does not show; where most likely there is none its interval is narrow and its tails
//! are long. It is held to how many intervals miss the truth at all.

use serde::Serialize;

use crate::faults::{HALF_WIDTHS, PARAMETERS};

/// Share of a normal distribution beyond two half widths of its 95 % interval.
const BEYOND_TWO: f64 = 8.9e-5;
/// Share of truths outside a 95 % interval.
const OUTSIDE: f64 = 0.05;
/// Standard deviations that chance may be off.
const DEVIATIONS: f64 = 4.0;

/// How many accepted models were how far from the truth, by a22, b2 and C0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Models {
    /// Accepted models.
    pub accepted: u64,
    /// Farther than one half width of the 95 % interval.
    pub beyond_one: [u64; 3],
    /// Farther than two.
    pub beyond_two: [u64; 3],
    /// The farthest, half widths.
    pub farthest: [f64; 3],
}

impl Models {
    /// Takes a model by its distances from the truth, half widths.
    pub fn take(&mut self, distances: [f64; 3]) {
        self.add(&Self {
            accepted: 1,
            beyond_one: distances.map(|distance| u64::from(distance > 1.0)),
            beyond_two: distances.map(|distance| u64::from(distance > 2.0)),
            farthest: distances,
        });
    }

    /// Takes the models of others.
    pub fn add(&mut self, other: &Self) {
        self.accepted += other.accepted;
        for k in 0..PARAMETERS.len() {
            self.beyond_one[k] += other.beyond_one[k];
            self.beyond_two[k] += other.beyond_two[k];
            self.farthest[k] = self.farthest[k].max(other.farthest[k]);
        }
    }

    /// More of them are far from the truth than chance explains.
    pub fn broken(&self) -> Vec<String> {
        let [a22, b2, _] = self.beyond_two;
        let intervals = 2 * self.accepted;
        let beyond = (a22 + b2 > most_by_chance(intervals, BEYOND_TWO)).then(|| {
            format!(
                "{} of {intervals} intervals of a22 and b2 are more than two half widths from the truth",
                a22 + b2
            )
        });
        let [_, _, outside] = self.beyond_one;
        let outside = (outside > most_by_chance(self.accepted, OUTSIDE)).then(|| {
            let accepted = self.accepted;
            format!("{outside} of {accepted} intervals of C0 miss the truth")
        });
        beyond.into_iter().chain(outside).collect()
    }
}

/// The first of a22 and b2 that is too far from the truth, and how far, half widths.
pub fn too_far(distances: [f64; 3]) -> Option<(&'static str, f64)> {
    let [a22, b2, _] = PARAMETERS;
    [(a22, distances[0]), (b2, distances[1])]
        .into_iter()
        .find(|(_, distance)| *distance > HALF_WIDTHS)
}

/// As many as chance brings at most, where each comes with this probability: the mean and four standard deviations, and a
/// few where the mean is small.
fn most_by_chance(count: u64, probability: f64) -> u64 {
    let mean = count as f64 * probability;
    (mean + DEVIATIONS * mean.sqrt() + DEVIATIONS).floor() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_far_models_are_named() {
        assert_eq!(too_far([2.9, 2.9, 9.0]), None);
        assert_eq!(too_far([0.1, 3.1, 0.0]), Some(("b2", 3.1)));
        let mut models = Models::default();
        for _ in 0..1000 {
            models.take([0.5, 0.5, 0.5]);
        }
        assert_eq!(models.broken(), [""; 0]);
        for _ in 0..4 {
            models.take([2.5, 0.5, 0.5]);
        }
        assert_eq!(models.broken(), [""; 0], "chance");
        for _ in 0..100 {
            models.take([2.5, 0.5, 1.5]);
        }
        assert_eq!(models.broken().len(), 2);
    }
}

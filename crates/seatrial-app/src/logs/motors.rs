//! Two motors taken together of which one counts the other way.

use std::path::Path;

use seatrial::identification::{Outcome, Reason, ReasonCode, Subject, Verdict};
use seatrial_core::{Real, Sample};
use seatrial_logs::{ChannelChoice, Quantity};

use super::{ReadSettings, read_again};

/// The half sum moves so many times as far as the half difference that is read, and the vehicle turns with it.
const STANDS_STILL: f64 = 5.0;
const LEAST_CORRELATION: f64 = 0.2;

/// A motor that counts the other way.
#[derive(Clone, Debug, PartialEq)]
pub struct MirroredMotor {
    /// The two columns.
    pub pair: [String; 2],
    /// Which of them it is.
    pub mirrored: usize,
}

impl MirroredMotor {
    /// The motor, where half the difference of two columns is read as the rudder and hardly moves, and the vehicle turns with half the sum.
    pub(super) fn find(
        path: &Path,
        settings: &ReadSettings,
        choice: &ChannelChoice,
        samples: &[Sample<f64>],
    ) -> Option<Self> {
        let pair = choice.half_differences.get(&Quantity::Rudder)?;
        let [first, second] = pair;
        if second.starts_with('-') {
            return None;
        }
        let mut choice = choice.clone();
        let sum = [first.clone(), format!("-{second}")];
        choice.half_differences.insert(Quantity::Rudder, sum);
        let sums = read_again(path, settings, &choice, samples)?;
        let correlation = correlation(&sums)?;
        let stands_still = range(&sums) > STANDS_STILL * range(samples);
        (stands_still && correlation.abs() > LEAST_CORRELATION)
            .then(|| Self { pair: pair.clone(), mirrored: usize::from(correlation > 0.0) })
    }

    /// The mirrored motor is why the rudder hardly moved.
    pub(crate) fn before(&self, mut verdict: Verdict) -> Verdict {
        if verdict.outcome() != Outcome::DoNotUse {
            return verdict;
        }
        let [first, second] = &self.pair;
        let (mirrored, reversed) = match self.mirrored {
            0 => (first, ", and reversed = true in a file for --channels"),
            _ => (second, ""),
        };
        let text = format!(
            "`{first}` and `{second}` move together, and the vehicle turns with half their sum: `{mirrored}` counts the other way."
        );
        let option = format!("Read the rudder with --rudder '{first},-{second}'{reversed}.");
        let is_else = |reason: &Reason| reason.kind() != ReasonCode::Constant.of(Subject::Rudder);
        verdict.reasons.retain(is_else);
        let reason = Reason {
            text,
            action: option,
            ..Reason::new(ReasonCode::Constant.of(Subject::Rudder), "")
        };
        verdict.reasons.insert(0, reason);
        verdict
    }
}

fn range(samples: &[Sample<f64>]) -> f64 {
    let rudders = || samples.iter().map(|sample| sample.rudder_rad);
    rudders().fold(f64::NEG_INFINITY, f64::max) - rudders().fold(f64::INFINITY, f64::min)
}

/// Of the rudder with the yaw rate of the heading over the next rows.
fn correlation(samples: &[Sample<f64>]) -> Option<f64> {
    const ROWS: usize = 10;
    let turns = samples.windows(ROWS + 1).map(|rows| {
        let (from, to) = (&rows[0], &rows[ROWS]);
        let turned = Real::wrapped(to.heading_rad - from.heading_rad);
        (from.rudder_rad, turned / (to.time_s - from.time_s))
    });
    let turns: Vec<(f64, f64)> = turns.filter(|(_, rate)| rate.is_finite()).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| turns.iter().map(of).sum::<f64>() / turns.len() as f64;
    let means = (mean(|turn| turn.0), mean(|turn| turn.1));
    let product = |of: fn(f64, f64) -> f64| {
        let products = turns.iter().map(|(a, b)| of(a - means.0, b - means.1));
        products.sum::<f64>()
    };
    let size = (product(|a, _| a * a) * product(|_, b| b * b)).sqrt();
    (size > 0.0).then(|| product(|a, b| a * b) / size)
}

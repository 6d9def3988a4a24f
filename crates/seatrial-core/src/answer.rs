//! Does the heading answer a deflected rudder at all?

use crate::{Excitation, Real};

/// Expected time constant of the turn, as a part of the longest deflection of the manoeuvre: the paper's T = 1/1.07 s and 2 s.
const TIME_CONSTANT: f64 = 0.47;
/// Time constants of deflected rudder after which an answer must be seen.
const LONGEST: f64 = 3.0;
/// A rudder beyond this part of the manoeuvre's amplitude is deflected.
const DEFLECTED: f64 = 0.5;
/// Standard deviations by which the scatter of the heading must exceed that before the manoeuvre.
const SIGNIFICANCE: f64 = 3.0;
/// Smallest answer that counts where the heading has no noise, rad.
const SMALLEST_ANSWER_RAD: f64 = 0.003;
/// Fewest samples before the manoeuvre that tell the noise of the heading.
const FEWEST: u32 = 8;

/// Watches a manoeuvre for a heading that stays as it was while the rudder is over: a compass that hangs, with or without noise, or
/// a rudder that is not connected.
///
/// ```text
/// no answer:  r <= v (1 + 3 sqrt(2/n + 2/m)) + q^2
/// ```
///
/// r is the mean square of the heading from its mean in the lead-in, over the m samples of the second half of
/// three expected time constants of deflected rudder; v is the variance in the n samples of the lead-in, q = 0.003 rad.
#[derive(Clone, Copy, Debug, Default)]
pub struct AnswerWatch<T> {
    deflected_from_rad: T,
    longest_s: f64,
    /// Time with the rudder over so far, s.
    deflected_s: f64,
    /// When the rudder was last seen over, s.
    over_s: Option<f64>,
    before: Scatter<T>,
    after: Scatter<T>,
    is_judged: bool,
}

/// Count, mean and sum of squared deviations.
#[derive(Clone, Copy, Debug, Default)]
struct Scatter<T> {
    samples: u32,
    mean: T,
    squares: T,
}

impl<T: Real> AnswerWatch<T> {
    /// A watch on a manoeuvre.
    ///
    /// ```
    /// use seatrial_core::Excitation;
    /// use seatrial_core::answer::AnswerWatch;
    ///
    /// let doublet = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
    /// let mut watch = AnswerWatch::new(&doublet);
    /// // A compass that hangs at 0 rad while the rudder is over: told after 3 * 0.47 * 2 s.
    /// let told_s =
    ///     (0..80).map(|k| 0.05 * f64::from(k)).find(|elapsed_s| watch.is_missing(*elapsed_s, 0.0, 0.26));
    /// assert!(told_s.is_some_and(|told_s| (2.8..2.9).contains(&told_s)));
    /// ```
    pub fn new(excitation: &Excitation<T>) -> Self {
        Self {
            deflected_from_rad: T::of(DEFLECTED) * excitation.amplitude_rad().abs(),
            longest_s: LONGEST * TIME_CONSTANT * excitation.longest_deflection_s(),
            ..Self::default()
        }
    }

    /// Takes in the heading relative to the heading of the run and the rudder, `elapsed_s` after the start of the manoeuvre,
    /// negative before it. `true`: the rudder has been over for long enough, and the heading has not answered.
    pub fn is_missing(&mut self, elapsed_s: f64, heading_rad: T, rudder_rad: T) -> bool {
        if self.is_judged {
            return false;
        }
        if elapsed_s < 0.0 {
            self.before.add(heading_rad);
            return false;
        }
        if self.before.samples == 0 {
            self.before.add(heading_rad);
        }
        if let Some(over_s) = self.over_s {
            self.deflected_s += elapsed_s - over_s;
        }
        self.over_s = (rudder_rad.abs() >= self.deflected_from_rad).then_some(elapsed_s);
        if self.deflected_s >= 0.5 * self.longest_s {
            self.after.add(heading_rad);
        }
        self.is_judged = self.deflected_s >= self.longest_s;
        self.is_judged && self.is_as_before()
    }

    fn is_as_before(&self) -> bool {
        let (before, after) = (&self.before, &self.after);
        let (n, m) = (T::of(before.samples.into()), T::of(after.samples.into()));
        let moved = after.mean - before.mean;
        let found = moved * moved + after.squares / m;
        let noise = match before.samples < FEWEST {
            true => T::ZERO,
            false => {
                let two = T::of(2.0);
                let spread = T::of(SIGNIFICANCE) * (two / n + two / m).sqrt();
                before.squares / n * (T::ONE + spread)
            }
        };
        let least = T::of(SMALLEST_ANSWER_RAD);
        found <= noise + least * least
    }
}

impl<T: Real> Scatter<T> {
    fn add(&mut self, value: T) {
        self.samples = self.samples.saturating_add(1);
        let deviation = value - self.mean;
        self.mean += deviation / T::of(self.samples.into());
        self.squares += deviation * (value - self.mean);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOUBLET: Excitation<f64> = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };

    /// 20 Hz, 2 s of lead-in: when no answer was found, s after the rudder went over.
    fn missing_at_s(heading: impl Fn(f64, f64) -> f64) -> Option<f64> {
        let mut watch = AnswerWatch::new(&DOUBLET);
        let mut noise = 0.0_f64;
        (-40..80).map(|k| f64::from(k) * 0.05).find(|&elapsed_s| {
            // A sequence without pattern in [-1, 1].
            noise = (noise * 7.13 + 0.317).fract();
            let rudder_rad = DOUBLET.rudder_rad(elapsed_s).unwrap_or(0.0);
            watch.is_missing(elapsed_s, heading(elapsed_s, 2.0 * noise - 1.0), rudder_rad)
        })
    }

    #[test]
    fn exact_a_heading_that_does_not_answer_is_found_within_three_time_constants() {
        for noise_rad in [0.0, 0.003, 0.05] {
            let found_s = missing_at_s(|_, noise| 0.4 + noise_rad * noise).unwrap();
            // 3 x 0.47 x 2 s, and a sample.
            assert!((2.8..2.9).contains(&found_s), "{noise_rad}: {found_s}");
        }
    }

    /// A tenth of the paper's turn, behind a second of delay, in noise of 0.3 degrees.
    #[test]
    fn exact_a_weak_and_late_answer_is_one() {
        let turn = |t: f64| 0.02 * (t - 1.0).clamp(0.0, 1.8);
        assert_eq!(missing_at_s(|t, noise| turn(t) + 0.005 * noise), None);
        assert_eq!(missing_at_s(|t, _| turn(t)), None);
    }
}

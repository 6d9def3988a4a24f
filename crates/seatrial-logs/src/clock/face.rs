//! A clock that begins again: at midnight without a date, and at one o'clock on a face of twelve hours.

use super::Clock;

/// Half a day is the turn of a face of twelve hours.
const TURNS_S: [f64; 2] = [43_200.0, 86_400.0];
/// The longest gap behind which a clock is believed to have begun again, s.
const LONGEST_GAP_S: f64 = 60.0;

/// What is added to times of a clock that begins again.
#[derive(Debug, Default)]
pub(crate) struct Face {
    added_s: f64,
    before_s: Option<f64>,
    /// The time at which it first began again, and the turn, s.
    first: Option<[f64; 2]>,
}

/// The turn, s, by which a time goes on from the one before.
pub(super) fn begins_again(before_s: f64, time_s: f64) -> Option<f64> {
    let goes_on = |turn_s: &f64| (0.0..LONGEST_GAP_S).contains(&(turn_s + time_s - before_s));
    TURNS_S.into_iter().find(goes_on)
}

impl Face {
    /// The time that goes on from the one before, where the clock may begin again.
    pub fn on(&mut self, clock: &Clock, time_s: f64) -> f64 {
        if matches!(clock, Clock::Plain { .. } | Clock::Epoch { .. }) {
            return time_s;
        }
        if let Some(before_s) = self.before_s
            && let Some(turn_s) = begins_again(before_s, time_s + self.added_s)
        {
            self.first.get_or_insert([before_s, turn_s]);
            self.added_s += turn_s;
        }
        let time_s = time_s + self.added_s;
        self.before_s = Some(time_s);
        time_s
    }

    /// What people should know of it.
    pub fn warning(&self) -> Option<String> {
        let [at_s, turn_s] = self.first?;
        let (hours, clock) = match turn_s == TURNS_S[0] {
            true => (12, "a clock of 12 hours without AM and PM"),
            false => (24, "a time of day without a date"),
        };
        Some(format!(
            "the time goes back by {hours} h behind {at_s:.1} s, as {clock} does: {hours} h were added from there on"
        ))
    }
}

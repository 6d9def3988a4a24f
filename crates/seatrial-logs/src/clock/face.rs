//! A clock that begins again: at midnight without a date, at one o'clock on a face of twelve hours, and where a counter is full.

use super::Clock;

const DAY_S: f64 = 86_400.0;
/// Half a day is the turn of a face of twelve hours.
const TURNS_S: [f64; 2] = [43_200.0, DAY_S];
/// Counts after which counters of 16 and 32 bits begin again.
const FULL_COUNTS: [f64; 2] = [65_536.0, 4_294_967_296.0];
/// The longest gap behind which a clock is believed to have begun again, s.
const LONGEST_GAP_S: f64 = 60.0;
/// Such a gap in turns of a counter: a logger of milliseconds in 16 bits that was switched off and on is believed for 1.3 s of 65.5.
const LONGEST_GAP_OF_A_COUNTER: f64 = 0.02;
/// Days by which 1 May is followed by 5 February where the month stands before the day, less one.
const MONTHS_DAYS: [f64; 4] = [27.0, 28.0, 29.0, 30.0];

/// What is added to times of a clock that begins again.
#[derive(Debug, Default)]
pub(crate) struct Face {
    added_s: f64,
    before_s: Option<f64>,
    /// The time at which it first began again, and the turn, s.
    first: Option<(f64, Turn)>,
}

/// How a clock begins again.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    OfDay(f64),
    /// A counter was full.
    Counter(f64),
    /// The day was read for the month.
    Month(f64),
}

impl Turn {
    fn seconds(self) -> f64 {
        match self {
            Self::OfDay(turn_s) | Self::Counter(turn_s) => turn_s,
            Self::Month(days) => -days * DAY_S,
        }
    }
}

/// The turn, s, by which a time goes on from the one before.
pub(super) fn begins_again(before_s: f64, time_s: f64) -> Option<f64> {
    let goes_on = |turn_s: &f64| (0.0..LONGEST_GAP_S).contains(&(turn_s + time_s - before_s));
    TURNS_S.into_iter().find(goes_on)
}

/// The turn of a counter that goes on from a count, both in s.
fn counts_again(before_s: f64, time_s: f64, per_second: f64) -> Option<f64> {
    let turns_s = FULL_COUNTS.into_iter().map(|counts| counts / per_second);
    let goes_on = |turn_s: &f64| {
        let longest_s = LONGEST_GAP_S.min(LONGEST_GAP_OF_A_COUNTER * turn_s);
        before_s < *turn_s && (0.0..longest_s).contains(&(turn_s + time_s - before_s))
    };
    turns_s.into_iter().find(goes_on)
}

/// The days by which a date is too late that goes on from midnight.
fn months_on(before_s: f64, time_s: f64) -> Option<f64> {
    let goes_on = |days: &f64| (0.0..LONGEST_GAP_S).contains(&(time_s - days * DAY_S - before_s));
    MONTHS_DAYS.into_iter().find(goes_on)
}

impl Face {
    /// The time that goes on from the one before, where the clock may begin again.
    pub fn on(&mut self, clock: &Clock, time_s: f64) -> f64 {
        let turn = self.before_s.and_then(|before_s| match clock {
            // A count of whole seconds has no end that a log sees.
            Clock::Plain { per_second } if *per_second > 1.0 => {
                counts_again(before_s - self.added_s, time_s, *per_second).map(Turn::Counter)
            }
            Clock::Plain { .. } | Clock::Epoch { .. } => None,
            _ => begins_again(before_s, time_s + self.added_s)
                .map(Turn::OfDay)
                .or_else(|| months_on(before_s, time_s + self.added_s).map(Turn::Month)),
        });
        if let (Some(turn), Some(before_s)) = (turn, self.before_s) {
            self.first.get_or_insert((before_s, turn));
            self.added_s += turn.seconds();
        }
        let time_s = time_s + self.added_s;
        self.before_s = Some(time_s);
        time_s
    }

    /// What people should know of it.
    pub fn warning(&self) -> Option<String> {
        let (at_s, turn) = self.first?;
        Some(match turn {
            Turn::OfDay(turn_s) => {
                let (hours, clock) = match turn_s == TURNS_S[0] {
                    true => (12, "a clock of 12 hours without AM and PM"),
                    false => (24, "a time of day without a date"),
                };
                format!(
                    "the time goes back by {hours} h behind {at_s:.1} s, as {clock} does: {hours} h were added from there on"
                )
            }
            Turn::Counter(turn_s) => format!(
                "the time goes back by {turn_s:.1} s behind {at_s:.1} s, as a counter that is full does: as much was added from there on"
            ),
            Turn::Month(days) => format!(
                "the date goes on by {days} days behind {at_s:.1} s, as where the month stands before the day: they were taken off from there on, and the date of the log is the other one"
            ),
        })
    }
}

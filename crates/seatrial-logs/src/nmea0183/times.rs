//! Times of sentences: those before them, and those of sentences that say one.

use crate::clock::unix_s;

const DAY_S: f64 = 86_400.0;

/// Times before sentences.
#[derive(Default)]
pub(super) struct Stamps {
    pub count: u64,
    /// Of every kind, the last.
    last_s: Vec<f64>,
    /// Those that are the same as the one before of their kind.
    pub repeated: u64,
    /// Do most sentences share the time of the one before of their kind?
    pub are_shared: bool,
}

impl Stamps {
    pub fn take(&mut self, kind: usize, own_s: f64) {
        self.last_s.resize(self.last_s.len().max(kind + 1), f64::NAN);
        self.repeated += u64::from(self.last_s[kind] == own_s);
        self.last_s[kind] = own_s;
        self.count += 1;
    }
}

/// The time of the sentences that have none of their own.
#[derive(Default)]
pub(super) struct Clock {
    /// Seconds since 1970 of the day, 0 where no sentence said so.
    day_s: f64,
    /// Seconds since 1970, or since midnight.
    pub last_s: Option<f64>,
}

impl Clock {
    /// Takes the time of a sentence that has one.
    pub fn take(&mut self, name: &str, cells: &[&str]) {
        let cell = |index: usize| cells.get(index).copied().unwrap_or_default();
        let rmc = cell(9);
        let date = match name {
            "RMC" if rmc.len() == 6 && rmc.is_ascii() => Some([&rmc[4..], &rmc[2..4], &rmc[..2]]),
            "ZDA" => Some([cell(4), cell(3), cell(2)]),
            _ => None,
        };
        if let Some(date) = date {
            let [year, month, day] = date.map(|part| part.parse().unwrap_or(f64::NAN));
            self.day_s = unix_s(year, month, day, 0.0).unwrap_or(self.day_s);
        }
        let time = match name {
            "RMC" | "ZDA" | "GGA" | "SHR" => cell(1),
            "GLL" => cell(5),
            _ => return,
        };
        let Some(second_s) = second_of_day(time) else {
            return;
        };
        let mut time_s = self.day_s + second_s;
        // Behind midnight the date comes with the next RMC or ZDA.
        if date.is_none() && self.last_s.is_some_and(|last| last - time_s > DAY_S / 2.0) {
            self.day_s += DAY_S;
            time_s += DAY_S;
        }
        self.last_s = Some(time_s);
    }
}

/// `hhmmss.ss`
fn second_of_day(text: &str) -> Option<f64> {
    if text.len() < 6 || !text.is_ascii() {
        return None;
    }
    let part = |from: usize| text[from..from + 2].parse::<u8>().ok().map(f64::from);
    let seconds: f64 = text[4..].parse().ok()?;
    (0.0..61.0).contains(&seconds).then_some(3600.0 * part(0)? + 60.0 * part(2)? + seconds)
}

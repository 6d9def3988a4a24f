//! How far long work is, on one line of a terminal.

use std::io::{IsTerminal, Write, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::screen::{PLAIN_WIDTH, width_of_stderr};

/// Characters of the bar.
const LENGTH: usize = 40;
/// Time between two drawings.
const REDRAW: Duration = Duration::from_millis(100);

/// A bar on standard error where that is a terminal, otherwise nothing.
pub struct Bar(Option<Mutex<Line>>);

struct Line {
    begun: Instant,
    drawn: Option<Instant>,
    work: Work,
}

/// Work of which a part is done.
struct Work {
    done: u64,
    total: u64,
    unit: Unit,
    /// Stands where otherwise the rate does.
    note: Option<String>,
}

enum Unit {
    Runs,
    Bytes,
}

/// The bar of so many runs.
pub fn bar(runs: u64) -> Bar {
    Bar::new(runs, Unit::Runs)
}

/// The bar of so many bytes.
pub fn of_bytes(bytes: u64) -> Bar {
    Bar::new(bytes, Unit::Bytes)
}

/// A duration in its greatest unit.
pub fn in_words(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    match seconds {
        ..90.0 => format!("{seconds:.0} s"),
        ..5400.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.0} h", seconds / 3600.0),
    }
}

impl Bar {
    fn new(total: u64, unit: Unit) -> Self {
        let line = || Line {
            begun: Instant::now(),
            drawn: None,
            work: Work {
                done: 0,
                total,
                unit,
                note: None,
            },
        };
        Self(stderr().is_terminal().then(|| Mutex::new(line())))
    }

    /// Is there a terminal?
    pub fn is_shown(&self) -> bool {
        self.0.is_some()
    }

    /// One more is done.
    pub fn step(&self) {
        self.change(|work| work.done += 1);
    }

    /// So much is done.
    pub fn set_done(&self, done: u64) {
        self.change(|work| work.done = done);
    }

    /// So much of so much is done, with a note in place of the rate.
    pub fn set(&self, done: u64, total: u64, note: String) {
        self.change(|work| {
            work.done = done;
            work.total = total;
            work.note = Some(note);
        });
    }

    /// Takes the line away.
    pub fn clear(self) {
        if self.0.is_some() {
            eprint!("\r\x1b[K");
        }
    }

    fn change(&self, change: impl FnOnce(&mut Work)) {
        let Some(Ok(mut line)) = self.0.as_ref().map(Mutex::lock) else {
            return;
        };
        change(&mut line.work);
        if line.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW) {
            return;
        }
        line.drawn = Some(Instant::now());
        let width = width_of_stderr().unwrap_or(PLAIN_WIDTH);
        let text = line.work.text(line.begun.elapsed());
        // A line as wide as the terminal would go on in the next.
        let text: String = text.chars().take(width - 1).collect();
        // A terminal that went away does not stop the work.
        let _ = write!(stderr(), "\r{text}\x1b[K");
    }
}

impl Work {
    fn text(&self, elapsed: Duration) -> String {
        let part = (self.done as f64 / self.total.max(1) as f64).min(1.0);
        let filled = (part * LENGTH as f64) as usize;
        let bar = "█".repeat(filled) + &"░".repeat(LENGTH - filled);
        let per_second = self.done as f64 / elapsed.as_secs_f64().max(1e-3);
        let megabytes = |bytes: f64| format!("{:.1} MB", bytes / 1e6);
        let (done, rate) = match self.unit {
            Unit::Runs => (
                format!("{}/{} runs", self.done, self.total),
                format!("{per_second:.1}/s"),
            ),
            Unit::Bytes => (
                format!(
                    "{}/{}",
                    megabytes(self.done as f64),
                    megabytes(self.total as f64)
                ),
                format!("{}/s", megabytes(per_second)),
            ),
        };
        let rate = self.note.as_ref().unwrap_or(&rate);
        let left = match part > 0.0 {
            true => in_words(elapsed.mul_f64((1.0 - part) / part)) + " left",
            false => String::new(),
        };
        format!("{bar} {done} {rate} {left}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_line_says_how_much_is_done_how_fast_and_what_is_left() {
        let mut work = Work {
            done: 25,
            total: 100,
            unit: Unit::Runs,
            note: None,
        };
        let quarter = "█".repeat(10) + &"░".repeat(30);
        let after = Duration::from_secs(50);
        assert_eq!(
            work.text(after),
            format!("{quarter} 25/100 runs 0.5/s 2 min left")
        );
        (work.done, work.total, work.unit) = (2_500_000, 10_000_000, Unit::Bytes);
        assert_eq!(
            work.text(Duration::from_secs(5)),
            format!("{quarter} 2.5 MB/10.0 MB 0.5 MB/s 15 s left")
        );
        work.note = Some("no errors".into());
        work.done = 20_000_000;
        let all = "█".repeat(40);
        assert_eq!(
            work.text(Duration::from_secs(5)),
            format!("{all} 20.0 MB/10.0 MB no errors 0 s left")
        );
        work.done = 0;
        assert_eq!(
            work.text(Duration::ZERO),
            format!("{} 0.0 MB/10.0 MB no errors ", "░".repeat(40))
        );
    }
}

//! How far long work is, on one line of a terminal.

use std::io::{IsTerminal, stderr};
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

/// A bar on standard error where that is a terminal, otherwise nothing. It is as wide as the terminal and never wider: a line that the
/// terminal breaks is not taken away whole.
pub struct Bar(ProgressBar);

/// The bar of so many runs.
pub fn of_runs(runs: u64) -> Bar {
    Bar::new(runs, "{wide_bar} {pos}/{len} runs {per_sec} {eta}")
}

/// The bar of so many bytes.
pub fn of_bytes(bytes: u64) -> Bar {
    let template = "{wide_bar} {bytes}/{total_bytes} {bytes_per_sec} {eta}";
    Bar::new(bytes, template)
}

/// A bar of bytes whose number is not known yet, with a note in place of the rate.
pub fn of_bytes_with_a_note() -> Bar {
    Bar::new(0, "{wide_bar} {bytes}/{total_bytes} {msg} {eta}")
}

/// A duration in its greatest unit.
pub fn in_words(duration: Duration) -> String {
    HumanDuration(duration).to_string()
}

impl Bar {
    fn new(total: u64, template: &str) -> Self {
        if !stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template(template);
        Self(ProgressBar::new(total).with_style(style.unwrap_or(ProgressStyle::default_bar())))
    }

    /// Is there a terminal?
    pub fn is_shown(&self) -> bool {
        !self.0.is_hidden()
    }

    /// One more is done.
    pub fn step(&self) {
        self.0.inc(1);
    }

    /// So much is done.
    pub fn set_done(&self, done: u64) {
        self.0.set_position(done);
    }

    /// So much of so much is done, with a note.
    pub fn set(&self, done: u64, total: u64, note: String) {
        self.0.set_length(total);
        self.0.set_position(done);
        self.0.set_message(note);
    }

    /// Takes the line away while something else is written to the terminal.
    pub fn aside(&self, write: impl FnOnce()) {
        self.0.suspend(write);
    }

    /// Takes the line away.
    pub fn clear(self) {
        self.0.finish_and_clear();
    }
}

//! Logs that lie or fall short, each with the truth that it hides.
//!
//! ```
//! use seatrial_lab::lies;
//!
//! let kind = lies::kind_of_name("heading_is_radians").unwrap();
//! let log = kind.log(1);
//! assert!(log.csv.starts_with("time_s,heading_deg,rudder_deg"));
//! assert!(log.truth.a22_per_s < 0.0);
//! ```
//!
//! A log is one voyage: the vehicle holds its heading, does a manoeuvre for training and another one for validation. A
//! kind changes what the vehicle does, what its instruments read, or what the file says of them. The same seed gives
//! the same log.

mod clock;
mod draw;
mod instruments;
mod kinds;
mod setup;
mod voyage;

pub use kinds::{KINDS, kind_of_name};
pub use setup::{Decidability, Kind};

use setup::Setup;
use voyage::Voyage;

/// What an identification of the log should find, in the units that its columns state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogTruth {
    /// a22, 1/s.
    pub a22_per_s: f64,
    /// b2 for a rudder in radians, 1/s^2; negative where the log's rudder is reversed.
    pub b2_per_s2: f64,
    /// The rudder angle of a fraction of 1, rad.
    pub full_rudder_rad: f64,
}

/// A log, and what is true of it.
#[derive(Clone, Debug)]
pub struct LyingLog {
    /// The file.
    pub csv: String,
    /// Start and end of the training window by the file's own clock, in seconds as the file states them.
    pub training_s: [f64; 2],
    /// Start and end of the validation window.
    pub validation_s: [f64; 2],
    /// The truth of the vehicle in the training window.
    pub truth: LogTruth,
}

impl Kind {
    /// The log of a seed.
    pub fn log(&self, seed: u64) -> LyingLog {
        let setup = Setup::of(self, seed);
        let voyage = Voyage::sail(&setup, seed);
        instruments::write(&setup, &voyage, seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_names_are_unique_and_logs_repeat() {
        let mut names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), KINDS.len());
        for kind in &KINDS {
            let (first, again) = (kind.log(3), kind.log(3));
            assert_eq!(first.csv, again.csv, "{}", kind.name);
            assert!(first.csv.lines().count() > 40, "{}", kind.name);
            assert!(first.training_s[0] < first.training_s[1], "{}", kind.name);
            assert!(first.training_s[1] <= first.validation_s[0], "{}", kind.name);
        }
    }

    #[test]
    fn prop_there_are_enough_lies_and_controls() {
        let count =
            |decidability| KINDS.iter().filter(|kind| kind.decidability == decidability).count();
        assert!(count(Decidability::Sound) >= 8);
        assert!(count(Decidability::Decidable) + count(Decidability::Undecidable) >= 28);
    }
}

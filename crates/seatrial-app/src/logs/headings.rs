//! Headings that a table has beside the one that is read.

use std::path::Path;

use seatrial::identification::{Reason, ReasonCode, Subject, Verdict};
use seatrial::log::heading_later_s;
use seatrial_core::Sample;
use seatrial_logs::{Channel, Format, LogDescription, Quantity, names_a_course};

use super::{ReadSettings, read_again};

/// A heading that is not read.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherHeading {
    /// The column that is read.
    pub read: String,
    /// The column that is not.
    pub column: String,
    /// The time by which the one that is read is later, s.
    pub late_s: Option<f64>,
}

impl OtherHeading {
    /// The first column that is named for a heading and not read; of a heading that somebody chose, only where it is later than that one.
    pub(super) fn find(
        path: &Path,
        settings: &ReadSettings,
        description: &LogDescription,
        samples: &[Sample<f64>],
    ) -> Option<Self> {
        let choice = settings.choice().ok()?;
        let is_said = choice.columns.contains_key(&Quantity::Heading);
        if description.format != Format::Csv {
            return None;
        }
        let is_heading = |channel: &&Channel| channel.quantity == Quantity::Heading;
        let read = description.channels.iter().find(is_heading)?.column.clone();
        let is_taken = |name: &&String| description.channels.iter().any(|c| c.column == **name);
        let mut others = description.columns.iter().filter(|name| !is_taken(name));
        let column = others.find(|name| names_a_heading(name))?.clone();
        let mut choice = choice;
        choice.columns.insert(Quantity::Heading, column.clone());
        let other = read_again(path, settings, &choice, samples);
        let late_s = other.and_then(|other| heading_later_s(samples, &other));
        (late_s.is_some() || !is_said).then_some(Self { read, column, late_s })
    }

    /// One line, with the option that takes the other.
    pub(super) fn warning(&self) -> String {
        let Self { read, column, .. } = self;
        match self.late_s {
            Some(late_s) => format!(
                "heading is read from `{read}`, which is {late_s:.1} s later than `{column}`: read that one with --heading {}",
                quoted(column)
            ),
            None => format!(
                "heading is read from `{read}`; `{column}` is a heading, too: read it with --heading {}",
                quoted(column)
            ),
        }
    }

    /// A heading that is late is the cause of what it leads to.
    pub(crate) fn before(&self, mut verdict: Verdict) -> Verdict {
        let Some(late_s) = self.late_s else {
            return verdict;
        };
        let Self { read, column, .. } = self;
        let measured = format!(
            "the heading of column `{read}` is {late_s:.1} s later than that of `{column}`: it is filtered, held or logged with the time of its arrival"
        );
        let reason = Reason {
            text: format!(
                "Column `{read}` is a heading {late_s:.1} s later than column `{column}`."
            ),
            action: format!("Read column `{column}` for the heading."),
            ..Reason::new(ReasonCode::Late.of(Subject::Heading), measured)
        };
        // A late heading is what looks like a rudder that lags.
        let is_else = |reason: &Reason| reason.kind() != ReasonCode::ModelOrder.into();
        verdict.reasons.retain(is_else);
        verdict.reasons.insert(usize::from(verdict.accepted), reason);
        verdict
    }
}

/// Of a compass, and no rate, course, target or spread.
fn names_a_heading(column: &str) -> bool {
    let name = column.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    has(&["heading", "hdg", "yaw", "compass"])
        && !names_a_course(column)
        && !has(&[
            "rate", "speed", "/s", "_s", "target", "des", "cmd", "set", "order", "err", "std",
            "var", "dev", "acc", "raw", "ctrl", "pid", "hold", "mode", "sp",
        ])
}

/// As a shell takes it.
fn quoted(column: &str) -> String {
    match column.contains(|letter: char| !(letter.is_alphanumeric() || "_.-/".contains(letter))) {
        true => format!("'{column}'"),
        false => column.to_owned(),
    }
}

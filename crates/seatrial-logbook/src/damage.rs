//! What is damaged of a logbook.

use rusqlite::ErrorCode;
use serde::Serialize;

use seatrial::campaign::Run;
use seatrial::identification::{Reason, ReasonCode};

/// What was found wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damage {
    /// `campaign 2, run 3`
    pub place: String,
    /// What is wrong there.
    pub found: String,
}

/// What an error of SQLite says of a part of a logbook, in words for whoever owns it.
pub(super) fn unreadable(error: &rusqlite::Error) -> String {
    let words = match error.sqlite_error_code() {
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
            "this part of the file was overwritten, cut off or lost, and cannot be read"
        }
        Some(ErrorCode::SystemIoFailure) => "the disk does not give this part of the file",
        Some(ErrorCode::OperationInterrupted) => {
            "reading takes longer than any logbook of its size needs"
        }
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => "another process holds it",
        _ => "something stands there that seatrial does not write",
    };
    words.into()
}

impl Damage {
    /// The number of the campaign that is damaged; `None` where it is the whole file.
    pub fn campaign(&self) -> Option<i64> {
        let number = self.place.strip_prefix("campaign ")?;
        let number = number.split(',').next()?;
        number.parse().ok()
    }

    /// Lets nothing of a run be used, and says why first of all reasons.
    pub(super) fn decide(&self, run: &mut Run) {
        let text = format!("the logbook is damaged: {}: {}", self.place, self.found);
        run.verdict.accepted = false;
        let reason = Reason::new(ReasonCode::Damaged, text);
        run.verdict.reasons.insert(0, reason);
    }
}

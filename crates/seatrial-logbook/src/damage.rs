//! What is damaged of a logbook.

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

impl Damage {
    /// Lets nothing of a run be used, and says why first of all reasons.
    pub(super) fn decide(&self, run: &mut Run) {
        let text = format!("the logbook is damaged: {}: {}", self.place, self.found);
        run.verdict.accepted = false;
        let reason = Reason::new(ReasonCode::Damaged, text);
        run.verdict.reasons.insert(0, reason);
    }
}

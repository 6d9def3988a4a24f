//! What to type next.

use std::path::Path;

use seatrial::campaign::Campaign;
use seatrial::identification::Outcome;

use crate::identify_log::IdentifiedLog;

/// The command that goes on from an identified log. `call` is the command that identified it, `seatrial identify run.csv`.
pub fn after_log(found: &IdentifiedLog, call: &str) -> String {
    match found.verdict().outcome() {
        Outcome::Use | Outcome::UseWithCare => {
            format!("{call} --json > model.json && seatrial gains --model model.json")
        }
        Outcome::NotValidated => format!("{call} --validate-on SECOND_LOG"),
        Outcome::DoNotUse => format!("seatrial inspect {}", found.logs.log.path.display()),
    }
}

/// The command that goes on from a campaign of a logbook.
pub fn after_trial(campaign: &Campaign, logbook: &Path) -> String {
    let logbook = logbook.display();
    match campaign.accepted_runs().is_empty() {
        true => format!("seatrial report --logbook {logbook}"),
        false => format!("seatrial gains --logbook {logbook}"),
    }
}

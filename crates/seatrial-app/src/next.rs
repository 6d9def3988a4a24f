//! What to type next.

use std::path::Path;

use seatrial::campaign::Campaign;
use seatrial::identification::Outcome;
use seatrial_logbook::CampaignId;

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

/// The command that goes on from the campaign of this number in a logbook.
pub fn after_trial(campaign: &Campaign, number: CampaignId, logbook: &Path) -> String {
    let place = format!("--logbook {} --campaign {}", logbook.display(), number.0);
    match campaign.accepted_runs().is_empty() {
        true => format!("seatrial report {place}"),
        false => format!("seatrial gains {place}"),
    }
}

//! What to type after a trial.

use std::path::Path;

use seatrial::campaign::Campaign;
use seatrial::identification::Outcome;
use seatrial_core::{Axis, Outcome as TrialOutcome};
use seatrial_logbook::CampaignId;

use crate::next::PX4;

/// The command that goes on from the campaign of this number in a logbook: into the autopilot that it was made on, where that steers
/// to headings for us, else to its file of parameters. Of a trial that was aborted, or whose models are not to be used, it is the page
/// that shows why.
pub fn after_trial(
    campaign: &Campaign,
    number: CampaignId,
    logbook: &Path,
    firmware: Option<&str>,
) -> String {
    let place = place(number, logbook);
    if campaign.axis == Axis::Pitch || is_looked_into(campaign) {
        return report_of_trial(number, logbook);
    }
    let is_autopilot = campaign.vehicle.starts_with("mavlink:") && !campaign.is_rehearsal();
    match firmware {
        _ if !is_autopilot => gains_of_trial(number, logbook),
        Some(name) if name.starts_with("PX4") => format!("seatrial gains {place} {PX4}"),
        _ => {
            let full_rudder = campaign.full_rudder.filter(|full| !full.is_assumed);
            let angle = full_rudder.map_or(String::new(), |full| {
                format!(" --full-rudder-deg {:.4}", full.angle_rad.to_degrees())
            });
            format!("seatrial commission --vehicle {} {place}{angle}", campaign.vehicle)
        }
    }
}

/// The command that finds gains from the models of the campaign of this number.
pub fn gains_of_trial(number: CampaignId, logbook: &Path) -> String {
    format!("seatrial gains {}", place(number, logbook))
}

/// Does the trial lead to its page before anything else: was it aborted, or are its models not to be used?
pub fn is_looked_into(campaign: &Campaign) -> bool {
    let is_aborted = matches!(campaign.outcome, Some(TrialOutcome::Aborted(_)));
    is_aborted || campaign.verdict().outcome() == Outcome::DoNotUse
}

/// The command that prints every run and every remark of the campaign of this number.
pub fn remarks_of_trial(number: CampaignId, logbook: &Path) -> String {
    format!("seatrial logbook {} --logbook {}", number.0, logbook.display())
}

/// The command that makes the page of the campaign of this number in a logbook.
pub fn report_of_trial(number: CampaignId, logbook: &Path) -> String {
    format!("seatrial report {}", place(number, logbook))
}

fn place(number: CampaignId, logbook: &Path) -> String {
    format!("--logbook {} --campaign {}", logbook.display(), number.0)
}

//! The report of a campaign, with all that its logbook knows of it.

use seatrial::campaign::Campaign;
use seatrial_logbook::{CampaignEntry, Circumstances, Error, Logbook};
use seatrial_report::{About, render};

use crate::trials::next;
use crate::trials::order::plan_of_campaign;

/// The report of a campaign of a logbook, HTML.
pub fn campaign_page(logbook: &Logbook, entry: &CampaignEntry) -> Result<String, Error> {
    let campaign = logbook.campaign(entry.id)?;
    let circumstances = logbook.circumstances(entry.id)?;
    Ok(page(logbook, entry, &campaign, &circumstances))
}

/// The report of a campaign that is at hand, HTML.
pub fn page(
    logbook: &Logbook,
    entry: &CampaignEntry,
    campaign: &Campaign,
    circumstances: &Circumstances,
) -> String {
    let place = format!("{}, campaign {}", logbook.path().display(), entry.id.0);
    let provenance = [
        ("Logbook", place),
        ("SHA-256 of the campaign", entry.head_sha256.clone()),
        ("SHA-256 of the plan", entry.plan_sha256.clone()),
    ];
    // A plan of another version is shown as text only.
    let plan = plan_of_campaign(entry).ok();
    let about = About {
        started: Some(&entry.started),
        place: circumstances.place.as_deref(),
        operator: circumstances.operator.as_deref(),
        firmware: circumstances.firmware.as_deref(),
        notes: entry.notes.as_deref(),
        plan: plan.as_deref(),
        plan_text: &entry.plan,
        provenance: &provenance,
    };
    let command =
        next::after_trial(campaign, entry.id, logbook.path(), circumstances.firmware.as_deref());
    render(campaign, &about, &command)
}

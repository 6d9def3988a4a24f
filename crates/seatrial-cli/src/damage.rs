//! What is damaged of a logbook, said wherever something of it is shown.

use seatrial_logbook::{CampaignEntry, CampaignId, Damage, Error, Logbook};

use crate::output::say;
use crate::screen::{labelled, width};

/// A campaign; says of one that is damaged that it is.
pub fn warn(logbook: &Logbook, campaign: CampaignId) -> Result<CampaignEntry, Error> {
    let entry = logbook.entry(campaign)?;
    if let Some(damage) = &entry.damage {
        say(format!("warning: {}", text(damage).trim_end()));
    }
    Ok(entry)
}

/// Says what the logbook lacks.
pub fn warn_of_missing(logbook: &Logbook) {
    if let Some(missing) = logbook.missing() {
        say(format!("warning: {missing}"));
    }
}

/// What is damaged, and what follows from it.
pub fn text(damage: &Damage) -> String {
    let what = match damage.campaign() {
        Some(number) => format!("campaign {number}"),
        None => "the logbook".into(),
    };
    let found = format!(
        "{what}: DAMAGED, none of its models is to be used: {}: {}; `seatrial logbook --verify` says what is whole",
        damage.place, damage.found
    );
    labelled("", &found, width())
}

/// The campaigns of a damaged logbook that are not damaged themselves.
pub fn whole_campaigns(logbook: &Logbook) -> String {
    let entries = logbook.campaigns().unwrap_or_default();
    let whole = entries.iter().filter(|entry| entry.damage.is_none());
    let numbers: Vec<String> = whole.map(|entry| entry.id.0.to_string()).collect();
    match numbers.as_slice() {
        [] => "no campaign".into(),
        [one] => format!("campaign {one}"),
        several => format!("campaigns {}", several.join(", ")),
    }
}

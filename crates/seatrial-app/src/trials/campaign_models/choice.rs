//! Which campaign of a logbook is meant.

use seatrial_core::{Axis, Outcome};
use seatrial_logbook::{CampaignEntry, CampaignId, Logbook, State};

use crate::Error;

/// What a campaign is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Models that a vehicle is steered with, on the axis of yaw: trials on vehicles go before rehearsals.
    Models,
    /// To be shown or replayed: where none was accepted, the last one does.
    Record,
}

/// A campaign that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignChoice {
    /// The campaign.
    pub entry: CampaignEntry,
    /// Why the newest campaign is not the one.
    pub passed_over: Option<String>,
}

/// The campaign of that number, or the last one.
pub fn campaign_numbered(logbook: &Logbook, number: Option<i64>) -> Result<CampaignEntry, Error> {
    match number {
        Some(number) => Ok(logbook.entry(CampaignId(number))?),
        None => logbook.entries()?.pop().ok_or_else(|| {
            Error::Input(format!(
                "{}: the logbook holds no campaign yet; `seatrial trial` runs one",
                logbook.path().display()
            ))
        }),
    }
}

/// The campaign of this number, or of all campaigns, or those of the configuration of this name, the last that finished
/// with an accepted model.
pub fn chosen_campaign(
    logbook: &Logbook,
    name: Option<&str>,
    purpose: Purpose,
) -> Result<CampaignChoice, Error> {
    if let Some(number) = name.and_then(|name| name.parse().ok()) {
        let entry = campaign_numbered(logbook, Some(number))?;
        if purpose == Purpose::Models && entry.axis() == Axis::Pitch {
            return Err(Error::Input(format!(
                "{}: campaign {number} is of pitch; gains, turning limits and exports are made of yaw",
                logbook.path().display()
            )));
        }
        return Ok(CampaignChoice { entry, passed_over: None });
    }
    let mut campaigns = logbook.entries()?;
    if purpose == Purpose::Models {
        campaigns.retain(|campaign| campaign.axis() == Axis::Yaw);
    }
    if let Some(name) = name {
        campaigns = of_configuration(logbook, campaigns, name)?;
    }
    let newest = match campaigns.last() {
        Some(newest) => newest.clone(),
        None => {
            let newest = campaign_numbered(logbook, None)?;
            let path = logbook.path().display();
            return Err(Error::Input(format!(
                "{path}: no campaign of yaw; the newest, campaign {}, is of pitch",
                newest.id.0
            )));
        }
    };
    let entry = match last_accepted(logbook, &campaigns, purpose)? {
        Some(entry) => entry,
        None if purpose == Purpose::Record => newest.clone(),
        None => {
            let path = logbook.path().display();
            let number = newest.id.0;
            return Err(Error::Input(format!(
                "{path}: no campaign that finished with an accepted model; the newest is campaign {number}, which {}; --campaign {number} takes it all the same",
                why_not(logbook, &newest)?
            )));
        }
    };
    let passed_over = match entry.id == newest.id {
        true => None,
        false => Some(format!(
            "campaign {} is taken; the newest, campaign {}, {}; --campaign {} takes it all the same",
            entry.id.0,
            newest.id.0,
            why_not(logbook, &newest)?,
            newest.id.0
        )),
    };
    Ok(CampaignChoice { entry, passed_over })
}

fn of_configuration(
    logbook: &Logbook,
    campaigns: Vec<CampaignEntry>,
    name: &str,
) -> Result<Vec<CampaignEntry>, Error> {
    let mut held: Vec<String> = campaigns.iter().map(|c| c.configuration.clone()).collect();
    held.sort_unstable();
    held.dedup();
    let found: Vec<CampaignEntry> =
        campaigns.into_iter().filter(|campaign| campaign.configuration == name).collect();
    if found.is_empty() {
        return Err(Error::Input(format!(
            "{}: no configuration {name:?}; it holds: {}",
            logbook.path().display(),
            held.join(", ")
        )));
    }
    Ok(found)
}

/// The campaign of that number, or the last one of that configuration.
pub fn campaign_named(logbook: &Logbook, name: &str) -> Result<CampaignEntry, Error> {
    if let Ok(number) = name.parse() {
        return campaign_numbered(logbook, Some(number));
    }
    let mut found = of_configuration(logbook, logbook.entries()?, name)?;
    found.pop().map_or_else(|| campaign_numbered(logbook, None), Ok)
}

fn last_accepted(
    logbook: &Logbook,
    campaigns: &[CampaignEntry],
    purpose: Purpose,
) -> Result<Option<CampaignEntry>, Error> {
    let kinds: &[Option<bool>] = match purpose {
        Purpose::Models => &[Some(false), Some(true)],
        Purpose::Record => &[None],
    };
    for is_rehearsal in kinds {
        let of_kind = campaigns.iter().rev().filter(|campaign| {
            is_rehearsal.is_none_or(|is_rehearsal| campaign.is_rehearsal() == is_rehearsal)
        });
        for campaign in of_kind {
            if is_accepted(logbook, campaign)? {
                return Ok(Some(campaign.clone()));
            }
        }
    }
    Ok(None)
}

/// Did it finish with a model, without contradictions between its speeds?
fn is_accepted(logbook: &Logbook, entry: &CampaignEntry) -> Result<bool, Error> {
    if not_finished(entry.state).is_some() || entry.runs_accepted == 0 {
        return Ok(false);
    }
    Ok(logbook.campaign(entry.id)?.verdict().accepted)
}

/// Why a campaign did not finish.
pub fn not_finished(state: State) -> Option<String> {
    Some(match state {
        State::Ended { outcome: Outcome::Finished } => return None,
        State::Ended { outcome: Outcome::Aborted(reason) } => format!("was aborted: {reason}"),
        State::Unfinished => "is not finished".into(),
        State::Interrupted => "was interrupted".into(),
    })
}

fn why_not(logbook: &Logbook, entry: &CampaignEntry) -> Result<String, Error> {
    if let Some(damage) = logbook.entry(entry.id)?.damage {
        return Ok(format!("is damaged ({}: {})", damage.place, damage.found));
    }
    if let Some(why) = not_finished(entry.state) {
        return Ok(why);
    }
    Ok(match is_accepted(logbook, entry)? {
        false => "has no model that is accepted".into(),
        true => "is a rehearsal on a simulator".into(),
    })
}

//! Models of a logbook's campaigns.

use std::path::Path;

use seatrial::GainAllowance;
use seatrial_core::{RudderUnit, SchedulePoint};
use seatrial_logbook::{CampaignEntry, CampaignId, Logbook};

use super::{ModelPoint, Models};
use crate::Error;

/// The campaign of that number, or the last one.
pub fn campaign_numbered(logbook: &Logbook, number: Option<i64>) -> Result<CampaignEntry, Error> {
    match number {
        Some(number) => Ok(logbook.entry(CampaignId(number))?),
        None => logbook.campaigns()?.pop().ok_or_else(|| {
            Error::Input(format!(
                "{}: the logbook holds no campaign yet; `seatrial trial` runs one",
                logbook.path().display()
            ))
        }),
    }
}

/// The campaign of that number, or the last one of that configuration.
pub fn campaign_named(logbook: &Logbook, name: &str) -> Result<CampaignEntry, Error> {
    if let Ok(number) = name.parse() {
        return campaign_numbered(logbook, Some(number));
    }
    let campaigns = logbook.campaigns()?;
    let mut held: Vec<&str> = campaigns
        .iter()
        .map(|entry| entry.configuration.as_str())
        .collect();
    held.sort_unstable();
    held.dedup();
    let held = held.join(", ");
    campaigns
        .into_iter()
        .rfind(|entry| entry.configuration == name)
        .ok_or_else(|| {
            Error::Input(format!(
                "{}: no configuration {name:?}; it holds: {held}",
                logbook.path().display()
            ))
        })
}

/// The models of the accepted runs of a campaign.
pub fn of_campaign(path: &Path, number: Option<i64>) -> Result<Models, Error> {
    let logbook = Logbook::open_read_only(path)?;
    let entry = campaign_numbered(&logbook, number)?;
    let origin = format!("{}, campaign {}", path.display(), entry.id.0);
    let campaign = logbook.campaign(entry.id)?;
    let points: Vec<ModelPoint> = campaign
        .accepted_runs()
        .into_iter()
        .filter_map(|run| {
            let identification = run.identification.as_ref()?;
            let refined = identification.refined.as_ref();
            Some(ModelPoint {
                point: SchedulePoint {
                    thrust: Some(run.thrust),
                    surge_speed_m_s: run.surge_speed_m_s,
                    model: identification.model(),
                },
                covariance: refined.map(|refined| refined.covariance),
                allowance: GainAllowance::of(identification),
                noise: refined.map(|r| [r.heading_noise_rad, r.disturbance_rad_s2]),
                valid_range: identification.valid_range,
            })
        })
        .collect();
    if points.is_empty() {
        return Err(Error::Input(format!(
            "{origin}: no accepted run in this trial"
        )));
    }
    Ok(Models {
        origin,
        points,
        rudder_limit_rad: campaign.rudder_limit_rad,
        rudder_unit: RudderUnit::Rad,
        rejected: Vec::new(),
    })
}

//! Models of a logbook's campaigns.

mod choice;
mod comparison;

use std::path::Path;

use seatrial::motions::surge::SurgeModel;
use seatrial::{Campaign, CourseChange, GainAllowance};
use seatrial_core::{RudderUnit, SchedulePoint};
use seatrial_logbook::{CampaignEntry, Logbook};

use crate::Error;
use crate::models::{ModelPoint, Models, TrialOrigin};

pub use choice::{CampaignChoice, Purpose, campaign_named, campaign_numbered, chosen_campaign};
pub use comparison::{ComparedModels, compared_models, open_named};

use choice::not_finished;

/// The models of the accepted runs of a campaign, chosen by its number, by the name of its configuration or else as
/// [`chosen_campaign`] does for a vehicle. A logbook that is damaged gives none.
pub fn of_campaign(path: &Path, name: Option<&str>) -> Result<Models, Error> {
    let logbook = undamaged(path)?;
    let chosen = chosen_campaign(&logbook, name, Purpose::Models)?;
    let mut models = of_checked(&logbook, &chosen.entry)?;
    models.passed_over = chosen.passed_over;
    models.cautions.extend(logbook.missing().map(str::to_owned));
    Ok(models)
}

/// Opens a logbook whose numbers are used, not only shown: every edge takes models, and what is compared with them, from here.
///
/// # Errors
/// A logbook that cannot be read, or of which something was changed since it was written.
pub fn undamaged(path: &Path) -> Result<Logbook, Error> {
    let logbook = Logbook::open_read_only(path)?;
    check_undamaged(&logbook)?;
    Ok(logbook)
}

/// [`undamaged`], of a logbook that is open.
pub fn check_undamaged(logbook: &Logbook) -> Result<(), Error> {
    match logbook.verify()?.damage.into_iter().next() {
        None => Ok(()),
        Some(damage) => Err(Error::Logbook(seatrial_logbook::Error::Damaged {
            path: logbook.path().to_path_buf(),
            place: damage.place,
            found: damage.found,
        })),
    }
}

/// The models of the accepted runs of this campaign. A logbook that is damaged gives none.
pub fn of_entry(logbook: &Logbook, entry: &CampaignEntry) -> Result<Models, Error> {
    check_undamaged(logbook)?;
    of_checked(logbook, entry)
}

fn of_checked(logbook: &Logbook, entry: &CampaignEntry) -> Result<Models, Error> {
    let origin = format!("{}, campaign {}", logbook.path().display(), entry.id.0);
    let mut models = Models::of_trial(origin, &logbook.campaign(entry.id)?)?;
    if let Some(trial) = &mut models.trial {
        trial.number = Some(entry.id.0);
        trial.started = Some(entry.started.clone());
    }
    if models.rejected.is_empty() {
        let caution = not_finished(entry.state).map(|why| format!("the campaign {why}"));
        models.cautions.extend(caution);
    }
    Ok(models)
}

impl Models {
    /// The models of the accepted runs of a trial; `origin` is what messages call it.
    ///
    /// # Errors
    /// A trial without an accepted run.
    pub fn of_trial(origin: String, campaign: &Campaign) -> Result<Self, Error> {
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
                    rudder_lag_s: identification.lagging().map_or(0.0, |l| l.rudder_lag_s),
                    steady_turn: identification.steady_turn(),
                })
            })
            .collect();
        if points.is_empty() {
            return Err(Error::Input(format!("{origin}: no accepted run in this trial")));
        }
        Ok(Self {
            origin,
            points,
            rudder_limit_rad: campaign.rudder_limit_rad,
            rudder_unit: RudderUnit::Rad,
            full_rudder: campaign.full_rudder,
            trial: Some(origin_of(campaign)),
            cautions: Vec::new(),
            surge: SurgeModel::of(campaign),
            passed_over: None,
            rejected: against(campaign),
            promised: promised(campaign),
        })
    }
}

fn origin_of(campaign: &Campaign) -> TrialOrigin {
    TrialOrigin {
        number: None,
        vehicle: campaign.vehicle.clone(),
        configuration: campaign.configuration.clone(),
        started: None,
        software_version: campaign.software_version.clone(),
        is_rehearsal: campaign.is_rehearsal(),
        scenario: campaign.scenario.clone(),
    }
}

/// What a course change will do with the gains of the accepted runs of a trial.
pub fn promised(campaign: &Campaign) -> Option<CourseChange> {
    let runs = campaign.accepted_runs().into_iter();
    CourseChange::of_all(runs.filter_map(|run| {
        let found = run.identification.as_ref()?;
        CourseChange::of(found, Some(campaign.rudder_limit_rad))
    }))
}

/// What the campaign says against its own models, where as a whole they are not to be used.
fn against(campaign: &Campaign) -> Vec<String> {
    let verdict = campaign.verdict();
    let causes = verdict.causes().filter(|_| !verdict.accepted);
    causes.map(|reason| reason.text.clone()).collect()
}

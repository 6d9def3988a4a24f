//! The models of a long log: one for each speed at which manoeuvres were found in it.

use seatrial::campaign_check::{SpeedResult, contradictions};
use seatrial::identification::{Identification, Verdict};
use seatrial::identify::identify_joined;
use seatrial::identify::joined::Joined;
use seatrial::identify::{IdentifyError, IdentifySettings, ValidationData};
use seatrial::segmentation::{Proposal, find, propose};
use serde::{Deserialize, Serialize};

use super::no_model;
use crate::Error;
use crate::logs::{Observer, OpenedLog};

/// A model of one speed, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedModel {
    /// Mean thrust, a fraction of full.
    pub thrust: Option<f64>,
    /// Mean forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Where it was found.
    pub windows: Proposal,
    /// What each manoeuvre says by itself, where several were joined.
    pub joined: Option<Joined>,
    /// The model.
    pub identification: Option<Identification>,
    /// May it be used?
    pub verdict: Verdict,
}

/// Finds the manoeuvres of a log and identifies a model for each of their speeds, slowest first. `None` of a log that
/// has no manoeuvres or is one.
pub fn identify_speeds(
    log: &OpenedLog,
    settings: &IdentifySettings,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<SpeedModel>>, Error> {
    let proposals = propose(&log.record, &find(&log.record.samples));
    let mut models = proposals
        .into_iter()
        .map(|proposal| {
            observer.found(&log.path, &proposal);
            SpeedModel::identify(log, proposal, settings)
        })
        .collect::<Result<Vec<_>, _>>()?;
    refuse_contradictions(&mut models);
    Ok((!models.is_empty()).then_some(models))
}

/// Where speeds contradict each other, none of their models may be used.
fn refuse_contradictions(models: &mut [SpeedModel]) {
    let accepted = models.iter().filter(|model| model.verdict.accepted);
    let results: Vec<SpeedResult> = accepted.filter_map(SpeedModel::result).collect();
    let reasons = contradictions(&results);
    if reasons.is_empty() {
        return;
    }
    let refused = Verdict {
        accepted: false,
        reasons,
    };
    for model in models.iter_mut().filter(|model| model.verdict.accepted) {
        model.verdict = refused.clone();
        if let Some(identification) = &mut model.identification {
            identification.verdict = refused.clone();
        }
    }
}

/// The model that stands for all: the accepted one with the surest rudder, else the first there is. `None` of no models.
pub fn foremost(models: &[SpeedModel]) -> Option<&SpeedModel> {
    let rudder_share = |model: &SpeedModel| {
        let refined = model.identification.as_ref()?.refined.as_ref()?;
        Some(refined.covariance[1][1].sqrt() / refined.model.b2_per_s2.abs())
    };
    models
        .iter()
        .filter(|model| model.verdict.accepted)
        .min_by(|a, b| {
            let shares = [a, b].map(|model| rudder_share(model).unwrap_or(f64::INFINITY));
            shares[0].total_cmp(&shares[1])
        })
        .or_else(|| models.iter().find(|model| model.identification.is_some()))
        .or_else(|| models.first())
}

impl SpeedModel {
    /// What the speeds of a log are compared by.
    fn result(&self) -> Option<SpeedResult<'_>> {
        Some(SpeedResult {
            thrust: self.thrust,
            surge_speed_m_s: self.surge_speed_m_s,
            refined: self.identification.as_ref()?.refined.as_ref()?,
        })
    }

    fn identify(
        log: &OpenedLog,
        proposal: Proposal,
        settings: &IdentifySettings,
    ) -> Result<Self, Error> {
        let held_out = proposal.validation.map(|window| ValidationData {
            record: &log.record,
            window,
        });
        let (identification, joined, verdict) =
            match identify_joined(&log.record, &proposal.training, held_out, settings) {
                Ok((identification, joined)) => {
                    let verdict = identification.verdict.clone();
                    (Some(identification), joined, verdict)
                }
                Err(IdentifyError::Refused(reason)) => (None, None, Verdict::refused(reason)),
                Err(error) => return Err(no_model(log, error)),
            };
        Ok(Self {
            thrust: proposal.thrust,
            surge_speed_m_s: proposal.surge_speed_m_s,
            windows: proposal,
            joined,
            identification,
            verdict,
        })
    }
}

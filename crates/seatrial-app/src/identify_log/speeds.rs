//! The models of a long log: one for each speed at which manoeuvres were found in it.

use seatrial::campaign::speeds::{
    Part, SpeedLaw, SpeedResult, contradictions, missing, remarks, share, whole,
};
use seatrial::identification::{
    Identification, Outcome, Reason, ReasonCode, Refined, Subject, Verdict,
};
use seatrial::identify::joint_estimate::JointEstimate;
use seatrial::identify::{IdentifyError, IdentifySettings, RecordSurvey, ValidationData};
use seatrial::identify::{Proposal, propose};
use seatrial::log::segmentation::find;
use serde::{Deserialize, Serialize};

use super::no_model;
use crate::Error;
use crate::logs::{Observer, OpenedLog};
use crate::workers::of_each;

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
    pub joined: Option<JointEstimate>,
    /// The model.
    pub identification: Option<Identification>,
    /// What its own manoeuvres say, where the model has more from the other speeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<Refined>,
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
    identify_proposals(log, proposals, settings, observer)
}

/// Identifies a model for each of these speeds. `None` of none.
pub(super) fn identify_proposals(
    log: &OpenedLog,
    proposals: Vec<Proposal>,
    settings: &IdentifySettings,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<SpeedModel>>, Error> {
    if proposals.is_empty() {
        return Ok(None);
    }
    for proposal in &proposals {
        observer.found(&log.path, proposal);
    }
    let record = RecordSurvey::of(&log.record);
    let mut models = of_each(&proposals, |proposal| {
        SpeedModel::identify(log, &record, proposal.clone(), settings)
    })
    .into_iter()
    .collect::<Result<Vec<_>, _>>()?;
    refuse_contradictions(&mut models);
    Ok(Some(models))
}

/// Gives each accepted model what one law over speed, or over thrust where a speed is not known, tells of it. `None` where none does.
pub(super) fn share_over_speed(models: &mut [SpeedModel]) -> Option<SpeedLaw> {
    let knows_speed = models.iter().all(|model| model.surge_speed_m_s.is_some());
    let refined = |model: &SpeedModel| model.identification.as_ref()?.refined.clone();
    let own: Vec<_> = models.iter().map(refined).collect();
    let mut taking = Vec::new();
    for model in models.iter_mut() {
        let key = match knows_speed {
            true => model.surge_speed_m_s,
            false => model.thrust,
        };
        taking.extend(key.zip(model.identification.as_mut()));
    }
    let law = share(&mut taking)?;
    for (model, own) in models.iter_mut().zip(own) {
        let is_shared = refined(model) != own;
        model.own = own.filter(|_| is_shared);
    }
    Some(law)
}

/// Where speeds contradict each other, none of their models may be used.
fn refuse_contradictions(models: &mut [SpeedModel]) {
    let accepted = models.iter().filter(|model| model.verdict.accepted);
    let results: Vec<SpeedResult> = accepted.filter_map(SpeedModel::result).collect();
    let reasons = contradictions(&results);
    if reasons.is_empty() {
        return;
    }
    let refused = Verdict { accepted: false, reasons };
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
        .or_else(|| models.iter().find(|model| is_not_validated(model)))
        .or_else(|| models.iter().find(|model| model.identification.is_some()))
        .or_else(|| models.first())
}

fn is_not_validated(model: &SpeedModel) -> bool {
    model.verdict.outcome() == Outcome::NotValidated
}

/// May the models of a log be used, as a whole? It is no better than any of those that may be, and with care where a speed has
/// none. Where none may be used, the foremost one says why, and then the others.
pub(super) fn whole_verdict(models: &[SpeedModel]) -> Verdict {
    if let [only] = models {
        return only.verdict.clone();
    }
    let names: Vec<String> = models.iter().map(SpeedModel::figure).collect();
    let parts = models.iter().zip(&names);
    let parts: Vec<Part> =
        parts.map(|(model, name)| Part { name, verdict: &model.verdict }).collect();
    let unit = models.first().map_or("", SpeedModel::unit);
    let accepted: Vec<Part> = parts.iter().filter(|p| p.verdict.accepted).copied().collect();
    if !accepted.is_empty() {
        return whole(&accepted, unit, missing(&parts, unit));
    }
    let mut reasons = foremost(models).map_or_else(Vec::new, |model| model.verdict.reasons.clone());
    let given: Vec<_> = reasons.iter().map(Reason::kind).collect();
    let rest = remarks(&parts, unit, |_| true).into_iter();
    reasons.extend(rest.filter(|reason| !given.contains(&reason.kind())));
    Verdict { accepted: false, reasons }
}

/// Manoeuvres that differ, in a log that has neither speed nor thrust, may be of several speeds: that comes first, unless the heading is coarse.
fn name_unknown_speed(verdict: &mut Verdict, proposal: &Proposal) {
    let is_unknown = proposal.thrust.is_none() && proposal.surge_speed_m_s.is_none();
    let differ = is_unknown && !verdict.accepted && verdict.has(&ReasonCode::ManoeuvresDiffer);
    let coarse = verdict.reasons.iter().position(|reason| reason.code == ReasonCode::Quantised);
    if let Some(coarse) = coarse.filter(|_| differ) {
        // Coarse steps make them differ at any speed.
        let coarse = verdict.reasons.remove(coarse);
        verdict.reasons.insert(0, coarse);
    } else if differ {
        let windows = proposal.training.len() + usize::from(proposal.validation.is_some());
        let reason = Reason::new(
            ReasonCode::ManoeuvresDiffer.of(Subject::Speed),
            format!(
                "{windows} manoeuvres were taken for manoeuvres of one speed: the log has neither speed nor thrust"
            ),
        );
        verdict.reasons.insert(0, reason);
    }
}

impl SpeedModel {
    /// Its speed in m/s, else its thrust in per cent, without the unit.
    fn figure(&self) -> String {
        match (self.surge_speed_m_s, self.thrust) {
            (Some(speed), _) => format!("{speed:.2}"),
            (None, Some(thrust)) => format!("{:.0}", 100.0 * thrust),
            (None, None) => "an unknown".into(),
        }
    }

    fn unit(&self) -> &'static str {
        match (self.surge_speed_m_s, self.thrust) {
            (Some(_), _) => "m/s",
            (None, Some(_)) => "% thrust",
            (None, None) => "speed",
        }
    }

    /// Its speed, else its thrust, for messages.
    pub fn name(&self) -> String {
        format!("{} {}", self.figure(), self.unit())
    }

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
        record: &RecordSurvey,
        proposal: Proposal,
        settings: &IdentifySettings,
    ) -> Result<Self, Error> {
        let held_out =
            proposal.validation.map(|window| ValidationData { record: &log.record, window });
        let (identification, joined, verdict) =
            match record.identify_joined(&proposal.training, held_out, settings) {
                Ok((mut identification, joined)) => {
                    name_unknown_speed(&mut identification.verdict, &proposal);
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
            own: None,
            verdict,
        })
    }
}

//! Models of the documents of `identify --json` and `trial --json`.

use std::path::Path;

use seatrial::identification::{
    EstimateMethod, GainVehicle, ReasonCode, SteadyTurn, ValidRange, covariance_of_intervals,
};
use seatrial::likelihood::SteeringModel;
use seatrial::{CourseChange, FullRudder, GainAllowance, Window};
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::{Nomoto, RudderUnit, SchedulePoint, YawModel};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::statement::{ModelStatement, StatedVerdict};
use super::{ModelPoint, Models, TrialOrigin, given, limit_or_default, place, read_text};
use crate::{Error, IdentifiedLog};

/// What is read of a document: the rest of it is left alone, so that documents of other versions are read, too.
#[derive(Deserialize)]
struct StoredDocument {
    #[serde(default)]
    source: StoredSource,
    campaign: Option<StoredCampaign>,
    rudder_limit_rad: Option<f64>,
    full_rudder: Option<FullRudder>,
    vehicle: Option<String>,
    configuration: Option<String>,
    software_version: Option<String>,
    seed: Option<u64>,
    scenario: Option<String>,
    runs: Option<Vec<StoredRun>>,
    models: Option<Vec<StoredRun>>,
    first_answer: Option<CourseChange>,
    identification: Option<StoredIdentification>,
    /// Of a log: its model, or the surest one of its speeds; of all, the verdict on the whole.
    #[serde(flatten)]
    head: StoredIdentification,
}

#[derive(Deserialize)]
struct StoredCampaign {
    rudder_limit_rad: Option<f64>,
    runs: Vec<StoredRun>,
}

#[derive(Default, Deserialize)]
struct StoredSource {
    #[serde(default)]
    rudder_unit: RudderUnit,
    full_rudder_rad: Option<f64>,
}

/// A run of a trial, or the model of one speed of a log.
#[derive(Deserialize)]
struct StoredRun {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    identification: Option<StoredIdentification>,
    /// What its own manoeuvres say, where the model has more from the other speeds.
    own: Option<StoredRefined>,
    verdict: Option<StatedVerdict>,
}

#[derive(Deserialize)]
struct StoredIdentification {
    online: Option<StoredOnline>,
    refined: Option<StoredRefined>,
    nomoto: Option<Nomoto<f64>>,
    higher_order: Option<StoredHigherOrder>,
    loop_timing: Option<LoopTiming<f64>>,
    training: Option<Window>,
    valid_range: Option<ValidRange>,
    verdict: Option<StatedVerdict>,
}

#[derive(Deserialize)]
struct StoredOnline {
    #[serde(flatten)]
    model: YawModel<f64>,
    delta0_rad: Option<f64>,
}

#[derive(Deserialize)]
struct StoredHigherOrder {
    model: SteeringModel,
    steady_log_gain: Option<[f64; 2]>,
    steady_rudder_rad: Option<f64>,
    gain_vehicle: Option<GainVehicle>,
}

#[derive(Deserialize)]
struct StoredRefined {
    method: Option<EstimateMethod>,
    #[serde(flatten)]
    model: YawModel<f64>,
    delta0_rad: Option<f64>,
    covariance: Option<[[f64; 3]; 3]>,
    interval_95: Option<StoredIntervals>,
    heading_noise_rad: Option<f64>,
    disturbance_rad_s2: Option<f64>,
}

#[derive(Deserialize)]
struct StoredIntervals {
    a22_per_s: Option<[f64; 2]>,
    b2_per_s2: Option<[f64; 2]>,
    c0_rad_per_s2: Option<[f64; 2]>,
}

/// Why a document has no model.
#[derive(Debug, thiserror::Error)]
enum NoModel {
    #[error(
        "`verdict` is missing: whether the model may be used is not known; identify the log again"
    )]
    NoVerdict,
    #[error("neither `refined` nor `online` is there")]
    NoEstimate,
    #[error("{0}")]
    Wrong(String),
}

impl NoModel {
    fn at(self, place: &str) -> Error {
        match self {
            Self::Wrong(_) => Error::Setting(format!("{place}: {self}")),
            Self::NoVerdict | Self::NoEstimate => {
                Error::Input(format!("{place}: {self}; {EXPECTED}"))
            }
        }
    }
}

/// The models of an identification, or of the accepted runs of a trial; `surge_speed_m_s` is that of a single model; without, the
/// speed at which it was seen.
pub fn of_document(path: &Path, surge_speed_m_s: Option<f64>) -> Result<Models, Error> {
    of_document_text(path.display().to_string(), &read_text(path)?, surge_speed_m_s)
}

/// [`of_document`] of one that is at hand; `origin` is what messages call it.
pub fn of_document_text(
    origin: String,
    text: &str,
    surge_speed_m_s: Option<f64>,
) -> Result<Models, Error> {
    let document: StoredDocument = read(&origin, text)?;
    of_stored(origin, document, surge_speed_m_s)
}

/// [`of_document`] with what the manoeuvres of each speed say by themselves: models that borrow from each other are no independent ones.
pub fn of_document_alone(path: &Path) -> Result<Models, Error> {
    let origin = path.display().to_string();
    let mut document: StoredDocument = read(&origin, &read_text(path)?)?;
    let runs = document.models.iter_mut().flatten();
    for (own, identification) in
        runs.filter_map(|run| run.own.take().zip(run.identification.as_mut()))
    {
        identification.refined = Some(own);
        identification.nomoto = None;
        document.head.refined = None;
        document.head.online = None;
    }
    of_stored(origin, document, None)
}

fn of_stored(
    origin: String,
    document: StoredDocument,
    surge_speed_m_s: Option<f64>,
) -> Result<Models, Error> {
    let rudder_unit = document.source.rudder_unit;
    let trial = document.trial();
    let full_rudder = document.full_rudder.or(given(document.source.full_rudder_rad));
    let (limit, runs) = match document.campaign {
        Some(campaign) => (campaign.rudder_limit_rad, Some(campaign.runs)),
        None => (document.rudder_limit_rad, document.runs.or(document.models)),
    };
    let mut models = Models {
        origin,
        points: Vec::new(),
        rudder_limit_rad: limit_or_default(limit.or(document.source.full_rudder_rad), rudder_unit),
        rudder_unit,
        full_rudder,
        trial,
        cautions: Vec::new(),
        surge: None,
        passed_over: None,
        rejected: Vec::new(),
        promised: document.first_answer,
    };
    match runs {
        Some(runs) => {
            models.take_runs(&runs)?;
            models.take_head(&document.head, &runs)?;
        }
        None => {
            let single = document.identification.unwrap_or(document.head);
            models.take_single(&single, surge_speed_m_s)?;
        }
    }
    Ok(models)
}

impl Models {
    /// The accepted models of a log that was identified: those that [`of_document_text`] reads from its
    /// [document](IdentifiedLog::document). `surge_speed_m_s`, m/s, is the speed of a model of the whole log; without, the
    /// speed at which it was seen.
    ///
    /// A single model that is not accepted is given with its reason in `rejected`; of several speeds the accepted ones are.
    ///
    /// # Errors
    /// The log has no model, or none of its speeds has an accepted one.
    pub fn of_log(found: &IdentifiedLog, surge_speed_m_s: Option<f64>) -> Result<Self, Error> {
        let origin = found.logs.log.path.display().to_string();
        let text = serde_json::to_string(&found.document());
        let text = text.map_err(|error| Error::Rejected(error.to_string()))?;
        of_document_text(origin, &text, surge_speed_m_s)
    }
}

impl StoredDocument {
    /// The trial, where the document is of one.
    fn trial(&self) -> Option<TrialOrigin> {
        Some(TrialOrigin {
            number: None,
            vehicle: self.vehicle.clone()?,
            configuration: self.configuration.clone().unwrap_or_default(),
            started: None,
            software_version: self.software_version.clone().unwrap_or_default(),
            is_rehearsal: self.seed.is_some(),
            scenario: self.scenario.clone(),
        })
    }
}

const EXPECTED: &str =
    "expected a document of `seatrial identify --json` or `seatrial trial --json`";

fn read<T: DeserializeOwned>(origin: &str, text: &str) -> Result<T, Error> {
    serde_json::from_str(text)
        .map_err(|error| Error::Input(format!("{origin}: {error}; {EXPECTED}")))
}

impl Models {
    /// The last accepted run of a thrust counts.
    fn take_runs(&mut self, runs: &[StoredRun]) -> Result<(), Error> {
        let mut refused = Vec::new();
        for (run, number) in runs.iter().zip(1..) {
            let said = |why: NoModel| why.at(&format!("{}: run {number}", self.origin));
            if !accepts(run.verdict.as_ref()).map_err(said)? {
                refused.push(run);
                continue;
            }
            let point = run.point().map_err(said)?;
            self.points.retain(|p| run.thrust.is_none() || p.point.thrust != run.thrust);
            self.points.push(point);
        }
        for run in refused {
            let has_another = |p: &ModelPoint| p.point.thrust == run.thrust;
            if run.thrust.is_none() || !self.points.iter().any(has_another) {
                let name = place(run.thrust, run.surge_speed_m_s);
                self.cautions
                    .push(format!("{name} has no accepted run, and so no model of its own"));
            }
        }
        if self.points.is_empty() {
            return Err(Error::Input(format!("{}: no accepted run in this trial", self.origin)));
        }
        Ok(())
    }

    /// What a document says above its runs, or above the models of its speeds, does not contradict them.
    fn take_head(&mut self, head: &StoredIdentification, runs: &[StoredRun]) -> Result<(), Error> {
        let said = |why: NoModel| why.at(&self.origin);
        let Some(verdict) = &head.verdict else {
            return Ok(());
        };
        let is_accepted = accepts(Some(verdict)).map_err(said)?;
        if let Ok(model) = head.model() {
            head.check(None, is_accepted).map_err(said)?;
            let models = runs.iter().filter_map(|run| run.identification.as_ref());
            if !models.filter_map(|of| of.model().ok()).any(|of| of == model) {
                let wrong = "the model above the others is none of them: take the document as seatrial wrote it";
                return Err(said(NoModel::Wrong(wrong.into())));
            }
        }
        if !is_accepted {
            self.rejected.push(verdict.refusal().into());
        }
        Ok(())
    }

    fn take_single(
        &mut self,
        identification: &StoredIdentification,
        surge_speed_m_s: Option<f64>,
    ) -> Result<(), Error> {
        let said = |why: NoModel| why.at(&self.origin);
        let verdict = identification.verdict.as_ref();
        if let (Err(_), Some(refused)) = (identification.model(), verdict) {
            let refusal = refused.refusal();
            let none = format!("{}: this log gave no model: {refusal}", self.origin);
            return Err(Error::Input(none));
        }
        let is_accepted = match identification.model() {
            Ok(_) => accepts(verdict),
            Err(none) => Err(none),
        };
        let is_accepted = is_accepted.map_err(said)?;
        let stated = identification.check(None, is_accepted).map_err(said)?;
        let point = identification.point(None, surge_speed_m_s, &stated);
        let point = point.map_err(said)?;
        if let Some(verdict) = verdict.filter(|_| !is_accepted) {
            self.rejected.push(verdict.refusal().into());
        }
        self.points.push(point);
        Ok(())
    }
}

/// Does a verdict accept a model?
fn accepts(verdict: Option<&StatedVerdict>) -> Result<bool, NoModel> {
    let verdict = verdict.ok_or(NoModel::NoVerdict)?;
    match verdict.wrong() {
        Some(wrong) => Err(NoModel::Wrong(wrong)),
        None => Ok(verdict.accepted),
    }
}

impl StoredRun {
    /// The model of a run that is accepted, by its own verdict or by an operator.
    fn point(&self) -> Result<ModelPoint, NoModel> {
        let identification = self.identification.as_ref().ok_or(NoModel::NoEstimate)?;
        let by_operator = ReasonCode::AcceptedByOperator.into();
        let verdict = self.verdict.as_ref();
        let is_by_itself = !verdict.is_some_and(|verdict| verdict.has(&by_operator));
        if let Some(own) = &identification.verdict
            && !accepts(Some(own))?
            && is_by_itself
        {
            return Err(NoModel::Wrong(
                "the run is accepted, and its model is not: take the document as seatrial wrote it"
                    .into(),
            ));
        }
        let stated = identification.check(self.surge_speed_m_s, is_by_itself)?;
        identification.point(self.thrust, self.surge_speed_m_s, &stated)
    }
}

impl StoredIdentification {
    /// The refined estimate where there is one, else the online one.
    fn model(&self) -> Result<YawModel<f64>, NoModel> {
        let refined = self.refined.as_ref().map(|refined| refined.model);
        let online = || self.online.as_ref().map(|online| online.model);
        refined.or_else(online).ok_or(NoModel::NoEstimate)
    }

    /// Holds what is stated of the model against itself; `is_accepted` by a verdict and by no operator.
    fn check(
        &self,
        surge_speed_m_s: Option<f64>,
        is_accepted: bool,
    ) -> Result<ModelStatement, NoModel> {
        let refined = self.refined.as_ref();
        let online = self.online.as_ref();
        let timing = self.loop_timing;
        let [of_heading, of_sea] =
            refined.map_or([None; 2], |r| [r.heading_noise_rad, r.disturbance_rad_s2]);
        let of_turn = self.steady_turn().map(|turn| turn.log_gain[1]);
        let stated = ModelStatement {
            theta: self.model()?.theta(),
            intervals: refined.map_or_else(Default::default, StoredRefined::intervals),
            gain_a22_per_s: (self.higher_order.as_ref())
                .and_then(|found| Some(found.gain_vehicle?.a22_per_s)),
            covariance: refined.and_then(StoredRefined::covariance),
            nomoto: self.nomoto,
            delta0_rad: match refined {
                Some(refined) => refined.delta0_rad,
                None => online.and_then(|online| online.delta0_rad),
            },
            valid_range: self.valid_range,
            surge_speed_m_s,
            training_s: self.training.map(|training| training.to_s - training.from_s),
            amounts: vec![
                ("heading_noise_rad", of_heading),
                ("disturbance_rad_s2", of_sea),
                ("delay_s", timing.map(|t| t.delay_s)),
                ("sample_interval_s", timing.and_then(|t| t.sample_interval_s)),
                ("rudder_lag_s", Some(self.rudder_lag_s())),
                ("the variance of steady_log_gain", of_turn),
            ],
            is_accepted,
        };
        match stated.wrong() {
            Some(wrong) => Err(NoModel::Wrong(wrong)),
            None => Ok(stated),
        }
    }

    /// The model, by what was [checked](Self::check). Of an online estimate P is no covariance.
    fn point(
        &self,
        thrust: Option<f64>,
        surge_speed_m_s: Option<f64>,
        stated: &ModelStatement,
    ) -> Result<ModelPoint, NoModel> {
        let refined = self.refined.as_ref();
        let model = self.model()?;
        let seen_at_m_s = || self.valid_range.as_ref()?.usual_surge_speed_m_s;
        Ok(ModelPoint {
            point: SchedulePoint {
                thrust,
                surge_speed_m_s: surge_speed_m_s.or_else(seen_at_m_s),
                model,
            },
            covariance: stated.covariance,
            allowance: GainAllowance {
                damping_per_s: GainAllowance::damping_of(
                    model.a22_per_s,
                    stated.least_damped_per_s(),
                    self.may_be_unstable(),
                ),
                timing: self.loop_timing.unwrap_or_default(),
            },
            noise: refined.and_then(|refined| {
                Some([refined.heading_noise_rad?, refined.disturbance_rad_s2?])
            }),
            valid_range: self.valid_range,
            rudder_lag_s: self.rudder_lag_s(),
            steady_turn: self.steady_turn(),
        })
    }

    /// Does the verdict say that no gain may hold?
    fn may_be_unstable(&self) -> bool {
        let verdict = self.verdict.as_ref();
        verdict.is_some_and(|verdict| verdict.has(&ReasonCode::Unstable.into()))
    }

    /// The steady turns of the hypotheses, where the model is not made of them.
    fn steady_turn(&self) -> Option<SteadyTurn> {
        let method = self.refined.as_ref().and_then(|r| r.method.as_ref());
        let found = self.higher_order.as_ref()?;
        let is_beyond = method == Some(&EstimateMethod::WeighedHypotheses);
        Some(SteadyTurn {
            log_gain: found.steady_log_gain.filter(|_| !is_beyond)?,
            at: found.steady_rudder_rad.map(|rudder_rad| (found.model, rudder_rad)),
        })
    }

    /// Lag of the rudder, where the model is the one behind it.
    fn rudder_lag_s(&self) -> f64 {
        let method = self.refined.as_ref().and_then(|r| r.method.as_ref());
        match &self.higher_order {
            Some(found) if method == Some(&EstimateMethod::RudderLag) => found.model.rudder_lag_s,
            _ => 0.0,
        }
    }
}

impl StoredRefined {
    fn covariance(&self) -> Option<[[f64; 3]; 3]> {
        self.covariance.or_else(|| {
            let [a22, b2, c0] = self.intervals();
            Some(covariance_of_intervals([a22?, b2?, c0?]))
        })
    }

    /// Of a22, b2 and C0.
    fn intervals(&self) -> [Option<[f64; 2]>; 3] {
        self.interval_95.as_ref().map_or_else(Default::default, |ends| {
            [ends.a22_per_s, ends.b2_per_s2, ends.c0_rad_per_s2]
        })
    }
}

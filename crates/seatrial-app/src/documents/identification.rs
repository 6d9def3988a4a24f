//! `identify --json`.

use seatrial::campaign::speeds::SpeedLaw;
use seatrial::identification::{
    HigherOrder, LagEffect, Online, Reader, Refined, RejectedSamples, Restoring, Settings,
    ValidRange, Validation, Verdict,
};
use seatrial::{CourseChange, Window};
use seatrial_core::Nomoto;
use seatrial_core::heading_loop::LoopTiming;
use serde::{Deserialize, Serialize};

use crate::advice;
use crate::identify_log::{IdentifiedLog, Part, SpeedModel};
use crate::log_page::speed_rows;
use crate::logs::{OpenedLog, Source};

/// What a log was identified as: a model, or several, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IdentificationDocument {
    /// `seatrial.identification.v1`
    pub schema: String,
    /// The log.
    pub source: UsedSource,
    /// All logs, where the model is of several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Part>,
    /// The other log, where there was one.
    pub validation_source: Option<Source>,
    /// The training window, half open.
    pub training: Option<Window>,
    /// How the estimate was made.
    pub settings: Option<Settings>,
    /// The estimate made sample by sample.
    pub online: Option<Online>,
    /// The estimate made from the whole training record.
    pub refined: Option<Refined>,
    /// Nomoto form of the model.
    pub nomoto: Option<Nomoto<f64>>,
    /// The moment that rights the vehicle, on the axis of pitch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restoring: Option<Restoring>,
    /// Simulation of validation data.
    pub validation: Option<Validation>,
    /// The model of the order that the record supports, where a first-order one misses something.
    pub higher_order: Option<HigherOrder>,
    /// What a lag of the rudder that the log does not tell would do to the refined model.
    pub lag_effect: Option<LagEffect>,
    /// What a heading loop of this vehicle waits for.
    pub loop_timing: Option<LoopTiming<f64>>,
    /// Over what rudder, headings, speeds and frequencies the model was seen.
    pub valid_range: Option<ValidRange>,
    /// The overshoot of a course change with the gains of the accepted models, over all speeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_answer: Option<CourseChange>,
    /// May the model be used?
    pub verdict: Verdict,
    /// The model of each speed, where the log has several manoeuvres; the model above is the surest of them.
    pub models: Option<Vec<SpeedModel>>,
    /// The law over speed by which these models borrow from each other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over_speed: Option<SpeedLaw>,
}

/// A log, and how many of its samples reached the estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UsedSource {
    /// The log.
    #[serde(flatten)]
    pub source: Source,
    /// Samples in the training window.
    pub samples_used: usize,
    /// Samples that the guard rejected.
    pub samples_rejected: u32,
    /// These by cause.
    pub rejected: RejectedSamples,
}

impl IdentifiedLog {
    /// What `seatrial identify --json` prints.
    pub fn document(&self) -> IdentificationDocument {
        IdentificationDocument::of(self)
    }
}

impl IdentificationDocument {
    /// The document of a log that was identified.
    pub fn of(found: &IdentifiedLog) -> Self {
        let model = found.identification();
        let counts = model.map_or_else(RejectedSamples::default, |model| model.samples_rejected);
        Self {
            schema: "seatrial.identification.v1".into(),
            source: UsedSource {
                source: found.logs.log.source(),
                samples_used: model.map_or(0, |model| model.samples_used),
                samples_rejected: counts.total(),
                rejected: counts,
            },
            parts: found.logs.parts.clone(),
            validation_source: found.logs.validation_log.as_ref().map(OpenedLog::source),
            training: model.map(|model| model.training),
            settings: model.map(|model| model.settings.clone()),
            online: model.map(|model| model.online.clone()),
            refined: model.and_then(|model| model.refined.clone()),
            nomoto: model.and_then(|model| model.nomoto),
            restoring: model.and_then(|model| model.restoring),
            validation: model.and_then(|model| model.validation),
            higher_order: model.and_then(|model| model.higher_order.clone()),
            lag_effect: model.and_then(|model| model.lag_effect),
            loop_timing: model.and_then(|model| model.loop_timing),
            valid_range: model.and_then(|model| model.valid_range),
            first_answer: CourseChange::of_all(
                speed_rows(found).into_iter().filter_map(|row| row.course_change),
            ),
            verdict: found.verdict().clone(),
            models: found.models.clone(),
            over_speed: found.law,
        }
    }

    /// With what to do in the words of the place where it is read.
    pub fn addressed_to(mut self, reader: Reader) -> Self {
        advice::verdict(&mut self.verdict, reader);
        self.source.source = self.source.source.addressed_to(reader);
        for model in self.models.iter_mut().flatten() {
            advice::verdict(&mut model.verdict, reader);
            if let Some(identification) = &mut model.identification {
                identification.verdict = model.verdict.clone();
            }
        }
        self
    }
}

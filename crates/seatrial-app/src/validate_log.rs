//! A given model against a log.

use std::path::Path;

use seatrial::Window;
use seatrial::identification::{ValidRange, Validation, Verdict};
use seatrial::identify::{valid_range, validation, validation_estimate};
use seatrial::verdict::judge_validation;
use seatrial_core::YawModel;
use serde::Serialize;

use crate::Error;
use crate::error::other_unit;
use crate::identify_log::no_model;
use crate::logs::{Observer, OpenedLog, ReadSettings, Source, open_inside};
use crate::models::Models;

/// What is validated.
#[derive(Clone, Debug)]
pub enum ModelInput {
    /// A model in numbers.
    Numbers(YawModel<f64>),
    /// Models of a source; the one of the log's speed is taken.
    Models(Box<Models>),
}

/// The document of `validate --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationDocument {
    /// `seatrial.validation.v1`
    pub schema: &'static str,
    /// The log.
    pub source: Source,
    /// The model that was simulated.
    pub model: YawModel<f64>,
    /// How well it tells the log.
    pub validation: Validation,
    /// May the model be used?
    pub verdict: Verdict,
    /// The name of the model that was used, where there were several.
    #[serde(skip)]
    pub taken: Option<String>,
}

/// Simulates a model over a window of a log and judges it.
pub fn validate_log(
    path: &Path,
    given: &ModelInput,
    window: Window,
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<ValidationDocument, Error> {
    let log = open_inside(path, reading, window, observer)?;
    let (model, seen, taken) = chosen(given, &log, window)?;
    let validation =
        validation::validate(model, &log.record, window).map_err(|error| no_model(&log, error))?;
    let samples = log.record.usable(window);
    let own = validation_estimate(&samples);
    let beyond = seen.and_then(|seen| {
        let noise_rad = own.as_ref().map_or(0.0, |own| own.heading_noise_rad);
        let here = valid_range(&[&samples], &model, noise_rad)?;
        Some(seen.left_by(&here, log.record.rudder_unit))
    });
    Ok(ValidationDocument {
        schema: "seatrial.validation.v1",
        source: log.source(),
        model,
        validation,
        verdict: judge_validation(&model, validation, own.as_ref(), beyond.unwrap_or_default()),
        taken,
    })
}

type ReferenceModel = (YawModel<f64>, Option<ValidRange>, Option<String>);

fn chosen(given: &ModelInput, log: &OpenedLog, window: Window) -> Result<ReferenceModel, Error> {
    match given {
        ModelInput::Numbers(model) if model.theta().iter().all(|p| p.is_finite()) => {
            Ok((*model, None, None))
        }
        ModelInput::Numbers(_) => {
            Err(Error::Setting("the model: a22, b2 and C0 must be finite numbers".into()))
        }
        ModelInput::Models(models) if models.rudder_unit != log.rudder_unit() => {
            Err(other_unit(&models.origin))
        }
        ModelInput::Models(models) => {
            let point = models.of_record(&log.record.usable(window))?;
            let taken = (models.points.len() > 1).then(|| point.name());
            Ok((point.point.model, point.valid_range, taken))
        }
    }
}

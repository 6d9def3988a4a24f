//! What verbs find in logs: each function returns its document as JSON, and what to warn of.

use std::path::PathBuf;

use pyo3::prelude::*;
use seatrial::identification::Reader;
use seatrial_app::advice::{self, addressed};
use seatrial_app::compare_log::compare_log;
use seatrial_app::logs::open;
use seatrial_app::trials::campaign_models::{ComparedModels, compared_models, open_named};
use seatrial_app::trials::health::{
    Comparison, Criteria, Missions, WatchDocument, change, reference,
};
use seatrial_app::validate_log::{ModelInput, validate_log};
use seatrial_app::{Error, Inspection};
use serde_json::Value;

use crate::models::Source;
use crate::reading::{Reading, Span, Warned, window, windows};
use crate::{Document, answer, failed, json};

/// What is in a log.
#[pyfunction]
pub fn inspect(py: Python<'_>, path: PathBuf, reading: Reading) -> PyResult<Document> {
    let settings = reading.settings(py)?;
    let mut warned = Warned::default();
    let found = py.detach(|| Ok(Inspection::of(&open(&path, &settings, None, &mut warned)?)));
    let found = found.map_err(|error| failed(py, &error))?;
    let document = json(py, &found.addressed_to(Reader::Python))?;
    Ok(answer(document, warned.0))
}

/// Every method on a log.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    path: PathBuf,
    reading: Reading,
    training: Span,
    validation: Span,
    validate_on: Option<PathBuf>,
    lambda_rad_s: Option<f64>,
) -> PyResult<Document> {
    let settings = reading.settings(py)?;
    let windows = windows(training, validation, validate_on);
    let mut warned = Warned::default();
    let found = py.detach(|| compare_log(&path, &windows, &settings, lambda_rad_s, &mut warned));
    let found = found.map_err(|error| failed(py, &error))?;
    Ok(answer(json(py, &found.document)?, warned.0))
}

/// A model against a log.
#[pyfunction]
pub fn validate(
    py: Python<'_>,
    path: PathBuf,
    source: Source,
    reading: Reading,
    span: Span,
) -> PyResult<Document> {
    let settings = reading.settings(py)?;
    let given = match source.theta() {
        Some(model) => ModelInput::Numbers(model),
        None => ModelInput::Models(Box::new(source.models(py)?)),
    };
    let mut warned = Warned::default();
    if let ModelInput::Models(models) = &given {
        warned.0.extend(models.cautions.iter().chain(&models.rejected).cloned());
    }
    let found = py.detach(|| validate_log(&path, &given, window(span), &settings, &mut warned));
    let mut found = found.map_err(|error| failed(py, &error))?;
    advice::verdict(&mut found.verdict, Reader::Python);
    Ok(answer(json(py, &found)?, warned.0))
}

/// Has the vehicle changed, between two sets of models or over mission logs?
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python part has names for them")]
pub fn health(
    py: Python<'_>,
    reference: String,
    now: Option<String>,
    missions: Vec<String>,
    logbook: PathBuf,
    reading: Reading,
    false_alarms: f64,
    tolerated: Option<f64>,
    offset_counts: Option<bool>,
) -> PyResult<Document> {
    let settings = reading.settings(py)?;
    let criteria = Criteria { false_alarms, tolerated, offset_counts };
    let mut warned = Warned::default();
    let found = match &now {
        Some(now) => py.detach(|| {
            let mut read = |name: &str| compared_models(name, &logbook, &settings, &mut warned);
            between(&read(&reference)?, &read(now)?, criteria)
        }),
        None => py.detach(|| {
            let source = compared_models(&reference, &logbook, &settings, &mut warned)?;
            let mut watched = Missions::new(&source, criteria.in_missions()?)?;
            for name in &missions {
                let (log, window) = open_named(name, &settings, &mut warned)?;
                watched.read(name, &log, window)?;
            }
            document(&WatchDocument::of(&source, watched.logs(), &watched.report()))
        }),
    };
    let found = found.map_err(|error| failed(py, &error))?;
    Ok(answer(json(py, &found)?, warned.0))
}

fn between(was: &ComparedModels, now: &ComparedModels, criteria: Criteria) -> Result<Value, Error> {
    let settings = criteria.between_trials()?;
    let mut change = change(was, &self::reference(was)?, now, &settings);
    change.action = addressed(&change.action, Reader::Python);
    document(&Comparison::of(was, now, &change))
}

fn document(found: &impl serde::Serialize) -> Result<Value, Error> {
    serde_json::to_value(found).map_err(|error| Error::Rejected(error.to_string()))
}

//! Identification of records, reading of logs, the paper's claims.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use seatrial::identification::Reader;
use seatrial::identify::evenly_sampled::{BatchError, EvenlySampled};
use seatrial::identify::{IdentifyError, IdentifySettings, ValidationData, lambda_of};
use seatrial::log::leave_out_unsound;
use seatrial_app::Options;
use seatrial_app::advice;
use seatrial_app::identify_log::identify_log_observed;
use seatrial_app::logs::open;
use seatrial_core::Axis;
use seatrial_core::RudderUnit;
use seatrial_core::estimator::Method;

use crate::arrays::{Column, Columns, dictionary};
use crate::reading::{Reading, SaidUnits, Span, Warned, window, windows};
use crate::{Document, answer, error, failed, json, usage};

/// The settings that the names stand for.
pub fn settings(
    py: Python<'_>,
    estimate: &str,
    method: Option<&str>,
    lambda_rad_s: Option<f64>,
    trace: bool,
) -> PyResult<IdentifySettings> {
    let mut settings = match estimate {
        "refined" | "online" => IdentifySettings::default(),
        "paper" => IdentifySettings::paper(),
        other => {
            return Err(usage(
                py,
                format!("estimate={other:?}: expected 'refined', 'online', 'batch' or 'paper'"),
            ));
        }
    };
    if estimate == "online" {
        settings.refine = false;
    }
    if let Some(name) = method {
        settings.method = method_named(py, name)?;
    }
    settings.lambda_rad_s = lambda_rad_s;
    settings.trace = trace;
    Ok(settings)
}

/// The method of this name.
pub fn method_named(py: Python<'_>, name: &str) -> PyResult<Method> {
    match name {
        "least_squares" => Ok(Method::LeastSquares),
        "instrumental_variable" => Ok(Method::InstrumentalVariable),
        other => Err(usage(
            py,
            format!("method={other:?}: expected 'least_squares' or 'instrumental_variable'"),
        )),
    }
}

/// Identifies a record; JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python part has names for them")]
pub fn identify(
    py: Python<'_>,
    time: Column<'_>,
    heading: Column<'_>,
    rudder: Column<'_>,
    speed: Option<Column<'_>>,
    yaw_rate: Option<Column<'_>>,
    thrust: Option<Column<'_>>,
    rudder_unit: &str,
    units: SaidUnits,
    training: Span,
    validation: Option<Span>,
    estimate: &str,
    method: Option<&str>,
    lambda_rad_s: Option<f64>,
    trace: bool,
) -> PyResult<String> {
    let settings = settings(py, estimate, method, lambda_rad_s, trace)?;
    let columns = Columns {
        time: &time,
        heading: &heading,
        rudder: &rudder,
        speed: speed.as_ref(),
        yaw_rate: yaw_rate.as_ref(),
        thrust: thrust.as_ref(),
    };
    let mut record = columns.record(py)?;
    record.rudder_unit = match rudder_unit {
        "full" => RudderUnit::FullRudder,
        _ => RudderUnit::Rad,
    };
    record.units = units.stated();
    leave_out_unsound(&mut record);
    let (training, validation) = (window(training), validation.map(window));
    for window in [Some(training), validation].into_iter().flatten() {
        if window.from_s.is_nan() || window.to_s.is_nan() || window.from_s >= window.to_s {
            return Err(usage(py, format!("the window {window} is empty")));
        }
    }
    let found = py.detach(|| {
        let held_out = validation.map(|window| ValidationData { record: &record, window });
        seatrial::identify::identify(&record, training, held_out, &settings)
    });
    match found {
        Ok(mut found) => {
            advice::verdict(&mut found.verdict, Reader::Python);
            json(py, &found)
        }
        Err(found) => Err(no_model(py, found)),
    }
}

fn no_model(py: Python<'_>, found: IdentifyError) -> PyErr {
    match found {
        IdentifyError::Setting(invalid) => usage(py, invalid),
        IdentifyError::Refused(reason) => {
            let reason = advice::reason(&reason, Reader::Python);
            let refused =
                error(py, "RejectedError", format!("{} {}", reason.text, reason.action).trim_end());
            match refused.value(py).setattr("reason", reason.kind().to_string()) {
                Ok(()) => refused,
                Err(failed) => failed,
            }
        }
        found => error(py, "InputError", found.to_string()),
    }
}

/// a22, b2 and C0 by filtering and batch least squares, in one pass over the arrays where they lie; JSON.
#[pyfunction]
pub fn least_squares(
    py: Python<'_>,
    time: Column<'_>,
    heading: Column<'_>,
    rudder: Column<'_>,
    training: Span,
    lambda_rad_s: Option<f64>,
) -> PyResult<String> {
    let contiguous = |_| usage(py, "time, heading and rudder: expected contiguous arrays");
    let whole = EvenlySampled {
        time_s: time.as_slice().map_err(contiguous)?,
        heading_rad: heading.as_slice().map_err(contiguous)?,
        rudder_rad: rudder.as_slice().map_err(contiguous)?,
    };
    let lambda_rad_s = match lambda_rad_s {
        Some(given) => given,
        None => {
            let record = Columns::of(&time, &heading, &rudder).record(py)?;
            let chosen = py.detach(|| lambda_of(&record, window(training)));
            chosen.map_err(|found| no_model(py, found))?.lambda_rad_s
        }
    };
    let found = py.detach(|| {
        whole.within(window(training)).and_then(|part| part.least_squares(lambda_rad_s))
    });
    match found {
        Ok(found) => json(py, &found),
        Err(BatchError::Record(message)) => Err(error(py, "InputError", message)),
        Err(BatchError::Setting(invalid)) => Err(usage(py, invalid)),
        Err(unexcited) => Err(error(py, "RejectedError", unexcited)),
    }
}

/// Identifies a log of any format that the command reads; the document of `seatrial identify --json`, and what to warn of.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python part has names for them")]
pub fn identify_log(
    py: Python<'_>,
    path: PathBuf,
    reading: Reading,
    axis: &str,
    training: Span,
    validation: Span,
    validate_on: Option<PathBuf>,
    more_logs: Vec<PathBuf>,
    estimate: &str,
    method: Option<&str>,
    lambda_rad_s: Option<f64>,
    trace: bool,
) -> PyResult<Document> {
    let axis = match axis {
        "yaw" => Axis::Yaw,
        "pitch" => Axis::Pitch,
        other => {
            return Err(usage(py, format!("axis={other:?}: expected 'yaw' or 'pitch'")));
        }
    };
    let mut options = Options::default();
    options.axis = axis;
    options.reading = reading.settings(py)?;
    options.windows = windows(training, validation, validate_on);
    options.more_logs = more_logs;
    options.settings = settings(py, estimate, method, lambda_rad_s, trace)?;
    let mut warned = Warned::default();
    match py.detach(|| identify_log_observed(&path, &options, &mut warned)) {
        Ok(found) => {
            let document = json(py, &found.document().addressed_to(Reader::Python))?;
            Ok(answer(document, warned.0))
        }
        Err(found) => Err(failed(py, &found)),
    }
}

/// The samples of a log of any format that the command reads, the log as documents show it in JSON, and what to warn of.
/// Where the log has what the servo was told and nobody said which angle that is, the rudder is `rudder_of_full` in
/// place of `rudder_rad`.
#[pyfunction]
pub fn read_log<'py>(
    py: Python<'py>,
    path: PathBuf,
    reading: Reading,
) -> PyResult<(Bound<'py, PyDict>, String, Vec<String>)> {
    let settings = reading.settings(py)?;
    let mut warned = Warned::default();
    let opened = py.detach(|| open(&path, &settings, None, &mut warned));
    let log = opened.map_err(|found| failed(py, &found))?;
    let arrays = dictionary(py, &log.record.samples)?;
    if log.rudder_unit() == RudderUnit::FullRudder
        && let Some(rudder) = arrays.get_item("rudder_rad")?
    {
        arrays.set_item("rudder_of_full", rudder)?;
        arrays.del_item("rudder_rad")?;
    }
    Ok((arrays, json(py, &log.source())?, warned.0))
}

/// The paper's printed numbers beside recomputed ones; JSON.
#[pyfunction]
pub fn paper_claims(py: Python<'_>) -> PyResult<String> {
    let claims = py.detach(seatrial_app::trials::paper::claims);
    json(py, &claims)
}

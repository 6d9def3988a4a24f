//! Plans of trials, and what to expect of them.

use std::path::PathBuf;

use pyo3::prelude::*;
use seatrial::preview::parse_target;
use seatrial_app::trials::expectation::PriorOverrides;
use seatrial_app::trials::plan::{Changes, ExpectedVehicle, PreviewRequest, plan_trial};

use crate::models::Source;
use crate::{Document, answer, error, failed, json, usage};

/// The plan by its differences, a mapping of the Python part.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PlanArguments {
    file: Option<PathBuf>,
    time_constant_s: Option<f64>,
    sample_interval_s: Option<f64>,
    thrusts: Vec<f64>,
    amplitude_rad: Option<f64>,
    validation_amplitude_rad: Option<f64>,
    period_s: Option<f64>,
    rudder_limit_rad: Option<f64>,
    rudder_delay_s: Option<f64>,
    rudder_lag_s: Option<f64>,
    stop_when: Option<String>,
    repeats: Option<u32>,
    target: Option<String>,
    compare: bool,
}

/// The vehicle that is expected, a mapping of the Python part.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Believed {
    vehicle: Option<String>,
    models: Option<Source>,
    noise_rad: Option<f64>,
    disturbance: Option<[f64; 2]>,
    hold_gain: Option<f64>,
    heading_rad: Option<f64>,
}

/// A plan and its preview: the document of `plan --json`, the plan as TOML, whether it will do, and what to warn of.
#[pyfunction]
pub fn plan(
    py: Python<'_>,
    asked: PlanArguments,
    believed: Believed,
) -> PyResult<(Document, String, bool)> {
    let target = |text: Option<&String>| {
        text.map(|text| parse_target(text).map_err(|why| usage(py, why))).transpose()
    };
    for (name, value) in [
        ("time_constant_s", asked.time_constant_s),
        ("sample_interval_s", asked.sample_interval_s),
        ("noise_rad", believed.noise_rad),
    ] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            return Err(usage(py, format!("{name}: expected a number above 0")));
        }
    }
    let wanted = PreviewRequest {
        target: target(asked.target.as_ref())?,
        comparison: asked.compare,
        adopt: None,
        surge: None,
    };
    let changes = Changes {
        stop_when: target(asked.stop_when.as_ref())?,
        file: asked.file,
        time_constant_s: asked.time_constant_s,
        sample_interval_s: asked.sample_interval_s,
        thrusts: asked.thrusts,
        amplitude_rad: asked.amplitude_rad,
        validation_amplitude_rad: asked.validation_amplitude_rad,
        period_s: asked.period_s,
        rudder_limit_rad: asked.rudder_limit_rad,
        servo_s: [asked.rudder_delay_s, asked.rudder_lag_s],
        max_repeats: asked.repeats,
    };
    let expected = ExpectedVehicle {
        vehicle: believed.vehicle,
        models: believed.models.map(|source| source.models(py)).transpose()?,
        stated: PriorOverrides {
            noise_rad: believed.noise_rad,
            disturbance: believed.disturbance,
            hold_gain: believed.hold_gain,
            heading_rad: believed.heading_rad,
        },
    };
    let found = py.detach(|| plan_trial(&changes, &expected, wanted));
    let found = found.map_err(|error| failed(py, &error))?;
    let toml = toml::to_string_pretty(&found.plan);
    let toml = toml.map_err(|why| error(py, "SeatrialError", why))?;
    let will_do = found.will_do();
    let document = json(py, &found)?;
    Ok((answer(document, found.warnings), toml, will_do))
}

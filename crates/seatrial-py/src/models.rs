//! What follows from models of any source: gains, turning limits, files for controllers and simulators.

use std::borrow::Cow;
use std::path::PathBuf;

use pyo3::prelude::*;
use seatrial::gains::export::VehicleType;
use seatrial_app::file_form::FileForm;
use seatrial_app::gains::LoopRequirements;
use seatrial_app::gains_export::{Format, GainsFile, check_usable};
use seatrial_app::models::{Models, of_document, of_document_text, of_schedule_file};
use seatrial_app::outputs::{OutputError, Outputs};
use seatrial_app::trials::campaign_models::of_campaign;
use seatrial_app::turning::{MeasuredUTurn, TurningLimits};
use seatrial_app::vehicle_export::{self, Form};
use seatrial_app::vehicle_file::VehicleOverrides;
use seatrial_core::YawModel;
use seatrial_core::schedule::{Beyond, ScheduleKey};

use crate::{Document, answer, failed, for_python, json, usage};

/// Where models come from, a mapping of the Python part: one of its entries is given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Source {
    theta: Option<[f64; 3]>,
    /// A document at hand: what messages call it, and its JSON.
    document: Option<(String, String)>,
    /// A document, or a schedule where its name ends with .toml.
    path: Option<PathBuf>,
    logbook: Option<PathBuf>,
    campaign: Option<String>,
    surge_speed_m_s: Option<f64>,
    rudder_limit_rad: Option<f64>,
}

impl Source {
    /// The model in numbers, where it is one.
    pub fn theta(&self) -> Option<YawModel<f64>> {
        self.theta.map(YawModel::from_theta)
    }

    /// The models, checked.
    pub fn models(&self, py: Python<'_>) -> PyResult<Models> {
        let speed = self.surge_speed_m_s;
        let found = match (self.theta(), &self.document, &self.path, &self.logbook) {
            (Some(model), ..) => Ok(Models::given(model, speed)),
            (_, Some((origin, text)), ..) => of_document_text(origin.clone(), text, speed),
            (_, _, Some(path), _) if path.extension().is_some_and(|suffix| suffix == "toml") => {
                of_schedule_file(path)
            }
            (_, _, Some(path), _) => of_document(path, speed),
            (_, _, _, Some(logbook)) => of_campaign(logbook, self.campaign.as_deref()),
            _ => return Err(usage(py, "no models are given")),
        };
        found
            .and_then(|models| models.limited(self.rudder_limit_rad))
            .map_err(|error| failed(py, &error))
    }
}

/// What is said against models, and where they are used beyond what they were seen for.
fn warnings(models: &Models) -> Vec<String> {
    let beyond = models.beyond_range();
    let against = models.cautions.iter().chain(&models.rejected);
    let all = against.chain(&beyond).chain(&models.passed_over);
    all.map(|reason| format!("{}: {reason}", models.origin)).collect()
}

/// What is asked of the heading loop, a mapping of the Python part.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ModelArguments {
    damping_ratio: f64,
    delay_s: Option<f64>,
    interval_s: Option<f64>,
    at_speed_m_s: Option<f64>,
    at_thrust: Option<f64>,
    extrapolate: bool,
    full_rudder_rad: Option<f64>,
}

impl ModelArguments {
    fn wanted(&self, py: Python<'_>) -> PyResult<LoopRequirements> {
        if self.at_speed_m_s.is_some() && self.at_thrust.is_some() {
            return Err(usage(py, "at_speed_m_s and at_thrust: give one of them"));
        }
        let thrust = self.at_thrust.map(|thrust| (ScheduleKey::Thrust, thrust));
        let speed = self.at_speed_m_s.map(|speed| (ScheduleKey::Speed, speed));
        Ok(LoopRequirements {
            damping_ratio: self.damping_ratio,
            delay_s: self.delay_s,
            interval_s: self.interval_s,
            at: thrust.or(speed),
            beyond: match self.extrapolate {
                true => Beyond::Extrapolate,
                false => Beyond::Refuse,
            },
        })
    }

    /// The models with what is asked of their loop.
    fn models(&self, py: Python<'_>, source: &Source) -> PyResult<(LoopRequirements, Models)> {
        let wanted = self.wanted(py)?;
        let models = source
            .models(py)?
            .with_full_rudder(self.full_rudder_rad)
            .map_err(|error| failed(py, &error))?;
        Ok((wanted, models))
    }
}

/// Heading gains of every model, with margins; the document of `gains --json`.
#[pyfunction]
pub fn heading_gains(py: Python<'_>, source: Source, asked: ModelArguments) -> PyResult<Document> {
    let (wanted, models) = asked.models(py, &source)?;
    let mut found = wanted.gains(&models).map_err(|error| failed(py, &error))?;
    found.rejected = for_python(&found.rejected);
    Ok(answer(json(py, &found)?, warnings(&models)))
}

/// Turning limits of every model; the document of `turn --json`.
#[pyfunction]
pub fn turning_limits(
    py: Python<'_>,
    source: Source,
    heading_change_rad: f64,
    up_to_speed_m_s: Option<f64>,
    measured_u_turn: Option<(f64, f64)>,
) -> PyResult<Document> {
    let models = source.models(py)?;
    let measured = measured_u_turn
        .map(|(surge_speed_m_s, radius_m)| MeasuredUTurn { surge_speed_m_s, radius_m });
    if measured.is_some_and(|u| !(u.surge_speed_m_s > 0.0 && u.radius_m > 0.0)) {
        return Err(usage(py, "measured_u_turn: expected a speed and a radius above 0"));
    }
    let found = TurningLimits::of(&models, heading_change_rad, up_to_speed_m_s, measured);
    let mut found = found.map_err(|error| failed(py, &error))?;
    found.rejected = for_python(&found.rejected);
    Ok(answer(json(py, &found)?, warnings(&models)))
}

/// The names of forms that files are written in.
pub fn names_of<F: FileForm>() -> Vec<&'static str> {
    F::ALL.iter().map(|row| row.name).collect()
}

/// A file for a controller: its text, and what to know about it.
#[pyfunction]
pub fn export_gains(
    py: Python<'_>,
    source: Source,
    asked: ModelArguments,
    to: &str,
    vehicle_type: &str,
    takes_rehearsals: bool,
    accept: bool,
) -> PyResult<Document> {
    let no_form = || usage(py, format!("to={to:?}: no such form"));
    let format = Format::named(to).ok_or_else(no_form)?;
    let vehicle = match vehicle_type {
        "surface" => VehicleType::Surface,
        "underwater" => VehicleType::Underwater,
        other => {
            return Err(usage(
                py,
                format!("vehicle_type={other:?}: expected 'surface' or 'underwater'"),
            ));
        }
    };
    let (wanted, models) = asked.models(py, &source)?;
    if !accept {
        check_usable(&wanted, &models).map_err(|error| failed(py, &error))?;
    }
    let file = GainsFile::new(format, &wanted, &models, vehicle, takes_rehearsals);
    let file = file.map_err(|error| failed(py, &error))?;
    let notes = warnings(&models).into_iter().chain(file.notes);
    Ok(answer(file.text, notes.collect()))
}

/// Writes a file whole, unless something that is to be kept is in its place: what was read for it, a logbook, a log.
#[pyfunction]
pub fn save(py: Python<'_>, path: PathBuf, content: &[u8], read: Vec<PathBuf>) -> PyResult<()> {
    let named = [vec![path.clone()], read].concat();
    let saved = Outputs::of(named).save(&path, content);
    saved.map_err(|refused| match refused {
        OutputError::Refused { .. } => usage(py, refused),
        OutputError::NotSaved { error, .. } => error.into(),
    })
}

/// What is said of a vehicle besides its models, a mapping of the Python part.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SaidOfVehicle {
    name: Option<String>,
    full_rudder_rad: Option<f64>,
    lag_s: Option<f64>,
    delay_s: Option<f64>,
    rate_limit_rad_s: Option<f64>,
    surge_time_constant_s: Option<f64>,
}

/// A file for a simulator or planner: its bytes, and what to know about it.
#[pyfunction]
pub fn export_vehicle(
    py: Python<'_>,
    source: Source,
    said: SaidOfVehicle,
    to: &str,
    at_thrust: Option<f64>,
    accept: bool,
) -> PyResult<(Cow<'static, [u8]>, Vec<String>)> {
    let no_form = || usage(py, format!("to={to:?}: no such form"));
    let form = Form::named(to).ok_or_else(no_form)?;
    let models = source.models(py)?;
    let stated = VehicleOverrides {
        name: said.name,
        full_rudder_rad: said.full_rudder_rad,
        lag_s: said.lag_s,
        delay_s: said.delay_s,
        rate_limit_rad_s: said.rate_limit_rad_s,
        surge_time_constant_s: said.surge_time_constant_s,
    };
    let vehicle = stated.vehicle(&models).map_err(|error| failed(py, &error))?;
    if !accept {
        vehicle_export::check_usable(&vehicle, form, at_thrust, models.rejected.first())
            .map_err(|error| failed(py, &error))?;
    }
    let assumptions = vehicle.provenance.assumptions.iter().cloned();
    let mut warnings: Vec<String> = warnings(&models).into_iter().chain(assumptions).collect();
    let (file, note) =
        vehicle_export::file(&vehicle, form, at_thrust).map_err(|error| failed(py, &error))?;
    warnings.extend(note);
    Ok((file.into(), for_python(&warnings)))
}

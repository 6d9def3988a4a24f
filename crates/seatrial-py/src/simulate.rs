//! Trials and studies on simulated vehicles.

use std::num::NonZeroUsize;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use seatrial::identification::Reader;
use seatrial::study::Estimator;
use seatrial_app::advice;
use seatrial_app::trials::estimator_study::{EstimatorStudy, Subject};
use seatrial_app::trials::order::{VehicleError, rehearse};
use seatrial_app::trials::simulator;
use seatrial_app::workers::Workers;
use seatrial_core::{List, Plan, Sample};

use crate::arrays::dictionary;
use crate::{error, json, usage};

fn refused(py: Python<'_>, found: VehicleError) -> PyErr {
    match found {
        VehicleError::Setting(message) => usage(py, message),
        other => error(py, "InputError", other),
    }
}

fn plan(py: Python<'_>, thrusts: Option<&[f64]>) -> PyResult<Plan<f64>> {
    let mut plan = Plan::paper();
    if let Some(thrusts) = thrusts {
        plan.thrusts = List::from_slice(thrusts)
            .ok_or_else(|| usage(py, "thrusts: too many for one trial"))?;
    }
    Ok(plan)
}

/// A whole trial: the campaign as JSON, and every sample.
#[pyfunction]
pub fn trial<'py>(
    py: Python<'py>,
    vehicle: &str,
    thrusts: Option<Vec<f64>>,
    seed: u64,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let plan = plan(py, thrusts.as_deref())?;
    let mut simulated = simulator::vehicle(vehicle, seed).map_err(|found| refused(py, found))?;
    let conducted = py.detach(|| rehearse(&mut simulated, vehicle, seed, plan));
    let mut campaign = conducted.map_err(|invalid| usage(py, invalid))?.campaign;
    for run in &mut campaign.runs {
        advice::verdict(&mut run.verdict, Reader::Python);
        if let Some(found) = &mut run.identification {
            advice::verdict(&mut found.verdict, Reader::Python);
        }
    }
    let samples: Vec<Sample<f64>> =
        campaign.runs.iter().flat_map(|run| run.record.samples.iter().copied()).collect();
    Ok((json(py, &campaign)?, dictionary(py, &samples)?))
}

/// Accuracy of estimators on many simulated runs of a first-order vehicle; JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the Python part has names for them")]
pub fn study(
    py: Python<'_>,
    runs: u64,
    thrust: f64,
    seed: u64,
    compass_noise_rad: f64,
    disturbance_rad_s2: f64,
    disturbance_time_s: f64,
    estimators: Vec<String>,
    workers: Option<usize>,
) -> PyResult<String> {
    let named = |name: &String| {
        let known = Estimator::ALL.into_iter().find(|e| e.name() == name);
        known.ok_or_else(|| {
            let names = Estimator::ALL.map(Estimator::name).join(", ");
            usage(py, format!("estimators: {name:?}: expected some of {names}"))
        })
    };
    let estimators = estimators.iter().map(named).collect::<PyResult<Vec<_>>>()?;
    let study = EstimatorStudy {
        subject: Subject::new("sim:starfish", runs, seed).map_err(|found| refused(py, found))?,
        thrust,
        noises_deg: vec![compass_noise_rad.to_degrees()],
        disturbances: vec![(disturbance_rad_s2, disturbance_time_s)],
        estimators,
        width: None,
    };
    let workers = workers.and_then(NonZeroUsize::new);
    let studied = py.detach(|| study.run(&Workers::new(workers, &|| ())));
    let cells = studied.map_err(|found| usage(py, found))?.cells;
    json(py, &cells.first().map(|cell| &cell.estimators))
}

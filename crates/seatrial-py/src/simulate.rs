//! Trials and studies on simulated vehicles.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use seatrial::campaign::Campaign;
use seatrial::identify::cramer_rao::Noise;
use seatrial::study::{Estimator, Experiment, Outcome, Truth, accuracy};
use seatrial_app::conduct::{Unwatched, conduct};
use seatrial_core::{List, Plan, Sample, Vehicle};
use seatrial_sim::six_dof::{remus100, starfish};
use seatrial_sim::{FirstOrderVehicle, SixDofConfig, SixDofVehicle, VehicleConfig, VehicleFile};

use crate::arrays::dictionary;
use crate::{error, json, usage};

enum Config {
    FirstOrder(Box<VehicleConfig>),
    SixDof(Box<SixDofConfig>),
}

fn config(py: Python<'_>, name: &str) -> PyResult<Config> {
    match name.strip_prefix("sim:") {
        Some("starfish") => Ok(Config::FirstOrder(Box::new(VehicleConfig::starfish()))),
        Some("starfish-6dof") => Ok(Config::SixDof(Box::new(starfish::config()))),
        Some("remus100") => Ok(Config::SixDof(Box::new(remus100::config()))),
        Some(file) if file.ends_with(".toml") => {
            match VehicleFile::load(Path::new(file)).map_err(|e| error(py, "InputError", e))? {
                VehicleFile::FirstOrder(config) => Ok(Config::FirstOrder(config)),
                VehicleFile::SixDof(config) => Ok(Config::SixDof(config)),
            }
        }
        _ => Err(usage(
            py,
            format!(
                "vehicle={name:?}: expected sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml"
            ),
        )),
    }
}

fn plan(py: Python<'_>, thrusts: Option<&[f64]>) -> PyResult<Plan<f64>> {
    let mut plan = Plan::paper();
    if let Some(thrusts) = thrusts {
        plan.thrusts = List::from_slice(thrusts)
            .ok_or_else(|| usage(py, "thrusts: too many for one trial"))?;
    }
    plan.check().map_err(|invalid| usage(py, invalid))?;
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
    let about = Campaign {
        software_version: env!("CARGO_PKG_VERSION").into(),
        vehicle: vehicle.into(),
        configuration: String::new(),
        seed: Some(seed),
        rudder_limit_rad: plan.rudder_limit_rad,
        full_rudder: None,
        scenario: None,
        runs: Vec::new(),
        outcome: None,
    };
    let input = |found: seatrial_sim::ConfigError| error(py, "InputError", found);
    let campaign = match config(py, vehicle)? {
        Config::FirstOrder(config) => {
            let mut vehicle = FirstOrderVehicle::new(*config, seed).map_err(input)?;
            py.detach(|| conducted(&mut vehicle, plan, about))
        }
        Config::SixDof(config) => {
            let mut vehicle = SixDofVehicle::new(*config, seed).map_err(input)?;
            py.detach(|| conducted(&mut vehicle, plan, about))
        }
    };
    let campaign = campaign.map_err(|message| usage(py, message))?;
    let samples: Vec<Sample<f64>> = campaign
        .runs
        .iter()
        .flat_map(|run| run.record.samples.iter().copied())
        .collect();
    Ok((json(py, &campaign)?, dictionary(py, &samples)?))
}

fn conducted<V: Vehicle<f64>>(
    vehicle: &mut V,
    plan: Plan<f64>,
    about: Campaign,
) -> Result<Campaign, String> {
    conduct(vehicle, plan, about, &mut Unwatched)
        .map(|conducted| conducted.campaign)
        .map_err(|invalid| invalid.to_string())
}

/// Accuracy of estimators on many simulated runs of a first-order vehicle; JSON.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "the Python part has names for them"
)]
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
            usage(
                py,
                format!("estimators: {name:?}: expected some of {names}"),
            )
        })
    };
    let estimators = estimators.iter().map(named).collect::<PyResult<Vec<_>>>()?;
    let plan = Plan {
        max_repeats: 0,
        ..plan(py, Some(&[thrust]))?
    };
    let mut config = VehicleConfig::starfish();
    config.sensors.compass.noise_rad = compass_noise_rad;
    config.disturbance.standard_deviation_rad_s2 = disturbance_rad_s2;
    config.disturbance.correlation_time_s = disturbance_time_s;
    let vehicle = FirstOrderVehicle::new(config.clone(), seed).map_err(|e| usage(py, e))?;
    let truth = Truth {
        model: vehicle.truth(thrust).model,
        noise: Noise {
            heading_rad: compass_noise_rad,
            disturbance_rad_s2,
            disturbance_time_s,
        },
        rudder_limit_rad: plan.rudder_limit_rad,
    };
    let next = AtomicU64::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        loop {
            let run = next.fetch_add(1, Ordering::Relaxed);
            if run >= runs {
                return outcomes;
            }
            let vehicle = FirstOrderVehicle::new(config.clone(), seed.wrapping_add(run));
            let experiment = vehicle.ok().and_then(|mut v| Experiment::of(&mut v, plan));
            if let Some(experiment) = experiment {
                let has_bound = compass_noise_rad > 0.0;
                let outcome = Outcome::of(&experiment, &truth, &estimators, has_bound, None);
                outcomes.push((run, outcome));
            }
        }
    };
    let workers = workers.unwrap_or_else(crate::fleet::cores);
    let accuracy = py.detach(|| {
        let mut outcomes: Vec<(u64, Outcome)> = thread::scope(|scope| {
            let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            let done = workers.into_iter().map(|worker| worker.join());
            done.flat_map(Result::unwrap_or_default).collect()
        });
        outcomes.sort_by_key(|(run, _)| *run);
        let outcomes: Vec<Outcome> = outcomes.into_iter().map(|(_, outcome)| outcome).collect();
        accuracy(&outcomes, &truth, &estimators)
    });
    json(py, &accuracy)
}

//! The estimator that runs along.

use pyo3::prelude::*;
use seatrial_core::estimator::{EstimatorSettings, Intake};

use crate::identify::method_named;
use crate::usage;

/// The estimator that runs on the vehicle, step by step.
#[pyclass(module = "seatrial._native")]
pub struct Estimator(seatrial_core::Estimator<f64>);

fn answer(intake: Intake) -> &'static str {
    match intake {
        Intake::Used => "used",
        Intake::Warming => "warming",
        Intake::Rejected(_) => "rejected",
    }
}

#[pymethods]
impl Estimator {
    #[new]
    fn new(
        py: Python<'_>,
        lambda_rad_s: Option<f64>,
        method: Option<&str>,
        as_paper: bool,
    ) -> PyResult<Self> {
        let base = match (as_paper, lambda_rad_s) {
            (true, None) => EstimatorSettings::paper(),
            (true, Some(lambda_rad_s)) => {
                EstimatorSettings { lambda_rad_s, ..EstimatorSettings::paper() }
            }
            (false, None) => EstimatorSettings::default(),
            (false, Some(lambda_rad_s)) => EstimatorSettings::for_lambda(lambda_rad_s),
        };
        let method = method.map_or(Ok(base.method), |name| method_named(py, name))?;
        seatrial_core::Estimator::new(EstimatorSettings { method, ..base })
            .map(Self)
            .map_err(|invalid| usage(py, invalid))
    }

    fn warm(&mut self, time_s: f64, heading_rad: f64, rudder_rad: f64) -> &'static str {
        answer(self.0.warm(time_s, heading_rad, rudder_rad))
    }

    fn update(&mut self, time_s: f64, heading_rad: f64, rudder_rad: f64) -> &'static str {
        answer(self.0.update(time_s, heading_rad, rudder_rad))
    }

    fn excitation_ended(&mut self) {
        self.0.excitation_ended();
    }

    fn restart(&mut self) {
        self.0.restart();
    }

    #[getter]
    fn model(&self) -> [f64; 3] {
        self.0.model().theta()
    }

    #[getter]
    fn least_squares_model(&self) -> [f64; 3] {
        self.0.least_squares_model().theta()
    }

    #[getter]
    fn covariance(&self) -> [[f64; 3]; 3] {
        self.0.covariance()
    }

    #[getter]
    fn step_norm(&self) -> f64 {
        self.0.step_norm()
    }

    #[getter]
    fn converged_s(&self) -> Option<f64> {
        self.0.converged_s()
    }
}

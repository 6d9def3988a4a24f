//! First link of the chain: a training record and its online estimate, with rudder edges that no sample shows put where the
//! heading says.

use nalgebra::Matrix3;
use seatrial_core::{Sample, YawModel};

use super::edge_times::{EdgeTimes, Edges};
use super::error::IdentifyError;
use super::log_statistics::LogStatistics;
use super::online::Pass;
use super::survey::RecordSurvey;
use super::training::manoeuvre_to_learn_from;
use crate::identification::Refined;
use crate::record::{Window, median_interval_s};

/// What a likeliest model leaves of the error of a mean rudder: the rest passes for its initial state and its offset.
const LEFT_OF_A_MEAN: f64 = 0.25;

/// A training record with the estimate made sample by sample.
pub struct TrainingRecord<'a> {
    /// The training window.
    pub training: Window,
    /// The samples that the estimator let through, headings unwrapped.
    pub accepted: &'a [Sample<f64>],
    /// The estimate made sample by sample.
    pub online: YawModel<f64>,
    /// How good the log is.
    pub log: LogStatistics,
    /// The usual interval between samples of the window, s.
    pub interval_s: Option<f64>,
    /// The record that the training window lies in.
    pub record: &'a RecordSurvey<'a>,
    edges: Edges<'a>,
    edge_times: Option<EdgeTimes<'a>>,
}

impl<'a> TrainingRecord<'a> {
    /// `refine`: is there to be an estimate from the whole record?
    pub fn new(
        record: &'a RecordSurvey,
        training: Window,
        pass: &'a Pass,
        refine: bool,
    ) -> Result<Self, IdentifyError> {
        let samples = record.record().window(training);
        let manoeuvre = manoeuvre_to_learn_from(record.record(), samples)?;
        let edges = Edges::of(&pass.accepted, Some(pass.online.model));
        Ok(Self {
            training,
            accepted: &pass.accepted,
            online: pass.online.model,
            log: LogStatistics::of(record, training, &manoeuvre, pass, edges.lost()),
            interval_s: median_interval_s(samples),
            record,
            edge_times: refine.then(|| edges.edge_times(Some(pass.online.model))),
            edges,
        })
    }

    /// Is there to be an estimate from the whole record, with intervals?
    pub fn is_to_be_refined(&self) -> bool {
        self.edge_times.is_some()
    }

    /// The accepted samples, with the rudder's hidden edges in their places.
    pub fn samples(&self) -> &[Sample<f64>] {
        self.edge_times.as_ref().map_or(self.accepted, |edge_times| &*edge_times.samples)
    }

    /// What the places of hidden edges leave uncertain of a22, b2 and C0.
    pub fn edge_covariance(&self) -> Matrix3<f64> {
        self.edge_times.as_ref().map_or_else(Matrix3::zeros, |edge_times| edge_times.covariance)
    }

    /// Is there so little noise that the mean of the rudder over an interval with a hidden edge is not enough?
    pub fn is_blurred(&self, refined: &Refined) -> bool {
        let wrong_rad = refined.model.b2_per_s2.abs() * self.edges.coarseness_rad_s2();
        refined.heading_noise_rad < LEFT_OF_A_MEAN * wrong_rad
    }
}

//! The estimate that validation data give by themselves.

use seatrial_core::{Sample, YawModel};

use super::edge_times::Edges;
use super::intervals;
use super::whole_record::robust_estimate_behind;
use crate::identification::Refined;
use crate::manoeuvre::Manoeuvre;

/// The robust estimate from validation data alone.
pub fn validation_estimate(samples: &[Sample<f64>]) -> Option<Refined> {
    validation_estimate_behind(samples, None, None)
}

/// [`validation_estimate`] of a vehicle and a rudder that are known from the training: the model, and the rudder's lag and shift
/// together, s.
pub(super) fn validation_estimate_behind(
    samples: &[Sample<f64>],
    known: Option<YawModel<f64>>,
    known_delay_s: Option<f64>,
) -> Option<Refined> {
    Manoeuvre::find(samples)?;
    let edges = Edges::of(samples, known);
    let edge_times = edges.edge_times(None);
    let found = robust_estimate_behind(&edge_times.samples, known_delay_s).ok()?;
    Some(intervals::widened(&found.refined, &edge_times.covariance))
}

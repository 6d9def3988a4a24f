//! The estimate that validation data give by themselves.

use seatrial_core::Sample;

use super::edge_times::Edges;
use super::intervals;
use super::lag::LagTest;
use super::misfit::Misfit;
use super::output_error::output_error;
use super::refined::refined_estimate;
use crate::identification::{EstimateMethod, Refined};
use crate::manoeuvre::Manoeuvre;

/// The estimate from validation data alone: the refined one where a first-order model explains them, or else output error's.
pub fn validation_estimate(samples: &[Sample<f64>]) -> Option<Refined> {
    let manoeuvre = Manoeuvre::find(samples)?;
    let edges = Edges::of(samples);
    let edge_times = edges.edge_times(None);
    let samples = &*edge_times.samples;
    let refined = refined_estimate(samples, None).ok()?;
    let lag = LagTest::of(samples, &refined);
    let is_structural = Misfit::of(samples, &refined, manoeuvre.amplitude_rad, lag)
        .is_some_and(|misfit| misfit.is_structural());
    let estimate = if is_structural {
        let nearest = output_error(samples, Some(refined.model)).ok()?;
        let covariance = nearest.covariance.into();
        intervals::around(
            &refined,
            nearest.model,
            covariance,
            EstimateMethod::OutputError,
        )
    } else {
        refined
    };
    Some(intervals::widened(&estimate, &edge_times.covariance))
}

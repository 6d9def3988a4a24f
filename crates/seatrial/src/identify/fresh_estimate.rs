//! The estimate that validation data give by themselves.

use seatrial_core::Sample;

use super::edges::Edges;
use super::lag::LagTest;
use super::misfit::Misfit;
use super::{output_error, refine};
use crate::identification::{EstimateMethod, Refined};
use crate::manoeuvre::Manoeuvre;

/// The estimate from fresh data alone: the refined one where a first-order model explains them, or else output error's.
pub fn fresh_estimate(samples: &[Sample<f64>]) -> Option<Refined> {
    let manoeuvre = Manoeuvre::find(samples)?;
    let edges = Edges::of(samples);
    let placed = edges.placed(None);
    let samples = &*placed.samples;
    let refined = refine::refine(samples, None).ok()?;
    let lag = LagTest::of(samples, &refined);
    let is_structural = Misfit::of(samples, &refined, manoeuvre.amplitude_rad, lag)
        .is_some_and(|misfit| misfit.is_structural());
    let estimate = if is_structural {
        let nearest = output_error::output_error(samples, Some(refined.model)).ok()?;
        let covariance = nearest.covariance.into();
        refine::around(
            &refined,
            nearest.model,
            covariance,
            EstimateMethod::OutputError,
        )
    } else {
        refined
    };
    Some(refine::widened(&estimate, &placed.covariance))
}

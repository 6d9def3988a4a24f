//! A record of samples for [`seatrial_core::refine`], which takes series.

use seatrial_core::{Sample, YawModel};

use super::whitening::Prepared;
use crate::record::duration_s;
use seatrial_core::refine;
pub use seatrial_core::refine::{DISTURBANCE_TIME_CONSTANTS, Peak, RefineFailure};

/// Of a longer record only the stretch of this many samples in which the rudder moves most is refined: about
/// a second of work.
const MOST_SAMPLES: usize = 10_000;

/// The stretch of [`MOST_SAMPLES`] in which the rudder varies most, on a grid of half its length.
pub(super) fn liveliest(samples: &[Sample<f64>]) -> &[Sample<f64>] {
    let variance = |stretch: &[Sample<f64>]| {
        let n = stretch.len() as f64;
        let mean = stretch.iter().map(|s| s.rudder_rad).sum::<f64>() / n;
        stretch
            .iter()
            .map(|s| (s.rudder_rad - mean).powi(2))
            .sum::<f64>()
            / n
    };
    samples
        .windows(MOST_SAMPLES)
        .step_by(MOST_SAMPLES / 2)
        .max_by(|a, b| variance(a).total_cmp(&variance(b)))
        .unwrap_or(samples)
}

/// Length and sampling of a record, s.
pub(super) struct Span(refine::Span);

impl Span {
    pub(super) fn of(samples: &[Sample<f64>]) -> Result<Self, RefineFailure> {
        refine::Span::of(samples.len(), duration_s(samples)).map(Self)
    }

    /// In blocks of a twentieth of the vehicle's time constant.
    pub(super) fn prepare(
        &self,
        samples: &[Sample<f64>],
        a22_per_s: f64,
    ) -> Result<Prepared, RefineFailure> {
        let mut record = Prepared::new(samples, 1);
        record.block = self.0.prepare(record.series(), a22_per_s)?.block;
        Ok(record)
    }

    /// |a22|, but no slower than what the record can show, 1/s.
    pub(super) fn rate_scale(&self, a22_per_s: f64) -> f64 {
        self.0.rate_scale(a22_per_s)
    }

    /// The damping that output error prefers among a logarithmic grid and the start.
    pub(super) fn first_damping(
        &self,
        samples: &[Sample<f64>],
        start: Option<YawModel<f64>>,
    ) -> Result<f64, RefineFailure> {
        self.0
            .first_damping(Prepared::new(samples, 1).series(), start)
    }
}

//! A record as [`Series`], which borrows what is kept here.

use seatrial_core::refine::{self, Disturbance, Fit, Peak, RefineFailure, Series, Span};
use seatrial_core::{Sample, YawModel};

use crate::record::{duration_s, median, unwrapped_rad};

/// Intervals, headings relative to the first and rudder of a record, in blocks.
#[derive(Clone, Debug)]
pub struct RecordSeries {
    pub(crate) interval_s: Vec<f64>,
    pub(crate) heading_rad: Vec<f64>,
    pub(crate) rudder_rad: Vec<f64>,
    pub(crate) block: usize,
}

impl RecordSeries {
    /// `samples` are finite and increase in time; `block` samples are averaged for one comparison.
    pub fn new(samples: &[Sample<f64>], block: usize) -> Self {
        let heading_rad = unwrapped_rad(0.0, samples.iter().map(|s| s.heading_rad));
        Self::from_headings(samples, heading_rad, block)
    }

    /// Takes other headings, unwrapped, than those of the samples.
    pub fn from_headings(samples: &[Sample<f64>], heading_rad: Vec<f64>, block: usize) -> Self {
        let intervals = samples.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let mut interval_s: Vec<f64> = intervals.collect();
        let usual_s = usual(&interval_s);
        interval_s.push(0.0);
        Self {
            interval_s,
            heading_rad,
            rudder_rad: mean_rudder_rad(samples, usual_s),
            block: block.max(1),
        }
    }

    /// The record as the likelihood takes it.
    pub fn series(&self) -> Series<'_> {
        Series {
            interval_s: &self.interval_s,
            heading_rad: &self.heading_rad,
            rudder_rad: &self.rudder_rad,
            block: self.block,
        }
    }

    /// Number of comparisons.
    pub fn blocks(&self) -> usize {
        self.series().blocks()
    }

    /// [`Series::fit`]
    pub fn fit(&self, a22_per_s: f64, disturbance: Disturbance) -> Option<Fit> {
        self.series().fit(a22_per_s, disturbance)
    }

    /// The means over each block of the responses to b2, C0, psi0 and r0, and of the heading.
    pub(crate) fn comparisons(&self, a22_per_s: f64) -> Vec<[f64; 5]> {
        let mut rows = Vec::with_capacity(self.blocks());
        self.series().for_each_comparison(a22_per_s, |means| rows.push(means));
        rows
    }
}

/// Length and sampling of a record, s.
#[derive(Clone, Copy)]
pub(crate) struct RecordSpan(Span);

impl RecordSpan {
    pub(crate) fn of(samples: &[Sample<f64>]) -> Result<Self, RefineFailure> {
        Span::of(samples.len(), duration_s(samples)).map(Self)
    }

    /// In blocks of a twentieth of the vehicle's time constant.
    pub(crate) fn prepare(
        &self,
        samples: &[Sample<f64>],
        a22_per_s: f64,
    ) -> Result<RecordSeries, RefineFailure> {
        let mut record = RecordSeries::new(samples, 1);
        record.block = self.0.prepare(record.series(), a22_per_s)?.block;
        Ok(record)
    }

    /// |a22|, but no slower than what the record can show, 1/s.
    pub(crate) fn rate_scale(&self, a22_per_s: f64) -> f64 {
        self.0.rate_scale(a22_per_s)
    }

    /// The likelihood without disturbance, largest in a22: output error.
    pub(crate) fn nearest_simulation(
        &self,
        record: &RecordSeries,
        start_per_s: f64,
    ) -> Option<Peak> {
        let scale_per_s = self.rate_scale(start_per_s);
        Peak::find(&record.series(), Disturbance::NONE, start_per_s, scale_per_s)
    }

    /// The damping that output error prefers among a logarithmic grid and the start.
    pub(crate) fn first_damping(
        &self,
        samples: &[Sample<f64>],
        start: Option<YawModel<f64>>,
    ) -> Result<f64, RefineFailure> {
        self.0.first_damping(RecordSeries::new(samples, 1).series(), start)
    }
}

/// Are these the same interval? A clock's rounding of a billionth makes no other.
pub(crate) fn is_same(interval_s: f64, other_s: f64) -> bool {
    (interval_s - other_s).abs() <= 1e-9 * interval_s
}

/// The median, which needs no search where all are the same. 0 without intervals.
fn usual(interval_s: &[f64]) -> f64 {
    match interval_s {
        [first, rest @ ..] if rest.iter().all(|interval_s| is_same(*interval_s, *first)) => *first,
        _ => median(interval_s.to_vec()).unwrap_or(0.0),
    }
}

/// The rudder over each interval, rad: [`refine::mean_rudder_rad`].
pub(crate) fn mean_rudder_rad(samples: &[Sample<f64>], usual_s: f64) -> Vec<f64> {
    let over = |pair: &[Sample<f64>]| refine::mean_rudder_rad(&pair[0], &pair[1], usual_s);
    let last = samples.last().map(|s| s.rudder_rad);
    samples.windows(2).map(over).chain(last).collect()
}

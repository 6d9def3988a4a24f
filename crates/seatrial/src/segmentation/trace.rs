//! Rudder and heading of a record, ready to be searched.

use std::ops::Range;

use seatrial_core::{Real, Sample};

use super::{Kind, Segment};
use crate::line::Line;
use crate::record::{Window, mean, median_interval_s};

/// This share of the rudder's range next to its ends is no neutral angle.
const EDGE: f64 = 0.1;

/// Time, rudder about neutral and unwrapped heading of the samples that are finite and increase in time.
pub(super) struct Trace<'a> {
    samples: &'a [Sample<f64>],
    time_s: Vec<f64>,
    neutral_rad: f64,
    rudder_rad: Vec<f64>,
    heading_rad: Vec<f64>,
    usual_interval_s: f64,
}

/// The rudder beyond a threshold on one side.
pub(super) struct Excursion {
    pub window: Window,
    pub is_positive: bool,
}

impl<'a> Trace<'a> {
    /// `None` where fewer than two samples are usable or the rudder does not move.
    pub fn of(samples: &'a [Sample<f64>]) -> Option<Self> {
        let mut trace = Self {
            samples,
            time_s: Vec::with_capacity(samples.len()),
            neutral_rad: 0.0,
            rudder_rad: Vec::with_capacity(samples.len()),
            heading_rad: Vec::with_capacity(samples.len()),
            usual_interval_s: median_interval_s(samples)?,
        };
        let mut last_heading_rad = None;
        let mut unwrapped_rad = 0.0;
        for sample in samples {
            let is_finite = sample.time_s.is_finite()
                && sample.rudder_rad.is_finite()
                && sample.heading_rad.is_finite();
            if !is_finite || trace.time_s.last().is_some_and(|last| sample.time_s <= *last) {
                continue;
            }
            let before = last_heading_rad.replace(sample.heading_rad);
            unwrapped_rad += (sample.heading_rad - before.unwrap_or(sample.heading_rad)).wrapped();
            trace.time_s.push(sample.time_s);
            trace.rudder_rad.push(sample.rudder_rad);
            trace.heading_rad.push(unwrapped_rad);
        }
        let neutral_rad = neutral(&trace.rudder_rad)?;
        for rudder_rad in &mut trace.rudder_rad {
            *rudder_rad -= neutral_rad;
        }
        trace.neutral_rad = neutral_rad;
        Some(trace)
    }

    /// What makes an angle from neutral one from zero, on one side.
    pub fn trim_rad(&self, is_positive: bool) -> f64 {
        match is_positive {
            true => self.neutral_rad,
            false => -self.neutral_rad,
        }
    }

    pub fn largest_rudder_rad(&self) -> f64 {
        largest(&self.rudder_rad)
    }

    pub fn indices(&self, window: Window) -> Range<usize> {
        let from = self.time_s.partition_point(|t| *t < window.from_s);
        let to = self.time_s.partition_point(|t| *t < window.to_s);
        from..to.max(from)
    }

    /// About neutral.
    pub fn rudder_rad(&self, indices: Range<usize>) -> &[f64] {
        &self.rudder_rad[indices]
    }

    pub fn duration_s(&self, indices: &Range<usize>) -> f64 {
        match self.time_s[indices.clone()] {
            [first, .., last] => last - first,
            _ => 0.0,
        }
    }

    pub fn rudder_rms_rad(&self, indices: Range<usize>) -> f64 {
        let count = indices.len() as f64;
        let sum: f64 = self.rudder_rad[indices].iter().map(|d| d * d).sum();
        (sum / count).sqrt()
    }

    pub fn rudder_peak_rad(&self, window: Window) -> f64 {
        largest(&self.rudder_rad[self.indices(window)])
    }

    pub fn turned_rad(&self, window: Window) -> f64 {
        match self.heading_rad[self.indices(window)] {
            [first, .., last] => last - first,
            _ => 0.0,
        }
    }

    /// Segments beyond a threshold on one side, in order. Each lasts until the first sample that is not.
    pub fn excursions(&self, threshold_rad: f64) -> Vec<Excursion> {
        let mut excursions: Vec<Excursion> = Vec::new();
        let mut deflected: Option<bool> = None;
        for (time_s, rudder_rad) in self.time_s.iter().zip(&self.rudder_rad) {
            let side = (rudder_rad.abs() >= threshold_rad).then_some(*rudder_rad > 0.0);
            if let (Some(_), Some(excursion)) = (deflected, excursions.last_mut()) {
                excursion.window.to_s = *time_s;
            }
            if let Some(is_positive) = side.filter(|_| side != deflected) {
                let window = Window { from_s: *time_s, to_s: *time_s };
                excursions.push(Excursion { window, is_positive });
            }
            deflected = side;
        }
        excursions
    }

    /// Segments of a window in which the rudder stays within a bound.
    pub fn quiet_segments(&self, window: Window, bound_rad: f64) -> Vec<Window> {
        let indices = self.indices(window);
        let time_s = &self.time_s[indices.clone()];
        self.rudder_rad[indices]
            .chunk_by(|a, b| (a.abs() < bound_rad) == (b.abs() < bound_rad))
            .scan(0, |from, chunk| {
                let range = *from..*from + chunk.len();
                *from = range.end;
                Some((chunk, range))
            })
            .filter(|(chunk, _)| chunk[0].abs() < bound_rad)
            .map(|(_, range)| Window { from_s: time_s[range.start], to_s: time_s[range.end - 1] })
            .collect()
    }

    /// How far the heading goes from the straight line of its lead-in, over how far the lead-in strays from it.
    pub fn departure(&self, lead_in: Range<usize>, during: Range<usize>) -> f64 {
        let Some(line) = self.line(&lead_in) else { return 0.0 };
        let off = |k: usize| (self.heading_rad[k] - line.at(self.time_s[k])).abs();
        let farthest = |indices: Range<usize>| indices.map(off).fold(0.0, f64::max);
        farthest(during) / farthest(lead_in).max(f64::MIN_POSITIVE)
    }

    pub fn segment(
        &self,
        kind: Kind,
        window: Window,
        strokes: usize,
        first_stroke_s: f64,
        amplitude_rad: f64,
    ) -> Segment {
        let with_response = match kind {
            Kind::Steady => window,
            _ => Window { from_s: window.from_s, to_s: window.to_s + first_stroke_s },
        };
        let indices = self.indices(with_response);
        let expected = (self.duration_s(&indices) / self.usual_interval_s).round() + 1.0;
        let from = self.samples.partition_point(|s| s.time_s < window.from_s);
        let to = self.samples.partition_point(|s| s.time_s < window.to_s);
        let samples = &self.samples[from..to.max(from)];
        Segment {
            kind,
            window,
            strokes,
            first_stroke_s,
            amplitude_rad,
            thrust: mean(samples.iter().filter_map(|s| s.thrust)),
            surge_speed_m_s: mean(samples.iter().filter_map(|s| s.surge_speed_m_s)),
            excitation_rad: self.heading_deviation_rad(&indices),
            completeness: (indices.len() as f64 / expected).min(1.0),
        }
    }

    fn line(&self, indices: &Range<usize>) -> Option<Line> {
        Line::through(&self.time_s[indices.clone()], &self.heading_rad[indices.clone()])
    }

    /// Standard deviation of the heading about its own straight line.
    fn heading_deviation_rad(&self, indices: &Range<usize>) -> f64 {
        let Some(line) = self.line(indices) else {
            return 0.0;
        };
        let off = |k: usize| self.heading_rad[k] - line.at(self.time_s[k]);
        let sum: f64 = indices.clone().map(|k| off(k) * off(k)).sum();
        (sum / indices.len() as f64).sqrt()
    }
}

/// The middle of the shortest interval that holds half of the values. Where that lies at their edge, as one side of a
/// zig-zag may, of the shortest that holds 55 % of them. `None` of fewer than two or of one value only.
fn neutral(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (low, high) = (*sorted.first()?, *sorted.last()?);
    if low >= high {
        return None;
    }
    let middle = |share: f64| {
        let count = ((share * sorted.len() as f64).ceil() as usize).clamp(1, sorted.len());
        sorted
            .windows(count)
            .min_by(|a, b| (a[count - 1] - a[0]).total_cmp(&(b[count - 1] - b[0])))
            .map(|shortest| 0.5 * (shortest[0] + shortest[count - 1]))
    };
    let edge = EDGE * (high - low);
    middle(0.5).filter(|middle| (low + edge..high - edge).contains(middle)).or_else(|| middle(0.55))
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| v.abs().max(largest))
}

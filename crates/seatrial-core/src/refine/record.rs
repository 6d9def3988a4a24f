//! A training stage kept as it comes.

use super::Series;
use crate::{LostRudder, Real, Sample};

/// The record is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

/// Up to `N` samples of a stage.
#[derive(Clone, Copy, Debug)]
pub struct StageRecord<const N: usize> {
    usual_interval_s: f64,
    interval_s: [f64; N],
    heading_rad: [f64; N],
    rudder_rad: [f64; N],
    len: usize,
    last: Option<Sample<f64>>,
}

impl<const N: usize> StageRecord<N> {
    /// An empty record of a vehicle that samples at this interval, s.
    pub fn new(usual_interval_s: f64) -> Self {
        Self {
            usual_interval_s,
            interval_s: [0.0; N],
            heading_rad: [0.0; N],
            rudder_rad: [0.0; N],
            len: 0,
            last: None,
        }
    }

    /// Appends a sample, which is finite and later than the last.
    ///
    /// ```
    /// use seatrial_core::Sample;
    /// use seatrial_core::refine::{Full, StageRecord};
    ///
    /// let mut record = StageRecord::<2>::new(0.05);
    /// // Headings on both sides of north, 0.2 rad apart.
    /// record
    ///     .push(&Sample { heading_rad: 6.18, ..Sample::default() })
    ///     .and_then(|()| record.push(&Sample { time_s: 0.05, heading_rad: 0.1, ..Sample::default() }))?;
    /// let turned = record.series().heading_rad;
    /// assert!((turned[1] - turned[0] - 0.203).abs() < 1e-3);
    /// assert!(matches!(record.push(&Sample { time_s: 0.1, ..Sample::default() }), Err(Full)));
    /// # Ok::<(), Full>(())
    /// ```
    pub fn push(&mut self, sample: &Sample<f64>) -> Result<(), Full> {
        let (Some(heading_rad), Some(rudder_rad)) =
            (self.heading_rad.get_mut(self.len), self.rudder_rad.get_mut(self.len))
        else {
            return Err(Full);
        };
        *heading_rad = sample.heading_rad;
        *rudder_rad = sample.rudder_rad;
        if let Some(last) = self.last {
            let before = self.len - 1;
            let unwrapped_rad = self.heading_rad.get(before).copied().unwrap_or_default();
            if let Some(heading_rad) = self.heading_rad.get_mut(self.len) {
                *heading_rad = unwrapped_rad + (sample.heading_rad - last.heading_rad).wrapped();
            }
            if let Some(interval_s) = self.interval_s.get_mut(before) {
                *interval_s = sample.time_s - last.time_s;
            }
            if let Some(rudder_rad) = self.rudder_rad.get_mut(before) {
                *rudder_rad = mean_rudder_rad(&last, sample, self.usual_interval_s);
            }
        }
        self.last = Some(*sample);
        self.len += 1;
        Ok(())
    }

    /// What was kept.
    pub fn series(&self) -> Series<'_> {
        Series {
            interval_s: self.interval_s.get(..self.len).unwrap_or_default(),
            heading_rad: self.heading_rad.get(..self.len).unwrap_or_default(),
            rudder_rad: self.rudder_rad.get(..self.len).unwrap_or_default(),
            block: 1,
        }
    }
}

/// The rudder from one sample to the next, rad: held, or, where samples were lost and it moved a little, the mean of what
/// goes to the next sample in equal steps. When it moved far, at an edge of the manoeuvre, nobody knows when, and
/// it counts as held.
///
/// ```
/// use seatrial_core::Sample;
/// use seatrial_core::refine::mean_rudder_rad;
///
/// let before = Sample { rudder_rad: 0.10, ..Sample::default() };
/// // Held over the usual interval of 0.05 s; in two steps where a row is missing.
/// let next = Sample { time_s: 0.05, rudder_rad: 0.12, ..before };
/// assert_eq!(mean_rudder_rad(&before, &next, 0.05), 0.10);
/// let after_a_gap = Sample { time_s: 0.10, ..next };
/// assert!((mean_rudder_rad(&before, &after_a_gap, 0.05) - 0.105).abs() < 1e-12);
/// ```
pub fn mean_rudder_rad(sample: &Sample<f64>, next: &Sample<f64>, usual_interval_s: f64) -> f64 {
    let interval_s = next.time_s - sample.time_s;
    let moved_rad = next.rudder_rad - sample.rudder_rad;
    let lost = LostRudder::Interpolated;
    if lost.hides_edge(interval_s, usual_interval_s, moved_rad) {
        return sample.rudder_rad;
    }
    match lost.steps(interval_s, usual_interval_s) {
        1 => sample.rudder_rad,
        steps => {
            let steps = f64::from(steps);
            sample.rudder_rad + moved_rad * (steps - 1.0) / (2.0 * steps)
        }
    }
}

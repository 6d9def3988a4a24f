//! A record: the samples of a run or a log, and windows on them.

pub use seatrial_core::RudderUnit;
use seatrial_core::{Real, Sample};
use serde::{Deserialize, Serialize};

use crate::figures::three_figures;
use crate::stated_units::StatedUnits;

/// A half-open span of time, `from_s <= t < to_s`, in the record's own seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// First instant inside, s.
    pub from_s: f64,
    /// First instant after, s.
    pub to_s: f64,
}

impl Window {
    /// Every instant.
    pub const ALL: Self = Self { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };

    /// Is this instant inside?
    ///
    /// A nanosecond of tolerance absorbs the rounding of sampled times such as 0.1 + 0.2.
    ///
    /// ```
    /// use seatrial::Window;
    ///
    /// let window = Window { from_s: 0.3, to_s: 0.6 };
    /// // Half open, and 0.1 + 0.2 is not 0.3 in binary numbers.
    /// assert!(window.contains(0.1 + 0.2) && !window.contains(0.6));
    /// ```
    pub fn contains(&self, time_s: f64) -> bool {
        time_s >= self.from_s - 1e-9 && time_s < self.to_s - 1e-9
    }

    /// The samples inside. Time must not go back in them.
    ///
    /// ```
    /// use seatrial::{Sample, Window};
    ///
    /// let samples = [0.0, 1.0, 2.0, 3.0].map(|time_s| Sample { time_s, ..Sample::default() });
    /// assert_eq!(Window { from_s: 1.0, to_s: 3.0 }.of(&samples), &samples[1..3]);
    /// ```
    pub fn of(self, samples: &[Sample<f64>]) -> &[Sample<f64>] {
        let from = samples.partition_point(|s| s.time_s < self.from_s - 1e-9);
        let to = samples.partition_point(|s| s.time_s < self.to_s - 1e-9);
        &samples[from..to.max(from)]
    }

    /// The window as far as there are samples: no end is infinite.
    pub(crate) fn known_part(self, samples: &[Sample<f64>]) -> Self {
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return self;
        };
        Self {
            from_s: if self.from_s.is_finite() { self.from_s } else { first.time_s },
            to_s: if self.to_s.is_finite() {
                self.to_s
            } else {
                last.time_s + median_interval_s(samples).unwrap_or(0.0)
            },
        }
    }
}

impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.from_s {
            f64::NEG_INFINITY => f.write_str("the start")?,
            from_s => write!(f, "{from_s} s")?,
        }
        match self.to_s {
            f64::INFINITY => f.write_str(" to the end"),
            to_s => write!(f, " to {to_s} s"),
        }
    }
}

/// A rudder for display, in degrees or in percent of full.
///
/// ```
/// use seatrial::log::{RudderUnit, rudder_text};
///
/// assert_eq!(rudder_text(RudderUnit::Rad, 0.26), "14.9 deg");
/// assert_eq!(rudder_text(RudderUnit::FullRudder, -0.5), "-50.0 % of full");
/// ```
pub fn rudder_text(unit: RudderUnit, rudder: f64) -> String {
    let (scale, name) = unit.for_people();
    format!("{} {name}", three_figures(scale * rudder))
}

/// Samples in the order in which they were logged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The samples.
    pub samples: Vec<Sample<f64>>,
    /// What their rudder is measured in.
    #[serde(default)]
    pub rudder_unit: RudderUnit,
    /// In what the columns were that it was read from.
    #[serde(default, skip_serializing_if = "StatedUnits::are_given")]
    pub units: StatedUnits,
}

impl Record {
    /// The samples inside a window. Time must not go back in the record.
    ///
    /// ```
    /// use seatrial::{Record, Sample, Window};
    ///
    /// let record: Record =
    ///     [0.0, 1.0, 2.0].into_iter().map(|time_s| Sample { time_s, ..Sample::default() }).collect();
    /// assert_eq!(record.window(Window::ALL).len(), 3);
    /// assert_eq!(record.window(Window { from_s: 5.0, to_s: 9.0 }), &[]);
    /// ```
    pub fn window(&self, window: Window) -> &[Sample<f64>] {
        window.of(&self.samples)
    }

    /// The samples of a window whose time, heading and rudder are finite and whose time increases.
    ///
    /// ```
    /// use seatrial::{Record, Sample, Window};
    ///
    /// let at = |time_s, heading_rad| Sample { time_s, heading_rad, ..Sample::default() };
    /// let record: Record =
    ///     [at(0.0, 0.1), at(1.0, f64::NAN), at(1.0, 0.2), at(1.0, 0.3)].into_iter().collect();
    /// // Neither what is no number nor a time that comes again.
    /// assert_eq!(record.usable(Window::ALL), [at(0.0, 0.1), at(1.0, 0.2)]);
    /// ```
    pub fn usable(&self, window: Window) -> Vec<Sample<f64>> {
        let inside = self.window(window);
        let mut usable: Vec<Sample<f64>> = Vec::with_capacity(inside.len());
        for sample in inside {
            let is_finite = sample.time_s.is_finite()
                && sample.heading_rad.is_finite()
                && sample.rudder_rad.is_finite();
            if is_finite && usable.last().is_none_or(|last| sample.time_s > last.time_s) {
                usable.push(*sample);
            }
        }
        usable
    }

    /// Several records of one vehicle as one, and where each lies in it. Each begins so long after the one before that nothing carries over: 20
    /// times the longest. `None` where their rudders are not measured in the same.
    ///
    /// ```
    /// use seatrial::{Record, Sample};
    ///
    /// let log =
    ///     || (0..=10).map(|k| Sample { time_s: f64::from(k), ..Sample::default() }).collect::<Record>();
    /// let (joined, parts) = Record::joined(&[log(), log()]).ok_or("one unit of rudder")?;
    /// assert_eq!(joined.samples.len(), 22);
    /// // 20 times the length of 10 s, so that nothing carries over.
    /// assert_eq!(parts[1].from_s - parts[0].to_s, 200.0);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn joined(records: &[Self]) -> Option<(Self, Vec<Window>)> {
        const APART: f64 = 20.0;
        let lengths_s = records.iter().map(|record| duration_s(&record.samples));
        let apart_s = APART * lengths_s.fold(0.0, f64::max);
        let mut joined = records.first()?.clone();
        let mut parts = vec![Window::ALL.known_part(&joined.samples)];
        for record in &records[1..] {
            let begins_s = parts.last().map_or(0.0, |part| part.to_s) + apart_s;
            let first_s = record.samples.first().map_or(0.0, |first| first.time_s);
            let shifted = record
                .samples
                .iter()
                .map(|sample| Sample { time_s: sample.time_s - first_s + begins_s, ..*sample });
            let shifted: Vec<Sample<f64>> = shifted.collect();
            parts.push(Window::ALL.known_part(&shifted));
            joined.samples.extend(shifted);
            joined.units = joined.units.and(&record.units);
            if record.rudder_unit != joined.rudder_unit {
                return None;
            }
        }
        Some((joined, parts))
    }

    /// The median of the intervals between samples, s. `None` under two samples.
    pub fn median_interval_s(&self) -> Option<f64> {
        median_interval_s(&self.samples)
    }
}

/// The interval of times that lie on an even grid but for this share of it, s.
pub(crate) fn even_interval_s(times_s: &[f64], off_the_grid: f64) -> Option<f64> {
    let (first, last) = (times_s.first()?, times_s.last()?);
    let interval_s = (last - first) / (times_s.len().checked_sub(1)? as f64);
    let is_on_grid = |(k, time): (usize, &f64)| {
        (time - first - k as f64 * interval_s).abs() <= off_the_grid * interval_s
    };
    (interval_s > 0.0 && times_s.iter().enumerate().all(is_on_grid)).then_some(interval_s)
}

/// The median of the intervals between samples, s. `None` under two samples.
///
/// ```
/// use seatrial::Sample;
/// use seatrial::log::{duration_s, median_interval_s};
///
/// // One row of a log at 10 Hz is missing.
/// let samples = [0.0, 0.1, 0.2, 0.4, 0.5].map(|time_s| Sample { time_s, ..Sample::default() });
/// assert!(median_interval_s(&samples).is_some_and(|interval_s| (interval_s - 0.1).abs() < 1e-9));
/// assert_eq!(duration_s(&samples), 0.5);
/// assert_eq!(median_interval_s(&samples[..1]), None);
/// ```
pub fn median_interval_s(samples: &[Sample<f64>]) -> Option<f64> {
    let intervals =
        samples.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).filter(|h| h.is_finite());
    median(intervals.collect())
}

/// An interval so many times the usual one is a gap: nothing tells what happened in it.
pub(crate) const GAP: f64 = 10.0;

/// From which interval on samples are apart by a gap, s.
pub(crate) fn shortest_gap_s(samples: &[Sample<f64>]) -> f64 {
    median_interval_s(samples).map_or(f64::INFINITY, |usual_s| GAP * usual_s)
}

/// The parts of samples in time order that gaps separate.
pub(crate) fn between_gaps(samples: &[Sample<f64>]) -> impl Iterator<Item = &[Sample<f64>]> {
    let gap_s = shortest_gap_s(samples);
    samples.chunk_by(move |one, next| next.time_s - one.time_s < gap_s)
}

/// How long a log is, s, without what lies between logs that were joined: gaps longer than all that was recorded.
pub(crate) fn logged_s(samples: &[Sample<f64>]) -> f64 {
    let recorded_s: f64 = between_gaps(samples).map(duration_s).sum();
    let intervals = samples.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
    intervals.filter(|interval_s| *interval_s < recorded_s).sum()
}

/// The upper one of two in the middle. `None` without numbers.
pub(crate) fn median(mut numbers: Vec<f64>) -> Option<f64> {
    if numbers.is_empty() {
        return None;
    }
    let middle = numbers.len() / 2;
    let (_, median, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// By how much the heading turns over each interval, rad, by at most half a turn.
pub(crate) fn turns_rad(samples: &[Sample<f64>]) -> impl Iterator<Item = f64> {
    samples.windows(2).map(|pair| turned_rad(&pair[0], &pair[1]))
}

/// By how much the heading turns from one sample to another, rad.
pub(crate) fn turned_rad(from: &Sample<f64>, to: &Sample<f64>) -> f64 {
    (to.heading_rad - from.heading_rad).wrapped()
}

/// Headings without jumps at a full turn, rad, the first as it is given here.
pub(crate) fn unwrapped_rad(
    first_rad: f64,
    headings_rad: impl IntoIterator<Item = f64>,
) -> Vec<f64> {
    let mut before_rad = None;
    let mut unwrapped_rad = first_rad;
    let headings = headings_rad.into_iter().map(|heading_rad| {
        let before_rad = before_rad.replace(heading_rad).unwrap_or(heading_rad);
        unwrapped_rad += (heading_rad - before_rad).wrapped();
        unwrapped_rad
    });
    headings.collect()
}

/// From the first sample to the last, s.
pub fn duration_s(samples: &[Sample<f64>]) -> f64 {
    match samples {
        [first, .., last] => last.time_s - first.time_s,
        _ => 0.0,
    }
}

/// The mean, exact where all values are the same.
pub(crate) fn mean(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    let (mut sum, mut count) = (0.0, 1.0);
    for value in values {
        sum += value - first;
        count += 1.0;
    }
    Some(first + sum / count)
}

impl FromIterator<Sample<f64>> for Record {
    fn from_iter<I: IntoIterator<Item = Sample<f64>>>(samples: I) -> Self {
        Self {
            samples: samples.into_iter().collect(),
            rudder_unit: RudderUnit::Rad,
            units: StatedUnits::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_a_grid_with_a_lost_sample_is_not_even() {
        let mut time_s: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
        assert!(even_interval_s(&time_s, 4e-4).is_some());
        time_s.remove(20);
        assert!(even_interval_s(&time_s, 4e-4).is_none());
        assert!(even_interval_s(&[1.0], 4e-4).is_none());
    }
}

//! What is in a log, and whether a model can be identified from it.

use seatrial::Window;
use seatrial::identification::{Reader, Reason, ReasonCode, Verdict};
use seatrial::identify::{Proposal, propose};
use seatrial::log::segmentation::{Segment, find};
use seatrial::log::{Manoeuvre, Stroke};
use seatrial_core::{Real, Sample};
use seatrial_logs::Quantity;
use serde::{Deserialize, Serialize};

use crate::advice;
use crate::documents::Source;
use crate::identify_log::verdict_of;
use crate::logs::OpenedLog;

/// An interval longer than this many median intervals is a gap.
const GAP_INTERVALS: f64 = 3.0;

/// What is in a log; the document of `inspect --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inspection {
    /// `seatrial.inspection.v1`
    pub schema: String,
    /// The log.
    pub source: Source,
    /// When its samples were taken.
    pub sampling: Sampling,
    /// The values of each quantity.
    pub ranges: Vec<Range>,
    /// Does the heading turn up where the rudder is positive? `None` where the log does not show it.
    pub positive_rudder_turns_up: Option<bool>,
    /// The manoeuvres found.
    pub manoeuvres: Vec<Segment>,
    /// Which of them `identify` takes, where no windows are given.
    pub windows: Vec<Proposal>,
    /// May a model of it be used? What `identify` without windows says.
    pub verdict: Verdict,
}

/// When the samples were taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// How many.
    pub samples: usize,
    /// From the first to the last.
    pub span: Option<Window>,
    /// The median of the intervals, s.
    pub median_interval_s: Option<f64>,
    /// Samples a second.
    pub rate_hz: Option<f64>,
    /// Robust standard deviation of the intervals, s.
    pub jitter_s: Option<f64>,
    /// Intervals longer than three medians.
    pub gaps: usize,
    /// The longest of them.
    pub largest_gap: Option<Window>,
}

/// The values of one quantity in SI units; the heading is unwrapped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// The quantity.
    pub quantity: Quantity,
    /// How many.
    pub samples: usize,
    /// The lowest value.
    pub lowest: f64,
    /// The highest value.
    pub highest: f64,
    /// The mean.
    pub mean: f64,
    /// The standard deviation.
    pub standard_deviation: f64,
}

impl Inspection {
    /// What is in a log.
    pub fn of(opened: &OpenedLog) -> Self {
        let samples = opened.record.samples.as_slice();
        let channels = &opened.description.channels;
        let ranges: Vec<Range> = channels
            .iter()
            .filter(|channel| channel.quantity != Quantity::Time)
            .filter_map(|channel| Range::of(channel.quantity, &series(samples, channel.quantity)))
            .collect();
        let rudder = Manoeuvre::find(samples);
        let manoeuvres = find(samples);
        let windows = propose(&opened.record, &manoeuvres);
        Self {
            schema: "seatrial.inspection.v1".into(),
            source: opened.source(),
            sampling: Sampling::of(opened),
            positive_rudder_turns_up: rudder
                .as_ref()
                .and_then(|rudder| positive_rudder_turns_up(samples, &rudder.strokes)),
            manoeuvres,
            verdict: verdict_of(opened, windows.clone()).unwrap_or_else(|error| {
                Verdict::refused(Reason::new(
                    ReasonCode::Other("unreadable".into()),
                    error.to_string(),
                ))
            }),
            windows,
            ranges,
        }
    }

    /// With what to do in the words of the place where it is read.
    pub fn addressed_to(mut self, reader: Reader) -> Self {
        self.source = self.source.addressed_to(reader);
        advice::verdict(&mut self.verdict, reader);
        self
    }
}

impl Sampling {
    fn of(opened: &OpenedLog) -> Self {
        let samples = &opened.record.samples;
        let median_interval_s = opened.record.median_interval_s();
        let intervals = || {
            samples.windows(2).map(|pair| Window { from_s: pair[0].time_s, to_s: pair[1].time_s })
        };
        let length = |window: &Window| window.to_s - window.from_s;
        let is_gap = |window: &Window| {
            median_interval_s.is_some_and(|median| length(window) > GAP_INTERVALS * median)
        };
        let mut deviations: Vec<f64> = intervals()
            .map(|window| (length(&window) - median_interval_s.unwrap_or(0.0)).abs())
            .collect();
        deviations.sort_by(f64::total_cmp);
        Self {
            samples: samples.len(),
            span: match samples.as_slice() {
                [first, .., last] => Some(Window { from_s: first.time_s, to_s: last.time_s }),
                _ => None,
            },
            median_interval_s,
            rate_hz: median_interval_s.map(|interval| 1.0 / interval),
            // 1.4826 median absolute deviations are one standard deviation of a normal distribution.
            jitter_s: deviations.get(deviations.len() / 2).map(|median| 1.4826 * median),
            gaps: intervals().filter(is_gap).count(),
            largest_gap: intervals().filter(is_gap).max_by(|a, b| length(a).total_cmp(&length(b))),
        }
    }
}

impl Range {
    fn of(quantity: Quantity, values: &[Option<f64>]) -> Option<Self> {
        let present = || values.iter().flatten();
        let samples = present().count();
        if samples == 0 {
            return None;
        }
        let count = samples as f64;
        let mean = present().sum::<f64>() / count;
        let variance = present().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
        Some(Self {
            quantity,
            samples,
            lowest: present().fold(f64::INFINITY, |a, b| a.min(*b)),
            highest: present().fold(f64::NEG_INFINITY, |a, b| a.max(*b)),
            mean,
            standard_deviation: variance.sqrt(),
        })
    }
}

/// One quantity of every sample, in SI units; the heading is unwrapped.
pub fn series(samples: &[Sample<f64>], quantity: Quantity) -> Vec<Option<f64>> {
    let of = |sample: &Sample<f64>| match quantity {
        Quantity::Time => Some(sample.time_s),
        Quantity::Heading => Some(sample.heading_rad),
        Quantity::Rudder => Some(sample.rudder_rad),
        Quantity::Speed => sample.surge_speed_m_s,
        Quantity::Depth => sample.depth_m,
        Quantity::Altitude => sample.altitude_m,
        Quantity::Roll => sample.roll_rad,
        Quantity::Pitch => sample.pitch_rad,
        Quantity::YawRate => sample.yaw_rate_rad_s,
        Quantity::North => sample.north_m,
        Quantity::East => sample.east_m,
        Quantity::Thrust => sample.thrust,
    };
    let mut values: Vec<Option<f64>> = samples.iter().map(of).collect();
    if quantity == Quantity::Heading {
        let mut before: Option<f64> = None;
        for value in values.iter_mut().flatten() {
            if let Some(before) = before {
                *value = before + (*value - before).wrapped();
            }
            before = Some(*value);
        }
    }
    values
}

/// The heading bends towards the hand to which the rudder is laid: second difference over each stroke.
fn positive_rudder_turns_up(samples: &[Sample<f64>], strokes: &[Stroke]) -> Option<bool> {
    let heading = series(samples, Quantity::Heading);
    let at = |time_s: f64| {
        let index = samples.partition_point(|sample| sample.time_s < time_s);
        heading.get(index.min(samples.len().saturating_sub(1))).copied().flatten()
    };
    let mut votes = [0_usize; 2];
    for stroke in strokes {
        let Window { from_s, to_s } = stroke.window;
        let bend = at(from_s)? - 2.0 * at(0.5 * (from_s + to_s))? + at(to_s)?;
        if bend != 0.0 {
            votes[usize::from((bend > 0.0) == stroke.positive)] += 1;
        }
    }
    // Under three quarters of the strokes the log does not show it.
    let [down, up] = votes;
    match (4 * up >= 3 * (up + down), 4 * down >= 3 * (up + down)) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A doublet with the heading that 1 / s^2 makes of it.
    fn doublet() -> Vec<Sample<f64>> {
        let (mut heading_rad, mut rate) = (6.2, 0.0);
        (0..330)
            .map(|k| {
                let time_s = f64::from(k) * 0.05;
                let rudder_rad = match k {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => 0.0,
                };
                rate += 0.05 * rudder_rad;
                heading_rad += 0.05 * rate;
                Sample {
                    time_s,
                    heading_rad: Real::wrapped(heading_rad),
                    rudder_rad,
                    ..Sample::default()
                }
            })
            .collect()
    }

    #[test]
    fn exact_the_side_to_which_positive_rudder_turns() {
        let samples = doublet();
        let rudder = Manoeuvre::find(&samples).unwrap();
        assert_eq!(positive_rudder_turns_up(&samples, &rudder.strokes), Some(true));
        let mirrored: Vec<_> =
            samples.iter().map(|s| Sample { heading_rad: -s.heading_rad, ..*s }).collect();
        assert_eq!(positive_rudder_turns_up(&mirrored, &rudder.strokes), Some(false));
    }
}

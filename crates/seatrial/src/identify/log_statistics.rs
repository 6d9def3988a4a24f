//! How good the log of a training is: rejected samples, rudder, heading, speed, clock, compass.

use seatrial_core::Sample;

use super::compass::{CompassError, Jump};
use super::mishap::heading_jump;
use super::online::Pass;
use super::pace::Pace;
use super::survey::RecordSurvey;
use super::validation::heading_range_rad;
use crate::identification::RejectedSamples;
use crate::manoeuvre::Manoeuvre;
use crate::plausibility::{self, Doubt};
use crate::record::{Record, RudderUnit, Window, median, turns_rad};

/// Relative error of a time that is a whole number of steps, and the least step over the interval of rows that makes them uneven.
const ROUNDING: f64 = 0.05;
const LEAST_STEP: f64 = 0.1;
/// The rudder is held within this share of the manoeuvre's amplitude, in this share of its rows.
const HELD: f64 = 0.3;
const MOST_HELD: f64 = 0.8;

/// Lengths of the training that are looked at before and behind it.
const BESIDE: f64 = 2.0;

/// How good the log of a training is.
#[derive(Clone, Debug)]
pub struct LogStatistics {
    /// Samples that reached the estimator.
    pub samples_used: usize,
    /// Samples that did not, by cause.
    pub rejected: RejectedSamples,
    /// Half of the rudder's range, in its unit.
    pub rudder_amplitude_rad: f64,
    /// How far the rudder went to either side from rest, where it was deflected to both.
    pub rudder_sides_rad: Option<[f64; 2]>,
    /// Unit of the rudder.
    pub rudder_unit: RudderUnit,
    /// The heading's range, rad.
    pub heading_range_rad: f64,
    /// The step in which the heading is given, rad, where it is coarser than its noise.
    pub heading_step_rad: Option<f64>,
    /// Mean speed of the first and of the last quarter, m/s.
    pub surge_speed_m_s: Option<[f64; 2]>,
    /// The usual interval between samples and the one that one in twenty exceeds, s.
    pub interval_s: Option<[f64; 2]>,
    /// The time is written in such steps, s, while rows come at another even interval, s.
    pub rounded_time_s: Option<[f64; 2]>,
    /// Was the rudder put over once and held while the vehicle turned a circle?
    pub is_turning_circle: bool,
    /// How often each channel brings something new.
    pub pace: Option<Pace>,
    /// How the compass parts from the gyro.
    pub compass: CompassError,
    /// The largest jump of the heading up to two lengths of the training before or behind it: what may have spoilt another manoeuvre.
    pub jump_beside: Option<Jump>,
    /// Times that the rudder moved far while samples were lost.
    pub hidden_edges: usize,
    /// Whether its columns are in the units that they say.
    pub unit_doubts: Vec<Doubt>,
    /// Do rows that differ share a time?
    pub times_are_shared: bool,
    /// What it cannot show.
    pub unchecked: Vec<Doubt>,
}

impl LogStatistics {
    /// Statistics of a training window and of what the estimator let through of it.
    pub fn of(
        survey: &RecordSurvey,
        training: Window,
        manoeuvre: &Manoeuvre,
        pass: &Pass,
        hidden_edges: usize,
    ) -> Self {
        let record = survey.record();
        let samples = record.window(training);
        Self {
            samples_used: pass.samples_used,
            rejected: pass.rejected,
            rudder_amplitude_rad: manoeuvre.amplitude_rad,
            rudder_sides_rad: manoeuvre.sides_rad(samples),
            rudder_unit: record.rudder_unit,
            heading_range_rad: heading_range_rad(samples),
            heading_step_rad: smallest_heading_step_rad(samples),
            surge_speed_m_s: surge_speeds_m_s(samples),
            interval_s: usual_and_long_interval_s(samples),
            rounded_time_s: rounded_time_s(samples).filter(|_| !record.units.rows_are_missing),
            is_turning_circle: is_turning_circle(samples, manoeuvre),
            pace: Pace::of(samples),
            compass: CompassError::of(&pass.accepted),
            jump_beside: jump_beside(record, training.known_part(samples)),
            hidden_edges,
            unit_doubts: survey
                .unit_doubts()
                .iter()
                .cloned()
                .chain(plausibility::heading_stood(&record.usable(training)))
                .collect(),
            times_are_shared: record.units.times_are_shared,
            unchecked: survey.unchecked().to_vec(),
        }
    }

    /// Is there no yaw rate to compare the heading with?
    pub fn is_heading_unchecked(&self) -> bool {
        let is_of_heading = |doubt: &Doubt| matches!(doubt, Doubt::HeadingUnchecked { .. });
        self.unchecked.iter().any(is_of_heading)
    }
}

fn jump_beside(record: &Record, training: Window) -> Option<Jump> {
    let beside_s = BESIDE * (training.to_s - training.from_s);
    let around = record
        .window(Window { from_s: training.from_s - beside_s, to_s: training.to_s + beside_s });
    heading_jump(around).filter(|jump| !(training.from_s..training.to_s).contains(&jump.time_s))
}

/// The smallest change of heading from one sample to the next: the step in which a compass reads, or
/// very little.
fn smallest_heading_step_rad(samples: &[Sample<f64>]) -> Option<f64> {
    samples
        .windows(2)
        .map(|pair| (pair[1].heading_rad - pair[0].heading_rad).abs())
        .filter(|step| *step > 0.0)
        .reduce(f64::min)
}

/// Mean speed of the first and of the last quarter of the samples that have one, m/s.
fn surge_speeds_m_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let speeds: Vec<f64> =
        samples.iter().filter_map(|s| s.surge_speed_m_s.filter(|speed| *speed > 0.0)).collect();
    let quarter = speeds.len() / 4;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / quarter as f64;
    (quarter > 0).then(|| [mean(&speeds[..quarter]), mean(&speeds[speeds.len() - quarter..])])
}

/// The step of a rounded time and the even interval of its rows, s: intervals are one or several steps, and no row is off its place by more
/// than a step. Where rows are lost, those behind are off by more.
fn rounded_time_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let (first, last) = (samples.first()?, samples.last()?);
    let intervals = || samples.windows(2).map(|p| p[1].time_s - p[0].time_s);
    let step_s = {
        let mut sizes: Vec<f64> = intervals().collect();
        sizes.sort_by(f64::total_cmp);
        // Of steps of several, the difference.
        let apart = sizes.windows(2).map(|pair| pair[1] - pair[0]);
        let is_one = |apart: &f64| *apart > ROUNDING * sizes[0];
        apart.filter(is_one).fold(*sizes.first()?, f64::min)
    };
    let even_s = (last.time_s - first.time_s) / (samples.len() - 1) as f64;
    let is_whole = |interval_s: f64| {
        let steps = interval_s / step_s;
        (steps - steps.round()).abs() < ROUNDING * steps.max(1.0)
    };
    let is_in_place = |(row, sample): (usize, &Sample<f64>)| {
        let place_s = first.time_s + even_s * row as f64;
        (sample.time_s - place_s).abs() < (1.0 + ROUNDING) * step_s
    };
    let is_rounded = step_s > LEAST_STEP * even_s
        && !is_whole(even_s)
        && intervals().all(is_whole)
        && samples.iter().enumerate().all(is_in_place);
    is_rounded.then_some([step_s, even_s])
}

/// Was the rudder put over once and held until the vehicle had turned a circle?
fn is_turning_circle(samples: &[Sample<f64>], manoeuvre: &Manoeuvre) -> bool {
    let longest = manoeuvre.strokes.iter().max_by(|a, b| a.duration_s().total_cmp(&b.duration_s()));
    let Some(held) = longest.map(|stroke| stroke.window.of(samples)) else {
        return false;
    };
    let turned_rad: f64 = turns_rad(held).filter(|step| step.is_finite()).sum();
    let angle = median(held.iter().map(|s| s.rudder_rad).collect());
    let is_held = |sample: &&Sample<f64>| {
        angle.is_some_and(|a| (sample.rudder_rad - a).abs() < HELD * manoeuvre.amplitude_rad)
    };
    let is_most = held.iter().filter(is_held).count() as f64 > MOST_HELD * held.len() as f64;
    manoeuvre.strokes.len() <= 2 && is_most && turned_rad.abs() > core::f64::consts::TAU
}

/// The median interval and the one that one in twenty exceeds, s.
fn usual_and_long_interval_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let intervals = samples.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
    let mut intervals: Vec<f64> = intervals.filter(|interval| *interval > 0.0).collect();
    intervals.sort_by(f64::total_cmp);
    let at = |share: f64| intervals.get((share * intervals.len() as f64) as usize).copied();
    Some([at(0.5)?, at(0.95)?])
}

#[cfg(test)]
mod tests {
    use seatrial_core::Real;

    use super::*;

    fn rows(times_s: impl Iterator<Item = f64>) -> Vec<Sample<f64>> {
        times_s.map(|time_s| Sample { time_s, ..Sample::default() }).collect()
    }

    /// Days with five decimals at 1 Hz, with six at 5 Hz; even times, lost rows and jitter are none.
    #[test]
    fn exact_rounded_times_differ_from_lost_rows() {
        let days = |decimals: f64, interval_s: f64| {
            let day =
                move |row: u32| (45_250.5 + f64::from(row) * interval_s / 86_400.0) * decimals;
            rows((0..300).map(move |row| day(row).round() / decimals * 86_400.0))
        };
        for (decimals, interval_s) in [(1e5, 1.0), (1e6, 0.2)] {
            let [step_s, even_s] = rounded_time_s(&days(decimals, interval_s)).unwrap();
            // Ends are off by a step over all rows.
            assert!((step_s - 86_400.0 / decimals).abs() < 1e-3 * interval_s);
            assert!((even_s - interval_s).abs() < 0.01 * interval_s);
        }
        assert_eq!(rounded_time_s(&days(1e8, 1.0)), None);
        assert_eq!(rounded_time_s(&rows((0..300).map(|row| f64::from(row) * 0.05))), None);
        let lost = (0..300).filter(|row| row % 7 != 3 && !(100..110).contains(row));
        assert_eq!(rounded_time_s(&rows(lost.map(|row| f64::from(row) * 0.05))), None);
        let jitter = |row: i32| f64::from(row) * 0.05 + 0.01 * (f64::from(row) * 7.7).sin();
        assert_eq!(rounded_time_s(&rows((0..300).map(jitter))), None);
    }

    #[test]
    fn exact_a_turning_circle_is_one_rudder_held_while_the_heading_goes_round() {
        let record = |rudder: fn(f64) -> f64| {
            let mut samples = rows((0..600).map(|row| f64::from(row) * 0.5));
            let mut turned = 0.0;
            for sample in &mut samples {
                sample.rudder_rad = rudder(sample.time_s);
                turned += 0.5 * 0.1 * sample.rudder_rad;
                sample.heading_rad = Real::wrapped(turned);
            }
            is_turning_circle(&samples, &Manoeuvre::find(&samples).unwrap())
        };
        assert!(record(|t| if t > 20.0 { 0.6 } else { -0.02 }));
        // A doublet, a zig-zag, and a turn that ends too soon.
        assert!(!record(|t| if t > 20.0 && t < 60.0 { 0.3 } else { 0.0 }));
        assert!(!record(|t| 0.6 * (0.05 * t).sin().signum()));
        assert!(!record(|t| if t > 280.0 { 0.6 } else { 0.0 }));
    }
}

//! How good the log of a training is: rejected samples, rudder, heading, speed, clock, compass.

use seatrial_core::Sample;

use super::compass::{CompassError, Jump};
use super::examined::ExaminedRecord;
use super::mishap::heading_jump;
use super::online::Pass;
use super::pace::Pace;
use super::validation::heading_range_rad;
use crate::identification::RejectedSamples;
use crate::manoeuvre::Manoeuvre;
use crate::plausibility::{self, Doubt};
use crate::record::{Record, RudderUnit, Window};

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
        examined: &ExaminedRecord,
        training: Window,
        manoeuvre: &Manoeuvre,
        pass: &Pass,
        hidden_edges: usize,
    ) -> Self {
        let record = examined.record();
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
            pace: Pace::of(samples),
            compass: CompassError::of(&pass.accepted),
            jump_beside: jump_beside(record, training.known_part(samples)),
            hidden_edges,
            unit_doubts: examined
                .unit_doubts()
                .iter()
                .cloned()
                .chain(plausibility::heading_stood(&record.usable(training)))
                .collect(),
            times_are_shared: record.units.times_are_shared,
            unchecked: examined.unchecked().to_vec(),
        }
    }
}

fn jump_beside(record: &Record, training: Window) -> Option<Jump> {
    let beside_s = BESIDE * (training.to_s - training.from_s);
    let around = record.window(Window {
        from_s: training.from_s - beside_s,
        to_s: training.to_s + beside_s,
    });
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
    let speeds: Vec<f64> = samples
        .iter()
        .filter_map(|s| s.surge_speed_m_s.filter(|speed| *speed > 0.0))
        .collect();
    let quarter = speeds.len() / 4;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / quarter as f64;
    (quarter > 0).then(|| {
        [
            mean(&speeds[..quarter]),
            mean(&speeds[speeds.len() - quarter..]),
        ]
    })
}

/// The median interval and the one that one in twenty exceeds, s.
fn usual_and_long_interval_s(samples: &[Sample<f64>]) -> Option<[f64; 2]> {
    let mut intervals: Vec<f64> = samples
        .windows(2)
        .map(|pair| pair[1].time_s - pair[0].time_s)
        .filter(|interval| *interval > 0.0)
        .collect();
    intervals.sort_by(f64::total_cmp);
    let at = |share: f64| {
        intervals
            .get((share * intervals.len() as f64) as usize)
            .copied()
    };
    Some([at(0.5)?, at(0.95)?])
}

//! Which manoeuvres a long record holds, and which parts of it to learn from.
//!
//! [`find`] reads the rudder: strokes that are deflected and held, begun from rest, that turn the vehicle.
//! [`propose`](crate::identify::propose) makes training and validation windows of them, a pair for each speed, and [`singles`](crate::identify::singles) a pair for each
//! manoeuvre.

mod stroke;
mod trace;

use std::fmt;

use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

use crate::manoeuvre::Manoeuvre;
use crate::record::Window;
use stroke::{Chain, Stroke, chains};
use trace::Trace;

/// Each level of rudder is half of the one before, from the largest angle in the record: the strokes of a
/// manoeuvre lie near one of them.
const LEVELS: u32 = 10;

/// A rudder that moves less, rad (0.1 deg), was not moved.
const LEAST_AMPLITUDE_RAD: f64 = 0.0017;

/// Before a manoeuvre the rudder rests: over this many lengths of the first stroke, at least the second number of
/// them, its root mean square is below this share of the amplitude.
const LEAD_IN_STROKES: f64 = 4.0;
const LEAST_LEAD_IN_STROKES: f64 = 0.5;
const REST: f64 = 0.25;

/// A helmsman deflects the rudder to one side and back all the time: a step has the whole lead-in and this many strokes
/// after it, with this root mean square.
const STEP_STROKES: f64 = 2.0;
const STEP_REST: f64 = 0.15;

/// A manoeuvre takes the heading this many times as far from the straight line of its lead-in as the lead-in strays
/// from it: what noise, waves and a helmsman do anyway is none.
const LEAST_DEPARTURE: f64 = 3.0;

/// The strokes of a doublet differ in length by less than this factor, those of a zig-zag, which end when the heading
/// says so, by the second one.
const SAME_LENGTH: f64 = 1.2;
const SIMILAR_LENGTH: f64 = 1.6;

/// From the first to the last sample of a segment is up to an interval less than the segment.
const ROUNDING: f64 = 0.1;

/// Strokes from side to side that make a zig-zag also where the record begins in the middle of it.
const STROKES_WITHOUT_LEAD_IN: usize = 4;

/// What the rudder did in a segment of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// One side, then the other for as long.
    Doublet,
    /// From side to side, three times and more, for different lengths, as in 3-2-1-1.
    Multistep,
    /// From side to side, three times and more, for the same length; the first may be shorter.
    ZigZag,
    /// Deflected to one side once and back to rest.
    Step,
    /// Held to one side until the vehicle has turned once round.
    TurningCircle,
    /// Near its neutral angle for longer than any manoeuvre.
    Steady,
}

impl Kind {
    /// For people.
    ///
    /// ```
    /// use seatrial::log::segmentation::Kind;
    ///
    /// assert_eq!(Kind::Doublet.name(), "doublet");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Doublet => "doublet",
            Self::Multistep => "multistep",
            Self::ZigZag => "zig-zag",
            Self::Step => "step",
            Self::TurningCircle => "turning circle",
            Self::Steady => "steady",
        }
    }

    /// Was the rudder deflected to both sides, so that damping, rudder and offset can be distinguished?
    ///
    /// ```
    /// use seatrial::log::segmentation::Kind;
    ///
    /// // A model needs both: damping, rudder effect and offset cannot be told apart from one side alone.
    /// assert!(Kind::Doublet.uses_both_sides() && !Kind::Step.uses_both_sides());
    /// ```
    pub fn uses_both_sides(self) -> bool {
        matches!(self, Self::Doublet | Self::Multistep | Self::ZigZag)
    }
}

/// The name that documents have: `zig_zag`.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// A manoeuvre or a steady run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// What it is.
    pub kind: Kind,
    /// From the first movement of the rudder to its last return, half open.
    #[serde(flatten)]
    pub window: Window,
    /// Times that the rudder was deflected.
    pub strokes: usize,
    /// How long the first stroke was, s; the whole of a steady run.
    pub first_stroke_s: f64,
    /// Mean rudder angle of the strokes about neutral, rad; the largest of a steady run.
    pub amplitude_rad: f64,
    /// Mean thrust, a fraction of full, where the samples have it.
    pub thrust: Option<f64>,
    /// Mean forward speed, m/s, where the samples have it.
    pub surge_speed_m_s: Option<f64>,
    /// Standard deviation of the heading about its own straight line, up to a first stroke's length after the end, rad.
    pub excitation_rad: f64,
    /// Samples found over samples expected at the record's usual interval.
    pub completeness: f64,
}

/// Finds manoeuvres and steady runs in a record, in order of time.
///
/// ```text
/// stroke     |delta - n| >= 0.4 L on one side, the median a of |delta - n| in 0.58 L..1.51 L,
///            half of it within 10 % of a
/// manoeuvre  strokes from side to side, alike in angle, that follow each other closely, with
///            rms(delta - n) < a/4  and  max |psi - line| < 1/3 of that during the manoeuvre  before them
/// ```
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | delta, psi | rudder, heading, unwrapped | rad |
/// | n | neutral rudder: the middle of the shortest interval of angles that holds half of the samples | rad |
/// | L | a level of rudder: the largest angle, half of it, a quarter, ... | rad |
/// | line | the straight line through the headings of the lead-in, up to four first strokes long | rad |
///
/// Everything is measured in the record's own angles and stroke lengths; only movements of less than 0.1 deg are none.
/// A rudder that is never held, as a helmsman's or an autopilot's, makes no manoeuvre. Samples that are not
/// finite or go back in time are passed over. A million samples take half a second.
///
/// ```
/// use seatrial::log::segmentation::{Kind, find};
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// let doublets: Vec<_> =
///     find(&record.samples).into_iter().filter(|segment| segment.kind == Kind::Doublet).collect();
/// assert_eq!(doublets.len(), 2);
/// assert!((doublets[0].window.from_s - 2.0).abs() < 0.06);
/// ```
pub fn find(samples: &[Sample<f64>]) -> Vec<Segment> {
    let Some(trace) = Trace::of(samples) else {
        return Vec::new();
    };
    let mut found: Vec<Segment> = Vec::new();
    let mut level_rad = trace.largest_rudder_rad();
    for _ in 0..LEVELS {
        if level_rad < LEAST_AMPLITUDE_RAD {
            break;
        }
        for chain in chains(&trace, level_rad) {
            let segment = manoeuvre(&trace, &chain, &found);
            found.extend(segment);
        }
        level_rad *= 0.5;
    }
    found.sort_by(|a, b| a.window.from_s.total_cmp(&b.window.from_s));
    found.extend(steady_runs(&trace, &found));
    found.sort_by(|a, b| a.window.from_s.total_cmp(&b.window.from_s));
    found
}

/// [`find`] in each of several parts of a record that have nothing to do with each other. A part without a manoeuvre to both sides is one as a
/// whole, where the rudder was deflected to both.
///
/// ```
/// use seatrial::Window;
/// use seatrial::log::segmentation::{Kind, find_in_each};
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// // Two logs one after the other.
/// let parts = [Window { from_s: 0.0, to_s: 16.5 }, Window { from_s: 16.5, to_s: 33.0 }];
/// let found = find_in_each(&record.samples, &parts);
/// let doublets = found.iter().filter(|segment| segment.kind == Kind::Doublet).count();
/// assert_eq!(doublets, 2);
/// ```
pub fn find_in_each(samples: &[Sample<f64>], parts: &[Window]) -> Vec<Segment> {
    let of_part = |part: &Window| {
        let samples = part.of(samples);
        let found = find(samples);
        if found.iter().any(|segment| segment.kind.uses_both_sides()) {
            return found;
        }
        as_one(samples).into_iter().collect()
    };
    parts.iter().flat_map(of_part).collect()
}

/// All samples as one manoeuvre, where the rudder was deflected to both sides.
fn as_one(samples: &[Sample<f64>]) -> Option<Segment> {
    let manoeuvre = Manoeuvre::find(samples)?;
    let (first, last) = (manoeuvre.strokes.first()?, manoeuvre.strokes.last()?);
    let is_to_both_sides = (manoeuvre.strokes.iter()).any(|s| s.positive != first.positive);
    let window = Window { to_s: last.window.to_s, ..first.window };
    is_to_both_sides.then_some(Trace::of(samples)?.segment(
        Kind::Multistep,
        window,
        manoeuvre.strokes.len(),
        first.duration_s(),
        manoeuvre.amplitude_rad,
    ))
}

/// The manoeuvre that a chain of strokes is. `None` where it is none, or part of one that was found before.
fn manoeuvre(trace: &Trace, chain: &Chain, found: &[Segment]) -> Option<Segment> {
    let window = chain.window();
    let overlaps =
        |other: &Segment| other.window.from_s < window.to_s && window.from_s < other.window.to_s;
    if found.iter().any(overlaps) {
        return None;
    }
    let kind = kind(trace, chain)?;
    let first_stroke_s = chain.strokes.first()?.duration_s();
    let stands_alone = match kind {
        Kind::TurningCircle => true,
        Kind::ZigZag => chain.strokes.len() >= STROKES_WITHOUT_LEAD_IN,
        _ => false,
    };
    let previous_s = found
        .iter()
        .map(|other| other.window.to_s)
        .filter(|end_s| *end_s <= window.from_s)
        .reduce(f64::max);
    if !(stands_alone || stands_out(trace, chain, kind, previous_s)) {
        return None;
    }
    Some(trace.segment(kind, window, chain.strokes.len(), first_stroke_s, chain.amplitude_rad()))
}

/// Does the rudder rest before the strokes, and the heading depart from its straight line with them? `previous_s` is the end of the manoeuvre
/// before.
fn stands_out(trace: &Trace, chain: &Chain, kind: Kind, previous_s: Option<f64>) -> bool {
    let window = chain.window();
    let first_stroke_s = chain.strokes.first().map_or(0.0, Stroke::duration_s);
    let before_s = previous_s
        .unwrap_or(f64::NEG_INFINITY)
        .max(window.from_s - LEAD_IN_STROKES * first_stroke_s);
    let before = Window { from_s: before_s, to_s: window.from_s };
    let after = Window { from_s: window.to_s, to_s: window.to_s + STEP_STROKES * first_stroke_s };
    let during = trace.indices(Window { to_s: window.to_s + first_stroke_s, ..window });
    let rests = |part: Window, strokes: f64, share: f64| {
        let part = trace.indices(part);
        trace.duration_s(&part) >= (1.0 - ROUNDING) * strokes * first_stroke_s
            && trace.rudder_rms_rad(part) < share * chain.amplitude_rad()
    };
    let is_begun_from_rest = match kind {
        Kind::Step => {
            rests(before, LEAD_IN_STROKES, STEP_REST) && rests(after, STEP_STROKES, STEP_REST)
        }
        _ => rests(before, LEAST_LEAD_IN_STROKES, REST),
    };
    let departs_from = |from_s: f64| {
        let lead_in = trace.indices(Window { from_s, ..before });
        trace.departure(lead_in, during.clone()) > LEAST_DEPARTURE
    };
    // Behind another manoeuvre the vehicle is still on its way back.
    let is_behind = previous_s == Some(before_s);
    let departs =
        departs_from(before_s) || is_behind && departs_from(0.5 * (before_s + window.from_s));
    is_begun_from_rest && departs
}

fn kind(trace: &Trace, chain: &Chain) -> Option<Kind> {
    let durations = chain.strokes.iter().filter_map(|stroke| Some(stroke.held?.duration_s));
    let spread = |durations: &mut dyn Iterator<Item = f64>| {
        let (low, high) =
            durations.fold((f64::INFINITY, 0.0_f64), |(low, high), d| (low.min(d), high.max(d)));
        high / low
    };
    match chain.strokes.len() {
        1 if trace.turned_rad(chain.window()).abs() >= std::f64::consts::TAU => {
            Some(Kind::TurningCircle)
        }
        1 => Some(Kind::Step),
        2 => (spread(&mut durations.into_iter()) < SAME_LENGTH).then_some(Kind::Doublet),
        _ if spread(&mut durations.skip(1)) < SIMILAR_LENGTH => Some(Kind::ZigZag),
        _ => Some(Kind::Multistep),
    }
}

/// Segments between the manoeuvres in which the rudder stays within half of the smallest amplitude, longer than any of
/// them. None of a record without manoeuvres: nothing says there what a small angle is.
fn steady_runs(trace: &Trace, manoeuvres: &[Segment]) -> Vec<Segment> {
    let smallest_rad = manoeuvres.iter().map(|m| m.amplitude_rad).fold(f64::INFINITY, f64::min);
    let longest_s = manoeuvres
        .iter()
        .filter(|m| m.kind != Kind::TurningCircle)
        .map(|m| m.window.to_s - m.window.from_s)
        .fold(0.0, f64::max);
    if manoeuvres.is_empty() {
        return Vec::new();
    }
    let ends = manoeuvres.iter().map(|m| m.window.to_s + m.first_stroke_s);
    let starts = manoeuvres.iter().map(|m| m.window.from_s);
    [f64::NEG_INFINITY]
        .into_iter()
        .chain(ends)
        .zip(starts.chain([f64::INFINITY]))
        .flat_map(|(from_s, to_s)| {
            trace.quiet_segments(Window { from_s, to_s }, 0.5 * smallest_rad)
        })
        .filter(|window| window.to_s - window.from_s > longest_s)
        .map(|window| {
            let largest_rad = trace.rudder_peak_rad(window);
            let duration_s = window.to_s - window.from_s;
            trace.segment(Kind::Steady, window, 0, duration_s, largest_rad)
        })
        .collect()
}

#[cfg(test)]
mod tests;

//! Training and validation windows, a pair for each speed.

use std::fmt::Write;

use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

use super::lambda_of;
use crate::figures::three_figures;
use crate::record::{Record, Window, mean, median};
use crate::segmentation::{Kind, Segment};

/// Manoeuvres are of one speed where their thrusts differ by no more than this, or their speeds by no more than this
/// share (b2 goes with the square: 20 %).
const SAME_THRUST: f64 = 0.02;
const SAME_SPEED: f64 = 0.1;

/// A manoeuvre with more samples missing, or that turned the vehicle less than this share of the best of its speed,
/// teaches nothing.
const LEAST_COMPLETENESS: f64 = 0.5;
const LEAST_EXCITATION: f64 = 0.2;

/// More are not joined: the ninth makes an interval narrower by a twentieth.
const MOST_JOINED: usize = 8;

/// A window has this much rest before the manoeuvre and this much response after it, in time constants of the
/// vehicle, after which less than a hundredth of the response is left to come; the rest is no longer than was looked at, and both are within these bounds in first strokes.
const LEAD_IN_TIME_CONSTANTS: f64 = 2.0;
const RESPONSE_TIME_CONSTANTS: f64 = 5.0;
const LEAD_IN_STROKES: (f64, f64) = (0.5, 4.0);
const RESPONSE_STROKES: (f64, f64) = (3.0, 20.0);

/// Where the time constant is not known, in first strokes: rest and response.
const UNKNOWN_STROKES: (f64, f64) = (1.0, 3.0);

/// A record with one manoeuvre is that manoeuvre where it is no longer than this many times it.
const LONGEST_SINGLE: f64 = 10.0;

/// What to learn from and what to validate on at one speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// Mean thrust of the manoeuvres that train, a fraction of full.
    pub thrust: Option<f64>,
    /// Mean speed of those that train, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// Manoeuvres to learn from, the best excited one first; at least one.
    pub training: Vec<Window>,
    /// A manoeuvre of the same speed that is not learnt from.
    pub validation: Option<Window>,
    /// Why these, for people.
    pub because: String,
}

/// A manoeuvre by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single {
    /// The manoeuvre.
    pub segment: Segment,
    /// With the rest before it and the response after it.
    pub training: Window,
    /// The best excited other manoeuvre of the same speed.
    pub validation: Option<Window>,
}

/// What the manoeuvres of a record are grouped by.
#[derive(Clone, Copy, PartialEq)]
enum Key {
    Thrust,
    Speed,
    Nothing,
}

impl Key {
    /// Thrust where it is known of every manoeuvre, else speed where that is.
    fn of(segments: &[Segment]) -> Self {
        let has_thrust = |s: &Segment| s.thrust.is_some_and(|t| (0.0..=1.1).contains(&t));
        if segments.iter().all(has_thrust) {
            Self::Thrust
        } else if segments.iter().all(|s| s.surge_speed_m_s.is_some()) {
            Self::Speed
        } else {
            Self::Nothing
        }
    }

    fn value(self, segment: &Segment) -> f64 {
        match self {
            Self::Thrust => segment.thrust,
            Self::Speed => segment.surge_speed_m_s,
            Self::Nothing => None,
        }
        .unwrap_or(0.0)
    }

    fn is_same(self, a: &Segment, b: &Segment) -> bool {
        let difference = (self.value(a) - self.value(b)).abs();
        difference
            <= match self {
                Self::Thrust => SAME_THRUST,
                Self::Speed | Self::Nothing => SAME_SPEED * self.value(a).abs(),
            }
    }
}

/// Windows for training and validation, of every speed at which the rudder was deflected to both sides, slowest first.
///
/// The second best excited of several manoeuvres validates, and the others, eight at most, train; of these only such as
/// were at the best one's speed from begin to end, where it is known. Those in which the speed changes come after all others. The
/// windows of one
/// speed do not overlap: each holds the rest before its manoeuvre, 2 time constants of the vehicle, and the response after
/// it, 5 of them and 3 first strokes at least, as far as the next manoeuvre and the thrust allow. The time constant is 1.5/lambda of the state variable filter that
/// fits the best excited manoeuvre.
///
/// Empty where there is nothing to choose from: no manoeuvre to both sides, a record that is one manoeuvre with little
/// before and after it, or one manoeuvre beside which the rudder did more without the form of one.
///
/// ```
/// use seatrial::identify::propose;
/// use seatrial::log::segmentation::find;
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
/// // One doublet to learn from, the other to validate with.
/// let found = propose(&record, &find(&record.samples));
/// let [one_speed] = &found[..] else { panic!("one speed") };
/// assert_eq!(one_speed.training.len(), 1);
/// assert!(one_speed.validation.is_some());
/// ```
pub fn propose(record: &Record, segments: &[Segment]) -> Vec<Proposal> {
    let manoeuvres = manoeuvres(segments);
    by_speed(record, &manoeuvres)
        .into_iter()
        .map(|speed| Speed::new(record, &manoeuvres, speed).proposal())
        .collect()
}

/// Each manoeuvre to both sides by itself, in order of time, with the windows that [`propose`] gives them. Empty where
/// [`propose`] is: the record is then to be taken as a whole.
///
/// ```
/// use seatrial::identify::singles;
/// use seatrial::log::segmentation::find;
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
/// let found = singles(&record, &find(&record.samples));
/// assert_eq!(found.len(), 2);
/// ```
pub fn singles(record: &Record, segments: &[Segment]) -> Vec<Single> {
    let manoeuvres = manoeuvres(segments);
    let of = |speed| Speed::new(record, &manoeuvres, speed).singles();
    let mut singles: Vec<Single> = by_speed(record, &manoeuvres).into_iter().flat_map(of).collect();
    singles.sort_by(|a, b| a.training.from_s.total_cmp(&b.training.from_s));
    singles
}

fn manoeuvres(segments: &[Segment]) -> Vec<Segment> {
    let moves = segments.iter().filter(|s| s.kind != Kind::Steady);
    moves.copied().collect()
}

/// The manoeuvres to both sides of each speed, slowest first.
fn by_speed(record: &Record, manoeuvres: &[Segment]) -> Vec<Vec<Segment>> {
    if is_one_manoeuvre(record, manoeuvres) {
        return Vec::new();
    }
    let mut useful: Vec<Segment> = manoeuvres
        .iter()
        .filter(|s| s.kind.uses_both_sides() && s.completeness >= LEAST_COMPLETENESS)
        .copied()
        .collect();
    let key = Key::of(&useful);
    useful.sort_by(|a, b| key.value(a).total_cmp(&key.value(b)));
    let mut speeds: Vec<Vec<Segment>> = Vec::new();
    for segment in useful {
        match speeds.last_mut() {
            Some(speed) if key.is_same(&speed[0], &segment) => speed.push(segment),
            _ => speeds.push(vec![segment]),
        }
    }
    match speeds.as_slice() {
        [speed] if speed.len() == 1 && is_amid_others(record, &speed[0]) => Vec::new(),
        _ => speeds,
    }
}

/// Did the rudder do more outside this manoeuvre than in it, without the form of one? The whole record then trains, and its legs validate:
/// of two manoeuvres of random strokes the first few of one were a doublet, with a twentieth of the rudder's squares.
fn is_amid_others(record: &Record, manoeuvre: &Segment) -> bool {
    let usual_rad = median(record.samples.iter().map(|s| s.rudder_rad).collect()).unwrap_or(0.0);
    let squares = |samples: &[Sample<f64>]| -> f64 {
        samples.iter().map(|s| (s.rudder_rad - usual_rad).powi(2)).sum()
    };
    let own = squares(record.window(manoeuvre.window));
    own < squares(&record.samples) - own
}

fn is_one_manoeuvre(record: &Record, manoeuvres: &[Segment]) -> bool {
    let ([manoeuvre], [first, .., last]) = (manoeuvres, &record.samples[..]) else {
        return false;
    };
    let length_s = manoeuvre.window.to_s - manoeuvre.window.from_s;
    last.time_s - first.time_s <= LONGEST_SINGLE * length_s
}

/// Was the vehicle at this speed from the begin of a manoeuvre to its end, in the mean of each quarter? Yes where it is not known: at the
/// same thrust a vehicle may still gain way, and b2 goes with the square.
fn keeps_speed(record: &Record, manoeuvre: &Segment, speed_m_s: Option<f64>) -> bool {
    let Some(wanted) = speed_m_s else {
        return true;
    };
    let samples = record.window(manoeuvre.window);
    let quarter = (samples.len() / 4).max(1);
    let of = |part: &[Sample<f64>]| mean(part.iter().filter_map(|s| s.surge_speed_m_s));
    samples.chunks_exact(quarter).all(|part| {
        of(part).is_none_or(|speed| (speed - wanted).abs() <= SAME_SPEED * wanted.abs())
    })
}

/// The manoeuvres of one speed, the best excited of those at a steady speed first.
struct Speed<'a> {
    record: &'a Record,
    all: &'a [Segment],
    manoeuvres: Vec<Segment>,
    time_constant_s: Option<f64>,
}

impl<'a> Speed<'a> {
    fn new(record: &'a Record, all: &'a [Segment], mut manoeuvres: Vec<Segment>) -> Self {
        manoeuvres.sort_by(|a, b| b.excitation_rad.total_cmp(&a.excitation_rad));
        // The order of those that are as steady stays.
        manoeuvres.sort_by_cached_key(|m| !keeps_speed(record, m, m.surge_speed_m_s));
        let least_rad = LEAST_EXCITATION * manoeuvres[0].excitation_rad;
        manoeuvres.retain(|m| m.excitation_rad >= least_rad);
        let mut speed = Self { record, all, manoeuvres, time_constant_s: None };
        let choice = lambda_of(record, speed.window(&speed.manoeuvres[0]));
        speed.time_constant_s = choice.ok().map(|choice| choice.time_constant_s());
        speed
    }

    fn proposal(&self) -> Proposal {
        let mut training = self.manoeuvres.clone();
        let validation = (training.len() > 1).then(|| training.remove(1));
        let best = training[0];
        training.retain(|other| {
            *other == best || keeps_speed(self.record, other, best.surge_speed_m_s)
        });
        training.truncate(MOST_JOINED);
        let mean_of = |of: fn(&Segment) -> Option<f64>| {
            let known: Vec<f64> = training.iter().filter_map(of).collect();
            mean(known.into_iter()).filter(|_| training.iter().all(|m| of(m).is_some()))
        };
        Proposal {
            thrust: mean_of(|m| m.thrust),
            surge_speed_m_s: mean_of(|m| m.surge_speed_m_s),
            because: self.because(&training, validation.as_ref()),
            training: training.iter().map(|m| self.window(m)).collect(),
            validation: validation.map(|m| self.window(&m)),
        }
    }

    fn singles(&self) -> Vec<Single> {
        let single = |(k, segment): (usize, &Segment)| Single {
            segment: *segment,
            training: self.window(segment),
            validation: self.manoeuvres.get(usize::from(k == 0)).map(|other| self.window(other)),
        };
        self.manoeuvres.iter().enumerate().map(single).collect()
    }

    /// The manoeuvre with the rest before it and the response after it.
    fn window(&self, manoeuvre: &Segment) -> Window {
        let before = |m: &Segment| self.lead_in_and_response_s(m)[0];
        let response_s = self.lead_in_and_response_s(manoeuvre)[1];
        let Window { from_s, to_s } = manoeuvre.window;
        let previous_end_s = self
            .all
            .iter()
            .map(|other| other.window.to_s)
            .filter(|end_s| *end_s <= from_s)
            .fold(f64::NEG_INFINITY, f64::max);
        let next = self.all.iter().find(|other| other.window.from_s >= to_s);
        let next_begins_s =
            next.map_or(f64::INFINITY, |next| to_s.max(next.window.from_s - before(next)));
        self.within_thrust(
            manoeuvre,
            Window {
                from_s: (from_s - before(manoeuvre)).max(previous_end_s),
                to_s: (to_s + response_s).min(next_begins_s),
            },
        )
    }

    fn lead_in_and_response_s(&self, manoeuvre: &Segment) -> [f64; 2] {
        let stroke_s = manoeuvre.first_stroke_s;
        let Some(time_constant_s) = self.time_constant_s else {
            return [UNKNOWN_STROKES.0 * stroke_s, UNKNOWN_STROKES.1 * stroke_s];
        };
        let bounded = |length_s: f64, (least, most): (f64, f64)| {
            length_s.clamp(least * stroke_s, most * stroke_s)
        };
        [
            bounded(LEAD_IN_TIME_CONSTANTS * time_constant_s, LEAD_IN_STROKES),
            bounded(RESPONSE_TIME_CONSTANTS * time_constant_s, RESPONSE_STROKES),
        ]
    }

    /// The part of a window in which the thrust is that of the manoeuvre.
    fn within_thrust(&self, manoeuvre: &Segment, window: Window) -> Window {
        let Some(thrust) = manoeuvre.thrust else {
            return window;
        };
        let samples = self.record.window(window);
        let differs = |thrust_now: Option<f64>| {
            thrust_now.is_some_and(|now| (now - thrust).abs() > SAME_THRUST)
        };
        let different = || samples.iter().filter(|s| differs(s.thrust)).map(|s| s.time_s);
        Window {
            from_s: different()
                .filter(|time_s| *time_s < manoeuvre.window.from_s)
                .fold(window.from_s, f64::max),
            to_s: different()
                .filter(|time_s| *time_s >= manoeuvre.window.to_s)
                .fold(window.to_s, f64::min),
        }
    }

    fn because(&self, training: &[Segment], validation: Option<&Segment>) -> String {
        let named = |m: &Segment| format!("{} at {:.1} s", m.kind.name(), m.window.from_s);
        let mut text = format!("the best excited manoeuvre, the {}", named(&training[0]));
        for more in &training[1..] {
            let _ = write!(text, ", joined with the {}", named(more));
        }
        match validation {
            Some(validation) => {
                let _ = write!(text, "; validated on the {}", named(validation));
            }
            None => text += "; no other of this speed is left to validate on",
        }
        match self.time_constant_s {
            Some(time_constant_s) => {
                let _ = write!(
                    text,
                    "; windows by a time constant of {} s",
                    three_figures(time_constant_s)
                );
            }
            None => text += "; windows by the length of the strokes",
        }
        text
    }
}

//! The standard manoeuvres in a record.

mod holds;
mod pull_out;
mod spiral;
mod stopping;

use seatrial_core::Sample;

use super::{Instant, TurningCircle, ZigZag, track_m};
use crate::record::unwrapped_rad;
pub use pull_out::PullOut;
pub use spiral::{Spiral, SpiralLoop, SpiralRate};
pub use stopping::Stopping;

/// A rudder within this share of its largest angle is over.
const OVER: f64 = 0.5;
/// A rudder leaves its angle where it is below this share of it.
const LEFT: f64 = 0.9;
/// Heading change that a turning circle has at least, rad.
const CIRCLE_RAD: f64 = std::f64::consts::PI;

/// Which manoeuvre a record is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The rudder goes from side to side.
    ZigZag,
    /// The rudder stays on one side until the heading has changed by 180 degrees.
    TurningCircle,
    /// The rudder goes amidships out of a steady turn.
    PullOut,
    /// The rudder takes one angle after the other from side to side and back.
    Spiral,
    /// The speed ends.
    Stopping,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::ZigZag, Self::TurningCircle, Self::PullOut, Self::Spiral, Self::Stopping];

    /// As `seatrial manoeuvres read` takes it.
    ///
    /// ```
    /// use seatrial::sea_trials::ship_manoeuvres::Kind;
    ///
    /// let names: Vec<_> = Kind::ALL.into_iter().map(Kind::name).collect();
    /// assert!(names.contains(&"zig-zag"));
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::ZigZag => "zig-zag",
            Self::TurningCircle => "turning-circle",
            Self::PullOut => "pull-out",
            Self::Spiral => "spiral",
            Self::Stopping => "stopping",
        }
    }
}

/// What a record holds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RecordedManoeuvre {
    /// The rudder went from side to side.
    ZigZag(ZigZag),
    /// The rudder stayed on one side until the heading had changed by 180 degrees.
    TurningCircle(TurningCircle),
    /// The rudder went amidships out of a steady turn.
    PullOut(PullOut),
    /// The rudder took one angle after the other.
    Spiral(Spiral),
    /// The speed ended.
    Stopping(Stopping),
}

/// Why a record has no manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoManoeuvre {
    /// A sample lacks what the figures need.
    #[error(
        "no forward speed and no position: the figures of a manoeuvre are lengths; log one of them"
    )]
    NoSpeed,
    /// Too short or without a rudder.
    #[error("the rudder does not move: choose a part of the record with --from and --to")]
    NoRudder,
    /// None of them.
    #[error(
        "no zig-zag (three changes of the rudder from side to side), no turn by 180 degrees under one rudder, no pull-out, no spiral and no stop: choose a part of the record with --from and --to"
    )]
    Neither,
    /// Fewer than two swings.
    #[error(
        "no zig-zag: the rudder does not change three times from side to side without a stop amidships"
    )]
    NoZigZag,
    /// The heading does not turn far enough.
    #[error("no turning circle: the heading does not change by 180 degrees under one rudder")]
    NoTurningCircle,
    /// The rudder never goes amidships out of a turn.
    #[error("no pull-out: the rudder is not held amidships after it was held to one side")]
    NoPullOut,
    /// The record ends too early.
    #[error(
        "no pull-out: the yaw rate still changes where the rudder amidships ends; record until it is steady"
    )]
    PullOutNotSteady,
    /// Too few rudder angles.
    #[error(
        "no spiral: the rudder does not take five or more angles one after the other from one side to the other, each held"
    )]
    NoSpiral,
    /// A rudder angle was not held for long enough.
    #[error(
        "no spiral: at {rudder_deg:.1} deg of rudder, from {time_s:.0} s on, the yaw rate still changes at the end; hold each angle until it is steady"
    )]
    SpiralNotSteady {
        /// The rudder angle, degrees.
        rudder_deg: f64,
        /// When it was taken, s of the record.
        time_s: f64,
    },
    /// The speed does not end.
    #[error(
        "no stop: the least speed is {percent:.0} % of that at the beginning; a stop needs 20 % (without thrust) or 0 (full astern)"
    )]
    NotStopped {
        /// The least speed, percent of that at the beginning.
        percent: f64,
    },
}

/// The manoeuvres of a record, in the order of [`Kind::ALL`]; of those of one kind the last, of pull-outs the last of each side. Position
/// is that of the samples or, where it is missing, the forward speed along the heading; yaw rates are slopes of the heading.
///
/// # Errors
/// Why the wanted manoeuvre is not there or, where none is named, why none is.
///
/// ```
/// use seatrial::Sample;
/// use seatrial::sea_trials::ship_manoeuvres::recorded;
///
/// // A rudder that lies still makes no manoeuvre.
/// let still: Vec<_> = (0..100)
///     .map(|k| Sample { time_s: f64::from(k), surge_speed_m_s: Some(4.0), ..Sample::default() })
///     .collect();
/// assert!(recorded(&still, None).is_err());
/// ```
pub fn recorded(
    samples: &[Sample<f64>],
    wanted: Option<Kind>,
) -> Result<Vec<RecordedManoeuvre>, NoManoeuvre> {
    if samples.is_empty() {
        return Err(NoManoeuvre::NoSpeed);
    }
    if let Some(kind) = wanted {
        return Ok(vec![of_kind(samples, kind)?]);
    }
    let mut found = Vec::new();
    let mut cause = NoManoeuvre::Neither;
    let stands_still = samples.iter().all(|s| s.rudder_rad == 0.0);
    for kind in Kind::ALL {
        match of_kind(samples, kind) {
            Ok(one) => found.push(one),
            Err(why @ (NoManoeuvre::PullOutNotSteady | NoManoeuvre::SpiralNotSteady { .. })) => {
                cause = why;
            }
            Err(why @ NoManoeuvre::NoSpeed) if cause == NoManoeuvre::Neither => cause = why,
            Err(_) => {}
        }
    }
    // A spiral turns through circles and ends amidships: it is what the record was made for.
    if found.iter().any(|one| matches!(one, RecordedManoeuvre::Spiral(_))) {
        found.retain(|one| matches!(one, RecordedManoeuvre::Spiral(_)));
    }
    match (found.is_empty(), stands_still) {
        (false, _) => Ok(found),
        (true, true) => Err(NoManoeuvre::NoRudder),
        (true, false) => Err(cause),
    }
}

fn of_kind(samples: &[Sample<f64>], kind: Kind) -> Result<RecordedManoeuvre, NoManoeuvre> {
    if kind == Kind::Stopping {
        return stopping::stopping(samples).map(RecordedManoeuvre::Stopping);
    }
    let angles = samples.iter().map(|s| s.rudder_rad.abs());
    let largest_rad = angles.fold(0.0, f64::max);
    if !(largest_rad > 0.0 && largest_rad.is_finite()) {
        return Err(NoManoeuvre::NoRudder);
    }
    let holds = || holds::holds(samples, largest_rad);
    match kind {
        Kind::ZigZag => zig_zag(samples, largest_rad).map(RecordedManoeuvre::ZigZag),
        Kind::TurningCircle => circle(samples, largest_rad).map(RecordedManoeuvre::TurningCircle),
        Kind::PullOut => pull_out::pull_out(&holds(), largest_rad).map(RecordedManoeuvre::PullOut),
        _ => spiral::spiral(&holds(), largest_rad).map(RecordedManoeuvre::Spiral),
    }
}

fn circle(samples: &[Sample<f64>], largest_rad: f64) -> Result<TurningCircle, NoManoeuvre> {
    let track = track(samples)?;
    let turning = || {
        let after = track.get(circle_execute(samples, largest_rad)?..)?;
        let turned = after.last()?.heading_rad - after.first()?.heading_rad;
        (turned.abs() >= CIRCLE_RAD).then(|| TurningCircle::of(after, largest_rad)).flatten()
    };
    turning().ok_or(NoManoeuvre::NoTurningCircle)
}

/// The execute of the last turn: out of the angle on the other side or, where the rudder was held amidships between them, out of that.
fn circle_execute(samples: &[Sample<f64>], largest_rad: f64) -> Option<usize> {
    let Execute { left, over } = *executes(samples, largest_rad).last()?;
    let holds = holds::holds(samples, largest_rad);
    let amidships = holds
        .iter()
        .rfind(|hold| hold.is_amidships(largest_rad) && hold.from >= left && hold.to <= over);
    Some(amidships.map_or(left, |hold| hold.to))
}

fn zig_zag(samples: &[Sample<f64>], largest_rad: f64) -> Result<ZigZag, NoManoeuvre> {
    let track = track(samples)?;
    let executes = executes(samples, largest_rad);
    let is_stopped = |first: usize, last: usize| {
        let holds = holds::holds(samples, largest_rad);
        holds
            .iter()
            .filter(|hold| hold.from > first && hold.to <= last)
            .any(|hold| hold.is_amidships(largest_rad))
    };
    let executes: Vec<usize> = executes.iter().map(|execute| execute.left).collect();
    let ends = executes.first().zip(executes.last());
    if ends.is_some_and(|(first, last)| is_stopped(*first, *last)) {
        return Err(NoManoeuvre::NoZigZag);
    }
    ZigZag::of(&track, &executes, largest_rad).ok_or(NoManoeuvre::NoZigZag)
}

/// The rudder goes over to a side.
#[derive(Clone, Copy)]
struct Execute {
    /// The sample from which it leaves the angle before, the first time that of the middle.
    left: usize,
    /// The sample at which it is over.
    over: usize,
}

/// The executes of a record.
fn executes(samples: &[Sample<f64>], largest_rad: f64) -> Vec<Execute> {
    let mut found: Vec<Execute> = Vec::new();
    let mut side = 0.0;
    let mut held = 0;
    for (k, sample) in samples.iter().enumerate() {
        let share = sample.rudder_rad / largest_rad;
        if share.abs() >= OVER && share.signum() != side {
            found.push(Execute { left: (held + 1).min(k), over: k });
            side = share.signum();
        }
        let is_still = if side == 0.0 { share.abs() < 1.0 - LEFT } else { side * share >= LEFT };
        if is_still {
            held = k;
        }
    }
    found
}

/// Headings without jumps at a full turn, rad.
fn unwrapped_headings_rad(samples: &[Sample<f64>]) -> Vec<f64> {
    let first_rad = samples.first().map_or(0.0, |s| s.heading_rad);
    unwrapped_rad(first_rad, samples.iter().map(|s| s.heading_rad))
}

/// The largest share of a record in one gap of its positions that a straight line bridges.
const LARGEST_POSITION_GAP: f64 = 0.05;

/// The position of every sample, blanks bridged by straight lines; `None` where there are none, or too many in a row.
pub(super) fn positions(samples: &[Sample<f64>]) -> Option<Vec<[f64; 2]>> {
    let fix = |at: usize| {
        let sample = samples.get(at)?;
        Some([sample.north_m?, sample.east_m?])
    };
    let longest = (LARGEST_POSITION_GAP * samples.len() as f64) as usize;
    let mut positions: Vec<[f64; 2]> = Vec::with_capacity(samples.len());
    while positions.len() < samples.len() {
        let at = positions.len();
        if let Some(position) = fix(at) {
            positions.push(position);
            continue;
        }
        let before = positions.last().copied()?;
        let next = (at..=at + longest).find(|at| fix(*at).is_some())?;
        let (from_s, to_s) = (samples[at - 1].time_s, samples[next].time_s);
        let after = fix(next)?;
        for sample in &samples[at..next] {
            let share = (sample.time_s - from_s) / (to_s - from_s);
            let between = |axis: usize| before[axis] + share * (after[axis] - before[axis]);
            positions.push([between(0), between(1)]);
        }
    }
    Some(positions)
}

fn track(samples: &[Sample<f64>]) -> Result<Vec<Instant>, NoManoeuvre> {
    let positions = positions(samples);
    let has_speed = samples.iter().all(|s| s.surge_speed_m_s.is_some());
    if samples.is_empty() || !(positions.is_some() || has_speed) {
        return Err(NoManoeuvre::NoSpeed);
    }
    let mut track: Vec<Instant> = Vec::with_capacity(samples.len());
    for (k, (sample, heading_rad)) in
        samples.iter().zip(unwrapped_headings_rad(samples)).enumerate()
    {
        let last = track.last().copied();
        let surge_speed_m_s = sample.surge_speed_m_s.unwrap_or(f64::NAN);
        let [north_m, east_m] = match (&positions, last) {
            (Some(positions), _) => positions[k],
            (_, Some(last)) => {
                let way_m =
                    0.5 * (last.surge_speed_m_s + surge_speed_m_s) * (sample.time_s - last.time_s);
                let course = 0.5 * (last.heading_rad + heading_rad);
                [last.north_m + way_m * libm::cos(course), last.east_m + way_m * libm::sin(course)]
            }
            (_, None) => [0.0, 0.0],
        };
        track.push(Instant {
            time_s: sample.time_s,
            heading_rad,
            surge_speed_m_s,
            north_m,
            east_m,
        });
    }
    Ok(track)
}

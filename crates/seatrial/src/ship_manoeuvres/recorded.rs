//! Zig-zags and turning circles in a record.

use seatrial_core::{Real, Sample};

use super::{Instant, TurningCircle, ZigZag};

/// A rudder within this share of its largest angle is over.
const OVER: f64 = 0.5;
/// A rudder leaves its angle where it is below this share of it.
const LEFT: f64 = 0.9;
/// Heading change that a turning circle has at least, rad.
const CIRCLE_RAD: f64 = std::f64::consts::PI;

/// What a record holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Recorded {
    /// The rudder went from side to side.
    ZigZag(ZigZag),
    /// The rudder stayed on one side until the heading had changed by 180 degrees.
    TurningCircle(TurningCircle),
}

/// Why a record has no manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
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
    /// Neither of them.
    #[error(
        "neither a zig-zag (three changes of the rudder from side to side) nor a turn by 180 degrees under one rudder: choose a part of the record with --from and --to"
    )]
    Neither,
}

/// The manoeuvre of a record. Position is that of the samples or, where it is missing, the forward speed along the heading.
pub fn recorded(samples: &[Sample<f64>]) -> Result<Recorded, NoManoeuvre> {
    let track = track(samples)?;
    let largest_rad = samples
        .iter()
        .map(|s| s.rudder_rad.abs())
        .fold(0.0, f64::max);
    if !(largest_rad > 0.0 && largest_rad.is_finite()) {
        return Err(NoManoeuvre::NoRudder);
    }
    let executes = executes(samples, largest_rad);
    let turning = || {
        let from = *executes.last()?;
        let after = track.get(from..)?;
        let turned = after.last()?.heading_rad - after.first()?.heading_rad;
        let circle = || TurningCircle::of(after, largest_rad).map(Recorded::TurningCircle);
        (turned.abs() >= CIRCLE_RAD).then(circle).flatten()
    };
    let zig_zag = || ZigZag::of(&track, &executes, largest_rad).map(Recorded::ZigZag);
    turning().or_else(zig_zag).ok_or(NoManoeuvre::Neither)
}

/// The instants from which the rudder leaves an angle for the other side, the first of them the middle.
fn executes(samples: &[Sample<f64>], largest_rad: f64) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut side = 0.0;
    let mut held = 0;
    for (k, sample) in samples.iter().enumerate() {
        let share = sample.rudder_rad / largest_rad;
        if share.abs() >= OVER && share.signum() != side {
            found.push((held + 1).min(k));
            side = share.signum();
        }
        let is_still = if side == 0.0 {
            share.abs() < 1.0 - LEFT
        } else {
            side * share >= LEFT
        };
        if is_still {
            held = k;
        }
    }
    found
}

fn track(samples: &[Sample<f64>]) -> Result<Vec<Instant>, NoManoeuvre> {
    let has_position = samples
        .iter()
        .all(|s| s.north_m.is_some() && s.east_m.is_some());
    let has_speed = samples.iter().all(|s| s.surge_speed_m_s.is_some());
    if samples.is_empty() || !(has_position || has_speed) {
        return Err(NoManoeuvre::NoSpeed);
    }
    let mut track: Vec<Instant> = Vec::with_capacity(samples.len());
    for sample in samples {
        let last = track.last().copied();
        let heading_rad = last.map_or(sample.heading_rad, |last| {
            last.heading_rad + Real::wrapped(sample.heading_rad - last.heading_rad)
        });
        let surge_speed_m_s = sample.surge_speed_m_s.unwrap_or(f64::NAN);
        let [north_m, east_m] = match (sample.north_m.zip(sample.east_m), last) {
            (Some((north, east)), _) if has_position => [north, east],
            (_, Some(last)) => {
                let way_m =
                    0.5 * (last.surge_speed_m_s + surge_speed_m_s) * (sample.time_s - last.time_s);
                let course = 0.5 * (last.heading_rad + heading_rad);
                [
                    last.north_m + way_m * libm::cos(course),
                    last.east_m + way_m * libm::sin(course),
                ]
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

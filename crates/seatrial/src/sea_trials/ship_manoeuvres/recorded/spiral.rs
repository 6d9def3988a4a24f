//! Dieudonne's direct spiral: one rudder angle after the other from side to side and back, each until the yaw rate is steady.

use serde::Serialize;

use super::NoManoeuvre;
use super::holds::{Hold, largest_rad_s};

/// A spiral has at least this many rudder angles.
const LEAST_ANGLES: usize = 5;
/// Rudder angles within this share of the largest are one.
const SAME_ANGLE: f64 = 0.015;
/// Yaw rates of one angle, there and back, that differ by less than this share of the largest are one.
const SAME_RATE: f64 = 0.02;

/// The steady yaw rates of a spiral.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spiral {
    /// In the order of the record.
    pub points: Vec<SpiralRate>,
    /// The loop; absent where the record does not come back.
    pub loop_width: Option<SpiralLoop>,
}

/// A rudder angle and its yaw rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpiralRate {
    /// Rudder angle, rad.
    pub rudder_rad: f64,
    /// Steady yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Is it of the way back?
    pub is_back: bool,
}

/// The loop between the curve there and the curve back. A straight-line stable ship has none: both numbers are 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpiralLoop {
    /// Between the rudder angles at which the ship begins to turn to the other side, there and back, rad: each is the middle of the two
    /// angles of the record between which it does.
    pub width_rad: f64,
    /// Between the yaw rates there and back with the rudder nearest to amidships, rad/s.
    pub height_rad_s: f64,
}

impl SpiralLoop {
    /// Without a loop the ship is straight-line stable.
    pub fn is_stable(&self) -> bool {
        self.width_rad == 0.0
    }
}

/// The spiral of a record.
pub(super) fn spiral(holds: &[Hold], largest_rad: f64) -> Result<Spiral, NoManoeuvre> {
    let (there, back) = ways(holds, SAME_ANGLE * largest_rad).ok_or(NoManoeuvre::NoSpiral)?;
    let largest = largest_rad_s(holds);
    let unsteady = there.iter().chain(back).find(|hold| !hold.is_steady(largest));
    if let Some(hold) = unsteady {
        return Err(NoManoeuvre::SpiralNotSteady {
            rudder_deg: hold.rudder_rad.to_degrees(),
            time_s: hold.from_s,
        });
    }
    let rate = |hold: &Hold, is_back| SpiralRate {
        rudder_rad: hold.rudder_rad,
        yaw_rate_rad_s: hold.yaw_rate_rad_s(),
        is_back,
    };
    let points = there.iter().map(|hold| rate(hold, false));
    let points = points.chain(back.iter().map(|hold| rate(hold, true)));
    let loop_width = match back.is_empty() {
        true => None,
        false => Some(spiral_loop(there, back, largest, SAME_ANGLE * largest_rad)?),
    };
    Ok(Spiral { points: points.collect(), loop_width })
}

/// The holds from one side to the other, and those of the way back, the turning point in the first only.
fn ways(holds: &[Hold], same_rad: f64) -> Option<(&[Hold], &[Hold])> {
    let angles = || holds.iter().map(|hold| hold.rudder_rad);
    let (least, most) =
        (angles().fold(f64::INFINITY, f64::min), angles().fold(f64::NEG_INFINITY, f64::max));
    let first = |end: f64| angles().position(|angle| (angle - end).abs() <= same_rad);
    let (low, high) = (first(least)?, first(most)?);
    let (from, turn) = (low.min(high), low.max(high));
    let falls = high < low;
    let goes_on = |pair: &[Hold], falls: bool| (pair[1].rudder_rad < pair[0].rudder_rad) == falls;
    let there = &holds[from..=turn];
    let is_spiral = there.len() >= LEAST_ANGLES
        && least < 0.0
        && most > 0.0
        && there.windows(2).all(|pair| goes_on(pair, falls));
    let returned = holds[turn..].windows(2).take_while(|pair| goes_on(pair, !falls));
    let back = &holds[turn + 1..=turn + returned.count()];
    is_spiral.then_some((there, back))
}

fn spiral_loop(
    there: &[Hold],
    back: &[Hold],
    largest: f64,
    same_rad: f64,
) -> Result<SpiralLoop, NoManoeuvre> {
    let mut common: Vec<(f64, f64, bool)> = Vec::new();
    for a in there {
        let other = back.iter().find(|b| (a.rudder_rad - b.rudder_rad).abs() <= same_rad);
        let Some(b) = other else { continue };
        let difference = (a.yaw_rate_rad_s() - b.yaw_rate_rad_s()).abs();
        let noise = a.noise_beside_rad_s(b);
        let differs = difference > noise.max(SAME_RATE * largest);
        common.push((a.rudder_rad.abs(), difference, differs));
    }
    if !common.iter().any(|(_, _, differs)| *differs) {
        return Ok(SpiralLoop { width_rad: 0.0, height_rad_s: 0.0 });
    }
    let nearest = common.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let back_from_the_turn: Vec<Hold> = there.iter().rev().take(1).chain(back).cloned().collect();
    let [a, b] = [there, &back_from_the_turn].map(turns_over_rad);
    let (a, b) = a.zip(b).ok_or(NoManoeuvre::NoSpiral)?;
    Ok(SpiralLoop {
        width_rad: (a - b).abs(),
        height_rad_s: nearest.map_or(0.0, |(_, difference, _)| *difference),
    })
}

/// The middle of the two rudder angles between which the ship begins to turn to the other side, rad.
fn turns_over_rad(holds: &[Hold]) -> Option<f64> {
    let turns_over = |pair: &&[Hold]| pair[0].yaw_rate_rad_s() * pair[1].yaw_rate_rad_s() <= 0.0;
    let pair = holds.windows(2).find(turns_over)?;
    Some(0.5 * (pair[0].rudder_rad + pair[1].rudder_rad))
}

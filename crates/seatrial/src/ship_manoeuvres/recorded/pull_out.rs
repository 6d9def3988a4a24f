//! Pull-outs: the rudder goes amidships out of a steady turn.

use serde::Serialize;

use super::NoManoeuvre;
use super::holds::{Hold, largest_rad_s};

/// A rudder within this share of its largest angle turns the ship, below that it is amidships.
const TURNS: f64 = 0.5;
const AMIDSHIPS: f64 = 0.1;
/// Yaw rates from both sides that differ by less than this share of the turn's are one.
const SAME: f64 = 0.05;

/// The yaw rates that remain after the rudder has gone amidships.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PullOut {
    /// Out of a turn to starboard, rad/s.
    pub from_starboard_rad_s: Option<f64>,
    /// Out of a turn to port, rad/s.
    pub from_port_rad_s: Option<f64>,
    /// Is the ship straight-line stable? It is where the yaw rates from both sides become one: the rate that remains is then that of the
    /// rudder's offset. Absent where only one side is there.
    pub straight_line_stable: Option<bool>,
}

/// The pull-outs of a record, the last of each side.
pub(super) fn pull_out(holds: &[Hold], largest_rad: f64) -> Result<PullOut, NoManoeuvre> {
    let share = |hold: &Hold| hold.rudder_rad.abs() / largest_rad;
    let largest = largest_rad_s(holds);
    let (mut sides, mut errors) = ([None; 2], [0.0; 2]);
    let mut unsteady = None;
    for pair in holds.windows(2) {
        let (turn, after) = (&pair[0], &pair[1]);
        if share(turn) < TURNS || share(after) > AMIDSHIPS {
            continue;
        }
        let side = usize::from(turn.yaw_rate_rad_s() < 0.0);
        if after.is_steady(largest) {
            sides[side] = Some(after.yaw_rate_rad_s());
            errors[side] = after.error_rad_s();
        } else {
            unsteady = Some(NoManoeuvre::PullOutNotSteady);
        }
    }
    let [from_starboard_rad_s, from_port_rad_s] = sides;
    if sides == [None; 2] {
        return Err(unsteady.unwrap_or(NoManoeuvre::NoPullOut));
    }
    let difference = from_starboard_rad_s.zip(from_port_rad_s);
    let allowed = (SAME * largest).max(3.0 * libm::hypot(errors[0], errors[1]));
    Ok(PullOut {
        from_starboard_rad_s,
        from_port_rad_s,
        straight_line_stable: difference.map(|(a, b)| (a - b).abs() <= allowed),
    })
}

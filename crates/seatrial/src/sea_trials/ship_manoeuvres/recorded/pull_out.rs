//! Pull-outs: the rudder goes amidships out of a steady turn.

use serde::Serialize;

use super::NoManoeuvre;
use super::holds::{Hold, largest_rad_s};

/// A rudder of this share of its largest angle or more turns the ship.
const TURNS: f64 = 0.5;
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
    let largest = largest_rad_s(holds);
    let mut sides: [Option<&Hold>; 2] = [None; 2];
    let mut unsteady = None;
    for pair in holds.windows(2) {
        let (turn, after) = (&pair[0], &pair[1]);
        if turn.rudder_rad.abs() < TURNS * largest_rad || !after.is_amidships(largest_rad) {
            continue;
        }
        let side = usize::from(turn.yaw_rate_rad_s() < 0.0);
        if after.is_steady(largest) {
            sides[side] = Some(after);
        } else {
            unsteady = Some(NoManoeuvre::PullOutNotSteady);
        }
    }
    let [starboard, port] = sides;
    if starboard.or(port).is_none() {
        return Err(unsteady.unwrap_or(NoManoeuvre::NoPullOut));
    }
    Ok(PullOut {
        from_starboard_rad_s: starboard.map(Hold::yaw_rate_rad_s),
        from_port_rad_s: port.map(Hold::yaw_rate_rad_s),
        straight_line_stable: starboard.zip(port).map(|(a, b)| {
            let allowed = (SAME * largest).max(a.noise_beside_rad_s(b));
            (a.yaw_rate_rad_s() - b.yaw_rate_rad_s()).abs() <= allowed
        }),
    })
}

//! The steering gear: where the rudder is between its commands.

use super::hypothesis::Vehicle;
use super::leg::{Leg, PARTS};
use super::motion::decays;

/// A steering gear that lags, has a largest rate or has play.
#[derive(Clone)]
pub struct Gear {
    vehicle: Vehicle,
    /// A part, s, and what is left of a deflection over it, with its integrals.
    part_s: f64,
    left: [f64; 3],
    angle_rad: f64,
}

impl Gear {
    /// A vehicle's, at rest at an angle, rad.
    pub fn new(vehicle: &Vehicle, angle_rad: f64) -> Self {
        Self { vehicle: *vehicle, part_s: f64::NAN, left: [1.0, 0.0, 0.0], angle_rad }
    }

    /// The mean angle over a part, rad.
    pub fn advance(&mut self, command_rad: f64, part_s: f64) -> f64 {
        let Vehicle { lag_s, rate_limit_rad_s, play_rad, .. } = self.vehicle;
        let from = self.angle_rad;
        let half_rad = 0.5 * play_rad;
        let command_rad = match half_rad > 0.0 {
            true => from.clamp(command_rad - half_rad, command_rad + half_rad),
            false => command_rad,
        };
        let away = from - command_rad;
        let (next, mean) = match lag_s > 0.0 {
            true => {
                if part_s != self.part_s {
                    (self.part_s, self.left) = (part_s, decays(1.0 / lag_s, part_s));
                }
                let [left, once, _] = self.left;
                (command_rad + away * left, command_rad + away * once / part_s)
            }
            false => (command_rad, command_rad),
        };
        let most = rate_limit_rad_s * part_s;
        if (next - from).abs() > most {
            self.angle_rad = from + most.copysign(next - from);
            return 0.5 * (from + self.angle_rad);
        }
        self.angle_rad = next;
        if rate_limit_rad_s.is_finite() && lag_s == 0.0 {
            // The way there takes a share of the part.
            let way = (next - from).abs() / most;
            return next - 0.5 * way * (next - from);
        }
        mean
    }
}

/// Mean angles of the gear over parts of each interval between comparisons, rad. The gear starts at rest at the leg's beginning.
///
/// Of a thinned leg they are averaged as its headings are: the mean of headings follows the mean of angles.
pub fn angles(leg: &Leg, vehicle: &Vehicle) -> Vec<f64> {
    // Where a stroke begins matters to a gear that is not linear.
    let is_linear = vehicle.rate_limit_rad_s.is_infinite() && vehicle.play_rad == 0.0;
    let parts = if is_linear { PARTS } else { leg.fine_parts() };
    let commands = leg.commands(vehicle.shift_s, parts);
    let mut gear = Gear::new(vehicle, commands.first().copied().unwrap_or(0.0));
    let angles = leg.time_s.windows(2).zip(commands.chunks_exact(parts));
    let angles: Vec<f64> = angles
        .flat_map(|(pair, during)| {
            let part_s = (pair[1] - pair[0]) / parts as f64;
            during.iter().map(move |command| (*command, part_s))
        })
        .map(|(command, part_s)| gear.advance(command, part_s))
        .collect();
    leg.averaged(angles, parts)
}

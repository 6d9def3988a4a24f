//! A vehicle that runs free of any measurement: over a record, and in a heading step.

use super::gear::{Gear, angles};
use super::hypothesis::{Noise, Vehicle};
use super::leg::{Leg, PARTS, parts_of};
use super::motion::{Motion, Start, State};

/// Heading, yaw rate and sway at each comparison of a leg of a free-running vehicle; the fourth is 0.
pub fn simulate(leg: &Leg, vehicle: &Vehicle, start: &Start) -> Vec<State> {
    let angles = angles(leg, vehicle);
    let mut motion = Motion::new(vehicle, &Noise::NONE);
    let mut x = start.state();
    let mut states = Vec::with_capacity(leg.len());
    states.extend((!leg.is_empty()).then_some(x));
    let parts = parts_of(&angles, leg);
    for (pair, during) in leg.time_s.windows(2).zip(angles.chunks_exact(parts)) {
        motion.follow(&mut x, during, start.offset_rad_s2, pair[1] - pair[0]);
        states.push(x);
    }
    states
}

/// Overshoot of a heading step under proportional control, how far it is still off at the end, and how far it swings there, shares of
/// the step.
///
/// The controller sees the heading every `interval_s` and turns the rudder within `limit_rad`; it runs for 30 time constants, but at most
/// 6,000 intervals.
pub fn heading_step(
    vehicle: &Vehicle,
    gain: f64,
    step_rad: f64,
    limit_rad: f64,
    interval_s: f64,
) -> [f64; 3] {
    const LENGTH: f64 = 30.0;
    let slowest_s = 1.0 / vehicle.damping_per_s.abs().max(f64::MIN_POSITIVE);
    let of_loop_s = 1.0 / (gain * vehicle.authority_per_s2).abs().sqrt().max(f64::MIN_POSITIVE);
    let steps = (LENGTH * slowest_s.max(of_loop_s) / interval_s).clamp(100.0, 6_000.0) as usize;
    let part_s = interval_s / PARTS as f64;
    let mut gear = Gear::new(vehicle, 0.0);
    let mut motion = Motion::new(vehicle, &Noise::NONE);
    let mut x: State = [0.0; 4];
    let (mut most, mut off) = (0.0_f64, 0.0_f64);
    let [mut lowest, mut highest] = [f64::INFINITY, f64::NEG_INFINITY];
    for k in 0..steps {
        let command = (gain * (step_rad - x[0])).clamp(-limit_rad, limit_rad);
        for _ in 0..PARTS {
            let act = gear.advance(command, part_s);
            motion.follow(&mut x, &[act], 0.0, part_s);
        }
        most = most.max(x[0] - step_rad);
        if 4 * k > 3 * steps {
            off = off.max((x[0] - step_rad).abs());
            [lowest, highest] = [lowest.min(x[0]), highest.max(x[0])];
        }
    }
    [most, off, highest - lowest].map(|rad| rad / step_rad)
}

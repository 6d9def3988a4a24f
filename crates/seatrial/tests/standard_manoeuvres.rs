//! Zig-zag and spiral of the REMUS 100 against published models of it.
//!
//! Fossen: the REMUS 100 of his public Python Vehicle Simulator, unmodified, at 1220 rpm, which is 80 %, with the depth
//! controller used here. Prestero: the coefficients of his thesis (MIT/WHOI 2001, combined coefficients) in
//! sway and yaw, steady at 2.03 m/s. The two are far apart: Prestero's hull has a Munk moment and hardly drifts, Fossen's has
//! neither Munk moment nor lateral lift and drifts twice as much as this one.

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};
use seatrial_sim::SixDofVehicle;
use seatrial_sim::six_dof::remus100;

/// Rudder, then the steady yaw rate of Fossen and of Prestero, degrees and degrees per second.
const STEADY_TURNS: [[f64; 3]; 3] = [[14.9, 5.94, 19.97], [10.0, 4.49, 17.35], [5.0, 2.72, 14.05]];

const THRUST: f64 = 0.8;
/// Time for a steady course before each manoeuvre, s.
const SETTLE_S: f64 = 40.0;
/// Time on each rudder angle of the spiral, s; the mean of its last third counts.
const SPIRAL_STEP_S: f64 = 40.0;
/// Longest that a zig-zag may take, s.
const LONGEST_S: f64 = 600.0;

/// Steers by every sample for so many seconds, or until `steer` has no answer; the samples in order.
fn steer(
    vehicle: &mut SixDofVehicle,
    seconds: f64,
    mut steer: impl FnMut(&Sample<f64>) -> Option<Steering<f64>>,
) -> Vec<Sample<f64>> {
    let mut samples: Vec<Sample<f64>> = Vec::new();
    loop {
        let sample = vehicle.next_sample().unwrap().unwrap();
        samples.push(sample);
        let steering = match steer(&sample) {
            Some(steering) if sample.time_s - samples[0].time_s < seconds => steering,
            _ => return samples,
        };
        let thrust = Some(THRUST);
        let action = Action { steering, thrust, outcome: None };
        vehicle.act(&action).unwrap();
    }
}

/// Holds the heading of the first sample.
fn hold(vehicle: &mut SixDofVehicle) -> Vec<Sample<f64>> {
    let mut held_rad = None;
    steer(vehicle, SETTLE_S, |sample| {
        Some(Steering::HoldHeading(*held_rad.get_or_insert(sample.heading_rad)))
    })
}

/// Rudder to one side until the heading has changed by as much, then to the other, five times: the times of these changes from the
/// start, s, and the heading past the change of the second swing, rad.
fn zig_zag(vehicle: &mut SixDofVehicle, angle_rad: f64) -> (Vec<f64>, f64) {
    let (mut base_rad, mut side) = (None, 1.0);
    let (mut switches_s, mut turned) = (Vec::new(), Vec::new());
    let samples = steer(vehicle, LONGEST_S, |sample| {
        let base_rad = *base_rad.get_or_insert(sample.heading_rad);
        let turned_rad = (sample.heading_rad - base_rad).wrapped();
        turned.push((sample.time_s, turned_rad));
        if side * turned_rad >= angle_rad {
            side = -side;
            switches_s.push(sample.time_s);
        }
        (switches_s.len() < 5).then_some(Steering::Rudder(side * angle_rad))
    });
    let swing = turned.iter().filter(|(time_s, _)| (switches_s[1]..switches_s[2]).contains(time_s));
    let furthest_rad = swing.map(|(_, turned_rad)| turned_rad.abs()).fold(0.0, f64::max);
    let from_start = switches_s.iter().map(|time_s| time_s - samples[0].time_s);
    (from_start.collect(), furthest_rad - angle_rad)
}

/// The steady yaw rate at a rudder angle, rad/s.
fn steady_turn(vehicle: &mut SixDofVehicle, rudder_rad: f64) -> f64 {
    let samples = steer(vehicle, SPIRAL_STEP_S, |_| Some(Steering::Rudder(rudder_rad)));
    let settled = &samples[2 * samples.len() / 3..];
    let turns =
        settled.windows(2).map(|pair| (pair[1].heading_rad - pair[0].heading_rad).wrapped());
    turns.sum::<f64>() / (settled[settled.len() - 1].time_s - settled[0].time_s)
}

#[test]
fn val_remus_zig_zag_and_spiral() {
    let mut vehicle = SixDofVehicle::new(remus100::config().noise_free(), 1).unwrap();
    let rudders = [14.9, 10.0, 5.0, 2.0, 0.0, -2.0, -5.0, -10.0, -14.9].map(f64::to_radians);
    let course = hold(&mut vehicle);
    let later = course[course.len() / 2..].iter().map(|sample| sample.surge_speed_m_s.unwrap());
    let straight_m_s = later.clone().sum::<f64>() / later.len() as f64;
    // Fossen's 2.043 m/s.
    assert!((straight_m_s / 2.043 - 1.0).abs() < 0.01);

    // First turn and period, s, and the second overshoot, degrees, of Fossen.
    for (angle_deg, [first_s, period_s, overshoot_deg]) in
        [(10.0_f64, [1.97, 8.13, 0.79]), (20.0, [3.05, 12.73, 0.96])]
    {
        let (switches_s, overshoot_rad) = zig_zag(&mut vehicle, angle_deg.to_radians());
        println!("{angle_deg}: {switches_s:.3?} s, {overshoot_rad:.3} rad");
        hold(&mut vehicle);
        // 14 % is the largest measured: this hull turns faster, as below.
        assert!((switches_s[0] / first_s - 1.0).abs() < 0.17);
        assert!(((switches_s[2] - switches_s[0]) / period_s - 1.0).abs() < 0.17);
        // Faster turns have further to go until the rudder is over: up to 2.5 degrees more.
        let overshoot = overshoot_rad.to_degrees();
        assert!((overshoot_deg..overshoot_deg + 3.0).contains(&overshoot), "{overshoot}");
    }

    let there = rudders.map(|rudder_rad| steady_turn(&mut vehicle, rudder_rad));
    let back =
        rudders.iter().rev().skip(1).map(|rudder_rad| steady_turn(&mut vehicle, *rudder_rad));
    let back: Vec<f64> = back.collect();
    for [rudder_deg, fossen, prestero] in STEADY_TURNS {
        let at = rudders
            .iter()
            .position(|rudder_rad| (rudder_rad.to_degrees() - rudder_deg).abs() < 1e-9);
        let rate = there[at.unwrap()].to_degrees();
        println!("{rudder_deg}: {rate:.2} deg/s");
        assert!((fossen..prestero).contains(&rate), "{rudder_deg}: {rate}");
        // 37 to 43 % above the model whose logs it was fitted to, in the middle of a doublet.
        assert!(rate < 1.5 * fossen, "{rudder_deg}: {rate}");
    }
    // Stable on its course: no loop, and the turn follows the rudder.
    for (there, back) in there.iter().rev().skip(1).zip(back) {
        // Depth and roll still swing by as much.
        assert!((there - back).abs() < 1e-3, "{there:?} {back:?}");
    }
    assert!(there.windows(2).all(|pair| pair[1] < pair[0]));
}

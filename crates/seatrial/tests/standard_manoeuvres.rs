//! Zig-zag and spiral of the REMUS 100 against published models of it.
//!
//! Fossen: the REMUS 100 of his public Python Vehicle Simulator, unmodified, at 1220 rpm, which is 80 %, with the depth
//! controller used here. Prestero: the coefficients of his thesis (MIT/WHOI 2001, combined coefficients) in
//! sway and yaw, steady at 2.03 m/s. The two are far apart: Prestero's hull has a Munk moment and hardly drifts, Fossen's has
//! neither Munk moment nor lateral lift and drifts twice as much as this one.

use seatrial::sea_trials::field::StandardManoeuvres;
use seatrial_sim::SixDofVehicle;
use seatrial_sim::six_dof::remus100;

/// Rudder, then the steady yaw rate of Fossen and of Prestero, degrees and degrees per second.
const STEADY_TURNS: [[f64; 3]; 3] = [[14.9, 5.94, 19.97], [10.0, 4.49, 17.35], [5.0, 2.72, 14.05]];

#[test]
fn val_remus_zig_zag_and_spiral() {
    let mut vehicle = SixDofVehicle::new(remus100::config().noise_free(), 1).unwrap();
    let rudders = [14.9, 10.0, 5.0, 2.0, 0.0, -2.0, -5.0, -10.0, -14.9].map(f64::to_radians);
    let made = StandardManoeuvres::make(&mut vehicle, 0.8, &rudders).unwrap();
    // Fossen's 2.043 m/s.
    assert!((made.straight_speed_m_s / 2.043 - 1.0).abs() < 0.01);

    // First turn and period, s, and the second overshoot, degrees, of Fossen.
    for (zig_zag, [first_s, period_s, overshoot_deg]) in made
        .zig_zags
        .iter()
        .zip([[1.97, 8.13, 0.79], [3.05, 12.73, 0.96]])
    {
        println!(
            "{zig_zag:.3?}",
            zig_zag = (
                zig_zag.initial_turning_time_s,
                zig_zag.period_s,
                &zig_zag.overshoots_rad
            )
        );
        // 14 % is the largest measured: this hull turns faster, as below.
        assert!((zig_zag.initial_turning_time_s / first_s - 1.0).abs() < 0.17);
        assert!((zig_zag.period_s / period_s - 1.0).abs() < 0.17);
        // Faster turns have further to go until the rudder is over: up to 2.5 degrees more.
        let overshoot = zig_zag.overshoots_rad[1].to_degrees();
        assert!(
            (overshoot_deg..overshoot_deg + 3.0).contains(&overshoot),
            "{overshoot}"
        );
    }

    let (there, back) = made.spiral.split_at(rudders.len());
    for [rudder_deg, fossen, prestero] in STEADY_TURNS {
        let at = there
            .iter()
            .find(|p| (p.rudder_rad.to_degrees() - rudder_deg).abs() < 1e-9);
        let rate = at.unwrap().yaw_rate_rad_s.to_degrees();
        println!("{rudder_deg}: {rate:.2} deg/s");
        assert!((fossen..prestero).contains(&rate), "{rudder_deg}: {rate}");
        // 37 to 43 % above the model whose logs it was fitted to, in the middle of a doublet.
        assert!(rate < 1.5 * fossen, "{rudder_deg}: {rate}");
    }
    // Stable on its course: no loop, and the turn follows the rudder.
    for (there, back) in there.iter().rev().skip(1).zip(back) {
        // Depth and roll still swing by as much.
        let loop_rad_s = (there.yaw_rate_rad_s - back.yaw_rate_rad_s).abs();
        assert!(loop_rad_s < 1e-3, "{there:?} {back:?}");
    }
    assert!(
        there
            .windows(2)
            .all(|pair| pair[1].yaw_rate_rad_s < pair[0].yaw_rate_rad_s)
    );
}

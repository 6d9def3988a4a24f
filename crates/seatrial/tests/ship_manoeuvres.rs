//! Figures and criteria of the standard manoeuvres of ships.

use seatrial::sea_trials::ship_manoeuvres::{Instant, TurningCircle, ZigZag, criteria};
use seatrial_core::Side;

/// A point on a circle of this radius to starboard after an angle.
fn on_circle(radius_m: f64, course_rad: f64, angle_rad: f64) -> Instant {
    let [ahead, aside] = [radius_m * angle_rad.sin(), radius_m * (1.0 - angle_rad.cos())];
    let (sin, cos) = course_rad.sin_cos();
    Instant {
        time_s: 100.0 + 10.0 * angle_rad,
        heading_rad: course_rad + angle_rad,
        surge_speed_m_s: radius_m / 10.0,
        north_m: 5.0 + ahead * cos - aside * sin,
        east_m: -7.0 + ahead * sin + aside * cos,
    }
}

#[test]
fn exact_a_circle_has_its_radius_as_advance_and_transfer() {
    let track: Vec<Instant> =
        (0..800).map(|k| on_circle(30.0, 2.0, 0.005 * f64::from(k))).collect();
    let circle = TurningCircle::of(&track, 0.6).unwrap();
    // The chord of 0.005 rad against its arc.
    assert!((circle.advance_m - 30.0).abs() < 1e-3, "{circle:?}");
    assert!((circle.transfer_m - 30.0).abs() < 1e-3, "{circle:?}");
    assert!((circle.tactical_diameter_m - 60.0).abs() < 1e-3, "{circle:?}");
    assert!((circle.times_s[1] - 10.0 * std::f64::consts::PI).abs() < 1e-6);
    assert_eq!(circle.side, Side::Starboard);
    assert_eq!(TurningCircle::of(&track[..600], 0.6), None);
}

#[test]
fn exact_overshoots_count_from_the_heading_of_the_order() {
    let heading = [0.0, 0.1, 0.2, 0.25, 0.2, 0.0, -0.2, -0.28, -0.2, 0.0, 0.2];
    let track: Vec<Instant> = heading
        .iter()
        .enumerate()
        .map(|(k, heading)| Instant {
            time_s: k as f64,
            heading_rad: 3.0 + heading,
            surge_speed_m_s: 1.0,
            north_m: k as f64,
            east_m: 0.0,
        })
        .collect();
    let zig_zag = ZigZag::of(&track, &[0, 2, 6, 10], 0.2).unwrap();
    assert!((zig_zag.heading_rad - 0.2).abs() < 1e-12);
    assert_eq!(zig_zag.first_side, Side::Starboard);
    assert!(zig_zag.is_of(11.0) && !zig_zag.is_of(20.0));
    assert_eq!(zig_zag.initial_turning_time_s, 2.0);
    assert_eq!(zig_zag.initial_turning_track_m, 2.0);
    assert_eq!(zig_zag.period_s, Some(8.0));
    for (found, expected) in zig_zag.overshoots_rad.iter().zip([0.05, 0.08]) {
        assert!((found - expected).abs() < 1e-12);
    }
    assert_eq!(ZigZag::of(&track, &[0, 2], 0.2), None);

    // From the middle of it: the first heading is one of those at which the rudder is ordered over later.
    let heading = [-0.2, -0.28, 0.0, 0.2, 0.25, 0.0, -0.2, -0.27, 0.0, 0.2, 0.26];
    let track: Vec<Instant> = (track.iter().zip(heading))
        .map(|(at, heading)| Instant { heading_rad: 3.0 + heading, ..*at })
        .collect();
    let from_the_middle = ZigZag::of(&track, &[0, 3, 6, 9], 0.2).unwrap();
    for (found, expected) in from_the_middle.overshoots_rad.iter().zip([0.05, 0.07]) {
        assert!((found - expected).abs() < 1e-12, "{from_the_middle:?}");
    }
}

fn zig_zag(first_deg: f64, second_deg: f64) -> ZigZag {
    ZigZag {
        rudder_rad: 10_f64.to_radians(),
        heading_rad: 10_f64.to_radians(),
        first_side: Side::Starboard,
        initial_turning_time_s: 20.0,
        initial_turning_track_m: 300.0,
        overshoots_rad: vec![first_deg.to_radians(), second_deg.to_radians()],
        period_s: None,
    }
}

/// The limits of a short, a middle and a long ship, by the resolution's own formulas.
#[test]
fn val_imo_limits_of_overshoots() {
    for (length_m, speed_m_s, first, second) in
        [(90.0, 10.0, 10.0, 25.0), (200.0, 10.0, 15.0, 32.5), (320.0, 8.0, 20.0, 40.0)]
    {
        let ten = zig_zag(12.0, 30.0);
        let found = criteria(length_m, speed_m_s, [Some(&ten), Some(&ten)], &[]);
        let limits: Vec<f64> = found.iter().map(|c| c.limit).collect();
        // Rounding of degrees.
        let expected = [2.5, first, second, 25.0];
        assert!(limits.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        assert_eq!(found[1].holds, 12.0 <= first);
        assert_eq!(found[2].holds, 30.0 <= second);
        assert!(found[3].holds);
    }
}

#[test]
fn val_imo_limits_of_a_turning_circle() {
    let circle = TurningCircle {
        side: Side::Port,
        rudder_rad: 0.6,
        advance_m: 460.0,
        transfer_m: 200.0,
        tactical_diameter_m: 490.0,
        times_s: [60.0, 120.0],
    };
    let found = criteria(100.0, 8.0, [None, None], &[circle]);
    assert_eq!(found.len(), 2);
    assert!(!found[0].holds && found[1].holds, "{found:?}");
}

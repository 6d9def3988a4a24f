use super::*;

fn boat() -> IdentifiedVehicle {
    let at = |thrust: f64| IdentifiedSpeed {
        thrust,
        surge_speed_m_s: 2.0 * thrust,
        a22_per_s: -1.1,
        b2_per_s2: 1.3,
        c0_rad_per_s2: 0.01,
        covariance: Some([[0.04, -0.03, 0.0], [-0.03, 0.09, 0.0], [0.0, 0.0, 1e-6]]),
        seen_rudder_rad: Some(0.2),
    };
    IdentifiedVehicle {
        schema: SCHEMA.into(),
        name: "boat".into(),
        sample_interval_s: Some(0.1),
        rudder: Rudder { limit_rad: 0.5, lag_s: 0.15, delay_s: 0.2, rate_limit_rad_s: Some(0.6) },
        surge: SurgeLaw {
            time_constant_s: 3.0,
            drag_length_m: Some(8.0),
            turning_drag_m: Some(0.5),
        },
        noise: Some(NoiseEstimate {
            heading_rad: 0.01,
            disturbance_rad_s2: 0.004,
            disturbance_time_s: Some(2.0),
        }),
        speeds: vec![at(0.5), at(0.9)],
        provenance: Provenance {
            source: "seatrial.db, campaign 3".into(),
            assumptions: vec!["the thrust".into()],
            ..Provenance::default()
        },
    }
}

#[test]
fn io_a_vehicle_survives_its_own_file() {
    let text = boat().to_toml().unwrap();
    assert_eq!(IdentifiedVehicle::from_toml(&text).unwrap(), boat());
    let text = boat().to_json().unwrap();
    assert_eq!(IdentifiedVehicle::from_json(&text).unwrap(), boat());
    assert!(text.contains("\"schema\": \"seatrial.vehicle.v1\""), "{text}");
}

#[test]
fn exact_the_twin_has_every_number_of_the_file() {
    let twin = boat().twin();
    twin.check().unwrap();
    assert_eq!(twin.rudder_limit_rad, 0.5);
    assert_eq!(twin.rudder_delay_s, 0.2);
    assert_eq!(twin.servo.time_constant_s, 0.15);
    assert_eq!(twin.servo.rate_limit_rad_s, Some(0.6));
    assert_eq!(twin.surge_drag.unwrap().drag_length_m, 8.0);
    assert_eq!(twin.sensors.compass.noise_rad, 0.01);
    assert_eq!(twin.disturbance.standard_deviation_rad_s2, 0.004);
    assert_eq!(twin.timing.sample_interval_s, 0.1);
    assert_eq!(twin.speeds[1].b2_per_s2, 1.3);
    let reversed = |mut vehicle: IdentifiedVehicle| {
        vehicle.speeds.iter_mut().for_each(|p| p.b2_per_s2 *= -1.0);
        vehicle.twin().heading_hold.gain
    };
    assert_eq!(reversed(boat()), -twin.heading_hold.gain);
    assert!(twin.heading_hold.gain > 0.0);
}

#[test]
fn recover_draws_have_the_covariance() {
    let mut boat = boat();
    let covariance = [[0.0004, -0.0003, 1e-6], [-0.0003, 0.0009, 0.0], [1e-6, 0.0, 1e-6]];
    boat.speeds[0].covariance = Some(covariance);
    boat.speeds[1].covariance = None;
    let centre = boat.speeds[0].model().theta();
    let draws: Vec<[f64; 3]> = (0..4000)
        .map(|seed| {
            let drawn = boat.drawn(seed);
            drawn.check().unwrap();
            assert_eq!(drawn.speeds[1], boat.speeds[1]);
            let theta = drawn.speeds[0].model().theta();
            std::array::from_fn(|i| theta[i] - centre[i])
        })
        .collect();
    for i in 0..3 {
        for j in 0..3 {
            let found = draws.iter().map(|d| d[i] * d[j]).sum::<f64>() / 4000.0;
            let most = (covariance[i][i] * covariance[j][j]).sqrt();
            // A mean of 4000 products is known to 1.4 to 2.2 %: four times that.
            assert!((found - covariance[i][j]).abs() < 0.09 * most, "{i} {j} {found}");
        }
    }
    assert_eq!(boat.drawn(7), boat.drawn(7));
}

#[test]
fn io_faults_name_the_field_and_what_was_found() {
    type Break = fn(&mut IdentifiedVehicle);
    let cases: [(Break, &str); 20] = [
        (|v| v.schema = "seatrial.vehicle.v9".into(), "schema must be"),
        (|v| v.sample_interval_s = Some(0.0), "sample_interval_s must be"),
        (
            |v| v.rudder.limit_rad = 14.9,
            "rudder.limit_rad must be an angle from 0.001 to 1.5708 rad, not 14.9",
        ),
        (|v| v.rudder.lag_s = -0.1, "rudder.lag_s must be"),
        (|v| v.rudder.delay_s = f64::NAN, "rudder.delay_s must be"),
        (|v| v.rudder.rate_limit_rad_s = Some(0.0), "rudder.rate_limit_rad_s must be"),
        (|v| v.surge.time_constant_s = 0.0, "surge.time_constant_s must be"),
        (|v| v.surge.drag_length_m = Some(0.0), "surge.drag_length_m must be"),
        (|v| v.surge.turning_drag_m = Some(-1.0), "surge.turning_drag_m must be"),
        (|v| v.noise.as_mut().unwrap().heading_rad = 2.0, "noise.heading_rad must be"),
        (
            |v| v.noise.as_mut().unwrap().disturbance_rad_s2 = -1.0,
            "noise.disturbance_rad_s2 must be",
        ),
        (
            |v| v.noise.as_mut().unwrap().disturbance_time_s = Some(0.0),
            "noise.disturbance_time_s must be",
        ),
        (|v| v.surge.drag_length_m = Some(0.02), "surge.drag_length_m must be at least the way"),
        (|v| v.speeds.clear(), "speed must be"),
        (|v| v.speeds[0].thrust = 60.0, "speed[0].thrust must be"),
        (|v| v.speeds.reverse(), "speed[1].thrust must be"),
        (|v| v.speeds[1].b2_per_s2 = 0.0, "speed[1].b2_per_s2 must be"),
        (|v| v.speeds[1].a22_per_s = f64::INFINITY, "speed[1].a22_per_s must be"),
        (|v| v.speeds[1].seen_rudder_rad = Some(9.0), "speed[1].seen_rudder_rad must be"),
        (|v| v.speeds[0].covariance.as_mut().unwrap()[0][1] = 0.07, "speed[0].covariance must be"),
    ];
    for (spoil, expected) in cases {
        let mut vehicle = boat();
        spoil(&mut vehicle);
        let message = vehicle.check().unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}");
    }
    let text = format!("keel = 1\n{}", boat().to_toml().unwrap());
    let message = IdentifiedVehicle::from_toml(&text).unwrap_err().to_string();
    assert!(message.contains("unknown field `keel`"), "{message}");
    let json = boat().to_json().unwrap();
    for (from, to, expected) in [
        ("\"limit_rad\": 0.5", "\"limit_rad\": 14.9", "rudder.limit_rad must be"),
        ("vehicle.v1", "vehicle.v2", "schema must be"),
        ("\"name\"", "\"keel\": 1, \"name\"", "unknown field `keel`"),
    ] {
        let spoilt = json.replacen(from, to, 1);
        let message = IdentifiedVehicle::from_json(&spoilt).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// Between two speeds the vehicle is the one that a schedule of gains is made of.
#[test]
fn parity_the_twin_is_a_schedule_between_its_speeds() {
    use seatrial_core::schedule::{Beyond, ScheduleKey};
    use seatrial_core::{SchedulePoint, SpeedSchedule};
    let boat = boat();
    let point = |speed: &IdentifiedSpeed| SchedulePoint {
        thrust: Some(speed.thrust),
        surge_speed_m_s: Some(speed.surge_speed_m_s),
        model: speed.model(),
    };
    let points: Vec<_> = boat.speeds.iter().map(point).collect();
    let schedule = SpeedSchedule::new(ScheduleKey::Speed, &points).unwrap();
    let [slow, fast] = [0, 1].map(|k| boat.speeds[k].surge_speed_m_s);
    for share in [0.0, 0.3, 0.5, 1.0] {
        let speed_m_s = slow + share * (fast - slow);
        let found = schedule.lookup(speed_m_s, Beyond::Refuse).unwrap();
        let expected = found.value().model.theta();
        let twin = boat.plant(0.5).yaw_model(speed_m_s).theta();
        for (twin, expected) in twin.iter().zip(expected) {
            // Two ways to round.
            assert!((twin - expected).abs() < 1e-14, "{share}: {twin} {expected}");
        }
    }
}

use super::*;

/// Thrust, speed and [a22, b2, C0] of Table II.
pub(crate) const TABLE_II: [(f64, f64, [f64; 3]); 5] = [
    (0.6, 1.07, [-0.95, 0.60, 0.0072]),
    (0.7, 1.36, [-1.12, 0.87, 0.0107]),
    (0.8, 1.63, [-1.07, 1.08, 0.0120]),
    (0.9, 1.92, [-1.14, 1.37, 0.0054]),
    (1.0, 2.19, [-1.21, 1.77, 0.0049]),
];

pub(crate) fn points<T: Real>(table: &[(f64, f64, [f64; 3]); 5]) -> [SchedulePoint<T>; 5] {
    table.map(|(thrust, speed, theta)| SchedulePoint {
        thrust: Some(T::of(thrust)),
        surge_speed_m_s: Some(T::of(speed)),
        model: YawModel::from_theta(theta.map(T::of)),
    })
}

fn by_thrust() -> SpeedSchedule<f64> {
    SpeedSchedule::new(ScheduleKey::Thrust, &points(&TABLE_II)).unwrap()
}

#[test]
fn exact_points_are_returned_as_given_in_any_order() {
    let mut shuffled = points::<f64>(&TABLE_II);
    shuffled.swap(0, 3);
    shuffled.swap(1, 4);
    for key in [ScheduleKey::Thrust, ScheduleKey::Speed] {
        let schedule = SpeedSchedule::new(key, &shuffled).unwrap();
        for point in points::<f64>(&TABLE_II) {
            let found = schedule.lookup(point.key(key).unwrap(), Beyond::Refuse).unwrap();
            assert!(!found.is_extrapolated());
            for (a, b) in found.value().model.theta().iter().zip(point.model.theta()) {
                // One rounding of the interpolation.
                assert!((a - b).abs() < 1e-15);
            }
        }
    }
}

#[test]
fn exact_b2_between_points_in_speed_squared_and_linearly_without_a_speed() {
    let middle = by_thrust().lookup(0.65, Beyond::Refuse).unwrap();
    let point = middle.value();
    let speed: f64 = (1.07 + 1.36) / 2.0;
    assert!((point.surge_speed_m_s.unwrap() - speed).abs() < 1e-15);
    assert!((point.model.a22_per_s + 1.035).abs() < 1e-15);
    let fraction = (speed * speed - 1.07 * 1.07) / (1.36 * 1.36 - 1.07 * 1.07);
    // A handful of roundings on numbers of order 1, here and below.
    assert!((point.model.b2_per_s2 - (0.60 + 0.27 * fraction)).abs() < 1e-14);

    let mut without_speed = points::<f64>(&TABLE_II);
    for point in &mut without_speed {
        point.surge_speed_m_s = None;
    }
    let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &without_speed).unwrap();
    let found = *schedule.lookup(0.65, Beyond::Refuse).unwrap().value();
    assert_eq!(found.surge_speed_m_s, None);
    assert!((found.model.b2_per_s2 - 0.735).abs() < 1e-15);
}

#[test]
fn exact_extrapolation_is_refused_or_marked() {
    let schedule = by_thrust();
    assert!(matches!(
        schedule.lookup(0.5, Beyond::Refuse),
        Err(ScheduleError::Outside { from, to, .. }) if from == 0.6 && to == 1.0
    ));
    for (at, a22) in [(0.5, -0.78), (1.1, -1.28)] {
        let found = schedule.lookup(at, Beyond::Extrapolate).unwrap();
        assert!(found.is_extrapolated());
        assert!((found.value().model.a22_per_s - a22).abs() < 1e-14);
    }
    assert!(!schedule.lookup(0.6, Beyond::Extrapolate).unwrap().is_extrapolated());
    assert!(matches!(schedule.lookup(0.2, Beyond::Extrapolate), Err(ScheduleError::TooFar { .. })));
    for at in [f64::NAN, f64::INFINITY, -0.1] {
        assert_eq!(schedule.lookup(at, Beyond::Extrapolate), Err(ScheduleError::InvalidKey));
    }
}

#[test]
fn exact_bad_points_are_named() {
    let good = points::<f64>(&TABLE_II);
    let new = |points: &[SchedulePoint<f64>]| SpeedSchedule::new(ScheduleKey::Speed, points);
    assert_eq!(new(&good[..1]).unwrap_err(), ScheduleError::TooFewPoints { found: 1, needed: 2 });
    assert_eq!(new(&[good[0]; 17]).unwrap_err(), ScheduleError::TooManyPoints { found: 17 });
    assert_eq!(
        new(&[good[0], good[1], good[0]]).unwrap_err(),
        ScheduleError::DuplicateKey { at: 1.07 }
    );
    let mut bad = good;
    bad[3].model.b2_per_s2 = f64::NAN;
    assert_eq!(new(&bad).unwrap_err(), ScheduleError::NonFinite { index: 3 });
    let mut bad = good;
    bad[2].surge_speed_m_s = None;
    assert!(matches!(new(&bad).unwrap_err(), ScheduleError::MissingKey { index: 2, .. }));
}

#[test]
fn parity_f32_schedule() {
    let single = SpeedSchedule::<f32>::new(ScheduleKey::Speed, &points(&TABLE_II)).unwrap();
    let double = SpeedSchedule::<f64>::new(ScheduleKey::Speed, &points(&TABLE_II)).unwrap();
    let single = single.lookup(1.5, Beyond::Refuse).unwrap();
    let double = double.lookup(1.5, Beyond::Refuse).unwrap();
    for (a, b) in single.value().model.theta().iter().zip(double.value().model.theta()) {
        // A few roundings of f32 on numbers of order 1.
        assert!((f64::from(*a) - b).abs() < 1e-6);
    }
}

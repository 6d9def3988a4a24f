//! Every sensor's noise, errors, rate and latency.

use seatrial_core::{Action, Real, Sample, Steering, Vehicle};
use seatrial_sim::sensors::Sensors;
use seatrial_sim::six_dof::sea::Bottom;
use seatrial_sim::six_dof::starfish;
use seatrial_sim::{FirstOrderVehicle, SixDofVehicle, VehicleConfig};

/// Samples of a vehicle that turns under a constant rudder.
fn turning<V: Vehicle<f64, Error = std::convert::Infallible>>(
    mut vehicle: V,
    count: usize,
) -> Vec<Sample<f64>> {
    (0..count)
        .map(|_| {
            let Ok(sample) = vehicle.next_sample();
            let Ok(()) = vehicle.act(&Action {
                steering: Steering::Rudder(0.2),
                thrust: Some(0.6),
                outcome: None,
            });
            sample.unwrap()
        })
        .collect()
}

/// The noise-free Starfish of first order with these sensors.
fn with(change: impl FnOnce(&mut Sensors)) -> Vec<Sample<f64>> {
    let mut config = VehicleConfig::starfish().noise_free();
    // What it measures does not steer it.
    config.heading_hold.gain = 0.0;
    change(&mut config.sensors);
    turning(FirstOrderVehicle::new(config, 1).unwrap(), 1200)
}

#[test]
fn exact_a_latency_is_the_past() {
    let exact = with(|_| {});
    let late = with(|sensors| {
        sensors.compass.latency_s = 0.2;
        sensors.gyro.latency_s = 0.1;
        sensors.dvl.latency_s = 0.05;
    });
    for k in 4..exact.len() {
        // Four, two and one samples ago; the instants are equal but for rounding, and the turn is under 0.2 rad/s.
        let error = Real::wrapped(late[k].heading_rad - exact[k - 4].heading_rad);
        assert!(error.abs() < 1e-12, "{error}");
        let rates = [late[k].yaw_rate_rad_s, exact[k - 2].yaw_rate_rad_s].map(Option::unwrap);
        assert!((rates[0] - rates[1]).abs() < 1e-12);
        let speeds = [late[k].surge_speed_m_s, exact[k - 1].surge_speed_m_s].map(Option::unwrap);
        assert!((speeds[0] - speeds[1]).abs() < 1e-12);
    }
}

#[test]
fn exact_a_slow_sensor_stands_between_its_readings() {
    let exact = with(|_| {});
    let slow = with(|sensors| {
        sensors.compass.interval_s = 0.2;
        sensors.gyro.interval_s = 1.0;
    });
    for k in 0..exact.len() {
        assert_eq!(slow[k].heading_rad, slow[k - k % 4].heading_rad);
        assert_eq!(slow[k].yaw_rate_rad_s, slow[k - k % 20].yaw_rate_rad_s);
        // Rounding of the instant, times the rate of the turn.
        let error = Real::wrapped(slow[k].heading_rad - exact[k - k % 4].heading_rad);
        assert!(error.abs() < 1e-12);
    }
}

#[test]
fn exact_the_compass_lags_deviates_and_declines() {
    let exact = with(|_| {});
    let lagging = with(|sensors| sensors.compass.lag_s = 0.5);
    let last = exact.len() - 1;
    // In the end a steady turn is behind by rate times lag.
    let behind = Real::wrapped(exact[last].heading_rad - lagging[last].heading_rad);
    let rate_rad_s = exact[last].yaw_rate_rad_s.unwrap();
    assert!((behind - 0.5 * rate_rad_s).abs() < 1e-6, "{behind}");
    let [a, b, c, d, e] = [0.01, 0.05, -0.03, 0.02, 0.015];
    let deviating = with(|sensors| {
        sensors.compass.deviation_rad = [a, b, c, d, e];
        sensors.compass.declination_rad = 0.1;
    });
    for (exact, deviating) in exact.iter().zip(&deviating) {
        let m = exact.heading_rad - 0.1;
        let curve = a + b * m.sin() + c * m.cos() + d * (2.0 * m).sin() + e * (2.0 * m).cos();
        assert!(Real::wrapped(deviating.heading_rad - m - curve).abs() < 1e-12);
    }
}

#[test]
fn exact_steps_and_biases() {
    let step = 1_f64.to_radians();
    let exact = with(|_| {});
    let coarse = with(|sensors| {
        sensors.compass.resolution_rad = step;
        sensors.gyro.bias_rad_s = 0.01;
        sensors.pressure.bias_m = 0.3;
    });
    for (exact, coarse) in exact.iter().zip(&coarse) {
        let steps = coarse.heading_rad / step;
        assert!((steps - steps.round()).abs() < 1e-9);
        let error = Real::wrapped(coarse.heading_rad - exact.heading_rad);
        assert!(error.abs() <= 0.5 * step + 1e-12);
        let rates = [coarse.yaw_rate_rad_s, exact.yaw_rate_rad_s].map(Option::unwrap);
        assert!((rates[0] - rates[1] - 0.01).abs() < 1e-15);
        let depths = [coarse.depth_m, exact.depth_m].map(Option::unwrap);
        assert!((depths[0] - depths[1] - 0.3).abs() < 1e-12);
    }
}

#[test]
fn recover_the_bias_of_a_gyro_walks() {
    let walk = 0.002;
    let exact = with(|_| {});
    let ends: Vec<f64> = (0..200)
        .map(|seed| {
            let mut config = VehicleConfig::starfish().noise_free();
            config.sensors.gyro.bias_walk_rad_s_sqrt_s = walk;
            let walked = turning(FirstOrderVehicle::new(config, seed).unwrap(), 201);
            walked[200].yaw_rate_rad_s.unwrap() - exact[200].yaw_rate_rad_s.unwrap()
        })
        .collect();
    let rms = (ends.iter().map(|x| x * x).sum::<f64>() / 200.0).sqrt();
    // sqrt(10 s) times the walk; 200 seeds know it to 5 %, four times that is allowed.
    assert!((rms / (walk * 10.0_f64.sqrt()) - 1.0).abs() < 0.2, "{rms}");
}

#[test]
fn recover_dropouts_of_the_dvl_are_as_many_as_asked_for() {
    let taken = with(|sensors| sensors.dvl.dropout_fraction = 0.3);
    let lost = taken.iter().filter(|s| s.surge_speed_m_s.is_none()).count();
    // 1200 draws: standard deviation 1.3 %, four times that is allowed.
    let share = lost as f64 / taken.len() as f64;
    assert!((share - 0.3).abs() < 0.053, "{share}");
    assert!(taken.iter().all(|sample| sample.depth_m.is_some()));
}

#[test]
fn exact_the_dvl_sees_the_bottom_within_its_range() {
    let mut config = starfish::config().noise_free();
    config.helm.sensors.dvl.range_m = Some([0.5, 5.0]);
    config.sea.bottom = Some(Bottom { depth_m: 6.5, slope_north: 0.0, slope_east: 0.1 });
    // It turns on a circle of some 9 m radius over a bottom that is up to 2 m deeper at its far side.
    let taken = turning(SixDofVehicle::new(config, 1).unwrap(), 1200);
    let sees = |sample: &&Sample<f64>| sample.altitude_m.is_some();
    assert!((1..taken.len()).contains(&taken.iter().filter(sees).count()));
    for sample in taken {
        let altitude_m = 6.5 + 0.1 * sample.east_m.unwrap() - sample.depth_m.unwrap();
        assert_eq!(sample.altitude_m.is_some(), altitude_m <= 5.0);
        assert_eq!(sample.altitude_m.is_some(), sample.surge_speed_m_s.is_some());
    }
    let mut bottomless = starfish::config().noise_free();
    bottomless.helm.sensors.dvl.range_m = Some([0.5, 5.0]);
    let taken = turning(SixDofVehicle::new(bottomless, 1).unwrap(), 20);
    assert!(taken.iter().all(|sample| sample.surge_speed_m_s.is_none()));
}

//! The surge of a trial with intervals, against vehicles whose surge is known.

use seatrial::Campaign;
use seatrial::motions::surge::SurgeEstimate;
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::{List, Plan};
use seatrial_sim::{IdentifiedVehicle, SimulatedConfig};

const BOAT: &str = r#"
schema = "seatrial.vehicle.v1"
name = "boat"
sample_interval_s = 0.1
[rudder]
limit_rad = 0.5
[surge]
time_constant_s = 2.5
drag_length_m = 8.0
turning_drag_m = 0.5
[[speed]]
thrust = 0.5
surge_speed_m_s = 1.0
a22_per_s = -1.0
b2_per_s2 = 0.7
c0_rad_per_s2 = 0.01
[[speed]]
thrust = 1.0
surge_speed_m_s = 2.2
a22_per_s = -1.3
b2_per_s2 = 1.6
c0_rad_per_s2 = 0.005
"#;

fn boat() -> SimulatedConfig {
    let twin = IdentifiedVehicle::from_toml(BOAT).unwrap().twin();
    SimulatedConfig::FirstOrder(Box::new(twin))
}

fn estimate(config: &SimulatedConfig, thrusts: &[f64]) -> SurgeEstimate {
    let plan = Plan { thrusts: List::from_slice(thrusts).unwrap(), ..Plan::paper() };
    let about = Campaign { seed: Some(1), ..Campaign::of("sim", &plan) };
    let mut vehicle = config.vehicle(1).unwrap();
    let conducted = conduct(&mut vehicle, plan, about, &mut NoWatch).unwrap();
    SurgeEstimate::of(&conducted.campaign).unwrap()
}

/// Without noise every number of the file is found: 2.4 m/s a thrust beyond a dead band of 1/12.
#[test]
fn recover_the_surge_of_a_vehicle_file() {
    let surge = estimate(&boat().noise_free(), &[0.6, 0.8, 1.0]);
    let is = |found: &seatrial::motions::surge::Coefficient, expected: f64, within: f64| {
        let value = found.value.unwrap();
        assert!((value - expected).abs() < within, "{value} {expected}\n{surge:#?}");
    };
    is(&surge.speed_per_thrust_m_s, 2.4, 1e-3);
    is(&surge.dead_band, 1.0 / 12.0, 1e-3);
    // The thrust changes up to a sample after the run begins, 0.1 s, which the fit takes for a lag.
    is(&surge.drag_length_m, 8.0, 0.1);
    is(&surge.thrust_lag_s, 0.05, 0.06);
    is(&surge.turning_drag_m, 0.5, 0.02);
    is(&surge.speeds[2].surge_speed_m_s, 2.2, 1e-3);
    // u = u_s tanh(u_s t/l + c) makes 63 % of the way from 1.24 to 2.2 m/s.
    let [from, to]: [f64; 2] = [1.24 / 2.2, 1.0];
    let reached = from + (1.0 - (-1.0_f64).exp()) * (to - from);
    let expected_s = (reached.atanh() - from.atanh()) * 8.0 / 2.2;
    let found_s = surge.time_to_63_percent_s(1.24, 2.2).unwrap();
    assert!((found_s / expected_s - 1.0).abs() < 0.05, "{found_s} {expected_s}");
}

/// A reading that is held over four samples is one reading: to the mean of many samples it adds the noise of twice the deviation.
#[test]
fn recover_noise_of_a_speed_that_is_held() {
    let mut config = boat();
    if let SimulatedConfig::FirstOrder(config) = &mut config {
        config.sensors.dvl.interval_s = 0.4;
    }
    let surge = estimate(&config, &[0.6, 0.8, 1.0]);
    // A deviation from 330 third differences is known to 6 %; 3 of them.
    assert!((surge.noise_m_s / 0.02 - 1.0).abs() < 0.18, "{surge:#?}");
    assert!(surge.noise_is_white);
}

/// Waves of the period of the manoeuvre are no noise from reading to reading, and widen the intervals.
#[test]
fn prop_waves_widen_the_intervals() {
    let calm = SimulatedConfig::built_in("remus100").unwrap();
    let waves = "[sea]\ndensity_kg_m3 = 1026.0\ncurrent = []\n[sea.waves]\nsignificant_height_m = 0.3\npeak_period_s = 4.0\n";
    let wavy = calm.with(waves.parse().unwrap()).unwrap();
    let [calm, wavy] = [calm, wavy].map(|config| estimate(&config, &[0.6, 0.8, 1.0]));
    assert!(calm.noise_is_white && !wavy.noise_is_white);
    let width = |surge: &SurgeEstimate| {
        let [low, high] = surge.speeds[2].surge_speed_m_s.interval_95.unwrap();
        high - low
    };
    assert!(width(&wavy) > 2.0 * width(&calm), "{wavy:#?}");
}

/// One thrust tells neither how fast the speed follows nor the dead band, and each says what would.
#[test]
fn exact_one_thrust_tells_no_surge() {
    let mut config = boat();
    if let SimulatedConfig::FirstOrder(config) = &mut config {
        config.initial_thrust = 1.0;
    }
    let surge = estimate(&config, &[1.0]);
    assert!(surge.speeds[0].surge_speed_m_s.value.is_some());
    for missing in [&surge.drag_length_m, &surge.thrust_lag_s] {
        assert_eq!(missing.value, None);
        assert_eq!(
            missing.verdict,
            "not identifiable from this record: add a step from 100 to 40 %"
        );
    }
    for missing in [&surge.dead_band, &surge.speed_per_thrust_m_s] {
        assert!(missing.verdict.ends_with("add another"), "{missing:?}");
    }
    assert_eq!(surge.time_to_63_percent_s(1.0, 2.0), None);
}

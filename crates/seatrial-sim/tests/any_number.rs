//! No number in any field of a vehicle file, a scenario or a plan ends the program: it is refused by name, or played.

use seatrial_core::{Plan, Trial, Vehicle};
use seatrial_dev::with_any_number;
use seatrial_sim::{FirstOrderVehicle, Scenario, SimulatedConfig, VehicleConfig};
use toml::Table;

/// Ten samples of it, with a trial at the helm.
fn play(config: &SimulatedConfig) -> bool {
    let Ok(mut vehicle) = config.vehicle(1) else {
        return false;
    };
    let mut trial = Trial::new(Plan::paper()).unwrap();
    for _ in 0..10 {
        let Ok(Some(sample)) = vehicle.next_sample() else {
            return true;
        };
        let Ok(()) = vehicle.act(&trial.step(&sample));
    }
    true
}

/// How many were played and how many refused.
fn counted(outcomes: impl Iterator<Item = bool>) -> (usize, usize) {
    let outcomes: Vec<bool> = outcomes.collect();
    let played = outcomes.iter().filter(|played| **played).count();
    (played, outcomes.len() - played)
}

#[test]
fn prop_any_number_in_a_vehicle_file() {
    let six_dof = "
        initial_thrust = 0.6
        rudder_limit_rad = 0.26
        [vehicle]
        base = 'remus100'
        trim_n = 7.0
        rudder_area_factor = 1.2
        [vehicle.payload]
        mass_kg = 2.0
        position_m = [0.5, 0.0, 0.05]
        [rudder]
        limit_rad = 0.3
        dead_band_rad = 0.01
        backlash_rad = 0.01
        [rudder.servo]
        time_constant_s = 0.1
        rate_limit_rad_s = 0.5
        [hull]
        cross_flow_drag = 1.1
        frontal_drag = 0.1
        length_m = 1.3
        [depth_hold]
        depth_m = 3.0
        pitch_limit_rad = 0.3
        [disturbance]
        standard_deviation_rad_s2 = 0.01
        correlation_time_s = 2.0
        [timing]
        sample_interval_s = 0.05
        jitter_s = 0.001
        [sea]
        density_kg_m3 = 1025.0
        [sea.waves]
        significant_height_m = 0.3
        peak_period_s = 3.0
        peak_enhancement = 3.3
        towards_rad = 1.0
        components = 10
        [[sea.current]]
        depth_m = 0.0
        north_m_s = 0.3
        east_m_s = 0.1
        [sea.bottom]
        depth_m = 12.0
        slope_north = -0.05
        [sensors.compass]
        noise_rad = 0.01
        lag_s = 0.1
        latency_s = 0.1
        [sensors.dvl]
        range_m = [0.5, 30.0]
    ";
    let first_order = Table::try_from(VehicleConfig::starfish()).unwrap();
    for table in [six_dof.parse().unwrap(), first_order] {
        let outcomes = with_any_number(&table).into_iter().map(|table| {
            let file = SimulatedConfig::from_toml(&toml::to_string(&table).unwrap());
            file.is_ok_and(|file| play(&file))
        });
        let (played, refused) = counted(outcomes);
        assert!(played > 30 && refused > 100, "{played} {refused}");
    }
}

#[test]
fn prop_any_number_in_a_scenario() {
    let text = "
        [[fault]]
        kind = 'compass_step'
        at_s = 0.1
        for_s = 3.0
        size_rad = 0.3
        [[fault]]
        kind = 'rudder_offset'
        angle_rad = 0.05
        stage = 'training'
        run = 2
        after_s = 1.0
        [random]
        count = 2
        from_s = 20.0
        to_s = 120.0
        [sea.waves]
        significant_height_m = 0.3
        peak_period_s = 3.0
    ";
    let base = SimulatedConfig::built_in("remus100").unwrap();
    let table: Table = text.parse().unwrap();
    let outcomes = with_any_number(&table).into_iter().map(|table| {
        let scenario = Scenario::from_toml(&toml::to_string(&table).unwrap());
        scenario.is_ok_and(|scenario| {
            let config = base.with(scenario.conditions.clone());
            config.is_ok_and(|config| play(&config))
        })
    });
    let (played, refused) = counted(outcomes);
    assert!(played > 20 && refused > 40, "{played} {refused}");
}

#[test]
fn prop_any_number_in_a_plan() {
    let table = Table::try_from(Plan::<f64>::paper()).unwrap();
    let outcomes = with_any_number(&table).into_iter().map(|table| {
        let text = toml::to_string(&table).unwrap();
        let Ok(plan) = toml::from_str::<Plan<f64>>(&text) else {
            return false;
        };
        let Ok(mut trial) = Trial::new(plan) else {
            return false;
        };
        let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
        for _ in 0..2000 {
            let Ok(sample) = vehicle.next_sample();
            let action = trial.step(&sample.unwrap());
            let Ok(()) = vehicle.act(&action);
            while trial.take_event().is_some() {}
        }
        true
    });
    let (played, refused) = counted(outcomes);
    assert!(played > 50 && refused > 200, "{played} {refused}");
}

/// The issue's own: each ended the program or was taken.
#[test]
fn io_the_field_is_named_with_its_range() {
    let base = SimulatedConfig::built_in("remus100").unwrap();
    let waves = |height: &str, period: &str| {
        let text =
            format!("[sea.waves]\nsignificant_height_m = {height}\npeak_period_s = {period}");
        let scenario = Scenario::from_toml(&text).unwrap();
        base.with(scenario.conditions).unwrap_err().to_string()
    };
    assert!(
        waves("1e3", "3.0")
            .contains("sea.waves.significant_height_m must be a length from 0 to 30 m")
    );
    assert!(
        waves("1.0", "1e-300").contains("sea.waves.peak_period_s must be a time from 0.5 to 60 s")
    );
    for (text, field) in [
        ("sample_interval_s = 1e-9", "sample_interval_s"),
        ("accept_from_r2 = -1e308", "accept_from_r2"),
    ] {
        let plan: Plan<f64> = toml::from_str(text).unwrap();
        let refused = Trial::new(plan).unwrap_err().to_string();
        assert!(refused.contains(field) && refused.contains("from"), "{refused}");
    }
}

//! A vehicle file, a scenario or a plan that somebody mistyped is refused or played; nothing ends the program.

use seatrial_core::{Plan, Trial, Vehicle};
use seatrial_dev::{Damage, damaged_copies};
use seatrial_sim::{FirstOrderVehicle, Scenario, SimulatedConfig, VehicleConfig};

/// Damaged copies of each text.
const OF_EACH: u64 = 1000;

const SIX_DOF: &str = "
initial_thrust = 0.6
rudder_limit_rad = 0.26
[vehicle]
base = 'remus100'
trim_n = 7.0
[vehicle.payload]
mass_kg = 2.0
position_m = [0.5, 0.0, 0.05]
[rudder.servo]
time_constant_s = 0.1
rate_limit_rad_s = 0.5
[sea.waves]
significant_height_m = 0.3
peak_period_s = 3.0
components = 10
[[sea.current]]
depth_m = 0.0
north_m_s = 0.3
east_m_s = 0.1
[sensors.compass]
noise_rad = 0.01
latency_s = 0.1
";

const SCENARIO: &str = "
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
[random]
count = 2
from_s = 20.0
to_s = 120.0
[sea.waves]
significant_height_m = 0.3
peak_period_s = 3.0
";

/// Some samples of it, with a trial at the helm.
fn play(config: &SimulatedConfig, mut trial: Trial<f64>) -> bool {
    let Ok(mut vehicle) = config.vehicle(1) else {
        return false;
    };
    for _ in 0..10 {
        let Ok(Some(sample)) = vehicle.next_sample() else {
            return true;
        };
        let Ok(()) = vehicle.act(&trial.step(&sample));
    }
    true
}

/// Each damaged copy is read and played; some were played and some refused.
fn try_all(text: &str, first_seed: u64, played: impl Fn(&str) -> bool) {
    let copies = damaged_copies(OF_EACH);
    let damaged = (0..copies).map(|copy| Damage::new(first_seed + copy).of_text(text));
    let count = damaged.filter(|text| played(text)).count() as u64;
    assert!(count > 0 && count < copies, "{count} of {copies} were played");
}

fn paper() -> Trial<f64> {
    Trial::new(Plan::paper()).unwrap()
}

#[test]
fn prop_no_damaged_vehicle_file_ends_the_program() {
    let first_order = toml::to_string(&VehicleConfig::starfish()).unwrap();
    for (text, first_seed) in [(SIX_DOF, 1 << 40), (&first_order, 2 << 40)] {
        try_all(text, first_seed, |text| {
            let file = SimulatedConfig::from_toml(text);
            file.is_ok_and(|file| play(&file, paper()))
        });
    }
}

#[test]
fn prop_no_damaged_scenario_ends_the_program() {
    let base = SimulatedConfig::built_in("remus100").unwrap();
    try_all(SCENARIO, 3 << 40, |text| {
        let scenario = Scenario::from_toml(text);
        scenario.is_ok_and(|scenario| {
            let config = base.with(scenario.conditions.clone());
            config.is_ok_and(|config| play(&config, paper()))
        })
    });
}

#[test]
fn prop_no_damaged_plan_ends_the_program() {
    let text = toml::to_string(&Plan::<f64>::paper()).unwrap();
    try_all(&text, 4 << 40, |text| {
        let Ok(plan) = toml::from_str::<Plan<f64>>(text) else {
            return false;
        };
        let Ok(mut trial) = Trial::new(plan) else {
            return false;
        };
        let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
        for _ in 0..200 {
            let Ok(sample) = vehicle.next_sample();
            let Ok(()) = vehicle.act(&trial.step(&sample.unwrap()));
            while trial.take_event().is_some() {}
        }
        true
    });
}

//! What people type in TOML: a vehicle, a scenario, a plan, what an autopilot had before. What is accepted is played.
#![no_main]

use seatrial_app::TrialPlan;
use seatrial_core::{Plan, Trial, Vehicle};
use seatrial_links::autopilot::Backup;
use seatrial_sim::{SimulatedConfig, VehicleConfig, Scenario};

/// Samples of a vehicle that is played.
const SAMPLES: usize = 20;

const SIX_DOF: &str = "initial_thrust = 0.6\nrudder_limit_rad = 0.26\n[vehicle]\nbase = 'remus100'\ntrim_n = 7.0\n[vehicle.payload]\n\
    mass_kg = 2.0\nposition_m = [0.5, 0.0, 0.05]\n[rudder.servo]\ntime_constant_s = 0.1\nrate_limit_rad_s = 0.5\n[sea.waves]\n\
    significant_height_m = 0.3\npeak_period_s = 3.0\ncomponents = 10\n[[sea.current]]\ndepth_m = 0.0\nnorth_m_s = 0.3\neast_m_s = 0.1\n\
    [sensors.compass]\nnoise_rad = 0.01\nlatency_s = 0.1\n";
const SCENARIO: &str = "[[fault]]\nkind = 'compass_step'\nat_s = 0.1\nfor_s = 3.0\nsize_rad = 0.3\n[[fault]]\nkind = 'rudder_offset'\n\
    angle_rad = 0.05\nstage = 'training'\nrun = 2\n[random]\ncount = 2\nfrom_s = 20.0\nto_s = 120.0\n";
const BACKUP: &str = "system = 1\nmode = 4\n[parameters.RC_OVERRIDE_TIME]\nnumber = 0.8\nkind = 9\n";

fn plant() {
    let first_order = toml::to_string(&VehicleConfig::starfish()).expect("a vehicle");
    let plan = toml::to_string(&Plan::<f64>::paper()).expect("a plan");
    let texts = [SIX_DOF, SCENARIO, &plan, BACKUP, &first_order];
    for (kind, text) in texts.iter().enumerate() {
        seatrial_fuzz::plant_seed("typed", kind, [&[kind as u8], text.as_bytes()].concat());
    }
}

fn play(config: &SimulatedConfig, plan: Plan<f64>) {
    let (Ok(mut vehicle), Ok(mut trial)) = (config.vehicle(1), Trial::new(plan)) else {
        return;
    };
    for _ in 0..SAMPLES {
        let Ok(Some(sample)) = vehicle.next_sample() else {
            return;
        };
        let Ok(()) = vehicle.act(&trial.step(&sample));
        while trial.take_event().is_some() {}
    }
}

fn read(kind: u8, text: &str) {
    match kind % 4 {
        0 => {
            if let Ok(file) = SimulatedConfig::from_toml(text) {
                play(&file, Plan::paper());
            }
        }
        1 => {
            let base = SimulatedConfig::built_in("remus100").expect("a built-in vehicle");
            if let Ok(scenario) = Scenario::from_toml(text)
                && let Ok(config) = base.with(scenario.conditions.clone())
            {
                play(&config, Plan::paper());
            }
        }
        2 => {
            if let Ok(plan) = TrialPlan::parse(text)
                && plan.checked().is_ok()
            {
                assert!(plan.longest_s().is_finite());
                play(&SimulatedConfig::FirstOrder(Box::new(VehicleConfig::starfish())), plan.plan);
            }
        }
        _ => {
            let _ = toml::from_str::<Backup>(text);
        }
    }
}

libfuzzer_sys::fuzz_target!(
    init: plant(),
    |data: &[u8]| {
        if let Some((kind, text)) = data.split_first() {
            read(*kind, &String::from_utf8_lossy(text));
        }
    }
);

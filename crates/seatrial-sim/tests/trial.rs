//! Whole trials with simulated vehicles.

use std::time::Instant;

use seatrial_core::{
    AbortReason, Event, Excitation, List, Outcome, Plan, RunResult, Sample, Stage, Trial,
    Validation, Vehicle, YawModel,
};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// Runs a trial to its end.
fn run(plan: Plan<f64>, config: VehicleConfig, seed: u64) -> (Vec<RunResult<f64>>, Outcome) {
    let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
    let mut trial = Trial::new(plan).unwrap();
    let mut results = Vec::new();
    loop {
        let Ok(sample) = vehicle.next_sample();
        let action = trial.step(&sample.unwrap());
        let Ok(()) = vehicle.act(&action);
        while let Some(event) = trial.take_event() {
            if let Event::RunFinished { result, .. } = event {
                results.push(result);
            }
        }
        if let Some(outcome) = action.outcome {
            return (results, outcome);
        }
    }
}

fn assert_truth_found(config: &VehicleConfig, c0_share: f64) {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    let (results, outcome) = run(Plan::paper(), config.clone(), 1);
    assert_eq!(outcome, Outcome::Finished);
    assert_eq!(results.len(), 5);
    for result in results {
        let truth = vehicle.truth(result.thrust);
        assert!(result.accepted && result.settled && result.attempt == 1);
        let (found, expected) = (result.model.theta(), truth.model.theta());
        for ((found, truth), share) in found.iter().zip(expected).zip([0.01, 0.01, c0_share]) {
            // First-order hold on yaw costs 0.1 to 0.3 %; the speed is within 1e-3 of steady.
            assert!((found / truth - 1.0).abs() < share, "{result:?}");
        }
        // Nothing is unexplained but the slow end of the motion before.
        assert!(result.validation.r2_heading.unwrap() > 0.99);
        // exp(-12/2) of the last change of speed is left when training begins.
        let speed_m_s = result.surge_speed_m_s.unwrap();
        assert!((speed_m_s / truth.surge_speed_m_s - 1.0).abs() < 1e-3);
    }
}

#[test]
fn exact_noise_free_trial_finds_the_truth_at_all_speeds() {
    for heading_rad in [0.0, 3.1, -1.5] {
        let mut config = VehicleConfig::starfish().noise_free();
        config.initial_heading_rad = heading_rad;
        assert_truth_found(&config, 0.01);
    }
}

#[test]
fn exact_jitter_and_missing_samples_do_not_bias() {
    // Held straight over intervals of 0.1 s and more, the heading shifts C0 by up to 1.5e-4 rad/s^2, 3 % of the smallest.
    for (jitter_s, missing_fraction, c0_share) in [(0.02, 0.0, 0.01), (0.0, 0.2, 0.04)] {
        let mut config = VehicleConfig::starfish().noise_free();
        config.initial_heading_rad = 3.1;
        config.timing.jitter_s = jitter_s;
        config.timing.missing_fraction = missing_fraction;
        assert_truth_found(&config, c0_share);
    }
}

#[test]
fn recover_default_vehicle_over_seeds() {
    let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 0).unwrap();
    let mut errors = Vec::new();
    for seed in 0..20 {
        let (results, outcome) = run(Plan::paper(), VehicleConfig::starfish(), seed);
        assert_eq!(outcome, Outcome::Finished, "seed {seed}");
        let accepted: Vec<_> = results.iter().filter(|result| result.accepted).collect();
        assert_eq!(accepted.len(), 5, "seed {seed}");
        for result in accepted {
            let truth = vehicle.truth(result.thrust).model;
            errors.push([
                result.model.a22_per_s / truth.a22_per_s - 1.0,
                result.model.b2_per_s2 / truth.b2_per_s2 - 1.0,
            ]);
        }
    }
    let rms = |parameter: usize| {
        let squares: f64 = errors.iter().map(|e| e[parameter] * e[parameter]).sum();
        (squares / errors.len() as f64).sqrt()
    };
    assert!(rms(0) < 0.05, "a22: {}", rms(0));
    assert!(rms(1) < 0.03, "b2: {}", rms(1));
}

#[test]
fn regress_a_trial_of_five_speeds_is_fast() {
    // The quickest of several: on a busy machine others run in between.
    let quickest = (0..5).map(|_| {
        let start = Instant::now();
        let _ = run(Plan::paper(), VehicleConfig::starfish(), 1);
        start.elapsed().as_secs_f64()
    });
    let quickest_s = quickest.fold(f64::INFINITY, f64::min);
    // 10 ms measured; the rest is for a slow machine.
    assert!(quickest_s < 0.3, "{quickest_s} s");
}

/// Every speed with this share of the rudder authority, and a heading loop that stays stable.
fn with_authority(share: f64) -> VehicleConfig {
    let mut config = VehicleConfig::starfish();
    for point in &mut config.speeds {
        point.b2_per_s2 *= share;
    }
    config.heading_hold.gain *= share.signum();
    config
}

fn noisy(mut config: VehicleConfig, compass_deg: f64, disturbance_rad_s2: f64) -> VehicleConfig {
    config.sensors.compass.noise_rad = compass_deg.to_radians();
    config.disturbance.standard_deviation_rad_s2 = disturbance_rad_s2;
    config
}

fn at_one_speed() -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[0.6]).unwrap(), max_repeats: 0, ..Plan::paper() }
}

#[test]
fn recover_a_reversed_rudder_is_found_in_noise() {
    for seed in 0..100 {
        for (compass_deg, disturbance) in [(0.5, 0.003), (2.0, 0.003), (0.5, 0.01)] {
            let config = noisy(with_authority(-1.0), compass_deg, disturbance);
            let (results, outcome) = run(at_one_speed(), config, seed);
            assert_eq!(
                outcome,
                Outcome::Aborted(AbortReason::ReversedRudder),
                "seed {seed}, {compass_deg} deg, {disturbance} rad/s^2"
            );
            assert_eq!(results, []);
        }
    }
}

#[test]
fn prop_no_false_alarm_of_a_reversed_rudder() {
    for seed in 0..200 {
        for (share, compass_deg, disturbance) in [
            (1.0, 0.5, 0.003),
            (1.0, 2.0, 0.01),
            (0.02, 0.0, 0.003),
            (0.02, 0.5, 0.003),
            (0.02, 2.0, 0.003),
        ] {
            let config = noisy(with_authority(share), compass_deg, disturbance);
            let (_, outcome) = run(at_one_speed(), config, seed);
            assert_ne!(
                outcome,
                Outcome::Aborted(AbortReason::ReversedRudder),
                "seed {seed}, authority {share}, {compass_deg} deg, {disturbance} rad/s^2"
            );
        }
    }
}

/// What the mean heading of the lead-in is worth against its first sample.
#[test]
fn recover_an_averaged_start_is_worth_its_r2() {
    let truth = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut sums = [0.0; 2];
    for seed in 0..100 {
        let mut config = noisy(VehicleConfig::starfish(), 2.0, 0.0);
        config.initial_thrust = 0.8;
        let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
        let mut plan = at_one_speed();
        plan.thrusts = List::from_slice(&[0.8]).unwrap();
        let mut trial = Trial::new(plan).unwrap();
        let mut samples = Vec::new();
        while trial.outcome().is_none() {
            let Ok(sample) = vehicle.next_sample();
            let sample = Sample { yaw_rate_rad_s: None, ..sample.unwrap() };
            let Ok(()) = vehicle.act(&trial.step(&sample));
            if trial.status().stage == Some(Stage::Validate) {
                samples.push(sample);
            }
        }
        for (sum, lead_in_s) in sums.iter_mut().zip([0.0, 2.0]) {
            *sum += Validation::of(truth, lead_in_s, &samples).r2_heading.unwrap();
        }
    }
    let [first, averaged] = sums.map(|sum| sum / 100.0);
    // The mean of 100 runs whose single ones scatter by 0.15 (first sample) and 0.02.
    assert!((averaged - 0.81).abs() < 0.01, "{averaged}");
    assert!((averaged - first - 0.17).abs() < 0.06, "{first}");
}

/// The other manoeuvres run through the same trial.
#[test]
fn exact_other_manoeuvres_find_the_truth() {
    for excitation in [
        Excitation::ThreeTwoOneOne { amplitude_rad: 0.2, unit_s: 0.7 },
        Excitation::Multisine { amplitude_rad: 0.2, period_s: 10.0, tones: 5 },
    ] {
        let mut plan = at_one_speed();
        plan.training.excitation = excitation;
        let config = VehicleConfig::starfish().noise_free();
        let (results, outcome) = run(plan, config, 1);
        assert_eq!(outcome, Outcome::Finished);
        let truth = YawModel::from_theta([-0.95, 0.60, 0.0072]);
        for (found, truth) in results[0].model.theta().iter().zip(truth.theta()) {
            // As for the doublet: first-order hold on yaw.
            assert!((found / truth - 1.0).abs() < 0.01, "{excitation:?} {results:?}");
        }
    }
}

#[test]
fn io_a_plan_file_changes_what_it_names() {
    let text = r"
        thrusts = [0.5, 0.75]
        max_repeats = 1

        [settle]
        not_settled = 'abort'

        [training]
        lead_in_s = 2.0
        observe_s = 8.0
        [training.excitation.doublet]
        amplitude_rad = 0.2
        period_s = 3.0

        [envelope]
        depth_max_m = 5.0
        area = [[-500.0, -500.0], [-500.0, 500.0], [500.0, 0.0]]
    ";
    let plan: Plan<f64> = toml::from_str(text).unwrap();
    assert_eq!(*plan.thrusts, [0.5, 0.75]);
    assert_eq!(plan.validation, Plan::paper().validation);
    assert_eq!(plan.envelope.area.len(), 3);
    assert_eq!(plan.envelope.roll_max_rad, Plan::<f64>::paper().envelope.roll_max_rad);
    // 6 / 3 s.
    assert_eq!(plan.estimator_settings().lambda_rad_s, 2.0);
    assert!(Trial::new(plan).is_ok());

    let written = toml::to_string(&plan).unwrap();
    assert_eq!(toml::from_str::<Plan<f64>>(&written).unwrap(), plan);

    let typo = toml::from_str::<Plan<f64>>("thrust = [0.5]").unwrap_err();
    assert!(typo.to_string().contains("unknown field `thrust`"), "{typo}");
    let many = format!("thrusts = {:?}", [0.5; 17]);
    let many = toml::from_str::<Plan<f64>>(&many).unwrap_err();
    assert!(many.to_string().contains("at most 16"), "{many}");
}

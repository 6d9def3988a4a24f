//! The order of the yaw model: decided from the record, worth its R^2 on validation data, honest about itself.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identification::EstimateMethod;
use seatrial::identify::cramer_rao::Noise;
use seatrial::identify::second_order::{
    self, SecondOrder, Structure, SwayYawModel, SwayYawState, goodness_of_fit,
};
use seatrial::identify::{IdentifySettings, identify, validation_estimate};
use seatrial::{Record, Window};
use seatrial_core::Sample;
use seatrial_dev::data;

const INTERVAL_S: f64 = 0.05;

fn read(folder: &std::path::Path, name: &str) -> Record {
    let mut log = seatrial_logs::open(&folder.join(name), &Default::default()).unwrap();
    std::iter::from_fn(|| log.next())
        .map(Result::unwrap)
        .collect()
}

/// The paper's 80 % vehicle.
fn first_order() -> SwayYawModel {
    SwayYawModel {
        a22_per_s: -1.07,
        b2_per_s2: 1.08,
        c0_rad_per_s2: 0.012,
        a11_per_s: -1.0,
        ..SwayYawModel::default()
    }
}

/// 2 s of heading hold, a doublet of 0.26 rad, 10.5 s of heading hold, from rest with the rudder at `-C0/b2`.
fn training_stage(truth: &SwayYawModel, noise: Noise, seed: u64) -> Vec<Sample<f64>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let memory: f64 = (-INTERVAL_S / noise.disturbance_time_s).exp();
    let mut disturbance = noise.disturbance_rad_s2 * normal();
    let neutral = -truth.c0_rad_per_s2 / truth.b2_per_s2;
    let mut acting = neutral;
    let mut state = SwayYawState::default();
    let mut samples = Vec::new();
    for k in 0..330_u32 {
        let heading_rad = state.heading_rad + noise.heading_rad * normal();
        let rudder_rad = match k {
            40..80 => 0.26,
            80..120 => -0.26,
            _ => neutral + (-0.5 * heading_rad).clamp(-0.2, 0.2),
        };
        samples.push(Sample {
            time_s: f64::from(k) * INTERVAL_S,
            heading_rad,
            rudder_rad,
            ..Sample::default()
        });
        let pushed = SwayYawModel {
            c0_rad_per_s2: truth.c0_rad_per_s2 + disturbance,
            rudder_lag_s: 0.0,
            ..*truth
        };
        // The lag in steps of its own, so that it is not the estimator's formula that is tested.
        let fine = 20;
        for _ in 0..fine {
            let interval_s = INTERVAL_S / f64::from(fine);
            if truth.rudder_lag_s > 0.0 {
                acting += (rudder_rad - acting) * (1.0 - (-interval_s / truth.rudder_lag_s).exp());
            } else {
                acting = rudder_rad;
            }
            let instants = [0.0, interval_s].map(|time_s| Sample {
                time_s,
                rudder_rad: acting,
                ..Sample::default()
            });
            state = pushed.simulate(&instants, state)[1];
        }
        disturbance = memory * disturbance
            + noise.disturbance_rad_s2 * (1.0 - memory * memory).sqrt() * normal();
    }
    samples
}

fn noise(heading_deg: f64, disturbance_rad_s2: f64, disturbance_time_s: f64) -> Noise {
    Noise {
        heading_rad: heading_deg.to_radians(),
        disturbance_rad_s2,
        disturbance_time_s,
    }
}

/// The goals for the six-degree-of-freedom REMUS 100: mean R^2 of the measured heading with the trained offset, three
/// thrusts with and without current. First order scores 0.87 and 0.79, the noise-free truth 0.99 and 0.90.
#[test]
fn val_remus_mean_r2_of_validation_heading_by_the_order_supported() {
    let Some(folder) = data(".") else {
        return;
    };
    for (noise, least) in [("n0p3", 0.93), ("n1", 0.85)] {
        let mut scores = Vec::new();
        for current in ["c0", "c0p3"] {
            for thrust in [70, 80, 90] {
                let record = read(
                    &folder,
                    &format!("simulated/remus100_{thrust}_native_{noise}_{current}.csv"),
                );
                let window = |from_s, to_s| Window { from_s, to_s };
                let found = second_order::fit(&record.usable(window(40.0, 56.5))).unwrap();
                let held_out = record.window(window(56.5, 73.0));
                let r2 = goodness_of_fit(&found.model, held_out).r2_heading.unwrap();
                println!("{noise} {current} {thrust}: {r2:.3}, {}", found.order);
                scores.push(r2);
            }
        }
        let mean = scores.iter().sum::<f64>() / scores.len() as f64;
        println!("{noise}: {mean:.4}");
        assert!(mean >= least, "{noise}: {mean} of {scores:?}");
    }
}

/// The goals for the free-running KVLCC2 model: R^2 of the measured yaw rate with the offset refitted, on zig-zags that
/// the model was not made from.
#[test]
fn val_kvlcc2_validation_yaw_rate() {
    let Some(folder) = data(".") else {
        return;
    };
    let read = |name: &str| read(&folder, &format!("real/kvlcc2hsva_Z_{name}.csv"));
    let found = second_order::fit(&read("20_10_P").usable(Window::ALL)).unwrap();
    println!("{} {found:?}", found.order);
    assert!(found.order.structure.sway_coupling && found.order.structure.cross_flow);
    for (name, least) in [("20_10_S", 0.98), ("25_05", 0.98), ("10_10_S", 0.45)] {
        let fit = goodness_of_fit(&found.model, &read(name).samples);
        println!("{name}: {fit:?}");
        let r2 = fit.r2_yaw_rate_offset_refit.unwrap();
        assert!(r2 >= least, "{name}: {r2}");
    }
}

/// The stated false alarm rate, on few records of each kind; `model_order` in the examples takes more.
#[test]
fn prop_first_order_is_kept() {
    let mut alarms = Vec::new();
    let mut records = 0;
    for heading_deg in [0.2, 0.5, 1.0, 2.0] {
        for (disturbance_rad_s2, time_s) in [(0.0, 1.0), (0.005, 2.0), (0.005, 0.5), (0.02, 2.0)] {
            let noise = noise(heading_deg, disturbance_rad_s2, time_s);
            for seed in 5000..5002 {
                records += 1;
                let found =
                    second_order::fit(&training_stage(&first_order(), noise, seed)).unwrap();
                if found.order.exceeds_first_order() {
                    alarms.push((noise, found.order));
                }
            }
        }
    }
    println!("{} of {records}", alarms.len());
    // 5 % of 32 is 1.6; more than 5 would happen less than once in 100 times.
    assert!(alarms.len() <= 5, "{alarms:?}");
}

fn inside(interval: Option<[f64; 2]>, truth: f64) -> bool {
    interval.is_some_and(|[low, high]| low <= truth && truth <= high)
}

/// A vehicle with every term that the structure has.
fn assert_recovered(truth: &SwayYawModel, structure: Structure, heading_deg: f64) {
    let runs = 20;
    let mut right = 0;
    let mut covered = 0;
    let mut parameters = 0;
    for seed in 0..runs {
        let samples = training_stage(truth, noise(heading_deg, 0.0, 1.0), 100 + seed);
        let found: SecondOrder = second_order::fit(&samples).unwrap();
        if found.order.structure != structure {
            println!("{seed}: {}", found.order);
            continue;
        }
        right += 1;
        let interval = &found.interval_95;
        for (interval, truth) in [
            (Some(interval.a22_per_s), truth.a22_per_s),
            (Some(interval.b2_per_s2), truth.b2_per_s2),
            (Some(interval.c0_rad_per_s2), truth.c0_rad_per_s2),
            (interval.a21_per_s2, truth.a21_per_s2),
            (interval.a11_per_s, truth.a11_per_s),
            (interval.cross_flow_per_rad_s, truth.cross_flow_per_rad_s),
            (interval.rudder_lag_s, truth.rudder_lag_s),
        ] {
            if interval.is_some() {
                parameters += 1;
                covered += u32::from(inside(interval, truth));
            }
        }
    }
    println!("{structure:?}: {right} of {runs}, coverage {covered} of {parameters}");
    assert!(right >= runs - 2, "{right} of {runs}");
    // 95 % intervals; the errors of one record go together, so 85 % is three standard deviations away.
    assert!(
        f64::from(covered) >= 0.85 * f64::from(parameters),
        "{covered} of {parameters}"
    );
}

#[test]
fn recover_second_order_plant() {
    let truth = SwayYawModel {
        a22_per_s: -2.0,
        b2_per_s2: 1.3,
        a21_per_s2: -1.0,
        a11_per_s: -0.8,
        ..first_order()
    };
    let structure = Structure {
        sway_coupling: true,
        ..Structure::FIRST_ORDER
    };
    assert_recovered(&truth, structure, 0.1);
}

#[test]
fn recover_cross_flow_plant() {
    let truth = SwayYawModel {
        a22_per_s: -0.7,
        b2_per_s2: 1.2,
        a11_per_s: -0.6,
        cross_flow_per_rad_s: -15.0,
        ..first_order()
    };
    let structure = Structure {
        cross_flow: true,
        ..Structure::FIRST_ORDER
    };
    assert_recovered(&truth, structure, 0.3);
}

/// A slow servo is not taken for sway.
#[test]
fn recover_rudder_lag() {
    let truth = SwayYawModel {
        rudder_lag_s: 0.3,
        ..first_order()
    };
    let structure = Structure {
        rudder_lag: true,
        ..Structure::FIRST_ORDER
    };
    assert_recovered(&truth, structure, 0.3);
}

/// A weak rudder behind a slow servo: the lag passes for so small a disturbance that first order was not doubted.
#[test]
fn regress_a_lag_under_a_weak_rudder_is_no_damping() {
    let truth = SwayYawModel {
        a22_per_s: -0.91,
        b2_per_s2: 0.5,
        c0_rad_per_s2: 0.005,
        rudder_lag_s: 0.15,
        ..first_order()
    };
    let mut unreported = 0;
    // A lag that noise hides is part of the interval and need not be named.
    for (heading_deg, least_named) in [(0.17, 4), (0.5, 2), (1.0, 0), (2.0, 0)] {
        let mut named = 0;
        for seed in 0..4 {
            let samples = training_stage(&truth, noise(heading_deg, 0.0, 1.0), 300 + seed);
            let record: Record = samples.into_iter().collect();
            let found = identify(&record, Window::ALL, None, &IdentifySettings::default()).unwrap();
            let refined = found.refined.unwrap();
            let interval = refined.interval_95.a22_per_s;
            named += usize::from(refined.method == EstimateMethod::RudderLag);
            let is_reported = ["lag_unknown", "model_order"].iter().any(|code| {
                found
                    .verdict
                    .reasons
                    .iter()
                    .any(|r| r.code.to_string() == *code)
            });
            unreported += usize::from(!inside(Some(interval), truth.a22_per_s) && !is_reported);
        }
        assert!(named >= least_named, "{heading_deg} deg: {named} of 4");
    }
    // 3 measured: a lag that noise hides is believed to be rare, and some intervals miss for it.
    assert!(unreported <= 3, "{unreported} of 16");
}

/// A rudder that saturates in the training is found by validation data, also where these are not of first order.
#[test]
fn regress_validation_data_of_higher_order_have_an_estimate() {
    let method = |truth: &SwayYawModel| {
        let samples = training_stage(truth, noise(0.1, 0.0, 1.0), 3);
        validation_estimate(&samples).map(|estimate| estimate.method)
    };
    let lagging = SwayYawModel {
        rudder_lag_s: 0.4,
        ..first_order()
    };
    let found = [&first_order(), &lagging].map(|truth| method(truth).unwrap());
    assert_eq!(
        found,
        [
            EstimateMethod::AveragedRestrictedLikelihood,
            EstimateMethod::RudderLag
        ]
    );
}

/// Without noise nothing but the truth is found, and nothing more.
#[test]
fn exact_noise_free_records() {
    let nothing = noise(0.0, 0.0, 1.0);
    let found = second_order::fit(&training_stage(&first_order(), nothing, 1)).unwrap();
    assert!(!found.order.exceeds_first_order(), "{}", found.order);
    // The floor under the residual, 1e-6 of the heading's range, over the doublet's effect.
    assert!((found.model.a22_per_s + 1.07).abs() < 1e-4, "{found:?}");

    let truth = SwayYawModel {
        a21_per_s2: 0.4,
        a11_per_s: -0.6,
        cross_flow_per_rad_s: -8.0,
        ..first_order()
    };
    let found = second_order::fit(&training_stage(&truth, nothing, 1)).unwrap();
    println!("{found:?}");
    assert!((found.model.a21_per_s2 - 0.4).abs() < 0.01, "{found:?}");
    assert!((found.model.a11_per_s + 0.6).abs() < 0.01, "{found:?}");
    assert!(
        (found.model.cross_flow_per_rad_s + 8.0).abs() < 0.1,
        "{found:?}"
    );
}

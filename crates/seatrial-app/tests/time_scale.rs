//! From a small boat that answers in a quarter of a second to a ship that takes 100 s: same trial, no option.

use seatrial::campaign::Campaign;
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::{Plan, Stage};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// Time constant of the vehicle at 80 % thrust and its sampling interval, s.
const VEHICLES: [(f64, f64); 5] =
    [(0.25, 0.02), (0.25, 0.05), (1.0 / 1.07, 0.05), (11.0, 0.25), (100.0, 1.0)];

fn about() -> Campaign {
    Campaign::of("scaled", &Plan::paper())
}

/// The default vehicle `pace` times slower: the same motion in its own time.
fn slower(pace: f64, sample_interval_s: f64) -> VehicleConfig {
    let mut config = VehicleConfig::starfish();
    config.surge_time_constant_s *= pace;
    config.servo.time_constant_s *= pace;
    config.disturbance.standard_deviation_rad_s2 /= pace * pace;
    config.disturbance.correlation_time_s *= pace;
    config.timing.sample_interval_s = sample_interval_s;
    for point in &mut config.speeds {
        point.a22_per_s /= pace;
        point.b2_per_s2 /= pace * pace;
        point.c0_rad_per_s2 /= pace * pace;
    }
    config
}

#[test]
fn recover_any_time_scale() {
    for (time_constant_s, interval_s) in VEHICLES {
        let pace = time_constant_s * 1.07;
        let plan = Plan::for_time_constant(time_constant_s, interval_s);
        let (mut inside, mut intervals, mut accepted) = (0, 0, 0);
        for seed in 1..=2 {
            let mut vehicle = FirstOrderVehicle::new(slower(pace, interval_s), seed).unwrap();
            let conducted = conduct(&mut vehicle, plan, about(), &mut NoWatch).unwrap();
            for run in &conducted.campaign.runs {
                let truth = vehicle.truth(run.thrust).model.theta();
                let of_trial = run.identification.as_ref().unwrap();
                let detected_s = of_trial.online.convergence.detected_s.unwrap();
                // After lead-in and doublet, within the stage.
                assert!(detected_s > 6.0 * pace && detected_s < 16.5 * pace, "{detected_s}");

                // The same run as a log, of which nothing is known.
                let log = run.record.clone();
                let [training, validation] =
                    [Stage::Train, Stage::Validate].map(|s| run.stage(s).unwrap());
                let held_out = ValidationData { record: &log, window: validation };
                let of_log =
                    identify(&log, training, Some(held_out), &IdentifySettings::default()).unwrap();
                for found in [of_trial, &of_log] {
                    accepted += i32::from(found.verdict.accepted);
                    let refined = found.refined.as_ref().unwrap();
                    let of = refined.interval_95;
                    for ([low, high], truth) in
                        [of.a22_per_s, of.b2_per_s2, of.c0_rad_per_s2].into_iter().zip(truth)
                    {
                        intervals += 1;
                        inside += i32::from((low..=high).contains(&truth));
                    }
                }
            }
        }
        println!(
            "T {time_constant_s} s, h {interval_s} s: {inside} of {intervals} inside, {accepted} accepted"
        );
        assert!(intervals >= 60);
        // 95 % are expected; fewer than 85 % of 60 would be seen in one of a thousand choices of seeds.
        assert!(f64::from(inside) > 0.85 * f64::from(intervals));
        // A trained offset that is off by chance has a run repeated now and then.
        // Speeds whose time constant holds fewer than five samples are refused.
        if interval_s < 0.15 * time_constant_s {
            assert!(f64::from(accepted) > 0.85 * f64::from(intervals / 3));
        }
    }
}

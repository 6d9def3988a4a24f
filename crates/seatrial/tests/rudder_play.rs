//! A rudder with play: the interval holds the truth or reaches near it, and a sound rudder is not suspected.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identification::{EstimateMethod, ReasonCode, Refined, Subject};
use seatrial::identify::whole_record::{WholeRecord, robust_estimate};
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial::likelihood::leg::fin_behind;
use seatrial::{Record, Window};
use seatrial_core::model::YawState;
use seatrial_core::{Action, Sample, Steering, Vehicle, YawModel};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

const THETA: [f64; 3] = [-0.8, 0.7, 0.01];

/// Samples of a vehicle whose rudder has play, with compass noise of 0.3 deg; `rudder` answers row, heading and yaw rate, rad.
fn sail(
    rows: u32,
    interval_s: f64,
    play_rad: f64,
    seed: u64,
    rudder: impl Fn(u32, f64, f64) -> f64,
) -> Vec<Sample<f64>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let model = YawModel::from_theta(THETA);
    let (mut state, mut fin_rad) = (YawState::<f64>::default(), None);
    let sample = |k: u32| {
        let heading_rad = state.heading_rad + 0.3_f64.to_radians() * normal();
        let rudder_rad = rudder(k, heading_rad, state.yaw_rate_rad_s);
        let before_rad = fin_rad.unwrap_or(rudder_rad);
        let now_rad = fin_behind(&[before_rad, rudder_rad], play_rad)[1];
        fin_rad = Some(now_rad);
        state = model.advance(state, now_rad, interval_s);
        Sample { time_s: interval_s * f64::from(k), heading_rad, rudder_rad, ..Sample::default() }
    };
    (0..rows).map(sample).collect()
}

/// A doublet of 0.2 rad between segments of heading hold, 330 samples at 20 Hz.
fn record(play_rad: f64, seed: u64) -> WholeRecord {
    let samples = sail(330, 0.05, play_rad, seed, |k, heading_rad, _| match k {
        40..80 => 0.2,
        80..120 => -0.2,
        _ => -0.3 * heading_rad,
    });
    robust_estimate(&samples).expect("a model")
}

#[test]
fn exact_the_fin_stands_still_within_the_play() {
    let command_rad = [0.0, 0.2, 0.15, 0.05, -0.2, -0.15];
    let fin_rad = fin_behind(&command_rad, 0.1);
    let expected = [0.0, 0.15, 0.15, 0.1, -0.15, -0.15];
    for (fin, expected) in fin_rad.iter().zip(expected) {
        assert!((fin - expected).abs() < 1e-12, "{fin_rad:?}");
    }
}

/// Play is named where the record makes it a thousand times likelier, which chance hides in one of these twenty; the intervals reach in all.
#[test]
fn recover_the_interval_reaches_the_model_behind_play() {
    let mut unnamed = Vec::new();
    for seed in 1..=20 {
        let found = record(3_f64.to_radians(), seed);
        match found.robust.play_rad {
            Some(play_rad) => assert!((0.02..0.09).contains(&play_rad), "{play_rad}"),
            None => unnamed.push(seed),
        }
        let intervals = &found.refined.interval_95;
        for (truth, [low, high]) in
            THETA.into_iter().zip([intervals.a22_per_s, intervals.b2_per_s2])
        {
            let half_width = 0.5 * (high - low);
            let beyond = (low - truth).max(truth - high) / half_width;
            assert!(
                beyond < 0.5,
                "seed {seed}: {truth} is {beyond} half widths beyond {low} to {high}"
            );
        }
    }
    assert!(unnamed.len() <= 1, "{unnamed:?}");
}

/// By how many half widths the true b2 is beyond its interval.
fn beyond(refined: &Refined) -> f64 {
    let [low, high] = refined.interval_95.b2_per_s2;
    (low - THETA[1]).max(THETA[1] - high) / (0.5 * (high - low))
}

/// Courses of 40 deg to either side, 240 s at 10 Hz.
#[test]
fn recover_ordinary_steering_tells_the_play_of_its_rudder() {
    let steered = |play_rad, seed| {
        let samples = sail(2400, 0.1, play_rad, seed, |k, heading_rad, yaw_rate_rad_s| {
            let course_rad = 0.7 * f64::from(k / 150 % 2);
            (0.8 * (course_rad - heading_rad) - 0.5 * yaw_rate_rad_s).clamp(-0.25, 0.25)
        });
        let record = Record { samples, ..Record::default() };
        identify(&record, Window::ALL, None, &IdentifySettings::default()).unwrap()
    };
    for seed in 1..=5 {
        let found = steered(3_f64.to_radians(), seed);
        let refined = found.refined.as_ref().unwrap();
        assert_eq!(refined.method, EstimateMethod::PredictionError);
        assert!(
            found.verdict.has(ReasonCode::RudderNotFollowed.of(Subject::Linkage)),
            "{:?}",
            found.verdict
        );
        assert!(beyond(refined) < 0.5, "seed {seed}: {refined:?}");
        let sound = steered(0.0, seed).verdict;
        assert!(!sound.has(ReasonCode::RudderNotFollowed.of(Subject::Linkage)), "{sound:?}");
    }
}

/// Two doublets of 15 and 9 deg: the contest of hypotheses hands over the model at the rudder of the first, and its interval holds the one
/// behind the play.
#[test]
fn recover_the_weighed_model_reaches_the_one_behind_the_play() {
    let mut weighed = 0;
    for seed in 1..=4 {
        let samples = sail(1600, 0.05, 4_f64.to_radians(), seed, |k, _, _| match k {
            100..180 => 0.26,
            180..260 => -0.26,
            900..980 => -0.16,
            980..1060 => 0.16,
            _ => 0.0,
        });
        let record = Record { samples, ..Record::default() };
        let window = |from_s, to_s| Window { from_s, to_s };
        let data = ValidationData { record: &record, window: window(40.0, 70.0) };
        let training = window(0.0, 30.0);
        let found = identify(&record, training, Some(data), &IdentifySettings::default()).unwrap();
        let refined = found.refined.as_ref().unwrap();
        weighed += usize::from(refined.method == EstimateMethod::WeighedHypotheses);
        assert!(beyond(refined) < 0.5, "seed {seed}: {refined:?}");
    }
    assert!(weighed > 0);
}

#[test]
fn prop_a_sound_rudder_is_not_suspected() {
    let suspected = (1..=50).filter(|seed| record(0.0, *seed).robust.play_rad.is_some());
    assert!(suspected.count() <= 1);
}

/// A vehicle of 5 s in a sea as slow. A rudder behind play may look like that of a slower vehicle, whose comparisons are longer: evidence of
/// fewer of them is no evidence for play.
#[test]
fn prop_a_sound_rudder_of_a_slow_vehicle_is_not_suspected() {
    let suspects = |seed: &u64| {
        let mut vehicle =
            FirstOrderVehicle::new(VehicleConfig::starfish().slowed(5.4), *seed).unwrap();
        let mut samples = Vec::new();
        while let Ok(Some(sample)) = vehicle.next_sample() {
            let steering = match sample.time_s {
                110.0..121.0 => Steering::Rudder(0.26),
                121.0..132.0 => Steering::Rudder(-0.26),
                _ => Steering::HoldHeading(0.0),
            };
            if sample.time_s > 190.0 {
                break;
            }
            samples.extend((sample.time_s >= 100.0).then_some(sample));
            let action = Action { steering, thrust: Some(0.8), outcome: None };
            let Ok(()) = vehicle.act(&action);
        }
        robust_estimate(&samples).unwrap().robust.play_rad.is_some()
    };
    assert!((1..=20).filter(suspects).count() <= 1);
}

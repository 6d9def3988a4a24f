//! A rudder with play: the interval holds the truth or reaches near it, and a sound rudder is not suspected.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identify::robust::play::fin_behind;
use seatrial::identify::whole_record::{WholeRecord, robust_estimate};
use seatrial_core::model::YawState;
use seatrial_core::{Sample, YawModel};

const THETA: [f64; 3] = [-0.8, 0.7, 0.01];

/// A doublet of 0.2 rad between segments of heading hold, 330 samples at 20 Hz, compass noise of 0.3 deg.
fn record(play_rad: f64, seed: u64) -> WholeRecord {
    const INTERVAL_S: f64 = 0.05;
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let model = YawModel::from_theta(THETA);
    let mut commands_rad = Vec::new();
    let mut state = YawState::<f64>::default();
    let samples: Vec<Sample<f64>> = (0..330_u32)
        .map(|k| {
            let heading_rad = state.heading_rad + 0.3_f64.to_radians() * normal();
            let rudder_rad = match k {
                40..80 => 0.2,
                80..120 => -0.2,
                _ => -0.3 * heading_rad,
            };
            commands_rad.push(rudder_rad);
            let fin_rad = fin_behind(&commands_rad, play_rad);
            state = model.advance(state, fin_rad[fin_rad.len() - 1], INTERVAL_S);
            Sample {
                time_s: INTERVAL_S * f64::from(k),
                heading_rad,
                rudder_rad,
                ..Sample::default()
            }
        })
        .collect();
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

#[test]
fn recover_the_interval_reaches_the_model_behind_play() {
    for seed in 1..=20 {
        let found = record(3_f64.to_radians(), seed);
        let play_rad = found.robust.play_rad.expect("play");
        assert!((0.02..0.09).contains(&play_rad), "{play_rad}");
        let intervals = &found.refined.interval_95;
        for (truth, [low, high]) in THETA
            .into_iter()
            .zip([intervals.a22_per_s, intervals.b2_per_s2])
        {
            let half_width = 0.5 * (high - low);
            let beyond = (low - truth).max(truth - high) / half_width;
            assert!(
                beyond < 0.5,
                "seed {seed}: {truth} is {beyond} half widths beyond {low} to {high}"
            );
        }
    }
}

#[test]
fn prop_a_sound_rudder_is_not_suspected() {
    let suspected = (1..=50).filter(|seed| record(0.0, *seed).robust.play_rad.is_some());
    assert!(suspected.count() <= 1);
}

//! How often is a first-order vehicle taken for more? The paper's 80 % vehicle and a quicker one, for white heading noise
//! and yaw acceleration disturbance. The seeds are others than those on which the decision's constants were set.
//!
//! `cargo run --release -p seatrial --example model_order -- 100`

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identify::cramer_rao::Noise;
use seatrial::identify::second_order;
use seatrial_core::model::YawState;
use seatrial_core::{Sample, YawModel};

const TRUTHS: [[f64; 3]; 2] = [[-1.07, 1.08, 0.012], [-2.0, 2.2, 0.02]];
const FIRST_SEED: u64 = 1000;
const INTERVAL_S: f64 = 0.05;
const SAMPLES: usize = 330;

fn main() {
    let runs: u64 = std::env::args()
        .nth(1)
        .map_or(20, |text| text.parse().expect("a number of runs"));
    println!("a22, noise deg, disturbance rad/s^2, s | first order kept | the others");
    let mut kept = 0;
    let mut records = 0;
    for truth in TRUTHS {
        for noise_deg in [0.2, 0.5, 1.0, 2.0] {
            for (disturbance_rad_s2, disturbance_time_s) in
                [(0.0, 1.0), (0.005, 2.0), (0.005, 0.5), (0.02, 2.0)]
            {
                let noise = Noise {
                    heading_rad: f64::to_radians(noise_deg),
                    disturbance_rad_s2,
                    disturbance_time_s,
                };
                let others = taken_for_more(truth, noise, runs);
                let share = 1.0 - others.len() as f64 / runs as f64;
                println!(
                    "{} {noise_deg} {disturbance_rad_s2} {disturbance_time_s} | {share:.3} | {}",
                    truth[0],
                    others.join(", ")
                );
                kept += runs - others.len() as u64;
                records += runs;
            }
        }
    }
    println!("first order kept in {kept} of {records}");
}

/// The structures that were found in place of first order.
fn taken_for_more(truth: [f64; 3], noise: Noise, runs: u64) -> Vec<&'static str> {
    (FIRST_SEED..FIRST_SEED + runs)
        .filter_map(|seed| {
            let samples = training_stage(YawModel::from_theta(truth), noise, seed);
            let found = second_order::fit(&samples).expect("an excited record");
            found
                .order
                .exceeds_first_order()
                .then(|| found.order.structure.in_words())
        })
        .collect()
}

/// 2 s of heading hold, the doublet, 10.5 s of heading hold.
fn training_stage(truth: YawModel<f64>, noise: Noise, seed: u64) -> Vec<Sample<f64>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let memory: f64 = (-INTERVAL_S / noise.disturbance_time_s).exp();
    let mut state = YawState::default();
    let mut disturbance = noise.disturbance_rad_s2 * normal();
    let mut samples = Vec::with_capacity(SAMPLES);
    let settling = 200;
    for k in 0..settling + SAMPLES {
        let time_s = INTERVAL_S * (k as f64 - settling as f64);
        let heading_rad: f64 = state.heading_rad + noise.heading_rad * normal();
        let rudder_rad = match time_s {
            t if (2.0..4.0).contains(&t) => 0.26,
            t if (4.0..6.0).contains(&t) => -0.26,
            _ => (-0.5 * heading_rad).clamp(-0.26_f64, 0.26),
        };
        if k >= settling {
            samples.push(Sample {
                time_s,
                heading_rad,
                rudder_rad,
                ..Sample::default()
            });
        }
        let pushed = YawModel {
            c0_rad_per_s2: truth.c0_rad_per_s2 + disturbance,
            ..truth
        };
        state = pushed.advance(state, rudder_rad, INTERVAL_S);
        disturbance = memory * disturbance
            + noise.disturbance_rad_s2 * (1.0 - memory * memory).sqrt() * normal();
    }
    samples
}

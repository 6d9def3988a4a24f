//! How good is the refined estimate? Efficiency against the Cramer-Rao bound and coverage of the 95 %
//! intervals on the paper's 80 % vehicle, for white heading noise and yaw acceleration disturbance.
//!
//! `cargo run --release -p seatrial --example refine_accuracy -- 400`

use std::time::Instant;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seatrial::identify::bound::{Noise, cramer_rao_bound};
use seatrial::identify::refine::refine;
use seatrial_core::model::YawState;
use seatrial_core::{Sample, YawModel};

const TRUTH: [f64; 3] = [-1.07, 1.08, 0.012];
const INTERVAL_S: f64 = 0.05;
const SAMPLES: usize = 330;

fn main() {
    let runs: u64 = std::env::args()
        .nth(1)
        .map_or(100, |text| text.parse().expect("a number of runs"));
    println!("noise deg, disturbance rad/s^2, s | efficiency a22 b2 C0 | coverage a22 b2 C0 | ms");
    for noise_deg in [0.2, 0.5, 1.0, 2.0] {
        for (disturbance_rad_s2, disturbance_time_s) in
            [(0.0, 1.0), (0.005, 2.0), (0.005, 0.5), (0.02, 2.0)]
        {
            cell(
                runs,
                Noise {
                    heading_rad: f64::to_radians(noise_deg),
                    disturbance_rad_s2,
                    disturbance_time_s,
                },
            );
        }
    }
}

fn cell(runs: u64, noise: Noise) {
    let truth = YawModel::from_theta(TRUTH);
    let mut square_errors = [0.0; 3];
    let mut bounds = [0.0; 3];
    let mut covered = [0_u32; 3];
    let mut time_s = 0.0;
    for seed in 0..runs {
        let samples = training_stage(truth, noise, seed);
        let bound = cramer_rao_bound(&samples, truth, noise).expect("an excited record");
        let start = Instant::now();
        let refined = refine(&samples, Some(truth)).expect("an excited record");
        time_s += start.elapsed().as_secs_f64();
        let intervals = [
            refined.interval_95.a22_per_s,
            refined.interval_95.b2_per_s2,
            refined.interval_95.c0_rad_per_s2,
        ];
        for i in 0..3 {
            square_errors[i] += (refined.model.theta()[i] - TRUTH[i]).powi(2);
            bounds[i] += bound[(i, i)];
            covered[i] += u32::from(intervals[i][0] <= TRUTH[i] && TRUTH[i] <= intervals[i][1]);
        }
    }
    let efficiency: [f64; 3] = core::array::from_fn(|i| bounds[i] / square_errors[i]);
    let coverage = covered.map(|c| f64::from(c) / runs as f64);
    println!(
        "{:.1} {:.3} {:.1} | {:.2} {:.2} {:.2} | {:.3} {:.3} {:.3} | {:.1}",
        noise.heading_rad.to_degrees(),
        noise.disturbance_rad_s2,
        noise.disturbance_time_s,
        efficiency[0],
        efficiency[1],
        efficiency[2],
        coverage[0],
        coverage[1],
        coverage[2],
        1e3 * time_s / runs as f64
    );
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
        let time_s = INTERVAL_S * (k as f64 - f64::from(settling as u32));
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

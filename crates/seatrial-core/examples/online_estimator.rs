//! Estimates the yaw model of a vehicle in a 20 Hz loop, with a compass that is noisy and loses samples.
//!
//! `cargo run -p seatrial-core --example online_estimator`

use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::model::YawState;
use seatrial_core::{Estimator, EstimatorSettings, HeadingGain, Intake, YawModel};

const INTERVAL_S: f64 = 0.05;

/// Standard deviation of the compass, rad.
const COMPASS_NOISE_RAD: f64 = 0.005;

fn main() {
    run().unwrap();
}

/// One manoeuvre: 5 s straight on, a doublet of 4 s, 10 s to see the vehicle settle.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let vehicle = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut state = YawState::default();
    let mut compass = Compass { random: 1 };
    let mut estimator = Estimator::new(EstimatorSettings::<f64>::default())?;
    for k in 0..380 {
        let time_s = f64::from(k) * INTERVAL_S;
        let rudder_rad = match k {
            100..140 => 0.26,
            140..180 => -0.26,
            _ => 0.0,
        };
        let is_lost = k % 50 == 49;
        if !is_lost {
            let heading_rad = compass.reads(state.heading_rad);
            let intake = match k {
                // The filters settle before anything is learnt.
                0..60 => estimator.warm(time_s, heading_rad, rudder_rad),
                _ => estimator.update(time_s, heading_rad, rudder_rad),
            };
            if let Intake::Rejected(cause) = intake {
                println!("{time_s:5.2} s: refused, {cause:?}");
            }
        }
        if k == 180 {
            estimator.excitation_ended();
        }
        state = vehicle.advance(state, rudder_rad, INTERVAL_S);
    }

    let found = estimator.model();
    println!("          found   true");
    for (name, found, truth) in [
        ("a22, 1/s   ", found.a22_per_s, vehicle.a22_per_s),
        ("b2, 1/s^2  ", found.b2_per_s2, vehicle.b2_per_s2),
        ("C0, rad/s^2", found.c0_rad_per_s2, vehicle.c0_rad_per_s2),
    ] {
        println!("{name} {found:6.3} {truth:6.3}");
    }
    let timing = LoopTiming { delay_s: 0.1, sample_interval_s: Some(INTERVAL_S) };
    let gain = HeadingGain::design_delayed(&found, 0.7, timing)?;
    println!(
        "heading gain {:.2} rad/rad, rudder that holds a straight course {:.4} rad",
        gain.proportional_gain, gain.feed_forward_rudder_rad
    );
    // Compass noise of 0.3 degrees and one doublet: within a tenth.
    assert!((found.a22_per_s / vehicle.a22_per_s - 1.0).abs() < 0.1);
    assert!((found.b2_per_s2 / vehicle.b2_per_s2 - 1.0).abs() < 0.1);
    Ok(())
}

/// A compass with evenly distributed noise.
struct Compass {
    random: u64,
}

impl Compass {
    fn reads(&mut self, heading_rad: f64) -> f64 {
        self.random = (self.random)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let share = (self.random >> 11) as f64 / (1_u64 << 53) as f64;
        heading_rad + COMPASS_NOISE_RAD * 12_f64.sqrt() * (share - 0.5)
    }
}

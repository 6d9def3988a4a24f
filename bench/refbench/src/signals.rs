//! The records that everybody works on.

use std::fs;
use std::path::Path;

use seatrial_core::model::{YawModel, YawState};
use seatrial_core::{FixedRateSettings, Sample};

use crate::{INITIAL_COVARIANCE, INTERVAL_S, LAMBDA_RAD_S, LONG, ONLINE, Outcome, SHORT};

/// Standard deviation of the heading noise, rad.
const NOISE_RAD: f64 = 0.002;

/// A vehicle that steers to both sides all the time; heading with noise, and rudder.
pub struct Signals {
    pub heading: Vec<f64>,
    pub rudder: Vec<f64>,
}

impl Signals {
    fn new(samples: usize, seed: u64) -> Self {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let mut state = YawState::default();
        let mut noise = white(seed);
        let (heading, rudder) = (0..samples)
            .map(|k| {
                let rudder = match k % 210 {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => -0.011,
                };
                let heading = state.heading_rad + NOISE_RAD * noise();
                state = model.advance(state, rudder, INTERVAL_S);
                (heading, rudder)
            })
            .unzip();
        Self { heading, rudder }
    }
}

/// Draws with mean 0 and standard deviation 1: sums of twelve uniform draws of SplitMix64, less six.
fn white(mut seed: u64) -> impl FnMut() -> f64 {
    let mut uniform = move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = seed;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 2_f64.powi(53)
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// What is measured on.
pub struct Data {
    pub settings: FixedRateSettings<f64>,
    pub short: Signals,
    pub long: Signals,
    /// The short record as samples.
    pub samples: Vec<Sample<f64>>,
    /// Where the refined estimate starts.
    pub start: YawModel<f64>,
}

impl Data {
    pub fn new() -> Self {
        let short = Signals::new(SHORT, 0);
        let samples = (short.heading.iter().zip(&short.rudder).enumerate())
            .map(|(k, (heading_rad, rudder_rad))| Sample {
                time_s: k as f64 * INTERVAL_S,
                heading_rad: *heading_rad,
                rudder_rad: *rudder_rad,
                ..Sample::default()
            })
            .collect();
        Self {
            settings: FixedRateSettings {
                lambda_rad_s: LAMBDA_RAD_S,
                initial_covariance: INITIAL_COVARIANCE,
                ..FixedRateSettings::paper(INTERVAL_S)
            },
            short,
            long: Signals::new(LONG, 1),
            samples,
            start: YawModel::from_theta([-1.0, 1.0, 0.01]),
        }
    }

    /// Heading and rudder of the part of the long record that is estimated online.
    pub fn online(&self) -> (&[f64], &[f64]) {
        (&self.long.heading[..ONLINE], &self.long.rudder[..ONLINE])
    }

    /// Writes the records where the peers read them.
    pub fn write(&self, folder: &Path) -> Outcome<()> {
        for (name, signal) in [
            ("heading_short", &self.short.heading[..]),
            ("rudder_short", &self.short.rudder),
            ("heading_long", &self.long.heading),
            ("rudder_long", &self.long.rudder),
            ("start", &self.start.theta()),
        ] {
            let bytes: Vec<u8> = signal.iter().flat_map(|w| w.to_le_bytes()).collect();
            fs::write(folder.join(name), bytes)?;
        }
        Ok(())
    }
}

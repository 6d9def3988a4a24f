//! The records that everybody works on.

use std::fs;
use std::path::Path;

use seatrial_core::model::{YawModel, YawState};
use seatrial_core::{FixedRateSettings, Sample};
use seatrial_kernels::{NoisyRuns, normals_of_run};

use crate::{INITIAL_COVARIANCE, INTERVAL_S, LAMBDA_RAD_S, LONG, ONLINE, Outcome, RECORDS, SHORT};

/// Standard deviation of the heading noise, rad.
const NOISE_RAD: f64 = 0.02;

/// Runs of the Monte Carlo study.
pub const RUNS: u64 = 2000;

/// A vehicle that steers to both sides all the time; heading without and with noise, and rudder.
pub struct Signals {
    pub truth: Vec<f64>,
    pub heading: Vec<f64>,
    pub rudder: Vec<f64>,
}

impl Signals {
    fn new(samples: usize, run: u64) -> Self {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let mut state = YawState::default();
        let (truth, rudder): (Vec<f64>, Vec<f64>) = (0..samples)
            .map(|k| {
                let rudder = match k % 210 {
                    40..80 => 0.26,
                    80..120 => -0.26,
                    _ => -0.011,
                };
                let heading = state.heading_rad;
                state = model.advance(state, rudder, INTERVAL_S);
                (heading, rudder)
            })
            .unzip();
        let noise = normals_of_run(7, run, samples);
        let heading = truth
            .iter()
            .zip(noise)
            .map(|(psi, z)| psi + 0.1 * NOISE_RAD * z)
            .collect();
        Self {
            truth,
            heading,
            rudder,
        }
    }
}

/// What is measured on.
pub struct Data {
    pub settings: FixedRateSettings<f64>,
    pub short: Signals,
    pub long: Signals,
    pub fleet_heading: Vec<f64>,
    pub fleet_rudder: Vec<f64>,
    /// The short record as samples.
    pub samples: Vec<Sample<f64>>,
    /// Where the refined estimate starts.
    pub start: YawModel<f64>,
}

impl Data {
    pub fn new() -> Self {
        let short = Signals::new(SHORT, 0);
        let fleet: Vec<Signals> = (0..RECORDS as u64)
            .map(|record| Signals::new(SHORT, record))
            .collect();
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
            fleet_heading: fleet.iter().flat_map(|s| s.heading.clone()).collect(),
            fleet_rudder: fleet.iter().flat_map(|s| s.rudder.clone()).collect(),
            samples,
            start: YawModel::from_theta([-1.0, 1.0, 0.01]),
        }
    }

    /// Heading and rudder of the part of the long record that is estimated online.
    pub fn online(&self) -> (&[f64], &[f64]) {
        (&self.long.heading[..ONLINE], &self.long.rudder[..ONLINE])
    }

    pub fn noisy_runs(&self) -> NoisyRuns<'_> {
        NoisyRuns {
            heading_rad: &self.short.truth,
            rudder_rad: &self.short.rudder,
            heading_noise_rad: NOISE_RAD,
            seed: 1,
            runs: RUNS,
        }
    }

    /// Writes the records where the peers read them.
    pub fn write(&self, folder: &Path) -> Outcome<()> {
        for (name, signal) in [
            ("heading_short", &self.short.heading[..]),
            ("rudder_short", &self.short.rudder),
            ("truth_short", &self.short.truth),
            ("heading_long", &self.long.heading),
            ("rudder_long", &self.long.rudder),
            ("heading_fleet", &self.fleet_heading),
            ("rudder_fleet", &self.fleet_rudder),
            ("start", &self.start.theta()),
        ] {
            let bytes: Vec<u8> = signal.iter().flat_map(|w| w.to_le_bytes()).collect();
            fs::write(folder.join(name), bytes)?;
        }
        Ok(())
    }
}

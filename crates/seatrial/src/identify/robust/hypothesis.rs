//! One hypothesis of rudder and sea, and what is believed of it before a record is seen.

use seatrial_core::refine::DisturbancePrior;
use seatrial_core::whitening::Covariance;

use super::noise::whiten;
use super::normal::above_zero;
use super::peak::Peak;
use super::record::{B2, DELAY, FIRST, LAG2, PARAMETERS, Record};

/// Ratio between neighbouring strengths of the disturbance.
pub const STRENGTH_RATIO: f64 = 2.5;

/// What is believed of lag and disturbance before a record is seen.
#[derive(Clone, Copy, Debug)]
pub struct Prior {
    /// Probability that the rudder acts at once.
    prompt: f64,
    /// What is believed of the disturbance.
    disturbance: DisturbancePrior,
}

/// The prior that the estimate is the mean under.
pub const EXPECTED: Prior = Prior { prompt: 0.95, disturbance: DisturbancePrior::EXPECTED };

/// The prior of the interval, which should also hold for a record that is worse than expected.
pub const CAUTIOUS: Prior = Prior { prompt: 0.8, disturbance: DisturbancePrior::CAUTIOUS };

impl Prior {
    /// Of a rudder that acts at once or lags, and a disturbance of such a share.
    pub fn log_of(&self, prompt: bool, share: f64) -> f64 {
        let lag = match prompt {
            true => self.prompt,
            false => 1.0 - self.prompt,
        };
        self.disturbance.log_of(share, STRENGTH_RATIO, lag)
    }
}

/// A lag or none, a disturbance or none, and what the record says if they are the true ones.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    /// The likelihood's peak.
    pub peak: Peak,
    /// The disturbance's standard deviation over the rudder's effect, b2 times its amplitude; 0 for none.
    pub share: f64,
    /// Log of the probability of the record.
    pub log_evidence: f64,
    /// Mean of the parameters.
    pub mean: [f64; PARAMETERS],
    /// Covariance of the parameters.
    pub covariance: [[f64; PARAMETERS]; PARAMETERS],
}

impl Hypothesis {
    /// From its peak.
    pub fn of(peak: Peak, record: &Record) -> Self {
        let share =
            peak.noise.relative * peak.noise_rad / (peak.mean[B2].abs() * record.amplitude_rad);
        let mut covariance = peak.covariance;
        if peak.prompt {
            for held in [FIRST, DELAY, LAG2] {
                covariance[held][held] = 0.0;
            }
            return Self {
                share,
                log_evidence: peak.log_evidence,
                mean: peak.mean,
                covariance,
                peak,
            };
        }
        let deviation = covariance[LAG2][LAG2].sqrt();
        let cut = above_zero(peak.mean[LAG2] / deviation);
        let column: [f64; PARAMETERS] = core::array::from_fn(|i| covariance[i][LAG2] / deviation);
        // A cut narrows as a measurement does whose noise is as much larger.
        let mut cut_covariance = Covariance(covariance);
        cut_covariance.measure(LAG2, deviation * deviation * (1.0 / cut.narrowing - 1.0));
        Self {
            share,
            log_evidence: peak.log_evidence + cut.log_probability,
            mean: core::array::from_fn(|i| peak.mean[i] + column[i] * cut.shift),
            covariance: cut_covariance.0,
            peak,
        }
    }
}

impl Hypothesis {
    /// Log of its weight under a prior, up to a constant of the record.
    pub fn log_weight(&self, prior: &Prior) -> f64 {
        prior.log_of(self.peak.prompt, self.share) + self.log_evidence
    }

    /// Its prediction errors, in standard deviations.
    pub fn innovations(&self, record: &Record, block: usize) -> Vec<f64> {
        let around = record.linearised(&self.peak.point, block, self.peak.prompt);
        let mut rows: Vec<[f64; 1]> = (around.rows.iter()).map(|row| [row[PARAMETERS]]).collect();
        whiten(&around.time_s, &mut rows, &self.peak.noise);
        rows.iter().map(|[error]| error / self.peak.noise_rad).collect()
    }
}

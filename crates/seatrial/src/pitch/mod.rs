//! The diving plane: the paper's identification carried to pitch, with elevator doublets and depth held in between.

mod fit;
mod trial;

use seatrial_core::{DivingSample, PitchEstimator, PitchModel, PitchState};
use serde::{Deserialize, Serialize};

use crate::record::Window;

pub use fit::{Fit, fit};
pub use trial::{PitchPlan, PitchRun, PitchTrial, trial};

/// The pole of the state variable filter, rad/s: twice that of yaw, for doublets of half the length.
pub const LAMBDA_RAD_S: f64 = 3.0;
/// R^2 of pitch on validation data from which a model is accepted, as for heading.
pub const ACCEPT_FROM_R2: f64 = 0.6;
/// Elevator movement that counts as excitation, rad.
const EXCITED_RAD: f64 = 0.02;

/// A pitch model with what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PitchIdentification {
    /// The training window, s.
    pub training: Window,
    /// The estimate that runs along: instrumental variable.
    pub online: PitchModel<f64>,
    /// Samples that it learnt from.
    pub samples_used: u32,
    /// The refined estimate: output error.
    pub refined: Fit,
    /// R^2 of pitch on validation data, and the window; `None` without validation data.
    #[serde(alias = "fresh")]
    pub validation: Option<PitchValidation>,
    /// Accepted?
    pub accepted: bool,
    /// Why, in words.
    pub reason: String,
}

/// How the refined model does on validation data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PitchValidation {
    /// The window, s.
    pub window: Window,
    /// R^2 of pitch, simulated freely over the whole window from the elevator alone. The offset is estimated
    /// again: trim depends on depth and speed.
    pub r2_pitch: f64,
}

/// Why there is no pitch model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPitchModel {
    /// Too few samples.
    #[error("{found} usable samples in the {window}; a pitch model needs at least {needed}")]
    TooFew {
        /// Which window.
        window: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The elevator did not move.
    #[error("the elevator moves by {:.2} degrees in the training window: an elevator doublet of some degrees is needed", moved_rad.to_degrees())]
    NotExcited {
        /// Range of its angle, rad.
        moved_rad: f64,
    },
    /// The search did not end at a model.
    #[error("no pitch model explains the training window")]
    NoFit,
}

/// Samples that a fit needs.
const LEAST_SAMPLES: usize = 40;

/// Identifies the pitch model from the training window of a record, and validates it on validation data.
///
/// The filters are warmed on what lies before the window. Excitation ends with the last large movement of the
/// elevator.
pub fn identify(
    samples: &[DivingSample<f64>],
    training: Window,
    validation: Option<Window>,
) -> Result<PitchIdentification, NoPitchModel> {
    let inside = usable(samples, training, "training window")?;
    let elevators = || inside.iter().map(|s| s.elevator_rad);
    let moved_rad =
        elevators().fold(f64::NEG_INFINITY, f64::max) - elevators().fold(f64::INFINITY, f64::min);
    if moved_rad < EXCITED_RAD {
        return Err(NoPitchModel::NotExcited { moved_rad });
    }
    let mut estimator = PitchEstimator::new(LAMBDA_RAD_S);
    for sample in samples.iter().filter(|s| s.time_s < inside[0].time_s) {
        estimator.warm(sample);
    }
    let ended_s = excitation_end_s(&inside, moved_rad);
    for sample in &inside {
        if sample.time_s >= ended_s {
            estimator.excitation_ended();
        }
        estimator.update(sample);
    }
    let online = estimator.model();
    let refined = fit(&inside, &online).ok_or(NoPitchModel::NoFit)?;
    let validation = validation
        .map(|window| {
            let samples = usable(samples, window, "validation window")?;
            let r2_pitch = fit::r2(&samples, &refined.model).ok_or(NoPitchModel::NoFit)?;
            Ok(PitchValidation { window, r2_pitch })
        })
        .transpose()?;
    let stable = refined.model.damping_per_s < 0.0;
    let (accepted, reason) = match validation {
        _ if !stable => (
            false,
            "a is not negative: pitch would not be damped".to_owned(),
        ),
        None => (true, "no data to validate on".to_owned()),
        Some(validation) => (
            validation.r2_pitch >= ACCEPT_FROM_R2,
            format!(
                "explains {:.0} % of the pitch of the validation data; {:.0} % are needed",
                100.0 * validation.r2_pitch,
                100.0 * ACCEPT_FROM_R2
            ),
        ),
    };
    Ok(PitchIdentification {
        training,
        online,
        samples_used: estimator.samples_used(),
        refined,
        validation,
        accepted,
        reason,
    })
}

/// The samples of a window that are finite and increase in time.
fn usable(
    samples: &[DivingSample<f64>],
    window: Window,
    name: &'static str,
) -> Result<Vec<DivingSample<f64>>, NoPitchModel> {
    let mut usable: Vec<DivingSample<f64>> = Vec::new();
    for sample in samples.iter().filter(|s| window.contains(s.time_s)) {
        let finite = sample.pitch_rad.is_finite() && sample.elevator_rad.is_finite();
        if finite && usable.last().is_none_or(|last| sample.time_s > last.time_s) {
            usable.push(*sample);
        }
    }
    if usable.len() < LEAST_SAMPLES {
        return Err(NoPitchModel::TooFew {
            window: name,
            found: usable.len(),
            needed: LEAST_SAMPLES,
        });
    }
    Ok(usable)
}

/// When the elevator last moved by a third of its range from one sample to the next, s.
fn excitation_end_s(samples: &[DivingSample<f64>], moved_rad: f64) -> f64 {
    let last = samples
        .windows(2)
        .rfind(|pair| (pair[1].elevator_rad - pair[0].elevator_rad).abs() > moved_rad / 3.0);
    last.map_or(f64::INFINITY, |pair| pair[1].time_s)
}

/// The pitch that a model gives at each sample, from the elevator alone.
pub fn simulate(
    model: &PitchModel<f64>,
    start: PitchState<f64>,
    samples: &[DivingSample<f64>],
) -> Vec<f64> {
    let mut state = start;
    let mut pitches = vec![start.pitch_rad];
    for pair in samples.windows(2) {
        let interval_s = pair[1].time_s - pair[0].time_s;
        state = model.advance(state, pair[0].elevator_rad, interval_s);
        pitches.push(state.pitch_rad);
    }
    pitches
}

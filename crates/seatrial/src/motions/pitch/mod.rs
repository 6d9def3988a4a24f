//! The axis of pitch: the paper's identification with a restoring moment, from elevator doublets.
//!
//! The [heading](seatrial_core::Sample::heading_rad) of a sample is its pitch here and the rudder its elevator, see
//! [`Axis`](seatrial_core::Axis). The model is an [`Identification`] as that of yaw, with m beside it
//! ([`Restoring`](crate::identification::Restoring)):
//!
//! ```text
//! theta'' = a22 theta' + m theta + b2 delta_e + C0
//! ```

mod fit;

use seatrial_core::estimator::EstimatorSettings;
use seatrial_core::{GoodnessOfFit, PitchModel, Plan, Sample};

use crate::figures::{degrees, r2_text};
use crate::identification::{
    Identification, LEAST_R2, Reason, ReasonCode, ReasonKind, Settings, Subject, Validation,
    Verdict,
};
use crate::identify::online::{self, Pass, Segment};
use crate::identify::validation::heading_range_rad;
use crate::identify::{IdentifyError, ValidationData, WindowUse, valid_range};
use crate::record::{Record, Window};
use crate::time_scale::LambdaReason;

pub use fit::{Fit, fit, simulate};

/// Elevator movement that counts as excitation, rad.
const EXCITED_RAD: f64 = 0.02;
/// Samples that a fit needs.
const LEAST_SAMPLES: usize = 40;

/// Identifies the pitch model from the training window of a record, and validates it on validation data.
///
/// The filters are those of [`Plan::pitch`], warmed on what lies before the window. Excitation ends with the last large
/// movement of the elevator.
///
/// ```
/// use seatrial::motions::pitch::{identify, simulate};
/// use seatrial::{Record, Sample, Window};
/// use seatrial_core::{PitchModel, PitchState};
///
/// let rudder_rad = |k| match k % 400 {
///     120..160 => 0.15,
///     160..200 => -0.15,
///     _ => 0.0,
/// };
/// let mut record: Record = (0..400)
///     .map(|k| Sample { time_s: 0.05 * f64::from(k), rudder_rad: rudder_rad(k), ..Sample::default() })
///     .collect();
/// let truth = PitchModel::from_theta([-1.2, -0.4, 0.8, 0.0]);
/// let pitch_rad = simulate(&truth, PitchState::default(), &record.samples);
/// for (sample, pitch_rad) in record.samples.iter_mut().zip(pitch_rad) {
///     sample.heading_rad = (1e4 * pitch_rad).round() / 1e4;
/// }
/// let found = identify(&record, Window { from_s: 4.0, to_s: 20.0 }, None)?;
/// assert!(found.restoring.is_some_and(|restoring| (restoring.refined_per_s2 + 0.4).abs() < 0.01));
/// # Ok::<(), seatrial::identify::IdentifyError>(())
/// ```
pub fn identify(
    record: &Record,
    training: Window,
    data: Option<ValidationData>,
) -> Result<Identification, IdentifyError> {
    let inside = usable(record, training, WindowUse::Training)?;
    let excited_by_s = excitation_end_s(&inside);
    let settling = record.window(Window { from_s: f64::NEG_INFINITY, to_s: inside[0].time_s });
    let segment =
        Segment { settling, training: &inside, learns_from_s: inside[0].time_s, excited_by_s };
    let estimator: EstimatorSettings<f64> = Plan::pitch().estimator_settings();
    let pass = online::estimate(&segment, estimator, true).map_err(IdentifyError::Setting)?;
    let settings =
        Settings { lambda_because: LambdaReason::PlansDoublet, ..Settings::of(&estimator) };
    assess(record, training, data, pass, settings)
}

/// Refines the model of a pass over the training window, validates it and judges it.
pub fn assess(
    record: &Record,
    training: Window,
    data: Option<ValidationData>,
    mut pass: Pass,
    settings: Settings,
) -> Result<Identification, IdentifyError> {
    let inside = usable(record, training, WindowUse::Training)?;
    let online_m = pass.restoring_per_s2.unwrap_or_default();
    let online = PitchModel::righted(&pass.online.model, online_m);
    let fit = fit(&inside, &online).ok_or_else(|| {
        IdentifyError::Refused(Reason::new(
            ReasonCode::NotIdentifiable.of(Subject::Pitch),
            "the search for the model whose simulation is nearest to the pitch found none",
        ))
    })?;
    let held_out = data
        .map(|data| {
            let samples = usable(data.record, data.window, WindowUse::Validation)?;
            Ok((data.window, samples))
        })
        .transpose()?;
    let refined = fit.refined();
    let validation = held_out.as_ref().map(|(window, samples)| {
        let found = goodness_of_fit(&fit.model, samples);
        Validation {
            window: window.known_part(samples),
            r2_heading: found.r2_heading,
            r2_heading_offset_refit: found.r2_heading_offset_refit,
            r2_yaw_rate: found.r2_yaw_rate,
            samples: samples.len(),
            horizon_s: None,
        }
    });
    let mut seen = vec![inside.as_slice()];
    seen.extend(held_out.iter().map(|(_, samples)| samples.as_slice()));
    // Batch least squares know no restoring moment.
    pass.online.batch = None;
    Ok(Identification {
        training: training.known_part(&inside),
        samples_used: pass.samples_used,
        samples_rejected: pass.rejected,
        settings,
        online: pass.online,
        nomoto: None,
        restoring: Some(fit.restoring(online_m)),
        valid_range: valid_range(&seen, &refined.model, refined.heading_noise_rad),
        refined: Some(refined),
        verdict: judge(&fit, validation.as_ref()),
        validation,
        higher_order: None,
        lag_effect: None,
        loop_timing: None,
    })
}

/// R^2 of the pitch that a model gives, from any start.
fn goodness_of_fit(model: &PitchModel<f64>, samples: &[Sample<f64>]) -> GoodnessOfFit<f64> {
    let mut validation = seatrial_core::Validation::new(model.without_restoring(), 0.0)
        .righted_by(Some(model.restoring_per_s2));
    for sample in samples {
        validation.compare(sample);
    }
    validation.goodness_of_fit_from_any_start()
}

/// Weighs a model by its damping, its authority and its validation data.
fn judge(fit: &Fit, validation: Option<&Validation>) -> Verdict {
    let mut rejections = Vec::new();
    let mut reject =
        |kind: ReasonKind, measured: String| rejections.push(Reason::new(kind, measured));
    let a = fit.model.damping_per_s;
    if a >= 0.0 {
        reject(ReasonCode::Unstable.of(Subject::Pitch), format!("a = {a:.3} 1/s is not negative"));
    }
    if fit.authority_may_be_zero() {
        let [_, _, [low, high], _] = fit.interval_95;
        reject(
            ReasonCode::NotIdentifiable.of(Subject::Pitch),
            format!("the 95 % interval of b, {low:.3} to {high:.3} 1/s^2, holds 0"),
        );
    }
    let r2 = validation.map(|validation| validation.r2_heading_offset_refit);
    match r2 {
        None => reject(
            ReasonCode::NotValidated.into(),
            "nothing was held out to check the model".into(),
        ),
        Some(r2) if r2.is_none_or(|r2| r2 < LEAST_R2) => reject(
            ReasonCode::LowR2.into(),
            format!(
                "R^2 of pitch on validation data is {} with the offset estimated again; at least {LEAST_R2} is needed: repeat the run",
                r2_text(r2)
            ),
        ),
        Some(_) => {}
    }
    let accepted = rejections.is_empty();
    if accepted {
        rejections.push(Reason::new(
            ReasonCode::Ok,
            format!(
                "the model holds on validation data: R^2 of pitch with the offset estimated again {}",
                r2_text(r2.flatten())
            ),
        ));
    }
    Verdict { accepted, reasons: rejections }
}

/// The samples of a window that are finite and increase in time; refused where they are too few, or no elevator moves in training.
fn usable(
    record: &Record,
    window: Window,
    wanted: WindowUse,
) -> Result<Vec<Sample<f64>>, IdentifyError> {
    let usable = record.usable(window);
    if usable.is_empty() {
        return Err(IdentifyError::empty_window(wanted, window, record));
    }
    if usable.len() < LEAST_SAMPLES {
        return Err(IdentifyError::Refused(Reason::new(
            ReasonCode::TooFewSamples,
            format!(
                "{} usable samples in the {wanted} window, at least {LEAST_SAMPLES} are needed; widen the window or log faster",
                usable.len()
            ),
        )));
    }
    let moved_rad = elevator_range_rad(&usable);
    if wanted == WindowUse::Training && moved_rad < EXCITED_RAD {
        return Err(IdentifyError::Refused(Reason::new(
            ReasonCode::Constant.of(Subject::Elevator),
            format!(
                "the elevator moves by {} deg in the training window: nothing pitches the vehicle",
                degrees(moved_rad)
            ),
        )));
    }
    if wanted == WindowUse::Training && heading_range_rad(&usable) == 0.0 {
        return Err(IdentifyError::Refused(Reason::new(
            ReasonCode::NotIdentifiable.of(Subject::Pitch),
            "the pitch does not change while the elevator moves",
        )));
    }
    Ok(usable)
}

fn elevator_range_rad(samples: &[Sample<f64>]) -> f64 {
    let elevators = || samples.iter().map(|sample| sample.rudder_rad);
    elevators().fold(f64::NEG_INFINITY, f64::max) - elevators().fold(f64::INFINITY, f64::min)
}

/// When the elevator last moved by a third of its range from one sample to the next, s.
fn excitation_end_s(samples: &[Sample<f64>]) -> Option<f64> {
    let moved_rad = elevator_range_rad(samples);
    let last = samples
        .windows(2)
        .rfind(|pair| (pair[1].rudder_rad - pair[0].rudder_rad).abs() > moved_rad / 3.0);
    last.map(|pair| pair[1].time_s)
}

//! May a model be used? What was measured, what it means and what to do next.

mod compass;
mod contradiction;
mod fresh_data;
mod parameters;
mod record;

use seatrial_core::{GoodnessOfFit, YawModel};

use crate::identification::{HigherOrder, LagEffect, Reason, Refined, Validation, Verdict};
use crate::identify::compass::CompassError;
use crate::identify::second_order::ResidualTests;
use crate::record::RudderUnit;
use fresh_data::LEAST_VALIDATION_R2;
pub use parameters::{WIDEST_A22, WIDEST_B2};

/// Three parameters, two initial conditions and a noise level need some samples each.
const LEAST_SAMPLES: usize = 30;

/// A rudder that moves less than this, rad (0.1 deg), was not moved; a heading likewise.
const LEAST_MOVEMENT_RAD: f64 = 0.0017;

/// What was measured of a training record and its model.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// Samples that reached the estimator.
    pub samples_used: usize,
    /// Samples that did not.
    pub samples_rejected: u32,
    /// Half of the rudder's range in training, rad.
    pub rudder_amplitude_rad: f64,
    /// How far the rudder went to either hand from rest in training, rad, where it was laid to both.
    pub rudder_hands_rad: Option<[f64; 2]>,
    /// In what these are.
    pub rudder_unit: RudderUnit,
    /// The heading's range in training, rad.
    pub heading_range_rad: f64,
    /// The step in which the heading is given, rad, where it is coarser than its noise.
    pub heading_step_rad: Option<f64>,
    /// Mean speed of the first and of the last quarter of the training, m/s.
    pub surge_speed_m_s: Option<[f64; 2]>,
    /// The usual interval between samples and the one that one in twenty exceeds, s.
    pub interval_s: Option<[f64; 2]>,
    /// The estimate made sample by sample.
    pub online: YawModel<f64>,
    /// Must there be an estimate from the whole record with its interval?
    pub needs_interval: bool,
    /// How the compass parts from the gyro.
    pub compass: CompassError,
    /// The estimate made from the whole record.
    pub refined: Option<&'a Refined>,
    /// The share of the rudder's effect that a disturbance would have to have, where the vehicle is not of first order.
    pub mismatch: Option<f64>,
    /// The share of the rudder's effect that a disturbance has, where it is large.
    pub disturbed: Option<f64>,
    /// The model beyond the first order that explains it.
    pub higher_order: Option<&'a HigherOrder>,
    /// What a lag of the rudder that the log does not tell would do.
    pub lag_effect: Option<&'a LagEffect>,
    /// What a first-order model with the likeliest disturbance leaves unexplained.
    pub residual: Option<ResidualTests>,
    /// Times that the rudder moved far while samples were lost.
    pub hidden_edges: usize,
    /// R^2 on the training record itself.
    pub training_fit: GoodnessOfFit<f64>,
    /// R^2 on fresh data.
    pub validation: Option<Validation>,
    /// The largest jump of the heading from where the measured yaw rate takes it, rad, in fresh data that are not those
    /// of the training.
    pub fresh_jump_rad: Option<f64>,
    /// The estimate made from the fresh data alone, where they are not those of the training and give one.
    pub fresh: Option<&'a Refined>,
    /// Half of the rudder's range in validation, rad.
    pub validation_rudder_amplitude_rad: Option<f64>,
}

/// A record that cannot give any model at all: the reason, or `None` where one may be tried.
pub fn refuse_record(
    samples: usize,
    rudder_amplitude_rad: f64,
    rudder_unit: RudderUnit,
    heading_range_rad: f64,
) -> Option<Reason> {
    if samples < LEAST_SAMPLES {
        return Some(reason(
            "too_few_samples",
            format!(
                "{samples} usable samples in the training window, at least {LEAST_SAMPLES} are needed; widen the window or log faster"
            ),
        ));
    }
    if rudder_amplitude_rad < LEAST_MOVEMENT_RAD {
        return Some(rudder_constant(rudder_amplitude_rad, rudder_unit));
    }
    if heading_range_rad < LEAST_MOVEMENT_RAD {
        return Some(reason(
            "heading_constant",
            format!(
                "the heading stays within {} deg while the rudder moves {} either side; check that the heading channel is alive",
                degrees(heading_range_rad),
                rudder(rudder_amplitude_rad, rudder_unit)
            ),
        ));
    }
    None
}

/// The reason to refuse a record in which the rudder stays where it is.
pub fn rudder_constant(rudder_amplitude_rad: f64, rudder_unit: RudderUnit) -> Reason {
    reason(
        "rudder_constant",
        format!(
            "the rudder stays within {}: nothing excites the vehicle; command a doublet, or choose a window with one",
            rudder(rudder_amplitude_rad, rudder_unit)
        ),
    )
}

/// Weighs the evidence.
pub fn judge(evidence: &Evidence) -> Verdict {
    let mut weighing = Weighing::default();
    weighing.record(evidence);
    match evidence.refined {
        Some(refined) => {
            weighing.intervals(refined, evidence);
            weighing.agreement(evidence.online, refined);
            if let Some(effect) = evidence.lag_effect {
                weighing.lag(refined, effect);
            }
            if let (Some(residual), None) = (&evidence.residual, evidence.mismatch) {
                weighing.residual(residual, refined, evidence.heading_range_rad);
            }
        }
        None if evidence.needs_interval => weighing.reject(
            "not_identifiable",
            "the whole record gives no model with an interval: the heading does not follow the rudder as one model; repeat the manoeuvre".into(),
        ),
        None => {}
    }
    weighing.model(evidence);
    weighing.fresh_data(evidence.validation);
    if let (Some(refined), Some(fresh)) = (evidence.refined, evidence.fresh) {
        weighing.trained(refined, fresh, evidence);
    }
    weighing.extrapolation(evidence);
    weighing.verdict(evidence.validation)
}

/// Weighs a given model by fresh data alone, and by the model that they give by themselves.
pub fn judge_fresh_data(
    model: &YawModel<f64>,
    validation: Validation,
    fresh: Option<&Refined>,
) -> Verdict {
    let mut weighing = Weighing::default();
    weighing.fresh_data(Some(validation));
    if let Some(fresh) = fresh {
        weighing.given(model, fresh);
    }
    weighing.verdict(Some(validation))
}

/// A verdict of one rejecting reason.
pub fn refused(reason: Reason) -> Verdict {
    Verdict {
        accepted: false,
        reasons: vec![reason],
    }
}

/// The verdict on a run that the trial itself did not take: live, its R^2 on fresh data was under what the plan
/// asks for.
pub fn not_taken(
    judged: Verdict,
    live: &GoodnessOfFit<f64>,
    accept_from_r2: f64,
    is_repeated: bool,
) -> Verdict {
    let then = if is_repeated {
        "the run was repeated"
    } else {
        "no tries were left"
    };
    let low_r2 = reason(
        "low_r2",
        format!(
            "with the live model R^2 on fresh data was {} for heading, {} with the offset estimated again, {} for yaw rate; the plan accepts from {accept_from_r2:.2}: {then}",
            r2_text(live.r2_heading),
            r2_text(live.r2_heading_offset_refit),
            r2_text(live.r2_yaw_rate)
        ),
    );
    let others = judged.reasons.into_iter().filter(|r| r.code != "ok");
    Verdict {
        accepted: false,
        reasons: std::iter::once(low_r2).chain(others).collect(),
    }
}

#[derive(Default)]
struct Weighing {
    rejections: Vec<Reason>,
    notes: Vec<Reason>,
}

impl Weighing {
    fn reject(&mut self, code: &str, text: String) {
        self.rejections.push(reason(code, text));
    }

    fn note(&mut self, code: &str, text: String) {
        self.notes.push(reason(code, text));
    }

    fn verdict(self, validation: Option<Validation>) -> Verdict {
        let accepted = self.rejections.is_empty();
        let mut reasons = self.rejections;
        if accepted {
            reasons.push(reason(
                "ok",
                match validation {
                    Some(v) => {
                        let trained = v.r2_heading >= Some(LEAST_VALIDATION_R2);
                        let (heading, offset) = if trained {
                            (v.r2_heading, "")
                        } else {
                            (v.r2_heading_offset_refit, " with the offset estimated again")
                        };
                        format!(
                            "the model holds on fresh data: R^2 of heading{offset} {}, of yaw rate {}",
                            r2_text(heading),
                            r2_text(v.r2_yaw_rate)
                        )
                    }
                    None => "the model describes its training record".into(),
                },
            ));
        }
        reasons.extend(self.notes);
        Verdict { accepted, reasons }
    }
}

/// A 95 % interval as a share of its parameter.
struct Share {
    interval: [f64; 2],
    half_width: f64,
}

impl Share {
    fn new(value: f64, interval: [f64; 2]) -> Self {
        Self {
            interval,
            half_width: 0.5 * (interval[1] - interval[0]) / value.abs(),
        }
    }
}

fn reason(code: &str, text: String) -> Reason {
    Reason {
        code: code.into(),
        text,
    }
}

fn r2_text(r2: Option<f64>) -> String {
    r2.map_or_else(|| "not known".into(), |r2| format!("{r2:.2}"))
}

fn degrees(angle_rad: f64) -> String {
    three_figures(angle_rad.to_degrees())
}

/// A rudder as people read it.
fn rudder(amplitude: f64, unit: RudderUnit) -> String {
    let (scale, name) = unit.for_people();
    format!("{} {name}", three_figures(scale * amplitude))
}

fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// A number to three significant figures, as people read it.
pub fn three_figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 2 - value.abs().log10().floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

#[cfg(test)]
mod tests;

//! Does the model hold on data that it was not made from?

use seatrial_core::YawModel;

use super::contradiction::{BLIND, GIVEN, STOPPED, TRAINED, contradiction, weakness};
use super::{MOST_TIMES, Weighing};
use crate::figures::{r2_text, three_figures};
use crate::identification::{
    EstimateMethod, LEAST_R2, Reason, ReasonCode, Refined, Subject, Validation,
};
use crate::identify::model_evidence::{Independent, ModelEvidence};
use crate::record::{RudderUnit, rudder_text};

/// Rudder angles of validation data beyond the trained ones by this factor are an extrapolation.
const NOTED_EXTRAPOLATION: f64 = 1.2;

/// Deviations beyond which the offset changed: 99 %.
const CERTAIN: f64 = 2.58;

/// A change of b2 by less, as its logarithm, is not put down to the speed.
const LEAST_OF_SPEED: f64 = 0.15;

/// R^2 of heading that a model with 70 % of the rudder's effect does not reach on data of a rudder that did not stop: 1 - 0.3^2, and chance.
const STOPPED_R2: f64 = 0.93;

/// Where a jump of the compass was found.
const IN_VALIDATION: &str = "in the validation data";

/// How the offset C0 changed from training to validation data.
#[derive(Clone, Copy)]
pub(super) struct OffsetDrift {
    change_rad_s2: f64,
    /// Of the change.
    deviation_rad_s2: f64,
    b2_per_s2: f64,
    unit: RudderUnit,
}

impl OffsetDrift {
    pub(super) fn between(trained: &Refined, other: &Refined, unit: RudderUnit) -> Self {
        Self {
            change_rad_s2: other.model.c0_rad_per_s2 - trained.model.c0_rad_per_s2,
            deviation_rad_s2: (trained.covariance[2][2] + other.covariance[2][2]).sqrt(),
            b2_per_s2: trained.model.b2_per_s2,
            unit,
        }
    }

    fn is_certain(&self) -> bool {
        self.change_rad_s2.abs() > CERTAIN * self.deviation_rad_s2
    }

    fn rudder_text(&self) -> String {
        rudder_text(self.unit, (self.change_rad_s2 / self.b2_per_s2).abs())
    }
}

impl Weighing {
    /// `drift` is that of the offset from training to validation data, where both give one with its interval; `is_explained` tells that a sea
    /// explains a low R^2.
    pub(super) fn validation(
        &mut self,
        validation: Option<Validation>,
        drift: Option<OffsetDrift>,
        is_explained: bool,
    ) {
        let Some(validation) = validation else {
            return self.not_validated();
        };
        let good = |r2: Option<f64>| r2.is_some_and(|r2| r2 >= LEAST_R2);
        if good(validation.r2_heading) {
        } else if good(validation.r2_heading_offset_refit) && good(validation.r2_yaw_rate) {
            // A drift that the interval of the offset holds is known already.
            if drift.is_none_or(|drift| drift.is_certain()) {
                self.offset_drifted(validation, drift);
            }
        } else if is_explained {
            self.disturbed(validation);
        } else {
            self.reject(
                ReasonCode::LowR2,
                format!(
                    "R^2 on validation data is {} for heading, {} with the offset estimated again, {} for yaw rate; at least {LEAST_R2} is needed: repeat the run",
                    r2_text(validation.r2_heading), r2_text(validation.r2_heading_offset_refit), r2_text(validation.r2_yaw_rate)
                ),
            );
        }
    }

    /// Said once, also where the disturbance has been told already.
    fn disturbed(&mut self, validation: Validation) {
        let is_told = |reason: &Reason| reason.code == ReasonCode::Disturbed;
        if !self.notes.iter().any(is_told) {
            self.note(
                ReasonCode::Disturbed,
                format!(
                    "R^2 on validation data is {} for heading with the offset estimated again and {} for yaw rate: the sea of the training explains that",
                    r2_text(validation.r2_heading_offset_refit), r2_text(validation.r2_yaw_rate)
                ),
            );
        }
    }

    fn offset_drifted(&mut self, validation: Validation, drift: Option<OffsetDrift>) {
        let by =
            drift.map_or(String::new(), |drift| format!(", by {} of rudder", drift.rudder_text()));
        let reason = Reason::new(
            ReasonCode::Drifted.of(Subject::Offset),
            format!(
                "R^2 of heading on validation data is {} with the trained offset and {} with the offset estimated again: the model steers right, but the rudder that holds a straight course changed{by}",
                r2_text(validation.r2_heading),
                r2_text(validation.r2_heading_offset_refit)
            ),
        );
        self.notes.push(Reason {
            text: format!(
                "The rudder that holds a straight course changed between training and validation{by}."
            ),
            ..reason
        });
    }

    /// A compass that jumped is why its data are not predicted, and comes first.
    pub(super) fn jump_behind_low_r2(&mut self, evidence: &ModelEvidence) {
        let Some(jump) = evidence.independent.as_ref().and_then(|a| a.largest_jump) else {
            return;
        };
        let is_low = |reason: &mut Reason| reason.code == ReasonCode::LowR2;
        if let Some(low_r2) = self.rejections.pop_if(is_low) {
            self.jump(jump, IN_VALIDATION);
            self.rejections.push(low_r2);
        }
    }

    fn not_validated(&mut self) {
        self.reject(ReasonCode::NotValidated, "nothing was held out to check the model".into());
    }

    /// A model that is given against the one that validation data by themselves give.
    pub(super) fn given(&mut self, model: &YawModel<f64>, other: &Refined) {
        let is_turned = model.b2_per_s2 * other.model.b2_per_s2 < 0.0;
        if let Some(found) = contradiction(model, None, other, &GIVEN) {
            if is_turned {
                self.turned(&found);
            } else {
                self.contradicted(&found);
            }
        } else if let Some(times) = weakness(model, None, other, &GIVEN) {
            self.weakly_validated(times, "a model that is 30 % wrong", times > BLIND);
        }
    }

    /// A model just trained against the one that validation data by themselves give.
    ///
    /// Where the training shows more than first order, R^2 of the validation data is the judge, however uncertain the model that they give.
    pub(super) fn trained(
        &mut self,
        refined: &Refined,
        apart: &Independent,
        evidence: &ModelEvidence,
    ) {
        let Some(other) = &apart.estimate else {
            return;
        };
        // Both share the lag of the rudder, whatever it is.
        let given_delay = evidence.explanation.first_order();
        let covariance = given_delay.map_or(&refined.covariance, |fit| &fit.covariance_given_delay);
        let (model, covariance) = (&refined.model, Some(covariance));
        let saturated = saturated(refined, other, evidence);
        let is_of_higher_order = evidence.explanation.structural_misfit().is_some()
            || refined.method == EstimateMethod::WeighedHypotheses;
        let limits = match saturated {
            Some(_) => &STOPPED,
            None => &TRAINED,
        };
        match (contradiction(model, covariance, other, limits), saturated) {
            (Some(found), _) if model.b2_per_s2 * other.model.b2_per_s2 < 0.0 => {
                self.turned(&found);
            }
            (Some(_), _) if let Some(jump) = apart.largest_jump => {
                if !self.has(&ReasonCode::CompassError) {
                    self.jump(jump, IN_VALIDATION);
                }
            }
            (Some(found), _) if let Some(speeds) = speeds_apart(refined, other, apart) => self
                .reject(
                    ReasonCode::Drifted.of(Subject::Speed),
                    format!("the validation data by themselves give {found}: {speeds}"),
                ),
            (Some(_), Some(_))
                if is_of_higher_order && shows_no_lost_effect(refined, other, evidence) => {}
            (Some(found), Some(saturated)) => self.reject(
                ReasonCode::RudderNotFollowed,
                format!("the validation data by themselves give {found}: {saturated}"),
            ),
            (Some(found), None) => self.contradicted(&found),
            (None, _) => {
                let refuses = |times: f64| times > BLIND && !is_of_higher_order;
                let weak = weakness(model, covariance, other, &STOPPED);
                if let Some(times) =
                    weak.filter(|times| refuses(*times) || !predicts_too_well(evidence))
                {
                    self.weakly_validated(
                        times,
                        "a rudder that stops at 70 % of the training's angle",
                        refuses(times),
                    );
                }
            }
        }
    }

    fn contradicted(&mut self, found: &str) {
        self.reject(
            ReasonCode::Contradicted,
            format!(
                "the validation data by themselves give {found}: a rudder that saturates or jammed, another speed, a compass that errs, or a vehicle that changed; look at the rudder's own angle and at the compass, then train again"
            ),
        );
    }

    /// The other sign of b2 needs no damage to explain it.
    fn turned(&mut self, found: &str) {
        let measured = format!("the validation data by themselves give {found}");
        let reason = Reason {
            text: "The rudder or the heading of the validation data counts to the other side than the model's.".into(),
            action: "Turn one of the two columns: reversed = true in a [channels] file.".into(),
            ..Reason::new(ReasonCode::Contradicted, measured)
        };
        // What explains a low R^2 comes before it.
        self.rejections.insert(0, reason);
    }

    fn weakly_validated(&mut self, times: f64, wrong: &str, refuses: bool) {
        let remedy = match times <= MOST_TIMES {
            true => format!(
                "validate with {} times the rudder, or with {} manoeuvres, or in calmer water",
                three_figures(times),
                (times * times).ceil()
            ),
            false => "validate with a larger and longer manoeuvre, in calmer water".into(),
        };
        let text = format!(
            "the validation data by themselves are too uncertain to show {wrong}: {remedy}"
        );
        if refuses {
            self.reject(ReasonCode::UnderExcited.of(Subject::Validation), text);
        } else {
            self.note(ReasonCode::UnderExcited.of(Subject::Validation), text);
        }
    }

    pub(super) fn extrapolation(&mut self, evidence: &ModelEvidence) {
        let log = evidence.log;
        if let Some(other) = evidence
            .validation_rudder_amplitude_rad
            .filter(|other| *other > NOTED_EXTRAPOLATION * log.rudder_amplitude_rad)
        {
            self.note(
                ReasonCode::Extrapolating,
                format!(
                    "the validation data use {} of rudder either side, training only {}",
                    rudder_text(log.rudder_unit, other),
                    rudder_text(log.rudder_unit, log.rudder_amplitude_rad)
                ),
            );
        }
    }
}

/// Does the model predict the heading of validation data better than one of a rudder that stopped at 70 % of the training's angle could?
fn predicts_too_well(evidence: &ModelEvidence) -> bool {
    r2_of_heading(evidence).is_some_and(|r2| r2 > STOPPED_R2)
}

fn r2_of_heading(evidence: &ModelEvidence) -> Option<f64> {
    evidence.validation?.r2_heading_offset_refit
}

/// Does the model predict the heading of validation data with at most a quarter of the error that a rudder of b2/b2' of its effect would leave?
/// First-order models of a hull of higher order differ without one: three of 25 boats with sway were refused (`hulls -- 31337 25`).
///
/// ```text
/// 1 - R^2 < ((1 - b2/b2') / 4)^2
/// ```
fn shows_no_lost_effect(trained: &Refined, other: &Refined, evidence: &ModelEvidence) -> bool {
    let lost = 1.0 - trained.model.b2_per_s2 / other.model.b2_per_s2;
    r2_of_heading(evidence).is_some_and(|r2| 1.0 - r2 < (0.25 * lost).powi(2))
}

/// Where a larger angle in training than in the validation data turned the vehicle less per degree, at which angle the rudder
/// seems to stop, in words.
fn saturated(trained: &Refined, other: &Refined, evidence: &ModelEvidence) -> Option<String> {
    let log = evidence.log;
    let validation_rad = evidence.validation_rudder_amplitude_rad?;
    let share = trained.model.b2_per_s2 / other.model.b2_per_s2;
    let is_larger = log.rudder_amplitude_rad > NOTED_EXTRAPOLATION * validation_rad;
    (is_larger && (0.0..1.0).contains(&share)).then(|| {
        format!(
            "in training, with {} either side, the rudder did less per degree than with {}, as if it stopped at {}; look at its own angle, and train with less than that",
            rudder_text(log.rudder_unit, log.rudder_amplitude_rad),
            rudder_text(log.rudder_unit, validation_rad),
            rudder_text(log.rudder_unit, share * log.rudder_amplitude_rad)
        )
    })
}

/// Speeds of training and validation that explain why their b2 differ, in words: b2 goes with the square of the speed.
///
/// ```text
/// |ln(b2'/b2) - 2 ln(u'/u)| < |2 ln(u'/u)| / 2
/// ```
fn speeds_apart(trained: &Refined, other: &Refined, apart: &Independent) -> Option<String> {
    let [before_m_s, now_m_s] = apart.surge_speeds_m_s?;
    let expected = 2.0 * libm::log(now_m_s / before_m_s);
    let found = libm::log(other.model.b2_per_s2 / trained.model.b2_per_s2);
    let is_explained =
        expected.abs() > LEAST_OF_SPEED && (found - expected).abs() < 0.5 * expected.abs();
    is_explained.then(|| {
        format!(
            "the speed was {} m/s there and {} m/s in training, and b2 goes with its square; settle longer, so that both have one speed",
            three_figures(now_m_s),
            three_figures(before_m_s)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::verdict::tests::refined_at;

    #[test]
    fn exact_speeds_explain_the_b2_that_goes_with_their_square() {
        let trained = refined_at([-1.0, 1.0, 0.0], 0.05);
        let explanation = |speeds, b2| {
            let apart = Independent {
                length: 1.0,
                rudder_variance_ratio: 1.0,
                surge_speeds_m_s: speeds,
                largest_jump: None,
                estimate: None,
            };
            speeds_apart(&trained, &refined_at([-1.0, b2, 0.0], 0.05), &apart)
        };
        let text = explanation(Some([2.0, 1.5]), 0.5625).unwrap();
        assert!(text.contains("1.50 m/s there and 2.00 m/s in"), "{text}");
        // A rudder that lost more than the speed, one that does more at less speed, one speed, none.
        assert_eq!(explanation(Some([2.0, 1.5]), 0.3), None);
        assert_eq!(explanation(Some([2.0, 1.5]), 1.5), None);
        assert_eq!(explanation(Some([2.0, 1.96]), 0.96), None);
        assert_eq!(explanation(None, 0.5625), None);
        assert_eq!(explanation(Some([2.0, 1.5]), -0.5625), None);
    }
}

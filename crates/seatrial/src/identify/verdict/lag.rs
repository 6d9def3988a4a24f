//! A lag that a log does not tell: the rudder's, or that of a heading that is late or smoothed.

use super::Weighing;
use crate::figures::three_figures;
use crate::identification::{HigherOrder, Reason, ReasonCode};
use crate::identify::model_evidence::ModelEvidence;
use crate::likelihood::Parameter;

/// Lag in the vehicle's time constants from which the two are told apart too seldom: of a lag of three quarters of the time constant a22 is off
/// by two half widths at most, of an equal one by up to eight.
const LONGEST_LAG: f64 = 0.7;
/// What shows whether the rudder lags or the heading is late.
const LOG_BOTH: &str = "Log the measured rudder angle, and a gyro's yaw rate.";

/// The lag, s, that is all that a record has beyond first order, where nothing shows whether it is the rudder's or the heading's.
fn lag_of_either(evidence: &ModelEvidence) -> Option<f64> {
    let unchecked = lag_alone(evidence).filter(|_| evidence.log.is_heading_unchecked());
    Some(unchecked?.model.rudder_lag_s)
}

/// What a record has beyond first order, where that is a lag and no other hull.
fn lag_alone<'a>(evidence: &ModelEvidence<'a>) -> Option<&'a HigherOrder> {
    let higher = evidence.explanation.beyond()?;
    let lags = higher.structure.has(Parameter::Lag) && !higher.structure.has_own_hull();
    lags.then_some(higher)
}

impl Weighing {
    /// Notes what a record has beyond first order.
    pub(super) fn beyond(&mut self, detail: String, evidence: &ModelEvidence) {
        let reason = Reason::new(ReasonCode::ModelOrder, detail);
        self.notes.push(match lag_of_either(evidence) {
            Some(lag_s) => Reason {
                text: format!(
                    "The rudder lags, or the heading is late or smoothed, by {} s: the log does not show which.",
                    three_figures(lag_s)
                ),
                action: LOG_BOTH.into(),
                ..reason
            },
            None => reason,
        });
    }

    /// Rejects a model whose interval of b2, 1/s^2, holds 0.
    pub(super) fn holds_0(&mut self, interval: [f64; 2], evidence: &ModelEvidence) {
        let [low, high] = interval.map(three_figures);
        let holds_0 = format!("the 95 % interval of b2, {low} to {high} 1/s^2, holds 0");
        let Some(lag_s) = lag_of_either(evidence) else {
            return self.reject(
                ReasonCode::NotIdentifiable,
                format!(
                    "{holds_0}: the heading does not follow the rudder measurably; check that the two channels belong together, then excite with more rudder"
                ),
            );
        };
        let behind = format!(
            "behind a lag of {} s, of the rudder or of a heading that is late or smoothed",
            three_figures(lag_s)
        );
        let reason = Reason::new(
            ReasonCode::NotIdentifiable,
            format!("{holds_0} {behind}: log the measured rudder angle, and a gyro's yaw rate"),
        );
        self.rejections.push(Reason {
            text: format!("The heading follows the rudder {behind}: the log does not show which."),
            action: LOG_BOTH.into(),
            ..reason
        });
    }

    /// A lag about as long as the vehicle's own time constant may change places with it: the heading is the same.
    pub(super) fn lag_like_the_vehicle(&mut self, evidence: &ModelEvidence) {
        let Some(higher) = lag_alone(evidence) else {
            return;
        };
        let (lag_s, own_s) = (higher.model.rudder_lag_s, 1.0 / higher.model.a22_per_s.abs());
        if lag_s < LONGEST_LAG * own_s {
            return;
        }
        let (lag, own) = (three_figures(lag_s), three_figures(own_s));
        let (of, gyro) = match evidence.log.is_heading_unchecked() {
            true => ("the rudder's or a heading filter's", ", and a gyro's yaw rate"),
            false => ("the rudder's", ""),
        };
        let reason = Reason::new(
            ReasonCode::NotIdentifiable,
            format!(
                "the heading follows the rudder behind two lags of {own} and {lag} s, and does not show which is the vehicle's and which {of}: a22 may be that of either; log the measured rudder angle{gyro}"
            ),
        );
        self.rejections.push(Reason {
            text: format!(
                "The heading follows the rudder behind two lags, of {own} and {lag} s, and does not show which is the vehicle's and which {of}."
            ),
            action: format!("Log the measured rudder angle{gyro}."),
            ..reason
        });
        // Why an interval holds 0 is said once.
        let mut found = self.rejections.iter().enumerate();
        let first = found.find(|(_, reason)| reason.kind() == ReasonCode::NotIdentifiable.into());
        if let Some((first, _)) = first
            && first + 1 < self.rejections.len()
        {
            self.rejections.remove(first);
        }
    }
}

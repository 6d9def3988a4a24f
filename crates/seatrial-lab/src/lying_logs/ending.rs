//! What becomes of a log whose truth is known: is a wrong model accepted?

use std::path::Path;

use seatrial::Identification;
use seatrial::identification::{Reason, ReasonCode, ReasonKind, Subject, Verdict};
use seatrial_core::RudderUnit;
use serde::Serialize;

use crate::lies::LogTruth;

use seatrial_app::identify_log::{IdentifiedLog, Options, identify_log};

/// Half widths of the 95 % interval from the truth beyond which an accepted model is wrong.
pub const WRONG_BEYOND: f64 = 2.0;

/// What became of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ending {
    /// Was a model accepted?
    pub accepted: bool,
    /// Distance of the accepted model from the truth in half widths of its 95 % intervals, the larger of a22 and b2, of the
    /// worst of several models.
    pub farthest: Option<f64>,
    /// Errors of its a22 and b2 as shares of the truth.
    pub errors: Option<[f64; 2]>,
    /// Why it was refused; `unreadable` where the reader did.
    pub refused: Option<String>,
    /// What was noted of an accepted model.
    pub notes: Vec<ReasonKind>,
    /// What says that columns are wrong, and their quantities: the first reason of a refusal, every reason of an accepted model.
    pub blames: Vec<(String, Vec<&'static str>)>,
}

impl Ending {
    /// The outcome of a log that is read and identified as `seatrial identify` does, held against its truth.
    pub fn of(path: &Path, options: &Options, truth: &LogTruth) -> Self {
        match identify_log(path, options) {
            Ok(identified) => Self::of_identified(&identified, truth),
            Err(error) => {
                let blamed = named(&error.to_string());
                let refused = match error {
                    seatrial_app::Error::Rejected(_) => "rejected".to_owned(),
                    _ => format!("unreadable {}", blamed.join("+")).trim().into(),
                };
                Self {
                    accepted: false,
                    farthest: None,
                    errors: None,
                    refused: Some(refused.clone()),
                    notes: Vec::new(),
                    blames: vec![(refused, blamed)],
                }
            }
        }
    }

    /// Is its accepted model beyond two half widths of the truth?
    pub fn is_wrong(&self) -> bool {
        self.farthest.is_some_and(|farthest| farthest.is_nan() || farthest > WRONG_BEYOND)
    }

    /// Does it blame this column?
    pub fn names(&self, column: &str) -> bool {
        let mut columns = self.blames.iter().flat_map(|(_, columns)| columns);
        columns.any(|blamed| *blamed == column)
    }

    /// What blames others and not this column.
    pub fn accusation_beside(&self, column: &str) -> Option<&str> {
        let is_beside =
            |(_, columns): &&(String, Vec<&str>)| !columns.is_empty() && !columns.contains(&column);
        let beside = self.blames.iter().find(is_beside)?;
        Some(&beside.0)
    }

    fn of_identified(identified: &IdentifiedLog, truth: &LogTruth) -> Self {
        let found: Vec<(&Verdict, Option<&Identification>)> = match &identified.models {
            Some(models) => {
                models.iter().map(|model| (&model.verdict, model.identification.as_ref())).collect()
            }
            None => vec![(identified.verdict(), identified.identification())],
        };
        let accepted: Vec<_> = found.iter().filter(|(v, _)| v.accepted).collect();
        let unit = identified.logs.log.record.rudder_unit;
        let worst = accepted
            .iter()
            .filter_map(|(_, identification)| distance((*identification)?, truth, unit))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let verdict = accepted.first().copied().or(found.first()).map(|(v, _)| *v);
        let codes = |verdict: &Verdict| -> Vec<ReasonKind> {
            let codes = verdict.reasons.iter().map(Reason::kind);
            codes.filter(|kind| kind.code != ReasonCode::Ok).collect()
        };
        let codes = verdict.map(codes).unwrap_or_default();
        let is_accepted = !accepted.is_empty();
        Self {
            accepted: is_accepted,
            farthest: worst.map(|(farthest, _)| farthest),
            errors: worst.map(|(_, errors)| errors),
            refused: codes.first().filter(|_| !is_accepted).map(ToString::to_string),
            blames: codes
                .iter()
                .take(if is_accepted { codes.len() } else { 1 })
                .map(|code| (code.to_string(), blamed(code).to_vec()))
                .collect(),
            notes: if is_accepted { codes } else { Vec::new() },
        }
    }
}

/// The columns that a log may be wired wrongly with.
const COLUMNS: [&str; 4] = ["time", "heading", "rudder", "yaw_rate"];

/// The quantities for which an error of the reader names an option.
fn named(error: &str) -> Vec<&'static str> {
    let is_named = |column: &&str| {
        let option = column.replace('_', "-");
        error.contains(&format!("unit {column}=")) || error.contains(&format!("--{option} "))
    };
    COLUMNS.into_iter().filter(is_named).collect()
}

/// The quantities that a reason says something is wrong with; none where it blames the vehicle, the sea or the manoeuvre.
fn blamed(kind: &ReasonKind) -> &'static [&'static str] {
    use Subject::*;
    match (&kind.code, &kind.of) {
        (ReasonCode::UnitDoubtful, Some(Time))
        | (ReasonCode::SampledTooSeldom, None | Some(Time))
        | (ReasonCode::ClockJumped | ReasonCode::ClockJitter, _) => &["time"],
        (
            ReasonCode::UnitDoubtful
            | ReasonCode::Constant
            | ReasonCode::YawRateContradicts
            | ReasonCode::Late
            | ReasonCode::SampledTooSeldom,
            Some(Heading),
        )
        | (ReasonCode::CompassError | ReasonCode::CourseForHeading | ReasonCode::Quantised, _) => {
            &["heading"]
        }
        (
            ReasonCode::UnitDoubtful
            | ReasonCode::UnitUnknown
            | ReasonCode::SampledTooSeldom
            | ReasonCode::Constant,
            Some(Rudder),
        )
        | (ReasonCode::RudderNotFollowed, _) => &["rudder"],
        // Of the log as it is: which of the two channels does not follow.
        (ReasonCode::NotIdentifiable, None) | (ReasonCode::SignReversed, Some(Rudder)) => {
            &["rudder", "heading"]
        }
        (ReasonCode::SignReversed, Some(YawRate)) => &["heading", "yaw_rate"],
        (ReasonCode::Late, Some(YawRate)) => &["yaw_rate"],
        (ReasonCode::YawRateContradicts, None) => &["time", "heading", "yaw_rate"],
        _ => &[],
    }
}

/// How far a model is from the truth, in half widths of its intervals, and its errors.
fn distance(
    identification: &Identification,
    truth: &LogTruth,
    unit: RudderUnit,
) -> Option<(f64, [f64; 2])> {
    let refined = identification.refined.as_ref()?;
    let b2_per_s2 = match unit {
        RudderUnit::Rad => truth.b2_per_s2,
        RudderUnit::FullRudder => truth.b2_per_s2 * truth.full_rudder_rad,
    };
    let of = |found: f64, [low, high]: [f64; 2], truth: f64| {
        ((found - truth).abs() / (0.5 * (high - low)), found / truth - 1.0)
    };
    let intervals = &refined.interval_95;
    let a22 = of(refined.model.a22_per_s, intervals.a22_per_s, truth.a22_per_s);
    let b2 = of(refined.model.b2_per_s2, intervals.b2_per_s2, b2_per_s2);
    Some((a22.0.max(b2.0), [a22.1, b2.1]))
}

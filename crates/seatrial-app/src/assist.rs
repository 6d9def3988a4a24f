//! Results for programs that assist people: no more is told than may be repeated as true. A model that is not to be used has no
//! numbers, and every verdict has the sentence that goes with them.

use seatrial::campaign::Run;
use seatrial::identification::{
    Intervals, Outcome, Reason, ReasonCode, ReasonKind, Subject, ValidRange, Verdict,
};
use seatrial::{Campaign, Identification};
use seatrial_core::RudderUnit;
use serde::Serialize;

use crate::identify_log::IdentifiedLog;
use crate::logs::Source;

/// An error in words, without what it quotes of a file: lines, names and values. Whoever asks may name any file of this machine.
pub fn without_lines_of_files(error: &str) -> String {
    let mut told = Vec::new();
    // Behind its place an error of TOML quotes lines and says what stands in them.
    let mut is_quoting = false;
    for line in error.lines() {
        let is_quoted =
            line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ').starts_with('|');
        is_quoting |= is_quoted || line.contains("TOML parse error at line");
        if !is_quoted {
            told.push(match is_quoting {
                true => without_what_is_found(line),
                false => without_what_was_of_another_type(line),
            });
        }
        is_quoting &= is_quoted || line.contains("TOML parse error at line");
    }
    told.join("\n")
}

/// Of what follows a quoted line: what is missing or expected.
fn without_what_is_found(line: &str) -> String {
    if line.contains("TOML parse error at line") || line.starts_with("missing field") {
        return line.to_owned();
    }
    let expected = line.rfind(", expected").map(|at| &line[at + 2..]);
    expected.unwrap_or("not understood").to_owned()
}

/// What an error says before it quotes a name or a value.
const QUOTING: [&str; 5] =
    ["invalid type: ", "invalid value: ", "unknown field ", "unknown variant ", "duplicate field "];

fn without_what_was_of_another_type(line: &str) -> String {
    let said = QUOTING.iter().find_map(|said| Some(line.find(said)? + said.trim_end().len()));
    let Some(at) = said else {
        return line.to_owned();
    };
    let (before, found) = line.split_at(at);
    let rest = found.rfind(", expected").or_else(|| found.rfind(" at line "));
    format!("{before} not shown{}", rest.map_or("", |at| &found[at..]))
}

/// A verdict, and what may be said of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedVerdict {
    /// What may be done with the model.
    pub outcome: Outcome,
    /// May it be used at all?
    pub may_be_used: bool,
    /// The sentence that goes with the result.
    pub say: String,
    /// Why, what decides first.
    pub reasons: Vec<ReportedReason>,
}

/// A reason, and what to do about it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedReason {
    /// Its code.
    pub code: ReasonCode,
    /// The channel or the part that it is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<Subject>,
    /// What it is, in a sentence.
    pub cause: String,
    /// What was measured.
    pub detail: String,
    /// What to do.
    pub action: String,
}

impl ReportedReason {
    fn of(reason: &Reason) -> Self {
        Self {
            code: reason.code.clone(),
            of: reason.of.clone(),
            cause: reason.text.clone(),
            detail: reason.measured().to_owned(),
            action: reason.action.clone(),
        }
    }

    /// What a code stands for, and of what, where it has several subjects; `None` of one that there is not.
    pub fn of_code(code: &str, of: Option<&str>) -> Option<Self> {
        let asked = serde_json::json!({"code": code, "of": of});
        let kind: ReasonKind = serde_json::from_value(asked).ok()?;
        match kind.code {
            ReasonCode::Other(_) => None,
            _ => Some(Self::of(&Reason::new(kind, ""))),
        }
    }
}

impl ReportedVerdict {
    /// What may be said of this verdict.
    pub fn of(verdict: &Verdict) -> Self {
        let outcome = verdict.outcome();
        let cause = verdict.cause().map_or("", |cause| &cause.text);
        let action = verdict.cause().map_or("", |cause| &cause.action);
        let say = match outcome {
            Outcome::Use => format!("The model may be used: {cause}"),
            Outcome::UseWithCare => format!("The model may be used with care: {cause} {action}"),
            Outcome::NotValidated => format!(
                "The model is not validated, and is not to be presented as proven: {cause} {action}"
            ),
            Outcome::DoNotUse => format!("There is no model to use: {cause} {action}"),
        };
        Self {
            outcome,
            may_be_used: matches!(outcome, Outcome::Use | Outcome::UseWithCare),
            say: say.trim_end().to_owned(),
            reasons: verdict.reasons.iter().map(ReportedReason::of).collect(),
        }
    }
}

/// The model of one speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedModel {
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// May it be used?
    pub verdict: ReportedVerdict,
    /// Its numbers; `None` where it is not to be used.
    pub model: Option<ReportedNumbers>,
}

/// r' = a22 r + b2 rudder + C0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReportedNumbers {
    /// Rotational damping, 1/s.
    pub a22_per_s: f64,
    /// Rudder authority, 1/s^2, per `rudder_unit`.
    pub b2_per_s2: f64,
    /// Yaw acceleration at neutral rudder, rad/s^2.
    pub c0_rad_per_s2: f64,
    /// Radians, or fractions of a full rudder whose angle is not known.
    pub rudder_unit: RudderUnit,
    /// 95 % intervals.
    pub interval_95: Option<Intervals>,
    /// Over what rudder, headings, speeds and frequencies it was seen.
    pub valid_range: Option<ValidRange>,
}

impl ReportedModel {
    fn of(
        speed: (Option<f64>, Option<f64>),
        verdict: &Verdict,
        identification: Option<&Identification>,
        rudder_unit: RudderUnit,
    ) -> Self {
        let verdict = ReportedVerdict::of(verdict);
        let shown = identification.filter(|_| verdict.outcome != Outcome::DoNotUse);
        let numbers = |identification: &Identification| {
            let model = identification.model();
            ReportedNumbers {
                a22_per_s: model.a22_per_s,
                b2_per_s2: model.b2_per_s2,
                c0_rad_per_s2: model.c0_rad_per_s2,
                rudder_unit,
                interval_95: identification.refined.as_ref().map(|r| r.interval_95),
                valid_range: identification.valid_range,
            }
        };
        Self { thrust: speed.0, surge_speed_m_s: speed.1, model: shown.map(numbers), verdict }
    }
}

/// What was found in a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedLog {
    /// The log, and how it was read.
    pub source: Source,
    /// May a model of it be used?
    pub verdict: ReportedVerdict,
    /// The model of each speed, slowest first.
    pub speeds: Vec<ReportedModel>,
}

impl ReportedLog {
    /// What may be said of an identified log.
    pub fn of(found: &IdentifiedLog) -> Self {
        let unit = found.logs.log.rudder_unit();
        let speeds = match &found.models {
            Some(models) => models
                .iter()
                .map(|model| {
                    let speed = (model.thrust, model.surge_speed_m_s);
                    ReportedModel::of(speed, &model.verdict, model.identification.as_ref(), unit)
                })
                .collect(),
            None => {
                let identification = found.identification();
                vec![ReportedModel::of((None, None), found.verdict(), identification, unit)]
            }
        };
        Self {
            source: found.logs.log.source(),
            verdict: ReportedVerdict::of(found.verdict()),
            speeds,
        }
    }
}

/// What came of a trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReportedTrial {
    /// The vehicle.
    pub vehicle: String,
    /// Is it a simulator, whose model is that of no vehicle?
    pub is_rehearsal: bool,
    /// May its models be used?
    pub verdict: ReportedVerdict,
    /// The runs, in order.
    pub speeds: Vec<ReportedModel>,
}

impl ReportedTrial {
    /// What may be said of a campaign.
    pub fn of(campaign: &Campaign) -> Self {
        let speed_of = |run: &Run| {
            let speed = (Some(run.thrust), run.surge_speed_m_s);
            let identification = run.identification.as_ref();
            ReportedModel::of(speed, &run.verdict, identification, RudderUnit::Rad)
        };
        Self {
            vehicle: campaign.vehicle.clone(),
            is_rehearsal: campaign.is_rehearsal(),
            verdict: ReportedVerdict::of(&campaign.verdict()),
            speeds: campaign.runs.iter().map(speed_of).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_nothing_of_a_file_is_told_with_an_error() {
        for error in [
            "f: TOML parse error at line 1, column 9\n  |\n1 | a = hunter2\n  |     ^\nstring values must be quoted, expected a value",
            "f: TOML parse error at line 12, column 1\n   |\n12 | hunter2 = 1\n   | ^^^\nunknown field `hunter2`, expected `name` or `a`\n",
            "f: TOML parse error at line 1, column 1\ninvalid type: string \"hunter2, expected hunter2\", expected f64",
            "f: unknown field `hunter2`, expected `name` at line 1 column 9",
            "f: invalid type: string \"hunter2\", expected f64 at line 1 column 9",
            "f: duplicate field `hunter2` at line 1 column 9",
        ] {
            let told = without_lines_of_files(error);
            assert!(!told.contains("hunter2"), "{told}");
            assert!(told.starts_with("f: ") && told.contains("line 1"), "{told}");
        }
        let plain = "f: missing field `a22_per_s`\nf: no such file";
        assert_eq!(without_lines_of_files(plain), plain);
    }

    #[test]
    fn exact_a_code_says_its_cause_and_what_to_do() {
        let reason = ReportedReason::of_code("constant", Some("rudder")).unwrap();
        assert_eq!(reason.of, Some(Subject::Rudder));
        assert!(!reason.cause.is_empty() && !reason.action.is_empty());
        assert_eq!(ReportedReason::of_code("no_such_code", None), None);
    }

    #[test]
    fn exact_the_sentence_of_a_verdict_never_praises_a_model_that_is_not_to_be_used() {
        let refused = ReportedVerdict::of(&Verdict::refused(Reason::new(
            ReasonCode::Constant.of(Subject::Rudder),
            "0.0 deg",
        )));
        assert!(!refused.may_be_used);
        assert!(refused.say.starts_with("There is no model to use"));
    }
}

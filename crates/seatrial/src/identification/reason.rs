//! May a model be used, and why: the verdict and its reasons.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::code::{self, Reader, ReasonCode, ReasonKind, Subject};
use super::in_a_trial;

/// What a person may do with a model. In documents its name is in snake case: `use_with_care`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Use it.
    Use,
    /// Use it inside the stated range; a reason names what limits it.
    UseWithCare,
    /// It fits its training record, and nothing was held out to check it.
    NotValidated,
    /// Do not use it.
    DoNotUse,
}

impl Outcome {
    /// The outcome as people read it.
    ///
    /// ```
    /// use seatrial::identification::Outcome;
    ///
    /// assert_eq!(Outcome::DoNotUse.name(), "do not use");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Use => "use",
            Self::UseWithCare => "use with care",
            Self::NotValidated => "not validated",
            Self::DoNotUse => "do not use",
        }
    }
}

/// May the model be used, and why. In documents it carries its [`outcome`](Verdict::outcome), too.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Verdict {
    /// Yes or no.
    pub accepted: bool,
    /// At least one. Where the model is not accepted, what rejects it comes first, and that it was not validated after
    /// all else that does.
    pub reasons: Vec<Reason>,
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Verdict", 3)?;
        fields.serialize_field("accepted", &self.accepted)?;
        fields.serialize_field("outcome", &self.outcome())?;
        fields.serialize_field("reasons", &self.reasons)?;
        fields.end()
    }
}

impl Verdict {
    /// A verdict of one rejecting reason.
    ///
    /// ```
    /// use seatrial::identification::{Outcome, Reason, ReasonCode, Verdict};
    ///
    /// let verdict = Verdict::refused(Reason::new(ReasonCode::TooFewSamples, "12 samples"));
    /// assert_eq!((verdict.accepted, verdict.outcome()), (false, Outcome::DoNotUse));
    /// ```
    pub fn refused(reason: Reason) -> Self {
        Self { accepted: false, reasons: vec![reason] }
    }

    /// What a person may do with the model.
    ///
    /// ```
    /// use seatrial::identification::{Outcome, Reason, ReasonCode, Verdict};
    ///
    /// // Accepted, but the first-order model is behind an unknown lag of the rudder.
    /// let reasons = [ReasonCode::Ok, ReasonCode::LagUnknown].map(|code| Reason::new(code, ""));
    /// let verdict = Verdict { accepted: true, reasons: reasons.into() };
    /// assert_eq!(verdict.outcome(), Outcome::UseWithCare);
    /// let unchecked = Verdict::refused(Reason::new(ReasonCode::NotValidated, ""));
    /// assert_eq!(unchecked.outcome(), Outcome::NotValidated);
    /// ```
    pub fn outcome(&self) -> Outcome {
        let first = self.reasons.first().map(|reason| &reason.code);
        match (self.accepted, first) {
            (false, Some(ReasonCode::NotValidated)) => Outcome::NotValidated,
            (false, _) => Outcome::DoNotUse,
            (true, _) if self.reasons.iter().any(|reason| reason.limits()) => Outcome::UseWithCare,
            (true, _) => Outcome::Use,
        }
    }

    /// The reason that decides the outcome: what rejects the model, what limits its use, or that it may be used.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Verdict};
    ///
    /// let reasons = [ReasonCode::Ok, ReasonCode::LagUnknown].map(|code| Reason::new(code, ""));
    /// let verdict = Verdict { accepted: true, reasons: reasons.into() };
    /// // What limits the use comes before that it may be used.
    /// assert_eq!(verdict.cause().map(|reason| &reason.code), Some(&ReasonCode::LagUnknown));
    /// ```
    pub fn cause(&self) -> Option<&Reason> {
        let limit = self.reasons.iter().find(|reason| self.accepted && reason.limits());
        limit.or(self.reasons.first())
    }

    /// How many reasons there are beside the [`cause`](Verdict::cause), the word that a model may be used and the sign of
    /// the rudder, which is told by itself.
    pub fn other_causes(&self) -> usize {
        let decides = self.cause().is_some_and(Reason::is_cause);
        self.causes().count() - usize::from(decides)
    }

    /// How many more there are beside the [`cause`](Verdict::cause), in words; `None` where there is none.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Verdict};
    ///
    /// let codes = [ReasonCode::LowR2, ReasonCode::Disturbed, ReasonCode::ClockJitter];
    /// let verdict = Verdict { accepted: false, reasons: codes.map(|code| Reason::new(code, "")).into() };
    /// assert_eq!(verdict.more_remarks().as_deref(), Some("2 more remarks"));
    /// ```
    pub fn more_remarks(&self) -> Option<String> {
        match self.other_causes() {
            0 => None,
            1 => Some("1 more remark".into()),
            others => Some(format!("{others} more remarks")),
        }
    }

    /// The verdict on a run of a trial: where the cure of a reason is of columns, units and windows of a log, what cures it in a trial.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Verdict};
    ///
    /// let verdict = Verdict::refused(Reason::new(ReasonCode::NotValidated, ""));
    /// let of_a_trial = verdict.clone().of_a_trial();
    /// // Only what is to be done changes.
    /// assert_eq!(of_a_trial.reasons[0].text, verdict.reasons[0].text);
    /// ```
    pub fn of_a_trial(mut self) -> Self {
        for reason in &mut self.reasons {
            let kind = reason.kind();
            let is_own = code::words(&kind)
                .is_none_or(|words| reason.action != words.action(Reader::Terminal));
            if let Some(action) = in_a_trial::cure(&kind)
                && !is_own
            {
                reason.action = action.into();
            }
        }
        self
    }

    /// The reasons that speak against the model or limit its use.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Subject, Verdict};
    ///
    /// let kinds = [
    ///     ReasonCode::Ok.into(),
    ///     ReasonCode::SignReversed.of(Subject::Rudder),
    ///     ReasonCode::LagUnknown.into(),
    /// ];
    /// let verdict = Verdict { accepted: true, reasons: kinds.map(|kind| Reason::new(kind, "")).into() };
    /// // The sign of the rudder is told by itself and limits nothing.
    /// let causes: Vec<_> = verdict.causes().map(|reason| &reason.code).collect();
    /// assert_eq!(causes, [&ReasonCode::LagUnknown]);
    /// assert_eq!(verdict.other_causes(), 0);
    /// ```
    pub fn causes(&self) -> impl Iterator<Item = &Reason> {
        self.reasons.iter().filter(|reason| reason.is_cause())
    }

    /// Drops the remark that the lag of the rudder is not known.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Verdict};
    ///
    /// let reasons = [ReasonCode::Ok, ReasonCode::LagUnknown].map(|code| Reason::new(code, ""));
    /// let mut verdict = Verdict { accepted: true, reasons: reasons.into() };
    /// verdict.lag_is_known();
    /// assert!(!verdict.has(&ReasonCode::LagUnknown));
    /// ```
    pub fn lag_is_known(&mut self) {
        let is_else = |reason: &Reason| reason.code != ReasonCode::LagUnknown;
        self.reasons.retain(is_else);
    }

    /// Is this among its reasons? A code by itself is the one of no subject.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode, Subject, Verdict};
    ///
    /// let still = ReasonCode::Constant.of(Subject::Rudder);
    /// let verdict = Verdict::refused(Reason::new(still.clone(), "it moved by 0.1 deg"));
    /// assert!(verdict.has(still) && !verdict.has(ReasonCode::Constant.of(Subject::Heading)));
    /// ```
    pub fn has(&self, kind: impl Into<ReasonKind>) -> bool {
        let kind = kind.into();
        self.reasons.iter().any(|reason| reason.kind() == kind)
    }
}

/// One reason of a verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "StoredReason")]
pub struct Reason {
    /// Short and stable, for programs.
    pub code: ReasonCode,
    /// The channel or the part that it is about; `None` where the code says it all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<Subject>,
    /// The cause, in one sentence for people.
    pub text: String,
    /// What to do next, for a reader at a terminal; empty where nothing is to be done.
    pub action: String,
    /// What was measured; empty where the text says it all.
    pub detail: String,
}

/// As a document holds it.
#[derive(Deserialize)]
struct StoredReason {
    #[serde(flatten)]
    kind: ReasonKind,
    text: String,
    #[serde(default)]
    action: String,
    #[serde(default)]
    detail: String,
}

impl From<StoredReason> for Reason {
    fn from(written: StoredReason) -> Self {
        let ReasonKind { code, of } = written.kind;
        Self { code, of, text: written.text, action: written.action, detail: written.detail }
    }
}

impl Reason {
    fn is_cause(&self) -> bool {
        let rudder_sign = ReasonCode::SignReversed.of(Subject::Rudder);
        self.code != ReasonCode::Ok && self.kind() != rudder_sign
    }

    /// Its code, and of what.
    pub fn kind(&self) -> ReasonKind {
        ReasonKind { code: self.code.clone(), of: self.of.clone() }
    }

    pub(crate) fn is_fault(&self) -> bool {
        self.kind().is_fault()
    }

    pub(crate) fn is_of_the_vehicle(&self) -> bool {
        self.kind().is_of_the_vehicle()
    }

    pub(crate) fn limits(&self) -> bool {
        self.kind().limits()
    }

    /// A reason with what was measured. Cause and action are those of the code and its subject; the measured text is the cause of
    /// one that has none.
    ///
    /// ```
    /// use seatrial::identification::{Reason, ReasonCode};
    ///
    /// let reason = Reason::new(ReasonCode::LowR2, "R^2 is 0.31");
    /// // The cause is that of the code; what was measured stands beside it.
    /// assert!(!reason.text.contains("0.31"));
    /// assert_eq!(reason.measured(), "R^2 is 0.31");
    /// ```
    pub fn new(kind: impl Into<ReasonKind>, measured: impl Into<String>) -> Self {
        let (kind, measured) = (kind.into(), measured.into());
        let (text, action, detail) = match code::words(&kind) {
            Some(words) => (words.cause.into(), words.action(Reader::Terminal).into(), measured),
            None => (measured, String::new(), String::new()),
        };
        Self { code: kind.code, of: kind.of, text, action, detail }
    }

    /// What was measured, or the text where that says it all.
    pub fn measured(&self) -> &str {
        if self.detail.is_empty() { &self.text } else { &self.detail }
    }

    /// What to do next, in the words of the place where it is read.
    ///
    /// ```
    /// use seatrial::identification::{Reader, Reason, ReasonCode};
    ///
    /// let reason = Reason::new(ReasonCode::NotValidated, "");
    /// assert_eq!(reason.action_for(Reader::Terminal), reason.action);
    /// // Python has arguments where the command has options.
    /// assert!(!reason.action_for(Reader::Python).contains("--"));
    /// ```
    pub fn action_for(&self, reader: Reader) -> &str {
        match code::words(&self.kind()) {
            // What a reason advises by itself fits everywhere.
            Some(words) if self.action == words.action(Reader::Terminal) => words.action(reader),
            _ => &self.action,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trial has no log whose columns, units and windows could be chosen.
    #[test]
    fn exact_no_reason_of_a_trial_advises_about_a_log() {
        use ReasonCode::*;
        use Subject::{Heading, Rudder, Samples, Speed, Time, YawRate};
        let log_only = [
            TooFewSamples.into(),
            Damaged.of(Samples),
            SamplesMissing.into(),
            ClockJitter.into(),
            SampledTooSeldom.of(Time),
            ClockJumped.into(),
            SampledTooSeldom.into(),
            UnitDoubtful.of(Heading),
            UnitDoubtful.of(Rudder),
            UnitUnknown.of(Rudder),
            CourseForHeading.into(),
            UnitDoubtful.of(Time),
            YawRateContradicts.into(),
            SignReversed.of(YawRate),
            LagUnknown.into(),
            NotValidated.into(),
            ManoeuvresDiffer.of(Speed),
        ];
        let reasons = log_only.map(|kind: ReasonKind| Reason::new(kind, ""));
        let verdict = Verdict { accepted: false, reasons: reasons.to_vec() }.of_a_trial();
        for (reason, log) in verdict.reasons.iter().zip(&reasons) {
            for reader in [Reader::Terminal, Reader::Dashboard, Reader::Python] {
                let action = reason.action_for(reader);
                assert_ne!(action, log.action_for(reader));
                assert!(!action.contains(['“', '{']) && !action.contains("--"), "{action}");
                assert!(!action.contains(" log"), "{action}");
            }
        }
        let own = Reason { action: "Look at it.".into(), ..Reason::new(TooFewSamples, "") };
        let kept = Verdict::refused(own.clone()).of_a_trial();
        assert_eq!(kept.reasons, [own]);
    }

    #[test]
    fn exact_a_servo_that_was_told_has_no_unknown_lag() {
        use ReasonCode::{LagUnknown, ModelOrder, Ok};
        let reasons = [Ok, LagUnknown, ModelOrder].map(|code| Reason::new(code, ""));
        let mut verdict = Verdict { accepted: true, reasons: reasons.to_vec() };
        verdict.lag_is_known();
        assert!(!verdict.has(&LagUnknown) && verdict.has(&ModelOrder));
        assert_eq!(verdict.reasons.len(), 2);
    }

    #[test]
    fn exact_the_outcome_follows_from_the_reasons() {
        let sign = || ReasonCode::SignReversed.of(Subject::Rudder);
        let verdict = |accepted, kinds: Vec<ReasonKind>| Verdict {
            accepted,
            reasons: kinds.into_iter().map(|kind| Reason::new(kind, "")).collect(),
        };
        use ReasonCode::{LowR2, ModelOrder, NotValidated, Ok};
        for (verdict, outcome) in [
            (verdict(true, vec![Ok.into(), sign()]), Outcome::Use),
            (verdict(true, vec![Ok.into(), ModelOrder.into()]), Outcome::UseWithCare),
            (verdict(false, vec![NotValidated.into(), ModelOrder.into()]), Outcome::NotValidated),
            (verdict(false, vec![LowR2.into(), NotValidated.into()]), Outcome::DoNotUse),
        ] {
            assert_eq!(verdict.outcome(), outcome, "{verdict:?}");
            let json = serde_json::to_value(&verdict).unwrap();
            assert_eq!(json["outcome"], serde_json::to_value(outcome).unwrap());
            assert_eq!(serde_json::from_value::<Verdict>(json).unwrap(), verdict);
        }
    }

    #[test]
    fn exact_the_cause_is_what_decides() {
        use ReasonCode::{ClockJitter, LowR2, ModelOrder, NotValidated, Ok};
        let sign = || ReasonCode::SignReversed.of(Subject::Rudder);
        for (accepted, kinds, cause, others) in [
            (true, vec![Ok.into(), sign()], Ok, 0),
            (true, vec![Ok.into(), sign(), ModelOrder.into(), ClockJitter.into()], ModelOrder, 1),
            (false, vec![NotValidated.into()], NotValidated, 0),
            (false, vec![LowR2.into(), NotValidated.into()], LowR2, 1),
        ] {
            let verdict = Verdict {
                accepted,
                reasons: kinds.into_iter().map(|kind: ReasonKind| Reason::new(kind, "")).collect(),
            };
            assert_eq!(verdict.cause().unwrap().code, cause);
            assert_eq!(verdict.other_causes(), others);
        }
    }

    /// What a browser or Python shows names none of the command's options.
    #[test]
    fn exact_advice_fits_where_it_is_read() {
        let reason = Reason::new(ReasonCode::NotValidated, "measured");
        assert!(reason.action.contains("--validate-from"));
        assert_eq!(reason.detail, "measured");
        assert_eq!(reason.action_for(Reader::Terminal), reason.action);
        assert!(!reason.action_for(Reader::Dashboard).contains("--"));
        assert!(reason.action_for(Reader::Python).contains("validation="));
        let of_yesterday: Reason =
            serde_json::from_str(r#"{"code":"low_r2","text":"R^2 is 0.2"}"#).unwrap();
        assert_eq!(of_yesterday.measured(), "R^2 is 0.2");
    }
}

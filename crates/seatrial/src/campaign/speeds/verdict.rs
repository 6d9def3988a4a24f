//! One verdict on the models of several speeds, of a campaign and of a log alike.

use crate::identification::{Reason, ReasonCode, Verdict};

/// What was found at one speed.
#[derive(Clone, Copy)]
pub struct Part<'a> {
    /// The speed or the thrust, without its unit.
    pub name: &'a str,
    /// The verdict on its model.
    pub verdict: &'a Verdict,
}

/// The verdict on the accepted models of several speeds, which is no better than that of any of them. `unit` is that of their names;
/// `others` is what else stands in the way, such as speeds without a model.
///
/// ```
/// use seatrial::campaign::speeds::{Part, whole};
/// use seatrial::identification::{Outcome, Reason, ReasonCode, Verdict};
///
/// let accepted = |codes: &[ReasonCode]| Verdict {
///     accepted: true,
///     reasons: codes.iter().map(|code| Reason::new(code.clone(), "")).collect(),
/// };
/// let verdicts = [accepted(&[ReasonCode::Ok]), accepted(&[ReasonCode::Ok, ReasonCode::LagUnknown])];
/// let parts = [0, 1].map(|k| Part { name: ["60", "80"][k], verdict: &verdicts[k] });
/// let whole = whole(&parts, "% thrust", Vec::new());
/// // No better than the worst of them, and it says which.
/// assert_eq!(whole.outcome(), Outcome::UseWithCare);
/// assert!(whole.cause().is_some_and(|cause| cause.text.starts_with("At 80 % thrust: ")));
/// ```
pub fn whole(accepted: &[Part], unit: &str, others: Vec<Reason>) -> Verdict {
    let ok = Reason::new(
        ReasonCode::Ok,
        match accepted.len() {
            1 => "one speed has a model that holds on validation data".into(),
            speeds => format!("{speeds} speeds have a model that holds on validation data"),
        },
    );
    let limits = remarks(accepted, unit, Reason::limits);
    Verdict { accepted: true, reasons: std::iter::once(ok).chain(others).chain(limits).collect() }
}

/// A reason for those of all speeds that have no model, once for each cause, with what to do about it.
///
/// ```
/// use seatrial::campaign::speeds::{Part, missing};
/// use seatrial::identification::{Reason, ReasonCode, Verdict, Subject};
///
/// let refused = Verdict::refused(Reason::new(ReasonCode::Constant.of(Subject::Rudder), ""));
/// let parts = ["60", "80"].map(|name| Part { name, verdict: &refused });
/// // One cause, one reason.
/// let reasons = missing(&parts, "% thrust");
/// assert_eq!(reasons.len(), 1);
/// assert!(reasons[0].text.starts_with("None of 2 speeds has a model: "));
/// ```
pub fn missing(parts: &[Part], unit: &str) -> Vec<Reason> {
    let mut found: Vec<(&Reason, Vec<&str>)> = Vec::new();
    for part in parts.iter().filter(|part| !part.verdict.accepted) {
        let Some(cause) = part.verdict.cause() else {
            continue;
        };
        match found.iter_mut().find(|(other, _)| other.text == cause.text) {
            Some((_, names)) => names.push(part.name),
            None => found.push((cause, vec![part.name])),
        }
    }
    // What concerns most speeds comes first.
    found.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
    let of = |(cause, names): (&Reason, Vec<&str>)| {
        let which = match names.as_slice() {
            [name] => format!("{name} {unit} has no model"),
            all if all.len() == parts.len() => format!("None of {} speeds has a model", all.len()),
            several => format!("{} {unit} have no model", several.join(", ")),
        };
        Reason {
            text: format!("{which}: {}", cause.text),
            action: cause.action.clone(),
            detail: cause.detail.clone(),
            ..Reason::new(ReasonCode::SpeedMissing, "")
        }
    };
    found.into_iter().map(of).collect()
}

/// Reasons of several speeds: each kind once, with the speeds that it concerns.
pub fn remarks(parts: &[Part], unit: &str, counts: fn(&Reason) -> bool) -> Vec<Reason> {
    let mut found: Vec<(Reason, Vec<&str>)> = Vec::new();
    for part in parts {
        for reason in part.verdict.reasons.iter().filter(|r| counts(r)) {
            match found.iter_mut().find(|(other, _)| other.kind() == reason.kind()) {
                Some((_, names)) => names.push(part.name),
                None => found.push((reason.clone(), vec![part.name])),
            }
        }
    }
    found
        .into_iter()
        .map(|(reason, names)| Reason {
            text: match names.len() == parts.len() {
                true => reason.text,
                false => format!("At {} {unit}: {}", names.join(", "), reason.text),
            },
            ..reason
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::Outcome;

    fn verdict(accepted: bool, codes: &[ReasonCode]) -> Verdict {
        let reason = |code: &ReasonCode| Reason::new(code.clone(), "measured");
        Verdict { accepted, reasons: codes.iter().map(reason).collect() }
    }

    #[test]
    fn exact_the_whole_is_no_better_than_its_parts() {
        let good = verdict(true, &[ReasonCode::Ok]);
        let limited = verdict(true, &[ReasonCode::Ok, ReasonCode::ModelOrder]);
        let refused = verdict(false, &[ReasonCode::LowR2]);
        let part = |name, verdict| Part { name, verdict };
        let both = [part("1.0", &good), part("2.0", &good)];
        assert_eq!(whole(&both, "m/s", Vec::new()).outcome(), Outcome::Use);
        let one = [part("1.0", &good), part("2.0", &limited)];
        let found = whole(&one, "m/s", Vec::new());
        assert_eq!(found.outcome(), Outcome::UseWithCare);
        let text = &found.cause().unwrap().text;
        assert!(text.starts_with("At 2.0 m/s: The vehicle does more"), "{text}");
        let lacking = missing(&[part("1.0", &good), part("3.0", &refused)], "m/s");
        assert!(lacking[0].text.starts_with("3.0 m/s has no model: "), "{lacking:?}");
        let none = missing(&[part("2.0", &refused), part("3.0", &refused)], "m/s");
        assert_eq!(none.len(), 1);
        assert!(none[0].text.starts_with("None of 2 speeds has a model: "), "{none:?}");
        let found = whole(&both, "m/s", lacking);
        assert_eq!(found.outcome(), Outcome::UseWithCare);
        assert_eq!(found.cause().unwrap().code, ReasonCode::SpeedMissing);
    }
}

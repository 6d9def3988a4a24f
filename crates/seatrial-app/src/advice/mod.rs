//! Options of the command that a text names, in the words of the place where the text is read.
//!
//! What is said of logs, models, plans and vehicles is written for a terminal. A page has fields and buttons for the same
//! choices, its server was started with some of them, and Python has arguments; their names stand here, in one place.
//! A command that is printed to be typed in a terminal stays as it is.

mod options;

use seatrial::identification::{Reader, Reason, Verdict};
use serde_json::Value;

/// A text with each option that it names in the words of a reader: `--rudder NAME` is the list “Rudder from column” of a page,
/// and `columns={"rudder": "NAME"}` in Python.
pub fn addressed(text: &str, reader: Reader) -> String {
    if reader == Reader::Terminal {
        return text.to_owned();
    }
    let mut addressed = String::new();
    let mut last = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, from) = rest.split_at(at);
        let name = &from[2..];
        let end = name
            .find(|c: char| !c.is_ascii_lowercase() && c != '-')
            .unwrap_or(name.len());
        let (name, after) = name.split_at(end);
        let is_option = !before.ends_with(char::is_alphanumeric)
            && !is_in_command(&text[..text.len() - from.len()]);
        let sentence = is_option.then(|| options::said(name, after, reader));
        let Some((said, after)) = sentence.flatten() else {
            addressed += before;
            addressed += "--";
            addressed += name;
            last.clear();
            rest = after;
            continue;
        };
        // Both ends of a window are one field and one argument.
        if !(said == last && [" and ", " or ", ", "].contains(&before)) {
            addressed += match before {
                " " if !last.is_empty() => " and ",
                before => before,
            };
            addressed += &said;
        }
        last = said;
        rest = after;
    }
    addressed += rest;
    addressed
}

/// The field of a page for the rudder angle at full steering, where models are shown. A vehicle has it from the start of its server.
const FULL_RUDDER: &str = "“Rudder at full steering” under “Choose damping, speed or rudder angle”";

/// What is said of models, in the words of a reader.
pub fn of_models(text: &str, reader: Reader) -> String {
    match reader {
        Reader::Dashboard => addressed(&text.replace("--full-rudder-deg DEG", FULL_RUDDER), reader),
        _ => addressed(text, reader),
    }
}

/// A reason in the words of a reader.
pub fn reason(reason: Reason, reader: Reader) -> Reason {
    Reason {
        action: addressed(reason.action_for(reader), reader),
        text: addressed(&reason.text, reader),
        detail: addressed(&reason.detail, reader),
        code: reason.code,
        of: reason.of,
    }
}

/// A verdict in the words of a reader.
pub fn verdict(verdict: Verdict, reader: Reader) -> Verdict {
    let reasons = verdict.reasons.into_iter();
    Verdict {
        reasons: reasons.map(|one| reason(one, reader)).collect(),
        ..verdict
    }
}

/// Several texts in the words of a reader.
pub fn all(texts: impl IntoIterator<Item = String>, reader: Reader) -> Vec<String> {
    let texts = texts.into_iter();
    texts.map(|text| addressed(&text, reader)).collect()
}

/// Every text of a document in the words of a reader.
pub fn document(found: &mut Value, reader: Reader) {
    match found {
        Value::String(text) if text.contains("--") => *text = addressed(text, reader),
        Value::Array(values) => values.iter_mut().for_each(|one| document(one, reader)),
        Value::Object(fields) => fields.values_mut().for_each(|one| document(one, reader)),
        _ => {}
    }
}

/// Does a text end within a command that is printed to be typed?
fn is_in_command(text: &str) -> bool {
    let Some((_, command)) = text.rsplit_once("seatrial ") else {
        return false;
    };
    let begins = command.starts_with(|c: char| c.is_ascii_lowercase());
    begins && !command.contains(['`', ';', ')', '\n']) && !command.contains(". ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_logs::{Fault, Place, Quantity};

    fn faults() -> Vec<Fault> {
        let columns = vec!["x".to_owned()];
        vec![
            Fault::MissingColumn {
                quantity: Quantity::Rudder,
                columns: columns.clone(),
                nearest: None,
            },
            Fault::AmbiguousColumn {
                quantity: Quantity::Speed,
                candidates: columns,
            },
            Fault::UnknownUnit {
                column: "x".into(),
                found: "furlong".into(),
                quantity: Quantity::YawRate,
                expected: "deg/s".into(),
            },
            Fault::NotFinite {
                place: Place::Line(3),
                column: "x".into(),
                found: f64::NAN,
            },
            Fault::NoSamples { rows: 3 },
        ]
    }

    #[test]
    fn exact_a_page_has_a_field_for_the_full_rudder_of_models() {
        let text = "if full steering is another angle, say --full-rudder-deg DEG";
        let shown = of_models(text, Reader::Dashboard);
        assert!(
            shown.contains("say “Rudder at full steering” under"),
            "{shown}"
        );
        assert_eq!(of_models(text, Reader::Terminal), text);
        assert!(addressed(text, Reader::Dashboard).contains("in a terminal"));
    }

    #[test]
    fn exact_a_page_and_python_are_advised_about_what_they_have() {
        for fault in faults() {
            let text = fault.to_string();
            assert!(text.contains("--"), "{text}");
            assert_eq!(addressed(&text, Reader::Terminal), text);
            for reader in [Reader::Dashboard, Reader::Python] {
                let shown = addressed(&text, reader);
                assert!(
                    !shown.contains("--") && !shown.contains("NAME under"),
                    "{shown}"
                );
            }
        }
        for (text, dashboard, python) in [
            (
                "say which with --rudder NAME",
                "say which with “Rudder from column” under “Columns and units”",
                "say which with columns={\"rudder\": \"NAME\"}",
            ),
            (
                "degrees? try --unit heading=deg",
                "degrees? try deg as “Heading is in” under “Columns and units”",
                "degrees? try units={\"heading\": \"deg\"}",
            ),
            (
                "leave such rows out with --drop-invalid",
                "leave such rows out with “Leave out damaged rows” under “Columns and units”",
                "leave such rows out with drop_invalid=True",
            ),
            (
                "leave it out with --yaw-rate none",
                "leave it out with “left out” in “Yaw rate from column” under “Columns and units”",
                "leave it out with columns={\"yaw_rate\": \"none\"}",
            ),
            (
                "choose a part of the record with --from and --to",
                "choose a part of the record with the training window under “Windows”",
                "choose a part of the record with training=(from, to)",
            ),
            (
                "say so with --unit rudder=fraction --rudder-range-deg DEG",
                "say so with fraction as “Rudder is in” under “Columns and units” and “Rudder angle at full deflection” under “Columns and units”",
                "say so with units={\"rudder\": \"fraction\"} and full_rudder_rad=RAD",
            ),
            (
                "--campaign 3 takes it all the same",
                "campaign 3 takes it all the same",
                "campaign=3 takes it all the same",
            ),
            (
                "say which with --steering-outputs",
                "say which with the option steering-outputs in a terminal",
                "say which with the option steering-outputs in a terminal",
            ),
            ("a -- b --nothing", "a -- b --nothing", "a -- b --nothing"),
            ("my--rudder.csv", "my--rudder.csv", "my--rudder.csv"),
            (
                "run `seatrial vehicle restore x --plan VEHICLE`",
                "run `seatrial vehicle restore x --plan VEHICLE`",
                "run `seatrial vehicle restore x --plan VEHICLE`",
            ),
        ] {
            assert_eq!(addressed(text, Reader::Dashboard), dashboard);
            assert_eq!(addressed(text, Reader::Python), python);
        }
    }
}

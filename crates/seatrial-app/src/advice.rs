//! Options of the command that a text names, in the words of the place where the text is read.
//!
//! Faults and warnings of logs are written for a terminal. A page has fields and Python has arguments for the same
//! choices, and their names stand here, in one place.

use seatrial::identification::Reader;
use seatrial_logs::Quantity;

/// What closes a sentence about a field of the page.
const FORM: &str = " under “Columns and units”";

/// A text with each option that it names in the words of a reader: `--rudder NAME` is the list “Rudder from column” of a page,
/// and `columns={"rudder": "NAME"}` in Python.
pub fn addressed(text: &str, reader: Reader) -> String {
    if reader == Reader::Terminal {
        return text.to_owned();
    }
    let mut addressed = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, from) = rest.split_at(at);
        addressed += before;
        let name = &from[2..];
        let end = name
            .find(|c: char| !c.is_ascii_lowercase() && c != '-')
            .unwrap_or(name.len());
        let (name, after) = name.split_at(end);
        let (said, after) = match reader {
            Reader::Python => python(name, after),
            _ => page(name, after),
        }
        .unwrap_or_else(|| (format!("--{name}"), after));
        addressed += &said;
        rest = after;
    }
    addressed += rest;
    addressed
}

/// The value of an option, where it follows, and what comes behind it.
fn value(after: &str) -> (Option<&str>, &str) {
    let Some(text) = after.strip_prefix([' ', '=']) else {
        return (None, after);
    };
    let end = text
        .find(|c: char| c.is_whitespace() || ";,:)".contains(c))
        .unwrap_or(text.len());
    let (value, behind) = text.split_at(end);
    (Some(value), behind)
}

/// The word that stands for a name or a number where an option is explained, and what comes behind it.
fn placeholder(after: &str) -> (bool, &str) {
    match value(after) {
        (Some("NAME" | "DEG" | "US" | "S" | "FILE" | "LOG"), behind) => (true, behind),
        _ => (false, after),
    }
}

/// Of `heading=deg` the quantity and the unit.
fn unit(after: &str) -> Option<(Quantity, &str, &str)> {
    let (value, behind) = value(after);
    let (quantity, unit) = value?.split_once('=')?;
    Some((quantity.parse().ok()?, unit, behind))
}

/// What a page calls a quantity; `None` where it has no field for it.
fn field(quantity: Quantity) -> Option<&'static str> {
    match quantity {
        Quantity::Time => Some("Time"),
        Quantity::Heading => Some("Heading"),
        Quantity::Rudder => Some("Rudder"),
        Quantity::Speed => Some("Forward speed"),
        Quantity::YawRate => Some("Yaw rate"),
        Quantity::Thrust => Some("Thrust"),
        _ => None,
    }
}

fn page<'a>(name: &str, after: &'a str) -> Option<(String, &'a str)> {
    if name == "unit" {
        let (quantity, unit, behind) = unit(after)?;
        let list = format!("“{} is in”{FORM}", field(quantity)?);
        let said = match unit {
            "UNIT" => list,
            unit => format!("{unit} as {list}"),
        };
        return Some((said, behind));
    }
    let (_, behind) = placeholder(after);
    let of_form = |label: &str| format!("“{label}”{FORM}");
    let said = match name {
        "drop-invalid" => of_form("Leave out damaged rows"),
        "rudder-range-deg" => of_form("Rudder angle at full deflection"),
        "rudder-trim" => of_form("Pulse width of the neutral rudder"),
        "rudder-lag" | "rudder-delay" => of_form("Time constant of the servo"),
        "from" | "to" => "the training window under “Windows”".into(),
        "validate-from" | "validate-to" | "validate-on" => {
            "the validation window under “Windows”".into()
        }
        "channels" => "a file of channels, in a terminal".into(),
        column => match field(column.parse().ok()?) {
            Some(label) => of_form(&format!("{label} from column")),
            None => format!("a terminal: option {column}"),
        },
    };
    Some((said, behind))
}

fn python<'a>(name: &str, after: &'a str) -> Option<(String, &'a str)> {
    if name == "unit" {
        let (quantity, unit, behind) = unit(after)?;
        return Some((format!("units={{\"{quantity}\": \"{unit}\"}}"), behind));
    }
    let (is_placeholder, behind) = placeholder(after);
    let said = match name {
        "drop-invalid" => "drop_invalid=True".into(),
        "rudder-range-deg" => "full_rudder_rad=RAD".into(),
        "rudder-trim" => "rudder_trim_us=US".into(),
        "rudder-lag" => "rudder_lag_s=S".into(),
        "rudder-delay" => "rudder_delay_s=S".into(),
        "from" | "to" => "training=(from, to)".into(),
        "validate-from" | "validate-to" => "validation=(from, to)".into(),
        "validate-on" => "validate_on=LOG".into(),
        "channels" => "channels_file=FILE".into(),
        column => {
            let quantity: Quantity = column.parse().ok()?;
            match is_placeholder {
                true => format!("columns={{\"{quantity}\": \"NAME\"}}"),
                false => format!("columns[\"{quantity}\"]"),
            }
        }
    };
    Some((said, behind))
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_logs::{Fault, Place};

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
    fn exact_a_page_and_python_are_told_what_they_have() {
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
            ("a -- b --nothing", "a -- b --nothing", "a -- b --nothing"),
        ] {
            assert_eq!(addressed(text, Reader::Dashboard), dashboard);
            assert_eq!(addressed(text, Reader::Python), python);
        }
    }
}

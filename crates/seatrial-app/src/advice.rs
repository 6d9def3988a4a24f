//! Options of the command that a text names, in the words of the place where the text is read.
//!
//! What is said of logs, models, plans and vehicles is written for a terminal. A page has fields and buttons for the same
//! choices, its server was started with some of them, and Python has arguments; their names stand here, in one place.
//! A command that is printed to be typed in a terminal stays as it is.

use seatrial::identification::{Reader, Reason, Verdict};
use seatrial::words::capitalised;
use seatrial_logs::Quantity;

/// What a reader has in place of an option that is of the terminal alone.
const TERMINAL: &str = "";

/// The options that texts name, with what a page and Python have in their place. An argument of Python has its value
/// behind `=`, or what stands for it. Columns and units of a log are told by their quantities.
#[rustfmt::skip]
const OPTIONS: &[(&str, &str, &str)] = &[
    ("drop-invalid", "“Leave out damaged rows” under “Columns and units”", "drop_invalid=True"),
    ("rudder-range-deg", "“Rudder angle at full deflection” under “Columns and units”", "full_rudder_rad=RAD"),
    ("rudder-trim", "“Pulse width of the neutral rudder” under “Columns and units”", "rudder_trim_us=US"),
    ("rudder-lag", "“Time constant of the servo” under “Columns and units”", "rudder_lag_s=S"),
    ("rudder-delay", "“Dead time of the servo” under “Columns and units”", "rudder_delay_s=S"),
    ("from", "the training window under “Windows”", "training=(from, to)"),
    ("validate-from", "the validation window under “Windows”", "validation=(from, to)"),
    ("validate-on", "the validation window under “Windows”", "validate_on=LOG"),
    ("channels", "a file of channels, in a terminal", "channels_file=FILE"),
    ("where", TERMINAL, TERMINAL),
    ("as-paper", TERMINAL, "estimate=\"paper\""),
    ("axis", "the axis of the plan", "the axis of the plan"),
    ("plan", "“Plan from a file” under “Control”", "file=FILE"),
    ("thrust", "“Speeds, thrust in % of full”", "thrusts=SHARES"),
    ("vehicle", "“Vehicle”", "vehicle=VEHICLE"),
    ("campaign", "campaign", "campaign=NUMBER"),
    ("rehearsal", "“Use models of a rehearsal as well”", "rehearsal=True"),
    ("logbook", TERMINAL, "logbook=FILE"),
    ("heading-deg", TERMINAL, "heading_rad=RAD"),
    ("hold-gain", TERMINAL, "hold_gain=GAIN"),
    ("amplitude-deg", TERMINAL, "amplitude_rad=RAD"),
    ("period-s", TERMINAL, "period_s=S"),
    ("target", TERMINAL, "target=WIDTHS"),
    ("adopt", TERMINAL, TERMINAL),
    ("zeta", TERMINAL, "damping_ratio=RATIO"),
    ("delay", TERMINAL, "delay_s=S"),
    ("interval", TERMINAL, "interval_s=S"),
    ("extrapolate", TERMINAL, "extrapolate=True"),
    ("at-speed", TERMINAL, "at_speed_m_s=M_S"),
    ("at-thrust", TERMINAL, "at_thrust=SHARE"),
    ("speed M_S", "“Forward speed, m/s, where the log has none” under “Choose damping, speed or rudder angle”", "surge_speed_m_s=M_S"),
    ("full-rudder-deg", TERMINAL, "full_rudder_rad=RAD"),
    ("full-steering-deg", TERMINAL, "full_rudder_rad=RAD"),
    ("surge-time-constant", TERMINAL, "surge_time_constant_s=S"),
    ("heading-change-deg", TERMINAL, "heading_change_rad=RAD"),
    ("measured-u-turn", TERMINAL, "measured_u_turn=SPEED,RADIUS"),
    ("up-to-speed", TERMINAL, "up_to_speed_m_s=M_S"),
    ("length", TERMINAL, TERMINAL),
    ("listen", TERMINAL, TERMINAL),
    ("run-column", TERMINAL, "run_column=COLUMN"),
    ("resume", TERMINAL, "resume=True"),
    ("signing-key", TERMINAL, TERMINAL),
    ("steering-outputs", TERMINAL, TERMINAL),
    ("vehicle-id", TERMINAL, TERMINAL),
    ("without-rc", TERMINAL, TERMINAL),
];

/// A text with each option that it names in the words of a reader: `--rudder NAME` is the list “Rudder from column” of a page,
/// and `columns={"rudder": "NAME"}` in Python.
pub fn addressed(text: &str, reader: Reader) -> String {
    if reader == Reader::Terminal {
        return text.to_owned();
    }
    // Both ends of a window are one field and one argument.
    let text = text.replace(" and --to", "").replace(" and --validate-to", "");
    let mut parts = text.split("--");
    let mut addressed = parts.next().unwrap_or_default().to_owned();
    let mut is_behind_option = false;
    for part in parts {
        let is_option = !addressed.ends_with(char::is_alphanumeric) && !is_in_command(&addressed);
        match said(part, reader).filter(|_| is_option) {
            Some((said, behind)) => {
                addressed += if is_behind_option { "and " } else { "" };
                addressed += &said;
                addressed += behind;
                is_behind_option = behind == " ";
            }
            None => {
                addressed += "--";
                addressed += part;
                is_behind_option = false;
            }
        }
    }
    addressed
}

/// Does a text end within a command that is printed to be typed?
fn is_in_command(text: &str) -> bool {
    let Some((_, command)) = text.rsplit_once("seatrial ") else {
        return false;
    };
    let begins = command.starts_with(|c: char| c.is_ascii_lowercase());
    begins && !command.contains(['`', ';', ')', '\n']) && !command.contains(". ")
}

/// What a reader has in place of the option that a text begins with, and what comes behind it and its value.
fn said(text: &str, reader: Reader) -> Option<(String, &str)> {
    let end = text.find(|c: char| !c.is_ascii_lowercase() && c != '-');
    let (name, after) = text.split_at(end.unwrap_or(text.len()));
    let (value, behind) = value(after);
    let with_value = format!("{name} {}", value.unwrap_or_default());
    let mut options = OPTIONS.iter();
    let Some((_, page, python)) = options.find(|row| [name, &with_value].contains(&row.0)) else {
        return Some((of_log(name, value, reader)?, behind));
    };
    let words = match reader {
        Reader::Python if *python != TERMINAL => (*python).to_owned(),
        Reader::Dashboard if *page != TERMINAL => (*page).to_owned(),
        _ => in_a_terminal(name),
    };
    let argument = words.split_once('=').filter(|(_, of)| is_placeholder(of));
    Some(match (argument, value) {
        (Some((argument, _)), None) => (argument.to_owned(), behind),
        (Some((argument, _)), Some(value)) if !is_placeholder(value) => {
            (format!("{argument}={value}"), behind)
        }
        (None, Some(value)) if words.starts_with('“') => (chosen(value, &words), behind),
        (None, Some(value)) if !is_placeholder(value) => (words, after),
        _ => (words, behind),
    })
}

/// A column by its quantity, `--yaw-rate NAME`, or `--yaw-rate none`, which leaves it out; or a unit, `--unit heading=deg`.
fn of_log(name: &str, value: Option<&str>, reader: Reader) -> Option<String> {
    let unit = value.filter(|_| name == "unit").and_then(|value| value.split_once('='));
    let quantity: Quantity = unit.map_or(name, |(quantity, _)| quantity).parse().ok()?;
    let label = match quantity {
        Quantity::Speed => "Forward speed".to_owned(),
        other => capitalised(&other.name().replace('_', " ")),
    };
    let field = |kind: &str| format!("“{label} {kind}” under “Columns and units”");
    Some(match (reader, unit, value) {
        (Reader::Python, Some((_, unit)), _) => format!("units={{\"{quantity}\": \"{unit}\"}}"),
        (Reader::Python, None, Some(column)) => format!("columns={{\"{quantity}\": \"{column}\"}}"),
        (Reader::Python, None, None) => format!("columns[\"{quantity}\"]"),
        _ if quantity == Quantity::Altitude => in_a_terminal(name),
        (_, Some((_, unit)), _) => chosen(unit, &field("is in")),
        (_, None, Some("none")) => format!("“left out” in {}", field("from column")),
        (_, None, column) => chosen(column.unwrap_or("NAME"), &field("from column")),
    })
}

/// A value in a field; the field alone where one word stands for the value.
fn chosen(value: &str, field: &str) -> String {
    match is_placeholder(value) && !value.contains(',') {
        true => field.to_owned(),
        false => format!("{value} as {field}"),
    }
}

fn in_a_terminal(option: &str) -> String {
    format!("the option {option} in a terminal")
}

/// The value behind an option, where there is one and no word of the sentence, and what comes behind it.
fn value(after: &str) -> (Option<&str>, &str) {
    let text = after.strip_prefix([' ', '=']).unwrap_or_default();
    let word = text.split(char::is_whitespace).next().unwrap_or_default();
    let word = word.trim_end_matches([';', ',', ':', ')', '.']);
    let is_value = word == "none"
        || is_placeholder(word)
        || word.starts_with(|c: char| c.is_ascii_digit() || c == '-')
        || word.contains(['=', ':']);
    match is_value {
        true => (Some(word), &text[word.len()..]),
        false => (None, after),
    }
}

/// Does a word stand for a name or a number where an option is explained: `DEG`, `COLUMN=VALUE`?
fn is_placeholder(word: &str) -> bool {
    let is_of_one = |c: char| c.is_ascii_uppercase() || "_=,".contains(c);
    word.starts_with(|c: char| c.is_ascii_uppercase()) && word.chars().all(is_of_one)
}

/// A reason in the words of a reader.
pub fn reason(reason: &Reason, reader: Reader) -> Reason {
    Reason {
        action: addressed(reason.action_for(reader), reader),
        text: addressed(&reason.text, reader),
        detail: addressed(&reason.detail, reader),
        ..reason.clone()
    }
}

/// Puts a verdict in the words of a reader.
pub fn verdict(verdict: &mut Verdict, reader: Reader) {
    for one in &mut verdict.reasons {
        *one = reason(one, reader);
    }
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
            Fault::AmbiguousColumn { quantity: Quantity::Speed, candidates: columns },
            Fault::UnknownUnit {
                column: "x".into(),
                found: "furlong".into(),
                quantity: Quantity::YawRate,
                expected: "deg/s".into(),
            },
            Fault::NotFinite { place: Place::Line(3), column: "x".into(), found: f64::NAN },
            Fault::NoSamples { rows: 3 },
        ]
    }

    #[test]
    fn exact_a_page_and_python_are_advised_about_what_they_have() {
        for fault in faults() {
            let text = fault.to_string();
            assert!(text.contains("--"), "{text}");
            assert_eq!(addressed(&text, Reader::Terminal), text);
            for reader in [Reader::Dashboard, Reader::Python] {
                let shown = addressed(&text, reader);
                assert!(!shown.contains("--") && !shown.contains("NAME under"), "{shown}");
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

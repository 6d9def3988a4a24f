//! What a page and Python have in place of each option that texts name.

use seatrial::identification::Reader;
use seatrial_logs::Quantity;

/// What closes a sentence about a field of the page.
const FORM: &str = " under “Columns and units”";

/// What a place has for an option.
#[derive(Clone, Copy)]
enum Has {
    /// A field of “Columns and units”.
    Field(&'static str),
    /// These words.
    Words(&'static str),
    /// An argument of this name; a value that follows is its own.
    Argument(&'static str),
    /// Nothing: the option is the terminal's.
    Terminal,
}

use Has::{Argument, Field, Terminal, Words};

/// The options that texts name, with what a page and Python have in their place. Columns and units are told by their
/// quantities.
const OPTIONS: &[(&str, Has, Has)] = &[
    (
        "drop-invalid",
        Field("Leave out damaged rows"),
        Words("drop_invalid=True"),
    ),
    (
        "rudder-range-deg",
        Field("Rudder angle at full deflection"),
        Words("full_rudder_rad=RAD"),
    ),
    (
        "rudder-trim",
        Field("Pulse width of the neutral rudder"),
        Words("rudder_trim_us=US"),
    ),
    (
        "rudder-lag",
        Field("Time constant of the servo"),
        Words("rudder_lag_s=S"),
    ),
    (
        "rudder-delay",
        Field("Time constant of the servo"),
        Words("rudder_delay_s=S"),
    ),
    ("from", WINDOW, Words("training=(from, to)")),
    ("to", WINDOW, Words("training=(from, to)")),
    ("validate-from", VALIDATION, Words("validation=(from, to)")),
    ("validate-to", VALIDATION, Words("validation=(from, to)")),
    ("validate-on", VALIDATION, Words("validate_on=LOG")),
    (
        "channels",
        Words("a file of channels, in a terminal"),
        Words("channels_file=FILE"),
    ),
    ("as-paper", Terminal, Words("estimate=\"paper\"")),
    (
        "axis",
        Words("the axis of the plan"),
        Words("the axis of the plan"),
    ),
    (
        "plan",
        Words("“Plan from a file” under “Control”"),
        Argument("file"),
    ),
    (
        "thrust",
        Words("“Speeds, thrust in % of full”"),
        Argument("thrusts"),
    ),
    ("vehicle", Words("“Vehicle”"), Argument("vehicle")),
    ("campaign", Words("campaign"), Argument("campaign")),
    (
        "rehearsal",
        Words("“Use models of a rehearsal as well”"),
        Words("rehearsal=True"),
    ),
    ("logbook", Terminal, Argument("logbook")),
    ("heading-deg", Terminal, Argument("heading_rad")),
    ("hold-gain", Terminal, Argument("hold_gain")),
    ("amplitude-deg", Terminal, Argument("amplitude_rad")),
    ("period-s", Terminal, Argument("period_s")),
    ("target", Terminal, Argument("target")),
    ("adopt", Terminal, Terminal),
    ("zeta", Terminal, Argument("damping_ratio")),
    ("delay", Terminal, Argument("delay_s")),
    ("interval", Terminal, Argument("interval_s")),
    ("extrapolate", Terminal, Words("extrapolate=True")),
    ("at-speed", Terminal, Argument("at_speed_m_s")),
    ("at-thrust", Terminal, Argument("at_thrust")),
    ("sample", Terminal, Terminal),
    ("full-rudder-deg", Terminal, Argument("full_rudder_rad")),
    ("full-steering-deg", Terminal, Argument("full_rudder_rad")),
    (
        "surge-time-constant",
        Terminal,
        Argument("surge_time_constant_s"),
    ),
    (
        "heading-change-deg",
        Terminal,
        Argument("heading_change_rad"),
    ),
    ("measured-u-turn", Terminal, Argument("measured_u_turn")),
    ("up-to-speed", Terminal, Argument("up_to_speed_m_s")),
    ("length", Terminal, Terminal),
    ("kind", Terminal, Terminal),
    ("kinds", Terminal, Terminal),
    ("listen", Terminal, Terminal),
    ("run-column", Terminal, Argument("run_column")),
    ("resume", Terminal, Words("resume=True")),
    ("signing-key", Terminal, Terminal),
    ("steering-outputs", Terminal, Terminal),
    ("vehicle-id", Terminal, Terminal),
    ("without-rc", Terminal, Terminal),
    ("where", Terminal, Terminal),
];

const WINDOW: Has = Words("the training window under “Windows”");
const VALIDATION: Has = Words("the validation window under “Windows”");

/// What a reader has in place of an option, and what comes behind the option and its value.
pub(super) fn said<'a>(name: &str, after: &'a str, reader: Reader) -> Option<(String, &'a str)> {
    if name == "unit" {
        return unit(after, reader);
    }
    // The speed of one model is no column of a log.
    if (name, reader, value(after).0) == ("speed", Reader::Python, Some("M_S")) {
        return Some(("surge_speed_m_s=M_S".into(), value(after).1));
    }
    match OPTIONS.iter().find(|(option, ..)| *option == name) {
        Some((_, page, python)) => {
            let has = match reader {
                Reader::Python => python,
                _ => page,
            };
            Some(has.said(name, after))
        }
        None => column(name.parse().ok()?, after, reader),
    }
}

impl Has {
    fn said<'a>(self, name: &str, after: &'a str) -> (String, &'a str) {
        let behind = behind_placeholder(after);
        match self {
            Field(label) => (of_form(label), behind),
            Words(words) => (words.into(), behind),
            Argument(argument) => match value(after) {
                (Some(value), behind) if is_value(value) => (format!("{argument}={value}"), behind),
                _ => (argument.into(), behind),
            },
            Terminal => (format!("the option {name} in a terminal"), behind),
        }
    }
}

fn of_form(label: &str) -> String {
    format!("“{label}”{FORM}")
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

/// A column by its quantity: `--yaw-rate NAME`, or `--yaw-rate none`, which leaves it out.
fn column(quantity: Quantity, after: &str, reader: Reader) -> Option<(String, &str)> {
    let (named, behind) = match value(after) {
        (Some("none"), behind) => (Some("none"), behind),
        (Some("NAME"), behind) => (Some("NAME"), behind),
        _ => (None, after),
    };
    let said = match (reader, field(quantity), named) {
        (Reader::Python, _, Some(name)) => format!("columns={{\"{quantity}\": \"{name}\"}}"),
        (Reader::Python, _, None) => format!("columns[\"{quantity}\"]"),
        (_, Some(label), Some("none")) => {
            format!("“left out” in {}", of_form(&format!("{label} from column")))
        }
        (_, Some(label), _) => of_form(&format!("{label} from column")),
        (_, None, _) => format!("the option {quantity} in a terminal"),
    };
    Some((said, behind))
}

/// A unit: `--unit heading=deg`.
fn unit(after: &str, reader: Reader) -> Option<(String, &str)> {
    let (value, behind) = value(after);
    let (quantity, unit) = value?.split_once('=')?;
    let quantity: Quantity = quantity.parse().ok()?;
    if reader == Reader::Python {
        return Some((format!("units={{\"{quantity}\": \"{unit}\"}}"), behind));
    }
    let list = of_form(&format!("{} is in", field(quantity)?));
    let said = match unit {
        "UNIT" => list,
        unit => format!("{unit} as {list}"),
    };
    Some((said, behind))
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

/// What comes behind the word that stands for a name or a number where an option is explained.
fn behind_placeholder(after: &str) -> &str {
    match value(after) {
        (Some("NAME" | "DEG" | "US" | "S" | "M_S" | "FILE" | "LOG" | "COLUMN=VALUE"), behind) => {
            behind
        }
        _ => after,
    }
}

/// Is it a number or a name that an argument takes, and no word of the sentence?
fn is_value(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || c == '-') || word.contains(['=', ':'])
}

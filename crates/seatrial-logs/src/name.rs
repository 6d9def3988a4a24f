//! Names of columns taken apart: words, and a unit in brackets or at the end.

use crate::Quantity;
use crate::languages;
use crate::unit::{Dimension, Unit};
use crate::words::words;

/// A column's name in lower-case words, and the text of a unit in brackets.
#[derive(Debug)]
pub(crate) struct ColumnName {
    words: Vec<String>,
    bracket: Option<String>,
}

/// How well a name fits a quantity, and the unit that it states.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fit {
    /// 0 is best.
    pub rank: usize,
    pub unit: StatedUnit,
}

/// What a column's name says about its unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StatedUnit {
    None,
    Known(Unit),
    /// Something in brackets that is no unit of the quantity.
    Unknown(String),
}

/// Rank added where a name only contains the quantity's name.
const CONTAINED: usize = 10;

/// A name of more words is none of a quantity; looking for one takes time with the cube of their number.
const MOST_WORDS: usize = 32;

/// Words that make another quantity of a name that contains a quantity's name.
#[rustfmt::skip]
const OTHER_QUANTITY: [&str; 50] = [
    "soll", "sollwert", "kommando", "desired", "des", "target", "setpoint", "sp", "ref", "reference", "demand",
    "demanded", "goal", "cmd", "command", "commanded", "order", "std", "stdev", "sigma", "var", "variance", "cov",
    "covariance", "err", "error", "valid", "status", "flag", "quality", "count", "counts", "raw", "min", "max", "limit",
    "trim", "gain", "rate", "dot", "acc", "accel", "delta", "offset", "bias", "course", "track", "cog", "set", "mode",
];

/// Words that make a course over ground of a name.
const COURSE: [&str; 6] = ["course", "track", "cog", "grund", "küg", "fond"];

/// Is the column of this name a course over ground, which is where a vehicle goes and not where it points?
pub fn names_a_course(column: &str) -> bool {
    let words = ColumnName::new(column).words;
    words.iter().any(|word| COURSE.contains(&word.as_str()))
}

/// Rank added where a name means what was asked for and not what came of it: any other column of the quantity is better.
const COMMANDED: usize = 20;

/// Parts of names that mean what was asked for.
const COMMANDS: [&str; 11] = [
    "cmd", "command", "order", "demand", "deltac", "kommando", "soll", "consigne", "ordre", "指令",
    "命令",
];

/// Words after a quantity's name that leave it the same quantity.
#[rustfmt::skip]
const SAME_QUANTITY: [&str; 32] = [
    "data", "joint", "act", "mean", "average", "avg", "median", "last", "sensor", "utc", "gmt", "fwd", "main", "true",
    "magnetic", "mag", "filtered", "est", "estimate", "estimated", "measured", "meas", "actual", "feedback", "position",
    "pos", "angle", "value", "boot", "signal", "ist", "gemessen",
];

/// Words in brackets behind a time that say of which clock it is, or how it is written.
const CLOCKS: [&str; 16] = [
    "utc", "gmt", "gps", "local", "lt", "z", "zulu", "iso", "iso8601", "hh", "mm", "ss", "sss",
    "hhmmss", "yyyy", "dd",
];

/// Words in brackets that say to what a value refers or in which sense it counts, and no unit.
#[rustfmt::skip]
const REMARKS: [&str; 25] = [
    "t", "m", "true", "mag", "magnetic", "gyro", "compass", "actual", "measured", "rw", "mw", "rechtweisend",
    "missweisend", "ist", "gemessen", "stbd", "stb", "starboard", "port", "positive", "plus", "right", "left", "真", "磁",
];

impl ColumnName {
    pub fn new(name: &str) -> Self {
        // Japanese text has brackets of its own width.
        let name = name.replace(['（', '［'], "[").replace(['）', '］'], "]");
        // Grafana writes labels in braces behind a name.
        let labels = name.find('{').filter(|at| *at > 0);
        let name = &name[..labels.unwrap_or(name.len())];
        // An index, as in `control[2]`, is no unit.
        let is_index = |rest: &str| {
            rest[1..]
                .strip_suffix([']', ')'])
                .is_some_and(|index| index.bytes().all(|byte| byte.is_ascii_digit()))
        };
        let open = name.find(['[', '(']).filter(|at| !is_index(&name[*at..]));
        let (base, bracket) = match open {
            Some(at) if at > 0 => (
                &name[..at],
                Some(
                    name[at..]
                        .trim_matches(|c: char| "[]()".contains(c) || c.is_whitespace())
                        .to_string(),
                ),
            ),
            _ => (name, None),
        };
        let mut words = words(base);
        // The field of a topic that has no other: `/rudder_deg/data`.
        if words.len() > 1 && words.last().is_some_and(|word| word == "data") {
            words.pop();
        }
        Self { words, bracket }
    }

    /// Does the name fit this quantity?
    pub fn fit(&self, quantity: Quantity) -> Option<Fit> {
        let dimension = quantity.dimension();
        // A remark alone says no unit: that may be at the end of the name.
        if let Some(text) = &self.bracket
            && let unit = stated(text, dimension)
            && let Some(rank) = rank(&self.words, quantity)
        {
            return Some(Fit { rank, unit });
        } else if self
            .bracket
            .as_ref()
            .is_some_and(|text| stated(text, dimension) != StatedUnit::None)
        {
            return None;
        }
        // The longest unit first: `yaw_rate_rad_s` is not the seconds of a `yaw_rate_rad`.
        for unit_words in (1..self.words.len().min(5)).rev() {
            let (base, suffix) = self.words.split_at(self.words.len() - unit_words);
            let suffix: Vec<&str> = suffix.iter().map(String::as_str).collect();
            if is_of_something(base) {
                continue;
            }
            if let Some(unit) = Unit::of_words(&suffix, dimension)
                && let Some(rank) = rank(base, quantity)
            {
                return Some(Fit { rank, unit: StatedUnit::Known(unit) });
            }
        }
        Some(Fit {
            rank: rank(&self.words, quantity)?,
            unit: self.unit_of_the_name(quantity).map_or(StatedUnit::None, StatedUnit::Known),
        })
    }

    /// The unit of a name that is one itself, as `seconds`, or that is a path of Signal K, which has SI units.
    fn unit_of_the_name(&self, quantity: Quantity) -> Option<Unit> {
        let dimension = quantity.dimension();
        let is_path =
            self.words.len() > 1 && matches!(self.words[0].as_str(), "navigation" | "steering");
        match (self.words.as_slice(), dimension) {
            // Receivers of u-blox count the time of the week so.
            (words, Dimension::Time) if words.concat() == "itow" => Some(Unit::Millisecond),
            ([word], Dimension::Time) if word.len() > 2 || word == "ms" => {
                Unit::of_words(&[word], dimension)
            }
            (_, Dimension::Angle | Dimension::Steering) if is_path => Some(Unit::Radian),
            (_, Dimension::AngularRate) if is_path => Some(Unit::RadianPerSecond),
            (_, Dimension::Speed) if is_path => Some(Unit::MetrePerSecond),
            _ => None,
        }
    }

    /// Does a word of the name make another quantity of it?
    pub fn is_of_another_kind(&self) -> bool {
        let mut words = self.words.iter();
        words.any(|word| OTHER_QUANTITY.contains(&word.as_str()))
    }

    /// The unit that the name states for a quantity it was chosen for, whatever the name is.
    pub fn unit(&self, quantity: Quantity) -> StatedUnit {
        if let Some(text) = &self.bracket {
            let unit = stated(text, quantity.dimension());
            if unit != StatedUnit::None {
                return unit;
            }
        }
        let at_the_end = self.unit_at_the_end(quantity).map(|(_, unit)| unit);
        at_the_end
            .or_else(|| self.unit_of_the_name(quantity))
            .map_or(StatedUnit::None, StatedUnit::Known)
    }

    /// The words of the name before the unit that it states for a quantity.
    pub fn without_unit(&self, quantity: Quantity) -> Vec<String> {
        let unit = self.unit_at_the_end(quantity).filter(|_| self.bracket.is_none());
        let words = self.words.len() - unit.map_or(0, |(count, _)| count);
        self.words[..words].to_vec()
    }

    /// A unit in the last words of the name, and how many words that is; the longest unit where several fit.
    fn unit_at_the_end(&self, quantity: Quantity) -> Option<(usize, Unit)> {
        (1..self.words.len().min(5)).rev().find_map(|count| {
            let (base, suffix) = self.words.split_at(self.words.len() - count);
            let suffix: Vec<&str> = suffix.iter().map(String::as_str).collect();
            (!is_of_something(base)).then_some(())?;
            Some((count, Unit::of_words(&suffix, quantity.dimension())?))
        })
    }
}

/// Does the next word say of what it is? `SecondsOfDay` has no days for a unit.
fn is_of_something(base: &[String]) -> bool {
    base.last().is_some_and(|word| word == "of")
}

fn stated(text: &str, dimension: Dimension) -> StatedUnit {
    let lower = words(text);
    // `seconds since 01/01/1970`
    let before_since = lower.iter().take_while(|word| *word != "since");
    let lower: Vec<&str> = before_since.map(String::as_str).collect();
    if let Some(unit) = Unit::of_words(&lower, dimension) {
        return StatedUnit::Known(unit);
    }
    // `°T`, `deg, starboard positive`: a unit, and a remark on the reference or the sense.
    let remarks = lower.iter().rev().take_while(|w| REMARKS.contains(w)).count();
    let before = &lower[..lower.len() - remarks];
    // `Heading (M) (deg)`: the remark first.
    let first = before.iter().take_while(|w| REMARKS.contains(w)).count();
    let before = &before[first..];
    match Unit::of_words(before, dimension) {
        Some(unit) => StatedUnit::Known(unit),
        None if before.is_empty() => StatedUnit::None,
        None if dimension == Dimension::Time => {
            // `GPS s`: of which clock, and a unit.
            let unit: Vec<&str> = lower.into_iter().filter(|w| !CLOCKS.contains(w)).collect();
            match Unit::of_words(&unit, dimension) {
                Some(unit) => StatedUnit::Known(unit),
                None if unit.is_empty() => StatedUnit::None,
                None => StatedUnit::Unknown(text.to_string()),
            }
        }
        None => StatedUnit::Unknown(text.to_string()),
    }
}

fn rank(words: &[String], quantity: Quantity) -> Option<usize> {
    if words.len() > MOST_WORDS {
        return None;
    }
    let whole = words.concat();
    let exact = languages::names(quantity).group_of(&whole);
    let is_command = COMMANDS.iter().any(|part| whole.contains(part));
    // A heading by its own name is better than that of an attitude.
    let is_of_attitude = words.len() > 1 && words.iter().any(|word| word == "attitude");
    let found = exact.or_else(|| contained_rank(words, quantity))?;
    Some(found + usize::from(is_of_attitude) + if is_command { COMMANDED } else { 0 })
}

/// `ATT.Yaw`, `nav_heading_true`, `rudder1`: a clear name among words that do not change its meaning.
fn contained_rank(words: &[String], quantity: Quantity) -> Option<usize> {
    let greek_or_short =
        |name: &str| name.len() < 3 || matches!(name, "psi" | "phi" | "theta" | "delta" | "rot");
    let harmless = |word: &String| {
        SAME_QUANTITY.contains(&word.as_str()) || word.chars().all(|c| c.is_ascii_digit())
    };
    let is_other = |word: &String| OTHER_QUANTITY.contains(&word.as_str());
    let names = languages::names(quantity);
    let ends = |from: usize| (from + 1..=words.len()).map(move |to| (from, to));
    let groups = (0..words.len()).flat_map(ends).filter_map(|(from, to)| {
        let joined = words[from..to].concat();
        let name = joined.trim_end_matches(|c: char| c.is_ascii_digit());
        let is_clear = !greek_or_short(name)
            && !words[..from].iter().any(is_other)
            && words[to..].iter().all(harmless);
        names.group_of(name).filter(|_| is_clear)
    });
    groups.min().map(|group| CONTAINED + group)
}

/// The first 40 characters, control characters escaped.
pub(crate) fn clipped(text: &str) -> String {
    let mut clipped: String = text.chars().take(40).collect::<String>();
    if clipped.len() < text.len() {
        clipped.push('…');
    }
    clipped.escape_debug().to_string()
}

/// At most 30 names, each cut to 40 characters.
pub(crate) fn list(names: &[String]) -> String {
    const SHOWN: usize = 30;
    let mut text = names
        .iter()
        .take(SHOWN)
        .map(|name| format!("`{}`", clipped(name)))
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > SHOWN {
        text += &format!(" and {} more", names.len() - SHOWN);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(name: &str, quantity: Quantity) -> Option<(usize, Option<Unit>)> {
        ColumnName::new(name).fit(quantity).map(|fit| match fit.unit {
            StatedUnit::Known(unit) => (fit.rank, Some(unit)),
            StatedUnit::None => (fit.rank, None),
            StatedUnit::Unknown(text) => panic!("unit {text}"),
        })
    }

    #[test]
    fn io_names_state_quantity_and_unit() {
        use Quantity::*;
        for (name, quantity, rank, unit) in [
            ("t", Time, 0, None),
            ("psi_hat [rad]", Heading, 0, Some(Unit::Radian)),
            ("delta_rudder [rad]", Rudder, 0, Some(Unit::Radian)),
            ("r_angvelo [rad/s]", YawRate, 0, Some(Unit::RadianPerSecond)),
            ("u_velo [m/s]", Speed, 0, Some(Unit::MetrePerSecond)),
            ("TimeUS", Time, 0, Some(Unit::Microsecond)),
            ("time [ms]", Time, 0, Some(Unit::Millisecond)),
            ("time_s", Time, 0, Some(Unit::Second)),
            ("Heading (°)", Heading, 0, Some(Unit::Degree)),
            ("yaw [deg]", Heading, 0, Some(Unit::Degree)),
            ("headingDeg", Heading, 0, Some(Unit::Degree)),
            ("HEADING.RAD", Heading, 0, Some(Unit::Radian)),
            ("ATT.Yaw", Heading, 10, None),
            ("rudder_pwm", Rudder, 0, Some(Unit::PulseWidth)),
            ("servo1_us", Rudder, 13, Some(Unit::PulseWidth)),
            ("Rudder %", Rudder, 0, Some(Unit::Percent)),
            ("rudder_cmd", Rudder, 22, None),
            ("delta_r", Rudder, 0, None),
            ("Ruderwinkel [Grad]", Rudder, 4, Some(Unit::Degree)),
            ("Steuerkurs (Grad)", Heading, 2, Some(Unit::Degree)),
            ("Fahrt [Knoten]", Speed, 3, Some(Unit::Knot)),
            ("Zeit [s]", Time, 3, Some(Unit::Second)),
            ("Drehrate [Grad/min]", YawRate, 2, Some(Unit::DegreePerMinute)),
            ("舵角（度）", Rudder, 4, Some(Unit::Degree)),
            ("船首方位[deg]", Heading, 2, Some(Unit::Degree)),
            ("経過時間(秒)", Time, 3, Some(Unit::Second)),
            ("船速（ノット）", Speed, 3, Some(Unit::Knot)),
            ("Roerhoek (graden)", Rudder, 4, Some(Unit::Degree)),
            ("Rorvinkel (grader)", Rudder, 4, Some(Unit::Degree)),
            ("Курс (град)", Heading, 3, Some(Unit::Degree)),
            ("航向(度)", Heading, 2, Some(Unit::Degree)),
            ("타각(도)", Rudder, 4, Some(Unit::Degree)),
            ("rudder_deg (port positive)", Rudder, 0, Some(Unit::Degree)),
            ("heading_x10", Heading, 0, Some(Unit::Decidegree)),
            ("SecondsOfDay", Time, 1, None),
            ("iTOW", Time, 1, Some(Unit::Millisecond)),
            ("Heading (°T)", Heading, 0, Some(Unit::Degree)),
            ("Heading (true)", Heading, 0, None),
            ("HDG(M)", Heading, 0, None),
            ("Hdg °M", Heading, 0, Some(Unit::Degree)),
            ("Rudder Sensor Angle", Rudder, 10, None),
            ("Kurs (rw)", Heading, 3, None),
            ("Rudder (° stbd +)", Rudder, 0, Some(Unit::Degree)),
            ("Rudder [deg, starboard positive]", Rudder, 0, Some(Unit::Degree)),
            ("回頭角速度 [度/秒]", YawRate, 2, Some(Unit::DegreePerSecond)),
            ("yaw_rate_rad_s", YawRate, 0, Some(Unit::RadianPerSecond)),
            ("YawRate [deg/s]", YawRate, 0, Some(Unit::DegreePerSecond)),
            ("gyro_z", YawRate, 1, None),
            ("surge_speed_m_s", Speed, 0, Some(Unit::MetrePerSecond)),
            ("speed [kn]", Speed, 1, Some(Unit::Knot)),
            ("depth_m", Depth, 0, Some(Unit::Metre)),
        ] {
            assert_eq!(fit(name, quantity), Some((rank, unit)), "{name}");
        }
    }

    #[test]
    fn io_names_of_other_quantities_do_not_fit() {
        for name in [
            "desired_heading",
            "heading_error",
            "yaw_rate",
            "course",
            "delta_yaw",
            "heading_std",
            "yaw_cmd",
        ] {
            assert_eq!(fit(name, Quantity::Heading), None, "{name}");
        }
        assert_eq!(fit("roll_counts", Quantity::Roll), None);
        assert_eq!(fit("delta_t", Quantity::Rudder), None);
    }

    /// Found by fuzzing: a header with a quotation mark left open took seconds for a kB of it.
    #[test]
    fn regress_a_long_name_takes_no_time() {
        let begun = std::time::Instant::now();
        let name = ColumnName::new(&"heading of ".repeat(20_000));
        assert_eq!(name.fit(Quantity::Heading), None);
        // Some ms; hours when all runs of its words are looked at.
        assert!(begun.elapsed().as_secs() < 5);
    }
}

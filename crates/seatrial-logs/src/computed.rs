//! Columns that are computed from others: a pair of fins, a stamp in two columns, a date in six, an attitude in four.

use seatrial_core::Real;
use seatrial_core::attitude::euler_rad;

use crate::choice::{ChannelChoice, mirrored};
use crate::clock::unix_s;
use crate::coordinates::{coordinate, degrees, metres};
use crate::error::Fault;
use crate::languages;
use crate::matching::pair_of_columns;
use crate::name::ColumnName;
use crate::{
    Quantity, Unit,
    table::Cell,
    words::{is_among, words},
};

/// Hours, minutes and seconds.
const OF_DAY: usize = 3;
/// Words of columns of the time of day.
const HOURS: &str = "hour hours hh hr stunde";
const MINUTES: &str = "minute minutes min mi mn";
const SECONDS: &str = "second seconds sec secs ss sekunde";
/// Words of columns of a fraction of a second, and its counts in a second.
const FRACTIONS: [(&str, f64); 4] = [
    ("nsecs nsec nanosec nanosecs nanoseconds", 1e9),
    ("usecs usec microsec microsecs microseconds", 1e6),
    ("ms msec msecs millis millisec milliseconds millisecond", 1e3),
    ("cs hundredths centiseconds", 1e2),
];

/// A sine and a cosine shorter than this together have no direction: both are 0 where nothing was measured.
const LEAST_LENGTH: f64 = 0.1;

/// A column that is computed from others.
#[derive(Debug)]
pub(crate) struct Computed {
    pub quantity: Quantity,
    /// Its name, which says how it is computed.
    pub name: String,
    /// The columns that it is computed from.
    pub sources: Vec<usize>,
    rule: Rule,
}

#[derive(Debug)]
enum Rule {
    /// The second column has the sign that the other counts by.
    HalfDifference { sign: f64 },
    /// Seconds, or hour, minute, second, or those behind year, month, day; then a fraction in counts of a second.
    Parts { per_second: Option<f64>, is_of_day: bool },
    /// A date, and a time of day.
    DateAndTime,
    /// The heading whose sine and cosine they are.
    SineAndCosine,
    /// x, y, z, w: from east, north, up to a heading, or from north, east, down.
    Quaternion { z_is_down: bool },
    /// Metres north (0) or east (1) of the first position, from a latitude and a longitude.
    Metres { way: usize, first: Option<[f64; 2]> },
}

/// The name of half the difference of two columns.
pub(crate) fn half_difference_name([first, second]: &[String; 2]) -> String {
    match mirrored(second) {
        Some(second) => format!("({first} + {second}) / 2"),
        None => format!("({first} - {second}) / 2"),
    }
}

/// The columns that a choice or the names of columns ask for; those of names only for quantities without a column.
pub(crate) fn computed(
    columns: &[String],
    is_known: bool,
    has_coordinates: bool,
    choice: &ChannelChoice,
) -> Result<Vec<Computed>, Fault> {
    let mut computed = Vec::new();
    for (quantity, pair) in &choice.half_differences {
        computed.push(Computed {
            quantity: *quantity,
            name: half_difference_name(pair),
            sources: pair_of_columns(pair, columns, *quantity)?.to_vec(),
            rule: Rule::HalfDifference { sign: mirrored(&pair[1]).map_or(1.0, |_| -1.0) },
        });
    }
    let names = Names::new(columns);
    let is_free = |quantity: Quantity| !choice.columns.contains_key(&quantity);
    let mut found = Vec::new();
    if !is_known && is_free(Quantity::Time) {
        found.extend(
            names
                .calendar()
                .or_else(|| names.time_of_day())
                .or_else(|| names.stamp())
                .or_else(|| names.date_and_time()),
        );
    }
    let has = |quantity: Quantity| {
        columns.iter().any(|name| ColumnName::new(name).fit(quantity).is_some())
    };
    if !is_known && is_free(Quantity::Heading) && !has(Quantity::Heading) {
        found.extend(names.sine_and_cosine().or_else(|| names.quaternion()));
    }
    if has_coordinates
        && is_free(Quantity::North)
        && is_free(Quantity::East)
        && !(has(Quantity::North) && has(Quantity::East))
    {
        found.extend(names.positions().into_iter().flatten());
    }
    computed.extend(found);
    Ok(computed)
}

/// The names of columns in words.
struct Names<'a> {
    columns: &'a [String],
    words: Vec<Vec<String>>,
}

impl<'a> Names<'a> {
    fn new(columns: &'a [String]) -> Self {
        let words = columns.iter().map(|name| words(name)).collect();
        Self { columns, words }
    }

    /// The column of this prefix whose last word is one of these.
    fn column(&self, prefix: &[String], last: &str) -> Option<usize> {
        let is_it = |(word, before): (&String, &[String])| before == prefix && is_among(last, word);
        let mut names = self.words.iter();
        names.position(|words| words.split_last().is_some_and(is_it))
    }

    /// Columns of one prefix whose last words are each one of a group.
    fn group<const N: usize>(&self, groups: [&str; N]) -> Option<[usize; N]> {
        self.words.iter().find_map(|words| {
            let (word, prefix) = words.split_last()?;
            is_among(groups[0], word).then_some(())?;
            let mut found = [0; N];
            for (column, group) in found.iter_mut().zip(groups) {
                *column = self.column(prefix, group)?;
            }
            Some(found)
        })
    }

    fn list(&self, sources: &[usize]) -> String {
        let names: Vec<&str> =
            sources.iter().map(|column| self.columns[*column].as_str()).collect();
        names.join(" + ")
    }

    fn of(&self, quantity: Quantity, name: String, sources: &[usize], rule: Rule) -> Computed {
        Computed { quantity, name, sources: sources.to_vec(), rule }
    }

    /// Columns of parts of a time, with one of fractions of a second where there is one.
    fn parts<const N: usize>(&self, groups: [&str; N]) -> Option<Computed> {
        let found = self.group(groups)?;
        let (_, prefix) = self.words[found[0]].split_last()?;
        let fraction = FRACTIONS.iter().find_map(|(names, per_second)| {
            let column = self.column(prefix, names)?;
            Some((column, *per_second))
        });
        let sources = [&found[..], fraction.map(|(column, _)| column).as_slice()].concat();
        let per_second = fraction.map(|(_, per_second)| per_second);
        let name = self.list(&sources);
        let rule = Rule::Parts { per_second, is_of_day: N == OF_DAY };
        Some(self.of(Quantity::Time, name, &sources, rule))
    }

    /// `stamp.secs` and `stamp.nsecs`.
    fn stamp(&self) -> Option<Computed> {
        let has_fraction = |parts: &Computed| parts.sources.len() == 2;
        let is_of_a_minute = self.group([MINUTES, SECONDS]).is_some();
        let stamp = self.parts([SECONDS]).filter(has_fraction);
        stamp.filter(|_| !is_of_a_minute)
    }

    /// Columns of hour, minute and second, where no other says the time.
    fn time_of_day(&self) -> Option<Computed> {
        let parts = self.parts([HOURS, MINUTES, SECONDS])?;
        let is_other = |column: &usize| !parts.sources.contains(column);
        let names_the_time = |column: usize| {
            let name = ColumnName::new(&self.columns[column]);
            name.fit(Quantity::Time).is_some()
        };
        let mut others = (0..self.columns.len()).filter(is_other);
        (!others.any(names_the_time)).then_some(parts)
    }

    /// Columns of year, month, day, hour, minute and second.
    fn calendar(&self) -> Option<Computed> {
        self.parts([
            "year yyyy yy yr jahr",
            "month mon mo mm monat",
            "day dd tag",
            HOURS,
            MINUTES,
            SECONDS,
        ])
    }

    /// A column of the date and one of the time of day.
    fn date_and_time(&self) -> Option<Computed> {
        let of = |wanted: &str| {
            let is_wanted = |word: &String| is_among(wanted, word);
            self.words.iter().position(|words| {
                let is_clock = |word: &&String| is_among("utc gmt local gps", word);
                let others: Vec<&String> = words.iter().filter(|word| !is_clock(word)).collect();
                matches!(&words[..], [word] if is_wanted(word))
                    || matches!(&others[..], [word] if is_wanted(word))
            })
        };
        let [clear, vague] = languages::names(Quantity::Time).others();
        let time = ["time clock utc gmt", clear, vague].into_iter().find_map(of);
        let sources = [of("date datum fecha data dato дата 日付 日期")?, time?];
        let name = self.list(&sources);
        Some(self.of(Quantity::Time, name, &sources, Rule::DateAndTime))
    }

    /// `sin_psi` and `cos_psi`, of one heading.
    fn sine_and_cosine(&self) -> Option<Computed> {
        let without = |words: &[String], function: [&str; 2]| {
            let is_it = |word: &String| function.contains(&word.as_str());
            let mut others = words.to_vec();
            others.remove(words.iter().position(is_it)?);
            let of_heading = ColumnName::new(&others.join("_")).fit(Quantity::Heading);
            of_heading.map(|_| others)
        };
        let sources = (0..self.words.len()).find_map(|sine| {
            let of = without(&self.words[sine], ["sin", "sine"])?;
            let is_cosine = |words: &Vec<String>| {
                without(words, ["cos", "cosine"]).is_some_and(|others| others == of)
            };
            Some([sine, self.words.iter().position(is_cosine)?])
        })?;
        let name = format!("heading of {}", self.list(&sources));
        Some(self.of(Quantity::Heading, name, &sources, Rule::SineAndCosine))
    }

    /// `orientation.x` to `orientation.w`, or `qx` to `qw`.
    fn quaternion(&self) -> Option<Computed> {
        const PREFIXES: &str = "orientation quaternion quat q rotation attitude";
        let of_prefix = self.words.iter().find_map(|words| {
            let (word, prefix) = words.split_last()?;
            let is_attitude = prefix.last().is_some_and(|word| is_among(PREFIXES, word));
            (word == "x" && is_attitude).then_some(())?;
            let mut sources = [0; 4];
            for (source, axis) in sources.iter_mut().zip(["x", "y", "z", "w"]) {
                *source = self.column(prefix, axis)?;
            }
            Some(sources)
        });
        let by_letters = of_prefix.or_else(|| self.group(["qx", "qy", "qz", "qw"]));
        // Autopilots number them from w on.
        let by_numbers = || {
            let of_a_list = self.group(["1", "2", "3", "0"]);
            let is_attitude = |sources: &[usize; 4]| {
                let words = &self.words[sources[0]];
                let name = words.len().checked_sub(2).map(|at| words[at].as_str());
                name.is_some_and(|name| is_among(PREFIXES, name))
            };
            self.group(["q1", "q2", "q3", "q0"]).or_else(|| of_a_list.filter(is_attitude))
        };
        let z_is_down = by_letters.is_none();
        let sources = by_letters.or_else(by_numbers)?;
        let name = format!("heading of {}", self.list(&sources));
        let rule = Rule::Quaternion { z_is_down };
        Some(self.of(Quantity::Heading, name, &sources, rule))
    }

    /// Metres north and east from latitude and longitude.
    fn positions(&self) -> Option<[Computed; 2]> {
        let place = |of: &str| {
            let mut names = self.words.iter();
            names.position(|words| names_a_coordinate(words, of))
        };
        let sources = [place("latitude lat")?, place("longitude lon lng long")?];
        let metres = |(quantity, way)| {
            let name = format!("{quantity} by {}", self.list(&sources));
            self.of(quantity, name, &sources, Rule::Metres { way, first: None })
        };
        Some([(Quantity::North, 0), (Quantity::East, 1)].map(metres))
    }
}

/// Is one of these words in the name, and no word of another kind behind it?
fn names_a_coordinate(words: &[String], of: &str) -> bool {
    let is_harmless = |word: &String| is_among("deg degrees value 1 0 wgs84 e7", word);
    let at = words.iter().position(|word| is_among(of, word));
    at.is_some_and(|at| words[at + 1..].iter().all(is_harmless))
}

impl Computed {
    /// What the rule assumes and no value shows.
    pub fn remark(&self) -> Option<String> {
        let Rule::Quaternion { z_is_down } = self.rule else {
            return None;
        };
        let (of, other) = match z_is_down {
            true => ("autopilots, w first, x forward and z down, from north to east", "up"),
            false => ("ROS, x forward and z up, from east to north", "down"),
        };
        Some(format!(
            "{} is that of {of}: where z points {other}, turns have the other sign",
            self.name
        ))
    }

    /// Its unit, where the rule says.
    pub fn unit(&self) -> Option<Unit> {
        match &self.rule {
            Rule::HalfDifference { .. } | Rule::DateAndTime => None,
            // It says so by itself, and begins again at midnight.
            Rule::Parts { is_of_day, .. } if *is_of_day => None,
            Rule::Parts { .. } => Some(Unit::Second),
            Rule::Quaternion { .. } | Rule::SineAndCosine => Some(Unit::Radian),
            Rule::Metres { .. } => Some(Unit::Metre),
        }
    }

    /// The latitude and longitude from which its metres are, deg, once a row was read.
    pub fn origin_deg(&self) -> Option<[f64; 2]> {
        match self.rule {
            Rule::Metres { first, .. } => first,
            _ => None,
        }
    }

    /// The cell of a row, from the cells of its sources.
    pub fn cell(&mut self, sources: &[Cell]) -> Cell {
        if let (Rule::HalfDifference { sign }, [first, second]) = (&self.rule, sources) {
            return half_difference(first, second, *sign);
        }
        if let (Rule::DateAndTime, [date, time]) = (&self.rule, sources) {
            return date_and_time(date, time);
        }
        let mut numbers = Vec::with_capacity(sources.len());
        for cell in sources.iter().map(coordinate) {
            match cell {
                Cell::Number(number) | Cell::OfDay(number) => numbers.push(number),
                other => return other,
            }
        }
        let number = self.number(&numbers).filter(|number| number.is_finite());
        match (number, &self.rule) {
            (None, _) => Cell::Missing,
            (Some(time_s), Rule::Parts { is_of_day, .. }) if *is_of_day => Cell::OfDay(time_s),
            (Some(number), _) => Cell::Number(number),
        }
    }

    fn number(&mut self, numbers: &[f64]) -> Option<f64> {
        match (&mut self.rule, numbers) {
            (Rule::Parts { per_second, .. }, numbers) => {
                let (parts, fraction_s) = match (*per_second, numbers.split_last()) {
                    (Some(per_second), Some((count, parts))) => (parts, count / per_second),
                    _ => (numbers, 0.0),
                };
                of_parts(parts, fraction_s)
            }
            (Rule::SineAndCosine, [sine, cosine]) => {
                (libm::hypot(*sine, *cosine) > LEAST_LENGTH).then(|| libm::atan2(*sine, *cosine))
            }
            // From x forward, y port, z up in east, north, up.
            (Rule::Quaternion { z_is_down }, [x, y, z, w]) => {
                let [_, _, yaw] = euler_rad([*w, *x, *y, *z]);
                Some(match z_is_down {
                    true => yaw,
                    false => Real::wrapped(std::f64::consts::FRAC_PI_2 - yaw),
                })
            }
            (Rule::Metres { way, first }, [latitude, longitude]) => {
                let place = [*latitude, *longitude].map(degrees);
                Some(metres(place, *first.get_or_insert(place))[*way])
            }
            _ => None,
        }
    }
}

/// Seconds of a time in parts.
fn of_parts(parts: &[f64], fraction_s: f64) -> Option<f64> {
    let (date, of_day) =
        parts.split_at_checked(3).filter(|(_, of_day)| !of_day.is_empty()).unwrap_or((&[], parts));
    let whole_s = of_day.iter().fold(0.0, |sum, part| 60.0 * sum + part);
    let of_day_s = whole_s + fraction_s;
    match date {
        [year, month, day] => unix_s(*year, *month, *day, of_day_s),
        // Some write the whole time in the column of the fraction.
        _ if fraction_s >= 1.0 && fraction_s.floor() == whole_s => Some(fraction_s),
        _ => Some(of_day_s),
    }
}

/// Half of what a cell has more than another, which may count by the other sign.
fn half_difference(first: &Cell, second: &Cell, sign: f64) -> Cell {
    match (first, second) {
        (Cell::Number(first), Cell::Number(second)) => Cell::Number(0.5 * (first - sign * second)),
        (Cell::Number(_), other) | (other, _) => other.clone(),
    }
}

/// The instant of a date and a time of day; the time alone where the date is no date.
fn date_and_time(date: &Cell, time: &Cell) -> Cell {
    match (date, time) {
        (Cell::Instant(date), Cell::Number(of_day_s) | Cell::OfDay(of_day_s))
            if of_day_s.abs() < 1e9 =>
        {
            let of_day = jiff::SignedDuration::from_secs_f64(*of_day_s);
            date.checked_add(of_day).map_or(Cell::Missing, Cell::Instant)
        }
        _ => time.clone(),
    }
}

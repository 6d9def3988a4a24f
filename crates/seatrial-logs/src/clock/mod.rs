//! Time: from what a log writes to the log's own seconds.

mod face;
mod text;

use jiff::Timestamp;

use crate::number::median;
use crate::table::Cell;
use crate::{Unit, UnitSource};
pub(crate) use face::Face;
use face::begins_again;
pub(crate) use text::{instant, time_of_day};

/// How the time column becomes seconds.
///
/// Plain seconds stay as they are; an epoch or calendar time becomes seconds since the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Clock {
    Plain {
        per_second: f64,
    },
    /// Counts since the beginning of an era.
    Epoch {
        start: f64,
        era: Era,
    },
    /// Digits of a time of day, `hhmmss.sss`, or of a date and time, `yyyymmddhhmmss.sss`; without the point where
    /// a second has `per_second` counts.
    Digits {
        start_s: f64,
        per_second: f64,
    },
    Calendar {
        start: Timestamp,
    },
    /// Times of day with colons.
    OfDay,
}

/// A beginning from which times are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Era {
    unit: Unit,
    /// Its beginning in seconds since 1970.
    zero_unix_s: f64,
    name: &'static str,
}

const fn era(unit: Unit, zero_unix_s: f64, name: &'static str) -> Era {
    Era { unit, zero_unix_s, name }
}

/// Beginnings of two of the eras, in seconds since 1970.
const WINDOWS_UNIX_S: f64 = -11_644_473_600.0;
const LABVIEW_UNIX_S: f64 = -2_082_844_800.0;

/// The eras of loggers; of several in one unit that give a year of our time the first counts.
const ERAS: [Era; 16] = [
    era(Unit::Second, 0.0, "1970"),
    era(Unit::Centisecond, 0.0, "1970"),
    era(Unit::Millisecond, 0.0, "1970"),
    era(Unit::Microsecond, 0.0, "1970"),
    era(Unit::Nanosecond, 0.0, "1970"),
    era(Unit::Tick, 0.0, "1970"),
    era(Unit::Tick, WINDOWS_UNIX_S, "1601, as Windows counts"),
    era(Unit::Microsecond, WINDOWS_UNIX_S, "1601, as Windows counts"),
    era(Unit::Millisecond, WINDOWS_UNIX_S, "1601, as Windows counts"),
    era(Unit::Tick, -62_135_596_800.0, "year 1, as .NET counts"),
    era(Unit::Second, LABVIEW_UNIX_S, "1904, as LabVIEW counts"),
    era(Unit::Millisecond, LABVIEW_UNIX_S, "1904, as LabVIEW counts"),
    era(Unit::Day, -2_209_161_600.0, "1900, as a spreadsheet counts"),
    era(Unit::Day, -3_506_716_800.0, "17 November 1858 (modified Julian date)"),
    era(Unit::Day, -62_167_305_600.0, "year 0, as MATLAB counts"),
    era(Unit::Day, -210_866_760_000.0, "4713 BC (Julian date)"),
];

impl Era {
    fn per_second(&self) -> f64 {
        per_second(self.unit)
    }

    fn unix_s(&self, count: f64) -> f64 {
        count / self.per_second() + self.zero_unix_s
    }

    /// Is it a time at which logs were written?
    fn is_ours(&self, count: f64) -> bool {
        OUR_YEARS_UNIX_S.contains(&self.unix_s(count))
    }
}

/// Seconds since 1970 of the years 2000 to 2060. Ticks of .NET would be nanoseconds of 1990.
const OUR_YEARS_UNIX_S: std::ops::Range<f64> = 9.4e8..2.84e9;
/// No log in seconds has shorter steps.
const SHORTEST_STEP_S: f64 = 5e-4;

/// Counts of a unit of time in a second. Division by it: 50 ms are exactly the double nearest to 0.05.
fn per_second(unit: Unit) -> f64 {
    match unit.factor() {
        factor if factor < 1.0 => (1.0 / factor).round(),
        factor => 1.0 / factor,
    }
}

/// What was found out about the time column.
#[derive(Debug)]
pub(crate) struct ClockFound {
    pub clock: Clock,
    pub unit: Unit,
    pub because: Option<String>,
    pub is_doubtful: bool,
}

impl ClockFound {
    /// A clock whose times say that they are in seconds.
    fn known(clock: Clock, because: &str) -> Self {
        Self { clock, unit: Unit::Second, because: Some(because.into()), is_doubtful: false }
    }

    /// A date or a time of day says of what it is; a number does not.
    pub fn source(&self) -> UnitSource {
        match self.clock {
            Clock::Calendar { .. } | Clock::Digits { .. } | Clock::OfDay => UnitSource::Stated,
            Clock::Plain { .. } | Clock::Epoch { .. } => UnitSource::Assumed,
        }
    }

    /// What people should know where the unit of time is a guess.
    pub fn doubt(&self) -> Option<String> {
        let (unit, because) = (self.unit, self.because.as_deref().unwrap_or("values"));
        self.is_doubtful.then(|| {
            format!(
                "time has no unit and is taken as {unit}, because of its {because}; say which with --unit time=UNIT"
            )
        })
    }
}

impl Clock {
    /// Log time, s. `None` where the cell is no time of this clock.
    pub fn seconds(&self, cell: &Cell) -> Option<f64> {
        match (self, cell) {
            (Self::Plain { per_second }, Cell::Number(time)) => Some(time / per_second),
            (Self::OfDay | Self::Plain { .. }, Cell::OfDay(time)) => Some(*time),
            (Self::Epoch { start, era }, Cell::Number(time)) => {
                Some((time - start) / era.per_second())
            }
            (Self::Digits { start_s, per_second }, Cell::Number(time)) => {
                Some(of_digits(time / per_second)? - start_s)
            }
            (Self::Calendar { start }, Cell::Instant(time)) => {
                let nanoseconds = time.as_nanosecond() - start.as_nanosecond();
                Some(nanoseconds as f64 / 1e9)
            }
            _ => None,
        }
    }

    /// What a time must be, for messages.
    pub fn expected(&self) -> &'static str {
        match self {
            Self::Calendar { .. } => "a date and time such as 2026-11-20T12:00:00.05Z",
            Self::Digits { .. } => "a time such as 120000.05",
            Self::OfDay => "a time such as 12:00:00.05",
            _ => "a number",
        }
    }

    /// The first instant in seconds since 1970, where the log says.
    pub fn start_unix_s(&self) -> Option<f64> {
        match self {
            Self::Plain { .. } | Self::OfDay => None,
            Self::Epoch { start, era } => Some(era.unix_s(*start)),
            // A time of day has no date.
            Self::Digits { start_s, .. } => Some(*start_s).filter(|s| OUR_YEARS_UNIX_S.contains(s)),
            Self::Calendar { start } => Some(start.as_nanosecond() as f64 / 1e9),
        }
    }

    /// The first instant in UTC, where the log says.
    pub fn start(&self) -> Option<String> {
        let start = match self {
            Self::Calendar { start } => *start,
            _ => Timestamp::from_microsecond((self.start_unix_s()? * 1e6).round() as i64).ok()?,
        };
        Some(start.to_string())
    }

    /// From the first time cells of a log and the unit that the column states.
    pub fn find(cells: &[Cell], stated: Option<Unit>) -> ClockFound {
        let numbers: Vec<f64> = cells
            .iter()
            .filter_map(|cell| match cell {
                Cell::Number(time) if time.is_finite() => Some(*time),
                _ => None,
            })
            .collect();
        let is_of_day = |cell: &Cell| matches!(cell, Cell::OfDay(_));
        if numbers.is_empty() && cells.iter().any(is_of_day) {
            return ClockFound::known(Self::OfDay, "time of day");
        }
        if numbers.is_empty()
            && let Some(start) = cells.iter().find_map(|cell| match cell {
                Cell::Instant(instant) => Some(*instant),
                _ => None,
            })
        {
            return ClockFound::known(Self::Calendar { start }, "calendar time");
        }
        let first = numbers.first().copied().unwrap_or(0.0);
        if stated.is_none()
            && let Some(per_second) = digits_per_second(&numbers)
        {
            let start_s = of_digits(first / per_second).unwrap_or(0.0);
            let clock = Self::Digits { start_s, per_second };
            return ClockFound::known(clock, "digits of hours, minutes and seconds");
        }
        let median = median_step(&numbers);
        let eras = eras_of(first, median, stated);
        if let [era, others @ ..] = &eras[..]
            && others.iter().all(|other| other.unit == era.unit)
        {
            let era = *era;
            let because = format!("{first} counts {} since {}", era.unit, era.name);
            return ClockFound {
                clock: Self::Epoch { start: first, era },
                unit: era.unit,
                because: stated.is_none().then_some(because),
                is_doubtful: false,
            };
        }
        let (unit, because, is_doubtful) = plain_unit(&numbers, median, &eras, stated);
        ClockFound {
            clock: Self::Plain { per_second: per_second(unit) },
            unit,
            because,
            is_doubtful,
        }
    }
}

/// The unit of counts that are no date, why, and whether it is a guess.
fn plain_unit(
    numbers: &[f64],
    median: f64,
    eras: &[Era],
    stated: Option<Unit>,
) -> (Unit, Option<String>, bool) {
    match (stated, eras) {
        (Some(unit), _) => (unit, None, false),
        (None, []) => inferred_unit(numbers, median),
        // The count alone would be two times of ours, at two rates.
        (None, [era, ..]) => (era.unit, Some(several(numbers[0], eras)), true),
    }
}

/// `1 counts us since 1601 or 100ns since 1970`.
fn several(first: f64, eras: &[Era]) -> String {
    let each: Vec<String> =
        eras.iter().map(|era| format!("{} since {}", era.unit, era.name)).collect();
    format!("size: {first} counts {}", each.join(" or "))
}

/// The eras from whose beginning the first time may be counted, where it is one of our years.
fn eras_of(first: f64, median_step: f64, stated: Option<Unit>) -> Vec<Era> {
    let is_in = |era: &Era| {
        let is_of_days = era.unit == Unit::Day;
        let steps_fit = stated.is_some() || !is_of_days || median_step < SHORTEST_STEP_S;
        stated.is_none_or(|unit| unit == era.unit) && era.is_ours(first) && steps_fit
    };
    ERAS.into_iter().filter(is_in).collect()
}

/// Units of plain counts.
const UNITS: [Unit; 3] = [Unit::Millisecond, Unit::Microsecond, Unit::Nanosecond];

/// The median of the steps forward; NaN of none.
fn median_step(numbers: &[f64]) -> f64 {
    let steps = numbers.windows(2).map(|pair| pair[1] - pair[0]);
    median(steps.filter(|step| *step > 0.0)).unwrap_or(f64::NAN)
}

fn inferred_unit(numbers: &[f64], median: f64) -> (Unit, Option<String>, bool) {
    if median.is_nan() {
        return (Unit::Second, Some("one sample".into()), false);
    }
    // Loggers that count in whole ms, us or ns sample between 200 Hz and once in 5 s.
    let whole = numbers.iter().all(|time| time.fract() == 0.0);
    let unit = UNITS
        .into_iter()
        .find(|unit| whole && (5e-3..=5.0).contains(&(median * unit.factor())) && median > 5.0)
        .unwrap_or(Unit::Second);
    let because = format!("median step {}", (median * 1e6).round() / 1e6);
    (unit, Some(because), unit != Unit::Second)
}

/// The counts of a second where these times are written as digits: 1, or 1000 of `hhmmssmmm`.
fn digits_per_second(numbers: &[f64]) -> Option<f64> {
    [1.0, 1e3].into_iter().find(|per_second| {
        let times: Vec<f64> = numbers.iter().map(|number| number / per_second).collect();
        are_digits(&times)
    })
}

/// Are these times written as digits? A date shows by itself; a time of day by minutes that end at 59 seconds.
fn are_digits(numbers: &[f64]) -> bool {
    if numbers.len() < 2 || numbers.iter().any(|number| of_digits(*number).is_none()) {
        return false;
    }
    let is_date = numbers.iter().all(|number| *number >= 1e13);
    let passes_minutes = numbers.windows(2).any(|pair| pair[1] - pair[0] >= 40.0);
    let seconds = |number: &f64| of_digits(*number).unwrap_or(f64::NAN);
    let usual = median_step(numbers);
    // Where the clock begins again it goes back.
    let rises = || numbers.windows(2).filter(|pair| pair[1] > pair[0]);
    let times = || rises().map(|pair| seconds(&pair[1]) - seconds(&pair[0]));
    let risen: f64 = rises().map(|pair| pair[1] - pair[0]).sum();
    // What looks like a gap of 40 s in plain numbers is none in times.
    let is_even = times().fold(0.0, f64::max) < 40.0 && risen > times().sum();
    let turns = |pair: &[f64]| begins_again(seconds(&pair[0]), seconds(&pair[1])).is_some();
    let is_of_a_face = numbers.windows(2).any(turns);
    is_date || is_of_a_face || (passes_minutes && is_even && usual < 30.0)
}

/// Seconds since midnight of `hhmmss.sss`, since 1970 of `yyyymmddhhmmss.sss`.
fn of_digits(number: f64) -> Option<f64> {
    const DATE: f64 = 1e6;
    let (days, time) = ((number / DATE).floor(), number.rem_euclid(DATE));
    let [hours, minutes, seconds] = [(time / 1e4).floor(), (time / 1e2).floor() % 1e2, time % 1e2];
    if !(0.0..24.0).contains(&hours) || minutes >= 60.0 || seconds >= 60.0 || number < 0.0 {
        return None;
    }
    let of_day_s = 3600.0 * hours + 60.0 * minutes + seconds;
    if days == 0.0 {
        return Some(of_day_s);
    }
    if !(19_900_101.0..20_600_101.0).contains(&days) {
        return None;
    }
    let days = days as u32;
    let date = format!("{}-{:02}-{:02}", days / 10_000, days / 100 % 100, days % 100);
    let midnight = instant(&format!("{date}T00:00:00Z"))?;
    Some(midnight.as_second() as f64 + of_day_s)
}

/// Seconds since 1970 of a date in numbers, and of seconds since its midnight.
pub(crate) fn unix_s(year: f64, month: f64, day: f64, of_day_s: f64) -> Option<f64> {
    let year = if year < 100.0 { year + 2000.0 } else { year };
    let midnight = instant(&format!("{year:04}-{month:02}-{day:02}T00:00:00Z"))?;
    Some(midnight.as_second() as f64 + of_day_s)
}

/// Seconds since 1970 of 100 ns since 1601, as Windows counts them.
pub(crate) fn ticks_unix_s(ticks: f64) -> f64 {
    ticks / 1e7 + WINDOWS_UNIX_S
}

/// Seconds since 1970 of days since 1900, as a spreadsheet counts them.
pub(crate) fn days_unix_s(days: f64) -> Option<f64> {
    let of_days = |era: &&Era| era.unit == Unit::Day && era.is_ours(days);
    ERAS.iter().find(of_days).map(|era| era.unix_s(days))
}

/// A time that stands before a message: a date and time, a time of day, or seconds, or counts since the beginning of an era.
pub(crate) fn stamp_s(text: &str) -> Option<f64> {
    if let Some(instant) = instant(text) {
        return Some(instant.as_nanosecond() as f64 / 1e9);
    }
    if let Some(of_day_s) = time_of_day(text) {
        return Some(of_day_s);
    }
    let number: f64 = text.parse().ok().filter(|number: &f64| number.is_finite())?;
    let era = ERAS.iter().find(|era| era.unit != Unit::Day && era.is_ours(number));
    Some(era.map_or(number, |era| era.unix_s(number)))
}

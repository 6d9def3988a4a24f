//! Time: from what a log writes to the log's own seconds.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};

use crate::table::Cell;
use crate::{Unit, UnitSource};

/// How the time column becomes seconds.
///
/// Plain seconds stay as they are; an epoch or calendar time becomes seconds since the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Clock {
    Plain { per_second: f64 },
    Epoch { start: f64, per_second: f64 },
    Calendar { start: Timestamp },
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
    /// A date or a time of day says of what it is; a number does not.
    pub fn source(&self) -> UnitSource {
        match self.clock {
            Clock::Calendar { .. } => UnitSource::Stated,
            Clock::Plain { .. } | Clock::Epoch { .. } => UnitSource::Assumed,
        }
    }

    /// What people should know where the unit of time is a guess.
    pub fn doubt(&self) -> Option<String> {
        let because = self.because.as_deref().unwrap_or("values");
        self.is_doubtful.then(|| {
            format!(
                "time has no unit and is taken as {}, because of its {because}; say which with --unit time=UNIT",
                self.unit
            )
        })
    }
}

impl Clock {
    /// Log time, s. `None` where the cell is no time of this clock.
    pub fn seconds(&self, cell: &Cell) -> Option<f64> {
        match (self, cell) {
            // Division: 50 ms are exactly the double nearest to 0.05.
            (Self::Plain { per_second }, Cell::Number(time)) => Some(time / per_second),
            (Self::Epoch { start, per_second }, Cell::Number(time)) => {
                Some((time - start) / per_second)
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
            _ => "a number",
        }
    }

    /// The first instant in UTC, where the log says.
    pub fn start(&self) -> Option<String> {
        let start = match self {
            Self::Plain { .. } => return None,
            // Days of a spreadsheet count from another year.
            Self::Epoch { per_second, .. } if *per_second < 1.0 => return None,
            Self::Epoch { start, per_second } => {
                Timestamp::from_microsecond((start / per_second * 1e6).round() as i64).ok()?
            }
            Self::Calendar { start } => *start,
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
        if numbers.is_empty()
            && let Some(start) = cells.iter().find_map(|cell| match cell {
                Cell::Instant(instant) => Some(*instant),
                _ => None,
            })
        {
            return ClockFound {
                clock: Self::Calendar { start },
                unit: Unit::Second,
                because: Some("calendar time".into()),
                is_doubtful: false,
            };
        }
        let first = numbers.first().copied().unwrap_or(0.0);
        let (unit, because, is_doubtful) = match stated {
            Some(unit) => (unit, None, false),
            None => inferred_unit(first, &numbers),
        };
        let per_second = match unit.factor() {
            factor if factor < 1.0 => (1.0 / factor).round(),
            factor => 1.0 / factor,
        };
        let clock = if is_epoch(first / per_second) {
            Self::Epoch {
                start: first,
                per_second,
            }
        } else {
            Self::Plain { per_second }
        };
        ClockFound {
            clock,
            unit,
            because,
            is_doubtful,
        }
    }
}

/// Seconds since 1970 of the years 1990 to 2100.
fn is_epoch(seconds: f64) -> bool {
    (6.3e8..4.1e9).contains(&seconds)
}

/// Days since 1900 of the years 1980 to 2100.
const SPREADSHEET_DAYS: std::ops::Range<f64> = 29_221.0..73_051.0;
/// No log in seconds has shorter steps.
const SHORTEST_STEP_S: f64 = 5e-4;

const UNITS: [Unit; 4] = [
    Unit::Second,
    Unit::Millisecond,
    Unit::Microsecond,
    Unit::Nanosecond,
];

fn inferred_unit(first: f64, numbers: &[f64]) -> (Unit, Option<String>, bool) {
    for unit in UNITS {
        if is_epoch(first * unit.factor()) {
            let because = format!("{first} is an epoch of our days in {unit}");
            return (unit, Some(because), false);
        }
    }
    let mut steps: Vec<f64> = numbers
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > 0.0)
        .collect();
    if steps.is_empty() {
        return (Unit::Second, Some("one sample".into()), false);
    }
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    if SPREADSHEET_DAYS.contains(&first) && median < SHORTEST_STEP_S {
        let because = format!("{first} is a day of a spreadsheet's calendar");
        return (Unit::Day, Some(because), false);
    }
    // Loggers that count in whole ms, us or ns sample between 200 Hz and once in 5 s.
    let whole = numbers.iter().all(|time| time.fract() == 0.0);
    let unit = UNITS
        .into_iter()
        .skip(1)
        .find(|unit| whole && (5e-3..=5.0).contains(&(median * unit.factor())) && median > 5.0)
        .unwrap_or(Unit::Second);
    let because = format!("median step {}", (median * 1e6).round() / 1e6);
    (unit, Some(because), unit != Unit::Second)
}

/// An instant with its offset from UTC; one without is taken as UTC.
pub(crate) fn instant(text: &str) -> Option<Timestamp> {
    if text.len() < 10 {
        return None;
    }
    if text.contains('年') {
        let date = text.replace(['年', '月'], "/").replace('日', " ");
        return instant(&with_colons(&date));
    }
    if let Some((before, is_afternoon)) = half_day(text) {
        let (date, time) = before.split_once(' ')?;
        let seconds = in_half_day(time_of_day(time.trim())?, is_afternoon)?;
        let midnight = instant(&format!("{date} 00:00:00"))?;
        return Some(midnight + SignedDuration::from_secs_f64(seconds));
    }
    if let Some(year_first) = year_first(text) {
        return instant(&year_first);
    }
    if !text.contains('-') {
        return None;
    }
    text.parse().ok().or_else(|| {
        let civil: DateTime = text.parse().ok()?;
        Some(civil.to_zoned(TimeZone::UTC).ok()?.timestamp())
    })
}

/// `14時07分09秒` as `14:07:09`.
fn with_colons(text: &str) -> String {
    text.replace(['時', '分'], ":").replace('秒', "")
}

/// The text before AM or PM, and whether it is PM.
fn half_day(text: &str) -> Option<(&str, bool)> {
    let at = text.len().checked_sub(2)?;
    let (before, half) = text.split_at_checked(at)?;
    let is_afternoon = half.eq_ignore_ascii_case("pm");
    (is_afternoon || half.eq_ignore_ascii_case("am")).then(|| (before.trim_end(), is_afternoon))
}

/// Seconds since midnight of seconds since 12 o'clock: 12:30 AM is half past midnight.
fn in_half_day(seconds: f64, is_afternoon: bool) -> Option<f64> {
    const HALF_S: f64 = 43_200.0;
    let is_sound = (3600.0..HALF_S + 3600.0).contains(&seconds);
    is_sound.then(|| seconds % HALF_S + if is_afternoon { HALF_S } else { 0.0 })
}

/// Seconds of `14:07:09.05` or `2:07:09.05 PM` since midnight, and of `07:09.05` since the hour; with a decimal comma, too. Two numbers
/// without decimals may be hours and minutes, and are no time.
pub(crate) fn time_of_day(text: &str) -> Option<f64> {
    if text.contains('時') {
        return time_of_day(&with_colons(text));
    }
    if let Some((before, is_afternoon)) = half_day(text) {
        return in_half_day(time_of_day(before)?, is_afternoon);
    }
    if let Some((minutes, seconds)) = text.split_once(':')
        && !seconds.contains(':')
        && seconds.contains(['.', ','])
    {
        return time_of_day(&format!("00:{minutes:0>2}:{seconds}"));
    }
    let mut parts = text.split(':');
    let [hours, minutes, seconds] = [parts.next()?, parts.next()?, parts.next()?];
    let two_digits = |part: &str| part.len() == 2 && is_number(part);
    let whole = seconds.split(['.', ',']).next()?;
    if parts.next().is_some()
        || !(is_number(hours) && hours.len() <= 2 && two_digits(minutes) && two_digits(whole))
    {
        return None;
    }
    let seconds: f64 = seconds.replace(',', ".").parse().ok()?;
    let minutes: f64 = minutes.parse().ok()?;
    let hours: f64 = hours.parse().ok()?;
    let is_of_a_day = hours < 24.0 && minutes < 60.0 && seconds < 61.0;
    is_of_a_day.then_some(3600.0 * hours + 60.0 * minutes + seconds)
}

/// `20.11.2026 12:00:00.05`, `20/11/2026 12:00` or `20-11-2026 12:00` with the year first, as the standard has it; `2026/11/20 12:00`
/// with hyphens. Slashes with the month first, as `11/20/2026`, are read where no other reading is possible.
fn year_first(text: &str) -> Option<String> {
    let (date, time) = text.split_at_checked(text.find([' ', 'T']).unwrap_or(text.len()))?;
    let mut parts = date.split(['.', '/', '-']);
    let [first, second, third] = [parts.next()?, parts.next()?, parts.next()?];
    if parts.next().is_some() || [first, second, third].iter().any(|part| !is_number(part)) {
        return None;
    }
    let (year, month, day) = match (first.len(), third.len()) {
        (4, 1 | 2) if !date.contains('-') => (first, second, third),
        (1 | 2, 4) if second.parse::<u8>().ok()? > 12 => (third, first, second),
        (1 | 2, 4) => (third, second, first),
        _ => return None,
    };
    let time = match time.trim_start_matches([' ', 'T']) {
        "" => "00:00",
        time => time,
    };
    Some(format!(
        "{year}-{month:0>2}-{day:0>2}T{}",
        time.replace(',', ".")
    ))
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_time_of_day_is_seconds_since_midnight() {
        for (text, seconds) in [
            ("14:07:09", Some(50_829.0)),
            ("14:07:09.5", Some(50_829.5)),
            ("2:07:09.5 PM", Some(50_829.5)),
            ("12:00:01 am", Some(1.0)),
            ("12:00:01 PM", Some(43_201.0)),
            ("14:07:09 PM", None),
            ("14時07分09.5秒", Some(50_829.5)),
            ("07:09.5", Some(429.5)),
            ("7:09,5", Some(429.5)),
            ("07:09", None),
            ("4:07:09,5", Some(14_829.5)),
            ("24:00:00", None),
            ("14:07", None),
            ("14:7:09", None),
            ("1:2:3:4", None),
            ("14:07:xx", None),
        ] {
            assert_eq!(time_of_day(text), seconds, "{text}");
        }
    }

    #[test]
    fn exact_dates_with_the_day_first_are_read() {
        let expected = instant("2026-11-20T12:00:00.05Z").unwrap();
        for text in [
            "20.11.2026 12:00:00.05",
            "20.11.2026 12:00:00,05",
            "20/11/2026 12:00:00.05",
            "20-11-2026 12:00:00.05",
            "2026/11/20 12:00:00.05",
            "11/20/2026 12:00:00.05",
            "2026-11-20 12:00:00.05",
        ] {
            assert_eq!(instant(text), Some(expected), "{text}");
        }
        let fifth = instant("2026-04-05T00:00:00Z");
        assert_eq!(instant("05.04.2026"), fifth);
        for text in [
            "20.11.26 12:00",
            "1.2.3",
            "not a date",
            "31.31.2026 12:00",
            "192.168.20.2026",
        ] {
            assert_eq!(instant(text), None, "{text}");
        }
    }
}

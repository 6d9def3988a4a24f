//! Dates and times of day as text.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};

/// What stands behind a time in UTC.
const ZONES: [&str; 3] = [" UTC", " GMT", " Z"];

/// An instant with its offset from UTC; one without is taken as UTC.
pub(crate) fn instant(text: &str) -> Option<Timestamp> {
    if text.len() < 10 {
        return None;
    }
    if let Some(utc) = ZONES.iter().find_map(|zone| text.strip_suffix(zone)) {
        return instant(utc);
    }
    if text.contains('年') {
        let date = text.replace(['年', '月'], "/").replace('日', " ");
        return instant(&with_colons(&date));
    }
    if let Some((before, is_afternoon)) = half_day(text) {
        let (date, time) = before.rsplit_once(' ')?;
        let seconds = in_half_day(time_of_day(time.trim())?, is_afternoon)?;
        let midnight = instant(&format!("{date} 00:00:00"))?;
        return Some(midnight + SignedDuration::from_secs_f64(seconds));
    }
    if let Some(numeric) = with_a_month(text) {
        return instant(&numeric);
    }
    if let Some(with_a_point) = with_a_point(text) {
        return instant(&with_a_point);
    }
    if let Some(year_first) = year_first(text) {
        return instant(&year_first);
    }
    // `20261120_120000.05`
    if let (Some(date), Some(b'_' | b'-' | b' ')) = (text.get(..8), text.as_bytes().get(8))
        && is_number(date)
    {
        return instant(&format!("{date}T{}", &text[9..]));
    }
    // `20261120120000` and, with milliseconds, `20261120120000050` of voyage recorders.
    if matches!(text.len(), 14 | 17) && is_number(text) {
        let (date, time) = text.split_at(8);
        return instant(&format!("{date}T{}.{:0<3}", &time[..6], &time[6..]));
    }
    let is_basic = text.as_bytes()[..8].iter().all(u8::is_ascii_digit) && text.contains('T');
    if !text.contains('-') && !is_basic {
        return None;
    }
    text.parse().ok().or_else(|| {
        let civil: DateTime = text.parse().ok()?;
        Some(civil.to_zoned(TimeZone::UTC).ok()?.timestamp())
    })
}

/// The first letters of the months in English, German, French and Spanish, where they differ.
const MONTHS: [&[&str]; 12] = [
    &["jan", "ene"],
    &["feb", "fév", "fev"],
    &["mar", "mär", "mrz"],
    &["apr", "avr", "abr"],
    &["may", "mai"],
    &["jun", "juin"],
    &["jul", "juil"],
    &["aug", "aoû", "ago"],
    &["sep"],
    &["oct", "okt"],
    &["nov"],
    &["dec", "dez", "déc", "dic"],
];

/// `20 Nov 2026 12:00:00`, `20-Nov-2026 12:00:00`, `Nov 20, 2026 12:00:00` or `Fri Nov 20 12:00:00 2026` with the year first.
fn with_a_month(text: &str) -> Option<String> {
    let lower = text.to_lowercase();
    let is_between = |c: char| c.is_whitespace() || matches!(c, '-' | '/' | ',' | '.' | 't');
    // Only a date that has a name of a month is taken apart.
    lower.find(|c: char| c.is_alphabetic())?;
    let mut month = None;
    let (mut day, mut year, mut time, mut half) = (None, None, None, "");
    let date_end = lower.find(':').map_or(lower.len(), |colon| {
        let before = lower.as_bytes()[..colon].iter().rev();
        colon - before.take_while(|byte| byte.is_ascii_digit()).count()
    });
    let rest = lower[date_end..].trim();
    let mut rest = rest.split_whitespace();
    if let Some(first) = rest.next() {
        let hours = first.split(':').next().map_or(0, str::len);
        time = Some(format!("{:0>2}{}", &first[..hours], &first[hours..]).replace(',', "."));
    }
    let mut take = |part: &str| {
        let digits = part.trim_end_matches("st").trim_end_matches("th");
        if let Ok(number) = digits.parse::<u32>() {
            match digits.len() {
                4 => year = Some(number),
                1 | 2 if day.is_none() => day = Some(number),
                1 | 2 => year = Some(2000 + number),
                _ => {}
            }
        } else if month.is_none() && part.chars().count() >= 3 {
            // `juin` before `jui`, of which there is none.
            let begins = |names: &&[&str]| names.iter().any(|name| part.starts_with(name));
            month = MONTHS.iter().position(begins);
        }
    };
    lower[..date_end].split(is_between).for_each(&mut take);
    for part in rest {
        match part {
            "am" | "pm" => half = if part == "am" { " am" } else { " pm" },
            part => take(part),
        }
    }
    let time = time.unwrap_or_else(|| "00:00:00".into());
    let month = month? + 1;
    Some(format!("{:04}-{month:02}-{:02} {time}{half}", year?, day?))
}

/// `14:07:09:050`, with milliseconds behind the third colon, as `14:07:09.050`.
fn with_a_point(text: &str) -> Option<String> {
    let (before, milliseconds) = text.rsplit_once(':')?;
    let is_sound = milliseconds.len() == 3
        && is_number(milliseconds)
        && before.ends_with(|c: char| c.is_ascii_digit())
        && before.matches(':').count() == 2
        && !before.contains(['.', ',']);
    is_sound.then(|| format!("{before}.{milliseconds}"))
}

/// `14時07分09秒` as `14:07:09`.
fn with_colons(text: &str) -> String {
    text.replace(['時', '分'], ":").replace('秒', "")
}

/// The text before AM or PM, and whether it is PM.
fn half_day(text: &str) -> Option<(&str, bool)> {
    // `p.m.` and `p. m.` of other countries.
    let dots = |c: char| matches!(c, '.' | ' ' | '\u{a0}' | '\u{202f}');
    let plain = text.trim_end_matches(dots);
    let before = plain.strip_suffix(['m', 'M'])?.trim_end_matches(dots);
    let at = before.len().checked_sub(1)?;
    let (before, half) = before.split_at_checked(at)?;
    let half = format!("{half}m");
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
    if let Some(utc) = ZONES.iter().find_map(|zone| text.strip_suffix(zone)) {
        return time_of_day(utc);
    }
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
    if let Some(with_a_point) = with_a_point(text) {
        return time_of_day(&with_a_point);
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
    // Two digits of a year are one beside a time of day.
    let is_short =
        first.len() <= 2 && third.len() == 2 && time.contains(':') && !date.contains('-');
    let third = if is_short { format!("20{third}") } else { third.to_owned() };
    let third = third.as_str();
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
    Some(format!("{year}-{month:0>2}-{day:0>2}T{}", time.replace(',', ".")))
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
            ("14:07:09:500", Some(50_829.5)),
            ("14:07:09:500:1", None),
            ("14:07:09.5:500", None),
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
            "2026-11-20 12:00:00:050",
            "20/11/26 12:00:00.05",
            "20.11.26 12:00:00,05",
            "11/20/26 12:00:00.05 PM",
            "20261120_120000.05",
            "20261120-120000.05",
            "2026-11-20 12:00:00.05 UTC",
            "20.11.2026 12:00:00.05 GMT",
        ] {
            assert_eq!(instant(text), Some(expected), "{text}");
        }
        let fifth = instant("2026-04-05T00:00:00Z");
        assert_eq!(instant("05.04.2026"), fifth);
        for text in ["20-11-26 12:00", "1.2.3", "not a date", "31.31.2026 12:00", "192.168.20.2026"]
        {
            assert_eq!(instant(text), None, "{text}");
        }
    }
}

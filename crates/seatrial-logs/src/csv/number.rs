//! Numbers as spreadsheets and instruments write them.

/// Units behind a number, as they stand in a cell and as a name of a column states them.
const UNITS: [(&str, &str); 18] = [
    ("°/s", "deg/s"),
    ("º/s", "deg/s"),
    ("deg/s", "deg/s"),
    ("rad/s", "rad/s"),
    ("m/s", "m/s"),
    ("km/h", "km/h"),
    ("knots", "kn"),
    ("kts", "kn"),
    ("kn", "kn"),
    ("kt", "kn"),
    ("%", "percent"),
    ("rad", "rad"),
    ("°", "°"),
    ("º", "°"),
    ("deg", "°"),
    ("度", "°"),
    ("ノット", "kn"),
    ("sec", "s"),
];
/// What older instruments write where they have no value.
const NO_VALUES: [f64; 3] = [-999.0, -9999.0, -99_999.0];
/// Signs behind minutes and seconds of an angle.
const MINUTES: [char; 3] = ['\'', '’', '′'];
const SECONDS: [char; 3] = ['"', '”', '″'];

/// What stands behind an angle: starboard, port, true and magnetic.
const LETTERS: [(&str, f64); 13] = [
    ("R", 1.0),
    ("RIGHT", 1.0),
    ("L", -1.0),
    ("LEFT", -1.0),
    ("S", 1.0),
    ("STB", 1.0),
    ("STBD", 1.0),
    ("P", -1.0),
    ("PORT", -1.0),
    ("BB", -1.0),
    ("T", 1.0),
    ("M", 1.0),
    ("MAG", 1.0),
];

/// The number of a cell: a point or a comma before the decimals, thousands in groups, a minus of typography, a unit
/// behind it, or minutes and seconds behind that. `None` where it is none.
pub(crate) fn number(text: &str, decimal_comma: bool) -> Option<f64> {
    match decimal_comma {
        false => text.parse().ok(),
        true if is_grouped(text, '.') => None,
        true => text.replace(',', ".").parse().ok(),
    }
    .or_else(|| written_for_readers(text, decimal_comma))
    .or_else(|| degrees_and_minutes(text))
    .or_else(|| with_a_letter(text, decimal_comma))
    .or_else(|| of_full_width(text, decimal_comma))
}

/// Digits of full width, as Japanese programs write them.
fn of_full_width(text: &str, decimal_comma: bool) -> Option<f64> {
    let is_wide = |c: char| ('！'..='～').contains(&c);
    if !text.contains(is_wide) {
        return None;
    }
    let narrow = |c: char| match is_wide(c) {
        true => char::from_u32(c as u32 - ('！' as u32 - '!' as u32)).unwrap_or(c),
        false => c,
    };
    number(&text.chars().map(narrow).collect::<String>(), decimal_comma)
}

/// `12.5 S`, `S 12.5` and `12.5 P` of a rudder to starboard and port, `41.5 T` of a true heading.
fn with_a_letter(text: &str, decimal_comma: bool) -> Option<f64> {
    let is_letter = |c: char| c.is_ascii_alphabetic();
    let (number_text, letters) = match text.find(is_letter)? {
        0 => {
            let (letters, number) = text.split_at(text.find(|c| !is_letter(c))?);
            // `S1` and `m1` are names.
            let is_number = number.starts_with(' ') || number.contains(['.', ',']);
            (is_number.then(|| number.trim_start())?, letters)
        }
        at => text.split_at(at),
    };
    let (_, sign) = LETTERS.iter().find(|(word, _)| word.eq_ignore_ascii_case(letters))?;
    // Minutes before S are those of a latitude as well.
    let is_of_minutes = letters.eq_ignore_ascii_case("S") && number_text.contains(MINUTES);
    let number = number(number_text.trim_end(), decimal_comma).filter(|_| !is_of_minutes)?;
    (number >= 0.0 || *sign > 0.0).then_some(sign * number)
}

/// Degrees of `12°30.5'`, `-0°15'` or `12° 30' 15"`.
fn degrees_and_minutes(text: &str) -> Option<f64> {
    let (degrees, rest) = text.split_once(['°', 'º'])?;
    // South is no letter of these: it may be starboard.
    let is_west = rest.ends_with('W');
    let rest = rest.trim_end_matches(['N', 'E', 'W']);
    let is_negative = is_west || degrees.starts_with(['-', '−']);
    let degrees: f64 = degrees.trim_start_matches(['-', '−', '+']).parse().ok()?;
    // A backslash before a quotation mark is how some programs write it.
    let rest = rest.replace('\\', "").replace(',', ".");
    let (minutes, rest) = rest.split_once(MINUTES)?;
    let sixtieths = |text: &str| text.trim().parse().ok().filter(|n| (0.0..=60.0).contains(n));
    let seconds = match rest.trim().trim_end_matches(SECONDS).trim_end_matches(MINUTES) {
        "" => 0.0,
        seconds => sixtieths(seconds)?,
    };
    let angle = degrees + sixtieths(minutes)? / 60.0 + seconds / 3600.0;
    Some(if is_negative { -angle } else { angle })
}

/// Is it what older instruments write for no value?
pub(super) fn is_no_value(number: f64) -> bool {
    NO_VALUES.contains(&number)
}

/// The unit behind a number, as a name of a column states it.
pub(super) fn unit_behind(text: &str) -> Option<&'static str> {
    if degrees_and_minutes(text).is_some() {
        return Some("°");
    }
    let is_letter = |(word, _): &&(&str, f64)| {
        let before = text.len().checked_sub(word.len());
        let end = before.and_then(|at| text.get(at..));
        end.is_some_and(|end| end.eq_ignore_ascii_case(word))
    };
    // `12.5° S` of a rudder to starboard.
    let of_side = LETTERS
        .iter()
        .filter(is_letter)
        .find_map(|(word, _)| split_unit(text[..text.len() - word.len()].trim_end()));
    let (digits, unit) = split_unit(text).or(of_side)?;
    digits.ends_with(|c: char| c.is_ascii_digit()).then_some(unit)
}

/// Is it a whole number whose thousands are in groups of three behind this sign?
pub(super) fn is_grouped(text: &str, sign: char) -> bool {
    let digits = text.trim_start_matches(['-', '+', '−']);
    digits.contains(sign) && !digits.starts_with('0') && ungrouped(digits, sign).is_some()
}

/// The number and the unit behind it.
fn split_unit(text: &str) -> Option<(&str, &'static str)> {
    let mut units = UNITS.iter();
    units.find_map(|(sign, unit)| Some((text.strip_suffix(sign)?.trim_end(), *unit)))
}

fn written_for_readers(text: &str, decimal_comma: bool) -> Option<f64> {
    let digits = split_unit(text).map_or(text, |(digits, _)| digits);
    let text = digits.replace('−', "-");
    let (decimals, groups) = match decimal_comma {
        true => (',', ['.', ' ', '\u{a0}', '\u{202f}', '\'', '’']),
        false => ('.', [',', ' ', '\u{a0}', '\u{202f}', '\'', '’']),
    };
    let (whole, rest) = text.split_once(decimals).unwrap_or((&text, ""));
    let whole = match groups.into_iter().find(|sign| whole.contains(*sign)) {
        Some(sign) => {
            let digits = whole.trim_start_matches(['-', '+']);
            let signs = &whole[..whole.len() - digits.len()];
            format!("{signs}{}", ungrouped(digits, sign)?)
        }
        None => whole.to_owned(),
    };
    format!("{whole}.{rest}").parse().ok()
}

/// The digits of groups of three; the first may be shorter.
fn ungrouped(digits: &str, sign: char) -> Option<String> {
    let groups: Vec<&str> = digits.split(sign).collect();
    let are_digits = |group: &&str| group.bytes().all(|byte| byte.is_ascii_digit());
    let is_sound = (1..=3).contains(&groups[0].len())
        && groups[1..].iter().all(|group| group.len() == 3)
        && groups.iter().all(are_digits);
    is_sound.then(|| groups.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_numbers_are_read_as_people_write_them() {
        for (text, decimal_comma, expected) in [
            ("12.5", false, Some(12.5)),
            ("12,5", true, Some(12.5)),
            ("1.234,56", true, Some(1234.56)),
            ("1,234.56", false, Some(1234.56)),
            ("1 234,56", true, Some(1234.56)),
            ("-1'234.5", false, Some(-1234.5)),
            ("76.591", true, Some(76_591.0)),
            ("76.591", false, Some(76.591)),
            ("0.591", true, Some(0.591)),
            ("−3.5", false, Some(-3.5)),
            ("12°", false, Some(12.0)),
            ("-12,25 deg", true, Some(-12.25)),
            ("5,2 kn", true, Some(5.2)),
            ("45%", false, Some(45.0)),
            ("0.1 sec", false, Some(0.1)),
            ("0.40度", false, Some(0.4)),
            ("-1.5 °/s", false, Some(-1.5)),
            ("2.6 knobs", false, None),
            ("12°30'", false, Some(12.5)),
            ("-0° 15’", false, Some(-0.25)),
            ("12° 30' 36\"", false, Some(12.51)),
            ("12°30,6′", true, Some(12.51)),
            ("12°30.6\\'", false, Some(12.51)),
            ("12°75'", false, None),
            ("12°30.0'N", false, Some(12.5)),
            ("12° 30.0' W", false, Some(-12.5)),
            ("12°30.0'S", false, None),
            ("12.5 S", false, Some(12.5)),
            ("12,5 P", true, Some(-12.5)),
            ("12.5° port", false, Some(-12.5)),
            ("41.5T", false, Some(41.5)),
            ("-12.5 P", false, None),
            ("S12.5", false, Some(12.5)),
            ("S1", false, None),
            ("m1", false, None),
            ("PORT 12,5", true, Some(-12.5)),
            ("P-12.5", false, None),
            ("X12.5", false, None),
            ("338° 60.0'", false, Some(339.0)),
            ("330°15\\'27''", false, Some(330.2575)),
            ("1,23,4.5", false, None),
            ("12 34", false, None),
            ("port", false, None),
            ("", false, None),
            ("°", false, None),
        ] {
            let found = number(text, decimal_comma);
            assert_eq!(found, expected, "{text}");
        }
    }
}

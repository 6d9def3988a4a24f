//! Frames in lines of text.
//!
//! | recorder | line |
//! |---|---|
//! | canboat | `2026-06-08T01:51:24.127,2,127250,15,255,8,ff,c0,...` |
//! | Yacht Devices | `00:29:58.000 R 09F1120F FF C0 ...` |
//! | iKonvert | `!PDGY,127250,2,15,255,481.000,/8Ae/3//f/0=` |
//! | candump | `(1614817798.000000) can0 09F1120F#FFC0...` or `(...) can0 09F1120F [8] FF C0 ...` |
//! | PCAN | `1) 1059.9 Rx 09F1120F 8 FF C0 ...` |
//! | Vector (.asc) | `0.001000 1 9F1120Fx Rx d 8 FF C0 ...` |
//! | SavvyCAN | `1000,09F1120F,true,Rx,0,8,FF,C0,...` |
//! | python-can | `1614817798.0,0x9f1120f,1,0,0,8,AP/A...`, or `Timestamp: 1614817798.0 ID: 09f1120f X Rx DL: 8 ff c0 ...` |
//! | Busmaster | `00:29:58:0000 Rx 1 0x09F1120F x 8 FF C0 ...` |
//! | Garmin | `0,486942,127250,Vessel Heading,Garmin,15,255,2,1,8,0xFFC0...` |
//! | SeaSmart | `$PCDIN,01F112,000C72EA,0F,FFC0...*5A` |
//! | Actisense | `A000057.055 0FFF2 1F112 FFC0...` |
//! | OpenCPN's voyage recorder | `1714564800000,N2000,127250,15,"93 13 02 12 F1 01 FF 0F ..."`, an Actisense message |
//! | ShipModul | `1714564800.100 $MXPGN,01F112,280F,FDFF7F...*5A`, the last byte first |

use super::{Frame, MOST_BYTES};
use crate::clock::{instant, stamp_s, time_of_day};
use crate::nmea0183;

/// Cells of a line that are looked at.
const MOST_CELLS: usize = 32;
/// Lines that are looked at, of which half are frames.
const LINES: usize = 20;

/// How the first lines write frames.
pub(super) fn container(start: &[u8]) -> Option<fn(&str) -> Option<Frame>> {
    let is_cut = start.len() >= super::START;
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with(['#', ';']))
        .take(LINES)
        .collect();
    let whole = lines.len() - usize::from(is_cut && lines.len() > 1 && lines.len() < LINES);
    let all: [fn(&str) -> Option<Frame>; 15] = [
        canboat,
        yacht_devices,
        ikonvert,
        candump,
        pcan,
        vector,
        savvy,
        python_can,
        printed,
        busmaster,
        garmin,
        sea_smart,
        actisense,
        open_cpn,
        miniplex,
    ];
    let count = |read: &fn(&str) -> Option<Frame>| {
        lines[..whole].iter().filter(|line| read(line).is_some()).count()
    };
    all.into_iter().find(|read| 2 * count(read) >= whole && count(read) > 0)
}

/// Are the first lines frames as candump writes them without times?
pub(super) fn are_untimed(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let is_frame = |line: &str| {
        let mut cells = line.split_whitespace().filter(|cell| !cell.starts_with("can"));
        let first = cells.next().unwrap_or_default();
        let hex = first.trim_matches(['<', '>']).trim_start_matches("0x");
        let length = cells.next().unwrap_or_default();
        let is_length = length.starts_with('[') && length.ends_with(']');
        identifier(hex).is_some() && is_length && cells.all(|cell| cell.len() == 2)
    };
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).take(LINES).collect();
    let frames = lines.iter().filter(|line| is_frame(line)).count();
    frames > 0 && 2 * frames >= lines.len()
}

/// A number of hexadecimal digits.
fn base16(digits: &str) -> Option<u32> {
    u32::from_str_radix(digits, 16).ok()
}

/// The bytes of hexadecimal digits.
fn hexadecimal(digits: &str) -> Option<Vec<u8>> {
    let is_sound = digits.len().is_multiple_of(2)
        && digits.len() <= 2 * MOST_BYTES
        && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_sound.then_some(())?;
    (0..digits.len() / 2)
        .map(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).ok())
        .collect()
}

/// A byte of two digits a cell.
fn bytes<'a>(cells: impl Iterator<Item = &'a str>) -> Option<Vec<u8>> {
    cells
        .map(|cell| {
            let digits = Some(cell.trim()).filter(|digits| digits.len() == 2)?;
            u8::from_str_radix(digits, 16).ok()
        })
        .take(MOST_BYTES + 1)
        .collect()
}

/// An identifier of 29 bits.
fn identifier(text: &str) -> Option<u32> {
    let text = text.trim_start_matches("0x");
    let is_long = text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    let number = base16(text).filter(|_| is_long)?;
    // Some programs set the flag of a long identifier.
    Some(number & 0x1fff_ffff)
}

/// `2026-06-08T01:51:24.127`, with or without `Z`, or `2026-06-08-01:51:24.127`.
pub(super) fn date_s(text: &str) -> Option<f64> {
    let text = text.trim();
    let old_style = text.is_ascii() && text.as_bytes().get(10) == Some(&b'-');
    let time = match old_style {
        true => instant(&format!("{}T{}", &text[..10], &text[11..])),
        false => instant(text),
    };
    Some(time?.as_nanosecond() as f64 / 1e9)
}

fn canboat(line: &str) -> Option<Frame> {
    let mut cells = line.split(',');
    let time = cells.next()?;
    let time_s = date_s(time).or_else(|| time_of_day(time.trim()))?;
    let _priority: u8 = cells.next()?.trim().parse().ok()?;
    let number = cells.next()?.trim().parse().ok()?;
    let source = cells.next()?.trim().parse().ok()?;
    let _destination: u8 = cells.next()?.trim().parse().ok()?;
    let length: usize = cells.next()?.trim().parse().ok()?;
    let data = bytes(cells)?;
    (data.len() >= length).then_some(Frame {
        time_s,
        number,
        source,
        is_of_bus: data.len() <= 8,
        data,
    })
}

fn yacht_devices(line: &str) -> Option<Frame> {
    // Actisense writes commas, and the date behind the time.
    let is_blank = |letter: char| letter == ',' || letter.is_whitespace();
    let mut cells = line.split(is_blank).filter(|cell| !cell.is_empty());
    let time = cells.next()?;
    let mut way = cells.next()?;
    if time_of_day(time).is_some() && way.contains('-') {
        way = cells.next()?;
    }
    let time_s = match time_of_day(way) {
        // A date before the time.
        Some(_) => {
            let time_s = date_s(&format!("{time}T{way}"));
            way = cells.next()?;
            time_s
        }
        None => time_of_day(time).or_else(|| stamp_s(time)),
    }?;
    let identifier = identifier(cells.next()?)?;
    let data = bytes(cells)?;
    let is_frame = matches!(way, "R" | "T") && (1..=8).contains(&data.len());
    is_frame.then(|| Frame::of_bus(time_s, identifier, data))
}

fn ikonvert(line: &str) -> Option<Frame> {
    // Signal K writes its own time and the name of the connection before it.
    let (_, cells) = line.split_once("!PDGY,")?;
    let mut cells = cells.split(',');
    let number = cells.next()?.parse().ok()?;
    let _priority: u8 = cells.next()?.parse().ok()?;
    let source = cells.next()?.parse().ok()?;
    let _destination: u8 = cells.next()?.parse().ok()?;
    let time_s = finite(cells.next()?)?;
    let data = base64(cells.next()?)?;
    Some(Frame::of_message(time_s, number, source, data))
}

/// The bytes of base 64.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=');
    if digits.len() > 2 * MOST_BYTES {
        return None;
    }
    let (mut bits, mut count, mut bytes) = (0_u32, 0, Vec::new());
    for digit in digits.bytes() {
        let value = match digit {
            b'A'..=b'Z' => digit - b'A',
            b'a'..=b'z' => digit - b'a' + 26,
            b'0'..=b'9' => digit - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}

fn candump(line: &str) -> Option<Frame> {
    let (time, rest) = line.strip_prefix('(')?.split_once(')')?;
    let time_s = date_s(time).or_else(|| stamp_s(time.trim()))?;
    let mut cells = rest.split_whitespace();
    let _bus = cells.next()?;
    // `RX - -` of `candump -x`.
    let cell = cells.find(|cell| !matches!(*cell, "RX" | "TX" | "-" | "B" | "E"))?;
    if let Some((id, digits)) = cell.split_once('#') {
        let data = hexadecimal(digits).filter(|data| data.len() <= 8)?;
        return Some(Frame::of_bus(time_s, identifier(id)?, data));
    }
    let identifier = identifier(cell)?;
    let length = cells.find(|cell| cell.starts_with('['))?;
    let length: usize = length.trim_matches(['[', ']']).parse().ok()?;
    let data = bytes(cells.take(length.min(8)))?;
    (data.len() == length).then(|| Frame::of_bus(time_s, identifier, data))
}

/// The cells of a line between blanks.
fn cells(line: &str) -> Vec<&str> {
    line.split_whitespace().take(MOST_CELLS).collect()
}

fn pcan(line: &str) -> Option<Frame> {
    let cells = cells(line);
    let _place: u64 = cells.first()?.trim_end_matches(')').parse().ok()?;
    adapter(finite(cells.get(1)?)? / 1e3, cells.get(2..)?)
}

fn python_can(line: &str) -> Option<Frame> {
    let cells: Vec<&str> = line.split(',').take(MOST_CELLS).collect();
    let [time, id, "1", "0", _, length, data] = cells[..] else {
        return None;
    };
    // Without zeros before it.
    let id = format!("{:0>8}", id.strip_prefix("0x")?);
    let data = base64(data).filter(|data| length.parse() == Ok(data.len()))?;
    Some(Frame::of_bus(finite(time)?, identifier(&id)?, data))
}

/// A message as python-can prints it.
fn printed(line: &str) -> Option<Frame> {
    let cells = cells(line);
    let behind = |label: &str| {
        let at = cells.iter().position(|cell| *cell == label)?;
        cells.get(at + 1..)
    };
    let time_s = finite(behind("Timestamp:")?.first()?)?;
    let identifier = identifier(behind("ID:")?.first()?)?;
    let (length, data) = behind("DL:").or_else(|| behind("DLC:"))?.split_first()?;
    let length: usize = length.parse().ok().filter(|length| *length <= 8)?;
    let data = bytes(data.get(..length)?.iter().copied())?;
    Some(Frame::of_bus(time_s, identifier, data))
}

fn busmaster(line: &str) -> Option<Frame> {
    let cells = cells(line);
    let (of_day, fraction) = cells.first()?.rsplit_once(':')?;
    let time_s = time_of_day(&format!("{of_day}.{fraction}"))?;
    adapter(time_s, cells.get(1..)?)
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

fn vector(line: &str) -> Option<Frame> {
    let cells = cells(line);
    // An identifier of 29 bits ends with x, and has no zeros before it.
    let at = cells.iter().position(|cell| cell.ends_with('x'))?;
    let long = format!("{:0>8}", cells[at].trim_end_matches('x'));
    // Remarks on the length and the bits on the wire may stand behind the bytes.
    let remarks = cells.iter().position(|cell| *cell == "Length");
    let behind = cells.get(at + 1..remarks.unwrap_or(cells.len()))?;
    adapter(finite(cells.first()?)?, &[&[long.as_str()], behind].concat())
}

fn savvy(line: &str) -> Option<Frame> {
    let cells: Vec<&str> = line.trim_end_matches(',').split(',').take(MOST_CELLS).collect();
    // Is the identifier one of 29 bits?
    cells.get(2).filter(|flag| ["true", "false", "1", "0"].contains(*flag))?;
    adapter(finite(cells.first()?)? / 1e6, cells.get(1..)?)
}

/// A frame as CAN adapters write it behind its time: an identifier, a direction or not, a length, and as many bytes.
fn adapter(time_s: f64, cells: &[&str]) -> Option<Frame> {
    let at = cells.iter().position(|cell| identifier(cell).is_some())?;
    let lengths = at + 1..cells.len().min(at + 6);
    let data = lengths.into_iter().find_map(|at| {
        let length: usize = cells[at].parse().ok().filter(|length| (1..=8).contains(length))?;
        let rest = cells.get(at + 1..)?;
        (rest.len() == length).then(|| bytes(rest.iter().copied()))?
    })?;
    Some(Frame::of_bus(time_s, identifier(cells[at])?, data))
}

fn garmin(line: &str) -> Option<Frame> {
    let cells: Vec<&str> = line.split(',').map(str::trim).take(16).collect();
    let digits = cells.last()?.strip_prefix("0x")?;
    let number = cells.get(2)?.parse().ok()?;
    let time_s = match cells[1].parse::<f64>() {
        Ok(milliseconds) if milliseconds.is_finite() => milliseconds / 1e3,
        _ => underscored_s(cells[1])?,
    };
    // Source, destination, priority, single frame, size and data come last.
    let source = cells.get(cells.len().checked_sub(6)?)?.parse().ok()?;
    Some(Frame::of_message(time_s, number, source, hexadecimal(digits)?))
}

/// `month_day_year_hours_minutes_seconds_milliseconds`.
fn underscored_s(text: &str) -> Option<f64> {
    let numbers: Option<Vec<f64>> = text.split('_').map(|part| part.parse().ok()).collect();
    let [month, day, year, hours, minutes, seconds, milliseconds] = numbers?[..] else {
        return None;
    };
    let of_day_s = 3600.0 * hours + 60.0 * minutes + seconds + milliseconds / 1e3;
    crate::clock::unix_s(year, month, day, of_day_s)
}

fn sea_smart(line: &str) -> Option<Frame> {
    let (_, cells) = nmea0183::sentence(line)?;
    let [name, number, time, source, data] = cells[..] else {
        return None;
    };
    (name == "PCDIN").then_some(())?;
    let time_s = f64::from(base16(time)?) / 1e3;
    let (number, source) = (base16(number)?, u8::try_from(base16(source)?).ok()?);
    Some(Frame::of_message(time_s, number, source, hexadecimal(data)?))
}

fn actisense(line: &str) -> Option<Frame> {
    let mut cells = line.strip_prefix('A')?.split_whitespace();
    let time = cells.next()?;
    let (hours, rest) = time.split_at_checked(2)?;
    let (minutes, seconds) = rest.split_at_checked(2)?;
    let time_s = time_of_day(&format!("{hours}:{minutes}:{seconds}"))?;
    let addresses = cells.next().filter(|cell| cell.len() == 5)?;
    let number = base16(cells.next()?)?;
    let source = base16(addresses.get(..2)?)? as u8;
    Some(Frame::of_message(time_s, number, source, hexadecimal(cells.next()?)?))
}

fn open_cpn(line: &str) -> Option<Frame> {
    let time_s = nmea0183::time_before(line.split(',').next()?)?;
    let digits = line.rsplit(',').next()?.trim().trim_matches('"');
    let message = bytes(digits.split_whitespace())?;
    let frame = super::binary::long_message(&message)?;
    Some(Frame { time_s, ..frame })
}

fn miniplex(line: &str) -> Option<Frame> {
    let (before, cells) = nmea0183::sentence(line)?;
    let ["MXPGN", number, attributes, data] = cells[..] else {
        return None;
    };
    let mut data = hexadecimal(data).filter(|data| data.len() <= 8)?;
    data.reverse();
    Some(Frame {
        time_s: nmea0183::time_before(before)?,
        number: base16(number)?,
        source: u16::try_from(base16(attributes)?).ok()? as u8,
        data,
        is_of_bus: true,
    })
}

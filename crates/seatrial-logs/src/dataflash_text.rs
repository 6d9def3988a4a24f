//! Text copies of DataFlash logs (`.log`), as Mission Planner writes them, made into the binary log that they are a copy of.
//!
//! ```text
//! FMT, 1, 31, ATT, Qcc, TimeUS,Roll,Yaw
//! ATT, 9000000, 0.10, 45.30
//! ```

use std::collections::BTreeMap;

use crate::bytes::{Bytes, check_made};
use crate::dataflash::width;
use crate::error::Fault;
use crate::input::Input;

/// What stands before every message, and the type of those that describe the others.
const MARK: [u8; 2] = [0xa3, 0x95];
const FORMAT: u8 = 128;

/// Does such a copy begin so?
pub(crate) fn is_start(start: &[u8]) -> bool {
    start.starts_with(b"FMT,")
}

/// Type and codes of the messages of a name.
type Layouts = BTreeMap<String, (u8, Vec<u8>)>;

/// The log. Lines that are no messages are in it as they stand, which its reader passes over and counts.
pub(crate) fn binary(file: Input) -> Result<Input, Fault> {
    let mut lines = Bytes::new(file)?;
    let mut layouts = Layouts::new();
    let mut log = Vec::new();
    while let Some(line) = lines.line()? {
        let line = String::from_utf8_lossy(line).into_owned();
        let is_cut = lines.is_line_cut();
        let made = match line.strip_prefix("FMT,") {
            Some(described) => description(described, &mut layouts),
            None => message(&line, &layouts),
        };
        match made {
            Some(bytes) if !is_cut => log.extend(bytes),
            // Whole or not, its last number may be.
            Some(bytes) => log.extend(&bytes[..bytes.len().saturating_sub(1)]),
            None if is_cut => log.extend(&MARK[..1]),
            None => log.extend(line.bytes()),
        }
        check_made(log.len(), "text copy of a DataFlash log", "give the .bin")?;
    }
    Input::made_of(log, lines.file()).map_err(Fault::read)
}

fn padded(text: &str, width: usize) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(width, 0);
    bytes
}

/// Type, length, name, codes and labels, the first of a type.
fn description(line: &str, layouts: &mut Layouts) -> Option<Vec<u8>> {
    let mut cells = line.splitn(5, ',').map(str::trim);
    let number: u8 = cells.next()?.parse().ok()?;
    let _length: u8 = cells.next()?.parse().ok()?;
    let name = cells.next().filter(|name| (1..=4).contains(&name.len()))?;
    let codes = cells.next().filter(|codes| codes.len() <= 16)?;
    let labels: String = cells.next()?.split_whitespace().collect();
    (labels.len() <= 64).then_some(())?;
    // Text of other messages is not read.
    let is_text = ["PARM", "MSG", "FMTU"].contains(&name);
    let codes: Vec<u8> = codes
        .bytes()
        .map(|code| match code {
            b'N' | b'Z' | b'a' if !is_text => b'n',
            code => code,
        })
        .collect();
    let widths: Option<Vec<usize>> = codes.iter().map(|code| width(*code)).collect();
    let length = MARK.len() + 1 + widths?.iter().sum::<usize>();
    let head = [MARK[0], MARK[1], FORMAT, number, u8::try_from(length).ok()?];
    let texts =
        [padded(name, 4), padded(&String::from_utf8_lossy(&codes), 16), padded(&labels, 64)];
    // A second description of a type would change messages that were already made.
    if layouts.values().any(|(known, _)| *known == number) {
        return Some(Vec::new());
    }
    layouts.insert(name.into(), (number, codes));
    Some([&head[..], &texts.concat()].concat())
}

fn message(line: &str, layouts: &Layouts) -> Option<Vec<u8>> {
    let (name, values) = line.split_once(',')?;
    let (number, codes) = layouts.get(name.trim())?;
    // The last cell may be a text with commas.
    let cells: Vec<&str> = values.splitn(codes.len(), ',').map(str::trim).collect();
    (cells.len() == codes.len()).then_some(())?;
    let mut bytes = vec![MARK[0], MARK[1], *number];
    for (code, cell) in codes.iter().zip(cells) {
        field(*code, cell, &mut bytes)?;
    }
    Some(bytes)
}

/// The bytes of a field.
fn field(code: u8, cell: &str, bytes: &mut Vec<u8>) -> Option<()> {
    let width = width(code)?;
    let whole = |times: f64| {
        let number: f64 = cell.parse().ok()?;
        Some((number * times).round() as i64)
    };
    let number = match code {
        b'n' | b'N' | b'Z' | b'a' => {
            bytes.extend(padded(cell, width).into_iter().take(width));
            return Some(());
        }
        b'f' => i64::from(cell.parse::<f32>().ok()?.to_bits()),
        b'd' => cell.parse::<f64>().ok()?.to_bits() as i64,
        b'g' => 0,
        // The name of a mode.
        b'M' => whole(1.0).unwrap_or(0),
        b'c' | b'C' | b'e' | b'E' => whole(100.0)?,
        // Degrees, or their 1e-7.
        b'L' if cell.contains('.') => whole(1e7)?,
        _ => whole(1.0)?,
    };
    bytes.extend(&number.to_le_bytes()[..width]);
    Some(())
}

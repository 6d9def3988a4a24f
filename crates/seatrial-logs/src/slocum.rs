//! Slocum glider logs (`.dbd` and its kin).
//!
//! A text header; a cycle of known values that shows the order of bytes; then, cycle by cycle, two bits for
//! every sensor (nothing, the value before, a new value) and the new values. The list of sensors stands
//! behind the header or, usually, in a cache file beside the log. Every sensor is a kind of its own.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use crate::Quantity::*;
use crate::Unit::*;
use crate::bytes::{Bytes, text_of};
use crate::error::Fault;
use crate::input::{FileMap, Input};
use crate::message_table::{Kind, Message, Messages};
use crate::number::Primitive;
use crate::table::{Known, KnownField};

const MOST_HEADER_LINES: usize = 100;
const MOST_SENSORS: usize = 10_000;
/// Tags of the known values, of a cycle, and of the end.
const KNOWN_VALUES: u8 = b's';
const CYCLE: u8 = b'd';
const END: u8 = b'X';
/// Tag, then `a`, 0x1234, 123.456 and 123456789.12345 in 1, 2, 4 and 8 bytes.
const KNOWN_LENGTH: usize = 16;
/// The glider's clock and, where that is not logged, the science computer's.
const CLOCKS: [&str; 2] = ["m_present_time", "sci_m_present_time"];

/// Sensors that feed a quantity, the preferred one first.
const CHANNELS: [KnownField; 10] = [
    (Heading, "m_heading", "", Some(Radian)),
    (Rudder, "m_fin", "", Some(Radian)),
    (Rudder, "c_fin", "", Some(Radian)),
    (Speed, "m_speed", "", Some(MetrePerSecond)),
    (Depth, "m_depth", "", Some(Metre)),
    (Altitude, "m_altitude", "", Some(Metre)),
    (Roll, "m_roll", "", Some(Radian)),
    (Pitch, "m_pitch", "", Some(Radian)),
    (North, "m_y_lmc", "", Some(Metre)),
    (East, "m_x_lmc", "", Some(Metre)),
];

/// A glider's log.
pub(crate) struct Glider {
    bytes: Bytes,
    sensors: Vec<Sensor>,
    kinds: Vec<Kind>,
    state_bytes: usize,
    is_big_endian: bool,
    clock: Option<usize>,
    /// What is left to give of the cycle that was read.
    cycle: VecDeque<(usize, f64)>,
    values: Vec<f64>,
    time_s: f64,
    has_end: bool,
}

/// A sensor that is logged; its kind has the same index.
struct Sensor {
    name: String,
    kind: Primitive,
}

/// The header as far as it matters.
#[derive(Default)]
struct Header {
    state_bytes: usize,
    list: String,
    is_factored: bool,
}

impl Glider {
    /// Reads header and list of sensors; `path` says where the cache file may be.
    pub fn open(file: Input, path: &Path, held: &FileMap) -> Result<Self, Fault> {
        let mut bytes = Bytes::new(file)?;
        let header = Header::read(&mut bytes)?;
        let sensors = match header.is_factored {
            true => sensors(&mut Bytes::new(cache_file(path, held, &header.list)?)?, false)?,
            false => sensors(&mut bytes, true)?,
        };
        if sensors.is_empty() || header.state_bytes * 4 < sensors.len() {
            return Err(damaged(format!(
                "{} bytes of state for {} sensors",
                header.state_bytes,
                sensors.len()
            )));
        }
        let known = bytes.peek(KNOWN_LENGTH)?;
        let is_big_endian = match known.get(..4) {
            Some([KNOWN_VALUES, b'a', 0x12, 0x34]) => true,
            Some([KNOWN_VALUES, b'a', 0x34, 0x12]) => false,
            _ => return Err(damaged("no known values behind the header".into())),
        };
        bytes.skip(KNOWN_LENGTH);
        Ok(Self {
            bytes,
            kinds: sensors
                .iter()
                .map(|sensor| Kind { name: sensor.name.clone(), fields: vec![String::new()] })
                .collect(),
            clock: CLOCKS
                .iter()
                .find_map(|clock| sensors.iter().position(|sensor| sensor.name == *clock)),
            values: vec![f64::NAN; sensors.len()],
            sensors,
            state_bytes: header.state_bytes,
            is_big_endian,
            cycle: VecDeque::new(),
            time_s: f64::NAN,
            has_end: false,
        })
    }

    /// Reads the next cycle. `false` at the end.
    fn next_cycle(&mut self, wanted: &[bool]) -> Result<bool, Fault> {
        let position = self.bytes.position();
        let head = 1 + self.state_bytes;
        let seen = self.bytes.peek(head)?;
        match seen.first() {
            None => {
                self.bytes.damage.cut_at = (!self.has_end).then_some(position);
                return Ok(false);
            }
            Some(&END) => {
                self.has_end = true;
                return Ok(false);
            }
            Some(&CYCLE) if seen.len() >= head => {}
            Some(&CYCLE) => {
                self.bytes.damage.cut_at = Some(position);
                return Ok(false);
            }
            // A cycle's length follows from its state alone: behind damage there is no way back.
            Some(_) => {
                self.bytes.damage.skipped(position, 1);
                return Ok(false);
            }
        }
        let states = seen[1..head].to_vec();
        let state = |sensor: usize| states[sensor / 4] >> (6 - 2 * (sensor % 4)) & 3;
        let length: usize = (0..self.sensors.len())
            .filter(|sensor| state(*sensor) == 2)
            .map(|sensor| self.sensors[sensor].kind.width())
            .sum();
        let Some(cycle) = self.bytes.peek(head + length)?.get(head..head + length) else {
            self.bytes.damage.cut_at = Some(position);
            return Ok(false);
        };
        let mut at = 0;
        for (index, sensor) in self.sensors.iter().enumerate() {
            match state(index) {
                2 => {
                    let value = sensor.number(&cycle[at..], self.is_big_endian);
                    at += sensor.kind.width();
                    self.values[index] = value;
                }
                1 => {}
                _ => continue,
            }
            if self.clock == Some(index) {
                self.time_s = self.values[index];
            }
            if wanted[index] {
                self.cycle.push_back((index, self.values[index]));
            }
        }
        self.bytes.skip(head + length);
        Ok(true)
    }
}

impl Sensor {
    fn number(&self, bytes: &[u8], is_big_endian: bool) -> f64 {
        let mut number = [f64::NAN];
        self.kind.read_all(bytes, !is_big_endian, &mut number);
        number[0]
    }
}

/// The table that `dbd2asc` makes of a log, with the units of its columns in brackets.
#[cfg(feature = "containers")]
pub(crate) fn of_ascii(file: &Input) -> Result<impl std::io::Read + Send + 'static, Fault> {
    let mut bytes = Bytes::new(file.another().map_err(Fault::read)?)?;
    let is_of_the_header = |line: &String| {
        let word = line.split_whitespace().next();
        word.is_some_and(|word| word.ends_with(':'))
    };
    let mut line = next_line(&mut bytes)?;
    while line.as_ref().is_some_and(is_of_the_header) {
        line = next_line(&mut bytes)?;
    }
    let units = next_line(&mut bytes)?.unwrap_or_default();
    let _widths = next_line(&mut bytes)?;
    let named = |(name, unit): (&str, &str)| match unit {
        "timestamp" => format!("{name}[s]"),
        unit if unit.parse::<crate::Unit>().is_ok() => format!("{name}[{unit}]"),
        _ => name.to_owned(),
    };
    let names = line.unwrap_or_default();
    let named = names.split_whitespace().zip(units.split_whitespace()).map(named);
    let names = named.collect::<Vec<_>>().join(" ") + "\n";
    Ok(crate::as_text::Rows::below(names, move || {
        // A number that was cut off looks whole.
        let line = next_line(&mut bytes)?.filter(|_| !bytes.is_line_cut());
        Ok(line.map_or_else(String::new, |line| line + "\n"))
    }))
}

#[cfg(feature = "containers")]
fn next_line(bytes: &mut Bytes) -> Result<Option<String>, Fault> {
    let line = bytes.line()?;
    Ok(line.map(|line| String::from_utf8_lossy(line).into_owned()))
}

impl Header {
    fn read(bytes: &mut Bytes) -> Result<Self, Fault> {
        let mut header = Self::default();
        let mut lines = MOST_HEADER_LINES;
        let mut read = 0;
        while read < lines {
            let line = text_of(bytes.line()?.ok_or_else(|| damaged("no header".into()))?);
            read += 1;
            let Some((key, value)) = line.split_once(':') else {
                return Err(damaged(format!("line {read} of the header has no colon")));
            };
            let value = value.trim();
            let count = || {
                value
                    .parse::<usize>()
                    .ok()
                    .filter(|count| *count <= MOST_SENSORS)
                    .ok_or_else(|| damaged(format!("{key} {value} is no plausible number")))
            };
            match key {
                "num_ascii_tags" => lines = count()?.min(MOST_HEADER_LINES),
                "state_bytes_per_cycle" => header.state_bytes = count()?,
                "sensor_list_crc" => header.list = value.to_lowercase(),
                "sensor_list_factored" => header.is_factored = value == "1",
                _ => {}
            }
        }
        Ok(header)
    }
}

/// The sensors that are logged, from lines `s: T index index width name unit`; those of sensors that are not, `s: F`, stand
/// between and behind them. In a log the list ends where other lines begin.
fn sensors(bytes: &mut Bytes, is_in_log: bool) -> Result<Vec<Sensor>, Fault> {
    let mut sensors = Vec::new();
    while sensors.len() < MOST_SENSORS && (!is_in_log || bytes.peek(2)?.starts_with(b"s:")) {
        let Some(line) = bytes.line()? else { break };
        let line = text_of(line);
        let cells: Vec<&str> = line.split_whitespace().collect();
        let (is_logged, width, name) = match cells[..] {
            ["s:", is_logged, _, _, width, name, _] => (is_logged == "T", width, name),
            [] => continue,
            _ => {
                return Err(damaged(format!("`{}` is no sensor", crate::error::clipped(&line))));
            }
        };
        let kind = match width.parse() {
            Ok(1) => Primitive::I8,
            Ok(2) => Primitive::I16,
            Ok(4) => Primitive::F32,
            Ok(8) => Primitive::F64,
            _ => return Err(damaged(format!("sensor {name} has no width"))),
        };
        if is_logged {
            sensors.push(Sensor { name: name.into(), kind });
        }
    }
    Ok(sensors)
}

/// The list of sensors, in the folder of the log or in `cac` or `cache` beside it.
fn cache_file(path: &Path, held: &FileMap, list: &str) -> Result<Input, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let is_a_name = list.len() <= 16 && list.bytes().all(|byte| byte.is_ascii_hexdigit());
    ["", "cac", "cache", "../cac", "../cache"]
        .iter()
        .filter(|_| is_a_name)
        .flat_map(|beside| {
            [format!("{list}.cac"), format!("{}.CAC", list.to_uppercase())]
                .map(|name| folder.join(beside).join(name))
        })
        .find_map(|candidate: PathBuf| held.open(&candidate).ok())
        .ok_or_else(|| Fault::MissingBeside {
            name: format!("{}.cac", crate::error::clipped(list)),
            what: "the list of sensors",
        })
}

fn damaged(what: String) -> Fault {
    Fault::Damaged { format: "Slocum", what }
}

impl Messages for Glider {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        known.add_fields(&self.kinds, CHANNELS);
        let found = format!("{} other sensors", self.sensors.len());
        known.expects(Heading, "m_heading", &found);
        known.expects(Rudder, "m_fin or c_fin", &found);
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            if let Some((kind, value)) = self.cycle.pop_front() {
                message.set(kind, self.time_s, [value]);
                return Ok(true);
            }
            if !self.next_cycle(wanted)? {
                return Ok(false);
            }
        }
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}

//! NMEA 2000 captures as canboat writes them: `time,priority,PGN,source,destination,length,byte,byte,...`
//!
//! The parameter groups that are read fit into one frame, so that captures of frames and of assembled
//! messages look the same. Every source, and every rudder of a source, is a kind of its own.

use std::collections::BTreeMap;

use jiff::Timestamp;

use crate::bytes::{Bytes, Damage};
use crate::clock::instant;
use crate::error::Fault;
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::number::number;
use crate::table::Known;
use crate::{Quantity, Unit};

/// A bus of 250 kbit/s carries no more frames in a second: each has at least 110 bits.
const MOST_PER_S: f64 = 2300.0;
/// This many messages in less time than the bus needs are no burst.
const MANY_MESSAGES: u64 = 1000;
const MOST_KINDS: usize = 1024;
const MOST_FIELDS: usize = 3;

/// A parameter group: fields with their first byte, type and resolution.
struct Group {
    number: u32,
    name: &'static str,
    /// Does the first byte number instruments of one source?
    has_instance: bool,
    fields: &'static [(&'static str, usize, Type, f64)],
}

#[derive(Clone, Copy)]
enum Type {
    U16,
    I16,
    U32,
    I32,
}

impl Type {
    /// The three largest values mean that there is none.
    fn number(self, bytes: &[u8], at: usize) -> Option<f64> {
        match self {
            Self::U16 => number::<u16>(bytes, at)
                .filter(|n| *n < u16::MAX - 2)
                .map(f64::from),
            Self::I16 => number::<i16>(bytes, at)
                .filter(|n| *n < i16::MAX - 2)
                .map(f64::from),
            Self::U32 => number::<u32>(bytes, at)
                .filter(|n| *n < u32::MAX - 2)
                .map(f64::from),
            Self::I32 => number::<i32>(bytes, at)
                .filter(|n| *n < i32::MAX - 2)
                .map(f64::from),
        }
    }
}

const GROUPS: [Group; 7] = [
    Group {
        number: 127_245,
        name: "rudder",
        has_instance: true,
        fields: &[
            ("angle_order_rad", 2, Type::I16, 1e-4),
            ("position_rad", 4, Type::I16, 1e-4),
        ],
    },
    Group {
        number: 127_250,
        name: "vessel_heading",
        has_instance: false,
        fields: &[("heading_rad", 1, Type::U16, 1e-4)],
    },
    Group {
        number: 127_251,
        name: "rate_of_turn",
        has_instance: false,
        fields: &[("rate_rad_s", 1, Type::I32, 1e-6 / 32.0)],
    },
    Group {
        number: 127_257,
        name: "attitude",
        has_instance: false,
        fields: &[
            ("yaw_rad", 1, Type::I16, 1e-4),
            ("pitch_rad", 3, Type::I16, 1e-4),
            ("roll_rad", 5, Type::I16, 1e-4),
        ],
    },
    Group {
        number: 128_259,
        name: "speed",
        has_instance: false,
        fields: &[
            ("speed_water_m_s", 1, Type::U16, 0.01),
            ("speed_ground_m_s", 3, Type::U16, 0.01),
        ],
    },
    Group {
        number: 128_267,
        name: "water_depth",
        has_instance: false,
        fields: &[("depth_m", 1, Type::U32, 0.01)],
    },
    Group {
        number: 129_026,
        name: "cog_sog",
        has_instance: false,
        fields: &[("sog_m_s", 4, Type::U16, 0.01)],
    },
];

/// Which fields feed a quantity, the preferred one first.
const CHANNELS: [(Quantity, &str, &str, Unit); 11] = [
    (
        Quantity::Heading,
        "vessel_heading",
        "heading_rad",
        Unit::Radian,
    ),
    (Quantity::Heading, "attitude", "yaw_rad", Unit::Radian),
    (Quantity::Rudder, "rudder", "position_rad", Unit::Radian),
    (Quantity::Rudder, "rudder", "angle_order_rad", Unit::Radian),
    (
        Quantity::YawRate,
        "rate_of_turn",
        "rate_rad_s",
        Unit::RadianPerSecond,
    ),
    (
        Quantity::Speed,
        "speed",
        "speed_water_m_s",
        Unit::MetrePerSecond,
    ),
    (Quantity::Speed, "cog_sog", "sog_m_s", Unit::MetrePerSecond),
    (
        Quantity::Speed,
        "speed",
        "speed_ground_m_s",
        Unit::MetrePerSecond,
    ),
    (Quantity::Altitude, "water_depth", "depth_m", Unit::Metre),
    (Quantity::Roll, "attitude", "roll_rad", Unit::Radian),
    (Quantity::Pitch, "attitude", "pitch_rad", Unit::Radian),
];

/// A capture.
pub(crate) struct Capture {
    bytes: Bytes,
    kinds: Vec<Kind>,
    /// Kind by group, source and instance.
    kind_of: BTreeMap<(usize, u8, u8), usize>,
    /// Values that are there, of every field of every kind.
    valid: Vec<[u64; MOST_FIELDS]>,
    lines: u64,
    damage: Damage,
}

/// What a line holds.
struct Line {
    time: Timestamp,
    /// Index in [`GROUPS`].
    group: Option<usize>,
    source: u8,
    data: [u8; 8],
}

impl Line {
    fn of(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let time = time(cells.next()?)?;
        let _priority: u8 = cells.next()?.trim().parse().ok()?;
        let group: u32 = cells.next()?.trim().parse().ok()?;
        let source = cells.next()?.trim().parse().ok()?;
        let _destination: u8 = cells.next()?.trim().parse().ok()?;
        let length: usize = cells.next()?.trim().parse().ok()?;
        let mut data = [0xff; 8];
        let mut found = 0;
        for cell in cells {
            let digits = Some(cell.trim()).filter(|digits| digits.len() == 2)?;
            let byte = u8::from_str_radix(digits, 16).ok()?;
            if let Some(place) = data.get_mut(found) {
                *place = byte;
            }
            found += 1;
        }
        if found < length {
            return None;
        }
        Some(Self {
            time,
            group: GROUPS.iter().position(|known| known.number == group),
            source,
            data,
        })
    }

    fn key(&self) -> Option<(usize, u8, u8)> {
        let group = self.group?;
        let instance = match GROUPS[group].has_instance {
            true => self.data[0],
            false => 0,
        };
        Some((group, self.source, instance))
    }

    fn values(&self, group: usize) -> impl Iterator<Item = f64> + '_ {
        GROUPS[group]
            .fields
            .iter()
            .map(|(_, at, kind, resolution)| {
                kind.number(&self.data, *at)
                    .map_or(f64::NAN, |number| number * resolution)
            })
    }
}

/// `2026-06-08T01:51:24.127`, with or without `Z`, or `2026-06-08-01:51:24.127`.
fn time(text: &str) -> Option<Timestamp> {
    let text = text.trim();
    let old_style = text.is_ascii() && text.as_bytes().get(10) == Some(&b'-');
    match old_style {
        true => instant(&format!("{}T{}", &text[..10], &text[11..])),
        false => instant(text),
    }
}

impl Capture {
    /// Reads the file once for its sources.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut capture = Self {
            bytes: Bytes::new(file)?,
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
            valid: Vec::new(),
            lines: 0,
            damage: Damage::default(),
        };
        let (mut first, mut last) = (Timestamp::MAX, Timestamp::MIN);
        while let Some(line) = capture.next_line()? {
            (first, last) = (first.min(line.time), last.max(line.time));
            capture.register(&line);
        }
        let span_s = (last.as_nanosecond() - first.as_nanosecond()) as f64 / 1e9;
        if capture.lines > MANY_MESSAGES && capture.lines as f64 > MOST_PER_S * span_s {
            return Err(Fault::TimeCollapsed {
                messages: capture.lines,
                span_s,
                most_per_s: MOST_PER_S,
            });
        }
        capture.bytes.go_to(0)?;
        capture.damage = Damage::default();
        Ok(capture)
    }

    fn next_line(&mut self) -> Result<Option<Line>, Fault> {
        loop {
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(None);
            };
            if line.is_empty() || line.starts_with(b"#") {
                continue;
            }
            match std::str::from_utf8(line).ok().and_then(Line::of) {
                Some(line) => {
                    self.lines += 1;
                    return Ok(Some(line));
                }
                None => {
                    let length = line.len();
                    self.damage.not_a_line(&self.bytes, position, length);
                }
            }
        }
    }

    fn register(&mut self, line: &Line) {
        let Some(key) = line.key() else { return };
        let (group, source, instance) = key;
        if !self.kind_of.contains_key(&key) {
            if self.kinds.len() == MOST_KINDS {
                return;
            }
            let known = &GROUPS[group];
            self.kind_of.insert(key, self.kinds.len());
            self.valid.push([0; MOST_FIELDS]);
            self.kinds.push(Kind {
                name: match known.has_instance {
                    true => format!("{}.{source}.{instance}", known.name),
                    false => format!("{}.{source}", known.name),
                },
                fields: known
                    .fields
                    .iter()
                    .map(|(name, ..)| (*name).into())
                    .collect(),
            });
        }
        let valid = &mut self.valid[self.kind_of[&key]];
        for (count, value) in valid.iter_mut().zip(line.values(group)) {
            *count += u64::from(value.is_finite());
        }
    }
}

impl Messages for Capture {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (quantity, group, field, unit) in CHANNELS {
            // Of several sources the one that says most.
            let best = self
                .kind_of
                .iter()
                .filter(|((of, ..), _)| GROUPS[*of].name == group)
                .filter_map(|((of, ..), kind)| {
                    let fields = GROUPS[*of].fields;
                    let index = fields.iter().position(|(name, ..)| *name == field)?;
                    Some((self.valid[*kind][index], *kind))
                })
                .max_by_key(|(count, kind)| (*count, std::cmp::Reverse(*kind)));
            if let Some((1.., kind)) = best {
                let column = format!("{}.{field}", self.kinds[kind].name);
                known.add(quantity, column, Some(unit), "");
            }
        }
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name.as_str()).collect();
        let found = names.join(", ");
        known.lacks(
            Quantity::Heading,
            format!("expected PGN 127250 or 127257 with a heading; found {found}"),
        );
        known.lacks(
            Quantity::Rudder,
            format!("expected PGN 127245 with a position or an order; found {found}"),
        );
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(line) = self.next_line()? {
            let Some((group, kind)) = line
                .key()
                .and_then(|key| Some((key.0, *self.kind_of.get(&key)?)))
                .filter(|(_, kind)| wanted[*kind])
            else {
                continue;
            };
            message.kind = kind;
            message.time_s = line.time.as_nanosecond() as f64 / 1e9;
            message.values.clear();
            message.values.extend(line.values(group));
            return Ok(true);
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&self) -> u64 {
        self.bytes.position()
    }

    fn warnings(&self) -> Vec<String> {
        self.damage.warnings()
    }
}

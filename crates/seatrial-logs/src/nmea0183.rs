//! NMEA 0183 text: `$HEHDT,123.4,T*1D`, with or without a time before each sentence.
//!
//! A sentence's time is what stands before it (seconds, ms since 1970, or date and time; the `c` of a tag block
//! counts), else that of the last RMC, ZDA, GGA or GLL sentence. Every sentence is a kind, from any talker.

use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use crate::bytes::{Bytes, Damage};
use crate::clock::instant;
use crate::error::Fault;
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::table::Known;
use crate::{Quantity, Unit};

const DAY_S: f64 = 86_400.0;

/// A number of a sentence.
struct Field {
    name: &'static str,
    /// Cells behind the sentence's name, from 1.
    cell: usize,
    /// Cell and letter without which the number does not count.
    flag: Option<(usize, &'static str)>,
}

const fn field(name: &'static str, cell: usize) -> Field {
    Field {
        name,
        cell,
        flag: None,
    }
}

const fn flagged(name: &'static str, cell: usize, at: usize, flag: &'static str) -> Field {
    Field {
        name,
        cell,
        flag: Some((at, flag)),
    }
}

/// Sentences that are read.
const SENTENCES: [(&str, &[Field]); 11] = [
    ("HDT", &[field("heading_deg", 1)]),
    ("THS", &[flagged("heading_deg", 1, 2, "A")]),
    ("HDG", &[field("heading_deg", 1)]),
    ("HDM", &[field("heading_deg", 1)]),
    ("ROT", &[flagged("rate_deg_min", 1, 2, "A")]),
    (
        "RSA",
        &[
            flagged("rudder_deg", 1, 2, "A"),
            flagged("port_deg", 3, 4, "A"),
        ],
    ),
    ("VHW", &[field("heading_deg", 1), field("speed_kn", 5)]),
    ("VTG", &[field("speed_kn", 5)]),
    ("RMC", &[field("speed_kn", 7)]),
    ("DPT", &[field("depth_m", 1)]),
    ("DBT", &[field("depth_m", 3)]),
];

const CHANNELS: [(Quantity, &str, &str, Unit); 11] = [
    (Quantity::Heading, "HDT", "heading_deg", Unit::Degree),
    (Quantity::Heading, "THS", "heading_deg", Unit::Degree),
    (Quantity::Heading, "HDG", "heading_deg", Unit::Degree),
    (Quantity::Heading, "HDM", "heading_deg", Unit::Degree),
    (Quantity::Heading, "VHW", "heading_deg", Unit::Degree),
    (Quantity::Rudder, "RSA", "rudder_deg", Unit::Degree),
    (
        Quantity::YawRate,
        "ROT",
        "rate_deg_min",
        Unit::DegreePerMinute,
    ),
    (Quantity::Speed, "VHW", "speed_kn", Unit::Knot),
    (Quantity::Speed, "VTG", "speed_kn", Unit::Knot),
    (Quantity::Speed, "RMC", "speed_kn", Unit::Knot),
    (Quantity::Altitude, "DPT", "depth_m", Unit::Metre),
];

/// A log of sentences.
pub(crate) struct Sentences {
    bytes: Bytes,
    /// Index in [`SENTENCES`] of every kind.
    sentences: Vec<usize>,
    kinds: Vec<Kind>,
    clock: Clock,
    untimed: u64,
    has_own_times: bool,
    damage: Damage,
    /// Sentences whose checksum is not that of their bytes.
    wrong_sums: u64,
}

/// The time of the sentences that have none of their own.
#[derive(Default)]
struct Clock {
    /// Seconds since 1970 of the day, 0 where no sentence said so.
    day_s: f64,
    /// Seconds since 1970, or since midnight.
    last_s: Option<f64>,
}

impl Clock {
    /// Takes the time of a sentence that has one.
    fn take(&mut self, name: &str, cells: &[&str]) {
        let cell = |index: usize| cells.get(index).copied().unwrap_or_default();
        let date = match name {
            "RMC" => {
                let text = cell(9);
                (text.len() == 6 && text.is_ascii()).then(|| {
                    (
                        cell(1),
                        format!("20{}", &text[4..]),
                        &text[2..4],
                        &text[..2],
                    )
                })
            }
            "ZDA" => Some((cell(1), cell(4).into(), cell(3), cell(2))),
            _ => None,
        };
        if let Some((_, year, month, day)) = &date {
            let midnight = format!("{year}-{month:0>2}-{day:0>2}T00:00:00").parse::<DateTime>();
            if let Some(zoned) = midnight
                .ok()
                .and_then(|day| day.to_zoned(TimeZone::UTC).ok())
            {
                self.day_s = zoned.timestamp().as_second() as f64;
            }
        }
        let time = match name {
            "RMC" | "ZDA" | "GGA" => cell(1),
            "GLL" => cell(5),
            _ => return,
        };
        let Some(second_s) = second_of_day(time) else {
            return;
        };
        let mut time_s = self.day_s + second_s;
        // Behind midnight the date comes with the next RMC or ZDA.
        if date.is_none() && self.last_s.is_some_and(|last| last - time_s > DAY_S / 2.0) {
            self.day_s += DAY_S;
            time_s += DAY_S;
        }
        self.last_s = Some(time_s);
    }
}

/// `hhmmss.ss`
fn second_of_day(text: &str) -> Option<f64> {
    if text.len() < 6 || !text.is_ascii() {
        return None;
    }
    let part = |from: usize| text[from..from + 2].parse::<u8>().ok().map(f64::from);
    let seconds: f64 = text[4..].parse().ok()?;
    let is_time = (0.0..61.0).contains(&seconds);
    is_time.then_some(3600.0 * part(0)? + 60.0 * part(2)? + seconds)
}

/// The time before a sentence, s.
fn time_before(text: &str) -> Option<f64> {
    // A tag block: `\s:rudder,c:1577836800*5A\`.
    if let Some(block) = text.trim().strip_prefix('\\') {
        let code = block
            .split([',', '*'])
            .find_map(|part| part.strip_prefix("c:"))?;
        return seconds(code);
    }
    let text = text.trim().trim_end_matches([',', ';', ':']).trim();
    let text = text.trim_matches(['[', ']', '(', ')', '"']);
    if let Some(time) = instant(text) {
        return Some(time.as_nanosecond() as f64 / 1e9);
    }
    seconds(text.split([' ', ',', ';', '\t']).next()?)
}

/// Seconds, or milliseconds since 1970.
fn seconds(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    let is_milliseconds = (1e11..1e14).contains(&number);
    let seconds = if is_milliseconds {
        number / 1e3
    } else {
        number
    };
    seconds.is_finite().then_some(seconds)
}

/// What stands before a sentence, and its cells. `None` of what is none or has a wrong checksum.
pub(crate) fn sentence(line: &str) -> Option<(&str, Vec<&str>)> {
    let at = line.find(['$', '!'])?;
    let (before, body) = (&line[..at], &line[at + 1..]);
    let body = match body.rsplit_once('*') {
        Some((body, sum)) => {
            let found = body.bytes().fold(0, |sum, byte| sum ^ byte);
            (u8::from_str_radix(sum.trim().get(..2)?, 16).ok()? == found).then_some(body)?
        }
        None => body,
    };
    let cells: Vec<&str> = body.split(',').map(str::trim).collect();
    let address = cells.first()?;
    let is_address = (3..=8).contains(&address.len())
        && address
            .bytes()
            .all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit());
    is_address.then_some((before, cells))
}

impl Sentences {
    /// Reads the file once for its sentences.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            sentences: Vec::new(),
            kinds: Vec::new(),
            clock: Clock::default(),
            untimed: 0,
            has_own_times: false,
            damage: Damage::default(),
            wrong_sums: 0,
        };
        let mut message = Message::default();
        while log.next_sentence(None, &mut message)? {}
        if log.kinds.is_empty() && log.untimed > 0 {
            return Err(Fault::NotLogged {
                quantity: Quantity::Time,
                found: format!(
                    "{} sentences without a time before them, and no RMC, ZDA, GGA or GLL sentence",
                    log.untimed
                ),
            });
        }
        log.bytes.go_to(0)?;
        log.clock = Clock::default();
        log.untimed = 0;
        log.damage = Damage::default();
        log.wrong_sums = 0;
        Ok(log)
    }

    /// The next sentence that is read and has a time, of a wanted kind.
    fn next_sentence(
        &mut self,
        wanted: Option<&[bool]>,
        message: &mut Message,
    ) -> Result<bool, Fault> {
        loop {
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(false);
            };
            let length = line.len();
            if line.is_empty() || line.starts_with(b"#") {
                continue;
            }
            let line = String::from_utf8_lossy(line).into_owned();
            // Of a sentence that was cut off only a checksum says that it is whole.
            let may_be_cut = self.bytes.is_line_cut() && !line.contains('*');
            let Some((before, cells)) = sentence(&line).filter(|_| !may_be_cut) else {
                let is_summed = line.contains(['$', '!']) && line.contains('*');
                self.wrong_sums += u64::from(is_summed && !self.bytes.is_line_cut());
                self.damage.not_a_line(&self.bytes, position, length);
                continue;
            };
            let address = cells[0];
            let name = &address[address.len() - 3..];
            self.clock.take(name, &cells);
            let Some(index) = SENTENCES.iter().position(|(known, _)| *known == name) else {
                continue;
            };
            let own_s = time_before(before);
            self.has_own_times |= own_s.is_some();
            let Some(time_s) = own_s.or(self.clock.last_s) else {
                self.untimed += 1;
                continue;
            };
            let kind = match self.sentences.iter().position(|known| *known == index) {
                Some(kind) => kind,
                None if wanted.is_some() => continue,
                None => {
                    self.sentences.push(index);
                    self.kinds.push(Kind {
                        name: name.into(),
                        fields: SENTENCES[index].1.iter().map(|f| f.name.into()).collect(),
                    });
                    self.kinds.len() - 1
                }
            };
            if wanted.is_some_and(|wanted| !wanted[kind]) {
                continue;
            }
            message.kind = kind;
            message.time_s = time_s;
            message.values.clear();
            message
                .values
                .extend(SENTENCES[index].1.iter().map(|field| {
                    let cell = |index: usize| cells.get(index).copied().unwrap_or_default();
                    let counts = field.flag.is_none_or(|(at, flag)| cell(at) == flag);
                    let value = cell(field.cell).parse().ok().filter(|_| counts);
                    value.unwrap_or(f64::NAN)
                }));
            return Ok(true);
        }
    }
}

impl Messages for Sentences {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (quantity, sentence, field, unit) in CHANNELS {
            if self.kinds.iter().any(|kind| kind.name == sentence) {
                known.add(quantity, format!("{sentence}.{field}"), Some(unit), "");
            }
        }
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name.as_str()).collect();
        let found = names.join(", ");
        known.lacks(
            Quantity::Heading,
            format!("expected HDT, THS, HDG, HDM or VHW sentences; found {found}"),
        );
        known.lacks(
            Quantity::Rudder,
            format!("expected RSA sentences; found {found}"),
        );
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        self.next_sentence(Some(wanted), message)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&self) -> u64 {
        self.bytes.position()
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.damage.warnings();
        if !self.has_own_times {
            warnings.push(
                "no sentence has a time before it: times are those of the last RMC, ZDA, GGA or GLL sentence; log with a time before each sentence for more".into(),
            );
        }
        if self.untimed > 0 {
            let untimed = self.untimed;
            warnings.push(format!("{untimed} sentences have no time and are left out"));
        }
        if self.is_damaged() {
            let wrong = self.wrong_sums;
            warnings.push(format!(
                "{wrong} sentences have a wrong checksum and are left out"
            ));
        }
        warnings
    }

    fn is_damaged(&self) -> bool {
        self.wrong_sums > 0
    }
}

//! NMEA 0183 text: `$HEHDT,123.4,T*1D`, with or without a time before each sentence.
//!
//! A sentence's time is what stands before it (seconds, ms since 1970, or date and time; the `c` of a tag block
//! counts); sentences without one are spread between the times of RMC, ZDA, GGA or GLL sentences. The sentences of each instrument are a kind.

mod sentences;
mod times;

use std::cmp::Reverse;
use std::collections::VecDeque;

use crate::bytes::Bytes;
use crate::clock::{instant, stamp_s, time_of_day};
use crate::error::Fault;
use crate::input::Input;
use crate::message_table::{FieldNumbers, Kind, Message, Messages, names};
use crate::table::{Known, KnownChannel};
use crate::{Quantity, Unit};
use sentences::{CHANNELS, SENTENCES};
use times::{Clock, Stamps};

/// Instruments that are told apart; more send as the last of them.
const MOST_INSTRUMENTS: usize = 64;
/// Sentences that are held until the next time comes.
const MOST_HELD: usize = 10_000;
/// Times further apart than so many intervals before are those of a gap.
const GAP: f64 = 3.0;

/// An instrument's sentences of one name.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Instrument {
    /// Index in [`SENTENCES`].
    sentence: usize,
    talker: String,
    /// What stands before its sentences beside the time: the port or the source of a tag block.
    source: String,
}

/// A log of sentences.
pub(crate) struct Sentences {
    bytes: Bytes,
    /// Of every kind.
    instruments: Vec<Instrument>,
    kinds: Vec<Kind>,
    /// Of every field of every kind.
    numbers: Vec<Vec<FieldNumbers>>,
    clock: Clock,
    /// Sentences since the clock's last time.
    held: Vec<(usize, Vec<f64>)>,
    /// The last interval between times, s.
    interval_s: Option<f64>,
    ready: VecDeque<(usize, f64, Vec<f64>)>,
    untimed: u64,
    stamps: Stamps,
    /// Sentences whose checksum is not that of their bytes.
    wrong_sums: u64,
}

/// The time before a sentence, s, wherever it stands among the other cells.
pub(crate) fn time_before(text: &str) -> Option<f64> {
    // A tag block: `\s:rudder,c:1577836800*5A\`.
    if let Some(block) = text.trim().strip_prefix('\\') {
        let code = block.split([',', '*']).find_map(|part| part.strip_prefix("c:"))?;
        return stamp_s(code);
    }
    let parts = || std::iter::once(text).chain(text.split([',', ';', '\t'])).map(trimmed);
    let dated = parts().find_map(|part| instant(part).or_else(|| instant(&with_t(part))));
    if let Some(time) = dated {
        return Some(time.as_nanosecond() as f64 / 1e9);
    }
    parts()
        .find_map(time_of_day)
        .or_else(|| stamp_s(trimmed(text.split([' ', ',', ';', '\t']).next()?)))
}

/// `2026-06-08-01:51:24.127` and `2026-06-08_01:51:24` with a T.
fn with_t(text: &str) -> String {
    match text.is_ascii() && text.len() > 11 {
        true => format!("{}T{}", &text[..10], &text[11..]),
        false => String::new(),
    }
}

fn trimmed(text: &str) -> &str {
    text.trim().trim_matches(['[', ']', '(', ')', '"', ',', ';', ':']).trim()
}

/// What stands before a sentence beside numbers and times.
fn source_before(text: &str) -> String {
    if let Some(block) = text.trim().strip_prefix('\\') {
        let source = block.split([',', '*']).find_map(|part| part.strip_prefix("s:"));
        return source.unwrap_or_default().into();
    }
    let is_name = |part: &&str| part.starts_with(|c: char| c.is_ascii_alphabetic());
    let parts = text.split([',', ';', '\t', ' ']).map(trimmed).filter(is_name);
    parts.collect::<Vec<_>>().join(" ")
}

/// What stands before a sentence, or else behind it, and its cells. `None` of what is none or has a wrong checksum.
pub(crate) fn sentence(line: &str) -> Option<(&str, Vec<&str>)> {
    let at = line.find(['$', '!'])?;
    let (before, body) = (&line[..at], &line[at + 1..]);
    let (body, behind) = match body.rsplit_once('*') {
        Some((body, sum)) => {
            let found = body.bytes().fold(0, |sum, byte| sum ^ byte);
            let (sum, behind) = sum.trim().split_at_checked(2)?;
            (u8::from_str_radix(sum, 16).ok()? == found).then_some((body, behind))?
        }
        None => (body, ""),
    };
    // Some write the time behind the sentence.
    let before = match before.trim().is_empty() {
        true => behind.trim_start_matches([',', ';', ' ', '\t']),
        false => before,
    };
    let cells: Vec<&str> = body.split(',').map(str::trim).collect();
    let address = cells.first()?;
    let is_address = (3..=8).contains(&address.len())
        && address.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit());
    is_address.then_some((before, cells))
}

impl Sentences {
    /// Reads the file once for its sentences.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            instruments: Vec::new(),
            kinds: Vec::new(),
            numbers: Vec::new(),
            clock: Clock::default(),
            held: Vec::new(),
            interval_s: None,
            ready: VecDeque::new(),
            untimed: 0,
            stamps: Stamps::default(),
            wrong_sums: 0,
        };
        let mut message = Message::default();
        while log.next_sentence(None, &mut message)? {
            let numbers = log.numbers[message.kind].iter_mut();
            for (numbers, value) in numbers.zip(&message.values) {
                numbers.take(*value);
            }
        }
        if log.kinds.is_empty() && log.untimed > 0 {
            return Err(Fault::NotLogged {
                quantity: Quantity::Time,
                found: format!(
                    "{} sentences without a time before them, and no RMC, ZDA, GGA or GLL sentence",
                    log.untimed
                ),
            });
        }
        log.stamps.are_shared = 2 * log.stamps.repeated > log.stamps.count;
        log.name_kinds();
        log.bytes.begin_again()?;
        log.clock = Clock::default();
        log.interval_s = None;
        log.untimed = 0;
        log.wrong_sums = 0;
        Ok(log)
    }

    /// Names instruments by their talker, or by what else tells them apart, where several send the same sentence.
    fn name_kinds(&mut self) {
        for (kind, of) in self.kinds.iter_mut().zip(&self.instruments) {
            let (name, _) = SENTENCES[of.sentence];
            let others = self
                .instruments
                .iter()
                .filter(|other| other.sentence == of.sentence && *other != of);
            let others: Vec<&Instrument> = others.collect();
            kind.name = if others.is_empty() {
                name.into()
            } else if others.iter().all(|other| other.talker != of.talker) {
                format!("{}.{name}", of.talker)
            } else {
                format!("{}.{}.{name}", of.source, of.talker)
            };
        }
    }

    /// The kind of an instrument's sentences; new ones only on the way through for them.
    fn kind_of(&mut self, instrument: Instrument, is_new: bool) -> Option<usize> {
        let known = self.instruments.iter().position(|known| *known == instrument);
        if known.is_some() || !is_new {
            return known;
        }
        if self.instruments.len() >= MOST_INSTRUMENTS {
            let same = |known: &Instrument| known.sentence == instrument.sentence;
            return self.instruments.iter().rposition(same);
        }
        let (_, fields) = SENTENCES[instrument.sentence];
        let kind = Kind {
            name: String::new(),
            fields: fields.iter().map(|field| field.name.into()).collect(),
        };
        self.numbers.push(FieldNumbers::of(&kind));
        self.kinds.push(kind);
        self.instruments.push(instrument);
        Some(self.kinds.len() - 1)
    }

    /// Spreads the sentences that are held between the last time and the next, each kind evenly.
    fn spread(&mut self, from_s: f64, to_s: Option<f64>) {
        let until_next = to_s.map(|to_s| to_s - from_s).filter(|s| *s > 0.0);
        let is_gap = |s: &f64| self.interval_s.is_some_and(|usual_s| *s > GAP * usual_s);
        let interval_s = until_next.filter(|s| !is_gap(s)).or(self.interval_s).unwrap_or(0.0);
        if let Some(until_next_s) = until_next.filter(|s| !is_gap(s)) {
            self.interval_s = Some(until_next_s);
        }
        let mut counts = vec![0_u32; self.kinds.len()];
        for (kind, _) in &self.held {
            counts[*kind] += 1;
        }
        let mut seen = vec![0_u32; self.kinds.len()];
        let mut timed: Vec<(usize, f64, Vec<f64>)> = self
            .held
            .drain(..)
            .map(|(kind, values)| {
                let share = f64::from(seen[kind]) / f64::from(counts[kind]);
                seen[kind] += 1;
                (kind, from_s + interval_s * share, values)
            })
            .collect();
        timed.sort_by(|one, two| one.1.total_cmp(&two.1));
        self.ready.extend(timed);
    }

    /// The next sentence that is read and has a time, of a wanted kind.
    fn next_sentence(
        &mut self,
        wanted: Option<&[bool]>,
        message: &mut Message,
    ) -> Result<bool, Fault> {
        loop {
            if let Some((kind, time_s, values)) = self.ready.pop_front() {
                message.set(kind, time_s, values);
                return Ok(true);
            }
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                let Some(last_s) = self.clock.last_s.filter(|_| !self.held.is_empty()) else {
                    return Ok(false);
                };
                self.spread(last_s, None);
                continue;
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
                self.bytes.not_a_line(position, length);
                continue;
            };
            self.take(before, &cells, wanted);
        }
    }

    /// Takes in a sentence: at its own time, or held until the next time comes.
    fn take(&mut self, before: &str, cells: &[&str], wanted: Option<&[bool]>) {
        let (talker, name) = cells[0].split_at(cells[0].len() - 3);
        let stamp_s = time_before(before);
        let last_s = self.clock.last_s;
        let (own_s, shared_s) = match self.stamps.are_shared {
            true => (None, stamp_s),
            false => (stamp_s, None),
        };
        match shared_s {
            Some(_) => self.clock.last_s = shared_s,
            None => self.clock.take(name, cells),
        }
        if let Some(from_s) = last_s.filter(|last| Some(*last) != self.clock.last_s) {
            self.spread(from_s, self.clock.last_s);
        }
        let Some(sentence) = SENTENCES.iter().position(|(known, _)| *known == name) else {
            return;
        };
        if own_s.is_none() && self.clock.last_s.is_none() {
            self.untimed += 1;
            return;
        }
        let instrument =
            Instrument { sentence, talker: talker.into(), source: source_before(before) };
        let kind = self.kind_of(instrument, wanted.is_none());
        let Some(kind) = kind.filter(|kind| wanted.is_none_or(|wanted| wanted[*kind])) else {
            return;
        };
        if let Some(own_s) = own_s {
            self.stamps.take(kind, own_s);
        }
        let values = SENTENCES[sentence].1.iter().map(|field| field.value(cells)).collect();
        match (own_s, self.clock.last_s) {
            (Some(own_s), _) => self.ready.push_back((kind, own_s, values)),
            (None, Some(last_s)) => {
                self.held.push((kind, values));
                if self.held.len() == MOST_HELD {
                    self.spread(last_s, None);
                }
            }
            (None, None) => {}
        }
    }

    /// The fields that feed a quantity and have had numbers, the preferred first: of several instruments the one with the most. What never
    /// changes says nothing, where another does.
    fn channels(&self) -> Vec<Channel> {
        let mut found = Vec::new();
        for (quantity, sentence, field, unit) in CHANNELS {
            let of_sentence = |kind: usize| {
                let (name, fields) = SENTENCES[self.instruments[kind].sentence];
                let at = fields.iter().position(|known| known.name == field)?;
                let numbers = self.numbers[kind][at];
                (name == sentence && numbers.count > 0).then_some((numbers.changes, numbers.count))
            };
            let mut kinds: Vec<((bool, u64), usize)> =
                (0..self.kinds.len()).filter_map(|kind| Some((of_sentence(kind)?, kind))).collect();
            kinds.sort_by_key(|(count, kind)| (Reverse(*count), *kind));
            let column = |kind: usize| format!("{}.{field}", self.kinds[kind].name);
            let columns: Vec<String> = kinds.iter().map(|(_, kind)| column(*kind)).collect();
            found.extend(kinds.iter().map(|((changes, _), kind)| Channel {
                quantity,
                unit,
                kind: *kind,
                column: column(*kind),
                changes: *changes,
                doubt: (columns.len() > 1).then(|| {
                    format!(
                        "{} instruments send {sentence}, as {}: `{}` is taken; say another with {} NAME",
                        columns.len(),
                        columns.join(", "),
                        column(*kind),
                        quantity.option()
                    )
                }),
            }));
        }
        found.sort_by_key(|channel| !channel.changes);
        found
    }

    /// Says which heading is taken of those that several instruments send in different sentences, and which rudder of two.
    fn tell_rivals(&self, channels: &mut [Channel]) {
        for quantity in [Quantity::Heading, Quantity::Rudder] {
            let mut channels = channels.iter_mut().filter(|of| of.quantity == quantity);
            let Some(taken) = channels.next().filter(|taken| taken.doubt.is_none()) else {
                continue;
            };
            let talker = |of: &Channel| &self.instruments[of.kind].talker;
            let is_rival = |other: &&mut Channel| {
                quantity == Quantity::Rudder || talker(other) != talker(taken)
            };
            let rivals = channels.filter(is_rival);
            let rivals: Vec<String> = rivals.map(|other| other.column.clone()).collect();
            if !rivals.is_empty() {
                taken.doubt = Some(format!(
                    "{quantity} is in `{}` and in {}: `{0}` is taken; say another with {} NAME",
                    taken.column,
                    rivals.join(", "),
                    quantity.option()
                ));
            }
        }
    }
}

/// A field of an instrument that feeds a quantity.
struct Channel {
    quantity: Quantity,
    unit: Unit,
    kind: usize,
    column: String,
    changes: bool,
    doubt: Option<String>,
}

impl Messages for Sentences {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        let mut channels = self.channels();
        self.tell_rivals(&mut channels);
        known.channels = channels
            .into_iter()
            .map(|of| KnownChannel {
                quantity: of.quantity,
                column: of.column,
                unit: Some(of.unit),
                because: None,
                doubt: of.doubt,
            })
            .collect();
        let found = match self.kinds.is_empty() {
            true => "no sentence whose check sum is right".to_owned(),
            false => names(&self.kinds),
        };
        let headings = "HDT, THS, PASHR, HDG, HDM or VHW sentences";
        known.expects(Quantity::Heading, headings, &found);
        let rudders = "RSA, HTD or HTC sentences, or XDR with RUDDER";
        known.expects(Quantity::Rudder, rudders, &found);
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        self.next_sentence(Some(wanted), message)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.stamps.count == 0 {
            warnings.push(
                "no sentence has a time before it: sentences are spread evenly between the times of RMC, ZDA, GGA or GLL sentences".into(),
            );
        }
        if self.stamps.are_shared {
            warnings.push(
                "most sentences share the time before them with others: they are spread evenly between these times".into(),
            );
        }
        if self.untimed > 0 {
            let untimed = self.untimed;
            warnings.push(format!("{untimed} sentences have no time and are left out"));
        }
        if self.is_damaged() {
            let wrong = self.wrong_sums;
            warnings.push(format!("{wrong} sentences have a wrong checksum and are left out"));
        }
        warnings
    }

    fn is_damaged(&self) -> bool {
        self.wrong_sums > 0
    }
}

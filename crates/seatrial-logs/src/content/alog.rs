//! MOOS logs (`.alog`): `12.345  NAV_HEADING  pNavigation  123.4`, time first, in seconds since the start.
//!
//! Every variable that is a number is a kind of its own.

use std::collections::BTreeMap;

use crate::bytes::Bytes;
use crate::error::Fault;
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::table::Known;
use crate::{Quantity, Unit};

const MOST_VARIABLES: usize = 10_000;

/// Variables that feed a quantity, the preferred one first; units are MOOS's.
const CHANNELS: [(Quantity, &str, Option<Unit>); 12] = [
    (Quantity::Heading, "NAV_HEADING", Some(Unit::Degree)),
    (Quantity::Heading, "NAV_HDG", Some(Unit::Degree)),
    (Quantity::Rudder, "NAV_RUDDER", None),
    (Quantity::Rudder, "RUDDER_ANGLE", None),
    (Quantity::Rudder, "RUDDER", None),
    (Quantity::Rudder, "DESIRED_RUDDER", None),
    (Quantity::Speed, "NAV_SPEED", Some(Unit::MetrePerSecond)),
    (Quantity::Depth, "NAV_DEPTH", Some(Unit::Metre)),
    (Quantity::Altitude, "NAV_ALTITUDE", Some(Unit::Metre)),
    (Quantity::Pitch, "NAV_PITCH", Some(Unit::Radian)),
    (Quantity::North, "NAV_Y", Some(Unit::Metre)),
    (Quantity::East, "NAV_X", Some(Unit::Metre)),
];

/// A MOOS log.
pub(crate) struct Alog {
    bytes: Bytes,
    kinds: Vec<Kind>,
    kind_of: BTreeMap<String, usize>,
}

/// Time, variable and value; the third cell is who wrote it.
fn entry(line: &str) -> Option<(f64, &str, &str)> {
    let mut cells = line.split_whitespace();
    let time_s = cells.next()?.parse().ok().filter(|t: &f64| t.is_finite())?;
    let name = cells.next()?;
    let _source = cells.next()?;
    Some((time_s, name, cells.next().unwrap_or_default()))
}

impl Alog {
    /// Reads the file once for its variables.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
        };
        let mut message = Message::default();
        while log.next_number(None, &mut message)? {}
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// The next number of a wanted variable.
    fn next_number(
        &mut self,
        wanted: Option<&[bool]>,
        message: &mut Message,
    ) -> Result<bool, Fault> {
        loop {
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(false);
            };
            if line.is_empty() || line.starts_with(b"%") {
                continue;
            }
            let length = line.len();
            let line = String::from_utf8_lossy(line).into_owned();
            // A number that was cut off looks whole.
            let found = entry(&line).filter(|_| !self.bytes.is_line_cut());
            let Some((time_s, name, value)) = found else {
                self.bytes.not_a_line(position, length);
                continue;
            };
            let Ok(value) = value.parse::<f64>() else {
                continue;
            };
            let kind = match self.kind_of.get(name) {
                Some(kind) => *kind,
                None if wanted.is_some() || self.kinds.len() == MOST_VARIABLES => continue,
                None => {
                    self.kind_of.insert(name.into(), self.kinds.len());
                    self.kinds.push(Kind {
                        name: name.into(),
                        fields: vec![String::new()],
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
            message.values.push(value);
            return Ok(true);
        }
    }
}

impl Messages for Alog {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (quantity, name, unit) in CHANNELS {
            if self.kind_of.contains_key(name) {
                known.add(quantity, name.into(), unit, "");
            }
        }
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name.as_str()).collect();
        let found = crate::error::clipped(&names.join(", "));
        known.lacks(
            Quantity::Heading,
            format!("expected NAV_HEADING; found {found}"),
        );
        known.lacks(
            Quantity::Rudder,
            format!("expected NAV_RUDDER, RUDDER or DESIRED_RUDDER; found {found}"),
        );
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        self.next_number(Some(wanted), message)
    }

    fn bytes(&self) -> &Bytes {
        &self.bytes
    }

    fn bytes_mut(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}

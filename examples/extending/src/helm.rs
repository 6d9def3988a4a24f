//! A log format of one's own: what the recorder of a made-up autopilot writes.
//!
//! ```text
//! HELMLOG 1
//! 12000 COMPASS 0471 -013
//! 12040 SERVO -35
//! ```
//!
//! Milliseconds since the start; the heading in tenths of a degree and the yaw rate in tenths of a degree a second; the servo in tenths
//! of a degree, positive to port.

use std::path::Path;

use seatrial_logs::formats::{Bytes, Formats, Kind, Known, LogFormat, Message, Messages};
use seatrial_logs::{Fault, Quantity, Unit};

/// The formats of this program: give them to whatever reads logs.
pub fn formats() -> Formats {
    Formats::default().with(Helm)
}

/// Recordings of the autopilot.
pub struct Helm;

impl LogFormat for Helm {
    fn name(&self) -> &'static str {
        "helm"
    }

    fn is_start(&self, start: &[u8], _path: &Path) -> bool {
        start.starts_with(b"HELMLOG ")
    }

    fn open(&self, bytes: Bytes) -> Result<Box<dyn Messages>, Fault> {
        Ok(Box::new(HelmLog::open(bytes)?))
    }
}

struct HelmLog {
    bytes: Bytes,
    kinds: [Kind; 2],
}

/// The places of the kinds among `kinds`.
const COMPASS: usize = 0;
const SERVO: usize = 1;

impl HelmLog {
    fn open(mut bytes: Bytes) -> Result<Self, Fault> {
        match bytes.line()? {
            Some(b"HELMLOG 1") => {}
            other => {
                return Err(Fault::Damaged {
                    format: "helm",
                    what: format!(
                        "expected HELMLOG 1, found {}",
                        String::from_utf8_lossy(other.unwrap_or_default())
                    ),
                });
            }
        }
        let kind = |name: &str, fields: &[&str]| Kind {
            name: name.into(),
            fields: fields.iter().map(|field| (*field).into()).collect(),
        };
        Ok(Self {
            bytes,
            kinds: [kind("compass", &["heading", "yaw_rate"]), kind("servo", &["angle"])],
        })
    }
}

/// What a line says: kind, time and values.
fn read(line: &str, message: &mut Message) -> Option<()> {
    let mut words = line.split(' ');
    let milliseconds: u32 = words.next()?.parse().ok()?;
    let kind = words.next()?;
    let tenths: Vec<f64> = words
        .map(|word| Some(f64::from(word.parse::<i16>().ok()?) / 10.0))
        .collect::<Option<_>>()?;
    let (kind, values) = match (kind, tenths.as_slice()) {
        ("COMPASS", [_, _]) => (COMPASS, tenths),
        // Elsewhere a rudder to starboard is positive.
        ("SERVO", [to_port]) => (SERVO, vec![-to_port]),
        _ => return None,
    };
    *message = Message { kind, time_s: f64::from(milliseconds) / 1000.0, values };
    Some(())
}

impl Messages for HelmLog {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (quantity, column, unit) in [
            (Quantity::Heading, "compass.heading", Unit::Degree),
            (Quantity::YawRate, "compass.yaw_rate", Unit::DegreePerSecond),
            (Quantity::Rudder, "servo.angle", Unit::Degree),
        ] {
            known.add(quantity, column.into(), Some(unit), "");
        }
        known
    }

    fn next(&mut self, _wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(false);
            };
            let length = line.len();
            let line = String::from_utf8_lossy(line).into_owned();
            // A number that was cut off looks whole.
            if !self.bytes.is_line_cut() && read(&line, message).is_some() {
                return Ok(true);
            }
            self.bytes.not_a_line(position, length);
        }
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}

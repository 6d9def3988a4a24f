//! How the messages of a topic are laid out.

use std::collections::BTreeMap;

use crate::number::{Primitive, number};
use seatrial_core::attitude::{EULER, euler_rad};

/// Formats within formats.
const DEEPEST: usize = 8;
/// Fields of one topic.
const MOST_FIELDS: usize = 1024;

/// Where the numbers of a topic stand in its messages.
pub(super) struct Layout {
    pub fields: Vec<(String, Primitive, usize)>,
    /// Bytes of the time stamp, us since boot.
    timestamp: usize,
    pub length: usize,
    /// Index of the first of four fields that are an attitude.
    quaternion: Option<usize>,
    /// Indices of the velocity north and east.
    velocity: Option<[usize; 2]>,
}

/// The kind of number of a type of C.
fn primitive(type_name: &str) -> Option<Primitive> {
    match type_name {
        "bool" => Some(Primitive::U8),
        "float" => Some(Primitive::F32),
        "double" => Some(Primitive::F64),
        _ => Primitive::named(type_name.strip_suffix("_t")?),
    }
}

/// `float[4] q` as type, count and name.
fn declaration(text: &str) -> Option<(&str, Option<usize>, &str)> {
    let (type_name, name) = text.trim().split_once(' ')?;
    match type_name.split_once('[') {
        Some((type_name, count)) => {
            let count = count.strip_suffix(']')?.parse().ok()?;
            (count <= MOST_FIELDS).then_some((type_name, Some(count), name))
        }
        None => Some((type_name, None, name)),
    }
}

impl Layout {
    pub fn of(topic: &str, formats: &BTreeMap<String, String>) -> Option<Self> {
        let mut layout =
            Self { fields: Vec::new(), timestamp: 0, length: 0, quaternion: None, velocity: None };
        layout.expand("", topic, formats, 0)?;
        let position = |name: &str| layout.fields.iter().position(|(field, ..)| field == name);
        let timestamp = position("timestamp")?;
        let (_, Primitive::U64, at) = layout.fields[timestamp] else {
            return None;
        };
        let quaternion = position("q[0]").filter(|_| position("q[3]").is_some());
        let velocity = position("vx").zip(position("vy"));
        layout.timestamp = at;
        layout.quaternion = quaternion;
        layout.velocity = velocity.map(|(north, east)| [north, east]);
        Some(layout)
    }

    /// Appends the fields of a format.
    fn expand(
        &mut self,
        prefix: &str,
        format: &str,
        formats: &BTreeMap<String, String>,
        depth: usize,
    ) -> Option<()> {
        let text = formats.get(format).filter(|_| depth < DEEPEST)?;
        for field in text.split(';').filter(|field| !field.trim().is_empty()) {
            let (type_name, count, name) = declaration(field)?;
            for index in 0..count.unwrap_or(1) {
                let name = match count {
                    Some(_) => format!("{prefix}{name}[{index}]"),
                    None => format!("{prefix}{name}"),
                };
                match primitive(type_name) {
                    Some(kind) => {
                        let is_number = !name.contains("_padding");
                        if is_number && self.fields.len() == MOST_FIELDS {
                            return None;
                        }
                        if is_number {
                            self.fields.push((name, kind, self.length));
                        }
                        self.length += kind.width();
                    }
                    None if type_name == "char" => self.length += 1,
                    None => self.expand(&format!("{name}."), type_name, formats, depth + 1)?,
                }
                if self.length > usize::from(u16::MAX) {
                    return None;
                }
            }
        }
        Some(())
    }

    pub fn names(&self) -> Vec<String> {
        let own = self.fields.iter().map(|(name, ..)| name.as_str());
        let angles = self.quaternion.iter().flat_map(|_| EULER);
        let speed = self.velocity.iter().map(|_| "ground_speed");
        own.chain(angles).chain(speed).map(String::from).collect()
    }

    pub fn time_s(&self, data: &[u8]) -> Option<f64> {
        number::<u64>(data, self.timestamp).map(|us| us as f64 / 1e6)
    }

    pub fn numbers(&self, data: &[u8], values: &mut Vec<f64>) {
        values.clear();
        values.extend(
            self.fields.iter().map(|(_, kind, at)| kind.number(data, *at).unwrap_or(f64::NAN)),
        );
        if let Some(&[w, x, y, z]) =
            self.quaternion.and_then(|first| values.get(first..)?.first_chunk())
        {
            values.extend(euler_rad([w, x, y, z]));
        }
        if let Some([north, east]) = self.velocity {
            let (north, east) = (values[north], values[east]);
            values.push((north * north + east * east).sqrt());
        }
    }
}

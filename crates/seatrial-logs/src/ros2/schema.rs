//! Message definitions of ROS and the numbers that messages hold by them, in CDR or as ROS 1 writes them.

use std::collections::BTreeMap;

use seatrial_core::Real;

use seatrial_core::attitude::euler_rad;

use crate::number::Primitive;

/// Types within types.
const DEEPEST: usize = 10;
/// Parts of one message type.
const MOST_NODES: usize = 4096;
/// Elements of an array, and of a sequence of numbers, that become fields.
const MOST_ELEMENTS: usize = 36;
/// Bytes before the message: byte order and version of CDR.
const ENCAPSULATION: usize = 4;

/// Definitions that bags leave out.
const BUILT_IN: [(&str, &str); 2] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
];

/// How messages are written.
#[derive(Clone, Copy, Default, PartialEq)]
pub(crate) enum Wire {
    /// ROS 2: in CDR, aligned, behind its head.
    #[default]
    Cdr,
    /// ROS 1: little endian, one number behind the other.
    #[cfg(feature = "containers")]
    Ros1,
}

/// The kind of number of a type of ROS.
fn primitive(type_name: &str) -> Option<Primitive> {
    match type_name {
        "bool" | "byte" | "char" => Some(Primitive::U8),
        name => Primitive::named(name),
    }
}

/// A part of a message; slots are indices of its fields.
enum Node {
    /// A count of numbers, one behind the other, and the slot of the first.
    Run(Primitive, usize, Option<usize>),
    Text,
    Parts(Vec<Node>),
    Array(Box<Node>, usize),
    /// A sequence of numbers and the slot of the first.
    Numbers(Primitive, Option<usize>),
    Sequence(Box<Node>),
}

impl Node {
    /// Is a number of this kind and slot one more of a run?
    fn goes_on_with(&self, of: Primitive, slot: Option<usize>) -> bool {
        match *self {
            Self::Run(kind, count, first) => {
                kind == of && count > 0 && first.map(|first| first + count) == slot
            }
            _ => false,
        }
    }

    fn lengthen(&mut self, more: usize) {
        if let Self::Run(_, count, _) = self {
            *count = count.saturating_add(more);
        }
    }
}

/// What is computed from a message's numbers.
enum Derived {
    /// From the slots of w, x, y, z.
    Attitude([usize; 4]),
    /// From the slot of the angular velocity about z.
    YawRate(usize),
}

/// A message type.
pub(crate) struct Schema {
    root: Node,
    fields: Vec<String>,
    derived: Vec<Derived>,
    /// Slots of the header's time.
    stamp: Option<[usize; 2]>,
    nodes: usize,
    wire: Wire,
}

type Definitions<'a> = BTreeMap<String, Vec<(&'a str, &'a str)>>;

/// How many elements a field has.
#[derive(Clone, Copy)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

impl Count {
    /// What stands between the brackets of a declaration.
    fn of(between_brackets: &str) -> Self {
        between_brackets.parse().map_or(Self::Any, Self::Fixed)
    }

    fn of_nodes(self, node: Node) -> Node {
        match self {
            Self::One => node,
            Self::Fixed(count) => Node::Array(Box::new(node), count),
            Self::Any => Node::Sequence(Box::new(node)),
        }
    }
}

impl Schema {
    /// The schema of the type of this name, from its definition and those it needs, as bags store them.
    pub fn parse(name: &str, text: &str, wire: Wire) -> Option<Self> {
        let mut definitions = Definitions::new();
        for (name, text) in BUILT_IN {
            definitions.insert(name.into(), declarations(text));
        }
        for (index, section) in sections(text).into_iter().enumerate() {
            let (section_name, body) = match section.trim_start().strip_prefix("MSG:") {
                Some(rest) => rest.split_once('\n').unwrap_or((rest, "")),
                None if index == 0 => (name, section),
                None => continue,
            };
            definitions.insert(plain(section_name), declarations(body));
        }
        let mut schema = Self {
            root: Node::Text,
            fields: Vec::new(),
            derived: Vec::new(),
            stamp: None,
            nodes: 0,
            wire,
        };
        schema.root = schema.parts(&plain(name), "", &definitions, 0, true)?;
        let position = |name: &str| schema.fields.iter().position(|field| field == name);
        schema.stamp = position("header.stamp.sec")
            .zip(position("header.stamp.nanosec"))
            .map(|(sec, nanosec)| [sec, nanosec]);
        Some(schema)
    }

    fn parts(
        &mut self,
        type_name: &str,
        prefix: &str,
        definitions: &Definitions,
        depth: usize,
        is_field: bool,
    ) -> Option<Node> {
        let declared = definitions.get(type_name).filter(|_| depth < DEEPEST)?;
        let package = type_name.split('/').next().unwrap_or_default();
        let mut parts = Vec::<Node>::new();
        for (type_text, name) in declared {
            let path = match prefix {
                "" => (*name).to_string(),
                prefix => format!("{prefix}.{name}"),
            };
            let (element, count) = match type_text.split_once('[') {
                Some((element, count)) => (element, Count::of(count.trim_end_matches(']'))),
                None => (*type_text, Count::One),
            };
            let node = match primitive(element) {
                Some(kind) => self.numbers(kind, count, &path, is_field),
                None => {
                    let is_field = is_field && matches!(count, Count::One);
                    let is_text = element.starts_with("string") || element.starts_with("wstring");
                    let node = match is_text {
                        true => Node::Text,
                        false => {
                            let known = match element {
                                "Header" => "std_msgs/Header".into(),
                                "time" | "duration" => "builtin_interfaces/Time".into(),
                                _ if element.contains('/') => plain(element),
                                _ => format!("{package}/{element}"),
                            };
                            self.parts(&known, &path, definitions, depth + 1, is_field)?
                        }
                    };
                    count.of_nodes(node)
                }
            };
            match (parts.last_mut(), node) {
                (Some(before), Node::Run(kind, count, first))
                    if before.goes_on_with(kind, first) =>
                {
                    before.lengthen(count);
                }
                (_, node) => parts.push(node),
            }
            self.nodes += 1;
            if self.nodes > MOST_NODES || self.fields.len() > MOST_NODES {
                return None;
            }
        }
        if is_field {
            self.derive(type_name, prefix);
        }
        // A message without parts has one byte in CDR.
        if parts.is_empty() && self.wire == Wire::Cdr {
            parts.push(Node::Run(Primitive::U8, 1, None));
        }
        Some(Node::Parts(parts))
    }

    /// A number, an array or a sequence of numbers, with slots for those that are fields.
    fn numbers(&mut self, kind: Primitive, count: Count, path: &str, is_field: bool) -> Node {
        let slots = match count {
            Count::One => return Node::Run(kind, 1, self.slot(path, is_field)),
            Count::Fixed(count) if count > MOST_ELEMENTS => return Node::Run(kind, count, None),
            Count::Fixed(count) => count,
            Count::Any => MOST_ELEMENTS,
        };
        let first = is_field.then_some(self.fields.len());
        for i in 0..slots {
            self.slot(&format!("{path}[{i}]"), is_field);
        }
        match count {
            Count::Any => Node::Numbers(kind, first),
            _ => Node::Run(kind, slots, first),
        }
    }

    fn slot(&mut self, path: &str, is_field: bool) -> Option<usize> {
        is_field.then(|| {
            self.fields.push(path.into());
            self.fields.len() - 1
        })
    }

    /// Attitude and yaw rate in this crate's signs, from ROS's x forward, y port, z up in east, north, up.
    fn derive(&mut self, type_name: &str, prefix: &str) {
        let slot = |name: &str| {
            let path = format!("{prefix}.{name}");
            self.fields.iter().rposition(|field| *field == path)
        };
        let name = prefix.rsplit('.').next().unwrap_or_default();
        if type_name == "geometry_msgs/Quaternion"
            && let [Some(w), Some(x), Some(y), Some(z)] = ["w", "x", "y", "z"].map(slot)
        {
            self.derived.push(Derived::Attitude([w, x, y, z]));
        } else if ["angular_velocity", "angular"].contains(&name)
            && let Some(z) = slot("z")
        {
            self.derived.push(Derived::YawRate(z));
        }
    }

    /// Names of all fields, those computed last.
    pub fn names(&self) -> Vec<String> {
        let mut names = self.fields.clone();
        for derived in &self.derived {
            let (slot, computed): (usize, &[&str]) = match derived {
                Derived::Attitude([w, ..]) => (*w, &["roll_rad", "pitch_rad", "heading_rad"]),
                Derived::YawRate(z) => (*z, &["yaw_rate_rad_s"]),
            };
            let prefix = self.fields[slot].rsplit_once('.').map_or("", |(path, _)| path);
            names.extend(computed.iter().map(|name| format!("{prefix}.{name}")));
        }
        names
    }

    /// The numbers of a message, and the time of its header, s. `None` where it does not fit the schema.
    pub fn decode(&self, message: &[u8], values: &mut Vec<f64>) -> Option<Option<f64>> {
        values.clear();
        values.resize(self.fields.len(), f64::NAN);
        let mut cdr = match self.wire {
            Wire::Cdr => {
                let kind = *message.get(1)?;
                Cdr {
                    body: message.get(ENCAPSULATION..)?,
                    at: 0,
                    is_little_endian: kind & 1 == 1,
                    // Version 2 aligns to at most 4 bytes.
                    widest: if kind >= 6 { 4 } else { 8 },
                }
            }
            #[cfg(feature = "containers")]
            Wire::Ros1 => Cdr { body: message, at: 0, is_little_endian: true, widest: 1 },
        };
        cdr.read(&self.root, values)?;
        for derived in &self.derived {
            match *derived {
                Derived::Attitude(slots) => {
                    let [roll, pitch, yaw] = euler_rad(slots.map(|slot| values[slot]));
                    let heading = Real::wrapped(std::f64::consts::FRAC_PI_2 - yaw);
                    values.extend([roll, -pitch, heading]);
                }
                Derived::YawRate(slot) => values.push(-values[slot]),
            }
        }
        let stamp_s = self.stamp.map(|[sec, nanosec]| values[sec] + values[nanosec] / 1e9);
        Some(stamp_s.filter(|stamp_s| *stamp_s > 0.0))
    }
}

/// `sensor_msgs/msg/Imu` as `sensor_msgs/Imu`.
pub(crate) fn plain(name: &str) -> String {
    name.trim().replace("/msg/", "/")
}

/// Definitions are parted by lines of `=`.
fn sections(text: &str) -> Vec<&str> {
    let mut sections = Vec::new();
    let mut from = 0;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.starts_with("=====") {
            sections.push(&text[from..at]);
            from = at + line.len();
        }
        at += line.len();
    }
    sections.push(&text[from..]);
    sections
}

/// Type and name of every field; comments, constants and default values do not matter.
fn declarations(body: &str) -> Vec<(&str, &str)> {
    body.lines()
        .filter_map(|line| {
            let line = line.split('#').next()?;
            let mut words = line.split_whitespace();
            let (kind, name) = (words.next()?, words.next()?);
            let is_constant =
                name.contains('=') || words.next().is_some_and(|w| w.starts_with('='));
            (!is_constant).then_some((kind, name))
        })
        .collect()
}

/// A message in CDR.
struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
    is_little_endian: bool,
    widest: usize,
}

impl Cdr<'_> {
    fn read(&mut self, node: &Node, values: &mut [f64]) -> Option<()> {
        match node {
            Node::Run(kind, count, first) => self.run(*kind, *count, *first, values)?,
            Node::Text => {
                let length = self.length()?;
                self.skip(length)?;
            }
            Node::Parts(parts) => {
                for part in parts {
                    self.read(part, values)?;
                }
            }
            Node::Array(element, count) => self.repeat(element, *count, values)?,
            Node::Numbers(kind, first) => {
                let count = self.length()?;
                let kept = first.map_or(0, |_| count.min(MOST_ELEMENTS));
                self.run(*kind, kept, *first, values)?;
                self.run(*kind, count - kept, None, values)?;
            }
            Node::Sequence(element) => {
                let count = self.length()?;
                self.repeat(element, count, values)?;
            }
        }
        Some(())
    }

    fn repeat(&mut self, element: &Node, count: usize, values: &mut [f64]) -> Option<()> {
        // Every element has a byte at least.
        if count > self.body.len().saturating_sub(self.at) {
            return None;
        }
        (0..count).try_for_each(|_| self.read(element, values))
    }

    fn align(&mut self, width: usize) {
        self.at = self.at.next_multiple_of(width.min(self.widest));
    }

    fn skip(&mut self, count: usize) -> Option<()> {
        self.at = self.at.checked_add(count)?;
        (self.at <= self.body.len()).then_some(())
    }

    fn length(&mut self) -> Option<usize> {
        self.align(4);
        let bytes: [u8; 4] = *self.body.get(self.at..)?.first_chunk()?;
        self.at += 4;
        Some(match self.is_little_endian {
            true => u32::from_le_bytes(bytes),
            false => u32::from_be_bytes(bytes),
        } as usize)
    }

    /// Numbers one behind the other, of which those with a slot are kept.
    fn run(
        &mut self,
        kind: Primitive,
        count: usize,
        first: Option<usize>,
        values: &mut [f64],
    ) -> Option<()> {
        if count == 0 {
            return Some(());
        }
        self.align(kind.width());
        let from = self.at;
        self.skip(kind.width().checked_mul(count)?)?;
        let Some(first) = first else { return Some(()) };
        let numbers = &self.body[from..self.at];
        let kept = &mut values[first..first + count];
        kind.read_all(numbers, self.is_little_endian, kept);
        Some(())
    }
}

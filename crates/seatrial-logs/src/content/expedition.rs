//! Logs of Expedition and of yacht recorders like it: names of channels in the first line, their numbers in the second, and rows of a
//! boat, a time in days and pairs of number and value.
//!
//! ```text
//! !Boat,Utc,BSP,HDG
//! !boat,0,1,13
//! 0,44259.520833,1,6.102,13,45.10
//! ```

use std::collections::BTreeMap;

use crate::clock::days_unix_s;
use crate::line_log::{Channels, LineFormat};

/// The channel of the time.
const TIME: u32 = 0;

/// Logs of pairs.
#[derive(Default)]
pub(crate) struct Pairs {
    /// The first two lines.
    head: Vec<String>,
    /// Names of channels by their numbers.
    names: BTreeMap<u32, String>,
}

/// Does a file begin with names and numbers of channels?
pub(crate) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    names(&mut text.lines()).is_some()
}

/// The names of the channels, from the first two lines.
fn names<'a>(lines: &mut impl Iterator<Item = &'a str>) -> Option<BTreeMap<u32, String>> {
    let mut of_line = || {
        let line = lines.next()?.trim().strip_prefix('!')?;
        Some(line.split(',').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>())
    };
    let (names, numbers) = (of_line()?, of_line()?);
    let numbers = numbers.iter().skip(1).map(|number| number.parse().ok());
    let pairs = numbers.zip(names.iter().skip(1).cloned());
    let named: Option<BTreeMap<u32, String>> =
        pairs.map(|(number, name)| Some((number?, name))).collect();
    named.filter(|named| named.contains_key(&TIME))
}

/// The unit of a channel, which these recorders never write: angles are in degrees, speeds in knots.
fn unit(name: &str) -> &'static str {
    let name = name.to_ascii_lowercase();
    match name.as_str() {
        "hdg" | "heading" | "heel" => " (deg)",
        _ if name.starts_with("rudder") => " (deg)",
        "bsp" | "sog" => " (kn)",
        _ => "",
    }
}

/// A boat, its time, and pairs of a number and a value.
type Numbered = (u32, f64, Vec<(u32, f64)>);

/// Boat, time and pairs of a row. The time's own number may stand before it.
fn row(line: &str) -> Option<Numbered> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let boat = cells.first()?.parse().ok()?;
    let from = match cells.len() % 2 {
        0 => 1,
        _ => 2,
    };
    if from == 2 && cells.get(1)?.parse::<u32>().ok()? != TIME {
        return None;
    }
    let time_s = days_unix_s(cells.get(from)?.parse().ok()?)?;
    let pairs = cells[from + 1..]
        .chunks_exact(2)
        .map(|pair| Some((pair[0].parse().ok()?, pair[1].parse().unwrap_or(f64::NAN))));
    Some((boat, time_s, pairs.collect::<Option<_>>()?))
}

impl LineFormat for Pairs {
    /// Boat and number of the channel.
    type Key = (u32, u32);

    fn read(&mut self, line: &str, is_cut: bool, channels: &mut Channels<Self::Key>) -> bool {
        if line.starts_with('!') {
            if self.head.len() < 2 {
                self.head.push(line.into());
                let names = names(&mut self.head.iter().map(String::as_str));
                self.names = names.unwrap_or_default();
            }
            return true;
        }
        let Some((boat, time_s, pairs)) = row(line).filter(|_| !is_cut) else {
            return false;
        };
        for (channel, value) in pairs {
            // The first boat's channel has the channel's own name.
            channels.add((boat, channel), [time_s, value], |_| {
                let name = self.names.get(&channel)?;
                let unit = unit(name);
                Some(match boat {
                    0 => format!("{name}{unit}"),
                    boat => format!("boat {boat}.{name}{unit}"),
                })
            });
        }
        true
    }
}

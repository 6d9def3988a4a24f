//! MOOS logs (`.alog`): `12.345  NAV_HEADING  pNavigation  123.4`, time first, in seconds since the start.
//!
//! Every variable that is a number is a channel.

use crate::joined::Kind;
use crate::line_log::{Channels, LineFormat};
use crate::table::Known;
use crate::{Quantity, Unit};

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

/// Time, variable and value; the third cell is who wrote it.
fn entry(line: &str) -> Option<(f64, &str, &str)> {
    let mut cells = line.split_whitespace();
    let time_s = cells.next()?.parse().ok().filter(|t: &f64| t.is_finite())?;
    let name = cells.next()?;
    let _source = cells.next()?;
    Some((time_s, name, cells.next().unwrap_or_default()))
}

/// MOOS logs.
pub(crate) struct Alog;

impl LineFormat for Alog {
    type Key = String;

    fn read(&mut self, line: &str, is_cut: bool, channels: &mut Channels<String>) -> bool {
        if line.starts_with('%') {
            return true;
        }
        let Some((time_s, name, value)) = entry(line).filter(|_| !is_cut) else {
            return false;
        };
        if let Ok(value) = value.parse() {
            channels.add(name.into(), [time_s, value], |_| Some(name.into()));
        }
        true
    }

    fn known(&self, channels: &[Kind]) -> Known {
        let names: Vec<&str> = channels.iter().map(|kind| kind.name.as_str()).collect();
        let mut known = Known::default();
        for (quantity, name, unit) in CHANNELS {
            if names.contains(&name) {
                known.add(quantity, name.into(), unit, "");
            }
        }
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
}

//! MOOS logs (`.alog`): `12.345  NAV_HEADING  pNavigation  123.4`, time first, in seconds since the start.
//!
//! Every variable that is a number is a channel.

use crate::Quantity::*;
use crate::Unit::*;
use crate::line_log::{Channels, LineFormat};
use crate::message_table::names;
use crate::table::{Known, KnownField};

/// Variables that feed a quantity, the preferred one first; units are MOOS's.
const CHANNELS: [KnownField; 12] = [
    (Heading, "NAV_HEADING", "", Some(Degree)),
    (Heading, "NAV_HDG", "", Some(Degree)),
    (Rudder, "NAV_RUDDER", "", None),
    (Rudder, "RUDDER_ANGLE", "", None),
    (Rudder, "RUDDER", "", None),
    (Rudder, "DESIRED_RUDDER", "", None),
    (Speed, "NAV_SPEED", "", Some(MetrePerSecond)),
    (Depth, "NAV_DEPTH", "", Some(Metre)),
    (Altitude, "NAV_ALTITUDE", "", Some(Metre)),
    (Pitch, "NAV_PITCH", "", Some(Radian)),
    (North, "NAV_Y", "", Some(Metre)),
    (East, "NAV_X", "", Some(Metre)),
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

    fn known(&self, channels: &Channels<String>) -> Known {
        let mut known = Known::default();
        known.add_fields(&channels.kinds, CHANNELS);
        let found = crate::error::clipped(&names(&channels.kinds));
        known.expects(Heading, "NAV_HEADING", &found);
        known.expects(Rudder, "NAV_RUDDER, RUDDER or DESIRED_RUDDER", &found);
        known
    }
}

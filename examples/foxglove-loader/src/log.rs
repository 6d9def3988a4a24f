//! The samples of a log as topics.

use seatrial_core::{RudderUnit, Sample};
use seatrial_logs::{ChannelChoice, FileMap, ReadError, open_in};

/// A quantity over time.
pub struct Topic {
    pub name: &'static str,
    /// Times in ns and values.
    pub points: Vec<(u64, f64)>,
}

/// A log that has been read.
#[derive(Default)]
pub struct Log {
    pub topics: Vec<Topic>,
    pub start_ns: u64,
    pub end_ns: u64,
    /// What people should know before they trust the numbers.
    pub warnings: Vec<String>,
}

type Value = fn(&Sample<f64>) -> Option<f64>;

const RUDDER: &str = "/rudder_rad";
/// The rudder of a log that does not say the angle of full deflection.
const SHARE_OF_RUDDER: &str = "/rudder_fraction";

/// The topics of a recording of seatrial that a log may have.
const TOPICS: [(&str, Value); 11] = [
    ("/heading_rad", |s| Some(s.heading_rad)),
    (RUDDER, |s| Some(s.rudder_rad)),
    ("/surge_speed_m_s", |s| s.surge_speed_m_s),
    ("/depth_m", |s| s.depth_m),
    ("/altitude_m", |s| s.altitude_m),
    ("/roll_rad", |s| s.roll_rad),
    ("/pitch_rad", |s| s.pitch_rad),
    ("/yaw_rate_rad_s", |s| s.yaw_rate_rad_s),
    ("/north_m", |s| s.north_m),
    ("/east_m", |s| s.east_m),
    ("/thrust_fraction", |s| s.thrust),
];

impl Log {
    /// Reads a log of any format that seatrial knows. The time is the vehicle's own clock. A topic without values is left out.
    pub fn read(name: &str, bytes: Vec<u8>) -> Result<Self, ReadError> {
        let mut held = FileMap::default();
        held.insert(name, bytes);
        let mut reader = open_in(name.as_ref(), &held, &ChannelChoice::default())?;
        let description = reader.description().clone();
        let samples = reader.by_ref().collect::<Result<Vec<_>, _>>()?;
        let named = |name| match (name, description.rudder_unit) {
            (RUDDER, RudderUnit::FullRudder) => SHARE_OF_RUDDER,
            (name, _) => name,
        };
        let topics = TOPICS.into_iter().map(|(name, value)| Topic {
            name: named(name),
            points: samples
                .iter()
                .filter_map(|sample| Some((ns(sample.time_s), value(sample)?)))
                .collect(),
        });
        Ok(Self {
            topics: topics.filter(|topic| !topic.points.is_empty()).collect(),
            start_ns: samples.first().map_or(0, |sample| ns(sample.time_s)),
            end_ns: samples.last().map_or(0, |sample| ns(sample.time_s)),
            warnings: [description.warnings, reader.warnings()].concat(),
        })
    }
}

/// Foxglove counts no time before 0.
fn ns(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

//! Vehicle logs in and out: formats, channels, units, time.
//!
//! [`open`] finds the format of a log by its content, which column feeds which quantity and in which
//! unit, says so in a [`LogDescription`], and yields [`Sample`](seatrial_core::Sample)s in SI units one
//! by one with bounded memory. Every format is a `table::Table`: named columns and rows of cells; names,
//! units, time and the checks of every row are the same for all of them.

// A build with few formats leaves some of what they share unused.
#![cfg_attr(
    not(all(
        feature = "dataflash",
        feature = "tlog",
        feature = "ulog",
        feature = "canboat",
        feature = "slocum",
        feature = "nmea0183",
        feature = "alog",
        feature = "mcap",
        feature = "rosbag2"
    )),
    allow(dead_code)
)]

#[cfg(all(
    test,
    feature = "dataflash",
    feature = "tlog",
    feature = "ulog",
    feature = "mcap",
    feature = "rosbag2"
))]
mod agreement;
#[cfg(feature = "alog")]
mod alog;
#[cfg(any(feature = "dataflash", feature = "tlog"))]
mod ardupilot;
pub mod ardupilot_json;
#[cfg(any(
    feature = "ulog",
    feature = "mcap",
    feature = "rosbag2",
    feature = "autopilot"
))]
mod attitude;
#[cfg(feature = "autopilot")]
pub mod autopilot;
#[cfg(feature = "messages")]
mod bytes;
#[cfg(feature = "canboat")]
mod canboat;
mod clock;
mod content;
mod csv;
#[cfg(feature = "dataflash")]
mod dataflash;
mod description;
mod error;
mod half_difference;
mod infer;
#[cfg(feature = "messages")]
mod joined;
#[cfg(feature = "autopilot")]
pub mod link;
mod matching;
#[cfg(feature = "tlog")]
mod mavlink;
#[cfg(feature = "mcap")]
mod mcap;
mod name;
#[cfg(feature = "nmea0183")]
mod nmea0183;
#[cfg(any(feature = "messages", feature = "parquet"))]
mod number;
#[cfg(feature = "parquet")]
mod parquet;
mod quantity;
mod reader;
#[cfg(any(feature = "mcap", feature = "rosbag2"))]
mod ros2;
#[cfg(feature = "autopilot")]
pub mod ros2_vehicle;
#[cfg(feature = "rosbag2")]
mod rosbag;
mod runs;
#[cfg(feature = "slocum")]
mod slocum;
mod table;
#[cfg(feature = "tlog")]
mod tlog;
#[cfg(feature = "ulog")]
mod ulog;
mod unit;
mod wiggle;
mod write;

pub use description::{
    Channel, ChannelChoice, Correction, Counts, Format, LogDescription, UnitSource,
};
pub use error::{Fault, Place, ReadError};
pub use quantity::Quantity;
pub use reader::{LogReader, open};
pub use runs::{Run, Runs};
pub use unit::Unit;
#[cfg(feature = "foxglove")]
pub use write::FoxgloveServer;
#[cfg(feature = "parquet")]
pub use write::write_parquet;
pub use write::{CsvWriter, Estimate, Row, RowWriter, write_csv};
#[cfg(feature = "mcap")]
pub use write::{McapWriter, write_mcap};

#![doc = include_str!("../README.md")]
//!
//! # How it works
//!
//! Every format is a `table::Table`: named columns and rows of cells. Names, units, time and the checks of every row are the
//! same code for all of them.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(all(test, feature = "mcap", feature = "rosbag2"))]
#[path = "../tests/agreement/inside.rs"]
mod agreement;
#[cfg(feature = "containers")]
mod as_text;
mod bytes;
mod choice;
mod clock;
mod computed;
mod content;
mod coordinates;
mod csv;
mod dataflash;
mod dataflash_text;
mod description;
mod error;
mod format_name;
pub mod formats;
mod infer;
mod input;
#[cfg(feature = "containers")]
mod key_value;
mod languages;
mod line_log;
mod look_ahead;
mod loose;
mod matching;
#[cfg(feature = "containers")]
mod matlab;
#[cfg(feature = "mcap-reader")]
mod mcap;
mod message_table;
mod motors;
mod name;
mod nmea0183;
mod nmea2000;
mod no_log;
mod number;
#[cfg(feature = "parquet-reader")]
mod parquet;
mod pcap;
mod quantity;
mod reader;
#[cfg(feature = "containers")]
mod ros1;
#[cfg(any(feature = "mcap-reader", feature = "rosbag2", feature = "containers"))]
mod ros2;
#[cfg(feature = "rosbag2")]
mod rosbag;
mod runs;
mod signal_k;
mod slocum;
mod table;
mod tlog;
mod track;
mod ulog;
mod unit;
#[cfg(all(feature = "without-c", any(test, not(feature = "parquet"))))]
mod unpack;
mod view;
mod words;
#[cfg(feature = "containers")]
mod workbook;
mod write;

pub use choice::{ChannelChoice, Correction};
pub use content::{columns, columns_from, is_log};
pub use csv::DAMAGE_MARK;
pub use description::{Channel, Counts, LogDescription, UnitSource};
pub use error::{Fault, Place, ReadError};
pub use format_name::Format;
pub use input::{FileMap, Source, sha256};
pub use name::names_a_course;
pub use quantity::{Quantity, UnknownQuantity};
pub use reader::{LogReader, open, open_in};
pub use runs::{Run, Runs};
pub use unit::{Unit, UnknownUnit};
#[cfg(feature = "foxglove")]
pub use write::FoxgloveServer;
#[cfg(feature = "parquet")]
pub use write::write_parquet;
pub use write::{CsvWriter, Estimate, Row, RowWriter, TrackFormat, write_csv, write_track};
#[cfg(feature = "mcap")]
pub use write::{McapWriter, write_mcap};

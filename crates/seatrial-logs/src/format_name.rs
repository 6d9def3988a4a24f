//! The formats that are read, and what people call them.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Formats that are read, found by content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Format {
    /// CSV, delimited text in UTF-8, UTF-16, Latin-1 or Shift-JIS; keys and values, objects in JSON, messages of `mavlogdump`, text of `dbd2asc`.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// ArduPilot DataFlash and its text copies.
    #[serde(rename = "dataflash")]
    DataFlash,
    /// MAVLink telemetry.
    Tlog,
    /// PX4 ULog.
    Ulog,
    /// NMEA 2000: canboat (PLAIN, JSON), Yacht Devices (RAW, .DAT), iKonvert, candump, PCAN, Vector, Busmaster, python-can, Garmin, SeaSmart, Actisense (ASCII, NGT-1, .ebl).
    Canboat,
    /// Slocum gliders.
    Slocum,
    /// NMEA 0183, with or without times before the sentences, as OpenCPN and Signal K record it.
    Nmea0183,
    /// MOOS.
    Alog,
    /// DUNE, messages of IMC (LAUV).
    Lsf,
    /// Signal K, deltas in JSON.
    #[serde(rename = "signal_k")]
    SignalK,
    /// Expedition, pairs of channel and value.
    Expedition,
    /// MCAP with ROS 2 messages.
    Mcap,
    /// rosbag2 in SQLite.
    Rosbag,
    /// ROS 1 bags.
    #[serde(rename = "rosbag1")]
    Rosbag1,
    /// Excel workbooks.
    #[serde(rename = "xlsx")]
    Workbook,
    /// MATLAB, version 5 to 7.
    #[serde(rename = "mat")]
    Matlab,
    /// One that the program brought ([`LogFormat`](crate::formats::LogFormat)), by its name.
    #[serde(untagged)]
    Other(String),
}

impl Format {
    /// Every format that is read, what people call it, and how names of its files end.
    ///
    /// ```
    /// use seatrial_logs::Format;
    ///
    /// let ends_so = |(_, _, endings): &&(Format, &str, &[&str])| endings.contains(&"tlog");
    /// assert_eq!(Format::NAMES.iter().find(ends_so).map(|(format, ..)| format), Some(&Format::Tlog));
    /// ```
    pub const NAMES: &[(Self, &str, &[&str])] = &[
        (Self::Csv, "CSV", &["csv", "tsv", "txt", "jsonl"]),
        (Self::Parquet, "Parquet", &["parquet"]),
        (Self::DataFlash, "DataFlash", &["bin", "log"]),
        (Self::Tlog, "telemetry", &["tlog"]),
        (Self::Ulog, "ULog", &["ulg"]),
        (Self::Mcap, "MCAP", &["mcap"]),
        (Self::Rosbag, "rosbag2", &["db3"]),
        (Self::Rosbag1, "ROS 1", &["bag"]),
        (Self::Nmea0183, "NMEA 0183", &["nmea"]),
        (Self::Canboat, "NMEA 2000", &["n2k", "raw", "trc", "ebl"]),
        (Self::SignalK, "Signal K", &[]),
        (Self::Expedition, "Expedition", &[]),
        (Self::Alog, "MOOS", &["alog"]),
        (Self::Slocum, "Slocum", &["dbd", "sbd", "mbd", "ebd"]),
        (Self::Lsf, "DUNE", &["lsf"]),
        (Self::Workbook, "Excel", &["xlsx"]),
        (Self::Matlab, "MATLAB", &["mat"]),
    ];
}

/// The name that documents have: `dataflash`.
impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

//! What a file is, by its content; its name does not matter.

use std::fs::File;
use std::io::{Read, Seek};

use crate::csv::Text;
use crate::error::Fault;
use crate::table::Table;

/// For messages.
pub(crate) const BINARY_FORMATS: &str =
    "Parquet, ArduPilot DataFlash (.bin), MAVLink telemetry (.tlog) and PX4 ULog (.ulg)";

/// Bytes that are enough to tell every format.
const START: u64 = 4096;

/// Opens a format that this build may have been made without.
macro_rules! built {
    ($feature:literal, $name:literal, $open:expr) => {{
        #[cfg(feature = $feature)]
        {
            Ok(Box::new($open))
        }
        #[cfg(not(feature = $feature))]
        {
            Err(Fault::NotBuilt {
                format: $name,
                feature: concat!("--features ", $feature),
            })
        }
    }};
}

/// Opens a file as what it is; text where it is nothing else.
pub(crate) fn open(mut file: File) -> Result<Box<dyn Table>, Fault> {
    let mut start = Vec::new();
    Read::by_ref(&mut file)
        .take(START)
        .read_to_end(&mut start)
        .map_err(Fault::read)?;
    file.rewind().map_err(Fault::read)?;
    if start.starts_with(b"PAR1") {
        built!("parquet", "Parquet", crate::parquet::Columnar::open(file)?)
    } else if is_dataflash(&start) {
        built!(
            "dataflash",
            "ArduPilot DataFlash",
            crate::joined::Joined::new(crate::dataflash::DataFlash::open(file)?)
        )
    } else if is_telemetry(&start) {
        built!(
            "tlog",
            "MAVLink telemetry",
            crate::joined::Joined::new(crate::tlog::Telemetry::open(file)?)
        )
    } else if start.starts_with(b"ULog\x01\x12\x35") {
        built!(
            "ulog",
            "PX4 ULog",
            crate::joined::Joined::new(crate::ulog::ULog::open(file)?)
        )
    } else {
        Ok(Box::new(Text::open(file)?))
    }
}

/// The first message describes messages.
fn is_dataflash(start: &[u8]) -> bool {
    start.starts_with(&[0xa3, 0x95, 0x80])
}

/// A time of arrival, us since 1970, of the years 1990 to 2100 (ground stations have a clock), then a frame.
fn is_telemetry(start: &[u8]) -> bool {
    let stamp = start.first_chunk().map(|bytes| u64::from_be_bytes(*bytes));
    stamp.is_some_and(|us| (630_000_000_000_000..4_100_000_000_000_000).contains(&us))
        && matches!(start.get(8), Some(0xfd | 0xfe))
}

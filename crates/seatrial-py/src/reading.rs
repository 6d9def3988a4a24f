//! How logs are read, and what is said of them on the way.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use seatrial::Window;
use seatrial::identification::Reader;
use seatrial::log::{ColumnUnit, Origin, StatedUnits};
use seatrial_app::identify_log::Windows;
use seatrial_app::logs::{Observer, ReadSettings, servo_of};
use seatrial_logs::{ChannelChoice, Quantity};

use crate::usage;

/// The arguments with which a log is read, a mapping of the Python part.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Reading {
    channels_file: Option<PathBuf>,
    columns: BTreeMap<String, String>,
    units: BTreeMap<String, String>,
    full_rudder_rad: Option<f64>,
    rudder_trim_us: Option<f64>,
    rudder_delay_s: Option<f64>,
    rudder_lag_s: Option<f64>,
    drop_invalid: bool,
}

impl Reading {
    /// The settings that they stand for.
    pub fn settings(&self, py: Python<'_>) -> PyResult<ReadSettings> {
        let quantity = |name: &String| name.parse::<Quantity>().map_err(|why| usage(py, why));
        for (name, value) in
            [("full_rudder_rad", self.full_rudder_rad), ("rudder_trim_us", self.rudder_trim_us)]
        {
            if let Some(value) = value.filter(|value| !value.is_finite() || *value <= 0.0) {
                return Err(usage(py, format!("{name}={value}: expected a number above 0")));
            }
        }
        let mut channels = ChannelChoice::default();
        channels.full_rudder_rad = self.full_rudder_rad;
        channels.rudder_trim = self.rudder_trim_us;
        channels.drop_invalid = self.drop_invalid;
        for (name, column) in &self.columns {
            channels.name_column(quantity(name)?, column.clone());
        }
        for (name, unit) in &self.units {
            let unit = unit.parse().map_err(|why| usage(py, why))?;
            channels.units.insert(quantity(name)?, unit);
        }
        let servo = servo_of(self.rudder_delay_s, self.rudder_lag_s);
        let mut settings = ReadSettings::default();
        settings.channels_file = self.channels_file.clone();
        settings.channels = channels;
        settings.servo = servo.map_err(|why| usage(py, why))?;
        settings.reader = Reader::Python;
        Ok(settings)
    }
}

/// The units of the columns of arrays, a mapping of the Python part: numbers of each for one SI unit, and who says so.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SaidUnits {
    time: (f64, String),
    heading: (f64, String),
    rudder: (f64, String),
    yaw_rate: (f64, String),
    time_is_a_date: bool,
}

impl SaidUnits {
    /// As they are doubted.
    pub fn stated(&self) -> StatedUnits {
        let unit = |(per_si, origin): &(f64, String)| ColumnUnit {
            per_si: *per_si,
            origin: match origin.as_str() {
                "given" => Origin::Given,
                "stated" => Origin::Stated,
                _ => Origin::Assumed,
            },
            is_against_name: false,
        };
        StatedUnits {
            time: unit(&self.time),
            heading: unit(&self.heading),
            rudder: unit(&self.rudder),
            yaw_rate: unit(&self.yaw_rate),
            time_is_a_date: self.time_is_a_date,
            ..StatedUnits::default()
        }
    }
}

/// The start and the end of a window, s.
pub type Span = (Option<f64>, Option<f64>);

/// The window that a span stands for.
pub fn window((from_s, to_s): Span) -> Window {
    Window { from_s: from_s.unwrap_or(f64::NEG_INFINITY), to_s: to_s.unwrap_or(f64::INFINITY) }
}

/// The windows that arguments stand for.
pub fn windows(training: Span, validation: Span, validate_on: Option<PathBuf>) -> Windows {
    Windows {
        from_s: training.0,
        to_s: training.1,
        validate_from_s: validation.0,
        validate_to_s: validation.1,
        validate_on,
    }
}

/// Keeps what people should know before they trust the samples.
#[derive(Default)]
pub struct Warned(pub Vec<String>);

impl Observer for Warned {
    fn warned(&mut self, warning: &str) {
        self.0.push(warning.to_owned());
    }
}

//! Samples, and what a trial makes of them, into a log. Every column's name says its unit, so that
//! [`open`](crate::open) gives the same samples back.
//!
//! [`write_csv`], [`write_parquet`] and [`write_mcap`] write rows that are all there; [`CsvWriter`] and
//! [`McapWriter`] write them as they come.

mod csv;
#[cfg(feature = "foxglove")]
mod foxglove;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(any(feature = "foxglove", feature = "mcap"))]
mod ros2;
mod track;

use std::io;

use seatrial_core::{Sample, Stage, YawModel};

pub use csv::{CsvWriter, write_csv};
#[cfg(feature = "foxglove")]
pub use foxglove::FoxgloveServer;
#[cfg(feature = "mcap")]
pub use mcap::{McapWriter, write_mcap};
#[cfg(feature = "parquet")]
pub use parquet::write_parquet;
pub use track::{TrackFormat, write_track};

/// A row of a log that is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// What the vehicle measured.
    pub sample: Sample<f64>,
    /// The stage of the trial.
    pub stage: Option<Stage>,
    /// The live estimate.
    pub estimate: Option<Estimate>,
}

/// A live estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// a22, b2 and C0.
    pub model: YawModel<f64>,
    /// Half widths of their 95 % intervals.
    pub half_widths: Option<[f64; 3]>,
    /// Step norm of the parameters (39).
    pub step_norm: f64,
}

impl From<Sample<f64>> for Row {
    fn from(sample: Sample<f64>) -> Self {
        Self { sample, ..Self::default() }
    }
}

/// Writes rows as they come.
pub trait RowWriter {
    /// Takes a row.
    fn write(&mut self, row: &Row) -> io::Result<()>;

    /// Writes out everything that it was given.
    fn flush(&mut self) -> io::Result<()>;

    /// Writes what belongs after the last row.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// A column of the logs that are written.
#[derive(Clone, Copy)]
struct Column {
    name: &'static str,
    value: fn(&Row) -> Option<f64>,
}

/// Columns that every log has.
const NEEDED: usize = 3;

const COLUMNS: [Column; 20] = {
    const fn column(name: &'static str, value: fn(&Row) -> Option<f64>) -> Column {
        Column { name, value }
    }
    [
        column("time_s", |r| Some(r.sample.time_s)),
        column("heading_rad", |r| Some(r.sample.heading_rad)),
        column("rudder_rad", |r| Some(r.sample.rudder_rad)),
        column("surge_speed_m_s", |r| r.sample.surge_speed_m_s),
        column("depth_m", |r| r.sample.depth_m),
        column("altitude_m", |r| r.sample.altitude_m),
        column("roll_rad", |r| r.sample.roll_rad),
        column("pitch_rad", |r| r.sample.pitch_rad),
        column("yaw_rate_rad_s", |r| r.sample.yaw_rate_rad_s),
        column("north_m", |r| r.sample.north_m),
        column("east_m", |r| r.sample.east_m),
        column("thrust_fraction", |r| r.sample.thrust),
        column("stage", |r| r.stage.map(stage_number)),
        column("estimate_a22_per_s", |r| Some(r.estimate?.model.a22_per_s)),
        column("estimate_b2_per_s2", |r| Some(r.estimate?.model.b2_per_s2)),
        column("estimate_c0_rad_per_s2", |r| Some(r.estimate?.model.c0_rad_per_s2)),
        column("half_width_a22_per_s", |r| Some(r.estimate?.half_widths?[0])),
        column("half_width_b2_per_s2", |r| Some(r.estimate?.half_widths?[1])),
        column("half_width_c0_rad_per_s2", |r| Some(r.estimate?.half_widths?[2])),
        column("estimate_step_norm", |r| Some(r.estimate?.step_norm)),
    ]
};

fn stage_number(stage: Stage) -> f64 {
    match stage {
        Stage::Settle => 1.0,
        Stage::Train => 2.0,
        Stage::Validate => 3.0,
    }
}

/// The columns that have a value somewhere.
fn columns_of(rows: &[Row]) -> Vec<Column> {
    let has_values = |column: &Column| rows.iter().any(|row| (column.value)(row).is_some());
    let columns = COLUMNS.into_iter().enumerate();
    let written = columns.filter(|(i, column)| *i < NEEDED || has_values(column));
    written.map(|(_, column)| column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_every_column_is_in_the_docs() {
        let docs = include_str!("../../../../docs/recordings.md");
        for column in COLUMNS {
            assert!(docs.contains(&format!("| `{}` |", column.name)), "{}", column.name);
        }
    }
}

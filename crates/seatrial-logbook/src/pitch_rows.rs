//! Pitch trials as their tables hold them.

use rusqlite::{Connection, Row};
use seatrial_core::DivingSample;

use super::read::collect;
use super::row::Exact;

/// A row of `pitch_trial`, as text.
pub(super) struct StoredPitchTrial {
    pub(super) number: i64,
    pub(super) configuration: String,
    pub(super) entered: String,
    pub(super) software_version: String,
    pub(super) vehicle: String,
    pub(super) seed: Option<u64>,
    pub(super) plan: String,
    pub(super) result: String,
    pub(super) sha256: String,
}

/// Every trial, in place of a number: numbers begin at 1.
pub(super) const ALL: i64 = 0;

/// The pitch trial of that number, or all.
pub(super) fn stored(
    connection: &Connection,
    number: i64,
) -> Result<Vec<StoredPitchTrial>, rusqlite::Error> {
    collect(
        connection,
        "SELECT id, configuration, entered, software_version, vehicle, seed, plan, result, sha256
         FROM pitch_trial WHERE ?1 IN (0, id) ORDER BY id",
        number,
        |row| {
            Ok(StoredPitchTrial {
                number: row.get(0)?,
                configuration: row.get(1)?,
                entered: row.get(2)?,
                software_version: row.get(3)?,
                vehicle: row.get(4)?,
                seed: row.get::<_, Option<i64>>(5)?.map(i64::cast_unsigned),
                plan: row.get(6)?,
                result: row.get(7)?,
                sha256: row.get(8)?,
            })
        },
    )
}

/// The samples of a pitch trial.
pub(super) fn samples(
    connection: &Connection,
    number: i64,
) -> Result<Vec<DivingSample<f64>>, rusqlite::Error> {
    let known = |row: &Row, column| row.get(column).map(|Exact(value)| value);
    let perhaps = |row: &Row, column| {
        let value: Option<Exact> = row.get(column)?;
        Ok::<_, rusqlite::Error>(value.map(|Exact(value)| value))
    };
    collect(
        connection,
        "SELECT time_s, pitch_rad, elevator_rad, depth_m, surge_speed_m_s
         FROM pitch_sample WHERE trial = ? ORDER BY number",
        number,
        |row| {
            Ok(DivingSample {
                time_s: known(row, 0)?,
                pitch_rad: known(row, 1)?,
                elevator_rad: known(row, 2)?,
                depth_m: perhaps(row, 3)?,
                surge_speed_m_s: perhaps(row, 4)?,
            })
        },
    )
}

//! Steps and JSON as columns of a row.

use rusqlite::types::{FromSql, FromSqlError, FromSqlResult, ToSql, ToSqlOutput, Type, ValueRef};
use rusqlite::{Error, Row};
use seatrial::Step;
use seatrial_core::{Action, Sample, Stage, Steering, YawModel};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The step of a row that begins with [`Step::COLUMNS`], stage and outcome.
pub(super) fn step_of(row: &Row) -> Result<Step, Error> {
    let number = |column| number(row, column);
    let optional = |column| optional(row, column);
    let steering = match (optional(11)?, optional(12)?) {
        (Some(angle), None) => Steering::Rudder(angle),
        (None, Some(angle)) => Steering::HoldHeading(angle),
        _ => {
            return Err(unexpected(11, "expected either a rudder or a heading commanded"));
        }
    };
    let estimate = match (optional(14)?, optional(15)?, optional(16)?) {
        (Some(a22), Some(b2), Some(c0)) => Some(YawModel::from_theta([a22, b2, c0])),
        (None, None, None) => None,
        _ => return Err(unexpected(14, "expected a whole estimate or none")),
    };
    Ok(Step {
        sample: Sample {
            time_s: number(0)?,
            heading_rad: number(1)?,
            rudder_rad: number(2)?,
            surge_speed_m_s: optional(3)?,
            depth_m: optional(4)?,
            altitude_m: optional(5)?,
            roll_rad: optional(6)?,
            pitch_rad: optional(7)?,
            yaw_rate_rad_s: optional(8)?,
            north_m: optional(9)?,
            east_m: optional(10)?,
            thrust: optional(17)?,
        },
        stage: row.get::<_, Option<String>>(18)?.map(|name| stage(18, &name)).transpose()?,
        action: Action { steering, thrust: optional(13)?, outcome: json_column(row, 19)? },
        estimate,
    })
}

/// A double that keeps its bits: SQLite takes NaN for NULL, so one is stored as its eight bytes.
#[derive(Clone, Copy)]
pub(super) struct Exact(pub f64);

impl ToSql for Exact {
    fn to_sql(&self) -> Result<ToSqlOutput<'_>, Error> {
        Ok(if self.0.is_nan() { self.0.to_be_bytes().to_vec().into() } else { self.0.into() })
    }
}

impl FromSql for Exact {
    fn column_result(value: ValueRef<'_>) -> FromSqlResult<Self> {
        match value {
            ValueRef::Real(number) => Ok(Self(number)),
            ValueRef::Blob(bytes) => bytes
                .try_into()
                .map(|bytes| Self(f64::from_be_bytes(bytes)))
                .map_err(|_| FromSqlError::InvalidType),
            _ => Err(FromSqlError::InvalidType),
        }
    }
}

/// The number of a column.
pub(super) fn number(row: &Row, column: usize) -> Result<f64, Error> {
    row.get(column).map(|Exact(value)| value)
}

/// The number of a column that may be NULL.
pub(super) fn optional(row: &Row, column: usize) -> Result<Option<f64>, Error> {
    let value: Option<Exact> = row.get(column)?;
    Ok(value.map(|Exact(value)| value))
}

/// The name of a stage in the logbook.
pub(super) fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Settle => "settle",
        Stage::Train => "train",
        Stage::Validate => "validate",
    }
}

/// The stage of that name.
pub(super) fn stage(column: usize, name: &str) -> Result<Stage, Error> {
    [Stage::Settle, Stage::Train, Stage::Validate]
        .into_iter()
        .find(|stage| stage_name(*stage) == name)
        .ok_or_else(|| unexpected(column, &format!("no stage is called {name:?}")))
}

/// The value as JSON text.
pub(super) fn to_json(value: &impl Serialize) -> Result<String, Error> {
    serde_json::to_string(value).map_err(|error| Error::ToSqlConversionFailure(error.into()))
}

/// The value of JSON text from that column.
pub(super) fn from_json<T: DeserializeOwned>(column: usize, text: &str) -> Result<T, Error> {
    serde_json::from_str(text)
        .map_err(|error| Error::FromSqlConversionFailure(column, Type::Text, error.into()))
}

/// The value of a column of JSON text, which may be NULL.
pub(super) fn json_column<T: DeserializeOwned>(
    row: &Row,
    column: usize,
) -> Result<Option<T>, Error> {
    row.get::<_, Option<String>>(column)?.map(|text| from_json(column, &text)).transpose()
}

fn unexpected(column: usize, what: &str) -> Error {
    Error::FromSqlConversionFailure(column, Type::Null, what.into())
}

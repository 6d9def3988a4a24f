//! The columns of the Parquet file: the fields of a row.

use serde::{Deserialize, Serialize};

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// UTF-8.
    Text(Option<&'a str>),
    /// 64 bit.
    Number(Option<f64>),
    /// 64 bit, signed.
    Integer(Option<u64>),
    /// Yes or no.
    Bool(Option<bool>),
    /// Microseconds since 1970, UTC.
    Time(Option<i64>),
    /// Texts, in order.
    Texts(Option<&'a [String]>),
}

/// The cell of a field of each type.
macro_rules! cells {
    ($($type:ty => $cell:expr;)*) => {
        $(impl<'a> From<&'a $type> for Value<'a> {
            fn from(field: &'a $type) -> Self {
                let cell: fn(&'a $type) -> Self = $cell;
                cell(field)
            }
        })*
    };
}

cells! {
    String => |field| Self::Text(Some(field));
    Option<String> => |field| Self::Text(field.as_deref());
    Option<f64> => |field| Self::Number(*field);
    u64 => |field| Self::Integer(Some(*field));
    Option<u64> => |field| Self::Integer(*field);
    Option<bool> => |field| Self::Bool(*field);
    Option<i64> => |field| Self::Time(*field);
    Option<Vec<String>> => |field| Self::Texts(field.as_deref());
}

/// A column.
#[derive(Clone, Copy)]
pub struct Column {
    /// Its name, with its unit.
    pub name: &'static str,
    /// What it holds.
    pub meaning: &'static str,
    pub(super) value: fn(&Row) -> Value<'_>,
}

/// The fields of [`Row`], each a column: its name, its type and what it holds.
macro_rules! columns {
    ($($name:ident: $type:ty = $meaning:literal,)*) => {
        /// A manoeuvre and its model, or a log that cannot be read. Missing things are `None`.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default)]
        pub struct Row {
            $(#[doc = $meaning] pub $name: $type,)*
        }

        /// Every column, in order.
        pub const COLUMNS: &[Column] = &[$(Column {
            name: stringify!($name),
            meaning: $meaning,
            value: |row| Value::from(&row.$name),
        },)*];
    };
}

columns! {
    source: String = "The log, as it was found",
    run: Option<String> = "The run within the log, with `--run-column`",
    format: Option<String> = "Format of the log",
    bytes: u64 = "Length of the log, bytes",
    modified: Option<i64> = "When the log was last written",
    etag: Option<String> = "Version of the log in its object store",
    sha256: Option<String> = "SHA-256 of the log; of a file of many runs missing",
    start: Option<i64> = "Second 0 of the log, where it has an epoch or calendar time",
    samples_read: Option<u64> = "Samples of the log or run",
    rows_left_out: Option<u64> = "Rows of the log or run that are no samples",
    rudder_unit: Option<String> = "`rad`, or `full_rudder` where 1 is full rudder",
    warnings: Option<Vec<String>> = "What was assumed of the log or is doubtful in it",
    manoeuvre: Option<String> = "`doublet`, `multistep` or `zig_zag`; `record` of a log or run that was taken as a whole",
    from_s: Option<f64> = "Start of the training window, s of the log",
    to_s: Option<f64> = "End of the training window, s of the log",
    thrust: Option<f64> = "Mean thrust, a fraction of full",
    surge_speed_m_s: Option<f64> = "Mean forward speed, m/s",
    rudder_amplitude_rad: Option<f64> = "How far the rudder was deflected to either side, rad",
    samples_used: Option<u64> = "Samples that the estimate learnt from",
    samples_rejected: Option<u64> = "Samples that the guard rejected",
    lambda_rad_s: Option<f64> = "Pole of the state variable filter, rad/s",
    method: Option<String> = "The estimator whose model is reported",
    a22_per_s: Option<f64> = "Rotational damping a22, 1/s",
    b2_per_s2: Option<f64> = "Rudder authority b2, 1/s^2",
    c0_rad_per_s2: Option<f64> = "Yaw acceleration at neutral rudder C0, rad/s^2",
    delta0_rad: Option<f64> = "C0/b2, rad; the rudder that holds a constant heading is its negative",
    a22_low_per_s: Option<f64> = "Lower end of the 95 % interval of a22, 1/s",
    a22_high_per_s: Option<f64> = "Upper end",
    b2_low_per_s2: Option<f64> = "Lower end of the 95 % interval of b2, 1/s^2",
    b2_high_per_s2: Option<f64> = "Upper end",
    c0_low_rad_per_s2: Option<f64> = "Lower end of the 95 % interval of C0, rad/s^2",
    c0_high_rad_per_s2: Option<f64> = "Upper end",
    nomoto_t_s: Option<f64> = "Nomoto's time constant T, s",
    nomoto_k_per_s: Option<f64> = "Nomoto's gain K, 1/s",
    online_a22_per_s: Option<f64> = "a22 of the estimator that runs on the vehicle, 1/s",
    online_b2_per_s2: Option<f64> = "b2 of it, 1/s^2",
    online_c0_rad_per_s2: Option<f64> = "C0 of it, rad/s^2",
    r2_heading: Option<f64> = "R^2 of heading on the best excited other manoeuvre of the same speed",
    r2_heading_offset_refit: Option<f64> = "The same with the offset estimated again",
    r2_yaw_rate: Option<f64> = "R^2 of yaw rate on it",
    accepted: Option<bool> = "May the model be used?",
    verdict: Option<String> = "Code of the first reason; `ok` where it may",
    reasons: Option<Vec<String>> = "Codes of all reasons",
    verdict_text: Option<String> = "The first reason for people",
    error: Option<String> = "Code of an error row; missing in every other",
    error_text: Option<String> = "What is wrong with the log and what to do",
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_every_column_is_in_the_docs() {
        let docs = include_str!("../../../../docs/fleet.md");
        for Column { name, meaning, .. } in COLUMNS {
            let line = format!("| `{name}` | {meaning} |");
            assert!(docs.contains(&line), "{line}");
        }
    }
}

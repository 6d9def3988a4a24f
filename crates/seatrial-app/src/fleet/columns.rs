//! The columns of the Parquet file.

use super::Row;

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

/// A column.
#[derive(Clone, Copy)]
pub struct Column {
    /// Its name, with its unit.
    pub name: &'static str,
    /// What it holds.
    pub meaning: &'static str,
    pub(super) value: fn(&Row) -> Value<'_>,
}

const fn column(name: &'static str, meaning: &'static str, value: fn(&Row) -> Value<'_>) -> Column {
    Column {
        name,
        meaning,
        value,
    }
}

/// Every column, in order.
pub const COLUMNS: [Column; 46] = [
    column("source", "The log, as it was found", |r| {
        Value::Text(Some(&r.source))
    }),
    column("run", "The run within the log, with `--run-column`", |r| {
        Value::Text(r.run.as_deref())
    }),
    column("format", "Format of the log", |r| {
        Value::Text(r.format.as_deref())
    }),
    column("bytes", "Length of the log, bytes", |r| {
        Value::Integer(Some(r.bytes))
    }),
    column("modified", "When the log was last written", |r| {
        Value::Time(r.modified)
    }),
    column("etag", "Version of the log in its object store", |r| {
        Value::Text(r.etag.as_deref())
    }),
    column(
        "sha256",
        "SHA-256 of the log; of a file of many runs missing",
        |r| Value::Text(r.sha256.as_deref()),
    ),
    column(
        "start",
        "Second 0 of the log, where it has an epoch or calendar time",
        |r| Value::Time(r.start),
    ),
    column("samples_read", "Samples of the log or run", |r| {
        Value::Integer(r.samples_read)
    }),
    column(
        "rows_left_out",
        "Rows of the log or run that are no samples",
        |r| Value::Integer(r.rows_left_out),
    ),
    column(
        "rudder_unit",
        "`rad`, or `full_rudder` where 1 is full rudder",
        |r| Value::Text(r.rudder_unit.as_deref()),
    ),
    column(
        "warnings",
        "What was assumed of the log or is doubtful in it",
        |r| Value::Texts(r.warnings.as_deref()),
    ),
    column(
        "manoeuvre",
        "`doublet`, `multistep` or `zig_zag`; `record` of a log or run that was taken as a whole",
        |r| Value::Text(r.manoeuvre.as_deref()),
    ),
    column(
        "from_s",
        "Start of the training window, s of the log",
        |r| Value::Number(r.from_s),
    ),
    column("to_s", "End of the training window, s of the log", |r| {
        Value::Number(r.to_s)
    }),
    column("thrust", "Mean thrust, a fraction of full", |r| {
        Value::Number(r.thrust)
    }),
    column("surge_speed_m_s", "Mean forward speed, m/s", |r| {
        Value::Number(r.surge_speed_m_s)
    }),
    column(
        "rudder_amplitude_rad",
        "How far the rudder was deflected to either side, rad",
        |r| Value::Number(r.rudder_amplitude_rad),
    ),
    column(
        "samples_used",
        "Samples that the estimate learnt from",
        |r| Value::Integer(r.samples_used),
    ),
    column("samples_rejected", "Samples that the guard rejected", |r| {
        Value::Integer(r.samples_rejected)
    }),
    column(
        "lambda_rad_s",
        "Pole of the state variable filter, rad/s",
        |r| Value::Number(r.lambda_rad_s),
    ),
    column("method", "The estimator whose model is reported", |r| {
        Value::Text(r.method.as_deref())
    }),
    column("a22_per_s", "Rotational damping a22, 1/s", |r| {
        Value::Number(r.a22_per_s)
    }),
    column("b2_per_s2", "Rudder authority b2, 1/s^2", |r| {
        Value::Number(r.b2_per_s2)
    }),
    column(
        "c0_rad_per_s2",
        "Yaw acceleration at neutral rudder C0, rad/s^2",
        |r| Value::Number(r.c0_rad_per_s2),
    ),
    column(
        "delta0_rad",
        "C0/b2, rad; the rudder that holds a constant heading is its negative",
        |r| Value::Number(r.delta0_rad),
    ),
    column(
        "a22_low_per_s",
        "Lower end of the 95 % interval of a22, 1/s",
        |r| Value::Number(r.a22_low_per_s),
    ),
    column("a22_high_per_s", "Upper end", |r| {
        Value::Number(r.a22_high_per_s)
    }),
    column(
        "b2_low_per_s2",
        "Lower end of the 95 % interval of b2, 1/s^2",
        |r| Value::Number(r.b2_low_per_s2),
    ),
    column("b2_high_per_s2", "Upper end", |r| {
        Value::Number(r.b2_high_per_s2)
    }),
    column(
        "c0_low_rad_per_s2",
        "Lower end of the 95 % interval of C0, rad/s^2",
        |r| Value::Number(r.c0_low_rad_per_s2),
    ),
    column("c0_high_rad_per_s2", "Upper end", |r| {
        Value::Number(r.c0_high_rad_per_s2)
    }),
    column("nomoto_t_s", "Nomoto's time constant T, s", |r| {
        Value::Number(r.nomoto_t_s)
    }),
    column("nomoto_k_per_s", "Nomoto's gain K, 1/s", |r| {
        Value::Number(r.nomoto_k_per_s)
    }),
    column(
        "online_a22_per_s",
        "a22 of the estimator that runs on the vehicle, 1/s",
        |r| Value::Number(r.online_a22_per_s),
    ),
    column("online_b2_per_s2", "b2 of it, 1/s^2", |r| {
        Value::Number(r.online_b2_per_s2)
    }),
    column("online_c0_rad_per_s2", "C0 of it, rad/s^2", |r| {
        Value::Number(r.online_c0_rad_per_s2)
    }),
    column(
        "r2_heading",
        "R^2 of heading on the best excited other manoeuvre of the same speed",
        |r| Value::Number(r.r2_heading),
    ),
    column(
        "r2_heading_offset_refit",
        "The same with the offset estimated again",
        |r| Value::Number(r.r2_heading_offset_refit),
    ),
    column("r2_yaw_rate", "R^2 of yaw rate on it", |r| {
        Value::Number(r.r2_yaw_rate)
    }),
    column("accepted", "May the model be used?", |r| {
        Value::Bool(r.accepted)
    }),
    column(
        "verdict",
        "Code of the first reason; `ok` where it may",
        |r| Value::Text(r.verdict.as_deref()),
    ),
    column("reasons", "Codes of all reasons", |r| {
        Value::Texts(r.reasons.as_deref())
    }),
    column("verdict_text", "The first reason for people", |r| {
        Value::Text(r.verdict_text.as_deref())
    }),
    column(
        "error",
        "Code of an error row; missing in every other",
        |r| Value::Text(r.error.as_deref()),
    ),
    column(
        "error_text",
        "What is wrong with the log and what to do",
        |r| Value::Text(r.error_text.as_deref()),
    ),
];

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

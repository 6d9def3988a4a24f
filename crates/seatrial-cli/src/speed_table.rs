//! One line of a table for each speed: the model, its bounds, its gain and its verdict.

use seatrial::campaign::{Campaign, Run};
use seatrial::identification::{Identification, Intervals, Outcome, Verdict};
use seatrial::words::{bounds_text, decimals_of, r2_text, three_figures, with_decimals, within};
use seatrial_core::RudderUnit;
use seatrial_report::promises;

use crate::screen::labelled;
use crate::table::Table;

/// What is shown of one speed. The numbers of a model are shown where it may be used or was only not validated.
pub type SpeedRow<'a> = seatrial_report::LogModel<'a>;

/// The row of a run. `whole` is the verdict of its campaign.
pub fn run_row<'a>(campaign: &Campaign, run: &'a Run, whole: &Verdict) -> SpeedRow<'a> {
    SpeedRow::of_run(campaign, run, &run.verdict_within(whole))
}

/// A column: its heading, its unit and the cell of a row.
struct Column {
    name: &'static str,
    unit: &'static str,
    cell: fn(&SpeedRow) -> Option<String>,
}

const fn column(
    name: &'static str,
    unit: &'static str,
    cell: fn(&SpeedRow) -> Option<String>,
) -> Column {
    Column { name, unit, cell }
}

const THRUST: Column =
    column("thrust", "%", |row| row.thrust.map(|thrust| format!("{:.0}", 100.0 * thrust)));
const SPEED: Column =
    column("speed", "m/s", |row| row.surge_speed_m_s.map(|speed| with_decimals(speed, 2)));
const T: Column = column("T", "s", |row| Some(three_figures(model(row)?.nomoto?.t_s)));
const K: Column = column("K", "1/s", |row| Some(three_figures(model(row)?.nomoto?.k_per_s)));
const A22: Column = column("a22", "1/s", |row| bounds(row, |i| i.a22_per_s));
const B2: Column = column("b2", "1/s^2", |row| bounds(row, |i| i.b2_per_s2));
/// The moment that rights pitch.
const M: Column =
    column("m", "1/s^2", |row| Some(bounds_text(model(row)?.restoring?.interval_95_per_s2)));
const A22_ESTIMATE: Column = column("a22", "1/s", |row| {
    let value = model(row)?.model().a22_per_s;
    Some(estimate(value, intervals(row).map(|i| i.a22_per_s)))
});
const B2_ESTIMATE: Column = column("b2", "1/s^2", |row| {
    let value = model(row)?.model().b2_per_s2;
    Some(estimate(value, intervals(row).map(|i| i.b2_per_s2)))
});
const M_ESTIMATE: Column = column("m", "1/s^2", |row| {
    let m = model(row)?.restoring?;
    Some(estimate(m.refined_per_s2, Some(m.interval_95_per_s2)))
});
const C0: Column = column("C0", "deg/s^2", |row| {
    let interval = intervals(row).map(|i| i.c0_rad_per_s2);
    Some(in_degrees(model(row)?.model().c0_rad_per_s2, interval))
});
const R2: Column =
    column("R^2", "", |row| Some(r2_text(Some(model(row)?.validation?.judged_r2_heading()?))));
const OVERSHOOT: Column = column("overshoot", "deg", |row| Some(row.course_change?.range_text()));
const GAIN: Column = column("K_p", "", |row| Some(three_figures(row.gain()?)));
const VERDICT: Column = column("verdict", "", |row| Some(row.outcome.name().to_owned()));

/// Columns that of a single model stand in a line of their own.
const IN_OFFSET_LINE: [&str; 2] = [C0.name, R2.name];

/// Tables from the widest to the narrowest: the parameters of the model go first, its gain and its verdict never.
const LAYOUTS: [&[Column]; 6] = [
    &[THRUST, SPEED, T, K, OVERSHOOT, GAIN, A22_ESTIMATE, B2_ESTIMATE, C0, R2, VERDICT],
    &[THRUST, SPEED, T, K, OVERSHOOT, GAIN, A22, B2, VERDICT],
    &[THRUST, SPEED, T, K, OVERSHOOT, GAIN, VERDICT],
    &[THRUST, SPEED, T, K, GAIN, VERDICT],
    &[THRUST, T, K, GAIN, VERDICT],
    &[SPEED, GAIN, VERDICT],
];

/// Of pitch, which has no gain.
const PITCH_LAYOUTS: [&[Column]; 3] = [
    &[THRUST, SPEED, A22_ESTIMATE, M_ESTIMATE, B2_ESTIMATE, C0, R2, VERDICT],
    &[THRUST, SPEED, A22, M, B2, VERDICT],
    &[SPEED, A22, M, B2, VERDICT],
];

/// What the gains promise, a paragraph each.
pub fn promise_text(rows: &[SpeedRow], width: usize) -> String {
    let promises = promises(rows).into_iter();
    promises.map(|promise| labelled("", &promise, width)).collect()
}

/// The widest table that fits, and below it which columns are left out, or of a single model its offset and R^2. `None` where no row has
/// anything but its verdict. `unit` is that of the rudder.
pub fn speed_table(rows: &[SpeedRow], unit: RudderUnit, width: usize) -> Option<String> {
    let is_pitch = |row: &SpeedRow| row.identification.is_some_and(|i| i.restoring.is_some());
    let layouts: &[&[Column]] = match rows.iter().any(is_pitch) {
        true => &PITCH_LAYOUTS,
        false => &LAYOUTS,
    };
    let tables = || layouts.iter().map(|columns| table(columns, rows));
    rows.iter().any(is_shown).then(|| {
        let fits = |table: &Table| table.width() <= width;
        let at = tables().position(|table| fits(&table));
        let at = at.unwrap_or(layouts.len() - 1);
        let left_out: Vec<&str> = layouts[0]
            .iter()
            .filter(|column| layouts[at].iter().all(|shown| shown.name != column.name))
            .filter(|column| rows.iter().any(|row| (column.cell)(row).is_some()))
            .filter(|column| rows.len() > 1 || !IN_OFFSET_LINE.contains(&column.name))
            .map(|column| column.name)
            .collect();
        let note = match left_out.is_empty() {
            true => String::new(),
            false => labelled(
                "",
                &format!("On a wider screen, or with --json: {}.", left_out.join(", ")),
                width,
            ),
        };
        let offset = match rows {
            [only] => offset_text(only, unit),
            _ => None,
        };
        let offset = offset.map_or(String::new(), |offset| labelled("", &offset, width));
        table(layouts[at], rows).to_string() + &note + &offset
    })
}

/// A table of these columns, without those that no row has.
fn table(columns: &[Column], rows: &[SpeedRow]) -> Table {
    let is_shown = |column: &&Column| {
        (rows.len() > 1 || !IN_OFFSET_LINE.contains(&column.name))
            && rows.iter().any(|row| (column.cell)(row).is_some())
    };
    let columns: Vec<&Column> = columns.iter().filter(is_shown).collect();
    let heads: Vec<(&str, &str)> = columns.iter().map(|c| (c.name, c.unit)).collect();
    let mut table = Table::new(&heads);
    for row in rows {
        let cell = |column: &&Column| (column.cell)(row).unwrap_or_else(|| "-".into());
        table.row(columns.iter().map(cell).collect());
    }
    table
}

/// The model where its numbers may be read.
fn model<'a>(row: &SpeedRow<'a>) -> Option<&'a Identification> {
    row.identification.filter(|_| row.outcome != Outcome::DoNotUse)
}

fn intervals(row: &SpeedRow) -> Option<Intervals> {
    Some(model(row)?.refined.as_ref()?.interval_95)
}

fn bounds(row: &SpeedRow, of: fn(&Intervals) -> [f64; 2]) -> Option<String> {
    Some(bounds_text(of(&intervals(row)?)))
}

/// A value, then its bounds where they are known.
fn estimate(value: f64, interval: Option<[f64; 2]>) -> String {
    let value = within(value, interval);
    match interval {
        Some(interval) => format!("{value} ({})", bounds_text(interval)),
        None => value,
    }
}

fn is_shown(row: &SpeedRow) -> bool {
    row.thrust.is_some() || row.surge_speed_m_s.is_some() || model(row).is_some()
}

fn in_degrees(value_rad: f64, interval_rad: Option<[f64; 2]>) -> String {
    let interval = interval_rad.map(|bounds| bounds.map(f64::to_degrees));
    within(value_rad.to_degrees(), interval)
}

/// What stands below the table of one model: the offset, the neutral rudder and R^2, in one line.
fn offset_text(row: &SpeedRow, unit: RudderUnit) -> Option<String> {
    let identification = model(row)?;
    let model = identification.model();
    let interval = intervals(row);
    let mut parts = vec![format!(
        "C0 {} deg/s^2",
        in_degrees(model.c0_rad_per_s2, interval.map(|i| i.c0_rad_per_s2))
    )];
    parts.extend(model.delta0_rad().map(|delta0| {
        let interval = interval.and_then(|i| i.delta0_rad);
        match unit {
            RudderUnit::Rad => format!("delta0 {} deg", in_degrees(delta0, interval)),
            RudderUnit::FullRudder => format!(
                "delta0 {} of full rudder",
                interval.map_or_else(
                    || three_figures(delta0),
                    |i| with_decimals(delta0, decimals_of(i))
                )
            ),
        }
    }));
    let r2 = identification.validation.and_then(|v| v.judged_r2_heading());
    let angle = match identification.restoring {
        Some(_) => "pitch",
        None => "heading",
    };
    parts.extend(r2.map(|r2| format!("R^2 of {angle} {}", r2_text(Some(r2)))));
    Some(parts.join(", "))
}

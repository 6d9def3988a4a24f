//! The first rows of a log, on which units are inferred before the first sample is given.

use std::collections::{BTreeMap, VecDeque};

use crate::clock::{Clock, ClockFound};
use crate::description::UnitSource;
use crate::error::{Fault, Place, clipped};
use crate::infer::FirstRows;
use crate::matching::{Match, Matches};
use crate::table::{Cell, Table};
use crate::{Quantity, Unit};

/// Rows on which units are inferred before the first sample is given.
const LOOK_AHEAD_ROWS: usize = 20_000;

/// A row of the look-ahead; the cells stand in the order of the slots.
pub(crate) type Row = Result<(Place, Vec<Cell>), Fault>;

/// The first rows; ends behind a fault that ends reading.
pub(crate) fn look_ahead(table: &mut dyn Table, drop_invalid: bool) -> VecDeque<Row> {
    let mut rows = VecDeque::new();
    while rows.len() < LOOK_AHEAD_ROWS {
        let mut cells = Vec::new();
        match table.next_row(&mut cells) {
            Ok(None) => break,
            Ok(Some(place)) => rows.push_back(Ok((place, cells))),
            Err(fault) => {
                let goes_on = fault.is_in_one_row() && drop_invalid;
                rows.push_back(Err(fault));
                if !goes_on {
                    break;
                }
            }
        }
    }
    rows
}

/// An optional column of nothing but text is not what its name says.
pub(crate) fn leave_out_text(
    found: &mut Matches,
    rows: &mut VecDeque<Row>,
    columns: &[String],
    table: &mut dyn Table,
) {
    for position in (0..found.matches.len()).rev() {
        let Match { quantity, column, .. } = found.matches[position];
        let mut cells = rows
            .iter()
            .filter_map(|row| Some(&row.as_ref().ok()?.1[position]))
            .filter(|cell| **cell != Cell::Missing)
            .peekable();
        let is_text = cells.peek().is_some() && cells.all(|cell| !matches!(cell, Cell::Number(_)));
        if quantity.is_required() || !is_text {
            continue;
        }
        found.warnings.push(format!(
            "column `{}` is text and not read as {quantity}",
            clipped(&columns[column])
        ));
        found.matches.remove(position);
        table.leave_out(position);
        for (_, cells) in rows.iter_mut().flatten() {
            cells.remove(position);
        }
    }
}

/// The cells of the look-ahead at this position of its rows.
fn cells(rows: &VecDeque<Row>, position: usize) -> Vec<Cell> {
    rows.iter().filter_map(|row| Some(row.as_ref().ok()?.1[position].clone())).collect()
}

/// What units are inferred from.
fn first_rows(
    found: &Matches,
    rows: &VecDeque<Row>,
    time: &ClockFound,
    time_cells: &[Cell],
) -> FirstRows {
    let seconds = |cell: &Cell| time.clock.seconds(cell).unwrap_or(f64::NAN);
    let quantities = found.matches.iter().enumerate();
    FirstRows {
        time_s: time_cells.iter().map(seconds).collect(),
        values: quantities.map(|(i, m)| (m.quantity, numbers(&cells(rows, i)))).collect(),
    }
}

fn numbers(cells: &[Cell]) -> Vec<f64> {
    cells
        .iter()
        .map(|cell| match cell {
            Cell::Number(number) => *number,
            _ => f64::NAN,
        })
        .collect()
}

/// A unit taken from the values, whether they state it, and why.
pub(crate) type Inferred = (Unit, UnitSource, Option<String>);

/// The units that the values of the first rows tell.
pub(crate) struct InferredUnits {
    pub units: BTreeMap<Quantity, Inferred>,
    pub time: ClockFound,
    /// What people should know of the match and of these units.
    pub warnings: Vec<String>,
}

pub(crate) fn inferred_units(
    found: &mut Matches,
    rows: &VecDeque<Row>,
    columns: &[String],
) -> Result<InferredUnits, Fault> {
    let stated = found.stated_units();
    let time_cells = found
        .matches
        .iter()
        .position(|m| m.quantity == Quantity::Time)
        .map_or(Vec::new(), |position| cells(rows, position));
    let time = Clock::find(&time_cells, stated.get(&Quantity::Time).copied());
    let names = found.matches.iter().map(|m| (m.quantity, columns[m.column].clone())).collect();
    let inferred = first_rows(found, rows, &time, &time_cells).infer(&stated, &names)?;

    let mut warnings = std::mem::take(&mut found.warnings);
    warnings.extend(inferred.warnings);
    warnings.extend(time.doubt());
    let assumed =
        |(quantity, (unit, because))| (quantity, (unit, UnitSource::Assumed, Some(because)));
    let mut units: BTreeMap<Quantity, Inferred> = inferred.units.into_iter().map(assumed).collect();
    let of_time = (time.unit, time.source(), time.because.clone());
    units.insert(Quantity::Time, of_time);
    Ok(InferredUnits { units, time, warnings })
}

/// Why a table has no rows: damage, or a logger that was not running.
pub(crate) fn no_rows(table: &dyn Table) -> Fault {
    match table.is_damaged() {
        true => Fault::Damaged { format: "the", what: table.warnings().join("; ") },
        false => Fault::HeaderOnly,
    }
}

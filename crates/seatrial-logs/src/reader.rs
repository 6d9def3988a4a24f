//! From the rows of a log to samples in SI units.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use seatrial_core::{RudderUnit, Sample};

use crate::choice::ChannelChoice;
use crate::clock::{Clock, Face};
use crate::content::table;
use crate::description::{Channel, Counts, LogDescription};
use crate::error::{Fault, Place, ReadError, clipped};
use crate::input::FileMap;
use crate::look_ahead::{
    Inferred, InferredUnits, Row, inferred_units, leave_out_text, look_ahead, no_rows,
};
use crate::loose::{from_long, from_sparse, is_sparse};
use crate::matching::{Match, match_columns};
use crate::table::{Cell, Table};
use crate::track::Positions;
use crate::unit::{Conversion, Dimension, NEUTRAL_PULSE_US};
use crate::view::{wanted_rows, with_computed};
use crate::{Quantity, Unit};

/// So many damaged rows, and a quarter of the sound ones, are a fault of the column and not of rows.
const MANY_ROWS: u64 = 20;

/// The samples of a log, one by one.
pub struct LogReader {
    log: String,
    table: Box<dyn Table>,
    description: LogDescription,
    clock: Clock,
    face: Face,
    /// Seconds that a second of the column stands for: of a column that counts rows, the interval between them.
    time_scale: f64,
    drop_invalid: bool,
    look_ahead: VecDeque<Row>,
    cells: Vec<Cell>,
    previous: Option<Sample<f64>>,
    /// Of the sample before, where its integral is the heading.
    rate_rad_s: Option<f64>,
    half_differences: BTreeMap<Quantity, [String; 2]>,
    counts: Counts,
    is_finished: bool,
    positions: Option<Positions>,
}

/// Opens a log of any known format; `-` is standard input.
pub fn open(path: &Path, choice: &ChannelChoice) -> Result<LogReader, ReadError> {
    open_in(path, &FileMap::default(), choice)
}

/// [`open`] of a path that may be one of a file in memory.
pub fn open_in(path: &Path, map: &FileMap, choice: &ChannelChoice) -> Result<LogReader, ReadError> {
    let log = path.display().to_string();
    let mut reader = table(path, map, &choice.formats)
        .and_then(|table| LogReader::new(log.clone(), table, choice))
        .map_err(|fault| ReadError { log, fault })?;
    if let Some(track) = &choice.positions {
        let positions = Positions::open(track, map, reader.clock.start_unix_s());
        reader.positions =
            Some(positions.map_err(|fault| ReadError { log: track.display().to_string(), fault })?);
    }
    Ok(reader)
}

impl LogReader {
    pub(crate) fn new(
        log: String,
        table: Box<dyn Table>,
        choice: &ChannelChoice,
    ) -> Result<Self, Fault> {
        Self::of_table(log, table, choice, false)
    }

    /// What was put together from columns filled at different rates is read as it is, however few of its rows are filled.
    fn of_table(
        log: String,
        table: Box<dyn Table>,
        choice: &ChannelChoice,
        was_sparse: bool,
    ) -> Result<Self, Fault> {
        let table = wanted_rows(table, choice)?;
        let (table, choice) = from_long(table, choice.clone())?;
        let (mut table, choice) = with_computed(table, choice)?;
        let columns = table.columns().to_vec();
        let mut found = match_columns(&columns, &table.known(), &choice)?;
        table.select(&found.columns());
        let mut rows = look_ahead(&mut *table, choice.drop_invalid);
        if rows.is_empty() {
            return Err(no_rows(&*table));
        }
        leave_out_text(&mut found, &mut rows, &columns, &mut *table);
        if !was_sparse && table.known().is_empty() && is_sparse(&found, &rows) {
            let (table, choice) = from_sparse(table, &found, rows, choice)?;
            return Self::of_table(log, table, &choice, true);
        }

        let InferredUnits { units, time, mut warnings } =
            inferred_units(&mut found, &rows, &columns)?;
        let channels: Vec<Channel> = found
            .matches
            .iter()
            .map(|m| channel(m, &columns, &units, &choice, &mut warnings))
            .collect();
        Ok(Self {
            log,
            description: LogDescription {
                format: table.format(),
                columns,
                rudder_unit: rudder_unit(&channels, &choice),
                full_rudder_rad: choice.full_rudder_rad.filter(|_| is_of_servo(&channels)),
                channels,
                aircraft: table.aircraft().map(str::to_owned),
                firmware: table.firmware().map(str::to_owned),
                start_utc: time.clock.start(),
                warnings,
            },
            table,
            clock: time.clock,
            face: Face::default(),
            time_scale: time_scale(&choice),
            drop_invalid: choice.drop_invalid,
            look_ahead: rows,
            cells: Vec::new(),
            previous: None,
            rate_rad_s: None,
            half_differences: choice.half_differences,
            counts: Counts::default(),
            is_finished: false,
            positions: None,
        })
    }

    /// What the log is and how it is read.
    pub fn description(&self) -> &LogDescription {
        &self.description
    }

    /// The quantities that are half the difference of two columns, and those: as chosen, or two motors where nothing else is the rudder.
    pub fn half_differences(&self) -> &BTreeMap<Quantity, [String; 2]> {
        &self.half_differences
    }

    /// Latitude and longitude, deg, of north and east 0, where the log or its file of positions has them. Call it after the last sample.
    pub fn origin_deg(&self) -> Option<[f64; 2]> {
        match &self.positions {
            Some(positions) => Some(positions.origin_deg()),
            None => self.table.origin_deg(),
        }
    }

    /// Second 0 of the log in s since 1970, UTC, where its clock tells.
    pub fn start_unix_s(&self) -> Option<f64> {
        self.clock.start_unix_s()
    }

    /// Rows read and left out so far.
    pub fn counts(&self) -> Counts {
        Counts { is_damaged: self.table.is_damaged(), ..self.counts }
    }

    /// Bytes of the log consumed so far.
    pub fn bytes_read(&self) -> u64 {
        self.table.bytes_read()
    }

    /// SHA-256 of the whole log in hexadecimal. Call it after the last sample.
    pub fn sha256(&mut self) -> Result<String, ReadError> {
        self.table.sha256().map_err(|fault| ReadError { log: self.log.clone(), fault })
    }

    /// What was left out on the way. Call it after the last sample.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.table.warnings();
        warnings.extend(self.positions.as_ref().map(Positions::warning));
        warnings.extend(self.face.warning());
        let Counts { rows, missing, invalid, repeated_time, reversed_time, .. } = self.counts;
        for (count, what) in [
            (missing, "have no time, heading or rudder"),
            (invalid, "are invalid"),
            (repeated_time, "repeat the time of the row before"),
            (reversed_time, "go back in time"),
        ] {
            if count > 0 {
                warnings.push(format!("{count} of {rows} rows {what} and are left out"));
            }
        }
        warnings
    }

    fn next_row(&mut self) -> Result<Option<Place>, Fault> {
        let Some(row) = self.look_ahead.pop_front() else {
            return self.table.next_row(&mut self.cells);
        };
        let (place, cells) = row?;
        self.cells = cells;
        Ok(Some(place))
    }

    /// The sample of the next row; `Some(None)` where the row is left out.
    fn next_sample(&mut self) -> Result<Option<Option<Sample<f64>>>, Fault> {
        let Some(place) = self.next_row()? else {
            return Ok(None);
        };
        let Some(sample) = self.sample(place)? else {
            self.counts.missing += 1;
            return Ok(Some(None));
        };
        match self.previous {
            Some(before) if sample.time_s == before.time_s => {
                let is_same = sample.heading_rad == before.heading_rad
                    && sample.rudder_rad == before.rudder_rad;
                self.counts.repeated_time += 1;
                self.counts.differing_at_a_time += u64::from(!is_same);
                Ok(Some(None))
            }
            Some(before) if sample.time_s < before.time_s => Err(Fault::TimeReversed {
                place,
                column: self.column(Quantity::Time),
                before: before.time_s,
                after: sample.time_s,
            }),
            before => {
                let sample = match self.heading_is_a_rate() {
                    true => self.integrated(before, sample),
                    false => sample,
                };
                self.previous = Some(sample);
                Ok(Some(Some(sample)))
            }
        }
    }

    /// Is the integral of the yaw rate taken for the heading?
    fn heading_is_a_rate(&self) -> bool {
        let channels = self.description.channels.iter();
        channels
            .filter(|channel| channel.quantity == Quantity::Heading)
            .any(|channel| channel.unit.dimension() == Dimension::AngularRate)
    }

    /// A sample whose heading is the integral of the yaw rate that stands in its place; 0 at the first.
    fn integrated(&mut self, before: Option<Sample<f64>>, mut sample: Sample<f64>) -> Sample<f64> {
        let rate_rad_s = sample.heading_rad;
        let rates = self.rate_rad_s.replace(rate_rad_s).unwrap_or(rate_rad_s) + rate_rad_s;
        sample.heading_rad = before.map_or(0.0, |before| {
            before.heading_rad + 0.5 * rates * (sample.time_s - before.time_s)
        });
        sample
    }

    /// The row's sample, `None` where time, heading or rudder is missing.
    fn sample(&mut self, place: Place) -> Result<Option<Sample<f64>>, Fault> {
        let mut sample = Sample::default();
        for (channel, cell) in self.description.channels.iter().zip(&self.cells) {
            let quantity = channel.quantity;
            let column = || clipped(&channel.column);
            let value = match (quantity, cell) {
                (_, Cell::Missing) => None,
                (Quantity::Time, cell) => {
                    let time_s = self.clock.seconds(cell).ok_or_else(|| Fault::NotANumber {
                        place,
                        column: column(),
                        found: cell.to_string(),
                        expected: self.clock.expected(),
                    })?;
                    Some(self.time_scale * self.face.on(&self.clock, time_s))
                }
                (_, Cell::Number(value)) => {
                    channel.check(*value, place)?;
                    Some((value - channel.offset) * channel.scale)
                }
                (_, cell) => {
                    return Err(Fault::NotANumber {
                        place,
                        column: column(),
                        found: cell.to_string(),
                        expected: "a number",
                    });
                }
            };
            let finite = value.filter(|value| value.is_finite());
            match (finite, value) {
                (None, Some(found)) if quantity.is_required() => {
                    return Err(Fault::NotFinite { place, column: column(), found });
                }
                (None, None) if quantity.is_required() => return Ok(None),
                _ => set(&mut sample, quantity, finite),
            }
        }
        if let Some(positions) = &mut self.positions {
            positions.place(&mut sample);
        }
        Ok(Some(sample))
    }

    /// The fault of a row, with the count of damaged rows behind it.
    fn with_others(&mut self, first: Fault) -> Fault {
        let (mut others, mut sound) = (0, self.counts.samples);
        loop {
            match self.next_sample() {
                Ok(Some(_)) => sound += 1,
                Err(fault) if fault.is_in_one_row() => others += 1,
                Ok(None) | Err(_) => break,
            }
        }
        match others {
            0 => first,
            others if first.is_of_a_cell() && others >= MANY_ROWS && others > sound / 4 => {
                Fault::ManyRows {
                    first: Box::new(first),
                    damaged: others + 1,
                    rows: sound + others + 1,
                }
            }
            others => Fault::SeveralRows { first: Box::new(first), others },
        }
    }

    fn column(&self, quantity: Quantity) -> String {
        let channel = self.description.channels.iter();
        channel
            .filter(|channel| channel.quantity == quantity)
            .map(|channel| clipped(&channel.column))
            .collect()
    }
}

impl Iterator for LogReader {
    type Item = Result<Sample<f64>, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.is_finished {
            let fault = match self.next_sample() {
                Ok(None) if self.counts.samples == 0 => Fault::NoSamples { rows: self.counts.rows },
                Ok(None) => break,
                Ok(Some(sample)) => {
                    self.counts.rows += 1;
                    let Some(sample) = sample else { continue };
                    self.counts.samples += 1;
                    return Some(Ok(sample));
                }
                Err(fault) if fault.is_in_one_row() && self.drop_invalid => {
                    self.counts.rows += 1;
                    match fault {
                        Fault::TimeReversed { .. } => self.counts.reversed_time += 1,
                        _ => self.counts.invalid += 1,
                    }
                    continue;
                }
                Err(fault) if fault.is_in_one_row() => self.with_others(fault),
                Err(fault) => fault,
            };
            self.is_finished = true;
            return Some(Err(ReadError { log: self.log.clone(), fault }));
        }
        self.is_finished = true;
        None
    }
}

/// Seconds for a second of the column.
fn time_scale(choice: &ChannelChoice) -> f64 {
    let correction = choice.corrections.get(&Quantity::Time);
    correction.map_or(1.0, |correction| correction.scale)
}

/// How a matched column is read.
fn channel(
    found: &Match,
    columns: &[String],
    inferred: &BTreeMap<Quantity, Inferred>,
    choice: &ChannelChoice,
    warnings: &mut Vec<String>,
) -> Channel {
    let quantity = found.quantity;
    let (unit, unit_source, because) = match (found.unit, inferred.get(&quantity)) {
        (Some((unit, source)), _) => (unit, source, found.because.clone()),
        (None, Some((unit, source, because))) => (*unit, *source, because.clone()),
        (None, None) => unreachable!("every unit that is not stated is inferred"),
    };
    let conversion = conversion(quantity, unit, choice, warnings);
    Channel {
        quantity,
        column: columns[found.column].clone(),
        unit,
        unit_source,
        against: found.against,
        because,
        scale: conversion.factor,
        offset: conversion.offset,
    }
}

fn conversion(
    quantity: Quantity,
    unit: Unit,
    choice: &ChannelChoice,
    warnings: &mut Vec<String>,
) -> Conversion {
    let correction = choice.corrections.get(&quantity);
    let scale = correction.map_or(1.0, |correction| correction.scale);
    let offset = correction.and_then(|correction| correction.offset);
    let plain = Conversion { offset: offset.unwrap_or(0.0), factor: unit.factor() * scale };
    if quantity != Quantity::Rudder || unit.dimension() != Dimension::Steering {
        return plain;
    }
    if choice.full_rudder_rad.is_none() {
        let full = match unit {
            Unit::PulseWidth => "the angle 400 us from the trim",
            _ => "the angle of full rudder",
        };
        warnings.push(format!(
            "rudder is in {unit} and its angle is not known: 1 stands for full rudder, and b2, K and gains are per full rudder; give {full} with --rudder-range-deg DEG"
        ));
    }
    Conversion {
        offset: match (offset, unit) {
            (Some(offset), _) => offset,
            // The trims of two outputs cancel.
            (None, Unit::PulseWidth) if !choice.is_a_difference(quantity) => {
                choice.rudder_trim.unwrap_or(NEUTRAL_PULSE_US)
            }
            (None, _) => 0.0,
        },
        factor: plain.factor * choice.full_rudder_rad.unwrap_or(1.0),
    }
}

/// A rudder in a servo's unit is an angle only where the full angle is given.
fn rudder_unit(channels: &[Channel], choice: &ChannelChoice) -> RudderUnit {
    match is_of_servo(channels) && choice.full_rudder_rad.is_none() {
        true => RudderUnit::FullRudder,
        false => RudderUnit::Rad,
    }
}

/// Is the rudder in a servo's unit?
fn is_of_servo(channels: &[Channel]) -> bool {
    channels.iter().any(|channel| {
        channel.quantity == Quantity::Rudder && channel.unit.dimension() == Dimension::Steering
    })
}

fn set(sample: &mut Sample<f64>, quantity: Quantity, value: Option<f64>) {
    match (quantity, value) {
        (Quantity::Time, Some(value)) => sample.time_s = value,
        (Quantity::Heading, Some(value)) => sample.heading_rad = value,
        (Quantity::Rudder, Some(value)) => sample.rudder_rad = value,
        (Quantity::Time | Quantity::Heading | Quantity::Rudder, None) => {}
        (Quantity::Speed, value) => sample.surge_speed_m_s = value,
        (Quantity::Depth, value) => sample.depth_m = value,
        (Quantity::Altitude, value) => sample.altitude_m = value,
        (Quantity::Roll, value) => sample.roll_rad = value,
        (Quantity::Pitch, value) => sample.pitch_rad = value,
        (Quantity::YawRate, value) => sample.yaw_rate_rad_s = value,
        (Quantity::North, value) => sample.north_m = value,
        (Quantity::East, value) => sample.east_m = value,
        (Quantity::Thrust, value) => sample.thrust = value,
    }
}

//! Logs as every use case reads them: any format, channels mapped, units settled, behind the servo.

mod headings;
mod mapping;
mod most_excited;
mod motors;
mod source;
mod stated_units;

use std::path::{Path, PathBuf};

use seatrial::identification::Reader;
use seatrial::identify::Proposal;
use seatrial::log::{InvalidServo, Servo, leave_out_unsound};
use seatrial::{Record, Window};
use seatrial_core::{Axis, RudderUnit, Sample};
use seatrial_logs::{
    ChannelChoice, Counts, FileMap, LogDescription, Quantity, TrackFormat, write_track,
};

use crate::Error;
use crate::advice::addressed;
pub use headings::OtherHeading;
use mapping::Mapping;
use most_excited::MostExcited;
pub use motors::MirroredMotor;
pub use source::Source;
pub(crate) use stated_units::stated_units;

/// Samples between two reports of progress.
const SAMPLES_A_REPORT: u64 = 1 << 16;

/// How a log is read. Everything has a default.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadSettings {
    /// TOML file whose section `channels` says which column, topic or field is which quantity, in which unit, scaled
    /// and turned how; `channels` goes before it.
    pub channels_file: Option<PathBuf>,
    /// Which columns are read, and in which units.
    pub channels: ChannelChoice,
    /// Files in memory, by the paths that logs are opened by.
    pub held: FileMap,
    /// The servo between the logged command and the rudder: the model is then the one behind it.
    pub servo: Option<Servo>,
    /// Who reads what is said of the log.
    pub reader: Reader,
}

impl ReadSettings {
    /// For logs of this axis. Those of pitch have the columns `pitch_rad` and `elevator_rad`, where no others are named.
    pub fn on_axis(&self, axis: Axis) -> Self {
        let mut reading = self.clone();
        if axis == Axis::Pitch {
            let columns = &mut reading.channels.columns;
            for (quantity, column) in [
                (Quantity::Heading, "pitch_rad"),
                (Quantity::Rudder, "elevator_rad"),
                // Its column is read as the heading.
                (Quantity::Pitch, "none"),
            ] {
                columns.entry(quantity).or_insert_with(|| column.into());
            }
        }
        reading
    }
}

/// Receives reports while a log is read and identified.
pub trait Observer {
    /// A log was opened: which channels are read in which units.
    fn opened(&mut self, _path: &Path, _description: &LogDescription, _servo: Option<Servo>) {}
    /// This many bytes of it have been read.
    fn read(&mut self, _bytes: u64) {}
    /// It has been read to its end.
    fn finished(&mut self) {}
    /// What people should know before they trust the samples.
    fn warned(&mut self, _warning: &str) {}
    /// Manoeuvres of one speed were found, and are identified next.
    fn found(&mut self, _path: &Path, _proposal: &Proposal) {}
}

/// Takes no reports.
#[derive(Clone, Copy, Debug)]
pub struct NoObserver;

impl Observer for NoObserver {}

/// A log in memory, and where it came from.
#[derive(Clone, Debug)]
pub struct OpenedLog {
    /// Where it lies, or the name that it goes by.
    pub path: PathBuf,
    /// The samples kept, in the order of time. Its `rudder_unit` says whether their rudder is an angle.
    pub record: Record,
    /// What the log is and how it was read.
    pub description: LogDescription,
    /// The servo that was given: the record's rudder is the one behind it.
    pub servo: Option<Servo>,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Rows read and left out.
    pub counts: Counts,
    /// What people should know before they trust the samples.
    pub warnings: Vec<String>,
    /// A heading that the log has beside the one that was read.
    pub other_heading: Option<OtherHeading>,
    /// One of two motors that counts the other way, where their half difference stands still.
    pub mirrored_motor: Option<MirroredMotor>,
    /// The latitude and longitude from which north and east are, deg, where the log has them.
    pub origin_deg: Option<[f64; 2]>,
}

impl OpenedLog {
    /// The track in a form that charts open; `None` where latitude and longitude are not known.
    pub fn track(&self, format: TrackFormat) -> Option<String> {
        let start_utc = self.description.start_utc.as_deref();
        write_track(format, &self.record.samples, self.origin_deg?, start_utc)
    }

    /// In what the rudder is: radians, or fractions of a full rudder whose angle is not known.
    pub fn rudder_unit(&self) -> RudderUnit {
        self.record.rudder_unit
    }

    /// The log as documents show it.
    pub fn source(&self) -> Source {
        Source {
            path: self.path.display().to_string(),
            sha256: self.sha256.clone(),
            samples_read: self.counts.samples,
            median_interval_s: self.record.median_interval_s(),
            rudder_unit: self.rudder_unit(),
            servo: self.servo,
            description: LogDescription {
                warnings: self.warnings.clone(),
                ..self.description.clone()
            },
            rows: self.counts,
        }
    }
}

impl ReadSettings {
    /// Columns and units, those of the file included.
    pub fn choice(&self) -> Result<ChannelChoice, Error> {
        Ok(self.mapping()?.under(self.channels.clone()))
    }

    fn mapping(&self) -> Result<Mapping, Error> {
        above_zero("full_rudder_rad", self.channels.full_rudder_rad)?;
        above_zero("rudder_trim", self.channels.rudder_trim)?;
        match &self.channels_file {
            Some(path) => Mapping::read(path),
            None => Ok(Mapping::default()),
        }
    }
}

/// Refuses a number that is given, by the name that it has there, and is not above 0.
pub fn above_zero(name: &str, value: Option<f64>) -> Result<(), Error> {
    match value.filter(|value| !value.is_finite() || *value <= 0.0) {
        Some(value) => Err(Error::Setting(format!("{name} {value}: expected a number above 0"))),
        None => Ok(()),
    }
}

/// The servo of the delay and the lag that are given, if any, s.
pub fn servo_of(delay_s: Option<f64>, lag_s: Option<f64>) -> Result<Option<Servo>, InvalidServo> {
    let servo = Servo::new(delay_s.unwrap_or(0.0), lag_s.unwrap_or(0.0))?;
    Ok(delay_s.or(lag_s).map(|_| servo))
}

/// Reads a log: every sample inside `keep`, or all; of a log with more than 500,000 the segment in which the rudder
/// varies most.
///
/// # Errors
/// A log that cannot be read, or a column or unit that it does not have: where, what was found and what to do.
pub fn open(
    path: &Path,
    settings: &ReadSettings,
    keep: Option<Window>,
    observer: &mut dyn Observer,
) -> Result<OpenedLog, Error> {
    let mapping = settings.mapping()?;
    let mut choice = mapping.under(settings.channels.clone());
    let mut reader = seatrial_logs::open_in(path, &settings.held, &choice)
        .map_err(|error| mapping.error_of(error))?;
    choice.half_differences = reader.half_differences().clone();
    let servo = settings.servo;
    observer.opened(path, reader.description(), servo);
    let mut warnings = told(&reader.description().warnings, settings.reader, observer);

    let keep = keep.unwrap_or(Window::ALL);
    let mut segment = MostExcited::default();
    let (mut samples_read, mut samples_inside) = (0_u64, 0_u64);
    while let Some(sample) = reader.next() {
        let sample = sample?;
        if keep.contains(sample.time_s) {
            samples_inside += 1;
            segment.push(sample);
        }
        samples_read += 1;
        if samples_read.is_multiple_of(SAMPLES_A_REPORT) {
            observer.read(reader.bytes_read());
        }
    }
    observer.finished();
    let sha256 = reader.sha256()?;
    let mut record = match servo {
        Some(servo) => servo.behind(&segment.into_record()),
        None => segment.into_record(),
    };
    record.rudder_unit = reader.description().rudder_unit;
    record.units = stated_units(reader.description(), &reader.counts());

    let mut late = reader.warnings();
    late.extend(shortened(&record, samples_inside));
    let other_heading = OtherHeading::find(path, settings, reader.description(), &record.samples);
    late.extend(other_heading.as_ref().map(OtherHeading::warning));
    let mirrored_motor = MirroredMotor::find(path, settings, &choice, &record.samples);
    leave_out_unsound(&mut record);
    warnings.extend(told(&late, settings.reader, observer));
    Ok(OpenedLog {
        path: path.to_path_buf(),
        record,
        servo,
        description: reader.description().clone(),
        sha256,
        counts: reader.counts(),
        origin_deg: reader.origin_deg(),
        warnings,
        other_heading,
        mirrored_motor,
    })
}

/// Warnings in the words of a reader, told to an observer.
fn told(warnings: &[String], reader: Reader, observer: &mut dyn Observer) -> Vec<String> {
    let warnings = warnings.iter().map(|text| addressed(text, reader));
    warnings.inspect(|text| observer.warned(text)).collect()
}

/// Reads what is inside `keep`, or, to be able to say what the log has instead, all of it.
pub fn open_inside(
    path: &Path,
    settings: &ReadSettings,
    keep: Window,
    observer: &mut dyn Observer,
) -> Result<OpenedLog, Error> {
    let opened = open(path, settings, Some(keep), observer)?;
    if opened.record.samples.is_empty() && keep != Window::ALL {
        return open(path, settings, None, observer);
    }
    Ok(opened)
}

fn shortened(record: &Record, samples_inside: u64) -> Option<String> {
    match record.samples.as_slice() {
        [first, .., last] if (record.samples.len() as u64) < samples_inside => Some(format!(
            "of {samples_inside} samples the {} in which the rudder varies most are kept, from {} s to {} s; choose others with a window of time",
            record.samples.len(),
            first.time_s,
            last.time_s
        )),
        _ => None,
    }
}

/// The samples of a log in the time of those that were read, read by another choice of columns. `None` of what cannot be read so, and of a pipe,
/// which is read once.
fn read_again(
    path: &Path,
    settings: &ReadSettings,
    choice: &ChannelChoice,
    samples: &[Sample<f64>],
) -> Option<Vec<Sample<f64>>> {
    if path == Path::new("-") {
        return None;
    }
    let kept = Window { from_s: samples.first()?.time_s, to_s: samples.last()?.time_s };
    let rows = seatrial_logs::open_in(path, &settings.held, choice).ok()?;
    let rows = rows.filter_map(Result::ok);
    Some(rows.filter(|s| kept.contains(s.time_s)).collect())
}

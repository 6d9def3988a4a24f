//! Logs as every verb reads them: the options, the samples that are kept, what is said about them.

use std::collections::{BTreeMap, VecDeque};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use seatrial::servo::Servo;
use seatrial::{Record, Window};
use seatrial_core::RudderUnit;
use seatrial_core::Sample;
use seatrial_logs::{ChannelChoice, Counts, LogDescription, LogReader, Quantity, Unit, UnitSource};
use serde::Serialize;

use crate::channels::Mapping;
use crate::output::Failure;

/// The most samples that are kept of a log: 84 MB.
const MOST_SAMPLES: usize = 500_000;
/// Samples that are kept or left out together.
const CHUNK_SAMPLES: usize = 50_000;

/// A log and how to read it.
#[derive(Args, Debug)]
pub struct LogArgs {
    /// The log, whatever its format: that is found by its content; `-` is standard input.
    pub log: PathBuf,
    #[command(flatten)]
    pub channels: ChannelArgs,
}

/// Which columns of a log are read, and in which units. Everything has a default.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Reading the log")]
pub struct ChannelArgs {
    /// Column with the time.
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// Column with the heading.
    #[arg(long, value_name = "COLUMN")]
    pub heading: Option<String>,
    /// Column with the rudder: measured angle, command, PWM or percent.
    #[arg(long, value_name = "COLUMN")]
    pub rudder: Option<String>,
    /// Column with the forward speed; `none` leaves it out, as for all that follow.
    #[arg(long, value_name = "COLUMN")]
    pub speed: Option<String>,
    /// Column with the depth.
    #[arg(long, value_name = "COLUMN")]
    pub depth: Option<String>,
    /// Column with the height above the bottom.
    #[arg(long, value_name = "COLUMN")]
    pub altitude: Option<String>,
    /// Column with the roll angle.
    #[arg(long, value_name = "COLUMN")]
    pub roll: Option<String>,
    /// Column with the pitch angle.
    #[arg(long, value_name = "COLUMN")]
    pub pitch: Option<String>,
    /// Column with the measured yaw rate.
    #[arg(long, value_name = "COLUMN")]
    pub yaw_rate: Option<String>,
    /// Column with the position north.
    #[arg(long, value_name = "COLUMN")]
    pub north: Option<String>,
    /// Column with the position east.
    #[arg(long, value_name = "COLUMN")]
    pub east: Option<String>,
    /// Column with the thrust that is asked for.
    #[arg(long, value_name = "COLUMN")]
    pub thrust: Option<String>,
    /// TOML file whose section `channels` says which column, topic or field is which quantity, in which unit,
    /// scaled and turned how; the options here go before it.
    #[arg(long = "channels", value_name = "FILE")]
    pub mapping: Option<PathBuf>,
    /// Unit of a quantity's column, as in `heading=deg` or `rudder=pwm`; repeatable.
    #[arg(long = "unit", value_name = "QUANTITY=UNIT", value_parser = quantity_and_unit)]
    pub units: Vec<(Quantity, Unit)>,
    /// Pulse width of the neutral rudder [default: 1500].
    #[arg(long, value_name = "US")]
    pub rudder_trim: Option<f64>,
    /// Rudder angle at full deflection: 400 us from the trim, 100 % or fraction 1.
    #[arg(long, value_name = "DEG")]
    pub rudder_range_deg: Option<f64>,
    /// Dead time of the rudder behind the logged command.
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub rudder_delay: f64,
    /// Time constant with which the rudder follows the logged command: the model is then the one behind the servo.
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub rudder_lag: f64,
    /// Leave rows with text, NaN, missing cells or reversed time out instead of refusing the log.
    #[arg(long)]
    pub drop_invalid: bool,
}

/// `heading=deg`.
pub fn quantity_and_unit(text: &str) -> Result<(Quantity, Unit), String> {
    let (quantity, unit) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}`: expected QUANTITY=UNIT, such as heading=deg"))?;
    Ok((quantity.parse()?, unit.parse()?))
}

impl ChannelArgs {
    fn mapping(&self) -> Result<Mapping, Failure> {
        match &self.mapping {
            Some(path) => Mapping::read(path),
            None => Ok(Mapping::default()),
        }
    }

    /// What these options and their file choose.
    pub fn chosen(&self) -> Result<ChannelChoice, Failure> {
        if self.servo()?.is_some() {
            return Err(Failure::usage(
                "--rudder-delay and --rudder-lag are for one log; of many, identify estimates the lag",
            ));
        }
        Ok(self.mapping()?.under(self.choice()?))
    }

    /// The servo that is given, if any.
    fn servo(&self) -> Result<Option<Servo>, Failure> {
        let servo = Servo::new(self.rudder_delay, self.rudder_lag)
            .map_err(|invalid| Failure::usage(format!("--rudder-{invalid}")))?;
        Ok((self.rudder_delay > 0.0 || self.rudder_lag > 0.0).then_some(servo))
    }

    fn choice(&self) -> Result<ChannelChoice, Failure> {
        for (option, value) in [
            ("--rudder-range-deg", self.rudder_range_deg),
            ("--rudder-trim", self.rudder_trim),
        ] {
            if let Some(value) = value.filter(|value| !value.is_finite() || *value <= 0.0) {
                return Err(Failure::usage(format!(
                    "{option} {value}: expected a number above 0"
                )));
            }
        }
        let columns = [
            (Quantity::Time, &self.time),
            (Quantity::Heading, &self.heading),
            (Quantity::Rudder, &self.rudder),
            (Quantity::Speed, &self.speed),
            (Quantity::Depth, &self.depth),
            (Quantity::Altitude, &self.altitude),
            (Quantity::Roll, &self.roll),
            (Quantity::Pitch, &self.pitch),
            (Quantity::YawRate, &self.yaw_rate),
            (Quantity::North, &self.north),
            (Quantity::East, &self.east),
            (Quantity::Thrust, &self.thrust),
        ]
        .into_iter()
        .filter_map(|(quantity, column)| Some((quantity, column.clone()?)))
        .collect::<BTreeMap<_, _>>();
        Ok(ChannelChoice {
            columns,
            units: self.units.iter().copied().collect(),
            rudder_trim: self.rudder_trim,
            full_rudder_rad: self.rudder_range_deg.map(f64::to_radians),
            drop_invalid: self.drop_invalid,
            ..ChannelChoice::default()
        })
    }
}

/// A log in memory, and where it came from.
pub struct OpenedLog {
    /// As given on the command line.
    pub path: PathBuf,
    /// The samples kept, in the order of time.
    pub record: Record,
    /// What the log is and how it was read.
    pub description: LogDescription,
    /// In what the rudder is.
    pub rudder_unit: RudderUnit,
    /// The servo that was given: the record's rudder is the one behind it.
    pub servo: Option<Servo>,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Rows read and left out.
    pub counts: Counts,
    /// Everything that was also said on standard error.
    pub warnings: Vec<String>,
}

/// `source` in the JSON of every verb that reads a log.
#[derive(Clone, Debug, Serialize)]
pub struct Source {
    path: String,
    sha256: String,
    samples_read: u64,
    median_interval_s: Option<f64>,
    rudder_unit: RudderUnit,
    servo: Option<Servo>,
    #[serde(flatten)]
    description: LogDescription,
    rows: Counts,
}

impl OpenedLog {
    /// The log as the JSON documents show it.
    pub fn source(&self) -> Source {
        Source {
            path: self.path.display().to_string(),
            sha256: self.sha256.clone(),
            samples_read: self.counts.samples,
            median_interval_s: self.record.median_interval_s(),
            rudder_unit: self.rudder_unit,
            servo: self.servo,
            description: LogDescription {
                warnings: self.warnings.clone(),
                ..self.description.clone()
            },
            rows: self.counts,
        }
    }
}

/// Reads a log: every sample inside `keep`, or all; of a log with more than 500,000 the stretch with
/// the liveliest rudder. Says on standard error which columns were read in which units.
pub fn open(
    path: &Path,
    channels: &ChannelArgs,
    keep: Option<Window>,
) -> Result<OpenedLog, Failure> {
    let servo = channels.servo()?;
    let mapping = channels.mapping()?;
    let choice = mapping.under(channels.choice()?);
    let mut reader =
        seatrial_logs::open(path, &choice).map_err(|error| mapping.failure_of(error))?;
    eprintln!("{}", channel_line(path, reader.description()));
    if let Some(servo) = servo {
        eprintln!("the rudder acts behind the logged command: {servo}");
    }
    let mut said = reader.description().warnings.clone();
    said.iter().for_each(|text| warn(text));

    let keep = keep.unwrap_or(Window::ALL);
    let mut stretch = LivelyStretch::default();
    let mut progress = Progress::new(path);
    let mut samples_inside = 0_u64;
    while let Some(sample) = reader.next() {
        let sample = sample.map_err(Failure::input)?;
        if keep.contains(sample.time_s) {
            samples_inside += 1;
            stretch.push(sample);
        }
        progress.advance(&reader);
    }
    progress.finish();
    let sha256 = reader.sha256().map_err(Failure::input)?;
    let mut record = match servo {
        Some(servo) => servo.behind(&stretch.into_record()),
        None => stretch.into_record(),
    };
    record.rudder_unit = reader.description().rudder_unit;

    let mut late = reader.warnings();
    if let [first, .., last] = record.samples.as_slice()
        && (record.samples.len() as u64) < samples_inside
    {
        late.push(format!(
            "of {samples_inside} samples the {} with the liveliest rudder are kept, from {} s to {} s; choose others with a window of time",
            record.samples.len(), first.time_s, last.time_s
        ));
    }
    late.iter().for_each(|text| warn(text));
    said.extend(late);
    Ok(OpenedLog {
        path: path.to_path_buf(),
        rudder_unit: record.rudder_unit,
        record,
        servo,
        description: reader.description().clone(),
        sha256,
        counts: reader.counts(),
        warnings: said,
    })
}

fn warn(text: &str) {
    eprintln!("warning: {text}");
}

/// `run.csv: time t [s], heading yaw [rad, assumed], ...`
fn channel_line(path: &Path, description: &LogDescription) -> String {
    format!("{}: {}", path.display(), channel_text(description))
}

/// Which columns were read in which units, and which of these were assumed.
pub fn channel_text(description: &LogDescription) -> String {
    let channels: Vec<String> = description
        .channels
        .iter()
        .map(|channel| {
            let assumed = match (channel.unit_source, &channel.because) {
                (UnitSource::Assumed, _) => ", assumed".into(),
                (UnitSource::Chosen, Some(because)) => format!(", {because}"),
                (UnitSource::Chosen | UnitSource::Stated, _) => String::new(),
            };
            format!(
                "{} from {} [{}{assumed}]",
                channel.quantity, channel.column, channel.unit
            )
        })
        .collect();
    let start = description
        .start_utc
        .as_ref()
        .map_or(String::new(), |start| format!("; second 0 is {start}"));
    format!("{}{start}", channels.join(", "))
}

/// The stretch of at most 500,000 successive samples whose rudder varies most.
#[derive(Default)]
struct LivelyStretch {
    recent: VecDeque<Rc<Chunk>>,
    best: Vec<Rc<Chunk>>,
    best_variance: f64,
    growing: Chunk,
}

#[derive(Default)]
struct Chunk {
    samples: Vec<Sample<f64>>,
    rudder_sum: f64,
    rudder_square_sum: f64,
}

impl LivelyStretch {
    fn push(&mut self, sample: Sample<f64>) {
        self.growing.rudder_sum += sample.rudder_rad;
        self.growing.rudder_square_sum += sample.rudder_rad * sample.rudder_rad;
        self.growing.samples.push(sample);
        if self.growing.samples.len() == CHUNK_SAMPLES {
            self.close_chunk();
        }
    }

    fn close_chunk(&mut self) {
        if self.recent.len() == MOST_SAMPLES / CHUNK_SAMPLES {
            self.recent.pop_front();
        }
        self.recent
            .push_back(Rc::new(std::mem::take(&mut self.growing)));
        let total = |of: fn(&Chunk) -> f64| self.recent.iter().map(|chunk| of(chunk)).sum::<f64>();
        let count = total(|chunk| chunk.samples.len() as f64);
        let mean = total(|chunk| chunk.rudder_sum) / count;
        let variance = total(|chunk| chunk.rudder_square_sum) / count - mean * mean;
        let is_longer = self.recent.len() > self.best.len();
        if is_longer || variance > self.best_variance {
            self.best = self.recent.iter().cloned().collect();
            self.best_variance = variance;
        }
    }

    fn into_record(mut self) -> Record {
        if !self.growing.samples.is_empty() {
            self.close_chunk();
        }
        drop(self.recent);
        let mut samples = Vec::with_capacity(self.best.iter().map(|c| c.samples.len()).sum());
        for chunk in self.best {
            samples.extend_from_slice(&chunk.samples);
        }
        samples.into_iter().collect()
    }
}

/// A bar on a terminal for logs that take more than a second.
struct Progress {
    bar: Option<ProgressBar>,
    bytes: Option<u64>,
    begun: Instant,
    samples: u32,
}

impl Progress {
    fn new(path: &Path) -> Self {
        Self {
            bar: None,
            bytes: std::fs::metadata(path).ok().map(|file| file.len()),
            begun: Instant::now(),
            samples: 0,
        }
    }

    fn advance(&mut self, reader: &LogReader) {
        self.samples = self.samples.wrapping_add(1);
        if !self.samples.is_multiple_of(1 << 16) || self.begun.elapsed() < Duration::from_secs(1) {
            return;
        }
        let Some(bytes) = self.bytes.filter(|_| std::io::stderr().is_terminal()) else {
            return;
        };
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template(
                "{bar:40} {bytes}/{total_bytes} {bytes_per_sec} {eta}",
            );
            ProgressBar::new(bytes).with_style(style.unwrap_or(ProgressStyle::default_bar()))
        });
        bar.set_position(reader.bytes_read());
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_a_long_log_keeps_its_liveliest_stretch() {
        let mut stretch = LivelyStretch::default();
        for k in 0..1_500_000 {
            let lively = (900_000..1_000_000).contains(&k);
            let rudder_rad = if lively && k / 40 % 2 == 0 { 0.3 } else { 0.0 };
            stretch.push(Sample {
                time_s: f64::from(k) * 0.05,
                rudder_rad,
                ..Sample::default()
            });
        }
        let record = stretch.into_record();
        assert_eq!(record.samples.len(), MOST_SAMPLES);
        assert!(record.samples[0].time_s <= 900_000.0 * 0.05);
        assert!(record.samples[MOST_SAMPLES - 1].time_s >= 999_999.0 * 0.05);
    }

    #[test]
    fn io_a_short_log_is_kept_whole() {
        let mut stretch = LivelyStretch::default();
        for k in 0..120_001 {
            stretch.push(Sample {
                time_s: f64::from(k),
                ..Sample::default()
            });
        }
        let record = stretch.into_record();
        assert_eq!(record.samples.len(), 120_001);
        assert!(record.samples.is_sorted_by(|a, b| a.time_s < b.time_s));
    }
}

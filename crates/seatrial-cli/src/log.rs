//! Logs as every verb reads them: the options, and what is said about a log.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use seatrial::Window;
use seatrial::identify::Proposal;
use seatrial::log::Servo;
use seatrial::words::plain;
use seatrial_app::log_page::{channel_text, windows_text};
use seatrial_app::log_reading::quantity_and_unit;
use seatrial_app::logs::{self, Observer, OpenedLog, ReadSettings, above_zero, servo_of};
use seatrial_logs::{ChannelChoice, LogDescription, Quantity, Unit};

use crate::output::Failure;
use crate::progress::{Bar, of_bytes};
use crate::screen::{labelled, width};

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
    /// Column with the rudder: measured angle, command, PWM or percent; or two motors or fins, LEFT,RIGHT (half their difference; LEFT,-RIGHT
    /// where the second counts the other way).
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
    /// Reads only the rows in which a column has a value, as in `BOAT=1`: one vehicle of several in a file; repeatable.
    #[arg(long = "where", value_name = "COLUMN=VALUE", value_parser = column_and_value)]
    pub rows_where: Vec<(String, String)>,
    /// Track in GPX or KML with the positions, joined by UTC.
    #[arg(long, value_name = "FILE")]
    pub positions: Option<PathBuf>,
    /// Pulse width of the neutral rudder [default: 1500].
    #[arg(long, value_name = "US")]
    pub rudder_trim: Option<f64>,
    /// Rudder angle at full deflection: 400 us from the trim, 100 % or fraction 1.
    #[arg(long, value_name = "DEG")]
    pub rudder_range_deg: Option<f64>,
    /// Dead time of the rudder behind the logged command.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub rudder_delay: Option<f64>,
    /// Time constant with which the rudder follows the logged command: the model is then the one behind the servo; 0 of a measured angle.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub rudder_lag: Option<f64>,
    /// Leave rows with text, NaN, missing cells or reversed time out instead of refusing the log.
    #[arg(long)]
    pub drop_invalid: bool,
}

/// `BOAT=1`.
fn column_and_value(text: &str) -> Result<(String, String), String> {
    let (column, value) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}`: expected COLUMN=VALUE, such as BOAT=1"))?;
    Ok((column.trim().into(), value.trim().into()))
}

impl ChannelArgs {
    /// What these options and their file choose of many logs.
    #[cfg(feature = "parquet")]
    pub fn chosen(&self) -> Result<ChannelChoice, Failure> {
        let settings = self.read_settings()?;
        if settings.servo.is_some() {
            return Err(Failure::usage(
                "--rudder-delay and --rudder-lag are for one log; of many, identify estimates the lag",
            ));
        }
        Ok(settings.choice()?)
    }

    /// How these options read a log.
    pub fn read_settings(&self) -> Result<ReadSettings, Failure> {
        let mut settings = ReadSettings::default();
        settings.channels_file = self.mapping.clone();
        settings.channels = self.choice()?;
        settings.servo = servo_of(self.rudder_delay, self.rudder_lag)
            .map_err(|invalid| Failure::usage(format!("--rudder-{invalid}")))?;
        Ok(settings)
    }

    fn choice(&self) -> Result<ChannelChoice, Failure> {
        above_zero("--rudder-range-deg", self.rudder_range_deg)?;
        above_zero("--rudder-trim", self.rudder_trim)?;
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
        .filter_map(|(quantity, column)| Some((quantity, column.clone()?)));
        let mut choice = ChannelChoice::default();
        for (quantity, column) in columns {
            choice.name_column(quantity, column);
        }
        choice.units = self.units.iter().copied().collect();
        choice.rudder_trim = self.rudder_trim;
        choice.full_rudder_rad = self.rudder_range_deg.map(f64::to_radians);
        choice.rows_where = self.rows_where.clone();
        choice.positions = self.positions.clone();
        choice.drop_invalid = self.drop_invalid;
        Ok(choice)
    }
}

/// Reads a log, and says on standard error which columns were read in which units.
pub fn open(
    path: &Path,
    channels: &ChannelArgs,
    keep: Option<Window>,
) -> Result<OpenedLog, Failure> {
    let settings = channels.read_settings()?;
    Ok(logs::open(path, &settings, keep, &mut Reporter::default())?)
}

/// Says on standard error what is found in a log, and draws a bar on a terminal for logs that take more than a second.
#[derive(Default)]
pub struct Reporter {
    /// Also which windows are chosen, and why.
    windows: bool,
    reading: Option<Reading>,
}

impl Reporter {
    /// Also says which windows are chosen, and why, where that is wanted.
    pub fn windows(windows: bool) -> Self {
        Self { windows, reading: None }
    }
}

/// A line on standard error, broken where a terminal ends.
fn tell(line: &str) {
    let line = &*plain(line);
    match std::io::stderr().is_terminal() {
        true => eprint!("{}", labelled("", line, width())),
        false => eprintln!("{line}"),
    }
}

struct Reading {
    bar: Option<Bar>,
    bytes: Option<u64>,
    begun: Instant,
}

impl Observer for Reporter {
    fn opened(&mut self, path: &Path, description: &LogDescription, servo: Option<Servo>) {
        tell(&format!("{}: {}", path.display(), channel_text(description)));
        if let Some(servo) = servo {
            tell(&format!("the rudder acts behind the logged command: {servo}"));
        }
        self.reading = Some(Reading {
            bar: None,
            bytes: std::fs::metadata(path).ok().map(|file| file.len()),
            begun: Instant::now(),
        });
    }

    fn read(&mut self, bytes: u64) {
        let Some(reading) = &mut self.reading else {
            return;
        };
        if reading.begun.elapsed() < Duration::from_secs(1) {
            return;
        }
        let Some(length) = reading.bytes.filter(|_| std::io::stderr().is_terminal()) else {
            return;
        };
        let bar = reading.bar.get_or_insert_with(|| of_bytes(length));
        bar.set_done(bytes);
    }

    fn finished(&mut self) {
        if let Some(bar) = self.reading.take().and_then(|reading| reading.bar) {
            bar.clear();
        }
    }

    fn warned(&mut self, warning: &str) {
        let warn = || tell(&format!("warning: {warning}"));
        match self.reading.as_ref().and_then(|reading| reading.bar.as_ref()) {
            Some(bar) => bar.aside(warn),
            None => warn(),
        }
    }

    fn found(&mut self, path: &Path, proposal: &Proposal) {
        if self.windows {
            tell(&format!("seatrial: {}: {}", path.display(), windows_text(proposal)));
        }
    }
}

//! What can be wrong with a log, and where.

use std::fmt;
use std::io;

use crate::Quantity;
use crate::format_name::Format;
use crate::motors::{of_two_sides, without};
pub(crate) use crate::name::clipped;
use crate::name::list;

/// Binary formats that are read, for messages.
/// A log that cannot be read or understood.
#[derive(Debug, thiserror::Error)]
#[error("{log}: {fault}")]
pub struct ReadError {
    /// The log as it was named.
    pub log: String,
    /// What is wrong with it.
    pub fault: Fault,
}

/// Where in a log something was found. Kinds of places are added, as faults are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A line of a text file, from 1.
    Line(u64),
    /// A row of a file without lines, from 1.
    Row(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Row(row) => write!(f, "row {row}"),
        }
    }
}

/// What is wrong with a log: what was found, what was expected and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The operating system refused.
    #[error("cannot be {doing}: {source}{}", advice(.source))]
    Io {
        /// `opened`, `read` or `downloaded`.
        doing: &'static str,
        /// What it said.
        source: io::Error,
    },
    /// Not a file.
    #[error("is a folder; expected a log file: name one of the files in it")]
    Folder,
    /// A log within another format.
    #[error(
        "is packed by {packer}: unpack it, or give it on standard input: {unpack} FILE | seatrial identify -"
    )]
    Packed {
        /// What packs such files.
        packer: &'static str,
        /// What unpacks them to standard output.
        unpack: &'static str,
    },
    /// A file of another kind.
    #[error("is {what}: {instead}")]
    NoLog {
        /// What it is, with what it holds.
        what: &'static str,
        /// What to give in its place.
        instead: &'static str,
    },
    /// A list of sensors.
    #[error(
        "is a cache file of a Slocum glider, which names the sensors of logs and holds no samples: give the log itself (.dbd, .sbd or .mbd)"
    )]
    SlocumCache,
    /// Positions are joined by UTC, and the log has none.
    #[error(
        "its times have no date, and positions of a track are joined by UTC: name a column with date and time with --time NAME"
    )]
    NoDate,
    /// Arrays in HDF5.
    #[error(
        "is a MATLAB file of version 7.3, which is HDF5: in MATLAB write it as version 7 with `s = load('FILE.mat'); save('NEW.mat', '-struct', 's', '-v7')`"
    )]
    Matlab73,
    /// No bytes, or nothing but blank and comment lines.
    #[error(
        "is empty; expected a header line with column names and one line per sample: was the logger running?"
    )]
    Empty,
    /// Names of columns but no rows.
    #[error(
        "has a header and no samples below it; expected one row per sample: was the logger running?"
    )]
    HeaderOnly,
    /// Rows, but none that can be used.
    #[error(
        "has {rows} rows and no usable sample: time, heading or rudder is missing or invalid in every one; look at its first rows, or name other columns with --time, --heading and --rudder"
    )]
    NoSamples {
        /// Rows read.
        rows: u64,
    },
    /// The first line is numbers.
    #[error(
        "line {line}: the first line is numbers ({found}); expected column names: put a line such as `time_s,heading_rad,rudder_rad` above it"
    )]
    NoHeader {
        /// Line of the file, from 1.
        line: u64,
        /// The line.
        found: String,
    },
    /// The text is UTF-16.
    #[error("the text is in UTF-16, as Excel's “Unicode text”; save it as “CSV UTF-8”")]
    Utf16,
    /// Text in an encoding that is not read.
    #[error("the text is in an encoding that is not read: save it as “CSV UTF-8”")]
    OtherEncoding,
    /// A workbook of a spreadsheet.
    #[error("is a workbook of a spreadsheet (.ods); save it as .xlsx, or its sheet as “CSV UTF-8”")]
    Workbook,
    /// The file is neither text nor of a known format.
    #[error(
        "byte {offset} is {found:#04x}, which is neither UTF-8 text nor the start of a known format; expected one of {}: export the log as CSV in UTF-8",
        (Format::NAMES.iter()).map(|(_, name, _)| *name).collect::<Vec<_>>().join(", ")
    )]
    NotText {
        /// Bytes before it.
        offset: usize,
        /// The byte.
        found: u8,
    },
    /// A known format that this build does not read.
    #[error("is {format}, which {}", if cfg!(target_family = "wasm") { "this page does not read; `seatrial identify` in a terminal does".into() } else { format!("this program was built without; build it with `{feature}`") })]
    NotBuilt {
        /// Name of the format.
        format: &'static str,
        /// Cargo feature.
        feature: &'static str,
    },
    /// A line that is no line of a log.
    #[error(
        "line {line} is longer than {limit} bytes; expected one sample a line: is a quotation mark left open, or is this not CSV?"
    )]
    LineTooLong {
        /// Line of the file, from 1.
        line: u64,
        /// The most that is read.
        limit: usize,
    },
    /// More columns than any log has.
    #[error("line {line} has more than {limit} columns; export only the channels that are needed")]
    TooManyColumns {
        /// Line of the file, from 1.
        line: u64,
        /// The most that is read.
        limit: usize,
    },
    /// No column for a quantity that is needed.
    #[error(
        "no column for {quantity}; found the columns {}{}: say which with {} NAME{}",
        list(.columns), nearest_text(.nearest), .quantity.option(), without(*.quantity, .columns)
    )]
    MissingColumn {
        /// What is needed.
        quantity: Quantity,
        /// Every column.
        columns: Vec<String>,
        /// The column with the most similar name.
        nearest: Option<String>,
    },
    /// A format that knows its channels has none for a quantity that is needed.
    #[error(
        "nothing in it is known as {quantity}: {found}; {}", elsewhere(*.quantity))]
    NotLogged {
        /// What is needed.
        quantity: Quantity,
        /// What was looked for and what was found.
        found: String,
    },
    /// The column that tells runs apart is not there.
    #[error(
        "no column `{}` tells its runs apart; found the columns {}",
        clipped(.name), list(.columns)
    )]
    NoRunColumn {
        /// As asked for.
        name: String,
        /// Every column.
        columns: Vec<String>,
    },
    /// The rows of a run are not together.
    #[error(
        "{place}: run `{}` goes on behind another run; expected the rows of a run together: sort the file by run, then by time",
        clipped(.run)
    )]
    ScatteredRun {
        /// Where it goes on.
        place: Place,
        /// The run.
        run: String,
    },
    /// A run of more rows than are held in memory.
    #[error(
        "run `{}` has more than {limit} rows; is that the right column? Write a run this long as a log of its own",
        clipped(.run)
    )]
    LongRun {
        /// The run.
        run: String,
        /// The most that is read.
        limit: usize,
    },
    /// Several columns fit equally well.
    #[error(
        "{} columns could be {quantity}: {}; say which with {} NAME{}",
        .candidates.len(), list(.candidates), .quantity.option(), of_two_sides(*.quantity, .candidates)
    )]
    AmbiguousColumn {
        /// What is looked for.
        quantity: Quantity,
        /// The columns.
        candidates: Vec<String>,
    },
    /// Several things are wrong with its columns.
    #[error("{first}; {} more: {}", .others.len(), .others.join("; "))]
    Several {
        /// What was found first.
        first: Box<Fault>,
        /// The others in short.
        others: Vec<String>,
    },
    /// Several rows are damaged.
    #[error("{first}; {others} more row{} damaged", if *.others == 1 { " is" } else { "s are" })]
    SeveralRows {
        /// What is wrong with the first.
        first: Box<Fault>,
        /// How many more there are.
        others: u64,
    },
    /// So many rows are damaged that leaving them out leaves no log.
    #[error(
        "{}; {damaged} of {rows} rows are like this, too many to leave out: write the column as plain numbers with a point or a comma before the decimals, or choose another column", .first.without_advice()
    )]
    ManyRows {
        /// What is wrong with the first.
        first: Box<Fault>,
        /// How many are damaged.
        damaged: u64,
        /// How many there are.
        rows: u64,
    },
    /// The column that was asked for is not there.
    #[error(
        "{} {name}: there is no such column; found {}{}",
        .quantity.option(), list(.columns), nearest_text(.nearest)
    )]
    NoSuchColumn {
        /// For which quantity.
        quantity: Quantity,
        /// As asked for.
        name: String,
        /// Every column.
        columns: Vec<String>,
        /// The column with the most similar name.
        nearest: Option<String>,
    },
    /// A unit that is unknown or does not fit.
    #[error(
        "column `{column}`: the unit `{found}` does not fit {quantity}; expected one of {expected}: say which with --unit {quantity}=UNIT"
    )]
    UnknownUnit {
        /// Column.
        column: String,
        /// The unit as written.
        found: String,
        /// What the column feeds.
        quantity: Quantity,
        /// Units that fit.
        expected: String,
    },
    /// Values that fit no unit.
    #[error(
        "column `{column}`: {quantity} reaches {largest}, and its unit does not show, or contradicts the name; say it with --unit {quantity}=UNIT, one of {}, or name another column with {} NAME",
        crate::Unit::that_fit(.quantity.dimension()), .quantity.option()
    )]
    ImplausibleValues {
        /// Column.
        column: String,
        /// What the column feeds.
        quantity: Quantity,
        /// Largest magnitude found.
        largest: f64,
    },
    /// Text where a number belongs.
    #[error(
        "{place}, column `{column}`: found {found:?}, expected {expected}; correct it, or leave such rows out with --drop-invalid"
    )]
    NotANumber {
        /// The place in the log.
        place: Place,
        /// Column.
        column: String,
        /// The text.
        found: String,
        /// `a number`, or what times may be.
        expected: &'static str,
    },
    /// NaN or infinity.
    #[error(
        "{place}, column `{column}`: found {found}, expected a finite number; correct it, or leave such rows out with --drop-invalid"
    )]
    NotFinite {
        /// The place in the log.
        place: Place,
        /// Column.
        column: String,
        /// The value.
        found: f64,
    },
    /// A unit that the first rows suggested does not fit a later one.
    #[error(
        "{place}, column `{column}`: {quantity} has no unit and looked like {unit}, but here it is {found}; say which with --unit {quantity}=UNIT"
    )]
    UnitContradicted {
        /// The place in the log.
        place: Place,
        /// Column.
        column: String,
        /// What it feeds.
        quantity: Quantity,
        /// The unit assumed.
        unit: crate::Unit,
        /// The value.
        found: f64,
    },
    /// Time goes back.
    #[error(
        "{place}, column `{column}`: time goes back from {before} s to {after} s; expected increasing time: split the log there, read one of several vehicles with --where COLUMN=VALUE, or leave such rows out with --drop-invalid"
    )]
    TimeReversed {
        /// The place in the log.
        place: Place,
        /// Column.
        column: String,
        /// Time of the sample before, s.
        before: f64,
        /// Time found, s.
        after: f64,
    },
    /// A row with too few or too many cells.
    #[error(
        "{place}: found {found} cells, expected {expected} as in the header; correct it, or leave such rows out with --drop-invalid"
    )]
    Ragged {
        /// The place in the log.
        place: Place,
        /// Cells in the row.
        found: usize,
        /// Cells in the header.
        expected: usize,
    },
    /// Times that cannot be those of the vehicle.
    #[error(
        "has {messages} messages within {span_s:.3} s, and the bus carries at most {most_per_s:.0} in a second: these are the times of a copy, not of the vehicle; record again with the times of reception"
    )]
    TimeCollapsed {
        /// Messages in the file.
        messages: u64,
        /// From the first to the last, s.
        span_s: f64,
        /// What is possible, 1/s.
        most_per_s: f64,
    },
    /// A sound file of a known format without a message that is read.
    #[error("is a {format} file in which nothing can be read: {what}")]
    NothingToRead {
        /// Name of the format.
        format: &'static str,
        /// What was expected and found.
        what: String,
    },
    /// A file that belongs to the log is not there.
    #[error(
        "needs {name}, {what}; it is neither beside it nor in a folder `cac` or `cache` there: copy it from the vehicle"
    )]
    MissingBeside {
        /// Name of the file.
        name: String,
        /// What it holds.
        what: &'static str,
    },
    /// A file that unpacks to more than is held.
    #[error(
        "{format} file asks for more memory or time than a log of its length does: {what}; is it one? Write it again in pages of 1 MB or less"
    )]
    TooMuch {
        /// Name of the format.
        format: &'static str,
        /// What asks for it.
        what: String,
    },
    /// A binary file whose structure is broken.
    #[error("{format} file is truncated or damaged: {what}; copy it again from the vehicle")]
    Damaged {
        /// Name of the format.
        format: &'static str,
        /// What its reader found.
        what: String,
    },
}

impl Fault {
    /// All of these in one; `None` of none.
    pub(crate) fn all(faults: Vec<Self>) -> Option<Self> {
        let mut faults = faults.into_iter();
        let first = faults.next()?;
        let others: Vec<String> = faults.map(|fault| fault.in_short()).collect();
        Some(match others.is_empty() {
            true => first,
            false => Self::Several { first: Box::new(first), others },
        })
    }

    /// Without the list of columns, which the first fault has.
    fn in_short(&self) -> String {
        match self {
            Self::MissingColumn { quantity, nearest, .. } => format!(
                "no column for {quantity}{}: {} NAME{}",
                nearest_text(nearest),
                quantity.option(),
                quantity.without()
            ),
            other => other.to_string(),
        }
    }

    /// What was found, and not what to do.
    fn without_advice(&self) -> String {
        let text = self.to_string();
        let found = text.split("; correct it").next().unwrap_or_default();
        found.to_owned()
    }

    /// Is a cell no number?
    pub(crate) fn is_of_a_cell(&self) -> bool {
        matches!(self, Self::NotANumber { .. } | Self::NotFinite { .. })
    }

    /// Is the fault confined to one row, so that reading can go on without it?
    pub(crate) fn is_in_one_row(&self) -> bool {
        self.is_of_a_cell() || matches!(self, Self::TimeReversed { .. } | Self::Ragged { .. })
    }

    pub(crate) fn read(source: io::Error) -> Self {
        Self::Io { doing: "read", source }
    }
}

fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "; check the name",
        io::ErrorKind::PermissionDenied => "; give yourself the right to read it",
        _ => "",
    }
}

/// What to do where a format that knows its channels has none for a quantity: every message has a time of its own or none.
fn elsewhere(quantity: Quantity) -> String {
    match quantity {
        Quantity::Time => {
            "record it again with a time before each sentence, as OpenCPN's voyage recorder does"
                .into()
        }
        _ => {
            let option = quantity.option();
            format!("if it is there under another name say which with {option} NAME")
        }
    }
}

fn nearest_text(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or(String::new(), |name| format!(" (did you mean `{}`?)", clipped(name)))
}

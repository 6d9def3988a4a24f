//! What a verb hands back: an exit code, a failure in words, text or JSON.

use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt;
use std::io::Write;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use clap::{ArgMatches, Command};
use seatrial::health::HealthError;
use seatrial::identification::Verdict;
use seatrial::words::{plain, shortened};
use seatrial_app::outputs::{OutputError, OutputKind, Outputs};
use seatrial_app::trials::order::{OrderError, VehicleError};
use serde::Serialize;

use crate::interrupt;
use crate::screen::{coloured, has_colour, width_of_stderr, wrapped};
use crate::standard_error;

/// Exit codes of every verb. 2 (usage) is clap's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// A bug.
    Internal = 1,
    /// The command line does not make sense.
    Usage = 2,
    /// Input cannot be read or understood.
    Input = 3,
    /// Done, but the result is rejected; the verdict says why.
    Rejected = 4,
    /// Trial aborted, vehicle handed back.
    Aborted = 5,
    /// Finished, but something could not be saved.
    NotSaved = 6,
}

impl Exit {
    /// The exit code that belongs to a verdict.
    pub fn of(verdict: &Verdict) -> Self {
        Self::done_if(verdict.accepted)
    }

    /// That of a result which is as it must be, or is not.
    pub fn done_if(is_good: bool) -> Self {
        match is_good {
            true => Self::Done,
            false => Self::Rejected,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a verb stopped. The message says where, what was found, what was expected and what to do.
#[derive(Debug)]
pub struct Failure {
    /// The exit code that belongs to it.
    pub exit: Exit,
    message: String,
}

impl Failure {
    /// A command line that does not make sense.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self::new(Exit::Usage, message)
    }

    /// Input that cannot be read or understood.
    pub fn input(message: impl fmt::Display) -> Self {
        Self::new(Exit::Input, message)
    }

    /// A disk or a pipe that takes nothing, and a program that was asked to end.
    pub fn held_up(path: &Path) -> Self {
        Self::not_saved(format!(
            "{}: not saved: nothing takes it, and this program was asked to end",
            path.display()
        ))
    }

    /// Input that was understood but gives no result.
    pub fn rejected(message: impl fmt::Display) -> Self {
        Self::new(Exit::Rejected, message)
    }

    /// Something that could not be saved.
    pub fn not_saved(message: impl fmt::Display) -> Self {
        Self::new(Exit::NotSaved, message)
    }

    /// A trial that does not go on, the vehicle handed back.
    pub fn aborted(message: impl fmt::Display) -> Self {
        Self::new(Exit::Aborted, message)
    }

    /// A bug.
    pub fn internal(message: impl fmt::Display) -> Self {
        Self::new(Exit::Internal, message)
    }

    /// With what it is about in front.
    pub fn about(self, what: impl fmt::Display) -> Self {
        Self::new(self.exit, format!("{what}: {}", self.message))
    }

    fn new(exit: Exit, message: impl fmt::Display) -> Self {
        Self { exit, message: message.to_string() }
    }
}

impl From<seatrial_app::Error> for Failure {
    fn from(error: seatrial_app::Error) -> Self {
        use seatrial_app::Error;
        match error {
            Error::Setting(_) => Self::usage(error),
            Error::Input(_) | Error::Log(_) => Self::input(error),
            Error::Rejected(_) => Self::rejected(error),
            Error::Logbook(error) => error.into(),
        }
    }
}

impl From<VehicleError> for Failure {
    fn from(error: VehicleError) -> Self {
        let exit = match error {
            VehicleError::Setting(_) => Exit::Usage,
            VehicleError::Unreachable(_) => Exit::Input,
            VehicleError::Refused(_) => Exit::Aborted,
            VehicleError::Internal(_) => Exit::Internal,
        };
        Self::new(exit, error)
    }
}

impl From<OrderError> for Failure {
    fn from(error: OrderError) -> Self {
        match error {
            OrderError::Plan(_) => Self::input(error),
            OrderError::PlanText(_) => Self::internal(error),
            OrderError::Vehicle(error) => error.into(),
            OrderError::Logbook(error) => error.into(),
        }
    }
}

impl From<HealthError> for Failure {
    fn from(error: HealthError) -> Self {
        match error {
            HealthError::Setting { .. } => Self::usage(error),
            _ => Self::input(error),
        }
    }
}

impl From<seatrial_logbook::Error> for Failure {
    fn from(error: seatrial_logbook::Error) -> Self {
        match error.is_not_saved() {
            true => Self::not_saved(error),
            false => Self::input(error),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Says something on standard error. One that cannot be written to, as on a full disk, is no reason to stop.
pub fn say(message: impl fmt::Display) {
    let message = format!("seatrial: {}", plain(&shortened(&message.to_string())));
    let shown = match width_of_stderr() {
        Some(width) => wrapped(&message, width),
        None => message + "\n",
    };
    standard_error::write(move || {
        let _ = write!(std::io::stderr(), "{shown}");
    });
}

/// Ends with what is wrong with the command line, or with the help that was asked for.
pub fn leave(error: &clap::Error) -> ! {
    let text = error.to_string();
    match shortened(&text) {
        Cow::Owned(text) if error.use_stderr() => {
            eprintln!("{text}");
            std::process::exit(error.exit_code())
        }
        _ => error.exit(),
    }
}

/// Says why a verb stopped, if it did, and gives the exit code of the program.
pub fn ended(ran: Result<Exit, Failure>) -> ExitCode {
    let exit = ran.unwrap_or_else(|failure| {
        say(&failure);
        failure.exit
    });
    standard_error::finish();
    exit.into()
}

/// Says lines that are laid out already on standard error.
pub fn say_laid_out(lines: &str) {
    let lines = plain(lines).into_owned();
    standard_error::write(move || {
        let _ = writeln!(std::io::stderr(), "{lines}");
    });
}

/// JSON escapes the lower control characters itself; a terminal obeys some of the upper ones, too.
fn without_commands(json: String) -> String {
    let is_command = |c: char| c.is_control() && c != '\n';
    if !json.contains(is_command) {
        return json;
    }
    json.chars().fold(String::new(), |mut text, c| {
        match is_command(c) {
            true => text += &format!("\\u{:04x}", u32::from(c)),
            false => text.push(c),
        }
        text
    })
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Refused { .. } => Self::usage(error),
            OutputError::NotSaved { .. } => Self::not_saved(error),
        }
    }
}

/// An option that names a file to be written, or a folder for such files. Before a verb runs, [`checked`] looks at every one.
#[derive(Clone, Debug)]
pub struct OutputPath(PathBuf);

impl From<OsString> for OutputPath {
    fn from(path: OsString) -> Self {
        Self(path.into())
    }
}

impl Deref for OutputPath {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

/// The files of a command line: every value that may name one. What is in the way of an output is refused.
pub fn checked(command: &Command, matches: &ArgMatches) -> Result<Outputs, Failure> {
    let [mut named, mut written, mut reports, mut read] = [const { Vec::new() }; 4];
    let kinds = [&mut named, &mut written, &mut reports, &mut read];
    named_files(command, matches, kinds);
    let outputs = Outputs::of(named.clone());
    for path in written.iter().filter(|path| !path.is_dir()) {
        outputs.check(path)?;
    }
    for path in reports.iter() {
        outputs.check_for(path, OutputKind::Page)?;
    }
    read.iter().try_for_each(|path| check_readable(path))?;
    Ok(outputs)
}

/// Refuses to read a device, which gives bytes without end, and a pipe, which keeps whoever opens it waiting.
pub fn check_readable(path: &Path) -> Result<(), Failure> {
    match std::fs::metadata(path) {
        Ok(about) if !about.is_file() && !about.is_dir() => Err(Failure::usage(format!(
            "{}: no file but a device or a pipe; copy what it gives into a file",
            path.display()
        ))),
        _ => Ok(()),
    }
}

/// The path in a value that may name a file, as in `sim:vehicle.toml` and `@list`.
pub fn path_in(value: &str) -> &Path {
    let path = value.trim_start_matches("sim:").trim_start_matches("ros2:");
    Path::new(path.trim_start_matches('@'))
}

/// The option of a page.
const REPORT: &str = "report";

/// Options of recordings, whose writer looks at what is there itself.
const RECORDINGS: [&str; 2] = ["out", "record"];

fn named_files(
    command: &Command,
    matches: &ArgMatches,
    [named, written, reports, read]: [&mut Vec<PathBuf>; 4],
) {
    let below = matches.subcommand();
    let output = clap::value_parser!(OutputPath);
    let output = clap::builder::ValueParser::from(output).type_id();
    for argument in command.get_arguments() {
        // The values of global options stand in every command below, too.
        if argument.is_global_set() && below.is_some() {
            continue;
        }
        let Ok(Some(values)) = matches.try_get_raw(argument.get_id().as_str()) else {
            continue;
        };
        for value in values {
            let path = match value.to_str() {
                Some(text) => path_in(text).into(),
                None => PathBuf::from(value),
            };
            if argument.get_value_parser().type_id() == output {
                let is_page = argument.get_id() == REPORT;
                let written = if is_page { &mut *reports } else { &mut *written };
                written.push(path.clone());
            } else if !RECORDINGS.contains(&argument.get_id().as_str()) {
                read.push(path.clone());
            }
            named.push(path);
        }
    }
    if let Some((name, matches)) = below
        && let Some(command) = command.find_subcommand(name)
    {
        named_files(command, matches, [named, written, reports, read]);
    }
}

/// A reader that has taken nothing for this long is not waited for by a program that was asked to end, and by one that had a vehicle.
const UNREAD: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(5)];
/// Bytes that are written at a time.
const AT_A_TIME: usize = 4096;

/// How long nobody may read, and why not longer; `None`: as long as it takes.
fn patience() -> Option<(Duration, &'static str)> {
    let [asked, handed_back] = UNREAD;
    if interrupt::is_asked() {
        return Some((asked, "nobody reads it, and this program was asked to end"));
    }
    standard_error::is_detached().then_some((handed_back, "nobody reads it"))
}

/// Writes on standard output, however slowly it is read: until the program is asked to end, or, where it had a vehicle, nobody reads.
fn write_out(text: String) -> std::io::Result<()> {
    let (tell, told) = channel();
    std::thread::spawn(move || {
        let mut stdout = std::io::stdout().lock();
        for bytes in text.as_bytes().chunks(AT_A_TIME) {
            let written = stdout.write_all(bytes).and_then(|()| stdout.flush());
            let is_over = written.is_err();
            if tell.send(written).is_err() || is_over {
                break;
            }
        }
    });
    let mut unread = Duration::ZERO;
    let look = Duration::from_millis(50);
    loop {
        match told.recv_timeout(look) {
            Ok(written) => written?,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {
                unread += look;
                match patience() {
                    Some((most, why)) if unread > most => {
                        return Err(std::io::Error::new(std::io::ErrorKind::TimedOut, why));
                    }
                    _ => continue,
                }
            }
        }
        unread = Duration::ZERO;
    }
}

/// Standard output as the user asked for it.
pub struct Output {
    /// One JSON document instead of text.
    pub json: bool,
    files: Outputs,
}

impl Output {
    /// JSON or text, and the files of the command.
    pub fn new(json: bool, files: Outputs) -> Self {
        Self { json, files }
    }

    /// Text, whatever was asked for.
    pub fn as_text(&self) -> Self {
        Self::new(false, self.files.clone())
    }

    /// The way to every file that is written.
    pub fn files(&self) -> &Outputs {
        &self.files
    }

    /// Writes a file whole.
    pub fn save(&self, path: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        let (files, place) = (self.files.clone(), path.to_path_buf());
        let content = content.as_ref().to_vec();
        let saved = interrupt::unless_asked(move || files.save(&place, &content));
        Ok(saved.ok_or_else(|| Failure::held_up(path))??)
    }

    /// Makes a folder and writes these files in it.
    pub fn save_in(&self, folder: &Path, files: &[(&str, String)]) -> Result<(), Failure> {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::not_saved(format!("{}: {error}", folder.display())))?;
        for (name, content) in files {
            self.save(&folder.join(name), content)?;
        }
        Ok(())
    }

    /// Prints the document as JSON, or the text. A closed pipe is not an error.
    pub fn print(
        &self,
        document: &impl Serialize,
        text: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        let printed = if self.json {
            without_commands(serde_json::to_string_pretty(document).map_err(Failure::internal)?)
        } else {
            let text = plain(&text()).into_owned();
            match has_colour() {
                true => coloured(&text),
                false => text,
            }
        };
        match write_out(printed.trim_end().to_owned() + "\n") {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(Failure::not_saved(format!("standard output: {error}")))
            }
            _ => Ok(()),
        }
    }
}

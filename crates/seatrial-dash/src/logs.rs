//! Logs that are opened in the page: read, identified, inspected, drawn.

use std::fmt::Display;
use std::path::Path;

use seatrial::CourseChange;
use seatrial::identification::Reader;
use seatrial_app::Inspection;
use seatrial_app::documents::IdentificationDocument;
use seatrial_app::identify_log::{IdentifiedLog as Found, identify_opened};
use seatrial_app::log_page::page;
use seatrial_app::log_reading::LogReading;
use seatrial_app::logs::{NoObserver, OpenedLog, open};
use seatrial_app::series::series_of;
use seatrial_logs::{Quantity, TrackFormat};
use tempfile::NamedTempFile;

use crate::api::{IdentifiedLog, InspectedLog, LogColumns, Verdict};
use crate::refusal::Refusal;

/// The log as `seatrial identify` identifies it; `trace`: with the estimate after every sample, which a report draws.
fn found(log: &Path, reading: LogReading, trace: bool) -> Result<Found, Refusal> {
    let name = reading.name().to_owned();
    let mut options = reading.options().map_err(unreadable)?;
    options.settings.trace = trace;
    let opened =
        options.windows.open(log, &options.reading, &mut NoObserver).and_then(|mut logs| {
            logs.log.path = name.clone().into();
            identify_opened(logs, &options, &mut NoObserver)
        });
    opened.map_err(|error| refused(log, &name, &error))
}

/// What `seatrial identify` makes of a log without windows.
pub fn identified(log: &Path, reading: LogReading) -> Result<IdentifiedLog, Refusal> {
    let found = found(log, reading, false)?;
    let validated =
        found.identification().and_then(|found| Some((found, found.validation?.window)));
    let document = IdentificationDocument::of(&found).addressed_to(Reader::Dashboard);
    let promised = document.first_answer.iter().map(CourseChange::sentence);
    Ok(IdentifiedLog {
        verdict: Verdict { promises: promised.collect(), ..found.verdict().into() },
        document,
        series: series_of(&found.logs.log.record, validated),
        is_located: found.logs.log.origin_deg.is_some(),
    })
}

/// The page of `seatrial report` of a log.
pub fn report(log: &Path, reading: LogReading) -> Result<String, Refusal> {
    let name = reading.name().to_owned();
    Ok(page(&found(log, reading, true)?, Path::new(&name)))
}

/// The log as it is read, called by its name.
fn opened(log: &Path, reading: LogReading) -> Result<OpenedLog, Refusal> {
    let name = reading.name().to_owned();
    let settings = reading.settings().map_err(unreadable)?;
    let opened =
        open(log, &settings, None, &mut NoObserver).map_err(|error| refused(log, &name, &error))?;
    Ok(OpenedLog { path: name.into(), ..opened })
}

/// What `seatrial inspect` says of a log.
pub fn inspected(log: &Path, reading: LogReading) -> Result<InspectedLog, Refusal> {
    let opened = opened(log, reading)?;
    Ok(InspectedLog {
        document: Inspection::of(&opened).addressed_to(Reader::Dashboard),
        series: series_of(&opened.record, None),
        is_located: opened.origin_deg.is_some(),
    })
}

/// The track of a log.
pub fn track(log: &Path, reading: LogReading, format: TrackFormat) -> Result<String, Refusal> {
    opened(log, reading)?.track(format).ok_or_else(|| {
        Refusal::unprocessable(
            "no_track",
            "the log has no latitude and longitude: a track for charts needs them",
        )
    })
}

/// The names of a log's columns, for who has to say which is which.
pub fn columns(log: &Path, reading: &LogReading) -> Result<LogColumns, Refusal> {
    let found = seatrial_logs::columns(log);
    let columns = found.map_err(|error| refused(log, reading.name(), &error))?;
    let symbols = |quantity: Quantity| {
        let units = quantity.units().into_iter();
        units.map(|unit| unit.symbol().to_owned()).collect()
    };
    let units = Quantity::ALL.map(|quantity| (quantity.name().to_owned(), symbols(quantity)));
    Ok(LogColumns { columns, units: units.into() })
}

/// Largest list of sensors, bytes, and how many are kept.
const LARGEST_LIST: u64 = 4 << 20;
const MOST_LISTS: usize = 256;

/// Keeps a list of sensors by its name where logs are looked at.
pub fn keep_sensor_list(
    uploads: &Path,
    list: NamedTempFile,
    reading: &LogReading,
) -> Result<(), Refusal> {
    let name = reading.name().to_lowercase();
    let number = name.strip_suffix(".cac").unwrap_or_default();
    let is_a_name =
        (1..=16).contains(&number.len()) && number.bytes().all(|byte| byte.is_ascii_hexdigit());
    if !is_a_name {
        return Err(Refusal::unprocessable(
            "out_of_range",
            "name: expected that of a list of sensors, as in 06a36d4e.cac",
        ));
    }
    let folder = uploads.join("cac");
    std::fs::create_dir_all(&folder).map_err(Refusal::internal)?;
    let length = list.as_file().metadata().map_err(Refusal::internal)?.len();
    let kept = std::fs::read_dir(&folder).map_err(Refusal::internal)?.count();
    if length > LARGEST_LIST || kept >= MOST_LISTS {
        return Err(Refusal::unprocessable(
            "too_large",
            format!("expected at most {MOST_LISTS} lists of sensors of at most 4 MB each"),
        ));
    }
    list.persist(folder.join(name)).map_err(Refusal::internal)?;
    Ok(())
}

/// A refusal with the log by its name, not by that of the file that it was put into.
fn refused(log: &Path, name: &str, error: &dyn Display) -> Refusal {
    let text = error.to_string().replace(&*log.to_string_lossy(), name);
    let beside =
        "it is neither beside it nor in a folder `cac` or `cache` there: copy it from the vehicle";
    let text = text.replace(beside, "choose it together with the log");
    Refusal::unprocessable("log_refused", text)
}

fn unreadable(error: seatrial_app::Error) -> Refusal {
    Refusal::unprocessable("log_refused", error.to_string())
}

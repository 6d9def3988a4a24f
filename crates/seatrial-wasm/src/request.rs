//! What a page asks for, and the answers.

use std::collections::BTreeMap;
use std::path::Path;

use seatrial::CourseChange;
use seatrial::identification::{Reader, Reason, Verdict};
use seatrial::words::shortened;
use seatrial_app::advice::{self, addressed};
use seatrial_app::identify_log::{IdentifiedLog, identify_log};
use seatrial_app::log_reading::LogReading;
use seatrial_app::logs::{NoObserver, OpenedLog, open};
use seatrial_app::model_request::{ModelFile, ModelRequest};
use seatrial_app::models::{Models, of_document_text};
use seatrial_app::series::series_of;
use seatrial_app::simulated_log::SeaTrial;
use seatrial_app::{Error, Inspection, log_page};
use seatrial_logs::{FileMap, Quantity, TrackFormat};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::simulated;

/// What a page asks for. `log` is the name of a file that is held.
#[derive(Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// The names of a log's columns.
    Columns {
        /// The log.
        log: String,
    },
    /// The document of `seatrial inspect --json`.
    Inspect {
        /// The log.
        log: String,
        /// How it is read.
        #[serde(default)]
        reading: Box<LogReading>,
    },
    /// The document of `seatrial identify --json`, the verdict in the words of a page, the samples to be drawn, and the names of the columns.
    Identify {
        /// The log.
        log: String,
        /// How it is read.
        #[serde(default)]
        reading: Box<LogReading>,
    },
    /// The track of a log that has latitude and longitude.
    Track {
        /// The log.
        log: String,
        /// How it is read.
        #[serde(default)]
        reading: Box<LogReading>,
        /// Is it KML, or GPX?
        #[serde(default)]
        kml: bool,
    },
    /// The page of `seatrial report`.
    Report {
        /// The log.
        log: String,
        /// How it is read.
        #[serde(default)]
        reading: Box<LogReading>,
    },
    /// The documents of `seatrial gains --json` and `seatrial turn --json`.
    Gains {
        /// Where the model comes from, for people.
        origin: String,
        /// The document of an identification.
        document: Value,
        /// What is said besides.
        #[serde(default)]
        stated: ModelRequest,
    },
    /// The file of `seatrial gains --export`.
    File {
        /// Where the model comes from, for people.
        origin: String,
        /// The document of an identification.
        document: Value,
        /// What is said besides.
        #[serde(default)]
        stated: ModelRequest,
        /// Which file.
        form: ModelFile,
    },
    /// A simulated trial; its log is held under the name `simulated.csv`.
    Simulate {
        /// What is played.
        trial: SeaTrial,
    },
    /// The truth of a simulated trial, and the document of `seatrial identify --json` for its log.
    Rehearse {
        /// What is played.
        trial: SeaTrial,
        /// How its log is read.
        #[serde(default)]
        reading: Box<LogReading>,
    },
}

/// The answer to a request, `{"done": ...}` or `{"refused": "why"}`.
pub fn answer(message: &[u8], files: &mut FileMap) -> String {
    let done = serde_json::from_slice(message)
        .map_err(|error| format!("the request: {error}"))
        .and_then(|request: Request| request.answer(files).map_err(|error| words(&error)));
    match done {
        Ok(done) => json!({ "done": done }).to_string(),
        Err(refused) => json!({ "refused": refused }).to_string(),
    }
}

/// An error as a page says it.
fn words(error: &Error) -> String {
    let text = error.to_string().replace(
        "it is neither beside it nor in a folder `cac` or `cache` there: copy it from the vehicle",
        "choose it together with the log",
    );
    addressed(&shortened(&text), Reader::Dashboard)
}

impl Request {
    fn answer(self, files: &mut FileMap) -> Result<Value, Error> {
        match self {
            Self::Columns { log } => {
                let columns = seatrial_logs::columns_from(Path::new(&log), files)?;
                let units = Quantity::ALL.map(|quantity| (quantity.name(), quantity.units()));
                Ok(json!({ "columns": columns, "units": BTreeMap::from(units) }))
            }
            Self::Inspect { log, reading } => inspected(&log, *reading, files),
            Self::Identify { log, reading } => identified(&log, *reading, files),
            Self::Track { log, reading, kml } => {
                let format = if kml { TrackFormat::Kml } else { TrackFormat::Gpx };
                let text = opened(&log, *reading, files)?.track(format);
                let text = text.ok_or_else(|| {
                    Error::Input(format!("{log}: it has no latitude and longitude"))
                })?;
                Ok(json!({ "text": text }))
            }
            Self::Report { log, reading } => {
                let found = found(&log, *reading, true, files)?;
                Ok(json!({ "html": log_page::page(&found, Path::new(&log)) }))
            }
            Self::Gains { origin, document, stated } => {
                let models = models(origin, &document, &stated)?;
                Ok(json!(stated.limits(&models)?))
            }
            Self::File { origin, document, stated, form } => {
                let file = stated.file(&models(origin, &document, &stated)?, form)?;
                let text = String::from_utf8(file.bytes).map_err(|_| {
                    Error::Setting(
                        "this file is no text, and a page without a server does not write it"
                            .into(),
                    )
                })?;
                Ok(json!({ "text": text, "notes": file.notes }))
            }
            Self::Simulate { trial } => simulated::trial(&trial, files),
            Self::Rehearse { trial, reading } => simulated::found(&trial, *reading),
        }
    }
}

/// `trace`: with the estimate after every sample, which a report draws.
fn found(
    log: &str,
    reading: LogReading,
    trace: bool,
    files: &FileMap,
) -> Result<IdentifiedLog, Error> {
    let mut options = reading.options()?;
    options.settings.trace = trace;
    options.reading.held = files.clone();
    identify_log(Path::new(log), &options)
}

fn identified(log: &str, reading: LogReading, files: &FileMap) -> Result<Value, Error> {
    let found = found(log, reading, false, files)?;
    let validated =
        found.identification().and_then(|model| Some((model, model.validation?.window)));
    let document = found.document();
    Ok(json!({
        "shown": document.clone().addressed_to(Reader::Dashboard),
        "verdict": verdict(found.verdict(), document.first_answer),
        "document": document,
        "series": series_of(&found.logs.log.record, validated),
        "columns": found.logs.log.description.columns,
        "is_located": found.logs.log.origin_deg.is_some(),
    }))
}

fn opened(log: &str, reading: LogReading, files: &FileMap) -> Result<OpenedLog, Error> {
    let mut settings = reading.settings()?;
    settings.held = files.clone();
    open(Path::new(log), &settings, None, &mut NoObserver)
}

fn inspected(log: &str, reading: LogReading, files: &FileMap) -> Result<Value, Error> {
    let opened = opened(log, reading, files)?;
    Ok(json!({
        "document": Inspection::of(&opened),
        "series": series_of(&opened.record, None),
        "is_located": opened.origin_deg.is_some(),
    }))
}

/// May the model be used, and what decides it, in the words of a page.
fn verdict(verdict: &Verdict, promised: Option<CourseChange>) -> Value {
    let cause = |reason: &Reason| {
        let reason = advice::reason(reason, Reader::Dashboard);
        json!({ "code": reason.code, "of": reason.of, "action": reason.action, "text": reason.text })
    };
    json!({
        "outcome": verdict.outcome(),
        "cause": verdict.cause().map(cause),
        "other_causes": verdict.other_causes(),
        "promises": promised.iter().map(CourseChange::sentence).collect::<Vec<_>>(),
    })
}

fn models(origin: String, document: &Value, stated: &ModelRequest) -> Result<Models, Error> {
    of_document_text(origin, &document.to_string(), stated.surge_speed_m_s)
}

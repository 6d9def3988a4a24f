//! Many logs: on this machine, or as pieces for others.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use seatrial_app::fleet::{
    Entry, Estimate, Job, Journal, JournalError, Options, Source, find, work_on,
};

use crate::reading::Reading;
use crate::{error, failed, json, usage};

/// Python is asked this often whether somebody wants to stop.
const ASK_EVERY: Duration = Duration::from_millis(200);

/// Cores of this machine.
pub fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Which estimate, the column that tells runs apart, how logs are read.
type How = (String, Option<String>, Reading);

fn options(py: Python<'_>, (estimate, run_column, reading): How) -> PyResult<Options> {
    let estimate = match estimate.as_str() {
        "refined" => Estimate::Refined,
        "online" => Estimate::Online,
        other => {
            return Err(usage(py, format!("estimate={other:?}: expected 'refined' or 'online'")));
        }
    };
    let settings = reading.settings(py)?;
    if settings.servo.is_some() {
        return Err(usage(
            py,
            "rudder_delay_s and rudder_lag_s are for one log; of many, identify estimates the lag",
        ));
    }
    let mut options = Options::default();
    options.channels = settings.choice().map_err(|found| failed(py, &found))?;
    options.estimate = estimate;
    options.run_column = run_column;
    Ok(options)
}

fn sources(py: Python<'_>, inputs: &[String], out: &Path) -> PyResult<Vec<Source>> {
    let found = py.detach(|| find(inputs, out));
    found.map(|found| found.sources).map_err(|none| error(py, "InputError", none))
}

fn failure(py: Python<'_>, found: &JournalError) -> PyErr {
    let class = match found {
        JournalError::NotSaved { .. } | JournalError::Object(_) => "NotSavedError",
        _ => "UsageError",
    };
    error(py, class, found)
}

/// A job on the cores of this machine; the summary as JSON.
#[pyfunction]
pub fn fleet(
    py: Python<'_>,
    inputs: Vec<String>,
    out: PathBuf,
    how: How,
    workers: Option<usize>,
    resume: bool,
) -> PyResult<String> {
    let job = Job {
        sources: sources(py, &inputs, &out)?,
        options: options(py, how)?,
        out,
        workers: workers.unwrap_or_else(cores),
        resume,
    };
    let asked = Mutex::new(Instant::now());
    let interrupted = Mutex::new(None);
    let summary = py.detach(|| {
        job.run(|_| {
            let Ok(mut asked) = asked.lock() else {
                return ControlFlow::Break(());
            };
            if asked.elapsed() < ASK_EVERY {
                return ControlFlow::Continue(());
            }
            *asked = Instant::now();
            match (Python::attach(|py| py.check_signals()), interrupted.lock()) {
                (Ok(()), _) => ControlFlow::Continue(()),
                (Err(signal), Ok(mut interrupted)) => {
                    *interrupted = Some(signal);
                    ControlFlow::Break(())
                }
                (Err(_), Err(_)) => ControlFlow::Break(()),
            }
        })
    });
    match summary.map_err(|found| failure(py, &found))? {
        Some(summary) => json(py, &summary),
        None => Err(interrupted
            .into_inner()
            .ok()
            .flatten()
            .unwrap_or_else(|| error(py, "SeatrialError", "the job was broken off"))),
    }
}

/// A log as a worker needs to know it.
type Log = (PathBuf, u64, i64, Option<String>);

/// What a worker makes of some logs: lines for [`FleetJournal::keep`].
#[pyfunction]
pub fn fleet_work(py: Python<'_>, logs: Vec<Log>, how: How) -> PyResult<String> {
    let options = options(py, how)?;
    let lines = py.detach(|| {
        let mut lines = String::new();
        for (path, bytes, modified_ns, etag) in logs {
            let source = Source { path, bytes, modified_ns, etag };
            for entry in work_on(&source, &options) {
                lines += &serde_json::to_string(&entry)?;
                lines.push('\n');
            }
        }
        Ok::<_, serde_json::Error>(lines)
    });
    lines.map_err(|found| error(py, "SeatrialError", found))
}

/// The journal of a job whose work is done elsewhere.
#[pyclass(module = "seatrial._native")]
pub struct FleetJournal {
    journal: Option<Journal>,
    sources: Vec<Source>,
}

#[pymethods]
impl FleetJournal {
    #[new]
    fn new(
        py: Python<'_>,
        inputs: Vec<String>,
        out: PathBuf,
        how: How,
        resume: bool,
    ) -> PyResult<Self> {
        let sources = sources(py, &inputs, &out)?;
        let options = options(py, how)?;
        let journal =
            Journal::open(&out, &sources, &options, resume).map_err(|found| failure(py, &found))?;
        Ok(Self { journal: Some(journal), sources })
    }

    /// The logs that are not done.
    fn pending(&self) -> Vec<Log> {
        let is_done = |index| {
            let journal = self.journal.as_ref();
            journal.is_some_and(|journal| journal.is_whole(index))
        };
        self.sources
            .iter()
            .enumerate()
            .filter(|(index, _)| !is_done(*index))
            .map(|(_, s)| (s.path.clone(), s.bytes, s.modified_ns, s.etag.clone()))
            .collect()
    }

    /// Keeps lines of [`fleet_work`]; what is there already is not kept twice.
    fn keep(&mut self, py: Python<'_>, lines: &str) -> PyResult<()> {
        let Some(journal) = &mut self.journal else {
            return Err(usage(py, "the job is finished"));
        };
        for line in lines.lines() {
            let entry: Entry = serde_json::from_str(line).map_err(|found| usage(py, found))?;
            journal.keep(&entry).map_err(|found| failure(py, &found))?;
        }
        Ok(())
    }

    /// Writes the Parquet file; the summary as JSON.
    fn finish(&mut self, py: Python<'_>) -> PyResult<String> {
        let Some(journal) = self.journal.take() else {
            return Err(usage(py, "the job is finished"));
        };
        let summary = py.detach(|| journal.finish());
        json(py, &summary.map_err(|found| failure(py, &found))?)
    }
}

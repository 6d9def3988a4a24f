//! A trial that is played in the page.

use std::path::Path;

use seatrial_app::Error;
use seatrial_app::identify_log::identify_log;
use seatrial_app::log_reading::LogReading;
use seatrial_app::simulated_log::{SeaTrial, SimulatedTrial};
use seatrial_logs::{FileMap, Row, write_csv};
use seatrial_sim::Truth;
use serde_json::{Value, json};

/// Where its log is held.
const NAME: &str = "simulated.csv";

/// Plays a trial: its log is held as one that a person has dropped, with the windows of its stages and the truth beside it.
pub fn trial(wanted: &SeaTrial, files: &mut FileMap) -> Result<Value, Error> {
    let (played, truth, csv) = played(wanted)?;
    let text = String::from_utf8_lossy(&csv).into_owned();
    files.insert(NAME, csv);
    Ok(json!({
        "log": NAME,
        "csv": text,
        "samples": played.samples.len(),
        "runs": played.runs,
        "outcome": played.outcome,
        "truth": truth,
    }))
}

/// The truth of a trial, and the document of `seatrial identify --json` for its log, which is not kept.
pub fn found(wanted: &SeaTrial, reading: LogReading) -> Result<Value, Error> {
    let (_, truth, csv) = played(wanted)?;
    let mut options = reading.options()?;
    options.reading.held.insert(NAME, csv);
    let found = identify_log(Path::new(NAME), &options)?;
    Ok(json!({ "truth": truth, "document": found.document() }))
}

/// The trial, its truth and its log.
fn played(wanted: &SeaTrial) -> Result<(SimulatedTrial, Option<Truth>, Vec<u8>), Error> {
    let (played, truth) = wanted.play()?;
    let rows: Vec<Row> = played.samples.iter().copied().map(Row::from).collect();
    let mut csv = Vec::new();
    write_csv(&mut csv, &rows).map_err(|error| Error::Input(format!("{NAME}: {error}")))?;
    Ok((played, truth, csv))
}

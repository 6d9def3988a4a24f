//! A trial that is played in the page.

use seatrial_app::Error;
use seatrial_app::simulated_log::SeaTrial;
use seatrial_logs::{Held, Row, write_csv};
use serde_json::{Value, json};

/// Where its log is held.
const NAME: &str = "simulated.csv";

/// Plays a trial: its log is held as one that a person has dropped, with the windows of its stages and the truth beside it.
pub fn trial(wanted: &SeaTrial, files: &mut Held) -> Result<Value, Error> {
    let (played, truth) = wanted.play()?;
    let rows: Vec<Row> = played.samples.iter().copied().map(Row::from).collect();
    let mut csv = Vec::new();
    write_csv(&mut csv, &rows).map_err(|error| Error::Input(format!("{NAME}: {error}")))?;
    let text = String::from_utf8_lossy(&csv).into_owned();
    files.insert(NAME, csv);
    Ok(json!({
        "log": NAME,
        "csv": text,
        "samples": rows.len(),
        "runs": played.runs,
        "outcome": played.outcome,
        "truth": truth,
    }))
}

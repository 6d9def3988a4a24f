//! Every method on the identical record of a log.

use std::path::Path;
use std::time::Instant;

use seatrial::identify::{IdentifySettings, ValidationData};
use seatrial::study::{Comparison, compare, split};
use seatrial::{Record, Window};
use serde::Serialize;

use crate::Error;
use crate::identify_log::{Logs, SpeedModel, Windows, foremost, identify_speeds, no_model};
use crate::logs::{Observer, OpenedLog, ReadSettings, Source};

/// The document of `compare --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonDocument {
    /// `seatrial.comparison.v1`
    pub schema: &'static str,
    /// The log.
    pub source: Source,
    /// The other log, where there was one.
    pub validation_source: Option<Source>,
    /// Which data validate, and why these.
    pub windows_because: String,
    /// What each method made of the record.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Methods compared on a log.
#[derive(Clone, Debug)]
pub struct ComparedLog {
    /// What was read.
    pub logs: Logs,
    /// What was found.
    pub document: ComparisonDocument,
}

/// Compares the methods on a log. Without a validation window what follows the training window validates; without any
/// the windows are those of the surest model that [`identify_log`](crate::identify_log()) finds. `lambda_rad_s` is the
/// pole of the state variable filter of every method but the paper's, derived from the data where it is `None`.
pub fn compare_log(
    path: &Path,
    windows: &Windows,
    reading: &ReadSettings,
    lambda_rad_s: Option<f64>,
    observer: &mut dyn Observer,
) -> Result<ComparedLog, Error> {
    let logs = windows.validated_on_the_rest().open(path, reading, observer)?;
    let selection = Selection::of(windows, &logs, observer)?;
    let begun = Instant::now();
    let clock_ms = || begun.elapsed().as_secs_f64() * 1e3;
    let comparison = compare(
        &logs.log.record,
        selection.training,
        selection.validation,
        lambda_rad_s,
        &clock_ms,
    )
    .map_err(|error| no_model(&logs.log, error))?;
    let document = ComparisonDocument {
        schema: "seatrial.comparison.v1",
        source: logs.log.source(),
        validation_source: logs.validation_log.as_ref().map(OpenedLog::source),
        windows_because: selection.because,
        comparison,
    };
    Ok(ComparedLog { logs, document })
}

struct Selection<'a> {
    training: Window,
    validation: ValidationData<'a>,
    because: String,
}

impl<'a> Selection<'a> {
    fn of(windows: &Windows, logs: &'a Logs, observer: &mut dyn Observer) -> Result<Self, Error> {
        let record: &Record = &logs.log.record;
        let training = logs.training;
        let on_this_log = |training, window, because: &str| Self {
            training,
            validation: ValidationData { record, window },
            because: because.into(),
        };
        if let Some(validation) = logs.validation_data() {
            return Ok(Self {
                training,
                validation,
                because: "as given; without, what follows the training window".into(),
            });
        }
        if !windows.are_given()
            && let settings = IdentifySettings::default()
            && let Some(models) = identify_speeds(&logs.log, &settings, observer)?
            && let Some(SpeedModel { windows, .. }) = foremost(&models)
            && let (Some(training), Some(validation)) =
                (windows.training.first(), windows.validation)
        {
            return Ok(on_this_log(*training, validation, &windows.because));
        }
        Ok(match split(record).filter(|_| training == Window::ALL) {
            Some((training, validation)) => {
                on_this_log(training, validation, "the log was split in the middle of its strokes")
            }
            None => on_this_log(
                training,
                training,
                "NOT HELD OUT: nothing is left of the log, so the models are judged by the data that they were made from",
            ),
        })
    }
}

//! The page of a log: its models, the record and how it was read.

use super::log_model::LogModel;
use super::number::percent;
use super::source::Source;
use super::{Fact, Page, RunSection, headline, reasons, recorded, run_figures_of, tables};
use seatrial::Record;
use seatrial::campaign::{Stage, StageSpan};
use seatrial::identification::{Identification, Verdict};
use seatrial_core::Axis;

/// A record with its models, and what to call it.
#[derive(Clone, Copy, Debug)]
pub struct Log<'a> {
    /// What heading and rudder of the record are.
    pub axis: Axis,
    /// Name of the log, as the reader knows it.
    pub name: &'a str,
    /// The record that the model was made from.
    pub record: &'a Record,
    /// The record of validation data, where it is another one.
    pub validation: Option<&'a Record>,
    /// The model that stands for all, where there is one.
    pub identification: Option<&'a Identification>,
    /// May it be used?
    pub verdict: &'a Verdict,
    /// The model of each speed; one line of the summary each.
    pub models: &'a [LogModel<'a>],
    /// What to type next; empty where there is nothing.
    pub command: &'a str,
    /// When it was recorded and on what, as far as the log says.
    pub about: &'a [Fact],
    /// How it was read and with what.
    pub provenance: &'a [Fact],
}

/// The page of a log. Without a model the record is drawn all the same.
pub fn render(log: &Log) -> String {
    let identification = log.identification;
    let mut stages = Vec::new();
    stages.extend(identification.map(|i| StageSpan { stage: Stage::Train, window: i.training }));
    let validation = identification.and_then(|i| i.validation);
    stages.extend(
        validation
            .map(|validation| StageSpan { stage: Stage::Validate, window: validation.window }),
    );
    let source = Source {
        axis: log.axis,
        record: log.record,
        validation: log.validation.unwrap_or(log.record),
        stages: &stages,
        identification,
        name: log.name,
        origin_s: 0.0,
        is_trial: false,
    };
    let mut recorded = vec![("Software", format!("seatrial {}", env!("CARGO_PKG_VERSION")))];
    recorded.extend(log.provenance.iter().cloned());
    let records: Vec<&Record> = [Some(log.record), log.validation].into_iter().flatten().collect();
    recorded.push(("SHA-256 of the samples", recorded::fingerprint(&records)));
    let has_models = log.models.iter().any(|m| m.identification.is_some());
    let page = Page {
        title: match log.axis {
            Axis::Yaw => format!("Steering of {}", log.name),
            Axis::Pitch => format!("Pitch of {}", log.name),
        },
        subtitle: speeds_text(log.models),
        about: log.about.to_vec(),
        headline: headline::of_log(log.verdict, log.models, log.command),
        summary: has_models
            .then(|| tables::log_summary(log.models, log.record.rudder_unit, log.axis)),
        runs: vec![RunSection {
            anchor: "run-1".to_owned(),
            title: "The record".to_owned(),
            verdict: None,
            reasons: reasons(&log.verdict.reasons),
            facts: identification.map_or(Vec::new(), recorded::method),
            figures: run_figures_of(&source),
        }],
        recorded,
        ..Page::default()
    };
    page.text()
}

/// The speeds of a log that has several.
fn speeds_text(models: &[LogModel]) -> String {
    if models.len() < 2 {
        return String::new();
    }
    let usable = models.iter().filter(|m| m.is_accepted()).count();
    let thrusts: Vec<String> = models.iter().filter_map(|m| m.thrust.map(percent)).collect();
    match thrusts.is_empty() {
        true => format!("{usable} of {} speeds have a usable model", models.len()),
        false => format!(
            "{usable} of {} speeds have a usable model: thrust {}",
            models.len(),
            thrusts.join(", ")
        ),
    }
}

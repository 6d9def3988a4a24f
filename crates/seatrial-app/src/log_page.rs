//! What a log was identified as, on one page and in the lines about its reading that every edge shows.

use std::path::Path;

use seatrial::Window;
use seatrial::identify::Proposal;
use seatrial_core::RudderUnit;
use seatrial_logs::{LogDescription, UnitSource};
use seatrial_report::{Fact, Log, LogModel, render_log};

use crate::identify_log::{IdentifiedLog, foremost};
use crate::logs::OpenedLog;
use crate::next;

/// The page of an identified log.
pub fn page(found: &IdentifiedLog, path: &Path) -> String {
    let logs = &found.logs;
    let verdict = found.verdict();
    let mut provenance = source("Log", &logs.log);
    let models = found.models.as_deref().unwrap_or_default();
    let windows = foremost(models).map(|model| ("Windows", windows_text(&model.windows)));
    provenance.extend(windows);
    provenance.extend(found.law_text().map(|text| ("Law over speed", text)));
    provenance.extend(logs.validation_log.iter().flat_map(|log| source("Validated on", log)));
    let name = path.file_name().unwrap_or(path.as_os_str());
    let rows = speed_rows(found);
    let command = next::after_log(found, &identify_call(path), None);
    render_log(&Log {
        axis: found.axis,
        name: &name.to_string_lossy(),
        record: &logs.log.record,
        validation: logs.validation_log.as_ref().map(|log| &log.record),
        identification: found.identification(),
        verdict,
        models: &rows,
        command: &command,
        about: &about(&logs.log),
        provenance: &provenance,
    })
}

/// When a log was recorded and on what, as far as it says.
fn about(log: &OpenedLog) -> Vec<Fact> {
    let described = &log.description;
    let date =
        described.start_utc.as_ref().map(|start| start.replace('T', " ").replace('Z', " UTC"));
    let known = [
        ("Date", date),
        ("Firmware", described.firmware.clone()),
        ("Format", Some(described.format.to_string())),
    ];
    known.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

/// Where samples came from and how they were read.
pub fn source(title: &'static str, log: &OpenedLog) -> Vec<Fact> {
    let mut facts = vec![
        (title, log.path.display().to_string()),
        ("Columns", channel_text(&log.description)),
        ("SHA-256 of the file", log.sha256.clone()),
    ];
    facts.extend(log.warnings.iter().map(|text| ("Warning", text.clone())));
    facts
}

/// What is shown of every speed, or of the one model.
pub fn speed_rows(found: &IdentifiedLog) -> Vec<LogModel<'_>> {
    // A share of full rudder ends at 1; the full angle of others is in no log.
    let rudder_limit = match found.logs.log.rudder_unit() {
        RudderUnit::FullRudder => Some(1.0),
        RudderUnit::Rad => None,
    };
    match &found.models {
        Some(models) => models
            .iter()
            .map(|model| {
                LogModel::new(
                    [model.thrust, model.surge_speed_m_s],
                    model.identification.as_ref(),
                    &model.verdict,
                    rudder_limit,
                )
            })
            .collect(),
        None => vec![LogModel::new(
            [None, usual_speed_m_s(found)],
            found.identification(),
            found.verdict(),
            rudder_limit,
        )],
    }
}

/// The speed of the one model of a log, m/s, where it was logged.
fn usual_speed_m_s(found: &IdentifiedLog) -> Option<f64> {
    let range = found.identification()?.valid_range?;
    range.usual_surge_speed_m_s
}

/// The command that identifies a log.
fn identify_call(log: &Path) -> String {
    format!("seatrial identify {}", log.display())
}

/// Which columns were read in which units, and which of these were assumed.
pub fn channel_text(description: &LogDescription) -> String {
    let channels: Vec<String> = description
        .channels
        .iter()
        .map(|channel| {
            let assumed = match (channel.unit_source, &channel.because) {
                (UnitSource::Assumed, _) => ", assumed".into(),
                (UnitSource::Chosen, Some(because)) => format!(", {because}"),
                (UnitSource::Chosen | UnitSource::Stated, _) => String::new(),
            };
            format!("{} from {} [{}{assumed}]", channel.quantity, channel.column, channel.unit)
        })
        .collect();
    let start = description
        .start_utc
        .as_ref()
        .map_or(String::new(), |start| format!("; second 0 is {start}"));
    format!("{}{start}", channels.join(", "))
}

/// Which windows are used at a speed, and why.
pub fn windows_text(proposal: &Proposal) -> String {
    let span = |window: &Window| format!("{:.2} s to {:.2} s", window.from_s, window.to_s);
    let training: Vec<String> = proposal.training.iter().map(span).collect();
    format!(
        "{}: training {}, validation {}: {}",
        speed_text(proposal.thrust, proposal.surge_speed_m_s),
        training.join(" and "),
        proposal.validation.as_ref().map_or_else(|| "none".into(), span),
        proposal.because
    )
}

/// Thrust and speed of a model.
pub fn speed_text(thrust: Option<f64>, surge_speed_m_s: Option<f64>) -> String {
    let thrust = thrust.map(|thrust| format!("{:.0} % thrust", 100.0 * thrust));
    let speed = surge_speed_m_s.map(|speed| format!("{speed:.2} m/s"));
    match (thrust, speed) {
        (None, None) => "unknown speed".into(),
        (thrust, speed) => [thrust, speed].into_iter().flatten().collect::<Vec<_>>().join(", "),
    }
}

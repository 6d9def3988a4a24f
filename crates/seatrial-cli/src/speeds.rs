//! The models of a long log, as text and as a schedule file.

use std::fmt::Write;
use std::path::Path;

use seatrial::identify::joint_estimate::JointEstimate;
use seatrial::words::three_figures;
use seatrial_app::documents::Source;
use seatrial_app::identify_log::SpeedModel;
use seatrial_app::models::write_schedule_file;
use seatrial_core::RudderUnit;

use crate::model_text::{model_text, training_text, validation_text, verdict_text};
use crate::output::{Failure, Output};
use seatrial_app::log_page::speed_text;

/// A paragraph of the page.
fn paragraph(model: &SpeedModel, unit: RudderUnit) -> String {
    let mut text = format!("{}: ", speed_text(model.thrust, model.surge_speed_m_s));
    text += &verdict_text(&model.verdict);
    if let Some(identification) = &model.identification {
        text += &model_text(identification, unit);
        text += &joined_text(model.joined.as_ref());
        text += &validation_text(identification);
        text += &training_text(identification);
    }
    let _ = writeln!(text, "Windows     {}\n", model.windows.because);
    text
}

fn joined_text(joined: Option<&JointEstimate>) -> String {
    let Some(joined) = joined else {
        return String::new();
    };
    let mut text = format!(
        "Joined      {} manoeuvres, each with its own offset; that they differ by chance has a probability of {}\n",
        joined.manoeuvres.len(),
        three_figures(joined.consistency)
    );
    for manoeuvre in &joined.manoeuvres {
        let [a22, b2, c0] = manoeuvre.model.theta().map(three_figures);
        let _ = writeln!(
            text,
            "  from {:.2} s: a22 {a22}, b2 {b2}, C0 {c0}",
            manoeuvre.training.from_s
        );
    }
    text
}

/// The page: a paragraph for each speed.
pub fn text(models: &[SpeedModel], unit: RudderUnit) -> String {
    let accepted = models.iter().filter(|m| m.verdict.accepted).count();
    let mut text = format!(
        "Manoeuvres at {} speed{}: {accepted} model{} accepted\n\n",
        models.len(),
        plural(models.len()),
        plural(accepted)
    );
    for model in models {
        text += &paragraph(model, unit);
    }
    text
}

/// Writes the accepted models as a schedule file.
pub fn save_schedule(
    path: &Path,
    models: &[SpeedModel],
    log: &Source,
    output: &Output,
) -> Result<(), Failure> {
    let text = write_schedule_file(models, log)
        .map_err(|error| Failure::from(error).about("--schedule"))?;
    output.save(path, format!("# Speed schedule by seatrial\n{text}"))
}

/// The ending of a noun after a count.
pub fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

//! The models of a long log: one for each speed at which manoeuvres were found in it.

use std::fmt::Write;
use std::path::Path;

use seatrial::figures::three_figures;
use seatrial::identification::{Identification, Verdict};
use seatrial::identify::identify_joined;
use seatrial::identify::joined::Joined;
use seatrial::identify::{IdentifyError, IdentifySettings, ValidationData};
use seatrial::record::Window;
use seatrial::segmentation::{Proposal, find, propose};
use serde::Serialize;

use crate::identify::{fresh_text, model_text, training_text, verdict_text};
use crate::log::OpenedLog;
use crate::output::{Failure, say};
use crate::windows::failure;
use seatrial_core::RudderUnit;

/// A model of one speed, or why there is none.
#[derive(Serialize)]
pub struct SpeedModel {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    /// Where it was found.
    pub windows: Proposal,
    /// What each manoeuvre says by itself, where several were joined.
    joined: Option<Joined>,
    /// The model.
    pub identification: Option<Identification>,
    /// May it be used?
    pub verdict: Verdict,
}

/// Finds the manoeuvres of a log and identifies a model for each of their speeds, slowest first. Says on standard error
/// which windows are used and why. `None` of a log that has no manoeuvres or is one.
pub fn identify(
    log: &OpenedLog,
    settings: &IdentifySettings,
) -> Result<Option<Vec<SpeedModel>>, Failure> {
    let proposals = propose(&log.record, &find(&log.record.samples));
    let models = proposals
        .into_iter()
        .map(|proposal| {
            say(format_args!(
                "{}: {}",
                log.path.display(),
                windows_text(&proposal)
            ));
            SpeedModel::identify(log, proposal, settings)
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok((!models.is_empty()).then_some(models))
}

/// The model that stands for all: the accepted one with the surest rudder, else the first there is.
pub fn foremost(models: &[SpeedModel]) -> &SpeedModel {
    let rudder_share = |model: &SpeedModel| {
        let refined = model.identification.as_ref()?.refined.as_ref()?;
        Some(refined.covariance[1][1].sqrt() / refined.model.b2_per_s2.abs())
    };
    models
        .iter()
        .filter(|model| model.verdict.accepted)
        .min_by(|a, b| {
            let shares = [a, b].map(|model| rudder_share(model).unwrap_or(f64::INFINITY));
            shares[0].total_cmp(&shares[1])
        })
        .or_else(|| models.iter().find(|model| model.identification.is_some()))
        .unwrap_or(&models[0])
}

impl SpeedModel {
    fn identify(
        log: &OpenedLog,
        proposal: Proposal,
        settings: &IdentifySettings,
    ) -> Result<Self, Failure> {
        let fresh = proposal.validation.map(|window| ValidationData {
            record: &log.record,
            window,
        });
        let (identification, joined, verdict) =
            match identify_joined(&log.record, &proposal.training, fresh, settings) {
                Ok((identification, joined)) => {
                    let verdict = identification.verdict.clone();
                    (Some(identification), joined, verdict)
                }
                Err(IdentifyError::Refused(reason)) => (None, None, Verdict::refused(reason)),
                Err(error) => return Err(failure(log, error)),
            };
        Ok(Self {
            thrust: proposal.thrust,
            surge_speed_m_s: proposal.surge_speed_m_s,
            windows: proposal,
            joined,
            identification,
            verdict,
        })
    }

    /// A line for a page about another speed's model.
    pub fn line(&self) -> String {
        let speed = speed_text(self.thrust, self.surge_speed_m_s);
        let verdict = match self.verdict.accepted {
            true => "accepted",
            false => "rejected",
        };
        let model = self.identification.as_ref().map(|i| i.model().theta());
        match model.map(|theta| theta.map(three_figures)) {
            Some([a22, b2, c0]) => format!("{speed}: {verdict}, a22 {a22}, b2 {b2}, C0 {c0}"),
            None => format!("{speed}: {verdict}"),
        }
    }

    /// A paragraph of the page.
    fn text(&self, unit: RudderUnit) -> String {
        let mut text = format!("{}: ", speed_text(self.thrust, self.surge_speed_m_s));
        text += &verdict_text(&self.verdict);
        if let Some(identification) = &self.identification {
            text += &model_text(identification, unit);
            text += &self.joined_text();
            text += &fresh_text(identification.validation);
            text += &training_text(identification);
        }
        let _ = writeln!(text, "Windows     {}\n", self.windows.because);
        text
    }

    fn joined_text(&self) -> String {
        let Some(joined) = &self.joined else {
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
        text += &model.text(unit);
    }
    text
}

/// Writes the accepted models as a schedule file.
pub fn save_schedule(path: &Path, models: &[SpeedModel], unit: RudderUnit) -> Result<(), Failure> {
    #[derive(Serialize)]
    struct Schedule {
        rudder_unit: RudderUnit,
        point: Vec<Point>,
    }
    #[derive(Serialize)]
    struct Point {
        thrust: Option<f64>,
        surge_speed_m_s: Option<f64>,
        a22_per_s: f64,
        b2_per_s2: f64,
        c0_rad_per_s2: f64,
    }
    let point = |speed: &SpeedModel| {
        let model = speed.identification.as_ref()?.model();
        Some(Point {
            thrust: speed.thrust,
            surge_speed_m_s: speed.surge_speed_m_s,
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
        })
    };
    let accepted = models.iter().filter(|model| model.verdict.accepted);
    let schedule = Schedule {
        rudder_unit: unit,
        point: accepted.filter_map(point).collect(),
    };
    if schedule.point.is_empty() {
        return Err(Failure::rejected(
            "--schedule: no model was accepted, and no schedule is written",
        ));
    }
    let text = toml::to_string(&schedule).map_err(Failure::internal)?;
    std::fs::write(path, text)
        .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))
}

/// Which windows are used at a speed, and why.
pub fn windows_text(proposal: &Proposal) -> String {
    let span = |window: &Window| format!("{:.2} s to {:.2} s", window.from_s, window.to_s);
    let training: Vec<String> = proposal.training.iter().map(span).collect();
    format!(
        "{}: training {}, validation {}: {}",
        speed_text(proposal.thrust, proposal.surge_speed_m_s),
        training.join(" and "),
        proposal
            .validation
            .as_ref()
            .map_or_else(|| "none".into(), span),
        proposal.because
    )
}

fn speed_text(thrust: Option<f64>, surge_speed_m_s: Option<f64>) -> String {
    let thrust = thrust.map(|thrust| format!("{:.0} % thrust", 100.0 * thrust));
    let speed = surge_speed_m_s.map(|speed| format!("{speed:.2} m/s"));
    match (thrust, speed) {
        (None, None) => "unknown speed".into(),
        (thrust, speed) => [thrust, speed]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(", "),
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

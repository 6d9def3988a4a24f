//! The page of a pitch trial.

use seatrial_core::{DivingSample, PitchState};

use super::chart::{Chart, Layer, Panel, Span};
use super::headline::{Headline, Tone};
use super::number::{decimals, decimals_or_missing, percent};
use super::tables::{Table, columns};
use super::{Fact, Figure, Page};
use seatrial::Window;
use seatrial::pitch::{PitchIdentification, PitchRun, PitchTrial, simulate};

/// The page of a pitch trial on a vehicle.
pub fn render(vehicle: &str, trial: &PitchTrial, provenance: &[Fact]) -> String {
    let accepted = trial.runs.iter().filter(|run| run.is_accepted()).count();
    let (tone, verdict) = match &trial.aborted {
        Some(reason) => (Tone::Bad, format!("Aborted: {reason}")),
        None if accepted == trial.plan.thrusts.len() => (
            Tone::Good,
            format!("{accepted} of {accepted} thrusts have a model"),
        ),
        None => (
            Tone::Partly,
            format!(
                "{accepted} of {} thrusts have a model",
                trial.plan.thrusts.len()
            ),
        ),
    };
    let page = Page {
        title: format!("Pitch of {vehicle}"),
        subtitle: "θ'' = a θ' + m θ + b δe + c, with 95 % half widths".to_owned(),
        headline: Headline {
            tone,
            verdict,
            findings: trial.runs.iter().filter_map(finding).collect(),
            next: Vec::new(),
            command: String::new(),
        },
        summary: Some(models(&trial.runs)),
        over_speed: trial
            .runs
            .iter()
            .filter_map(|run| figure(trial, run))
            .collect(),
        recorded: provenance.to_vec(),
        ..Page::default()
    };
    page.text()
}

/// Why a thrust has no accepted model.
fn finding(run: &PitchRun) -> Option<String> {
    let reason = match &run.identification {
        Some(found) if found.accepted => return None,
        Some(found) => &found.reason,
        None => run.refused.as_ref()?,
    };
    Some(format!("{}: {reason}", percent(run.thrust)))
}

fn models(runs: &[PitchRun]) -> Table {
    let rows = runs.iter().filter_map(|run| {
        let found = run.identification.as_ref()?;
        let theta = found.refined.model.theta();
        let [_, _, authority, offset] = theta;
        let mut row = vec![
            percent(run.thrust).into(),
            decimals_or_missing(run.surge_speed_m_s, 2).into(),
        ];
        for ((value, [low, high]), digits) in theta
            .into_iter()
            .zip(found.refined.interval_95)
            .zip([2, 2, 2, 4])
        {
            let half_width = decimals(0.5 * (high - low), digits);
            row.push(format!("{} ± {half_width}", decimals(value, digits)).into());
        }
        row.push(decimals((-offset / authority).to_degrees(), 2).into());
        row.push(decimals_or_missing(found.validation.map(|found| found.r2_pitch), 2).into());
        row.push(decimals_or_missing(run.depth_excursion_m, 2).into());
        Some(row)
    });
    Table {
        title: "Models",
        note: "Trim: the elevator that holds the vehicle level. Depth: the greatest excursion."
            .to_owned(),
        columns: columns(&[
            ("Thrust", ""),
            ("Speed", "m/s"),
            ("a", "1/s"),
            ("m", "1/s²"),
            ("b", "1/s²"),
            ("c", "rad/s²"),
            ("Trim", "°"),
            ("R²", ""),
            ("Depth", "m"),
        ]),
        rows: rows.collect(),
    }
}

/// Elevator, pitch and depth of a run, with the model's pitch through the training.
fn figure(trial: &PitchTrial, run: &PitchRun) -> Option<Figure> {
    let found = run.identification.as_ref()?;
    let from_s = found.training.from_s;
    let to_s = found
        .validation
        .map_or(found.training.to_s, |validation| validation.window.to_s);
    let inside = |s: &&DivingSample<f64>| (from_s..=to_s).contains(&s.time_s);
    let shown: Vec<_> = trial.samples.iter().filter(inside).copied().collect();
    let line = |value: fn(&DivingSample<f64>) -> Option<f64>| -> Vec<[f64; 2]> {
        let known = shown.iter();
        known
            .filter_map(|s| Some([s.time_s - from_s, value(s)?]))
            .collect()
    };
    let elevator = line(|s| Some(s.elevator_rad.to_degrees()));
    let pitch = line(|s| Some(s.pitch_rad.to_degrees()));
    let pitch = vec![
        Layer::line("a", "measured", pitch),
        Layer::line("b", "model", modelled_pitch(found, &shown)?),
    ];
    let depth = line(|s| s.depth_m);
    let chart = Chart {
        alt: format!("Elevator, pitch and depth at {}.", percent(run.thrust)),
        x_label: "Time since the start of training, s",
        x_range: [0.0, to_s - from_s],
        spans: stage_spans(found),
        marks: Vec::new(),
        panels: vec![
            Panel::linear("Elevator, °", 60.0, vec![Layer::line("a", "", elevator)]),
            Panel::linear("Pitch, °", 110.0, pitch),
            Panel::linear("Depth, m", 60.0, vec![Layer::line("a", "", depth)]),
        ],
    };
    Some(Figure::new(
        &chart,
        format!(
            "Elevator doublets at {}; the model runs freely from the start of training.",
            percent(run.thrust)
        ),
    ))
}

/// The pitch of the model through the training, degrees over the time since it began. `None` without
/// a sample.
fn modelled_pitch(
    found: &PitchIdentification,
    shown: &[DivingSample<f64>],
) -> Option<Vec<[f64; 2]>> {
    let training = shown.iter().filter(|s| found.training.contains(s.time_s));
    let training: Vec<_> = training.copied().collect();
    let start = PitchState {
        pitch_rad: training.first()?.pitch_rad,
        pitch_rate_rad_s: 0.0,
    };
    let modelled = simulate(&found.refined.model, start, &training);
    let points = training.iter().zip(modelled);
    let points =
        points.map(|(s, pitch_rad)| [s.time_s - found.training.from_s, pitch_rad.to_degrees()]);
    Some(points.collect())
}

/// Training and validation, shaded.
fn stage_spans(found: &PitchIdentification) -> Vec<Span> {
    let span = |window: Window, shade, label: &str| Span {
        from: window.from_s - found.training.from_s,
        to: window.to_s - found.training.from_s,
        shade,
        label: label.to_owned(),
    };
    let training = span(found.training, "span-train", "train");
    let validation = found
        .validation
        .map(|validation| span(validation.window, "span-validate", "validate"));
    std::iter::once(training).chain(validation).collect()
}

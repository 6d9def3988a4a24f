//! The page of a pitch trial.

use seatrial_core::{DivingSample, PitchState};

use super::chart::{Chart, Layer, Panel, Span};
use super::headline::{Headline, Tone};
use super::number::{decimals, decimals_or_missing, percent};
use super::tables::{Table, columns};
use super::{Fact, Figure, Page};
use seatrial::pitch::{PitchRun, PitchTrial, simulate};

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
        runs: Vec::new(),
        together: Vec::new(),
        methods: Vec::new(),
        over_speed: trial
            .runs
            .iter()
            .filter_map(|run| figure(trial, run))
            .collect(),
        controller: None,
        control: Vec::new(),
        every_run: None,
        recorded: provenance.to_vec(),
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
        row.push(decimals_or_missing(found.fresh.map(|fresh| fresh.r2_pitch), 2).into());
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
        .fresh
        .map_or(found.training.to_s, |fresh| fresh.window.to_s);
    let inside = |s: &&DivingSample<f64>| (from_s..=to_s).contains(&s.time_s);
    let shown = || trial.samples.iter().filter(inside);
    let since = |time_s: f64| time_s - from_s;
    let training: Vec<_> = shown()
        .filter(|s| found.training.contains(s.time_s))
        .copied()
        .collect();
    let start = PitchState {
        pitch_rad: training.first()?.pitch_rad,
        pitch_rate_rad_s: 0.0,
    };
    let modelled = simulate(&found.refined.model, start, &training);
    let depths = shown().filter_map(|s| Some([since(s.time_s), s.depth_m?]));
    let span = |from: f64, to: f64, shade, label: &str| Span {
        from: since(from),
        to: since(to),
        shade,
        label: label.to_owned(),
    };
    let mut spans = vec![span(from_s, found.training.to_s, "span-train", "train")];
    spans.extend(found.fresh.map(|fresh| {
        span(
            fresh.window.from_s,
            fresh.window.to_s,
            "span-validate",
            "validate",
        )
    }));
    let chart = Chart {
        alt: format!("Elevator, pitch and depth at {}.", percent(run.thrust)),
        x_label: "Time since the start of training, s",
        x_range: [0.0, since(to_s)],
        spans,
        marks: Vec::new(),
        panels: vec![
            Panel::linear(
                "Elevator, °",
                60.0,
                vec![Layer::line(
                    "a",
                    "",
                    shown()
                        .map(|s| [since(s.time_s), s.elevator_rad.to_degrees()])
                        .collect(),
                )],
            ),
            Panel::linear(
                "Pitch, °",
                110.0,
                vec![
                    Layer::line(
                        "a",
                        "measured",
                        shown()
                            .map(|s| [since(s.time_s), s.pitch_rad.to_degrees()])
                            .collect(),
                    ),
                    Layer::line(
                        "b",
                        "model",
                        training
                            .iter()
                            .zip(modelled)
                            .map(|(s, pitch_rad)| [since(s.time_s), pitch_rad.to_degrees()])
                            .collect(),
                    ),
                ],
            ),
            Panel::linear(
                "Depth, m",
                60.0,
                vec![Layer::line("a", "", depths.collect())],
            ),
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

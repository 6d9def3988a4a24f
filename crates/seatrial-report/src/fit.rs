//! Measured against simulated heading.

use seatrial_core::model::YawState;
use seatrial_core::{Sample, YawModel};

use super::Figure;
use super::chart::{Chart, Layer, Panel};
use super::number::{self, decimals};
use super::run_figures::{Source, degrees, present, series, unwrapped, yaw_rate};
use seatrial::campaign::Stage;
use seatrial::identify::validation::quiet_lead_in_s;
use seatrial::record::{Record, Window};

/// Samples that a simulation can be compared with, the heading unwrapped.
pub(super) fn usable(samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let mut usable: Vec<Sample<f64>> = Vec::with_capacity(samples.len());
    for sample in samples {
        let later = usable.last().is_none_or(|last| sample.time_s > last.time_s);
        if later && sample.heading_rad.is_finite() && sample.rudder_rad.is_finite() {
            usable.push(*sample);
        }
    }
    unwrapped(&usable)
}

/// A simulation of usable samples with the measured rudder, from the mean of the lead-in: the
/// initial conditions of [`Validation`](seatrial_core::validation::Validation).
fn simulated(samples: &[Sample<f64>], model: &YawModel<f64>) -> Vec<YawState<f64>> {
    let Some(first) = samples.first() else {
        return Vec::new();
    };
    let lead_in_s = quiet_lead_in_s(samples);
    let lead_in = samples
        .iter()
        .take_while(|s| s.time_s - first.time_s < lead_in_s);
    let lead_in = &samples[..lead_in.count().clamp(1, samples.len())];
    let count = lead_in.len() as f64;
    let headings = lead_in.iter().map(|s| s.heading_rad);
    let rates = lead_in.iter().filter_map(|s| s.yaw_rate_rad_s);
    let rates: Vec<f64> = rates.filter(|rate| rate.is_finite()).collect();
    let mut state = YawState {
        heading_rad: headings.sum::<f64>() / count,
        yaw_rate_rad_s: rates.iter().sum::<f64>() / rates.len().max(1) as f64,
    };
    let mut states = vec![state];
    for pair in samples.windows(2) {
        state = model.advance(state, pair[0].rudder_rad, pair[1].time_s - pair[0].time_s);
        states.push(state);
    }
    states
}

/// Measured and simulated heading of one sample, rad, unwrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlaid {
    /// Time in the record, s.
    pub time_s: f64,
    /// Measured.
    pub measured_rad: f64,
    /// Free running simulation.
    pub simulated_rad: f64,
}

/// A model's simulation over the measured heading of a record's window, as the report draws it.
pub fn overlay(record: &Record, window: Window, model: &YawModel<f64>) -> Vec<Overlaid> {
    let samples = usable(record.window(window));
    let states = simulated(&samples, model);
    let pairs = samples.iter().zip(states);
    pairs
        .map(|(sample, state)| Overlaid {
            time_s: sample.time_s,
            measured_rad: sample.heading_rad,
            simulated_rad: state.heading_rad,
        })
        .collect()
}

/// Ends of an axis for both: a model that runs away leaves the picture.
fn around(measured: &[[f64; 2]], simulated: &[[f64; 2]]) -> Option<[f64; 2]> {
    let ends = |points: &[[f64; 2]]| {
        points
            .iter()
            .map(|point| point[1])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| {
                [low.min(y), high.max(y)]
            })
    };
    let [low, high] = ends(measured);
    let [lowest, highest] = ends(simulated);
    let span = high - low;
    span.is_finite().then(|| {
        [
            lowest.clamp(low - span, low),
            highest.clamp(high, high + span),
        ]
    })
}

/// Measured against simulated heading, on the training run and on fresh data (Figs. 10 and 11).
pub(super) fn figure(source: &Source) -> Option<Figure> {
    let identification = source.identification?;
    let model = identification.model();
    let online = &identification.online.model;
    let mut panels = Vec::new();
    let mut longest = 0.0_f64;
    for (stage, record, name) in [
        (Stage::Train, source.record, "training"),
        (Stage::Validate, source.fresh, "fresh data"),
    ] {
        let Some(window) = source.window(stage) else {
            continue;
        };
        let samples = usable(record.window(Window {
            to_s: window.to_s + 1e-6,
            ..window
        }));
        if samples.len() < 2 {
            continue;
        }
        longest = longest.max(window.to_s - window.from_s);
        let measured = series(&samples, window.from_s, |s| degrees(Some(s.heading_rad)));
        let states = simulated(&samples, &model);
        let simulation: Vec<[f64; 2]> = measured
            .iter()
            .zip(&states)
            .map(|([t, _], state)| [*t, state.heading_rad.to_degrees()])
            .collect();
        let mut layers = vec![Layer::line("a", "measured", measured.clone())];
        if identification.refined.is_some() {
            let live = measured
                .iter()
                .zip(simulated(&samples, online))
                .map(|([t, _], state)| [*t, state.heading_rad.to_degrees()]);
            layers.push(Layer::line("c", "live model", live.collect()));
        }
        layers.push(Layer::line("b", "model", simulation.clone()));
        panels.push(
            Panel::linear(format!("Heading, {name}, °"), 88.0, layers)
                .with_range(around(&measured, &simulation)),
        );
        if stage == Stage::Validate {
            let difference = measured
                .iter()
                .zip(&simulation)
                .map(|(m, s)| [m[0], m[1] - s[1]]);
            let layers = vec![
                Layer::level("zero", "", 0.0),
                Layer::line("a", "", difference.collect()),
            ];
            panels.push(Panel::linear("Measured less model, fresh, °", 50.0, layers));
            let (rate, name) = yaw_rate(&samples, window.from_s);
            if present(&rate) {
                let modelled = measured
                    .iter()
                    .zip(&states)
                    .map(|([t, _], state)| [*t, state.yaw_rate_rad_s.to_degrees()])
                    .collect();
                let layers = vec![
                    Layer::line("a", name, rate),
                    Layer::line("b", "model", modelled),
                ];
                panels.push(Panel::linear("Yaw rate, fresh, °/s", 66.0, layers));
            }
        }
    }
    if panels.is_empty() || longest <= 0.0 {
        return None;
    }
    let r2 = identification
        .validation
        .and_then(|v| v.judged_r2_heading());
    let fresh = match (identification.validation, r2) {
        (Some(_), Some(r2)) => format!(
            "On validation data the model explains {} of the heading (R² = {}).",
            if r2 > 0.0 {
                format!("{} %", decimals(100.0 * r2, 0))
            } else {
                "nothing".to_owned()
            },
            number::r2(Some(r2))
        ),
        (Some(_), None) => {
            "The heading of the validation data did not vary: R² says nothing.".to_owned()
        }
        (None, _) => {
            "There are no validation data: nothing says yet how well the model predicts.".to_owned()
        }
    };
    let chart = Chart {
        alt: format!(
            "{}: measured and simulated heading over time. {fresh}",
            source.name
        ),
        x_label: "Time since the stage began, s",
        x_range: [0.0, longest],
        spans: Vec::new(),
        marks: Vec::new(),
        panels,
    };
    Some(Figure::new(
        &chart,
        format!(
            "The model steered by the measured rudder against what the vehicle did. {fresh} The lines should lie on each other; \
             a drift late in the run is what the model cannot know: disturbance and noise."
        ),
    ))
}

//! Measured against simulated heading.

use seatrial_core::model::YawState;
use seatrial_core::{Axis, Sample};

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Panel};
use super::curves::{degrees, present, series, usable, yaw_rate};
use super::number::{self, decimals};
use super::source::Source;
use seatrial::campaign::Stage;
use seatrial::identification::Identification;
use seatrial::identify::simulated;
use seatrial::identify::validation::simulated_by;
use seatrial::{Record, Window};

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

/// Does the R^2 on which the verdict rests take the offset from the validation data?
fn is_offset_again(found: &Identification) -> bool {
    let validation = found.validation;
    validation.is_some_and(|validation| validation.is_judged_with_offset_again())
}

/// A simulation of all samples, or part by part where R^2 is that of a model that runs free so far only.
fn as_scored(
    found: &Identification,
    samples: &[Sample<f64>],
    simulated: impl Fn(&[Sample<f64>]) -> Vec<YawState<f64>>,
) -> Vec<YawState<f64>> {
    match found.validation.and_then(|validation| validation.horizon_s) {
        None => simulated(samples),
        Some(horizon_s) => {
            let begins_s = samples.first().map_or(0.0, |first| first.time_s);
            let part = |sample: &Sample<f64>| ((sample.time_s - begins_s) / horizon_s).floor();
            let parts = samples.chunk_by(|a, b| part(a) == part(b));
            parts.flat_map(simulated).collect()
        }
    }
}

/// The simulation whose R^2 is stated, over the measured heading of a record's window of validation data, as the report draws it.
pub fn overlay(record: &Record, window: Window, found: &Identification) -> Vec<Overlaid> {
    let samples = usable(record.window(window));
    let states = as_scored(found, &samples, |part| simulated(found, part, is_offset_again(found)));
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
    let heights = |points: &[[f64; 2]]| extent(points.iter().map(|point| point[1]));
    let [low, high] = heights(measured);
    let [lowest, highest] = heights(simulated);
    let span = high - low;
    span.is_finite().then(|| [lowest.clamp(low - span, low), highest.clamp(high, high + span)])
}

/// A stage with what the model makes of it.
struct Comparison {
    stage: Stage,
    window: Window,
    samples: Vec<Sample<f64>>,
    states: Vec<YawState<f64>>,
    offset_again: bool,
    /// Heading over the time since the stage began, degrees.
    measured: Vec<[f64; 2]>,
    /// That of the model, degrees.
    simulated: Vec<[f64; 2]>,
}

impl Comparison {
    /// `None` where the stage is missing or has fewer than two usable samples.
    fn new(source: &Source, stage: Stage, found: &Identification) -> Option<Self> {
        let record = match stage {
            Stage::Validate => source.validation,
            Stage::Settle | Stage::Train => source.record,
        };
        let window = source.window(stage)?;
        let samples = usable(record.window(Window { to_s: window.to_s + 1e-6, ..window }));
        if samples.len() < 2 {
            return None;
        }
        let measured = series(&samples, window.from_s, |s| degrees(Some(s.heading_rad)));
        let offset_again = stage == Stage::Validate && is_offset_again(found);
        let states = as_scored(found, &samples, |part| simulated(found, part, offset_again));
        let mut comparison =
            Self { stage, window, samples, states, offset_again, measured, simulated: Vec::new() };
        comparison.simulated = comparison.modelled(&comparison.states, |s| s.heading_rad);
        Some(comparison)
    }

    /// A value of the simulated states over the time since the stage began, degrees.
    fn modelled(
        &self,
        states: &[YawState<f64>],
        value: fn(&YawState<f64>) -> f64,
    ) -> Vec<[f64; 2]> {
        let pairs = self.measured.iter().zip(states);
        pairs.map(|([t, _], state)| [*t, value(state).to_degrees()]).collect()
    }

    /// Measured and simulated heading; with that of the live model where it is another.
    fn heading(&self, angle: &str, found: &Identification) -> Panel {
        let name = match self.stage {
            Stage::Validate => "validation data",
            Stage::Settle | Stage::Train => "training",
        };
        let mut layers = vec![Layer::line("a", "measured", self.measured.clone())];
        if found.refined.is_some() {
            let online_m = found.restoring.map(|m| m.online_per_s2);
            let online = found.online.model;
            let live = as_scored(found, &self.samples, |part| {
                simulated_by(online, online_m, part, self.offset_again)
            });
            let live = self.modelled(&live, |s| s.heading_rad);
            layers.push(Layer::line("c", "live model", live));
        }
        layers.push(Layer::line("b", "model", self.simulated.clone()));
        Panel::linear(format!("{angle}, {name}, °"), 88.0, layers)
            .with_range(around(&self.measured, &self.simulated))
    }

    /// What the model leaves of the heading.
    fn difference(&self) -> Panel {
        let pairs = self.measured.iter().zip(&self.simulated);
        let difference = pairs.map(|(m, s)| [m[0], m[1] - s[1]]);
        let layers =
            vec![Layer::level("zero", "", 0.0), Layer::line("a", "", difference.collect())];
        Panel::linear("Measured less model, validation, °", 50.0, layers)
    }

    /// Measured and simulated yaw rate. `None` where neither sensor nor heading gives one.
    fn rate(&self) -> Option<Panel> {
        let (rate, name) = yaw_rate(&self.samples, self.window.from_s);
        present(&rate).then(|| {
            let layers = vec![
                Layer::line("a", name, rate),
                Layer::line("b", "model", self.modelled(&self.states, |s| s.yaw_rate_rad_s)),
            ];
            Panel::linear("Yaw rate, validation, °/s", 66.0, layers)
        })
    }
}

/// What validation says about the model, one sentence.
fn validation_sentence(identification: &Identification, angle: &str) -> String {
    let r2 = identification.validation.and_then(|v| v.judged_r2_heading());
    match (identification.validation, r2) {
        (Some(_), Some(r2)) => {
            let is_within = identification.is_validated_within();
            let [model, data] = match is_within {
                true => ["A model of the rest of the record", " of the validation data"],
                false => ["On validation data the model", ""],
            };
            let share = match r2 > 0.0 {
                true => format!("{} %", decimals(100.0 * r2, 0)),
                false => "nothing".to_owned(),
            };
            let offset = match is_offset_again(identification) {
                true => ", with its offset estimated again",
                false => "",
            };
            let r2 = number::r2(Some(r2));
            format!("{model} explains {share} of the {angle}{data} (R² = {r2}{offset}).")
        }
        (Some(_), None) => {
            format!("The {angle} of the validation data did not vary: R² says nothing.")
        }
        (None, _) => {
            "There are no validation data: nothing says yet how well the model predicts.".to_owned()
        }
    }
}

/// Measured against simulated heading, on the training run and on validation data (Figs. 10 and 11).
pub(super) fn figure(source: &Source) -> Option<Figure> {
    let identification = source.identification?;
    let angle = source.axis.angle();
    let mut panels = Vec::new();
    let mut longest = 0.0_f64;
    for stage in [Stage::Train, Stage::Validate] {
        let Some(comparison) = Comparison::new(source, stage, identification) else {
            continue;
        };
        longest = longest.max(comparison.window.to_s - comparison.window.from_s);
        panels.push(comparison.heading(&source.angle(), identification));
        if stage == Stage::Validate {
            panels.push(comparison.difference());
            if source.axis == Axis::Yaw {
                panels.extend(comparison.rate());
            }
        }
    }
    if panels.is_empty() || longest <= 0.0 {
        return None;
    }
    let validated = validation_sentence(identification, angle);
    let chart = Chart {
        alt: format!("{}: measured and simulated {angle} over time. {validated}", source.name),
        x_label: "Time since the stage began, s",
        x_range: [0.0, longest],
        panels,
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        format!(
            "The model steered by the measured {} against what the vehicle did{}. {validated} The lines should lie on each other; \
             a drift late in the run is what the model cannot know: disturbance and noise.",
            source.axis.surface(),
            identification.validation.and_then(|validation| validation.horizon_s).map_or(
                String::new(),
                |horizon_s| format!(", started again every {} s", decimals(horizon_s, 0))
            )
        ),
    ))
}

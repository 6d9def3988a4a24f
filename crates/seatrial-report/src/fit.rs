//! Measured against simulated heading.

use seatrial_core::model::YawState;
use seatrial_core::{Axis, PitchModel, PitchState, Sample, YawModel};

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Panel};
use super::curves::{degrees, present, series, usable, yaw_rate};
use super::number::{self, decimals};
use super::source::Source;
use seatrial::campaign::Stage;
use seatrial::identification::Identification;
use seatrial::identify::validation::quiet_lead_in_s;
use seatrial::record::{Record, Window};

/// A model of yaw, or with a restoring moment m, 1/s^2, of pitch.
#[derive(Clone, Copy)]
struct Motion {
    model: YawModel<f64>,
    restoring_per_s2: Option<f64>,
}

impl Motion {
    /// The model of an identification that goes to the controller.
    fn of(identification: &Identification) -> Self {
        Self {
            model: identification.model(),
            restoring_per_s2: identification.restoring.map(|m| m.refined_per_s2),
        }
    }

    /// The model that was estimated sample by sample.
    fn live(identification: &Identification) -> Self {
        Self {
            model: identification.online.model,
            restoring_per_s2: identification.restoring.map(|m| m.online_per_s2),
        }
    }

    fn advance(&self, state: YawState<f64>, rudder_rad: f64, interval_s: f64) -> YawState<f64> {
        let Some(m) = self.restoring_per_s2 else {
            return self.model.advance(state, rudder_rad, interval_s);
        };
        let start = PitchState {
            pitch_rad: state.heading_rad,
            pitch_rate_rad_s: state.yaw_rate_rad_s,
        };
        let after = PitchModel::righted(&self.model, m).advance(start, rudder_rad, interval_s);
        YawState {
            heading_rad: after.pitch_rad,
            yaw_rate_rad_s: after.pitch_rate_rad_s,
        }
    }
}

/// A simulation of usable samples with the measured rudder, from the mean of the lead-in: the
/// initial conditions of [`Validation`](seatrial_core::validation::Validation).
fn simulated(samples: &[Sample<f64>], motion: &Motion) -> Vec<YawState<f64>> {
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
        state = motion.advance(state, pair[0].rudder_rad, pair[1].time_s - pair[0].time_s);
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

/// The simulation of a model over the measured heading of a record's window, as the report draws it.
pub fn overlay(record: &Record, window: Window, found: &Identification) -> Vec<Overlaid> {
    let samples = usable(record.window(window));
    let states = simulated(&samples, &Motion::of(found));
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
    span.is_finite().then(|| {
        [
            lowest.clamp(low - span, low),
            highest.clamp(high, high + span),
        ]
    })
}

/// A stage with what the model makes of it.
struct Comparison {
    stage: Stage,
    window: Window,
    samples: Vec<Sample<f64>>,
    states: Vec<YawState<f64>>,
    /// Heading over the time since the stage began, degrees.
    measured: Vec<[f64; 2]>,
    /// That of the model, degrees.
    simulated: Vec<[f64; 2]>,
}

impl Comparison {
    /// `None` where the stage is missing or has fewer than two usable samples.
    fn new(source: &Source, stage: Stage, motion: &Motion) -> Option<Self> {
        let record = match stage {
            Stage::Validate => source.validation,
            Stage::Settle | Stage::Train => source.record,
        };
        let window = source.window(stage)?;
        let samples = usable(record.window(Window {
            to_s: window.to_s + 1e-6,
            ..window
        }));
        if samples.len() < 2 {
            return None;
        }
        let measured = series(&samples, window.from_s, |s| degrees(Some(s.heading_rad)));
        let states = simulated(&samples, motion);
        let mut comparison = Self {
            stage,
            window,
            samples,
            states,
            measured,
            simulated: Vec::new(),
        };
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
        pairs
            .map(|([t, _], state)| [*t, value(state).to_degrees()])
            .collect()
    }

    /// Measured and simulated heading; with that of the live model where it is another.
    fn heading(&self, angle: &str, live: Option<&Motion>) -> Panel {
        let name = match self.stage {
            Stage::Validate => "validation data",
            Stage::Settle | Stage::Train => "training",
        };
        let mut layers = vec![Layer::line("a", "measured", self.measured.clone())];
        if let Some(live) = live {
            let live = self.modelled(&simulated(&self.samples, live), |s| s.heading_rad);
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
        let layers = vec![
            Layer::level("zero", "", 0.0),
            Layer::line("a", "", difference.collect()),
        ];
        Panel::linear("Measured less model, validation, °", 50.0, layers)
    }

    /// Measured and simulated yaw rate. `None` where neither sensor nor heading gives one.
    fn rate(&self) -> Option<Panel> {
        let (rate, name) = yaw_rate(&self.samples, self.window.from_s);
        present(&rate).then(|| {
            let layers = vec![
                Layer::line("a", name, rate),
                Layer::line(
                    "b",
                    "model",
                    self.modelled(&self.states, |s| s.yaw_rate_rad_s),
                ),
            ];
            Panel::linear("Yaw rate, validation, °/s", 66.0, layers)
        })
    }
}

/// What validation says about the model, one sentence.
fn validation_sentence(identification: &Identification, angle: &str) -> String {
    let r2 = identification
        .validation
        .and_then(|v| v.judged_r2_heading());
    match (identification.validation, r2) {
        (Some(_), Some(r2)) => format!(
            "On validation data the model explains {} of the {angle} (R² = {}).",
            if r2 > 0.0 {
                format!("{} %", decimals(100.0 * r2, 0))
            } else {
                "nothing".to_owned()
            },
            number::r2(Some(r2))
        ),
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
    let motion = Motion::of(identification);
    let refined = identification.refined.as_ref();
    let live = refined.map(|_| Motion::live(identification));
    let angle = source.axis.angle();
    let mut panels = Vec::new();
    let mut longest = 0.0_f64;
    for stage in [Stage::Train, Stage::Validate] {
        let Some(comparison) = Comparison::new(source, stage, &motion) else {
            continue;
        };
        longest = longest.max(comparison.window.to_s - comparison.window.from_s);
        panels.push(comparison.heading(&source.angle(), live.as_ref()));
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
        alt: format!(
            "{}: measured and simulated {angle} over time. {validated}",
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
            "The model steered by the measured {} against what the vehicle did. {validated} The lines should lie on each other; \
             a drift late in the run is what the model cannot know: disturbance and noise.",
            source.axis.surface()
        ),
    ))
}

//! The figures of one run: the manoeuvre, the estimates, measured against simulated heading.

use std::f64::consts::TAU;

use seatrial_core::model::YawState;
use seatrial_core::{Real, Sample, YawModel};

use super::Figure;
use super::chart::{Chart, Layer, Mark, PLOT_WIDTH, Panel, Shape, Span};
use super::number::decimals;
use crate::campaign::{Stage, StageSpan};
use crate::identification::Identification;
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window};
use crate::savitzky_golay::SavitzkyGolay;

/// A run or a log as the figures see it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub record: &'a Record,
    /// Where the validation window lies; the same record in a trial.
    pub fresh: &'a Record,
    pub stages: &'a [StageSpan],
    pub identification: Option<&'a Identification>,
    /// Name of the thing in captions and alternative texts, "80 % thrust, run 3".
    pub name: &'a str,
    /// The record's time at the left end of the manoeuvre's axis, s.
    pub origin_s: f64,
    pub time_label: &'static str,
}

impl Source<'_> {
    fn window(&self, stage: Stage) -> Option<Window> {
        let span = self.stages.iter().find(|span| span.stage == stage)?;
        let record = match stage {
            Stage::Validate => self.fresh,
            Stage::Settle | Stage::Train => self.record,
        };
        let samples = record.window(span.window);
        Some(Window {
            from_s: span.window.from_s.max(samples.first()?.time_s),
            to_s: span.window.to_s.min(samples.last()?.time_s),
        })
    }

    /// Are both windows on one time axis?
    fn one_record(&self) -> bool {
        std::ptr::eq(self.record, self.fresh)
    }
}

fn stage_name(stage: Stage) -> (&'static str, &'static str) {
    match stage {
        Stage::Settle => ("settle", "span-settle"),
        Stage::Train => ("train", "span-train"),
        Stage::Validate => ("validate", "span-validate"),
    }
}

/// The same samples with the jumps of the heading at the wrap taken out, the first heading between
/// 0 and a full turn.
pub(super) fn unwrapped(samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let mut last: Option<[f64; 2]> = None;
    let smooth = samples.iter().map(|sample| {
        let heading_rad = last.map_or(sample.heading_rad.rem_euclid(TAU), |[unwrapped, raw]| {
            unwrapped + (sample.heading_rad - raw).wrapped()
        });
        if heading_rad.is_finite() {
            last = Some([heading_rad, sample.heading_rad]);
        }
        Sample {
            heading_rad,
            ..*sample
        }
    });
    smooth.collect()
}

fn series(
    samples: &[Sample<f64>],
    origin_s: f64,
    value: impl Fn(&Sample<f64>) -> Option<f64>,
) -> Vec<[f64; 2]> {
    let points = samples
        .iter()
        .map(|sample| [sample.time_s - origin_s, value(sample).unwrap_or(f64::NAN)]);
    points.collect()
}

fn degrees(value: Option<f64>) -> Option<f64> {
    value.map(f64::to_degrees)
}

/// The yaw rate in deg/s and its name: as measured or, where it was not, the slope of parabolas
/// over 11 samples of heading (Fig. 15).
fn yaw_rate(samples: &[Sample<f64>], origin_s: f64) -> (Vec<[f64; 2]>, &'static str) {
    let measured = series(samples, origin_s, |s| degrees(s.yaw_rate_rad_s));
    if present(&measured) {
        return (measured, "measured");
    }
    let usable = usable(samples);
    let times: Vec<f64> = usable.iter().map(|s| s.time_s).collect();
    let headings: Vec<f64> = usable.iter().map(|s| s.heading_rad).collect();
    let rates = SavitzkyGolay::new(5, 2).and_then(|f| f.derivative(&times, &headings));
    let points = times.into_iter().zip(rates.unwrap_or_default());
    let points = points.map(|(t, rate)| [t - origin_s, rate.to_degrees()]);
    (points.collect(), "from heading")
}

/// Is there anything finite to draw?
fn present(points: &[[f64; 2]]) -> bool {
    points.iter().any(|point| point[1].is_finite())
}

/// Heading, rudder, rate and what else was measured, with the stages shaded (Figs. 5 and 7).
pub(super) fn manoeuvre(source: &Source) -> Option<Figure> {
    let all = &source.record.samples;
    let windows: Vec<Window> = [Stage::Settle, Stage::Train, Stage::Validate]
        .into_iter()
        .filter(|stage| *stage != Stage::Validate || source.one_record())
        .filter_map(|stage| source.window(stage))
        .collect();
    let (first, last) = (all.first()?.time_s, all.last()?.time_s);
    let (from_s, to_s) = match windows.iter().copied().reduce(|a, b| Window {
        from_s: a.from_s.min(b.from_s),
        to_s: a.to_s.max(b.to_s),
    }) {
        // A log may be hours longer than what was used of it.
        Some(used) => {
            let margin = 0.25 * (used.to_s - used.from_s);
            (
                first.max(used.from_s - margin),
                last.min(used.to_s + margin),
            )
        }
        None => (first, last),
    };
    let samples = source.record.window(Window {
        from_s,
        to_s: to_s + 1e-6,
    });
    let line = |value: fn(&Sample<f64>) -> Option<f64>| series(samples, source.origin_s, value);
    let heading = series(&unwrapped(samples), source.origin_s, |s| {
        degrees(Some(s.heading_rad))
    });
    if samples.len() < 2 || to_s <= from_s {
        return None;
    }
    let mut panels = vec![
        Panel::linear("Heading, °", 92.0, vec![Layer::line("a", "", heading)]),
        Panel::linear(
            "Rudder, °",
            66.0,
            vec![Layer::line("b", "", line(|s| degrees(Some(s.rudder_rad))))],
        ),
    ];
    let (rate, name) = yaw_rate(samples, source.origin_s);
    if present(&rate) {
        let layers = vec![Layer::line("a", name, rate)];
        panels.push(Panel::linear("Yaw rate, °/s", 66.0, layers));
    }
    let (roll, pitch) = (
        line(|s| degrees(s.roll_rad)),
        line(|s| degrees(s.pitch_rad)),
    );
    if present(&roll) || present(&pitch) {
        let layers = vec![
            Layer::line("a", "roll", roll),
            Layer::line("b", "pitch", pitch),
        ];
        panels.push(Panel::linear("Roll and pitch, °", 50.0, layers).spanning_at_least(10.0));
    }
    for (label, least_span, points) in [
        ("Speed, m/s", 0.4, line(|s| s.surge_speed_m_s)),
        ("Depth, m", 1.0, line(|s| s.depth_m)),
    ] {
        if present(&points) {
            let layers = vec![Layer::line("a", "", points)];
            panels.push(Panel::linear(label, 44.0, layers).spanning_at_least(least_span));
        }
    }
    let spans = source
        .stages
        .iter()
        .filter(|span| span.stage != Stage::Validate || source.one_record())
        .filter_map(|span| {
            let window = source.window(span.stage)?;
            let (label, shade) = stage_name(span.stage);
            Some(Span {
                from: window.from_s - source.origin_s,
                to: window.to_s - source.origin_s,
                shade,
                label: label.to_owned(),
            })
        });
    let chart = Chart {
        alt: format!(
            "{}: heading, rudder and other measurements over {:.0} seconds, stages shaded.",
            source.name,
            to_s - from_s
        ),
        x_label: source.time_label,
        x_range: [from_s - source.origin_s, to_s - source.origin_s],
        spans: spans.collect(),
        marks: Vec::new(),
        panels,
    };
    Some(Figure::new(
        &chart,
        "The manoeuvre. The rudder kicks to both sides and the heading must follow; between the \
         kicks the heading controller holds course. Speed and depth should stay level."
            .to_owned(),
    ))
}

/// The estimates after every sample and their step norm (Figs. 6, 8 and 12).
pub(super) fn estimates(source: &Source) -> Option<Figure> {
    let identification = source.identification?;
    let trace = &identification.online.trace;
    let training = source.window(Stage::Train)?;
    let from = training.from_s;
    let (first, last) = (trace.first()?.time_s, trace.last()?.time_s);
    let samples = source.record.window(identification.training);
    let manoeuvre = Manoeuvre::find(samples);
    let armed_s = manoeuvre.as_ref().and_then(Manoeuvre::both_hands_used_s);
    let settled_s = armed_s.unwrap_or(0.5 * (first + last));

    let parameter = |index: usize, label: &str, name: &str| {
        let points = trace.iter().map(|p| [p.time_s - from, p.theta[index]]);
        let mut layers = Vec::new();
        let mut late: Vec<f64> = trace
            .iter()
            .filter(|p| p.time_s >= settled_s)
            .map(|p| p.theta[index])
            .filter(|value| value.is_finite())
            .collect();
        if let Some(refined) = &identification.refined {
            let [low, high] = [
                refined.interval_95.a22_per_s,
                refined.interval_95.b2_per_s2,
                refined.interval_95.c0_rad_per_s2,
            ][index];
            late.extend([low, high]);
            let band = Shape::Band([low, high]);
            layers.push(Layer::new("band", "final, 95 %", band));
            layers.push(Layer::level("b", "", refined.model.theta()[index]));
        }
        layers.push(Layer::line("a", "live", points.collect()));
        let low = late.iter().copied().fold(f64::INFINITY, f64::min);
        let high = late.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let around = (0.5 * (high - low)).max(0.15 * high.abs().max(low.abs()));
        Panel::linear(format!("{label} {name}"), 78.0, layers)
            .with_range((low <= high).then_some([low - around, high + around]))
    };
    let step_norm = trace
        .iter()
        .map(|p| [p.time_s - from, p.step_norm.max(1e-9)])
        .collect();
    let convergence = identification.online.convergence;
    let panels = vec![
        parameter(0, "Damping a₂₂,", "1/s"),
        parameter(1, "Rudder authority b₂,", "1/s²"),
        parameter(2, "Offset C₀,", "rad/s²"),
        Panel::logarithmic(
            "Change per sample",
            78.0,
            vec![
                Layer::level("b", "threshold", convergence.threshold),
                Layer::line("a", "step norm", step_norm),
            ],
        ),
    ];
    let mut spans = Vec::new();
    let mut marks = Vec::new();
    if let (Some(manoeuvre), Some(armed_s)) = (&manoeuvre, armed_s) {
        spans.push(Span {
            from: manoeuvre.starts_s - from,
            to: armed_s - from,
            shade: "span-train",
            label: "doublet".to_owned(),
        });
        marks.push(Mark {
            at: armed_s - from,
            label: "armed".to_owned(),
        });
    }
    let converged = convergence.detected_s.map(|at| {
        marks.push(Mark {
            at,
            label: format!("converged {} s", decimals(at, 1)),
        });
        format!(
            "It stayed below the threshold {} times in a row at {} s: from there on more data changed little.",
            convergence.consecutive,
            decimals(at, 1)
        )
    });
    let converged = converged.unwrap_or_else(|| {
        "It did not stay below the threshold: the estimates had not come to rest.".to_owned()
    });
    let chart = Chart {
        alt: format!(
            "{}: estimates of a22, b2 and C0 over training, and the change per sample on a logarithmic axis. {converged}",
            source.name
        ),
        x_label: "Time since training began, s",
        x_range: [0.0, training.to_s.max(last) - from],
        spans,
        marks,
        panels,
    };
    Some(Figure::new(
        &chart,
        format!(
            "The estimates while the vehicle manoeuvres. Before the doublet they mean nothing and may leave the picture; after it \
             they must come to rest. The change per sample is watched (“armed”) once the rudder has been to both sides. {converged}"
        ),
    ))
}

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

/// Length of the quiet part before the rudder works, s.
fn lead_in_s(samples: &[Sample<f64>]) -> f64 {
    let manoeuvre = Manoeuvre::find(samples).zip(samples.first());
    manoeuvre.map_or(0.0, |(m, first)| m.starts_s - first.time_s)
}

/// R^2 (35) of heading of any model on usable samples.
pub(super) fn heading_r2(samples: &[Sample<f64>], model: &YawModel<f64>) -> Option<f64> {
    let count = samples.len() as f64;
    let mean = samples.iter().map(|s| s.heading_rad).sum::<f64>() / count;
    let square = |difference: f64| difference * difference;
    let variance: f64 = samples.iter().map(|s| square(s.heading_rad - mean)).sum();
    let states = samples.iter().zip(simulated(samples, model));
    let error: f64 = states
        .map(|(s, state)| square(s.heading_rad - state.heading_rad))
        .sum();
    Some(1.0 - error / variance).filter(|r2| r2.is_finite())
}

/// A simulation of usable samples with the measured rudder, from the mean of the lead-in: the
/// initial conditions of the validation.
fn simulated(samples: &[Sample<f64>], model: &YawModel<f64>) -> Vec<YawState<f64>> {
    let Some(first) = samples.first() else {
        return Vec::new();
    };
    let lead_in_s = lead_in_s(samples);
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

/// Measured against simulated heading, on the training run and on fresh data (Figs. 10 and 11).
pub(super) fn fit(source: &Source) -> Option<Figure> {
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
        panels.push(Panel::linear(format!("Heading, {name}, °"), 88.0, layers));
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
    let r2 = identification.validation.and_then(|v| v.r2_heading);
    let fresh = match (identification.validation, r2) {
        (Some(_), Some(r2)) => format!(
            "On fresh data the model explains {} of the heading (R² = {}).",
            if r2 > 0.0 {
                format!("{} %", decimals(100.0 * r2, 0))
            } else {
                "nothing".to_owned()
            },
            decimals(r2, 3)
        ),
        (Some(_), None) => {
            "The heading of the fresh data did not vary: R² says nothing.".to_owned()
        }
        (None, _) => {
            "There are no fresh data: nothing says yet how well the model predicts.".to_owned()
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

/// The track seen from above, turned so that the course of the run points right (Fig. 7b).
pub(super) fn track(source: &Source) -> Option<Figure> {
    let positions = |samples: &[Sample<f64>]| -> Vec<[f64; 2]> {
        let known = samples.iter().filter_map(|s| Some([s.north_m?, s.east_m?]));
        known
            .filter(|p| p[0].is_finite() && p[1].is_finite())
            .collect()
    };
    let all = positions(&source.record.samples);
    let (start, end) = (*all.first()?, *all.last()?);
    let (north, east) = (end[0] - start[0], end[1] - start[1]);
    let distance = north.hypot(east);
    let turned = |[n, e]: [f64; 2]| {
        let (n, e) = (n - start[0], e - start[1]);
        [
            (n * north + e * east) / distance,
            (n * east - e * north) / distance,
        ]
    };
    let path: Vec<[f64; 2]> = all.iter().copied().map(turned).collect();
    let range = |axis: usize| {
        let values = || path.iter().map(|point| point[axis]);
        [
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    let ([rear, front], [right, left]) = (range(0), range(1));
    if !((front - rear).is_finite() && (left - right).is_finite() && distance > 0.0) {
        return None;
    }
    let m_per_unit = (1.1 * (front - rear) / PLOT_WIDTH).max((left - right) / 240.0);
    let height = (1.3 * (left - right) / m_per_unit).max(70.0);
    let half_width = 0.5 * PLOT_WIDTH * m_per_unit;
    let (middle, across) = (0.5 * (rear + front), 0.5 * (right + left));
    // The panel widens its range by 6 % on either side.
    let half_height = 0.5 * height * m_per_unit / 1.12;
    let mut layers = vec![
        Layer::line("d", "", path.clone()),
        Layer::dots("d", "start", vec![[0.0, 0.0]]),
    ];
    for (stage, ink) in [(Stage::Train, "b"), (Stage::Validate, "a")] {
        if let Some(window) = source.window(stage).filter(|_| source.one_record()) {
            let path = positions(source.record.window(window));
            let path = path.into_iter().map(turned).collect();
            layers.push(Layer::line(ink, stage_name(stage).0, path));
        }
    }
    let chart = Chart {
        alt: format!(
            "{}: track seen from above, {} m long and {} m wide.",
            source.name,
            decimals(front - rear, 0),
            decimals(left - right, 1)
        ),
        x_label: "Along the course, m",
        x_range: [middle - half_width, middle + half_width],
        spans: Vec::new(),
        marks: Vec::new(),
        panels: vec![
            Panel::linear("Left of the course, m", height, layers)
                .with_range(Some([across - half_height, across + half_height])),
        ],
    };
    Some(Figure::new(
        &chart,
        "The track from above, from the first to the last position, both axes to one scale. Each \
         doublet bends it a little."
            .to_owned(),
    ))
}

//! The figures of one run: the manoeuvre, the estimates, the track.

use std::f64::consts::TAU;

use seatrial_core::{Real, Sample};

use super::Figure;
use super::chart::{Chart, Layer, Mark, PLOT_WIDTH, Panel, Shape, Span};
use super::fit::usable;
use super::number::{decimals, rudder_unit};
use seatrial::campaign::{Stage, StageSpan};
use seatrial::identification::Identification;
use seatrial::manoeuvre::Manoeuvre;
use seatrial::record::{Record, Window};
use seatrial::savitzky_golay::SavitzkyGolay;

/// A run or a log as the figures see it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub record: &'a Record,
    /// Where the validation window lies; the same record in a trial.
    pub fresh: &'a Record,
    pub stages: &'a [StageSpan],
    pub identification: Option<&'a Identification>,
    /// Its name in alternative texts.
    pub name: &'a str,
    /// The record's time at the left end of the manoeuvre's axis, s.
    pub origin_s: f64,
    /// A run of a trial, whose manoeuvres are known; otherwise a log of anything.
    pub is_trial: bool,
}

impl Source<'_> {
    pub(super) fn window(&self, stage: Stage) -> Option<Window> {
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

/// The same samples with the jumps of the heading at the wrap taken out, their mean between 0 and
/// a full turn.
pub(super) fn unwrapped(samples: &[Sample<f64>]) -> Vec<Sample<f64>> {
    let mut last: Option<[f64; 2]> = None;
    let headings = samples.iter().map(|sample| {
        let heading_rad = last.map_or(sample.heading_rad, |[unwrapped, raw]| {
            unwrapped + (sample.heading_rad - raw).wrapped()
        });
        if heading_rad.is_finite() {
            last = Some([heading_rad, sample.heading_rad]);
        }
        heading_rad
    });
    let headings: Vec<f64> = headings.collect();
    let finite = || headings.iter().filter(|heading| heading.is_finite());
    let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
    let turns = TAU * (mean / TAU).floor();
    let smooth = samples.iter().zip(&headings);
    smooth
        .map(|(sample, heading)| Sample {
            heading_rad: heading - turns,
            ..*sample
        })
        .collect()
}

pub(super) fn series(
    samples: &[Sample<f64>],
    origin_s: f64,
    value: impl Fn(&Sample<f64>) -> Option<f64>,
) -> Vec<[f64; 2]> {
    let points = samples
        .iter()
        .map(|sample| [sample.time_s - origin_s, value(sample).unwrap_or(f64::NAN)]);
    points.collect()
}

pub(super) fn degrees(value: Option<f64>) -> Option<f64> {
    value.map(f64::to_degrees)
}

/// The yaw rate in deg/s and its name: as measured or, where it was not, the slope of parabolas
/// over 11 samples of heading (Fig. 15).
pub(super) fn yaw_rate(samples: &[Sample<f64>], origin_s: f64) -> (Vec<[f64; 2]>, &'static str) {
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
pub(super) fn present(points: &[[f64; 2]]) -> bool {
    points.iter().any(|point| point[1].is_finite())
}

/// The rudder in degrees, or in per cent of full where nobody said which angle that is.
fn rudder_panel(samples: &[Sample<f64>], source: &Source) -> Panel {
    let (scale, unit) = rudder_unit(source.record.rudder_unit);
    let mut points = series(samples, source.origin_s, |s| Some(s.rudder_rad));
    points.iter_mut().for_each(|point| point[1] *= scale);
    let layers = vec![Layer::line("b", "", points)];
    Panel::linear(format!("Rudder, {unit}"), 66.0, layers)
}

/// Heading, rudder, rate and what else was measured, with the stages shaded (Figs. 5 and 7).
pub(super) fn manoeuvre(source: &Source) -> Option<Figure> {
    let all = &source.record.samples;
    let windows: Vec<Window> = [Stage::Settle, Stage::Train, Stage::Validate]
        .into_iter()
        .filter(|stage| *stage != Stage::Validate || source.one_record())
        .filter_map(|stage| source.window(stage))
        .collect();
    let mut times = all.iter().map(|s| s.time_s).filter(|t| t.is_finite());
    let (first, last) = (times.next()?, times.next_back()?);
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
        rudder_panel(samples, source),
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
        x_label: if source.is_trial {
            "Time since the run began, s"
        } else {
            "Time in the log, s"
        },
        x_range: [from_s - source.origin_s, to_s - source.origin_s],
        spans: spans.collect(),
        marks: Vec::new(),
        panels,
    };
    Some(Figure::new(
        &chart,
        if source.is_trial {
            "The manoeuvre. The rudder kicks to both sides and the heading must follow; between the kicks the heading controller holds \
             course. Speed and depth should stay level."
        } else {
            "What the log holds, with the stretches used for training and for validation shaded. The heading must follow the rudder; \
             speed and depth should stay level."
        }
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
    let armed_s = manoeuvre.as_ref().and_then(Manoeuvre::both_sides_used_s);
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
            label: if source.is_trial {
                "doublet"
            } else {
                "excitation"
            }
            .to_owned(),
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
            "At {1} s it had been below the threshold {0} times in a row, the criterion for an early stop.",
            convergence.consecutive,
            decimals(at, 1)
        )
    });
    let converged = converged.unwrap_or_else(|| {
        "It was never below the threshold for long enough: the estimates had not come to rest."
            .to_owned()
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
            "The estimates while the vehicle manoeuvres. Until the rudder has been to both sides they mean little and may leave the picture; \
             then their change per sample is watched (“armed”) and they must come to rest. {converged}"
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_headings_across_the_wrap_are_one_line() {
        let degrees = [179.0, -179.0, f64::NAN, 178.0, 181.0 - 360.0];
        let samples = degrees.map(|heading: f64| Sample {
            heading_rad: heading.to_radians(),
            ..Sample::default()
        });
        let unwrapped = unwrapped(&samples);
        let found = unwrapped.iter().map(|s| s.heading_rad.to_degrees().round());
        let found: Vec<f64> = found.filter(|heading| heading.is_finite()).collect();
        assert_eq!(found, [179.0, 181.0, 178.0, 181.0]);
    }
}

//! The figures of one run: the manoeuvre, the estimates, the track.

use seatrial_core::{Axis, Sample};

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Mark, Panel, Shape, Span};
use super::curves::{degrees, present, series, unwrapped, yaw_rate};
use super::number::{decimals, rudder_unit};
use super::plan_view::{PlanView, Room};
use super::source::{Source, stage_name};
use seatrial::Window;
use seatrial::campaign::Stage;
use seatrial::identification::Identification;
use seatrial::log::Manoeuvre;

/// Heading, rudder, rate and what else was measured, with the stages shaded (Figs. 5 and 7).
pub(super) fn manoeuvre(source: &Source) -> Option<Figure> {
    let shown = shown(source)?;
    let samples = source.record.window(Window { to_s: shown.to_s + 1e-6, ..shown });
    if samples.len() < 2 || shown.to_s <= shown.from_s {
        return None;
    }
    let chart = Chart {
        alt: format!(
            "{}: {}, {} and other measurements over {:.0} seconds, stages shaded.",
            source.name,
            source.axis.angle(),
            source.axis.surface(),
            shown.to_s - shown.from_s
        ),
        x_label: if source.is_trial { "Time since the run began, s" } else { "Time in the log, s" },
        x_range: [shown.from_s - source.origin_s, shown.to_s - source.origin_s],
        spans: stage_spans(source),
        marks: Vec::new(),
        panels: measurements(samples, source),
    };
    Some(Figure::new(
        &chart,
        if source.axis == Axis::Pitch {
            "The manoeuvre. The elevator kicks up and down and the pitch must follow; between the kicks the vehicle holds its depth. \
             Speed should stay level."
        } else if source.is_trial {
            "The manoeuvre. The rudder kicks to both sides and the heading must follow; between the kicks the heading controller holds \
             course. Speed and depth should stay level."
        } else if source.identification.is_some_and(Identification::is_validated_within) {
            "What the log holds. All of the shaded part is for training; a model of its first part predicted the part for validation. The \
             heading must follow the rudder; speed and depth should stay level."
        } else {
            "What the log holds, with the segments used for training and for validation shaded. The heading must follow the rudder; \
             speed and depth should stay level."
        }
        .to_owned(),
    ))
}

/// The stages and a quarter of their length around them, or the whole record where there are none.
fn shown(source: &Source) -> Option<Window> {
    let windows = [Stage::Settle, Stage::Train, Stage::Validate]
        .into_iter()
        .filter(|stage| *stage != Stage::Validate || source.one_record())
        .filter_map(|stage| source.window(stage));
    let used =
        windows.reduce(|a, b| Window { from_s: a.from_s.min(b.from_s), to_s: a.to_s.max(b.to_s) });
    let all = &source.record.samples;
    let mut times = all.iter().map(|s| s.time_s).filter(|t| t.is_finite());
    let (first, last) = (times.next()?, times.next_back()?);
    Some(match used {
        // A log may be hours longer than what was used of it.
        Some(used) => {
            let margin = 0.25 * (used.to_s - used.from_s);
            Window { from_s: first.max(used.from_s - margin), to_s: last.min(used.to_s + margin) }
        }
        None => Window { from_s: first, to_s: last },
    })
}

/// A panel for each quantity that was measured.
fn measurements(samples: &[Sample<f64>], source: &Source) -> Vec<Panel> {
    let origin_s = source.origin_s;
    let line = |value: fn(&Sample<f64>) -> Option<f64>| series(samples, origin_s, value);
    let heading = series(&unwrapped(samples), origin_s, |s| degrees(Some(s.heading_rad)));
    let mut panels = vec![
        Panel::linear(format!("{}, °", source.angle()), 92.0, vec![Layer::line("a", "", heading)]),
        rudder_panel(samples, source),
    ];
    let (rate, name) = yaw_rate(samples, origin_s);
    if source.axis.is_yaw() && present(&rate) {
        let layers = vec![Layer::line("a", name, rate)];
        panels.push(Panel::linear("Yaw rate, °/s", 66.0, layers));
    }
    let roll = line(|s| degrees(s.roll_rad));
    // On the axis of pitch it is drawn above.
    let pitch = match source.axis {
        Axis::Yaw => line(|s| degrees(s.pitch_rad)),
        Axis::Pitch => Vec::new(),
    };
    if present(&roll) || present(&pitch) {
        let layers = vec![Layer::line("a", "roll", roll), Layer::line("b", "pitch", pitch)];
        panels.push(Panel::linear("Roll and pitch, °", 50.0, layers).spanning_at_least(10.0));
    }
    for (label, least_span, points) in
        [("Speed, m/s", 0.4, line(|s| s.surge_speed_m_s)), ("Depth, m", 1.0, line(|s| s.depth_m))]
    {
        if present(&points) {
            let layers = vec![Layer::line("a", "", points)];
            panels.push(Panel::linear(label, 44.0, layers).spanning_at_least(least_span));
        }
    }
    panels
}

/// The rudder in degrees, or in per cent of full where nobody said which angle that is.
fn rudder_panel(samples: &[Sample<f64>], source: &Source) -> Panel {
    let (scale, unit) = rudder_unit(source.record.rudder_unit);
    let rudder = series(samples, source.origin_s, |s| Some(scale * s.rudder_rad));
    let layers = vec![Layer::line("b", "", rudder)];
    Panel::linear(format!("{}, {unit}", source.surface()), 66.0, layers)
}

/// The stages that lie in the record itself, shaded.
fn stage_spans(source: &Source) -> Vec<Span> {
    let stages = source.stages.iter();
    stages
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
        })
        .collect()
}

/// The estimates after every sample and their step norm (Figs. 6, 8 and 12).
pub(super) fn estimates(source: &Source) -> Option<Figure> {
    let identification = source.identification?;
    let trace = &identification.online.trace;
    let training = source.window(Stage::Train)?;
    let from = training.from_s;
    let (first, last) = (trace.first()?.time_s, trace.last()?.time_s);
    let manoeuvre = Manoeuvre::find(source.record.window(identification.training));
    let armed_s = manoeuvre.as_ref().and_then(Manoeuvre::both_sides_used_s);
    let settled_s = armed_s.unwrap_or(0.5 * (first + last));
    let parameter = |index, label| parameter(identification, index, label, from, settled_s);
    let authority = match source.axis {
        Axis::Yaw => "Rudder authority b₂, 1/s²",
        Axis::Pitch => "Elevator authority b₂, 1/s²",
    };
    let panels = vec![
        parameter(0, "Damping a₂₂, 1/s"),
        parameter(1, authority),
        parameter(2, "Offset C₀, rad/s²"),
        step_norm(identification, from),
    ];
    let mut spans = Vec::new();
    let mut marks = Vec::new();
    if let (Some(manoeuvre), Some(armed_s)) = (&manoeuvre, armed_s) {
        spans.push(Span {
            from: manoeuvre.starts_s - from,
            to: armed_s - from,
            shade: "span-train",
            label: if source.is_trial { "doublet" } else { "excitation" }.to_owned(),
        });
        marks.push(Mark { at: armed_s - from, label: "armed".to_owned() });
    }
    marks.extend(
        identification
            .online
            .convergence
            .detected_s
            .map(|at| Mark { at, label: format!("converged {} s", decimals(at, 1)) }),
    );
    let converged = convergence_sentence(identification);
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
            "The estimates while the vehicle manoeuvres. Until the {} has been to both sides they mean little and may leave the picture; \
             then their change per sample is watched (“armed”) and they must come to rest. {converged}",
            source.axis.surface()
        ),
    ))
}

/// The live estimates of one parameter with the final one and its interval. The axis shows what
/// came after `settled_s`.
fn parameter(
    identification: &Identification,
    index: usize,
    label: &str,
    from: f64,
    settled_s: f64,
) -> Panel {
    let trace = &identification.online.trace;
    let points = trace.iter().map(|p| [p.time_s - from, p.theta[index]]);
    let mut layers = Vec::new();
    let late = trace.iter().filter(|p| p.time_s >= settled_s);
    let late = late.map(|p| p.theta[index]).filter(|v| v.is_finite());
    let mut late: Vec<f64> = late.collect();
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
    let [low, high] = extent(late);
    let around = (0.5 * (high - low)).max(0.15 * high.abs().max(low.abs()));
    Panel::linear(label, 78.0, layers)
        .with_range((low <= high).then_some([low - around, high + around]))
}

/// The change per sample and the threshold that tells convergence.
fn step_norm(identification: &Identification, from: f64) -> Panel {
    let online = &identification.online;
    let norms = online.trace.iter().map(|p| [p.time_s - from, p.step_norm.max(1e-9)]);
    let norms = Layer::line("a", "step norm", norms.collect());
    let threshold = Layer::level("b", "threshold", online.convergence.threshold);
    Panel::logarithmic("Change per sample", 78.0, vec![threshold, norms])
}

/// When the estimates came to rest, one sentence.
fn convergence_sentence(identification: &Identification) -> String {
    let convergence = identification.online.convergence;
    let Some(at) = convergence.detected_s else {
        return "It was never below the threshold for long enough: the estimates had not come to rest."
            .to_owned();
    };
    format!(
        "At {} s it had been below the threshold {} times in a row, the criterion for an early stop.",
        decimals(at, 1),
        convergence.consecutive
    )
}

/// The known positions of the samples, north and east.
fn positions(samples: &[Sample<f64>]) -> Vec<[f64; 2]> {
    let known = samples.iter().filter_map(|s| Some([s.north_m?, s.east_m?]));
    known.filter(|p| p[0].is_finite() && p[1].is_finite()).collect()
}

/// The track seen from above, turned so that the course of the run points right (Fig. 7b).
pub(super) fn track(source: &Source) -> Option<Figure> {
    let all = positions(&source.record.samples);
    let (start, end) = (*all.first()?, *all.last()?);
    let (north, east) = (end[0] - start[0], end[1] - start[1]);
    let distance = libm::hypot(north, east);
    let turned = |[n, e]: [f64; 2]| {
        let (n, e) = (n - start[0], e - start[1]);
        [(n * north + e * east) / distance, (n * east - e * north) / distance]
    };
    let path: Vec<[f64; 2]> = all.iter().copied().map(turned).collect();
    let room = Room { over_tracks: 1.3, highest: 240.0, least_height: 70.0 };
    let view = PlanView::new(path.iter(), &room).filter(|_| distance > 0.0)?;
    let mut layers = vec![Layer::line("d", "", path), Layer::dots("d", "start", vec![[0.0, 0.0]])];
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
            decimals(view.length_m, 0),
            decimals(view.width_m, 1)
        ),
        x_label: "Along the course, m",
        x_range: view.along_m,
        panels: vec![
            Panel::linear("Left of the course, m", view.height, layers)
                .with_range(Some(view.across_m)),
        ],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        format!(
            "The track from above, from the first to the last position, both axes to one scale.{}",
            match source.is_trial {
                true => " Each doublet bends it a little.",
                false => "",
            }
        ),
    ))
}

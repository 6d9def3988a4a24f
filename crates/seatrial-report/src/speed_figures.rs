//! The figures of a whole trial: how steering changes with speed.

use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::heading_control::HeadingGain;
use seatrial_core::heading_loop::{HeadingLoop, Margins};
use seatrial_core::schedule::SchedulePoint;

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Panel, Span};
use super::number::{percent, significant};
use seatrial::campaign::{Campaign, Run};
use seatrial::gains::{DAMPING_RATIO, GainAllowance};
use seatrial::identification::{Identification, TracePoint, interval_95};

/// An accepted run with its model and gain.
pub(super) struct Speed<'a> {
    pub run: &'a Run,
    pub identification: &'a Identification,
    pub point: SchedulePoint<f64>,
    pub allowance: GainAllowance,
    /// The gain to load.
    pub gain: Option<HeadingGain<f64>>,
    pub margins: Option<Margins<f64>>,
}

/// The accepted runs in order of thrust.
pub(super) fn accepted(campaign: &Campaign) -> Vec<Speed<'_>> {
    let runs = campaign.accepted_runs().into_iter();
    runs.filter_map(|run| {
        let identification = run.identification.as_ref()?;
        let model = identification.model();
        let allowance = GainAllowance::of(identification);
        let gain = allowance.design(&model, DAMPING_RATIO).ok();
        let margins = gain
            .and_then(|gain| HeadingLoop::new(&model, gain.proportional_gain).ok())
            .and_then(|closed| closed.margins(allowance.timing).ok());
        Some(Speed {
            run,
            identification,
            point: SchedulePoint {
                thrust: Some(run.thrust),
                surge_speed_m_s: run.surge_speed_m_s,
                model,
            },
            allowance,
            gain,
            margins,
        })
    })
    .collect()
}

/// 95 % interval of K_p.
pub(super) fn gain_interval(speed: &Speed) -> Option<[f64; 2]> {
    let refined = speed.identification.refined.as_ref()?;
    interval_95(&refined.model, &refined.covariance, |model| {
        let gain = speed.allowance.design(model, DAMPING_RATIO).ok()?;
        Some(gain.proportional_gain)
    })
}

/// The models with their speeds.
pub(super) fn points(speeds: &[Speed]) -> Vec<SchedulePoint<f64>> {
    speeds.iter().map(|speed| speed.point).collect()
}

/// Evenly spaced values from `from` to `to`, with `count` steps between them.
pub(super) fn evenly(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |k| from + (to - from) * f64::from(k) / f64::from(count))
}

/// b2 against V^2 with both fits (Fig. 9).
pub(super) fn authority(speeds: &[Speed]) -> Option<Figure> {
    let known = || speeds.iter().filter_map(|speed| Some((speed, speed.point.surge_speed_m_s?)));
    let points = points(speeds);
    let through_zero = AuthorityFit::new(&points, AuthorityForm::ThroughZero).ok()?;
    let with_constant = AuthorityFit::new(&points, AuthorityForm::WithConstant).ok()?;
    let [slowest, fastest] = with_constant.speed_range_m_s;
    let widest = 1.1 * fastest * fastest;
    let line = |fit: &AuthorityFit<f64>| {
        let squares = evenly(0.0, widest, 60);
        squares.map(|v2| [v2, *fit.b2_per_s2(v2.sqrt()).value()]).collect()
    };
    let bars = known().filter_map(|(speed, v)| {
        let [low, high] = speed.identification.refined.as_ref()?.interval_95.b2_per_s2;
        Some([v * v, low, high])
    });
    let dots = known().map(|(speed, v)| [v * v, speed.point.model.b2_per_s2]);
    let chart = Chart {
        alt: format!(
            "Rudder authority b2 against speed squared at {} speeds with two straight fits.",
            known().count()
        ),
        x_label: "Speed squared V², m²/s²",
        x_range: [0.0, widest],
        spans: vec![identified(slowest * slowest, fastest * fastest)],
        marks: Vec::new(),
        panels: vec![Panel::linear(
            "b₂, 1/s²",
            190.0,
            vec![
                Layer::line("c", "through zero", line(&through_zero)),
                Layer::line("b", "with constant", line(&with_constant)),
                Layer::bars("a", "", bars.collect()),
                Layer::dots("a", "measured", dots.collect()),
            ],
        )],
    };
    let k = with_constant.per_speed_squared_per_m2;
    let c = with_constant.constant_per_s2;
    Some(Figure::new(
        &chart,
        format!(
            "Rudder authority grows with the square of speed. Fitted with a constant: b₂ = {} V² {} {} (rms residual {} 1/s²); \
             through zero, as the force of a fin: b₂ = {} V² ({} 1/s²). Where the two lines part, below and above the identified \
             speeds, neither is measured.",
            significant(k, 3),
            if c < 0.0 { "−" } else { "+" },
            significant(c.abs(), 3),
            significant(with_constant.rms_residual_per_s2, 2),
            significant(through_zero.per_speed_squared_per_m2, 3),
            significant(through_zero.rms_residual_per_s2, 2),
        ),
    ))
}

/// The identified part of a horizontal axis, shaded.
pub(super) fn identified(from: f64, to: f64) -> Span {
    Span { from, to, shade: "span-train", label: "identified".to_owned() }
}

/// The estimates of every accepted speed on one axis (Figs. 8 and 12).
pub(super) fn together(speeds: &[Speed]) -> Option<Figure> {
    let traces = traces(speeds);
    let longest = traces
        .iter()
        .filter_map(|trace| Some(trace.points.last()?.time_s - trace.from_s))
        .fold(0.0, f64::max);
    if longest <= 0.0 {
        return None;
    }
    let threshold = speeds.first()?.identification.online.convergence.threshold;
    let chart = Chart {
        alt: format!(
            "Live estimates of a22, b2 and C0 at {} speeds over training, and the change per sample on a logarithmic axis.",
            speeds.len()
        ),
        x_label: "Time since training began, s",
        x_range: [0.0, longest],
        panels: vec![
            parameters(&traces, "Damping a₂₂, 1/s", 0),
            parameters(&traces, "Rudder authority b₂, 1/s²", 1),
            parameters(&traces, "Offset C₀, rad/s²", 2),
            step_norms(&traces, threshold),
        ],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        "The live estimates of all speeds on one axis. Each must come to rest after its doublet; a₂₂ should differ little between speeds, \
         b₂ should grow with speed."
            .to_owned(),
    ))
}

/// The live estimates at one speed and how they are drawn.
struct Trace<'a> {
    ink: &'static str,
    thrust: f64,
    /// When training began, s.
    from_s: f64,
    points: &'a [TracePoint],
}

fn traces<'a>(speeds: &'a [Speed]) -> Vec<Trace<'a>> {
    const INKS: [&str; 5] = ["s1", "s2", "s3", "s4", "s5"];
    let inked = speeds.iter().zip(INKS.iter().cycle());
    inked
        .map(|(speed, ink)| Trace {
            ink,
            thrust: speed.run.thrust,
            from_s: speed.identification.training.from_s,
            points: &speed.identification.online.trace,
        })
        .collect()
}

/// One parameter at every speed; the axis shows the last estimates. The first panel names the speeds.
fn parameters(traces: &[Trace], label: &str, index: usize) -> Panel {
    let last = traces.iter().filter_map(|trace| Some(trace.points.last()?.theta[index]));
    let [low, high] = extent(last.chain([0.0]));
    let margin = 0.35 * (high - low);
    let lines = traces.iter().map(|trace| {
        let name = if index == 0 { percent(trace.thrust) } else { String::new() };
        let points = trace.points.iter();
        let points = points.map(|p| [p.time_s - trace.from_s, p.theta[index]]);
        Layer::line(trace.ink, &name, points.collect())
    });
    Panel::linear(label, 84.0, lines.collect()).with_range(Some([low - margin, high + margin]))
}

fn step_norms(traces: &[Trace], threshold: f64) -> Panel {
    let mut norms = vec![Layer::level("zero", "threshold", threshold)];
    norms.extend(traces.iter().map(|trace| {
        let points = trace.points.iter().map(|p| [p.time_s - trace.from_s, p.step_norm.max(1e-9)]);
        Layer::line(trace.ink, "", points.collect())
    }));
    Panel::logarithmic("Change per sample", 90.0, norms)
}

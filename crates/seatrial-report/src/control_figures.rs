//! The heading controller over thrust: gains, margins and what the gains would do.

use std::cmp::Ordering;

use seatrial_core::heading_control::{GainSchedule, HeadingGain};
use seatrial_core::heading_loop::Margins;
use seatrial_core::schedule::{ScheduleKey, SpeedSchedule};

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Panel};
use super::number::percent;
use super::speed_figures::{Speed, gain_interval, points};
use seatrial::gains::{DAMPING_RATIO, least_damped_schedule};
use seatrial::sea_trials::field::{Control, HeadingStepSample, HeadingSteps};

/// A speed with its gain and its thrust in per cent.
type SpeedDesign<'a> = (&'a Speed<'a>, HeadingGain<f64>, f64);

/// Gain, feed-forward and margins over thrust (Fig. 18).
pub(super) fn gains(speeds: &[Speed]) -> Option<Figure> {
    let designed =
        speeds.iter().filter_map(|speed| Some((speed, speed.gain?, 100.0 * speed.run.thrust)));
    let designed: Vec<SpeedDesign> = designed.collect();
    let [low, high] = extent(designed.iter().map(|(.., thrust)| *thrust));
    if low.partial_cmp(&high) != Some(Ordering::Less) {
        return None;
    }
    let feed_forward = designed
        .iter()
        .map(|(_, gain, thrust)| [*thrust, gain.feed_forward_rudder_rad.to_degrees()]);
    let margin = |of: fn(&Margins<f64>) -> Option<f64>| -> Vec<[f64; 2]> {
        let known = designed.iter();
        known.filter_map(|(speed, _, thrust)| Some([*thrust, of(&speed.margins?)?])).collect()
    };
    let phase = margin(|m| m.phase_margin_rad.map(f64::to_degrees));
    let delay = margin(|m| m.delay_margin_s);
    let chart = Chart {
        alt: format!(
            "Heading gain, feed-forward rudder, phase margin and delay margin from {low:.0} to {high:.0} per cent thrust."
        ),
        x_label: "Thrust, %",
        x_range: [low - 0.08 * (high - low), high + 0.08 * (high - low)],
        panels: vec![
            proportional_gains(&designed, [low, high]),
            joined_dots("Feed-forward rudder −δ₀, °", feed_forward.collect()),
            joined_dots("Phase margin, °", phase).spanning_at_least(30.0),
            joined_dots("Delay margin, s", delay),
        ],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        "The gain at each thrust with its 95 % interval, the rudder that holds a straight course, and how much \
         phase and dead time the sampled loop has to spare. Between thrusts the gain is that of the model between; the dashed line, as in the paper, joins \
         the gains of the two end points."
            .to_owned(),
    ))
}

/// The gain at each thrust with its interval, and the line between those of the end points.
fn proportional_gains(designed: &[SpeedDesign], ends: [f64; 2]) -> Panel {
    let gain_at = |thrust: f64| {
        let of = designed.iter().find(|(.., t)| *t == thrust);
        of.map_or(f64::NAN, |(_, gain, _)| gain.proportional_gain)
    };
    let dots = designed.iter();
    let dots: Vec<[f64; 2]> =
        dots.map(|(_, gain, thrust)| [*thrust, gain.proportional_gain]).collect();
    let bars = designed.iter().filter_map(|(speed, _, thrust)| {
        let [low, high] = gain_interval(speed)?;
        Some([*thrust, low, high])
    });
    let line = ends.map(|thrust| [thrust, gain_at(thrust)]);
    let layers = vec![
        Layer::line("c", "end to end", line.to_vec()),
        Layer::line("b", "schedule", dots.clone()),
        Layer::bars("a", "", bars.collect()),
        Layer::dots("a", "designed", dots),
    ];
    Panel::linear("Kₚ, °/°", 120.0, layers)
}

/// A dot at each thrust with a line through them.
fn joined_dots(label: &str, points: Vec<[f64; 2]>) -> Panel {
    let layers = vec![Layer::line("b", "", points.clone()), Layer::dots("a", "", points)];
    Panel::linear(label, 60.0, layers)
}

/// The heading-step experiment, simulated: the gain of the lowest thrust everywhere against the
/// schedule (Fig. 17).
pub(super) fn heading_steps(speeds: &[Speed], rudder_limit_rad: f64) -> Option<Figure> {
    let schedule = SpeedSchedule::new(ScheduleKey::Thrust, &points(speeds)).ok()?;
    let allowed = speeds.iter().map(|speed| (speed.point, speed.allowance));
    let (cautious, timing) = least_damped_schedule(ScheduleKey::Thrust, allowed).ok()?;
    let gains = GainSchedule::design(cautious, DAMPING_RATIO, timing).ok()?;
    let paper = HeadingSteps::default();
    let experiment = HeadingSteps {
        rudder_limit_rad,
        damping_ratio: DAMPING_RATIO,
        delay_s: timing.delay_s,
        sample_interval_s: timing.sample_interval_s.unwrap_or(paper.sample_interval_s),
        ..paper
    };
    let runs = experiment.run(&schedule, &gains).ok()?;
    // Constant and scheduled come in pairs, one pair a thrust.
    let pairs = runs.chunks_exact(2).enumerate();
    let panels: Vec<Panel> = pairs
        .map(|(k, pair)| {
            let [constant, scheduled] = [&pair[0], &pair[1]];
            let thrust = constant.point.thrust;
            step_panel(thrust, &constant.series, &scheduled.series, k == 0)
        })
        .collect();
    let worst = |control: Control| {
        let runs = runs.iter().filter(|run| run.control == control);
        let overshoots = runs.flat_map(|run| run.measures.map(|measure| measure.overshoot));
        overshoots.fold(0.0, f64::max)
    };
    let (constant, scheduled) = (worst(Control::Constant), worst(Control::Scheduled));
    let chart = Chart {
        alt: format!(
            "Simulated heading steps of 20 degrees at {} thrusts with a constant and with a scheduled gain.",
            panels.len()
        ),
        x_label: "Time since the first step, s",
        x_range: [0.0, 2.0 * experiment.hold_s],
        panels,
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        format!(
            "What the gains would do: heading steps of 20° and back, simulated with the identified models and the delays of the loop. The constant gain is that of the lowest \
             thrust without feed-forward. Worst overshoot {} with the constant gain, {} with the schedule.",
            percent(constant),
            percent(scheduled)
        ),
    ))
}

/// The steps at one thrust with both gains; `named` puts the names in the legend.
pub(super) fn step_panel(
    thrust: Option<f64>,
    constant: &[HeadingStepSample],
    scheduled: &[HeadingStepSample],
    named: bool,
) -> Panel {
    let degrees = |steps: &[HeadingStepSample], of: fn(&HeadingStepSample) -> f64| {
        let degrees = steps.iter().map(|s| [s.time_s, of(s).to_degrees()]);
        degrees.collect::<Vec<_>>()
    };
    let thrust = thrust.map_or(String::new(), percent);
    let name = |text: &'static str| if named { text } else { "" };
    let layers = vec![
        Layer::line("zero", name("wanted"), degrees(constant, |s| s.command_rad)),
        Layer::line("c", name("constant gain"), degrees(constant, |s| s.heading_rad)),
        Layer::line("b", name("scheduled"), degrees(scheduled, |s| s.heading_rad)),
    ];
    Panel::linear(format!("{thrust}: heading, °"), 62.0, layers)
}

//! The figures of a whole trial: how steering changes with speed.

use std::cmp::Ordering;
use std::f64::consts::FRAC_1_SQRT_2;

use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::heading_control::{GainSchedule, HeadingGain};
use seatrial_core::heading_loop::{HeadingLoop, Margins};
use seatrial_core::schedule::{ScheduleKey, SchedulePoint, SpeedSchedule};
use seatrial_core::turning::{Side, Turn, TurningOverSpeed};

use super::Figure;
use super::chart::{Chart, Layer, Mark, Panel, Span};
use super::number::{decimals, percent, significant};
use seatrial::campaign::{Campaign, Run};
use seatrial::gain_allowance::{GainAllowance, least_damped_schedule};
use seatrial::heading_step::{Control, HeadingStepRun, HeadingStepSample, HeadingSteps};
use seatrial::identification::Identification;
use seatrial::propagation::interval_95;

/// The damping ratio of every gain here, that of equation (57): about 5 % overshoot.
pub(super) const DAMPING_RATIO: f64 = FRAC_1_SQRT_2;

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

fn points(speeds: &[Speed]) -> Vec<SchedulePoint<f64>> {
    speeds.iter().map(|speed| speed.point).collect()
}

/// So many evenly spaced values from `from` to `to`.
fn evenly(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |k| from + (to - from) * f64::from(k) / f64::from(count))
}

/// b2 against V^2 with both fits (Fig. 9).
pub(super) fn authority(speeds: &[Speed]) -> Option<Figure> {
    let known = || {
        speeds
            .iter()
            .filter_map(|speed| Some((speed, speed.point.surge_speed_m_s?)))
    };
    let points = points(speeds);
    let through_zero = AuthorityFit::new(&points, AuthorityForm::ThroughZero).ok()?;
    let with_constant = AuthorityFit::new(&points, AuthorityForm::WithConstant).ok()?;
    let [slowest, fastest] = with_constant.speed_range_m_s;
    let widest = 1.1 * fastest * fastest;
    let line = |fit: &AuthorityFit<f64>| {
        let squares = evenly(0.0, widest, 60);
        squares
            .map(|v2| [v2, *fit.b2_per_s2(v2.sqrt()).value()])
            .collect()
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

fn identified(from: f64, to: f64) -> Span {
    Span {
        from,
        to,
        shade: "span-train",
        label: "identified".to_owned(),
    }
}

/// Radii, yaw rate and time of a U-turn over speed, to both hands (Fig. 14).
pub(super) fn turning(speeds: &[Speed], rudder_limit_rad: f64) -> Option<Figure> {
    let points = points(speeds);
    let over_speed = |form| {
        let authority = AuthorityFit::new(&points, form).ok()?;
        let damping = points.iter().map(|p| p.model.a22_per_s);
        Some(TurningOverSpeed {
            a22_per_s: damping.sum::<f64>() / points.len() as f64,
            authority,
            rudder_limit_rad,
        })
    };
    let with_constant = over_speed(AuthorityForm::WithConstant)?;
    let through_zero = over_speed(AuthorityForm::ThroughZero)?;
    let [slowest, fastest] = with_constant.authority.speed_range_m_s;
    let (from, to) = (0.4 * slowest, 1.8 * fastest);
    let turns_at_points = |hand| -> Vec<(f64, Turn<f64>)> {
        let turns = points.iter().filter_map(|point| {
            let turn = Turn::new(&point.model, rudder_limit_rad, hand).ok()?;
            Some((point.surge_speed_m_s?, turn))
        });
        turns.collect()
    };
    let starboard = turns_at_points(Side::Starboard);
    let port = turns_at_points(Side::Port);
    type Quantity = fn(f64, &Turn<f64>) -> f64;
    let panel = |label: &str, named: bool, quantity: Quantity| {
        let curve = |law: &TurningOverSpeed<f64>| -> Vec<[f64; 2]> {
            evenly(from, to, 90)
                .map(|v| {
                    [
                        v,
                        law.turn_at(v).map_or(f64::NAN, |turn| quantity(v, &turn)),
                    ]
                })
                .collect()
        };
        let dots = |turns: &[(f64, Turn<f64>)]| -> Vec<[f64; 2]> {
            turns
                .iter()
                .map(|(v, turn)| [*v, quantity(*v, turn)])
                .collect()
        };
        let main = curve(&with_constant);
        let (starboard, port) = (dots(&starboard), dots(&port));
        // The law through zero runs off to infinity at low speed.
        let shown = || {
            [&main, &starboard, &port]
                .into_iter()
                .flatten()
                .map(|p| p[1])
                .filter(|y| y.is_finite())
        };
        let low = shown().fold(f64::INFINITY, f64::min);
        let high = shown().fold(f64::NEG_INFINITY, f64::max);
        let name = |text: &'static str| if named { text } else { "" };
        let layers = vec![
            Layer::line("c", name("b₂ through zero"), curve(&through_zero)),
            Layer::line("b", name("with constant"), main),
            Layer::dots("a", name("starboard"), starboard),
            Layer::dots("hollow", name("port"), port),
        ];
        Panel::linear(label, 84.0, layers).with_range((low <= high).then_some([low, high]))
    };
    let panels = vec![
        panel("U-turn mean radius, m", true, |v, turn| {
            turn.u_turn_mean_radius_m(v)
        }),
        panel("Steady turning radius, m", false, |v, turn| {
            turn.steady_turning_radius_m(v)
        }),
        panel("Greatest yaw rate, °/s", false, |_, turn| {
            turn.yaw_rate_rad_s.to_degrees()
        }),
        panel("Time of a U-turn, s", false, |_, turn| turn.u_turn_time_s()),
    ];
    let minimum = with_constant.minimum_radius(from, to).ok().flatten();
    let minimum_words = minimum.map_or(String::new(), |minimum| {
        format!(
            " The fit with a constant has its least U-turn radius away from rest at {} m/s: {} m{}.",
            decimals(minimum.surge_speed_m_s, 2),
            decimals(minimum.u_turn_mean_radius_m, 1),
            if minimum.extrapolated {
                ", outside the identified speeds, so an assumption"
            } else {
                ""
            }
        )
    });
    let chart = Chart {
        alt: format!(
            "Turning radii, yaw rate and U-turn time from {} to {} metres per second; identified from {} to {}.{minimum_words}",
            decimals(from, 1),
            decimals(to, 1),
            decimals(slowest, 2),
            decimals(fastest, 2)
        ),
        x_label: "Speed, m/s",
        x_range: [from, to],
        spans: vec![identified(slowest, fastest)],
        marks: minimum
            .map(|minimum| Mark {
                at: minimum.surge_speed_m_s,
                label: "least radius".to_owned(),
            })
            .into_iter()
            .collect(),
        panels,
    };
    Some(Figure::new(
        &chart,
        format!(
            "Turning under full rudder ({}°). Dots: each identified speed with its own offset, to either hand; lines: mean damping and fitted \
             authority, without offset. Only the shaded speeds were measured; beyond them the lines are an assumption. The mean radius of a U-turn \
             includes its slow start and end, the steady radius is that of the circle in between.{minimum_words}",
            decimals(rudder_limit_rad.to_degrees(), 1)
        ),
    ))
}

/// Gain, feed-forward and margins over thrust (Fig. 18).
pub(super) fn gains(speeds: &[Speed]) -> Option<Figure> {
    let designed = || {
        speeds
            .iter()
            .filter_map(|speed| Some((speed, speed.gain?, 100.0 * speed.run.thrust)))
    };
    let thrusts = || designed().map(|(.., thrust)| thrust);
    let low = thrusts().fold(f64::INFINITY, f64::min);
    let high = thrusts().fold(f64::NEG_INFINITY, f64::max);
    if low.partial_cmp(&high) != Some(Ordering::Less) {
        return None;
    }
    let gain_at = |thrust: f64| {
        let of = designed().find(|(.., t)| *t == thrust);
        of.map_or(f64::NAN, |(_, gain, _)| gain.proportional_gain)
    };
    let gain_dots: Vec<[f64; 2]> = designed()
        .map(|(_, gain, thrust)| [thrust, gain.proportional_gain])
        .collect();
    let bars = designed().filter_map(|(speed, _, thrust)| {
        let [low, high] = gain_interval(speed)?;
        Some([thrust, low, high])
    });
    let feed_forward: Vec<[f64; 2]> = designed()
        .map(|(_, gain, thrust)| [thrust, gain.feed_forward_rudder_rad.to_degrees()])
        .collect();
    let margin = |of: fn(&Margins<f64>) -> Option<f64>| -> Vec<[f64; 2]> {
        designed()
            .filter_map(|(speed, _, thrust)| Some([thrust, of(&speed.margins?)?]))
            .collect()
    };
    let phase = margin(|m| m.phase_margin_rad.map(f64::to_degrees));
    let delay = margin(|m| m.delay_margin_s);
    let ends = vec![[low, gain_at(low)], [high, gain_at(high)]];
    let chart = Chart {
        alt: format!(
            "Heading gain, feed-forward rudder, phase margin and delay margin from {low:.0} to {high:.0} per cent thrust."
        ),
        x_label: "Thrust, %",
        x_range: [low - 0.08 * (high - low), high + 0.08 * (high - low)],
        spans: Vec::new(),
        marks: Vec::new(),
        panels: vec![
            Panel::linear(
                "Kₚ, °/°",
                120.0,
                vec![
                    Layer::line("c", "end to end", ends),
                    Layer::line("b", "schedule", gain_dots.clone()),
                    Layer::bars("a", "", bars.collect()),
                    Layer::dots("a", "designed", gain_dots),
                ],
            ),
            Panel::linear(
                "Feed-forward rudder −δ₀, °",
                60.0,
                vec![
                    Layer::line("b", "", feed_forward.clone()),
                    Layer::dots("a", "", feed_forward),
                ],
            ),
            Panel::linear(
                "Phase margin, °",
                60.0,
                vec![
                    Layer::line("b", "", phase.clone()),
                    Layer::dots("a", "", phase),
                ],
            )
            .spanning_at_least(30.0),
            Panel::linear(
                "Dead time it bears, s",
                60.0,
                vec![
                    Layer::line("b", "", delay.clone()),
                    Layer::dots("a", "", delay),
                ],
            ),
        ],
    };
    Some(Figure::new(
        &chart,
        "The gain at each thrust with its 95 % interval, the rudder that holds a straight course, and how much \
         phase and dead time the sampled loop has to spare. Between thrusts the gain is that of the model between; the dashed line, as in the paper, joins \
         the gains of the two end points."
            .to_owned(),
    ))
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
    let degrees = |run: &HeadingStepRun, of: fn(&HeadingStepSample) -> f64| -> Vec<[f64; 2]> {
        let samples = run.series.iter();
        samples.map(|s| [s.time_s, of(s).to_degrees()]).collect()
    };
    // Constant and scheduled come in pairs, one pair a thrust.
    let panels: Vec<Panel> = runs
        .chunks_exact(2)
        .enumerate()
        .map(|(k, pair)| {
            let [constant, scheduled] = [&pair[0], &pair[1]];
            let thrust = constant.point.thrust.map_or(String::new(), percent);
            let name = |text: &'static str| if k == 0 { text } else { "" };
            let layers = vec![
                Layer::line("zero", name("wanted"), degrees(constant, |s| s.command_rad)),
                Layer::line(
                    "c",
                    name("constant gain"),
                    degrees(constant, |s| s.heading_rad),
                ),
                Layer::line(
                    "b",
                    name("scheduled"),
                    degrees(scheduled, |s| s.heading_rad),
                ),
            ];
            Panel::linear(format!("{thrust}: heading, °"), 62.0, layers)
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
        spans: Vec::new(),
        marks: Vec::new(),
        panels,
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

/// The estimates of every accepted speed on one axis (Figs. 8 and 12).
pub(super) fn together(speeds: &[Speed]) -> Option<Figure> {
    const INKS: [&str; 5] = ["s1", "s2", "s3", "s4", "s5"];
    let traces = || {
        speeds.iter().zip(INKS.iter().cycle()).map(|(speed, ink)| {
            let from = speed.identification.training.from_s;
            (*ink, speed, from, &speed.identification.online.trace)
        })
    };
    let longest = traces()
        .filter_map(|(_, _, from, trace)| Some(trace.last()?.time_s - from))
        .fold(0.0, f64::max);
    if longest <= 0.0 {
        return None;
    }
    let panel = |label: &str, index: usize| {
        let last = || {
            let values = traces().filter_map(|(.., trace)| Some(trace.last()?.theta[index]));
            values.chain([0.0])
        };
        let low = last().fold(f64::INFINITY, f64::min);
        let high = last().fold(f64::NEG_INFINITY, f64::max);
        let margin = 0.35 * (high - low);
        let lines = traces().map(|(ink, speed, from, trace)| {
            let name = if index == 0 {
                percent(speed.run.thrust)
            } else {
                String::new()
            };
            let points = trace.iter().map(|p| [p.time_s - from, p.theta[index]]);
            Layer::line(ink, &name, points.collect())
        });
        Panel::linear(label, 84.0, lines.collect()).with_range(Some([low - margin, high + margin]))
    };
    let threshold = speeds.first()?.identification.online.convergence.threshold;
    let mut norms = vec![Layer::level("zero", "threshold", threshold)];
    norms.extend(traces().map(|(ink, _, from, trace)| {
        let points = trace
            .iter()
            .map(|p| [p.time_s - from, p.step_norm.max(1e-9)]);
        Layer::line(ink, "", points.collect())
    }));
    let chart = Chart {
        alt: format!(
            "Live estimates of a22, b2 and C0 at {} speeds over training, and the change per sample on a logarithmic axis.",
            speeds.len()
        ),
        x_label: "Time since training began, s",
        x_range: [0.0, longest],
        spans: Vec::new(),
        marks: Vec::new(),
        panels: vec![
            panel("Damping a₂₂, 1/s", 0),
            panel("Rudder authority b₂, 1/s²", 1),
            panel("Offset C₀, rad/s²", 2),
            Panel::logarithmic("Change per sample", 90.0, norms),
        ],
    };
    Some(Figure::new(
        &chart,
        "The live estimates of all speeds on one axis. Each must come to rest after its doublet; a₂₂ should differ little between speeds, \
         b₂ should grow with speed."
            .to_owned(),
    ))
}

//! The page of the field experiments.

use super::axis::extent;
use super::chart::{Chart, Layer, Panel};
use super::control_figures::step_panel;
use super::headline::{Headline, Tone};
use super::number::{decimals, percent, spoken};
use super::plan_view::{PlanView, Room};
use super::tables::{Cell, Table, under};
use super::{Figure, Page, recorded, speed_figures};
use seatrial::campaign::Campaign;
use seatrial::sea_trials::field::{Control, Field, SteeredSteps, UTurn};
use seatrial_core::{HeadingGain, SchedulePoint};

/// The page of the field experiments after a trial.
pub fn render(campaign: &Campaign, field: &Field) -> String {
    let speeds = speed_figures::accepted(campaign);
    let page = Page {
        title: format!("Field experiments with {}", campaign.vehicle),
        subtitle: "Section VI of the paper, re-enacted after a trial".to_owned(),
        headline: headline(field),
        summary: Some(claims(field)),
        over_speed: [
            u_turn_tracks(field),
            yaw_rate(field),
            radii(field),
            speed_figures::authority(&speeds),
        ]
        .into_iter()
        .flatten()
        .collect(),
        controller: Some(u_turns(field)),
        control: [heading_steps(field), gains(field), repeats(field)]
            .into_iter()
            .flatten()
            .collect(),
        every_run: Some(steps(field)),
        recorded: recorded::of_campaign(campaign),
        ..Page::default()
    };
    page.text()
}

fn headline(field: &Field) -> Headline {
    let claims = field.claims();
    let held = claims.iter().filter(|claim| claim.holds).count();
    let failed = claims.iter().filter(|claim| !claim.holds);
    Headline {
        tone: if held == claims.len() { Tone::Good } else { Tone::Partly },
        verdict: format!("{held} of {} claims of the paper hold here", claims.len()),
        findings: failed
            .map(|claim| format!("{}: {} does not hold", claim.place, spoken(claim.claim)))
            .collect(),
        command: String::new(),
        next: Vec::new(),
    }
}

fn claims(field: &Field) -> Table {
    let row = |claim: seatrial::sea_trials::field::Claim| {
        vec![
            Cell::words(claim.place.to_owned()),
            Cell::words(spoken(claim.claim)),
            format!("{} {}", decimals(claim.found, 3), claim.unit).into(),
            format!("{} {}", claim.limit, claim.unit).into(),
            Cell {
                class: if claim.holds { "good" } else { "bad" },
                ..Cell::from(if claim.holds { "✓" } else { "✕" }.to_owned())
            },
        ]
    };
    Table {
        title: "What the paper claims",
        note: "Found on this simulated vehicle with its noise and disturbance.".to_owned(),
        columns: under("Where | Claim | Found | Limit | Holds"),
        rows: field.claims().into_iter().map(row).collect(),
    }
}

fn u_turns(field: &Field) -> Table {
    let row = |turn: &UTurn| {
        let (predicted, measured) = (&turn.predicted, &turn.measured);
        vec![
            percent(turn.thrust).into(),
            decimals(measured.straight_speed_m_s, 2).into(),
            decimals(measured.speed_in_turn_m_s, 2).into(),
            decimals(measured.yaw_rate_rad_s.to_degrees(), 2).into(),
            decimals(predicted.yaw_rate_rad_s.to_degrees(), 2).into(),
            decimals(measured.u_turn_time_s, 1).into(),
            decimals(predicted.u_turn_time_s, 1).into(),
            Cell {
                detail: format!("± {}", decimals(measured.u_turn_radius_standard_error_m, 3)),
                ..decimals(measured.u_turn_radius_m, 2).into()
            },
            decimals(predicted.u_turn_mean_radius_m, 2).into(),
            decimals(predicted.at_speed_in_turn_m, 2).into(),
            decimals(measured.steady_turning_radius_m, 2).into(),
            decimals(predicted.steady_turning_radius_m, 2).into(),
            decimals(predicted.from_one_u_turn_m, 2).into(),
        ]
    };
    Table {
        title: "U-turns, heading steps, repeated trials",
        note: "The model's yaw rate and V/rate are those of the first-order model under full rudder; in a turn that lasts the vehicle drifts \
               and turns slower. R (50) has the time to build up the yaw rate in it. The last column takes the shortfall from the U-turn at the \
               middle thrust."
            .to_owned(),
        columns: under("Thrust | Straight [m/s] | In the turn [m/s] | Yaw rate [°/s] | By the model [°/s] | U-turn [s] | \
            (49) [s] | Circle [m] | R (50) [m] | R (50), speed in the turn [m] | Steady circle [m] | \
            V/rate [m] | From one U-turn [m]"),
        rows: field.u_turns.iter().map(row).collect(),
    }
}

fn steps(field: &Field) -> Table {
    let row = |steps: &SteeredSteps| {
        let [away, back] = &steps.measures;
        let settled = |time_s: Option<f64>| time_s.map_or("not".to_owned(), |t| decimals(t, 1));
        let pair = |a: String, b: String| Cell::from(format!("{a}, {b}"));
        vec![
            percent(steps.point.thrust.unwrap_or(f64::NAN)).into(),
            Cell::words(name(steps.control).to_owned()),
            decimals(steps.gain.proportional_gain, 2).into(),
            pair(percent(away.overshoot), percent(back.overshoot)),
            pair(settled(away.settling_time_s), settled(back.settling_time_s)),
            format!("{}, {}", steps.swings[0], steps.swings[1]).into(),
        ]
    };
    Table {
        title: "Heading steps",
        note: "The step away and the step back. Settled: within 5 % of the step. Swings: excursions beyond 5 % of the step after the \
               heading was reached, to either side in turn."
            .to_owned(),
        columns: under("Thrust | Gain | Kₚ [°/°] | Overshoot | Settled [s] | Swings"),
        rows: field.heading_steps.iter().map(row).collect(),
    }
}

fn name(control: Control) -> &'static str {
    match control {
        Control::Constant => "constant",
        Control::Scheduled => "scheduled",
        Control::Interpolated => "two end points",
    }
}

/// The U-turns and the circles after them, seen from above (Fig. 15a).
fn u_turn_tracks(field: &Field) -> Option<Figure> {
    const INKS: [&str; 5] = ["s1", "s2", "s3", "s4", "s5"];
    let start = |turn: &UTurn| turn.track_m.first().copied();
    let turned = |turn: &UTurn| -> Vec<[f64; 2]> {
        let (Some([n0, e0]), Some([n1, e1])) = (start(turn), turn.track_m.get(1).copied()) else {
            return Vec::new();
        };
        let course = libm::atan2(e1 - e0, n1 - n0);
        let (sine, cosine) = libm::sincos(course);
        let along = |[n, e]: [f64; 2]| {
            let (n, e) = (n - n0, e - e0);
            [n * cosine + e * sine, e * cosine - n * sine]
        };
        // To the left is up.
        turn.track_m.iter().map(|p| along(*p)).map(|[x, y]| [x, -y]).collect()
    };
    let tracks: Vec<Vec<[f64; 2]>> = field.u_turns.iter().map(turned).collect();
    let room = Room { over_tracks: 1.15, highest: 260.0, least_height: 0.0 };
    let view = PlanView::new(tracks.iter().flatten(), &room)?;
    let layers = tracks.iter().zip(&field.u_turns).zip(INKS.iter().cycle());
    let layers =
        layers.map(|((track, turn), ink)| Layer::line(ink, &percent(turn.thrust), track.clone()));
    let chart = Chart {
        alt: "Tracks of U-turns under full rudder from above, at each thrust.".to_owned(),
        x_label: "Along the first course, m",
        x_range: view.along_m,
        panels: vec![
            Panel::linear("Left of it, m", view.height, layers.collect())
                .with_range(Some(view.across_m)),
        ],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        "U-turns and the circle after them, from the instant at which the rudder moves; both axes to one scale (Fig. 15a of the paper)."
            .to_owned(),
    ))
}

/// Measured and modelled yaw rate in the U-turns (Fig. 15b).
fn yaw_rate(field: &Field) -> Option<Figure> {
    let longest = field
        .u_turns
        .iter()
        .filter_map(|turn| Some(turn.yaw_rate.last()?.time_s))
        .fold(0.0, f64::max);
    let panels = field.u_turns.iter().enumerate().map(|(k, turn)| {
        let name = |text: &'static str| if k == 0 { text } else { "" };
        let line = |of: fn(&seatrial::sea_trials::field::YawRateSample) -> f64| {
            let samples = turn.yaw_rate.iter();
            samples.map(|s| [s.time_s, of(s).to_degrees()]).collect()
        };
        Panel::linear(
            format!("{}: yaw rate, °/s", percent(turn.thrust)),
            60.0,
            vec![
                Layer::line("a", name("measured"), line(|s| s.measured_rad_s)),
                Layer::line("b", name("model"), line(|s| s.modelled_rad_s)),
            ],
        )
    });
    let chart = Chart {
        alt: "Measured and modelled yaw rate in a U-turn at each thrust.".to_owned(),
        x_label: "Time since the rudder moved, s",
        x_range: [0.0, longest],
        panels: panels.collect(),
        ..Chart::default()
    };
    (longest > 0.0).then(|| {
        Figure::new(
            &chart,
            "Yaw rate in the U-turns (Fig. 15b): the first-order model holds for as long as its doublets lasted, then drift and loss of speed \
             slow the turn."
                .to_owned(),
        )
    })
}

/// Radii over speed: predicted and measured.
fn radii(field: &Field) -> Option<Figure> {
    let speeds = field.u_turns.iter();
    let [low, high] = extent(speeds.map(|t| t.measured.straight_speed_m_s));
    let margin = 0.08 * (high - low);
    let chart = Chart {
        alt: "Turning radii over speed, predicted and measured.".to_owned(),
        x_label: "Speed straight ahead, m/s",
        x_range: [low - margin, high + margin],
        panels: vec![u_turn_radii(field), steady_radii(field)],
        ..Chart::default()
    };
    (low < high).then(|| {
        Figure::new(
            &chart,
            "Radii predicted from the trial against circles through the tracks.".to_owned(),
        )
    })
}

/// A quantity of each U-turn over the speed straight ahead.
fn over_speed(field: &Field, quantity: fn(&UTurn) -> f64) -> Vec<[f64; 2]> {
    let turns = field.u_turns.iter();
    turns.map(|t| [t.measured.straight_speed_m_s, quantity(t)]).collect()
}

fn u_turn_radii(field: &Field) -> Panel {
    let points = |quantity| over_speed(field, quantity);
    let layers = vec![
        Layer::line("c", "(50)", points(|t| t.predicted.u_turn_mean_radius_m)),
        Layer::line("b", "(50), speed in turn", points(|t| t.predicted.at_speed_in_turn_m)),
        Layer::dots("a", "circle", points(|t| t.measured.u_turn_radius_m)),
    ];
    Panel::linear("U-turn radius, m", 110.0, layers).spanning_at_least(4.0)
}

fn steady_radii(field: &Field) -> Panel {
    let points = |quantity| over_speed(field, quantity);
    let layers = vec![
        Layer::line("c", "V/rate", points(|t| t.predicted.steady_turning_radius_m)),
        Layer::line("b", "from one U-turn", points(|t| t.predicted.from_one_u_turn_m)),
        Layer::dots("a", "circle", points(|t| t.measured.steady_turning_radius_m)),
    ];
    Panel::linear("Steady radius, m", 110.0, layers).spanning_at_least(4.0)
}

/// The steps at every thrust (Fig. 17).
fn heading_steps(field: &Field) -> Option<Figure> {
    let of =
        |control: Control| field.heading_steps.iter().filter(move |steps| steps.control == control);
    let pairs = of(Control::Constant).zip(of(Control::Scheduled)).enumerate();
    let panels: Vec<Panel> = pairs
        .map(|(k, (constant, scheduled))| {
            let thrust = scheduled.point.thrust;
            step_panel(thrust, &constant.series, &scheduled.series, k == 0)
        })
        .collect();
    let chart = Chart {
        alt: "Heading steps of the vehicle at each thrust with a constant and a scheduled gain."
            .to_owned(),
        x_label: "Time since the first step, s",
        x_range: [0.0, 2.0 * field.settings.steps.hold_s],
        panels,
        ..Chart::default()
    };
    (!chart.panels.is_empty()).then(|| {
        Figure::new(
            &chart,
            "Heading steps on the vehicle itself (Fig. 17), without the compass noise. The constant gain is (57) for the lowest thrust, without \
             feed-forward. The scheduled gain is designed for the least damped model of each interval and counts the sample of delay."
                .to_owned(),
        )
    })
}

/// Gains over thrust: designed at every thrust, and from the two end points (Fig. 18).
fn gains(field: &Field) -> Option<Figure> {
    let design = |point: &SchedulePoint<f64>| {
        let gain = HeadingGain::design(&point.model, field.settings.steps.damping_ratio).ok()?;
        Some([100.0 * point.thrust?, gain.proportional_gain])
    };
    let designed: Vec<[f64; 2]> = field.points.iter().filter_map(design).collect();
    let (first, last) = (*designed.first()?, *designed.last()?);
    let margin = 0.08 * (last[0] - first[0]);
    let inner = field.gains_from_ends.iter();
    let inner = inner.map(|gain| [100.0 * gain.thrust, gain.of_the_model_between]);
    let model_between = [first].into_iter().chain(inner).chain([last]).collect();
    let chart = Chart {
        alt: "Heading gain over thrust, designed at each thrust and on the line between the two end points.".to_owned(),
        x_label: "Thrust, %",
        x_range: [first[0] - margin, last[0] + margin],
        panels: vec![Panel::linear(
            "Kₚ, °/°",
            110.0,
            vec![
                Layer::line("c", "line", vec![first, last]),
                Layer::line("b", "model between", model_between),
                Layer::dots("a", "designed", designed),
            ],
        )],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        "Gains (57) designed at each thrust, and those that the lowest and the highest alone give (Fig. 18): on the line between the two gains, and \
         designed from the model between the two models."
            .to_owned(),
    ))
}

/// a22 and b2 of the repeated trials with their intervals.
fn repeats(field: &Field) -> Option<Figure> {
    let repeated = field.repeatability.as_ref()?;
    let number = |k: usize| (k + 1) as f64;
    let panel = |label: &'static str,
                 mean: f64,
                 of: fn(&seatrial::sea_trials::field::Repeat) -> (f64, [f64; 2])| {
        let entries = || repeated.repeats.iter().map(of).enumerate();
        let bars = entries().map(|(k, (_, [low, high]))| [number(k), low, high]);
        let dots = entries().map(|(k, (value, _))| [number(k), value]);
        Panel::linear(
            label,
            90.0,
            vec![
                Layer::level("zero", "", mean),
                Layer::bars("a", "", bars.collect()),
                Layer::dots("a", "", dots.collect()),
            ],
        )
    };
    let chart = Chart {
        alt: "Damping and rudder authority of the repeated trials with their intervals.".to_owned(),
        x_label: "Trial",
        x_range: [0.0, number(repeated.repeats.len())],
        panels: vec![
            panel("Damping a₂₂, 1/s", repeated.a22_per_s.mean, |r| {
                (r.model.a22_per_s, r.interval_95.a22_per_s)
            }),
            panel("Rudder authority b₂, 1/s²", repeated.b2_per_s2.mean, |r| {
                (r.model.b2_per_s2, r.interval_95.b2_per_s2)
            }),
        ],
        ..Chart::default()
    };
    Some(Figure::new(
        &chart,
        format!(
            "The trial at {} repeated, with 95 % intervals; the line is the mean.",
            percent(repeated.thrust)
        ),
    ))
}

//! A plan's preview in words and tables.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::motions::surge::ExpectedSurge;
use seatrial::preview::{Comparison, PredictedQuantity, Preview, SurgeStep, Target};
use seatrial::verdict::{WIDEST_A22, WIDEST_B2};
use seatrial_app::trials::plan::{ExpectedTrial, PlannedTrial, Recommendations};
use seatrial_core::{Excitation, Outcome, Plan};

use super::too_little;
use crate::screen::{width, wrapped};
use crate::table::{Table, number};

/// A trial that takes longer than this is begun with one speed, s.
const LONG_S: f64 = 3600.0;

/// What to leave out of a plan that takes long.
fn shorter(plan: &Plan<f64>, duration_s: f64) -> Option<String> {
    let speeds = plan.thrusts.len();
    if duration_s < LONG_S || speeds < 2 {
        return None;
    }
    let thrust = plan.thrusts.iter().copied().nth(speeds / 2)?;
    Some(format!(
        "LONG: begin with one speed, which takes some {:.0} min of these {:.0}: the same command with --thrust {thrust}. In the file, observe_s of both stages and at_least_s of settling are what to shorten.\n",
        duration_s / speeds as f64 / 60.0,
        duration_s / 60.0
    ))
}

/// The preview; `written` is the file of the plan.
pub(super) fn text(document: &PlannedTrial, written: Option<&Path>) -> String {
    let mut text = preview_text(&document.preview, &document.plan);
    if let Some(comparison) = &document.comparison {
        let _ = write!(text, "\n{}", comparison_text(comparison));
    }
    if let Some(recommendation) = &document.recommendation {
        let _ = write!(text, "\n{}", recommendation_text(recommendation));
    }
    if let Some(surge) = &document.surge {
        let _ = write!(text, "\n{}", surge_text(surge));
    }
    if let Some(shorter) = shorter(&document.plan, document.preview.preview.duration_s) {
        let _ = write!(text, "\n{shorter}");
    }
    if let Some(file) = written {
        let file = file.display();
        let _ = write!(text, "\nWritten {file}\nNext    seatrial trial --plan {file}\n");
    }
    wrapped(&text, width())
}

fn surge_text(surge: &SurgeStep) -> String {
    let said = |found: &ExpectedSurge| {
        let (length, lag) = (found.drag_length_factor_95, found.thrust_lag_half_width_95_s);
        match (length, lag) {
            (None, _) => "nothing of drag length and lag".into(),
            (Some(factor), None) => {
                format!("the drag length within a factor of {factor:.2}, nothing of the lag")
            }
            (Some(factor), Some(lag_s)) => {
                format!(
                    "the drag length within a factor of {factor:.2}, the lag within {lag_s:.2} s"
                )
            }
        }
    };
    let believed = format!(
        "Believed: a drag length of {:.1} m, half to twice of it, and a noise of the speed of {:.3} m/s.\n",
        surge.believed.drag_length_m, surge.believed.noise_m_s
    );
    let without = said(&surge.without);
    let found = match &surge.added {
        _ if surge.without.is_identified() => format!(
            "Surge: the changes of thrust of this plan make it identifiable ({without}): nothing is added.\n"
        ),
        None => format!(
            "Surge: NOT IDENTIFIABLE. The plan tells {without}, and no further run from 20 to 100 % thrust tells enough.\n"
        ),
        Some(added) => format!(
            "Surge: without a further run the plan would tell {without}. Added: run {} at {:.0} % thrust, a step from {:.0} to {:.0} %, which costs {:.0} s. The trial then tells {}.\n",
            added.place + 1,
            100.0 * added.thrust,
            100.0 * added.step[0],
            100.0 * added.step[1],
            added.cost_s,
            said(&added.with)
        ),
    };
    found + &believed
}

fn preview_text(ExpectedTrial { vehicle, preview }: &ExpectedTrial, plan: &Plan<f64>) -> String {
    let mut text = String::new();
    let _ = match preview.outcome {
        Some(Outcome::Finished) => writeln!(
            text,
            "On {vehicle} this plan takes {:.0} s with {} (at most {:.0} s, repeats of rejected runs aside).",
            preview.duration_s,
            match plan.thrusts.len() {
                1 => "1 speed".into(),
                speeds => format!("{speeds} speeds"),
            },
            preview.longest_s
        ),
        Some(Outcome::Aborted(reason)) => writeln!(
            text,
            "On {vehicle} this plan is ABORTED after {:.0} s: {reason}. Change the plan or its envelope.",
            preview.duration_s
        ),
        None => writeln!(text, "The plan did not end."),
    };
    let _ = match (preview.track_box_m, preview.track_margin_m) {
        (Some([south, north, west, east]), Some(margin)) => writeln!(
            text,
            "Track: from {south:.0} to {north:.0} m north and from {west:.0} to {east:.0} m east of the start, {margin:.0} m on each side for the compass and the waves included."
        ),
        _ => writeln!(text, "Track: unknown without a speed; give --speed."),
    };
    let _ = writeln!(
        text,
        "\n{}\nHalf widths of the 95 % intervals to expect at best; K_p for a damping ratio of 0.7071, the radius of the steady circle under the full rudder.",
        speeds_table(preview).fitted(width(), &DISPENSABLE)
    );
    let too_little = too_little(preview);
    if !too_little.is_empty() {
        let _ = writeln!(
            text,
            "TOO LITTLE to accept a model at {} thrust (a22 within {:.0} %, b2 within {:.0} %): plan more rudder or a longer period.",
            too_little.join(", "),
            100.0 * WIDEST_A22,
            100.0 * WIDEST_B2
        );
    }
    text
}

/// Columns that a narrow screen does without, first those that fewest people miss.
const DISPENSABLE: [&str; 7] =
    ["disturbance", "noise", "radius", "settle", "train", "validate", "C0"];

fn speeds_table(preview: &Preview) -> Table {
    let mut table = Table::under(
        "thrust [%] | speed [m/s] | settle [s] | train [s] | validate [s] | heading [± deg] | a22 [± %] | \
            b2 [± %] | C0 [± rad/s^2] | K_p [± %] | radius [± %] | noise [deg] | disturbance [rad/s^2, s]",
    );
    for speed in &preview.speeds {
        let expected = speed.expected;
        let relative =
            |index: usize| percent(expected.and_then(|e| e.relative_half_width_95[index]));
        let radius = expected.and_then(|e| {
            let widths = e.steady_turning_radius_m.iter().flatten().map(relative_width);
            widths.reduce(f64::max)
        });
        let noise = speed.prior.noise;
        table.row(vec![
            format!("{:.0}", 100.0 * speed.prior.thrust),
            number(speed.prior.surge_speed_m_s, 2),
            format!("{:.1}", speed.settle_s),
            format!("{:.1}", speed.train_s),
            format!("{:.1}", speed.validate_s),
            format!("{:.0}", speed.heading_excursion_rad.to_degrees()),
            relative(0),
            relative(1),
            number(expected.map(|e| e.half_width_95[2]), 4),
            percent(expected.and_then(|e| e.proportional_gain).as_ref().map(relative_width)),
            percent(radius),
            format!("{:.2}", noise.heading_rad.to_degrees()),
            format!("{:.2e}, {:.1}", noise.disturbance_rad_s2, noise.disturbance_time_s),
        ]);
    }
    table
}

fn relative_width(predicted: &PredictedQuantity) -> f64 {
    predicted.half_width_95 / predicted.value.abs()
}

fn comparison_text(comparison: &Comparison) -> String {
    let mut table = Table::under(
        "manoeuvre | thrust [%] | a22 [± %] | b2 [± %] | C0 [± rad/s^2] | heading [± deg] | \
            track along [m] | across [m]",
    );
    for design in &comparison.designs {
        for speed in &design.speeds {
            let [a22, b2, _] =
                speed.expected.map_or([None; 3], |e| e.relative_half_width_95).map(percent);
            table.row(vec![
                design.name.replace('_', ", "),
                format!("{:.0}", 100.0 * speed.thrust),
                a22,
                b2,
                number(speed.expected.map(|e| e.half_width_95[2]), 4),
                format!("{:.0}", speed.heading_excursion_rad.to_degrees()),
                number(speed.track_m.map(|track| track[0]), 0),
                number(speed.track_m.map(|track| track[1]), 1),
            ]);
        }
    }
    let mut text = format!(
        "Manoeuvres of {:.1} deg and {:.1} s side by side; \"designed\" may turn as far as the envelope allows, \"calm\" as far as the doublet.\n\n{table}",
        comparison.amplitude_rad.to_degrees(),
        comparison.duration_s
    );
    if comparison.designs.iter().all(|d| d.name != "designed") {
        text.push_str("No designed manoeuvre of this amplitude and duration stays within the envelope should the prior be 30 % wrong.\n");
    }
    for design in &comparison.designs {
        if let Excitation::Switched { deflections_s, .. } = design.excitation {
            let lengths: Vec<String> = deflections_s.iter().map(|s| format!("{s:.2}")).collect();
            let _ = writeln!(
                text,
                "{}: to alternating sides for {} s.",
                design.name.replace('_', ", "),
                lengths.join(", ")
            );
        }
    }
    text
}

fn recommendation_text(recommendation: &Recommendations) -> String {
    let Target { a22, b2 } = recommendation.target;
    let wanted: Vec<String> = [("a22", a22), ("b2", b2)]
        .into_iter()
        .filter_map(|(name, width)| Some(format!("{name} ± {} %", (1e6 * width?).round() / 1e4)))
        .collect();
    let mut table = Table::under(
        "thrust [%] | amplitude [deg] | period [s] | a22 [± %, 9 of 10] | b2 [± %, 9 of 10] | \
            a22 [± %, best] | b2 [± %, best] | heading [± deg] | ",
    );
    for doublet in &recommendation.doublets {
        let widths = [doublet.nine_of_ten_within, doublet.relative_half_width_95];
        let mut row = vec![
            doublet.thrust.map_or("all".into(), |thrust| format!("{:.0}", 100.0 * thrust)),
            format!("{:.1}", doublet.amplitude_rad.to_degrees()),
            format!("{:.2}", doublet.period_s),
        ];
        row.extend(widths.iter().flatten().map(|width| percent(Some(*width))));
        row.push(format!("{:.0}", doublet.heading_excursion_rad.to_degrees()));
        row.push(if doublet.reachable { "" } else { "NOT REACHABLE" }.into());
        table.row(row);
    }
    if recommendation.doublets.is_empty() {
        return "No doublet tells anything of this vehicle.\n".into();
    }
    let mut text = format!(
        "The smallest doublets for {} in nine of ten trials:\n\n{table}",
        wanted.join(" and ")
    );
    if recommendation.doublets.iter().any(|d| !d.reachable) {
        text.push_str(
            "NOT REACHABLE within the rudder limit and the envelope: this doublet comes nearest.\n",
        );
    }
    text
}

fn percent(fraction: Option<f64>) -> String {
    number(fraction.map(|fraction| 100.0 * fraction), 1)
}

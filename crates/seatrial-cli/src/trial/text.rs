//! A trial in words and a table.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::campaign::{Campaign, Run};
use seatrial::{GainAllowance, Identification};
use seatrial_core::Outcome;

use crate::table::{Table, decimals};

pub(super) fn run_line(run: &Run) -> String {
    let judged = if run.verdict.accepted {
        "accepted"
    } else {
        "rejected"
    };
    let reason = run.verdict.reasons.first().map_or("", |r| r.text.as_str());
    format!(
        "run {} at {:.0} % thrust {judged}: {reason}",
        run.number,
        100.0 * run.thrust
    )
}

/// What is printed of the campaign.
pub(super) fn text(campaign: &Campaign, logbook: &Path, report: Option<&Path>) -> String {
    let mut text = String::new();
    let accepted = campaign.accepted_runs();
    let _ = match campaign.outcome {
        Some(Outcome::Aborted(reason)) => writeln!(
            text,
            "ABORTED: {reason}. The vehicle was handed back; everything up to then is kept."
        ),
        _ => writeln!(
            text,
            "{} of {} runs accepted, {} speeds with a model.",
            campaign.runs.iter().filter(|r| r.verdict.accepted).count(),
            campaign.runs.len(),
            accepted.len()
        ),
    };
    if !accepted.is_empty() {
        let _ = writeln!(text, "\n{}", models(&accepted));
        let _ = writeln!(
            text,
            "a22, b2 and C0 with 95 % half widths; K_p for a damping ratio of 0.7071 with the delays of the loop and the least damped model of the interval; the rudder that holds a heading is -delta0."
        );
    }
    for contradiction in campaign.contradictions() {
        let _ = writeln!(text, "do not use all speeds as one: {}", contradiction.text);
    }
    for run in campaign.runs.iter().filter(|run| !run.verdict.accepted) {
        let _ = writeln!(text, "{}", run_line(run));
    }
    let _ = writeln!(text, "\nlogbook  {}", logbook.display());
    if let Some(report) = report {
        let _ = writeln!(text, "report   {}", report.display());
    }
    text
}

fn models(runs: &[&Run]) -> String {
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("a22", "1/s"),
        ("b2", "1/s^2"),
        ("C0", "rad/s^2"),
        ("delta0", "deg"),
        ("T", "s"),
        ("K", "1/s"),
        ("R^2", ""),
        ("K_p", ""),
    ]);
    for run in runs {
        let Some(identification) = &run.identification else {
            continue;
        };
        let model = identification.model();
        let half_widths = identification.refined.as_ref().map(|refined| {
            let interval = &refined.interval_95;
            [
                interval.a22_per_s,
                interval.b2_per_s2,
                interval.c0_rad_per_s2,
            ]
            .map(|[low, high]| 0.5 * (high - low))
        });
        let with_width = |index: usize, digits: usize| {
            let value = model.theta()[index];
            let digits = decimals(value, digits);
            half_widths.map_or_else(
                || format!("{value:.digits$}"),
                |widths| format!("{value:.digits$} ±{:.digits$}", widths[index]),
            )
        };
        let number = |value: Option<f64>, digits: usize| {
            value.map_or_else(String::new, |value| {
                format!("{value:.*}", decimals(value, digits))
            })
        };
        table.row(vec![
            format!("{:.0}", 100.0 * run.thrust),
            number(run.surge_speed_m_s, 2),
            with_width(0, 3),
            with_width(1, 3),
            with_width(2, 4),
            number(model.delta0_rad().map(f64::to_degrees), 2),
            number(identification.nomoto.map(|n| n.t_s), 2),
            number(identification.nomoto.map(|n| n.k_per_s), 3),
            number(identification.validation.and_then(|v| v.r2_heading), 3),
            number(gain(identification), 2),
        ]);
    }
    table.to_string()
}

fn gain(identification: &Identification) -> Option<f64> {
    GainAllowance::of(identification)
        .design(&identification.model(), core::f64::consts::FRAC_1_SQRT_2)
        .ok()
        .map(|gain| gain.proportional_gain)
}

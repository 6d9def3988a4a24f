//! `seatrial turn`: turning limits to either side, and over speed.

use seatrial_app::models::SCHEDULE_FILE_HELP;
use seatrial_app::turning::{MeasuredUTurn, OverSpeed, PointLimits, SideLimits, TurningLimits};
use seatrial_core::Side;
use seatrial_core::authority::AuthorityForm;

use crate::model_source::{SourceArgs, rejected_text, trial_line, warn};
use crate::output::{Exit, Failure, Output};
use crate::screen::{width, wrapped};
use crate::table::{Table, estimate_cell, number};

/// Turning limits from a model or a schedule, to either side.
///
/// The rudder is taken to move at once to its limit and the speed to stay the same. The U-turn mean
/// radius is the paper's (50), with the time to build up the yaw rate; the steady radius is that of
/// the circle of a long turn, by a first-order model. A hull that drifts turns slower in a turn that
/// lasts: its circle is 12 to 35 % wider on the simulated vehicles, 22 % in the paper. Measure one
/// U-turn and enter it with --measured-u-turn: the ratio found at one thrust holds for the others within 8 %.
#[derive(clap::Args)]
#[command(after_help = help())]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Heading change whose time is wanted, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 180.0)]
    heading_change_deg: f64,
    /// Looks for the least radius up to this speed, m/s, beyond the identified ones if need be.
    #[arg(long, value_name = "M_S")]
    up_to_speed: Option<f64>,
    /// A U-turn under full rudder that was measured: its speed before the turn, m/s, and the radius of a circle through
    /// its track, m, as in 1.63:7.9. The circle at every speed is then that of the model times the ratio found there.
    #[arg(long, value_name = "M_S:M", value_parser = u_turn)]
    measured_u_turn: Option<MeasuredUTurn>,
}

/// A speed and a radius, as in 1.63:7.9.
fn u_turn(text: &str) -> Result<MeasuredUTurn, String> {
    let positive = |part: &str| part.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
    text.split_once(':')
        .and_then(|(speed, radius)| {
            Some(MeasuredUTurn { surge_speed_m_s: positive(speed)?, radius_m: positive(radius)? })
        })
        .ok_or_else(|| format!("{text}: expected SPEED:RADIUS in m/s and m, as in 1.63:7.9"))
}

fn help() -> String {
    format!(
        "\
Example:
  seatrial turn --a22 -1.62 --b2 1.25 --c0 0.045 --speed 1.4 \\
      --heading-change-deg 90 --measured-u-turn 1.4:6.5

{SCHEDULE_FILE_HELP}"
    )
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let models = args.source.read()?;
    warn(&models);
    let document = TurningLimits::of(
        &models,
        args.heading_change_deg.to_radians(),
        args.up_to_speed,
        args.measured_u_turn,
    )?;
    output.print(&document, || text(&document, width()))?;
    Ok(Exit::done_if(!document.is_refused()))
}

/// Columns that a narrow screen does without, first those that fewest people miss.
const DISPENSABLE: [&str; 9] =
    ["change", "circle", "Nomoto K", "Nomoto T", "b2", "a22", "mean radius", "yaw rate", "rudder"];

fn text(document: &TurningLimits, width: usize) -> String {
    let (rudder_scale, rudder) = document.rudder_unit.for_people();
    let mut table = Table::under(&format!(
        "thrust [%] | speed [m/s] | a22 [1/s] | b2 [1/s^2] | Nomoto T [s] | Nomoto K [1/s] | side | \
            rudder [{rudder}] | yaw rate [deg/s] | U-turn [s] | mean radius [m] | steady radius [m] | \
            circle [m, by U-turn] | change [s, trapezoid] | change [s, full rudder]"
    ));
    let mut notes = Vec::new();
    for point in &document.points {
        for limits in &point.sides {
            table.row(row(point, limits, rudder_scale));
        }
        let [one, other] = &point.sides;
        match (&one.refused, &other.refused) {
            (Some(reason), Some(same)) if reason == same => {
                notes.push(format!("No turning limits: {reason}."));
            }
            _ => notes.extend(point.sides.iter().filter_map(|limits| {
                let reason = limits.refused.as_ref()?;
                Some(format!("No turn to {}: {reason}.", side_name(limits.side)))
            })),
        }
    }
    if document.points.iter().any(|p| p.surge_speed_m_s.is_none()) {
        notes.push("No radius without a speed, and the log had none or not nearly one: give it with --speed.".into());
    }
    notes.extend(tightest_text(&document.points));
    notes.extend(document.over_speed.iter().filter_map(over_speed_text));
    notes.dedup();
    let text = format!(
        "{}Turning limits of {}, rudder limit {:.1} {rudder}, heading change {:.0} deg\n{}\n{}\n{}",
        rejected_text(&document.rejected),
        document.source,
        document.rudder_limit_rad * rudder_scale,
        document.heading_change_rad.to_degrees(),
        trial_line(document.trial.as_deref()),
        table.fitted(width, &DISPENSABLE),
        notes.join("\n")
    );
    wrapped(&text, width)
}

/// Limits of a model to one side.
fn row(point: &PointLimits, limits: &SideLimits, rudder_scale: f64) -> Vec<String> {
    vec![
        number(point.thrust.map(|thrust| 100.0 * thrust), 0),
        number(point.surge_speed_m_s, 2),
        format!("{:.3}", point.model.a22_per_s),
        format!("{:.3}", point.model.b2_per_s2),
        estimate_cell(&point.nomoto_t_s, 2, 1.0),
        estimate_cell(&point.nomoto_k_per_s, 2, 1.0),
        side_name(limits.side).into(),
        number(limits.rudder_rad.map(|rudder| rudder * rudder_scale), 1),
        estimate_cell(&limits.yaw_rate_rad_s, 2, 1_f64.to_degrees()),
        estimate_cell(&limits.u_turn_time_s, 2, 1.0),
        estimate_cell(&limits.u_turn_mean_radius_m, 2, 1.0),
        estimate_cell(&limits.steady_turning_radius_m, 2, 1.0),
        estimate_cell(&limits.circle_by_u_turn_m, 2, 1.0),
        estimate_cell(&limits.trapezoid_time_s, 2, 1.0),
        estimate_cell(&limits.full_rudder_time_s, 2, 1.0),
    ]
}

fn side_name(side: Side) -> &'static str {
    match side {
        Side::Starboard => "starboard",
        Side::Port => "port",
    }
}

/// Which of several identified speeds turns tightest, and how tightly.
fn tightest_text(points: &[PointLimits]) -> Option<String> {
    let known = |point: &PointLimits| {
        let [starboard, port] = [0, 1].map(|side| point.sides[side].u_turn_mean_radius_m);
        let [starboard, port] = [starboard?.value, port?.value];
        Some((point.surge_speed_m_s?, starboard, port))
    };
    let speeds: Vec<(f64, f64, f64)> = points.iter().filter_map(known).collect();
    let least = speeds.iter().min_by(|a, b| (a.1 + a.2).total_cmp(&(b.1 + b.2)));
    let (speed, starboard, port) = least.filter(|_| speeds.len() > 1)?;
    Some(format!(
        "The tightest U-turn of these speeds is at {speed:.2} m/s: mean radius {starboard:.1} m to starboard, {port:.1} m to port."
    ))
}

/// The speed of the tightest turn by a law of b2 over speed, in a sentence; how it was fitted is in the document. `None` where the law has it
/// at an end of the speeds.
fn over_speed_text(over_speed: &OverSpeed) -> Option<String> {
    let law = match over_speed.fit.form {
        AuthorityForm::ThroughZero => "the speed squared",
        AuthorityForm::WithConstant => "the speed squared and has a part that does not grow",
    };
    match (&over_speed.minimum, &over_speed.refused) {
        (Some(minimum), _) => Some(format!(
            "If the rudder's effect grows with {law}, the tightest U-turn is at {:.2} m/s{}: mean radius {:.1} m.",
            minimum.surge_speed_m_s,
            match minimum.extrapolated {
                true => " (EXTRAPOLATED beyond the identified speeds)",
                false => "",
            },
            minimum.u_turn_mean_radius_m,
        )),
        (None, Some(reason)) => Some(format!("No speed of the tightest turn: {reason}.")),
        (None, None) => None,
    }
}

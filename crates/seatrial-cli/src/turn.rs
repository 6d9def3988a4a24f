//! `seatrial turn`: turning limits to either hand, and over speed.

use std::str::FromStr;

use seatrial_core::RudderUnit;
use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::turning::{RadiusMinimum, TurningOverSpeed};
use seatrial_core::{SchedulePoint, Side, Turn, YawModel};
use serde::Serialize;

use crate::model_source::{SourceArgs, trial_line, warn};
use crate::output::{Exit, Failure, Output};
use crate::table::{Table, estimate_text};
use seatrial_app::models::{Estimate, ModelPoint, Models, SCHEDULE_FILE_HELP, TrialOrigin};

/// Turning limits from a model or a schedule, to either hand.
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
    #[arg(long, value_name = "M_S:M")]
    measured_u_turn: Option<UTurn>,
}

/// A U-turn that was measured.
#[derive(Clone, Copy, Debug)]
struct UTurn {
    surge_speed_m_s: f64,
    radius_m: f64,
}

impl FromStr for UTurn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let positive = |part: &str| {
            part.parse()
                .ok()
                .filter(|x: &f64| *x > 0.0 && x.is_finite())
        };
        text.split_once(':')
            .and_then(|(speed, radius)| {
                Some(Self {
                    surge_speed_m_s: positive(speed)?,
                    radius_m: positive(radius)?,
                })
            })
            .ok_or_else(|| format!("{text}: expected SPEED:RADIUS in m/s and m, as in 1.63:7.9"))
    }
}

fn help() -> String {
    format!(
        "Example:\n  seatrial turn --a22 -1.62 --b2 1.25 --c0 0.045 --speed 1.4 --heading-change-deg 90 --measured-u-turn 1.4:6.5\n\n{SCHEDULE_FILE_HELP}"
    )
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    source: &'a str,
    rudder_limit_rad: f64,
    rudder_unit: RudderUnit,
    heading_change_rad: f64,
    /// The trial that the models are of.
    trial: Option<String>,
    /// Radius of the measured U-turn over the model's steady radius at its speed.
    u_turn_ratio: Option<f64>,
    /// Where the rudder limit is beyond what a model was seen with.
    beyond_range: Vec<String>,
    points: Vec<PointLimits>,
    over_speed: Vec<OverSpeed>,
}

#[derive(Serialize)]
struct PointLimits {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    #[serde(flatten)]
    model: YawModel<f64>,
    delta0_rad: Option<f64>,
    nomoto_t_s: Option<Estimate>,
    nomoto_k_per_s: Option<Estimate>,
    hands: [HandLimits; 2],
}

#[derive(Serialize)]
struct HandLimits {
    hand: Side,
    /// Why there is no turn to this hand.
    refused: Option<String>,
    rudder_rad: Option<f64>,
    yaw_rate_rad_s: Option<Estimate>,
    rise_time_s: Option<Estimate>,
    u_turn_time_s: Option<Estimate>,
    u_turn_mean_radius_m: Option<Estimate>,
    steady_turning_radius_m: Option<Estimate>,
    /// The steady radius times the ratio of the measured U-turn; the interval is the model's alone.
    circle_by_u_turn_m: Option<Estimate>,
    trapezoid_time_s: Option<Estimate>,
    full_rudder_time_s: Option<Estimate>,
}

/// The paper's (52): mean a22, fitted b2, no offset.
#[derive(Serialize)]
struct OverSpeed {
    #[serde(flatten)]
    fit: AuthorityFit<f64>,
    mean_a22_per_s: f64,
    searched_m_s: [f64; 2],
    minimum: Option<RadiusMinimum<f64>>,
    refused: Option<String>,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let source = args.source.read()?;
    warn(&source);
    let heading_change_rad = args.heading_change_deg.to_radians();
    if !heading_change_rad.is_finite() {
        return Err(Failure::usage("--heading-change-deg: expected a number"));
    }
    let u_turn_ratio = args
        .measured_u_turn
        .map(|u_turn| ratio(u_turn, &source))
        .transpose()?;
    let limits =
        |point: &ModelPoint| point_limits(point, &source, heading_change_rad, u_turn_ratio);
    let document = Document {
        schema: "seatrial.turn.v1",
        source: &source.origin,
        rudder_limit_rad: source.rudder_limit_rad,
        rudder_unit: source.rudder_unit,
        heading_change_rad,
        trial: source.trial.as_ref().map(TrialOrigin::text),
        u_turn_ratio,
        beyond_range: source.beyond_range(),
        points: source.points.iter().map(limits).collect(),
        over_speed: over_speed(&source, args.up_to_speed)?,
    };
    output.print(&document, || text(&document))?;
    let refused = document
        .points
        .iter()
        .any(|p| p.hands.iter().any(|hand| hand.refused.is_some()));
    Ok(if refused || !source.rejected.is_empty() {
        Exit::Rejected
    } else {
        Exit::Done
    })
}

/// Speeds outside the identified ones by this factor are too far for a ratio.
const FAR: f64 = 1.1;

/// The measured radius over the model's, mean of both hands and linear in speed between the points.
fn ratio(u_turn: UTurn, source: &Models) -> Result<f64, Failure> {
    let refused = |reason: &str| Failure::usage(format!("--measured-u-turn: {reason}"));
    let mut radii: Vec<[f64; 2]> = source
        .points
        .iter()
        .filter_map(|point| {
            let speed_m_s = point.point.surge_speed_m_s?;
            let radius = |hand| {
                let turn = Turn::new(&point.point.model, source.rudder_limit_rad, hand).ok()?;
                Some(turn.steady_turning_radius_m(speed_m_s))
            };
            Some([
                speed_m_s,
                0.5 * (radius(Side::Starboard)? + radius(Side::Port)?),
            ])
        })
        .collect();
    radii.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let speed_m_s = u_turn.surge_speed_m_s;
    let (Some([slowest, _]), Some([fastest, _])) = (radii.first(), radii.last()) else {
        return Err(refused("no model here has a speed and turns to both hands"));
    };
    if speed_m_s < slowest / FAR || speed_m_s > fastest * FAR {
        return Err(refused(&format!(
            "{speed_m_s} m/s is far from the identified speeds, {slowest:.2} to {fastest:.2} m/s"
        )));
    }
    let above = radii.partition_point(|[speed, _]| *speed < speed_m_s);
    let predicted_m = match (above.checked_sub(1), radii.get(above)) {
        (Some(below), Some([v1, r1])) => {
            let [v0, r0] = radii[below];
            r0 + (r1 - r0) * (speed_m_s - v0) / (v1 - v0)
        }
        (Some(below), None) => radii[below][1],
        (None, _) => radii[0][1],
    };
    Ok(u_turn.radius_m / predicted_m)
}

fn point_limits(
    point: &ModelPoint,
    source: &Models,
    heading_change_rad: f64,
    u_turn_ratio: Option<f64>,
) -> PointLimits {
    let SchedulePoint {
        thrust,
        surge_speed_m_s,
        model,
    } = point.point;
    let limits = |hand: Side| {
        let turn = |model: &YawModel<f64>| Turn::new(model, source.rudder_limit_rad, hand);
        let of = |quantity: &dyn Fn(Turn<f64>) -> Option<f64>| {
            point.estimate(|model| quantity(turn(model).ok()?))
        };
        let found = turn(&model);
        HandLimits {
            hand,
            refused: found.err().map(|reason| reason.to_string()),
            rudder_rad: found.ok().map(|turn| turn.rudder_rad),
            yaw_rate_rad_s: of(&|turn| Some(turn.yaw_rate_rad_s)),
            rise_time_s: of(&|turn| Some(turn.rise_time_s())),
            u_turn_time_s: of(&|turn| Some(turn.u_turn_time_s())),
            u_turn_mean_radius_m: of(&|turn| Some(turn.u_turn_mean_radius_m(surge_speed_m_s?))),
            steady_turning_radius_m: of(&|turn| {
                Some(turn.steady_turning_radius_m(surge_speed_m_s?))
            }),
            circle_by_u_turn_m: of(&|turn| {
                Some(u_turn_ratio? * turn.steady_turning_radius_m(surge_speed_m_s?))
            }),
            trapezoid_time_s: of(&|turn| Some(turn.trapezoid_time_s(heading_change_rad))),
            full_rudder_time_s: of(&|turn| Some(turn.full_rudder_time_s(heading_change_rad))),
        }
    };
    PointLimits {
        thrust,
        surge_speed_m_s,
        model,
        delta0_rad: model.delta0_rad(),
        nomoto_t_s: point.estimate(|model| Some(model.nomoto()?.t_s)),
        nomoto_k_per_s: point.estimate(|model| Some(model.nomoto()?.k_per_s)),
        hands: [Side::Starboard, Side::Port].map(limits),
    }
}

/// Both fits of b2 over speed, where at least two speeds are known.
fn over_speed(source: &Models, up_to: Option<f64>) -> Result<Vec<OverSpeed>, Failure> {
    let points: Vec<SchedulePoint<f64>> = source
        .points
        .iter()
        .map(|p| p.point)
        .filter(|p| p.surge_speed_m_s.is_some())
        .collect();
    let mean_a22_per_s =
        points.iter().map(|p| p.model.a22_per_s).sum::<f64>() / points.len() as f64;
    let mut fits = Vec::new();
    for form in [AuthorityForm::ThroughZero, AuthorityForm::WithConstant] {
        let Ok(fit) = AuthorityFit::new(&points, form) else {
            if up_to.is_some() {
                return Err(Failure::usage(
                    "--up-to-speed needs a source with at least two different speeds",
                ));
            }
            return Ok(fits);
        };
        let searched_m_s = [
            fit.speed_range_m_s[0],
            up_to.unwrap_or(fit.speed_range_m_s[1]),
        ];
        let minimum = TurningOverSpeed {
            a22_per_s: mean_a22_per_s,
            authority: fit,
            rudder_limit_rad: source.rudder_limit_rad,
        }
        .minimum_radius(searched_m_s[0], searched_m_s[1]);
        fits.push(OverSpeed {
            fit,
            mean_a22_per_s,
            searched_m_s,
            minimum: minimum.ok().flatten(),
            refused: minimum.err().map(|reason| reason.to_string()),
        });
    }
    Ok(fits)
}

fn text(document: &Document) -> String {
    let (rudder_scale, rudder) = document.rudder_unit.for_people();
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("a22", "1/s"),
        ("b2", "1/s^2"),
        ("Nomoto T", "s"),
        ("Nomoto K", "1/s"),
        ("hand", ""),
        ("rudder", rudder),
        ("yaw rate", "deg/s"),
        ("U-turn", "s"),
        ("mean radius", "m"),
        ("steady radius", "m"),
        ("circle", "m, by U-turn"),
        ("change", "s, trapezoid"),
        ("change", "s, full rudder"),
    ]);
    let estimate = |estimate: &Option<Estimate>, decimals, scale| {
        estimate.map_or("-".into(), |e: Estimate| estimate_text(&e, decimals, scale))
    };
    let mut notes = Vec::new();
    for point in &document.points {
        for limits in &point.hands {
            let optional = |x: Option<f64>, scale: f64, decimals: usize| {
                x.map_or("-".into(), |x| format!("{:.decimals$}", x * scale))
            };
            let hand = match limits.hand {
                Side::Starboard => "starboard",
                Side::Port => "port",
            };
            table.row(vec![
                optional(point.thrust, 100.0, 0),
                optional(point.surge_speed_m_s, 1.0, 2),
                format!("{:.3}", point.model.a22_per_s),
                format!("{:.3}", point.model.b2_per_s2),
                estimate(&point.nomoto_t_s, 2, 1.0),
                estimate(&point.nomoto_k_per_s, 2, 1.0),
                hand.into(),
                optional(limits.rudder_rad, rudder_scale, 1),
                estimate(&limits.yaw_rate_rad_s, 2, 1_f64.to_degrees()),
                estimate(&limits.u_turn_time_s, 2, 1.0),
                estimate(&limits.u_turn_mean_radius_m, 2, 1.0),
                estimate(&limits.steady_turning_radius_m, 2, 1.0),
                estimate(&limits.circle_by_u_turn_m, 2, 1.0),
                estimate(&limits.trapezoid_time_s, 2, 1.0),
                estimate(&limits.full_rudder_time_s, 2, 1.0),
            ]);
            if let Some(reason) = &limits.refused {
                notes.push(format!("No turn to {hand}: {reason}."));
            }
        }
    }
    notes.extend(document.over_speed.iter().map(over_speed_text));
    format!(
        "Turning limits of {}, rudder limit {:.1} {rudder}, heading change {:.0} deg\n{}\n{table}\n{}",
        document.source,
        document.rudder_limit_rad * rudder_scale,
        document.heading_change_rad.to_degrees(),
        trial_line(document.trial.as_deref()),
        notes.join("\n")
    )
}

fn over_speed_text(over_speed: &OverSpeed) -> String {
    let fit = &over_speed.fit;
    let law = match fit.form {
        AuthorityForm::ThroughZero => format!("{:.3} V^2", fit.per_speed_squared_per_m2),
        AuthorityForm::WithConstant => format!(
            "{:.3} V^2 {:+.3}",
            fit.per_speed_squared_per_m2, fit.constant_per_s2
        ),
    };
    let [from, to] = over_speed.searched_m_s;
    let found = match (&over_speed.minimum, &over_speed.refused) {
        (Some(minimum), _) => format!(
            "least U-turn mean radius {:.2} m at {:.2} m/s{}",
            minimum.u_turn_mean_radius_m,
            minimum.surge_speed_m_s,
            if minimum.extrapolated {
                " (EXTRAPOLATED beyond the identified speeds)"
            } else {
                ""
            }
        ),
        (None, Some(reason)) => reason.clone(),
        (None, None) => {
            format!("no least U-turn mean radius inside {from:.2} to {to:.2} m/s")
        }
    };
    format!(
        "With b2 = {law} (rms {:.3} 1/s^2) and a22 = {:.3} 1/s: {found}.",
        fit.rms_residual_per_s2, over_speed.mean_a22_per_s
    )
}

//! `seatrial gains`: the heading controller's gains, feed-forward and margins.

mod export;

use std::path::PathBuf;

use seatrial::GainAllowance;
use seatrial::gain_allowance::{least_damped_schedule, longest};
use seatrial::verdict::three_figures;
use seatrial_core::RudderUnit;
use seatrial_core::heading_loop::{LoopTiming, Poles};
use seatrial_core::schedule::{Beyond, ScheduleError, ScheduleKey};
use seatrial_core::{GainSchedule, HeadingGain, HeadingLoop, SpeedSchedule, YawModel};
use serde::Serialize;

use crate::model_source::{SourceArgs, trial_line, warn};
use crate::output::{Exit, Failure, Output};
use crate::table::{Table, estimate_text};
use seatrial_app::models::{Estimate, ModelPoint, Models, SCHEDULE_FILE_HELP, TrialOrigin};

const SCHEMA: &str = "seatrial.gains.v1";

/// Heading controller gains from a model or a schedule, with margins.
///
/// rudder = K_p (desired heading - heading) - delta0, limited. K_p allows for the delays of the loop, as
/// far as the record tells or as given, and for the least damped model of the 95 % interval; the
/// paper's (57) beside it for neither. Damping and margins are those of the loop with K_p; their
/// intervals say what the uncertainty of the model makes of it.
#[derive(clap::Args)]
#[command(after_help = help())]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Damping ratio of the closed loop.
    #[arg(long, value_name = "RATIO", default_value_t = std::f64::consts::FRAC_1_SQRT_2)]
    zeta: f64,
    /// Dead time of compass, computer and rudder, s. Without: a sample of the record and the lag of its
    /// rudder, where they are known.
    #[arg(long, value_name = "S")]
    delay: Option<f64>,
    /// Interval of a sampled controller, s; 0 is continuous. Without: that of the record, where it is known.
    #[arg(long, value_name = "S")]
    interval: Option<f64>,
    /// Gain at this thrust, a fraction of full, interpolated.
    #[arg(long, value_name = "FRACTION", conflicts_with = "at_speed")]
    at_thrust: Option<f64>,
    /// Gain at this speed, m/s, interpolated.
    #[arg(long, value_name = "M_S")]
    at_speed: Option<f64>,
    /// Allows an --at-thrust or --at-speed outside the identified range; the result is marked.
    #[arg(long)]
    extrapolate: bool,
    /// Rudder angle at full steering, degrees, where the source does not know it; else the rudder limit.
    #[arg(long, value_name = "DEG", requires = "export")]
    full_rudder_deg: Option<f64>,
    /// Writes gains and limits for a controller; the table is printed too where they go to a file.
    #[arg(long, value_name = "FORMAT")]
    export: Option<export::Format>,
    /// Exports from a rehearsal on a simulator, too.
    #[arg(long, requires = "export")]
    rehearsal: bool,
    /// Whose parameters ardupilot and px4 are: surface is Rover, underwater Sub and UUV.
    #[arg(
        long,
        value_name = "TYPE",
        default_value = "surface",
        requires = "export"
    )]
    vehicle_type: export::VehicleType,
    /// Where the export goes; standard output without.
    #[arg(long, value_name = "FILE", requires = "export")]
    out: Option<PathBuf>,
}

fn help() -> String {
    format!(
        "Example:\n  seatrial gains --a22 -1.28 --b2 0.65 --c0 0.0129 --delay 0.1 --interval 0.05\n  \
         seatrial gains --a22 -1.28 --b2 0.65 --speed 1.05 --export ardupilot --vehicle-type underwater\n\n\
         ardupilot and px4 have no gain schedule: their parameters are those of --at-speed or --at-thrust, else of the\n\
         fastest model, which damps well at every lower speed. docs/exports.md derives every parameter.\n\n\
         {SCHEDULE_FILE_HELP}"
    )
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    source: &'a str,
    damping_ratio: f64,
    rudder_limit_rad: f64,
    rudder_unit: RudderUnit,
    /// The trial that the models are of.
    trial: Option<String>,
    /// The longest of the points.
    timing: LoopTiming<f64>,
    points: Vec<PointGains>,
    at: Option<InterpolatedGain>,
}

#[derive(Serialize)]
struct PointGains {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    #[serde(flatten)]
    model: YawModel<f64>,
    nomoto_t_s: Option<Estimate>,
    nomoto_k_per_s: Option<Estimate>,
    /// Why there is no gain.
    refused: Option<String>,
    /// To load.
    proportional_gain: Option<Estimate>,
    /// What it allows for.
    allowance: GainAllowance,
    /// The paper's gain, which allows for nothing.
    gain_of_57: Option<Estimate>,
    feed_forward_rudder_rad: Option<Estimate>,
    #[serde(rename = "loop")]
    closed_loop: Option<LoopFigures>,
}

/// The closed loop at a fixed gain.
#[derive(Serialize)]
struct LoopFigures {
    poles_per_s: Poles<f64>,
    damping_ratio: Option<Estimate>,
    natural_frequency_rad_s: Option<Estimate>,
    overshoot: Option<Estimate>,
    /// A factor; null is infinite.
    gain_margin: Option<Estimate>,
    phase_margin_rad: Option<Estimate>,
    delay_margin_s: Option<Estimate>,
}

#[derive(Serialize)]
struct InterpolatedGain {
    key: ScheduleKey,
    value: f64,
    extrapolated: bool,
    proportional_gain: Estimate,
    feed_forward_rudder_rad: f64,
    #[serde(rename = "loop")]
    closed_loop: Option<LoopFigures>,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let full_rudder_rad = args.full_rudder_deg.map(f64::to_radians);
    let mut source = args.source.read()?.with_full_rudder(full_rudder_rad)?;
    warn(&source);
    for point in &mut source.points {
        let timing = &mut point.allowance.timing;
        timing.delay_s = args.delay.unwrap_or(timing.delay_s);
        if let Some(interval_s) = args.interval {
            timing.sample_interval_s = (interval_s != 0.0).then_some(interval_s);
        }
    }
    let timing = longest(source.points.iter().map(|point| point.allowance));
    check(args.zeta, timing)?;
    let points = source.points.iter();
    let document = Document {
        schema: SCHEMA,
        source: &source.origin,
        damping_ratio: args.zeta,
        rudder_limit_rad: source.rudder_limit_rad,
        rudder_unit: source.rudder_unit,
        trial: source.trial.as_ref().map(TrialOrigin::text),
        timing,
        points: points.map(|p| point_gains(p, args.zeta)).collect(),
        at: interpolated(args, &source)?,
    };
    if let Some(format) = args.export {
        export::write(format, args, &source, output)?;
    }
    if args.export.is_none() || args.out.is_some() {
        output.print(&document, || text(&document))?;
    }
    let refused = document.points.iter().any(|p| p.refused.is_some());
    Ok(if refused || !source.rejected.is_empty() {
        Exit::Rejected
    } else {
        Exit::Done
    })
}

/// Refuses settings that no model could satisfy.
fn check(zeta: f64, timing: LoopTiming<f64>) -> Result<(), Failure> {
    let stable = YawModel::from_theta([-1.0, 1.0, 0.0]);
    HeadingGain::design(&stable, zeta)
        .map_err(|reason| Failure::usage(format!("--zeta {zeta}: {reason}")))?;
    HeadingLoop::new(&stable, 1.0)
        .and_then(|closed| closed.margins(timing))
        .map_err(|reason| Failure::usage(format!("--delay, --interval: {reason}")))?;
    Ok(())
}

fn point_gains(point: &ModelPoint, zeta: f64) -> PointGains {
    let model = point.point.model;
    let design = |model: &YawModel<f64>| point.allowance.design(model, zeta);
    let gain = design(&model);
    let of = |quantity: fn(HeadingGain<f64>) -> f64| {
        point.estimate(|model| Some(quantity(design(model).ok()?)))
    };
    let of_57 = |model: &YawModel<f64>| HeadingGain::design(model, zeta).ok();
    PointGains {
        thrust: point.point.thrust,
        surge_speed_m_s: point.point.surge_speed_m_s,
        model,
        nomoto_t_s: point.estimate(|model| Some(model.nomoto()?.t_s)),
        nomoto_k_per_s: point.estimate(|model| Some(model.nomoto()?.k_per_s)),
        refused: gain.err().map(|reason| reason.to_string()),
        proportional_gain: of(|gain| gain.proportional_gain),
        allowance: point.allowance,
        gain_of_57: point.estimate(|model| Some(of_57(model)?.proportional_gain)),
        feed_forward_rudder_rad: of(|gain| gain.feed_forward_rudder_rad),
        closed_loop: gain
            .ok()
            .and_then(|gain| loop_figures(point, gain.proportional_gain, point.allowance.timing)),
    }
}

fn loop_figures(point: &ModelPoint, gain: f64, timing: LoopTiming<f64>) -> Option<LoopFigures> {
    let closed = |model: &YawModel<f64>| HeadingLoop::new(model, gain).ok();
    let margins = |model: &YawModel<f64>| closed(model)?.margins(timing).ok();
    Some(LoopFigures {
        poles_per_s: closed(&point.point.model)?.poles(),
        damping_ratio: point.estimate(|model| Some(closed(model)?.damping_ratio())),
        natural_frequency_rad_s: point
            .estimate(|model| Some(closed(model)?.natural_frequency_rad_s())),
        overshoot: point.estimate(|model| Some(closed(model)?.overshoot())),
        gain_margin: point.estimate(|model| margins(model)?.gain_margin),
        phase_margin_rad: point.estimate(|model| margins(model)?.phase_margin_rad),
        delay_margin_s: point.estimate(|model| margins(model)?.delay_margin_s),
    })
}

/// The place in the schedule that the command line asks for.
fn asked(args: &Args) -> Option<(ScheduleKey, f64)> {
    let thrust = args.at_thrust.map(|thrust| (ScheduleKey::Thrust, thrust));
    thrust.or(args.at_speed.map(|speed| (ScheduleKey::Speed, speed)))
}

fn beyond(args: &Args) -> Beyond {
    if args.extrapolate {
        Beyond::Extrapolate
    } else {
        Beyond::Refuse
    }
}

fn no_such_place(args: &Args, key: ScheduleKey, value: f64, error: ScheduleError) -> Failure {
    let hint = if args.extrapolate {
        ""
    } else {
        " (--extrapolate allows it)"
    };
    Failure::usage(format!("{} {value}: {error}{hint}", key.name()))
}

/// The least damped models, for which gains are designed, and what their loops wait for.
fn cautious(
    source: &Models,
    key: ScheduleKey,
) -> Result<(SpeedSchedule<f64>, LoopTiming<f64>), Failure> {
    let points = source.points.iter().map(|p| (p.point, p.allowance));
    least_damped_schedule(key, points)
        .map_err(|error| Failure::input(format!("{}: {error}", source.origin)))
}

fn interpolated(args: &Args, source: &Models) -> Result<Option<InterpolatedGain>, Failure> {
    let Some((key, value)) = asked(args) else {
        return Ok(None);
    };
    let schedule = source.schedule(key)?;
    let refused = |error| no_such_place(args, key, value, error);
    let (cautious, timing) = cautious(source, key)?;
    let gains = GainSchedule::design(cautious, args.zeta, timing)
        .map_err(|error| Failure::input(format!("{}: {} {error}", source.origin, key.name())))?;
    let gain = gains.lookup(value, beyond(args)).map_err(refused)?;
    let model = schedule.lookup(value, beyond(args)).map_err(refused)?;
    let proportional_gain = gain.value().proportional_gain;
    let here = ModelPoint {
        point: *model.value(),
        covariance: None,
        allowance: GainAllowance::default(),
        noise: None,
        valid_range: None,
    };
    Ok(Some(InterpolatedGain {
        key,
        value,
        extrapolated: gain.is_extrapolated(),
        proportional_gain: Estimate {
            value: proportional_gain,
            interval_95: interpolated_interval(args.zeta, source, key, value, proportional_gain),
        },
        feed_forward_rudder_rad: gain.value().feed_forward_rudder_rad,
        closed_loop: loop_figures(&here, proportional_gain, timing),
    }))
}

/// The half widths of the two neighbours, weighted by their distance; their runs err independently.
fn interpolated_interval(
    zeta: f64,
    source: &Models,
    key: ScheduleKey,
    value: f64,
    gain: f64,
) -> Option<[f64; 2]> {
    let mut known: Vec<(f64, f64)> = source
        .points
        .iter()
        .filter_map(|point| {
            let design = |model: &YawModel<f64>| point.allowance.design(model, zeta).ok();
            let estimate = point.estimate(|model| Some(design(model)?.proportional_gain))?;
            let [low, high] = estimate.interval_95?;
            Some((point.point.key(key)?, (high - low) / 2.0))
        })
        .collect();
    if known.len() < source.points.len() {
        return None;
    }
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pair = known
        .windows(2)
        .find(|pair| value <= pair[1].0)
        .or_else(|| known.windows(2).last())?;
    let fraction = (value - pair[0].0) / (pair[1].0 - pair[0].0);
    let half_width = ((1.0 - fraction) * pair[0].1).hypot(fraction * pair[1].1);
    Some([gain - half_width, gain + half_width])
}

fn text(document: &Document) -> String {
    let (rudder_scale, rudder) = document.rudder_unit.for_people();
    let per_angle = match document.rudder_unit {
        RudderUnit::Rad => "rad/rad",
        RudderUnit::FullRudder => "full/rad",
    };
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("a22", "1/s"),
        ("b2", "1/s^2"),
        ("Nomoto T", "s"),
        ("Nomoto K", "1/s"),
        ("K_p", per_angle),
        ("(57)", per_angle),
        ("feed-forward", rudder),
        ("damping", ""),
        ("frequency", "rad/s"),
        ("overshoot", "%"),
        ("gain margin", "factor"),
        ("phase margin", "deg"),
        ("delay margin", "s"),
    ]);
    let optional = |x: Option<f64>, scale: f64, decimals: usize| {
        x.map_or("-".into(), |x| format!("{:.decimals$}", x * scale))
    };
    for point in &document.points {
        let mut cells = vec![
            optional(point.thrust, 100.0, 0),
            optional(point.surge_speed_m_s, 1.0, 2),
            format!("{:.3}", point.model.a22_per_s),
            format!("{:.3}", point.model.b2_per_s2),
            estimate(&point.nomoto_t_s, 2, 1.0),
            estimate(&point.nomoto_k_per_s, 2, 1.0),
            estimate(&point.proportional_gain, 3, 1.0),
            estimate(&point.gain_of_57, 3, 1.0),
            estimate(&point.feed_forward_rudder_rad, 2, rudder_scale),
        ];
        cells.extend(loop_cells(&point.closed_loop));
        table.row(cells);
    }
    let mut notes: Vec<String> = document
        .points
        .iter()
        .filter_map(|p| p.refused.as_ref())
        .map(|reason| format!("No gain: {reason}."))
        .collect();
    if let Some(at) = &document.at {
        notes.push(at_text(at, document.rudder_unit));
    }
    format!(
        "Heading gains of {}, damping ratio {:.4}, rudder limit {:.1} {rudder}\n{}\
         K_p and margins with {:.3} s delay, {}\n\n{table}\n{}",
        document.source,
        document.damping_ratio,
        document.rudder_limit_rad * rudder_scale,
        trial_line(document.trial.as_deref()),
        document.timing.delay_s,
        document
            .timing
            .sample_interval_s
            .map_or("continuous controller".into(), |h| format!(
                "sampled every {} s",
                three_figures(h)
            )),
        notes.join("\n")
    )
}

fn estimate(estimate: &Option<Estimate>, decimals: usize, scale: f64) -> String {
    estimate.map_or("-".into(), |e| estimate_text(&e, decimals, scale))
}

fn loop_cells(closed_loop: &Option<LoopFigures>) -> Vec<String> {
    let Some(figures) = closed_loop else {
        return vec!["-".into(); 6];
    };
    vec![
        estimate(&figures.damping_ratio, 3, 1.0),
        estimate(&figures.natural_frequency_rad_s, 2, 1.0),
        estimate(&figures.overshoot, 1, 100.0),
        figures
            .gain_margin
            .map_or("infinite".into(), |margin| estimate_text(&margin, 1, 1.0)),
        estimate(&figures.phase_margin_rad, 1, 1_f64.to_degrees()),
        estimate(&figures.delay_margin_s, 2, 1.0),
    ]
}

fn at_text(at: &InterpolatedGain, rudder_unit: RudderUnit) -> String {
    let (rudder_scale, rudder) = rudder_unit.for_people();
    let place = match at.key {
        ScheduleKey::Thrust => format!("{:.0} % thrust", at.value * 100.0),
        ScheduleKey::Speed => format!("{:.2} m/s", at.value),
    };
    let how = if at.extrapolated {
        "EXTRAPOLATED beyond the identified range"
    } else {
        "interpolated"
    };
    let figures = at.closed_loop.as_ref().map_or(String::new(), |figures| {
        format!(
            ", damping {} and phase margin {} deg with the model interpolated likewise",
            estimate(&figures.damping_ratio, 3, 1.0),
            estimate(&figures.phase_margin_rad, 1, 1_f64.to_degrees())
        )
    });
    format!(
        "At {place} ({how}): K_p {}, feed-forward {:.2} {rudder}{figures}.",
        estimate_text(&at.proportional_gain, 3, 1.0),
        at.feed_forward_rudder_rad * rudder_scale
    )
}

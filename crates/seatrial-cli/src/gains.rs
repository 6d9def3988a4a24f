//! `seatrial gains`: the heading controller's gains, feed-forward and margins.

mod export;

use std::path::Path;

use seatrial::gains::DAMPING_RATIO;
use seatrial::gains::export::VehicleType;
use seatrial::verdict::three_figures;
use seatrial_app::gains::{HeadingGains, InterpolatedGain, LoopFigures, LoopRequirements};
use seatrial_app::gains_export::{Format, check_usable};
use seatrial_app::models::{Estimate, SCHEDULE_FILE_HELP};
use seatrial_core::RudderUnit;
use seatrial_core::schedule::{Beyond, ScheduleKey};

use crate::choice::{form_of, one_of};
use crate::model_source::{SourceArgs, rejected_text, trial_line, warn};
use crate::output::{Exit, Failure, Output, OutputPath};
use crate::screen::{width, wrapped};
use crate::table::{Table, estimate_cell, estimate_text, number};

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
    #[arg(long, value_name = "RATIO", default_value_t = DAMPING_RATIO)]
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
    #[arg(long, value_name = "FORMAT", value_parser = form_of::<Format>())]
    export: Option<Format>,
    /// Exports from a rehearsal on a simulator, too.
    #[arg(long, requires = "export")]
    rehearsal: bool,
    /// Exports a gain that is warned of, too: of models that are not to be used, or whose interval holds 0.
    #[arg(long, requires = "export")]
    accept: bool,
    /// Whose parameters ardupilot and px4 are: surface is Rover, underwater Sub and UUV.
    #[arg(
        long,
        value_name = "TYPE",
        default_value = "surface",
        value_parser = one_of(export::VEHICLE_TYPES),
        requires = "export"
    )]
    vehicle_type: VehicleType,
    /// Where the export goes; standard output without.
    #[arg(long, value_name = "FILE", requires = "export")]
    out: Option<OutputPath>,
}

fn help() -> String {
    format!(
        "\
ardupilot and px4 have no gain schedule: their parameters are those of --at-speed or --at-thrust, else of the \
fastest model, which damps well at every lower speed. docs/exports.md derives every parameter.

Examples:
  seatrial gains --a22 -1.28 --b2 0.65 --c0 0.0129 --delay 0.1 --interval 0.05
  seatrial gains --a22 -1.28 --b2 0.65 --speed 1.05 --export ardupilot \\
      --vehicle-type underwater

{SCHEDULE_FILE_HELP}"
    )
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let full_rudder_rad = args.full_rudder_deg.map(f64::to_radians);
    let wanted = args.wanted();
    let models = args.source.read()?.with_full_rudder(full_rudder_rad)?;
    warn(&models);
    let document = wanted.gains(&models)?;
    if let Some(format) = args.export {
        if !args.accept {
            check_usable(&wanted, &models).map_err(|error| {
                Failure::rejected(format!("{error}; --accept writes it all the same"))
            })?;
        }
        export::write(format, args, &models, output)?;
    }
    if args.export.is_none() || args.out.is_some() {
        output.print(&document, || text(&document, args.out.as_deref(), width()))?;
    }
    Ok(Exit::done_if(!document.is_refused()))
}

impl Args {
    fn wanted(&self) -> LoopRequirements {
        let thrust = self.at_thrust.map(|thrust| (ScheduleKey::Thrust, thrust));
        LoopRequirements {
            damping_ratio: self.zeta,
            delay_s: self.delay,
            interval_s: self.interval,
            at: thrust.or(self.at_speed.map(|speed| (ScheduleKey::Speed, speed))),
            beyond: match self.extrapolate {
                true => Beyond::Extrapolate,
                false => Beyond::Refuse,
            },
        }
    }
}

/// The gain of the paper's (57).
const PAPERS_GAIN: &str = "paper's K_p";

/// Columns that a narrow screen does without, first those that fewest people miss.
const DISPENSABLE: [&str; 10] = [
    PAPERS_GAIN,
    "frequency",
    "damping",
    "delay margin",
    "Nomoto K",
    "Nomoto T",
    "gain margin",
    "b2",
    "a22",
    "phase margin",
];

fn text(document: &HeadingGains, written: Option<&Path>, width: usize) -> String {
    let (rudder_scale, rudder) = document.rudder_unit.for_people();
    let mut notes: Vec<String> = document
        .points
        .iter()
        .filter_map(|p| p.refused.as_ref())
        .map(|reason| format!("No gain: {reason}."))
        .collect();
    notes.extend(document.unsure());
    if let Some(at) = &document.at {
        notes.push(at_text(at, document.rudder_unit));
    }
    if let Some(file) = written {
        notes.push(format!("Kept in {}.", file.display()));
    } else if document.rejected.is_empty() && document.points.iter().any(|p| p.refused.is_none()) {
        let rehearsal = match document.is_rehearsal {
            true => " --rehearsal",
            false => "",
        };
        notes.push(format!(
            "Next: the same command with --export FORMAT --out FILE{rehearsal} writes them for a controller; FORMAT is ardupilot, px4, ros2, json or c. `seatrial turn` prints how tightly the vehicle turns."
        ));
    }
    let text = format!(
        "{}{}Heading gains of {}, damping ratio {:.4}, rudder limit {:.1} {rudder}\n{}\
         K_p and margins with {:.3} s delay, {}\n\n{}\n{}",
        rejected_text(&document.rejected),
        document.first_answer.map_or(String::new(), |promised| promised.sentence() + "\n"),
        document.source,
        document.damping_ratio,
        document.rudder_limit_rad * rudder_scale,
        trial_line(document.trial.as_deref()),
        document.timing.delay_s,
        document.timing.sample_interval_s.map_or("continuous controller".into(), |h| format!(
            "sampled every {} s",
            three_figures(h)
        )),
        table(document).fitted(width, &DISPENSABLE),
        notes.join("\n")
    );
    wrapped(&text, width)
}

fn table(document: &HeadingGains) -> Table {
    let (rudder_scale, rudder) = document.rudder_unit.for_people();
    let per_angle = match document.rudder_unit {
        RudderUnit::Rad => "rad/rad",
        RudderUnit::FullRudder => "full/rad",
    };
    let mut table = Table::under(&format!(
        "thrust [%] | speed [m/s] | K_p [{per_angle}] | overshoot [% of a step] | feed-forward [{rudder}] | \
            a22 [1/s] | b2 [1/s^2] | Nomoto T [s] | Nomoto K [1/s] | {PAPERS_GAIN} [{per_angle}] | damping | \
            frequency [rad/s] | gain margin [factor] | phase margin [deg] | delay margin [s]"
    ));
    for point in &document.points {
        let overshoot = point.closed_loop.as_ref().and_then(|of| of.overshoot);
        let mut cells = vec![
            number(point.thrust.map(|thrust| 100.0 * thrust), 0),
            number(point.surge_speed_m_s, 2),
            estimate_cell(&point.proportional_gain, 3, 1.0),
            overshoot.map_or("-".into(), |overshoot| overshoot_text(&overshoot)),
            estimate_cell(&point.feed_forward_rudder_rad, 2, rudder_scale),
            format!("{:.3}", point.model.a22_per_s),
            format!("{:.3}", point.model.b2_per_s2),
            estimate_cell(&point.nomoto_t_s, 2, 1.0),
            estimate_cell(&point.nomoto_k_per_s, 2, 1.0),
            estimate_cell(&point.gain_of_57, 3, 1.0),
        ];
        cells.extend(loop_cells(&point.closed_loop));
        table.row(cells);
    }
    table
}

/// Per cent of a step to one decimal: a thousandth is none, and none is the least.
fn overshoot_text(overshoot: &Estimate) -> String {
    let text = |share: f64| format!("{:.1}", 100.0 * share.max(0.0));
    let value = text(overshoot.value);
    overshoot.interval_95.map_or(value.clone(), |bounds| {
        let [low, high] = bounds.map(text);
        format!("{value} ({low} to {high})")
    })
}

fn loop_cells(closed_loop: &Option<LoopFigures>) -> Vec<String> {
    let Some(figures) = closed_loop else {
        return vec!["-".into(); 5];
    };
    vec![
        estimate_cell(&figures.damping_ratio, 3, 1.0),
        estimate_cell(&figures.natural_frequency_rad_s, 2, 1.0),
        figures.gain_margin.map_or("infinite".into(), |margin| estimate_text(&margin, 1, 1.0)),
        estimate_cell(&figures.phase_margin_rad, 1, 1_f64.to_degrees()),
        estimate_cell(&figures.delay_margin_s, 2, 1.0),
    ]
}

fn at_text(at: &InterpolatedGain, rudder_unit: RudderUnit) -> String {
    let (rudder_scale, rudder) = rudder_unit.for_people();
    let place = match at.key {
        ScheduleKey::Thrust => format!("{:.0} % thrust", at.value * 100.0),
        ScheduleKey::Speed => format!("{:.2} m/s", at.value),
    };
    let how =
        if at.extrapolated { "EXTRAPOLATED beyond the identified range" } else { "interpolated" };
    let figures = at.closed_loop.as_ref().map_or(String::new(), |figures| {
        format!(
            ", damping {} and phase margin {} deg with the model interpolated between the same speeds",
            estimate_cell(&figures.damping_ratio, 3, 1.0),
            estimate_cell(&figures.phase_margin_rad, 1, 1_f64.to_degrees())
        )
    });
    format!(
        "At {place} ({how}): K_p {}, feed-forward {:.2} {rudder}{figures}.",
        estimate_text(&at.proportional_gain, 3, 1.0),
        at.feed_forward_rudder_rad * rudder_scale
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_overshoot_is_not_below_none() {
        let text = |value, interval_95| overshoot_text(&Estimate { value, interval_95 });
        assert_eq!(text(0.0152, Some([0.004, 0.025])), "1.5 (0.4 to 2.5)");
        assert_eq!(text(1e-6, Some([-4e-5, 4e-3])), "0.0 (0.0 to 0.4)");
        assert_eq!(text(0.02, None), "2.0");
    }
}

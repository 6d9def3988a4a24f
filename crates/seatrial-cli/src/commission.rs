//! `seatrial commission`: gains into an autopilot, proven by heading steps, kept or put back.

mod own;

use std::path::PathBuf;

use seatrial::gains::commission::Range;
use seatrial::words::three_figures;
use seatrial_app::load_plan;
use seatrial_app::models::{Models, of_document};
use seatrial_app::trials::campaign_models::{Purpose, chosen_campaign, of_campaign, undamaged};
use seatrial_app::trials::commission::{
    CommissionResult, Ending, GainsVehicle, Order, Proposal, Request, check_step, conduct,
    models_for,
};
use seatrial_app::trials::order::{Change, Preflight, plan_of_campaign};
use seatrial_app::trials::vehicles::Attendant;
use seatrial_core::{Axis, Plan};
use serde::Serialize;

use crate::autopilot::{AtTerminal, LinkArgs, check_line};
use crate::interrupt::interrupted;
use crate::output::{Exit, Failure, Output, say, say_laid_out};
use crate::screen::{command, labelled, width};
use crate::vehicle::autopilot;

/// Put the gains of a model into an autopilot, prove them by heading steps, keep them or put the old ones back.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
The boat steps with its old gains first: a model that does not tell what it does is refused before anything is written. Then \
the new gains are written and read back, tried by a small step and by full ones, and stay only if they do no worse than the \
old ones and than foreseen. However the command ends, unproven gains do not stay: the old ones are \
put back, or listed for `seatrial vehicle restore`.

Where the heading controller is ours, the constant gain of the slowest speed steps first at every speed of the campaign, and the \
gain of the speed after it.

Exit code 0: the new gains are proven and stay; 4: refused, or the old ones are back; 5: aborted and handed back; 6: something \
could not be put back.

Example, on a boat that `seatrial sim serve` plays in another terminal:
  seatrial plan --thrust 0.8 --out plan.toml
  seatrial trial --vehicle mavlink:udp:127.0.0.1:14550 \\
      --full-rudder-deg 14.9 --plan plan.toml
  seatrial commission --vehicle mavlink:udp:127.0.0.1:14550 \\
      --full-rudder-deg 14.9")]
pub struct Args {
    /// The vehicle: mavlink:udp:HOST:PORT, mavlink:udpout:HOST:PORT, mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD, whose
    /// autopilot steers; sim:starfish, sim:FILE.toml or ros2:FILE.toml, which our own heading controller steers.
    #[arg(long, value_name = "VEHICLE")]
    vehicle: String,
    /// Logbook with the vehicle's trial; what is changed is kept beside it until it is put back.
    #[arg(long, value_name = "FILE", default_value = "seatrial.db")]
    logbook: PathBuf,
    /// Number of the campaign, or name of a configuration [default: the last that finished with an accepted model].
    #[arg(long, value_name = "NUMBER", conflicts_with = "model")]
    campaign: Option<String>,
    /// Uses models of a rehearsal on a simulator as well.
    #[arg(long)]
    rehearsal: bool,
    /// Document of `seatrial identify --json` or `seatrial trial --json` in the place of a campaign.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Take the model identified nearest to this speed, m/s [default: the autopilot's own].
    #[arg(long, value_name = "M_S")]
    at_speed: Option<f64>,
    /// Size of the steps, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 30.0)]
    step_deg: f64,
    /// The plan whose envelope holds, a TOML file [default: the campaign's].
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Seed of a simulated vehicle.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Do not ask before the vehicle moves and its gains change.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    link: LinkArgs,
}

/// What `commission --json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    vehicle: String,
    source: String,
    surge_speed_m_s: Option<f64>,
    changes: Vec<Change>,
    #[serde(flatten)]
    found: CommissionResult,
    line: String,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let step_rad = args.step_deg.to_radians();
    check_step(step_rad)?;
    let request = Request {
        models: args.models()?,
        plan: args.plan()?,
        at_speed_m_s: args.at_speed,
        step_rad,
    };
    request.check()?;
    if !args.vehicle.starts_with("mavlink:") {
        return own::run(args, &request.models, &request.plan, output);
    }
    let stop = interrupted().map_err(Failure::internal)?;
    let vehicle = autopilot(&args.vehicle, &args.link, &args.logbook)?;
    let reached = vehicle.reach(&request.plan, &stop)?;
    shown(reached.preflight())?;
    let proposal = request.proposal(reached.as_ref())?;
    let changes = reached.changes(&proposal.settings);
    show(reached.preflight(), &proposal, &changes);
    if !args.yes && !AtTerminal.agrees()? {
        return Err(Failure::aborted("not agreed to; nothing was changed"));
    }
    let mut taken = reached.take()?;
    let order = Order { proposal: &proposal, envelope: request.plan.envelope, stop: &stop };
    let found = conduct(taken.as_mut(), &order, &mut |text| say(text));
    let document = Document {
        schema: "seatrial.commission.v1",
        vehicle: args.vehicle.clone(),
        source: request.models.origin,
        surge_speed_m_s: proposal.model.surge_speed_m_s,
        changes,
        line: found.line(),
        found,
    };
    output.print(&document, || {
        let width = width();
        let undo = document.found.undo().map(|undo| command("Undo   ", undo, width));
        let advice = document.found.advice();
        labelled("", &document.found.summary(), width)
            + &advice.map_or(String::new(), |advice| labelled("Do     ", advice, width))
            + &undo.unwrap_or_default()
    })?;
    Ok(exit(&document.found))
}

/// Says each check, and refuses where one has not passed.
fn shown(preflight: &Preflight) -> Result<(), Failure> {
    let checks = || preflight.checks.iter();
    checks().for_each(|check| {
        say_laid_out(&check_line(check.passed, &check.name, &check.text));
    });
    let failed: Vec<&str> =
        checks().filter(|check| !check.passed).map(|check| check.name.as_str()).collect();
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::aborted(format!(
            "nothing was changed; what stands in the way: {}",
            failed.join(", ")
        ))),
    }
}

impl Args {
    fn models(&self) -> Result<Models, Failure> {
        let models = match &self.model {
            Some(path) => of_document(path, None)?,
            None => of_campaign(&self.logbook, self.campaign.as_deref())?,
        };
        // A simulator may have what a rehearsal found.
        let is_rehearsal_asked = self.rehearsal || self.vehicle.starts_with("sim:");
        Ok(models_for(models, is_rehearsal_asked, Some(self.link.full_rudder()?))?)
    }

    /// The plan of the file, else the one of the campaign.
    fn plan(&self) -> Result<Plan<f64>, Failure> {
        if let Some(path) = &self.plan {
            return Ok(load_plan(Some(path), Some(Axis::Yaw))?.plan);
        }
        if self.model.is_some() {
            return Err(Failure::usage(
                "--model: the envelope within which the vehicle must stay is that of a plan, --plan FILE",
            ));
        }
        let logbook = undamaged(&self.logbook)?;
        let chosen = chosen_campaign(&logbook, self.campaign.as_deref(), Purpose::Models)?;
        let plan = plan_of_campaign(&chosen.entry).map_err(Failure::input)?;
        Ok(plan.checked().map_err(Failure::input)?.plan)
    }
}

/// A table of parameters, from what to what and why, broken where the screen ends.
fn changes_text(title: &str, changes: &[Change], width: usize) -> String {
    let rows = changes.iter().map(|change| {
        let [from, to] = [change.from, change.to].map(three_figures);
        [change.name.clone(), from, to, change.why.clone()]
    });
    let heading = ["parameter", "from", "to", title].map(str::to_owned);
    let rows: Vec<[String; 4]> = std::iter::once(heading).chain(rows).collect();
    let widest = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let [name, from, to] = [0, 1, 2].map(|column| widest(column).unwrap_or(0));
    let lines = rows.iter().map(|[parameter, old, new, why]| {
        labelled(&format!("{parameter:name$}  {old:>from$}  {new:>to$}  "), why, width)
    });
    lines.collect::<String>()
}

/// The autopilot's own parameters beside the proposed ones, and what both are foreseen to do.
fn show(preflight: &Preflight, proposal: &Proposal, changes: &[Change]) {
    say_laid_out(&changes_text("until the hand-back", &preflight.changes, width()));
    say_laid_out(&changes_text("proposed", changes, width()));
    for (name, foreseen) in [("old", &proposal.old_foreseen), ("new", &proposal.new_foreseen)] {
        let settling = &foreseen.settling_s;
        let settles = match foreseen.settled > 0.0 {
            true => format!("settled after {} s", range_text(settling, 1.0, 1)),
            false => format!("not settled after {:.1} s", settling.high),
        };
        say(format!(
            "foreseen with the {name} gains: overshoot {} %, {settles}, rudder {} %/s",
            range_text(&foreseen.overshoot, 100.0, 0),
            range_text(&foreseen.activity_per_s, 100.0, 0),
        ));
    }
    let water = proposal.model.surge_speed_m_s.zip(proposal.distance_m());
    say(format!(
        "it takes at most {:.0} s{}",
        proposal.duration_s(),
        water.map_or(String::new(), |(speed, distance)| {
            format!(" at {speed:.2} m/s: {distance:.0} m of water ahead")
        })
    ));
}

/// `2 to 4`, or `3` where both ends are printed alike.
fn range_text(range: &Range, scale: f64, decimals: usize) -> String {
    let [low, high] = [range.low, range.high].map(|end| format!("{:.decimals$}", scale * end));
    match low == high {
        true => low,
        false => format!("{low} to {high}"),
    }
}

fn exit(found: &CommissionResult) -> Exit {
    match found.ending {
        _ if found.not_put_back.is_some() => Exit::NotSaved,
        Ending::Kept { .. } => Exit::Done,
        Ending::PutBack { .. } | Ending::Refused => Exit::Rejected,
        Ending::Aborted { .. } => Exit::Aborted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_range_of_one_value_is_printed_once() {
        let range = |low, high| Range { middle: low, low, high };
        assert_eq!(range_text(&range(0.02, 0.04), 100.0, 0), "2 to 4");
        assert_eq!(range_text(&range(20.61, 20.64), 1.0, 1), "20.6");
    }

    #[test]
    fn exact_what_is_proposed_stands_in_a_table_that_fits() {
        let change = |name: &str, from: f64, to: f64| Change {
            name: name.into(),
            from,
            to,
            why: "turn rate for a heading error, as quick as the rudder allows".into(),
        };
        let changes =
            [change("ATC_STR_ANG_P", 2.0, 0.501956), change("ATC_STR_RAT_MAX", 120.0, 7.66484)];
        let text = changes_text("proposed", &changes, 60);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "parameter        from     to  proposed");
        let first = "ATC_STR_ANG_P    2.00  0.502  turn rate for a heading";
        assert!(lines[1].starts_with(first), "{text}");
        assert!(lines.iter().any(|line| line.starts_with("ATC_STR_RAT_MAX   120   7.66  turn")));
        assert!(lines.iter().all(|line| line.chars().count() <= 60), "{text}");
    }
}

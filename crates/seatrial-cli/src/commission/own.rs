//! A vehicle that our own heading controller steers: constant gain against scheduled gain.

use seatrial_app::models::Models;
use seatrial_app::trials::commission::{Ending, OwnLoop, OwnSpeed, propose_own};
use seatrial_app::trials::order::Terms;
use seatrial_core::Plan;
use serde::Serialize;

use super::Args;
use crate::interrupt::interrupted;
use crate::output::{Exit, Failure, Output, say};
use crate::vehicle::named;

/// What `commission --json` prints of such a vehicle.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    vehicle: String,
    source: String,
    speeds: Vec<OwnSpeed>,
    not_put_back: Option<String>,
    line: String,
}

/// Steps at every speed of the models.
pub fn run(
    args: &Args,
    models: &Models,
    plan: &Plan<f64>,
    output: &Output,
) -> Result<Exit, Failure> {
    let own = OwnLoop {
        step_rad: args.step_deg.to_radians(),
        rudder_limit_rad: plan.rudder_limit_rad,
        sample_interval_s: plan.sample_interval_s,
    };
    let proposals = propose_own(models, &own)?;
    let stop = interrupted().map_err(Failure::internal)?;
    let vehicle = named(&args.vehicle, None, &args.link, &args.logbook)?;
    let terms = Terms {
        plan,
        plan_is_given: true,
        seed: args.seed,
        is_agreed: args.yes || vehicle.is_simulated(),
        stop: &stop,
    };
    let mut taken = vehicle.take(&terms)?;
    let mut speeds = Vec::new();
    for proposal in &proposals {
        let name = format!("{:.0} % thrust", 100.0 * proposal.thrust);
        let mut say_named = |text: &str| say(format!("{name}: {text}"));
        let found = proposal.conduct(taken.as_mut(), &own, plan.envelope, &stop, &mut say_named);
        say_named(&speed_line(&found));
        let is_over = matches!(found.found.ending, Ending::Aborted { .. });
        speeds.push(found);
        if is_over {
            break;
        }
    }
    let not_put_back = taken.hand_back();
    let document = Document {
        schema: "seatrial.own_commission.v1",
        vehicle: args.vehicle.clone(),
        source: models.origin.clone(),
        line: line(&speeds, proposals.len(), not_put_back.as_deref()),
        speeds,
        not_put_back,
    };
    output.print(&document, || document.line.clone())?;
    Ok(exit(&document))
}

fn is_kept(speed: &OwnSpeed) -> bool {
    matches!(speed.found.ending, Ending::Kept { .. })
}

fn speed_line(speed: &OwnSpeed) -> String {
    format!(
        "constant gain {:.3}, scheduled {:.3}: {}",
        speed.constant.proportional_gain,
        speed.scheduled.proportional_gain,
        speed.found.line()
    )
}

/// Which gain to steer with at which speeds, in one line.
fn line(speeds: &[OwnSpeed], asked: usize, not_put_back: Option<&str>) -> String {
    let kept = speeds.iter().filter(|speed| is_kept(speed)).count();
    let others = speeds.iter().filter(|speed| !is_kept(speed));
    let others: Vec<String> = others
        .map(|speed| format!("{:.0} %: {}", 100.0 * speed.thrust, speed.found.line()))
        .collect();
    let line = match others.is_empty() {
        true => {
            format!("KEPT the scheduled gain at all {asked} speeds: `seatrial gains` writes it")
        }
        false => format!(
            "the scheduled gain is proven at {kept} of {asked} speeds; {}",
            others.join("; ")
        ),
    };
    match not_put_back {
        Some(what) => format!("{line}; {what}"),
        None => line,
    }
}

fn exit(document: &Document) -> Exit {
    let is_aborted = |speed: &OwnSpeed| matches!(speed.found.ending, Ending::Aborted { .. });
    match () {
        () if document.not_put_back.is_some() => Exit::NotSaved,
        () if document.speeds.iter().any(is_aborted) => Exit::Aborted,
        () if document.speeds.iter().all(is_kept) => Exit::Done,
        () => Exit::Rejected,
    }
}

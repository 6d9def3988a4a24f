//! `seatrial surge`: how the speed follows the thrust.

use std::path::PathBuf;

use seatrial::motions::surge::{Coefficient, SurgeEstimate};
use seatrial_app::trials::campaign_models::{Purpose, chosen_campaign, undamaged};

use crate::output::{Exit, Failure, Output, say};
use crate::screen::{width, wrapped};
use crate::table::{Table, number};

/// How the speed follows the thrust: each coefficient of a trial with its interval, or why the trial does not tell it.
#[derive(clap::Args)]
#[command(after_help = "\
u' = (w |w| - u |u|)/l - d r^2, w' = (s (p - p0) - w)/lag: docs/surge.md.

Exit code 4: the drag length, and so how fast the speed follows, is not identifiable.

Example:
  seatrial trial --vehicle sim:remus100 --seed 1
  seatrial surge --logbook seatrial.db")]
pub struct Args {
    /// The logbook that holds the trial.
    #[arg(long, default_value = "seatrial.db", value_name = "FILE")]
    logbook: PathBuf,
    /// Number of the campaign, or name of a configuration; without, the last that finished with an accepted model, else the last.
    #[arg(long, value_name = "CAMPAIGN")]
    campaign: Option<String>,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let logbook = undamaged(&args.logbook)?;
    let chosen = chosen_campaign(&logbook, args.campaign.as_deref(), Purpose::Record)?;
    chosen.passed_over.iter().for_each(say);
    let campaign = logbook.campaign(chosen.entry.id)?;
    let surge = SurgeEstimate::of(&campaign).ok_or_else(|| {
        Failure::input(format!(
            "{}, campaign {}: no surge: its records have no forward speed, or too few samples of it",
            args.logbook.display(),
            chosen.entry.id.0
        ))
    })?;
    output.print(&surge, || text(&surge))?;
    Ok(Exit::done_if(surge.drag_length_m.value.is_some()))
}

fn caution(surge: &SurgeEstimate) -> String {
    match surge.noise_is_white {
        true => String::new(),
        false => {
            wrapped(
                "Each reading of the speed depends on the one before (waves, a filter): the intervals are rather too wide.",
                width(),
            ) + "\n"
        }
    }
}

/// How long the speed takes from the slowest to the fastest thrust.
fn time_text(surge: &SurgeEstimate) -> Option<String> {
    let ends = surge.speeds.first().zip(surge.speeds.last());
    let (slowest, fastest) = ends.filter(|(slowest, fastest)| slowest.thrust < fastest.thrust)?;
    let [from, to] = [slowest, fastest].map(|at| at.surge_speed_m_s.value);
    let seconds = surge.time_to_63_percent_s(from?, to?)?;
    Some(format!(
        "63 % of the way from {:.0} to {:.0} % thrust takes {seconds:.2} s.\n",
        100.0 * slowest.thrust,
        100.0 * fastest.thrust
    ))
}

fn text(surge: &SurgeEstimate) -> String {
    let mut table = Table::under("coefficient | value | 95 % | unit");
    let mut missing = Vec::new();
    let mut row = |name: String, unit: &str, of: &Coefficient| {
        let interval =
            of.interval_95.map_or("-".to_owned(), |[low, high]| format!("{low:.3} to {high:.3}"));
        if of.value.is_none() {
            missing.push(format!("{name}: {}.", of.verdict));
        }
        table.row(vec![name, number(of.value, 3), interval, unit.into()]);
    };
    for speed in &surge.speeds {
        let name = format!("steady speed at {:.0} %", 100.0 * speed.thrust);
        row(name, "m/s", &speed.surge_speed_m_s);
    }
    for (name, unit, of) in [
        ("speed over thrust s", "m/s", &surge.speed_per_thrust_m_s),
        ("dead band p0", "", &surge.dead_band),
        ("drag length l", "m", &surge.drag_length_m),
        ("lag of the thrust", "s", &surge.thrust_lag_s),
        ("turning drag d", "m", &surge.turning_drag_m),
    ] {
        row(name.to_owned(), unit, of);
    }
    if surge.thrust_lag_s.value.is_none() {
        missing
            .push("`seatrial plan --surge --out plan.toml` plans the cheapest such step.".into());
    }
    let missing: Vec<String> = missing.iter().map(|line| wrapped(line, width()) + "\n").collect();
    format!(
        "{table}\n{}The fit leaves {:.4} m/s rms; the noise of the speed is {:.4} m/s.\n{}{}",
        time_text(surge).unwrap_or_default(),
        surge.rms_residual_m_s,
        surge.noise_m_s,
        caution(surge),
        missing.concat()
    )
}

//! `seatrial study commission`: commissions of many simulated boats, beside the defaults and QuickTune's rule.

use std::num::NonZeroUsize;

use seatrial::commission::study::Method;
use seatrial_app::studies::commission::{Class, Commissions, boats_of_all, commission_boats};
use seatrial_app::workers::Workers;

use crate::output::{Exit, Failure, Output};
use crate::progress;
use crate::table::Table;

/// Commissions of simulated boats in three classes, beside the autopilot's defaults and QuickTune's rule.
///
/// Each boat is of first order with a rudder that lags by up to 0.3 s and is up to 0.06 s late, under the heading controller of
/// ArduPilot's Rover; its trial errs by 4 % of a22 and of the rudder's effect. Steps of 30 degrees there and back.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial study commission --boats 3")]
pub struct Args {
    /// Boats of each class.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    boats: u64,
    /// The first seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Loops of the autopilot per second.
    #[arg(long, value_name = "HZ", default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..=1000))]
    loop_rate: u32,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
}

/// Commissions them.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let bar = progress::bar(boats_of_all(args.boats));
    let done = || bar.inc(1);
    let workers = Workers::new(args.threads, &done);
    let document = commission_boats(args.boats, args.seed, args.loop_rate, &workers);
    bar.finish_and_clear();
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

fn text(document: &Commissions) -> String {
    let mut table = Table::new(&[
        ("T", "s"),
        ("gains", ""),
        ("overshoot", "median %"),
        ("", "most %"),
        ("unsettled", "boats"),
        ("settled after", "median s"),
        ("later than defaults", "boats"),
        ("rudder", "median %/s"),
        ("", "most %/s"),
    ]);
    for class in &document.classes {
        for row in &class.methods {
            let name = match row.method {
                Method::Defaults => "defaults",
                Method::QuickTune => "QuickTune's rule",
                Method::Proposed => "proposed",
                Method::Commissioned => "commissioned",
            };
            let [low, high] = class.time_constant_s;
            table.row(vec![
                format!("{low} to {high}"),
                name.into(),
                format!("{:.1}", 100.0 * row.overshoot_median),
                format!("{:.1}", 100.0 * row.overshoot_most),
                row.unsettled.to_string(),
                row.settling_median_s
                    .map_or("-".into(), |s| format!("{s:.1}")),
                row.later_than_defaults.to_string(),
                format!("{:.0}", 100.0 * row.activity_median_per_s),
                format!("{:.0}", 100.0 * row.activity_most_per_s),
            ]);
        }
    }
    let count = |of: fn(&Class) -> u64| document.classes.iter().map(of).sum::<u64>();
    format!(
        "{} boats of each class, {} loops a second; kept {}, no gains proposed for {}\n\n{table}",
        document.boats,
        document.loop_rate_hz,
        count(|class| class.kept as u64),
        count(|class| class.refused),
    )
}

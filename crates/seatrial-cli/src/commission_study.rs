//! `seatrial study commission`: commissions of many simulated boats, beside the defaults and QuickTune's rule.

use std::num::NonZeroUsize;

use seatrial::commission::Response;
use seatrial::commission::study::{CLASSES_S, Commissioning, Method, commission_one};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::parallel;
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

/// `study commission --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    seed: u64,
    boats: u64,
    loop_rate_hz: u32,
    classes: Vec<Class>,
}

#[derive(Serialize)]
struct Class {
    time_constant_s: [f64; 2],
    /// Boats for which no gains were proposed.
    refused: u64,
    /// Boats whose proposed gains were kept.
    kept: usize,
    methods: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    method: Method,
    /// Fractions of the step.
    overshoot_median: f64,
    overshoot_most: f64,
    unsettled: usize,
    /// s; of those that settle.
    settling_median_s: Option<f64>,
    /// Boats that settle later than with the defaults.
    later_than_defaults: usize,
    /// Full deflections per second.
    activity_median_per_s: f64,
    activity_most_per_s: f64,
}

/// Commissions them.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let progress = parallel::progress(args.boats * CLASSES_S.len() as u64);
    let threads = parallel::threads(args.threads);
    let loop_interval_s = 1.0 / f64::from(args.loop_rate);
    let classes = CLASSES_S.iter().enumerate().map(|(number, class_s)| {
        let first = args.seed.wrapping_add(1_000_000 * number as u64);
        let boats = parallel::each(args.boats, threads, &progress, |boat| {
            commission_one(*class_s, first.wrapping_add(boat), loop_interval_s)
        });
        class(*class_s, args.boats, &boats)
    });
    let document = Document {
        schema: "seatrial.commission_study.v1",
        seed: args.seed,
        boats: args.boats,
        loop_rate_hz: args.loop_rate,
        classes: classes.collect(),
    };
    progress.finish_and_clear();
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

fn class(time_constant_s: [f64; 2], asked: u64, boats: &[Commissioning]) -> Class {
    Class {
        time_constant_s,
        refused: asked - boats.len() as u64,
        kept: boats.iter().filter(|boat| boat.is_kept).count(),
        methods: Method::ALL
            .iter()
            .enumerate()
            .map(|(number, method)| row(*method, number, boats))
            .collect(),
    }
}

fn row(method: Method, number: usize, boats: &[Commissioning]) -> Row {
    let of = |quantity: fn(&Response) -> f64| {
        let mut values: Vec<f64> = boats
            .iter()
            .map(|b| quantity(&b.responses[number]))
            .collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let middle = |values: &[f64]| values.get(values.len() / 2).copied();
    let most = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let (overshoot, activity) = (of(|r| r.overshoot), of(|r| r.activity_per_s));
    let settling = |boat: &Commissioning, number: usize| boat.responses[number].settling_s;
    let mut settled: Vec<f64> = boats.iter().filter_map(|b| settling(b, number)).collect();
    settled.sort_by(f64::total_cmp);
    let is_later = |boat: &&Commissioning| match (settling(boat, number), settling(boat, 0)) {
        (Some(found_s), Some(default_s)) => found_s > default_s,
        (None, found) => found.is_some(),
        (Some(_), None) => false,
    };
    Row {
        method,
        overshoot_median: middle(&overshoot).unwrap_or(f64::NAN),
        overshoot_most: most(&overshoot),
        unsettled: boats.len() - settled.len(),
        settling_median_s: middle(&settled),
        later_than_defaults: boats.iter().filter(is_later).count(),
        activity_median_per_s: middle(&activity).unwrap_or(f64::NAN),
        activity_most_per_s: most(&activity),
    }
}

fn text(document: &Document) -> String {
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

//! `seatrial study lies`: logs that lie or fall short, each kind many times.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use seatrial_app::studies::lies::{LyingLogStudy, LyingLogs, name};

use crate::output::{Exit, Failure, Output};
use crate::progress::RunsOf;

/// Logs that lie or fall short: is a wrong model ever accepted?
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Every log is a simulated voyage with one thing wrong, or nothing; even seeds are identified with windows, odd ones \
without. A model is wrong where a22 or b2 is beyond two half widths of its 95 % interval from the truth. Exit code 4 \
where a wrong model of a decidable log was accepted, or one of an undecidable log without a note.

Example:
  seatrial study lies --seeds 2 --kinds time_in_milliseconds --kinds sound_20_hz")]
pub struct Args {
    /// Logs of each kind.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Kinds, or the first letters of several; repeatable [default: all].
    #[arg(long, value_name = "KIND")]
    kinds: Vec<String>,
    #[command(flatten)]
    runs_of: RunsOf,
}

/// Runs the study.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let study = LyingLogStudy {
        seed: args.runs_of.seed,
        seeds: args.seeds,
        kinds: args.kinds.clone(),
    };
    let folder = std::env::temp_dir().join(format!("seatrial-lies-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|error| Failure::not_saved(error.to_string()))?;
    let document = args
        .runs_of
        .all(args.seeds * study.chosen()?.len() as u64, |workers| {
            study.run(&folder, workers)
        })?;
    // An empty folder that stays behind harms nobody.
    let _ = std::fs::remove_dir(&folder);
    output.print(&document, || text(&document))?;
    Ok(Exit::done_if(document.failed() == 0))
}

fn text(document: &LyingLogs) -> String {
    let mut text = String::new();
    let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
    for total in &document.totals {
        let _ = writeln!(
            text,
            "{:<12} {} logs: {} accepted ({:.1} %), {} of them wrong ({:.1} %)",
            name(total.decidability),
            total.logs,
            total.accepted,
            share(total.accepted, total.logs),
            total.wrong,
            share(total.wrong, total.logs)
        );
    }
    if let Some(wiring) = document.wiring {
        let _ = writeln!(
            text,
            "{:<12} {} logs: {} right, {} wrong, {} refused with the column named ({:.1} % right or named), another column blamed in {}",
            "wired wrong",
            wiring.logs,
            wiring.right,
            wiring.wrong,
            wiring.named,
            share(wiring.right + wiring.named, wiring.logs),
            wiring.accused
        );
    }
    let _ = writeln!(
        text,
        "\n{:<28} {:>8} {:>6} {:>8}  refused because; noted",
        "kind", "accepted", "wrong", "outside"
    );
    let list = |codes: &BTreeMap<String, usize>| {
        let codes: Vec<String> = codes
            .iter()
            .map(|(code, n)| format!("{code} {n}"))
            .collect();
        codes.join(", ")
    };
    for row in &document.kinds {
        let line = format!(
            "{:<28} {:>5}/{:<2} {:>6} {:>8}  {}; {}",
            row.kind,
            row.total.accepted,
            row.total.logs,
            row.total.wrong,
            row.outside,
            list(&row.refused),
            list(&row.noted)
        );
        let _ = writeln!(text, "{}", line.trim_end_matches([';', ' ']));
        for (code, seeds) in &row.accused {
            let _ = writeln!(text, "    another column blamed by {code}: seeds {seeds:?}");
        }
    }
    text
}

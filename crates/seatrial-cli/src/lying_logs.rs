//! `seatrial study lies`: logs that lie or fall short, each kind many times.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;

use seatrial_app::identify_log::{Options, Windows};
use seatrial_app::lying_log::{Ending, Truth};
use seatrial_sim::lies::{Decidability, KINDS, Kind, kind_of_name};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::parallel;

/// Logs that lie or fall short: is a wrong model ever accepted?
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Every log is a simulated voyage with one thing wrong, or nothing; even seeds are identified with windows, odd ones
without. A model is wrong where a22 or b2 is beyond two half widths of its 95 % interval from the truth. Exit code 4
where a wrong model of a decidable log was accepted, or one of an undecidable log without a note.

Example:
  seatrial study lies --seeds 2 --kinds time_in_milliseconds --kinds sound_20_hz")]
pub struct Args {
    /// Logs of each kind.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Kinds, or the first letters of several; repeatable [default: all].
    #[arg(long, value_name = "KIND")]
    kinds: Vec<String>,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
}

/// `study lies --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    seed: u64,
    seeds: u64,
    totals: Vec<Total>,
    kinds: Vec<Row>,
}

/// All kinds that are as decidable.
#[derive(Serialize)]
struct Total {
    decidability: &'static str,
    logs: usize,
    accepted: usize,
    wrong: usize,
    wrong_without_note: usize,
}

/// One kind.
#[derive(Serialize)]
struct Row {
    kind: &'static str,
    sentence: &'static str,
    decidability: &'static str,
    logs: usize,
    accepted: usize,
    /// Accepted and beyond two half widths of the truth.
    wrong: usize,
    /// Of these without a note on what the log cannot show.
    wrong_without_note: usize,
    /// Accepted models outside their 95 % intervals.
    outside: usize,
    refused: BTreeMap<String, usize>,
    noted: BTreeMap<String, usize>,
}

/// Notes on what a log cannot show.
const UNDECIDED: [&str; 2] = ["heading_unchecked", "rudder_unchecked"];

/// Runs the study.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let kinds = chosen(&args.kinds)?;
    let folder = std::env::temp_dir().join(format!("seatrial-lies-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|error| Failure::not_saved(error.to_string()))?;
    let runs = args.seeds * kinds.len() as u64;
    let progress = parallel::progress(runs);
    let endings = parallel::each(runs, parallel::threads(args.threads), &progress, |run| {
        let kind = kinds[(run / args.seeds) as usize];
        Some(ending(
            kind,
            args.seed.wrapping_add(run % args.seeds),
            &folder,
        ))
    });
    progress.finish_and_clear();
    let endings = endings
        .into_iter()
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| Failure::not_saved(error.to_string()))?;
    // An empty folder that stays behind harms nobody.
    let _ = std::fs::remove_dir(&folder);
    let rows: Vec<Row> = kinds
        .iter()
        .zip(endings.chunks(args.seeds as usize))
        .map(|(kind, endings)| Row::of(kind, endings))
        .collect();
    let document = Document {
        schema: "seatrial.lying_logs.v1",
        seed: args.seed,
        seeds: args.seeds,
        totals: totals(&rows),
        kinds: rows,
    };
    output.print(&document, || text(&document))?;
    let failed: usize = document.totals.iter().map(Total::failed).sum();
    Ok(if failed == 0 {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

fn chosen(names: &[String]) -> Result<Vec<&'static Kind>, Failure> {
    if let Some(unknown) = names.iter().find(|name| {
        !KINDS
            .iter()
            .any(|kind| kind.name.starts_with(name.as_str()))
    }) {
        let known: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
        return Err(Failure::usage(format!(
            "--kinds {unknown}: expected one of {}",
            known.join(", ")
        )));
    }
    let is_chosen = |kind: &&Kind| {
        names.is_empty()
            || names.iter().any(|name| match kind_of_name(name) {
                Some(named) => named.name == kind.name,
                None => kind.name.starts_with(name.as_str()),
            })
    };
    Ok(KINDS.iter().filter(is_chosen).collect())
}

fn ending(kind: &Kind, seed: u64, folder: &Path) -> std::io::Result<Ending> {
    let log = kind.log(seed);
    let path = folder.join(format!("{}_{seed}.csv", kind.name));
    std::fs::write(&path, &log.csv)?;
    let windows = if seed.is_multiple_of(2) {
        Windows {
            from_s: Some(log.training_s[0]),
            to_s: Some(log.training_s[1]),
            validate_from_s: Some(log.validation_s[0]),
            validate_to_s: Some(log.validation_s[1]),
            validate_on: None,
        }
    } else {
        Windows::default()
    };
    let options = Options {
        windows,
        ..Options::default()
    };
    let truth = Truth {
        a22_per_s: log.truth.a22_per_s,
        b2_per_s2: log.truth.b2_per_s2,
        full_rudder_rad: log.truth.full_rudder_rad,
    };
    let ending = Ending::of(&path, &options, &truth);
    std::fs::remove_file(&path)?;
    Ok(ending)
}

impl Row {
    fn of(kind: &'static Kind, endings: &[Ending]) -> Self {
        let count = |is: &dyn Fn(&Ending) -> bool| endings.iter().filter(|e| is(e)).count();
        let is_noted = |e: &Ending| {
            e.notes
                .iter()
                .any(|note| UNDECIDED.contains(&note.as_str()))
        };
        let mut refused = BTreeMap::new();
        let mut noted = BTreeMap::new();
        for ending in endings {
            if let Some(code) = &ending.refused {
                *refused.entry(code.clone()).or_insert(0) += 1;
            }
            for code in &ending.notes {
                *noted.entry(code.clone()).or_insert(0) += 1;
            }
        }
        Self {
            kind: kind.name,
            sentence: kind.sentence,
            decidability: name(kind.decidability),
            logs: endings.len(),
            accepted: count(&|e| e.accepted),
            wrong: count(&Ending::is_wrong),
            wrong_without_note: count(&|e| e.is_wrong() && !is_noted(e)),
            outside: count(&|e| e.farthest.is_some_and(|farthest| farthest > 1.0)),
            refused,
            noted,
        }
    }
}

impl Total {
    /// Logs that did not end as they must.
    fn failed(&self) -> usize {
        match self.decidability {
            "undecidable" => self.wrong_without_note,
            _ => self.wrong,
        }
    }
}

fn name(decidability: Decidability) -> &'static str {
    match decidability {
        Decidability::Sound => "sound",
        Decidability::Decidable => "decidable",
        Decidability::Undecidable => "undecidable",
    }
}

fn totals(rows: &[Row]) -> Vec<Total> {
    ["sound", "decidable", "undecidable"]
        .into_iter()
        .map(|decidability| {
            let sum = |of: fn(&Row) -> usize| {
                let rows = rows.iter().filter(|row| row.decidability == decidability);
                rows.map(of).sum()
            };
            Total {
                decidability,
                logs: sum(|row| row.logs),
                accepted: sum(|row| row.accepted),
                wrong: sum(|row| row.wrong),
                wrong_without_note: sum(|row| row.wrong_without_note),
            }
        })
        .filter(|total| total.logs > 0)
        .collect()
}

fn text(document: &Document) -> String {
    let mut text = String::new();
    let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
    for total in &document.totals {
        let _ = writeln!(
            text,
            "{:<12} {} logs: {} accepted ({:.1} %), {} of them wrong ({:.1} %)",
            total.decidability,
            total.logs,
            total.accepted,
            share(total.accepted, total.logs),
            total.wrong,
            share(total.wrong, total.logs)
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
            row.accepted,
            row.logs,
            row.wrong,
            row.outside,
            list(&row.refused),
            list(&row.noted)
        );
        let _ = writeln!(text, "{}", line.trim_end_matches([';', ' ']));
    }
    text
}

//! `seatrial study world`: whole trials as seeded worlds of vehicle, link, disk, clock and operator.

use std::fmt::Write as _;

use seatrial_app::studies::world::{Depth, Models, PARAMETERS, WorldStudy, Worlds};

use crate::output::{Exit, Failure, Output};
use crate::progress::RunsOf;
use crate::table::{Table, number};

/// Whole trials as seeded worlds: vehicle, link, disk, clock and operator, and a fault at any instant.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
A seed chooses the vehicle, its plan, up to two of its faults, when the operator, a killed process or lost power interrupts it, and how \
deep it is looked into: most worlds are a trial on a vehicle; one in 32 keeps a logbook whose files are taken at any \
instant, one in 32 goes through MAVLink on a bad link with pilots, forgers, failsafes, single messages that are thinned, lost or \
late, a stopped terminal and a hung disk, one in 256 through MAVLink whose outputs are thinned, lost or late and is judged whole, one in 128 \
is judged whole and replayed.

In every world: it ends, without a panic; the rudder is neutral within 0.5 s of what ends the trial (1 s where the \
link is cut); parameters are back or listed, and restore brings back the listed ones; every run that began has an end and \
no finished run is lost, whatever instant the process or the power goes; a22 and b2 of an accepted model are within three \
half widths of their 95 % intervals, and no more of all models are beyond two than chance explains; memory is bounded; played \
twice it is the same. Exit code 4 where one is not so.

Example:
  seatrial study world --seeds 200
  seatrial study world --depth outputs --seeds 200
  seatrial study world --seed 4711 --seeds 1 --json")]
pub struct Args {
    /// Worlds.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    seeds: u64,
    /// Only worlds of one depth: quick, kept, linked, outputs or whole [default: as each seed chooses].
    #[arg(long, value_name = "DEPTH", value_parser = depth)]
    depth: Option<Depth>,
    #[command(flatten)]
    runs_of: RunsOf,
}

fn name(depth: Depth) -> String {
    format!("{depth:?}").to_lowercase()
}

fn depth(text: &str) -> Result<Depth, String> {
    let found = Depth::ALL.into_iter().find(|depth| name(*depth) == text);
    found.ok_or_else(|| {
        let names = Depth::ALL.map(name).join(", ");
        format!("expected one of {names}")
    })
}

/// Plays the worlds.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let study = WorldStudy {
        seed: args.runs_of.seed,
        seeds: args.seeds,
        depth: args.depth,
    };
    let worlds = args.runs_of.all(args.seeds, |workers| study.run(workers));
    output.print(&worlds, || text(&worlds))?;
    Ok(Exit::done_if(
        worlds.broken == 0 && worlds.broken_together.is_empty(),
    ))
}

fn text(document: &Worlds) -> String {
    let mut text = format!(
        "{} worlds from seed {}: {} with a broken invariant\n\n",
        document.seeds, document.seed, document.broken
    );
    let mut table =
        Table::under("depth | worlds | runs | accepted | samples | neutral [s] | broken");
    for (depth, row) in &document.depths {
        table.row(vec![
            name(*depth),
            row.worlds.to_string(),
            row.runs.to_string(),
            row.runs_accepted.to_string(),
            row.samples.to_string(),
            number(row.neutral_after_s, 2),
            row.broken.to_string(),
        ]);
    }
    text += &table.to_string();
    let depths = document.depths.iter();
    for (depth, row) in depths.filter(|(_, row)| row.models.accepted > 0) {
        text.push_str(&models(*depth, &row.models));
    }
    let outcomes: Vec<String> = document
        .outcomes
        .iter()
        .map(|(outcome, count)| format!("{outcome} {count}"))
        .collect();
    let _ = writeln!(text, "\n{}", outcomes.join(", "));
    if let Some(bytes) = document.peak_memory_bytes {
        let _ = writeln!(text, "most memory: {:.0} MB", bytes as f64 / 1e6);
    }
    for broken in &document.broken_together {
        let _ = writeln!(text, "all worlds: {broken}");
    }
    for ending in &document.broken_worlds {
        for broken in &ending.broken {
            let _ = writeln!(
                text,
                "seatrial study world --seed {} --seeds 1: {broken}",
                ending.seed
            );
        }
    }
    text
}

/// Accepted models beside the truth.
fn models(depth: Depth, models: &Models) -> String {
    let mut table = Table::under(&format!(
        "{}, {} accepted models | beyond 1 half width | [%] | beyond 2 | farthest",
        name(depth),
        models.accepted
    ));
    for (k, name) in PARAMETERS.into_iter().enumerate() {
        let share = 100.0 * models.beyond_one[k] as f64 / models.accepted as f64;
        table.row(vec![
            name.into(),
            models.beyond_one[k].to_string(),
            format!("{share:.1}"),
            models.beyond_two[k].to_string(),
            format!("{:.2}", models.farthest[k]),
        ]);
    }
    format!("\n{table}")
}

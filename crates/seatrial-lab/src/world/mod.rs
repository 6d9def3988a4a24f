//! `seatrial-lab world`: whole trials as seeded worlds of vehicle, link, disk, clock and operator, with a fault at any instant.
//!
//! A seed chooses the vehicle, its plan, up to two of its faults, when the operator, a killed process or lost power interrupts it,
//! what is held up, and how much of the program takes part ([`Depth`]). Time is simulated; nothing waits. Held up are, on a vehicle behind
//! MAVLink: messages of one kind, which are thinned, lost or late one by one; the terminal, which is stopped; the logbook's disk, which
//! hangs to the end. Memory that is refused ends the process, as a kill does. In every world:
//!
//! 1. the trial ends, without a panic, and is handed back: neutral rudder, then heading hold, no thrust;
//! 2. the rudder is neutral within 0.5 s of what ends the trial; 1 s where the link is cut;
//! 3. parameters of an autopilot are back or listed, and `restore` brings back the listed ones;
//! 4. every run that began has an end, and no finished run is lost, whatever instant the process or the power goes;
//! 5. accepted models are where their 95 % intervals say, one by one and together ([`Models`]);
//! 6. a logbook is whole, and the trial replayed from it is the trial, bit for bit;
//! 7. memory is bounded: samples, datagrams under way, and the process;
//! 8. played twice, a world is the same.

mod drawn;
mod ending;
mod kept;
mod linked;
mod models;
mod outputs;
mod play;
mod stalled;
mod wire;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use seatrial_app::workers::Workers;
use seatrial_cli::output::Failure;
use seatrial_cli::table::{Table, number};
use serde::Serialize;

use crate::faults::PARAMETERS;
use crate::runner::{Found, Study, listed, named};
pub use drawn::Depth;
pub use ending::Ending;
pub use models::Models;
pub use play::play;

/// Most worlds with a broken invariant that are listed.
const MOST_LISTED: usize = 100;
/// Worlds between two summaries: memory does not grow with their number.
const AT_A_TIME: u64 = 4096;

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
  seatrial-lab world --seeds 200
  seatrial-lab world --depth outputs --seeds 200
  seatrial-lab world --seed 4711 --seeds 1 --json")]
pub struct WorldStudy {
    /// Worlds.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    seeds: u64,
    /// Only worlds of one depth: quick, kept, linked, outputs or whole [default: as each seed chooses].
    #[arg(long, value_name = "DEPTH", value_parser = named(&Depth::ALL, Depth::name))]
    depth: Option<Depth>,
}

/// `world --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Worlds {
    /// `seatrial.study_world.v1`
    pub schema: &'static str,
    /// The first seed.
    pub seed: u64,
    /// Worlds.
    pub seeds: u64,
    /// Worlds with a broken invariant.
    pub broken: u64,
    /// The worlds of each depth.
    pub depths: BTreeMap<Depth, Row>,
    /// How trials ended, and how often.
    pub outcomes: BTreeMap<String, u64>,
    /// The most memory that this process has had, bytes, where the system reports it.
    pub peak_memory_bytes: Option<u64>,
    /// What is wrong with the models of all worlds together.
    pub broken_together: Vec<String>,
    /// The first worlds with a broken invariant.
    pub broken_worlds: Vec<Ending>,
}

/// Worlds of one depth.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// Worlds.
    pub worlds: u64,
    /// Runs with a result.
    pub runs: u64,
    /// Accepted runs.
    pub runs_accepted: u64,
    /// Samples that vehicles gave.
    pub samples: u64,
    /// Longest from the condition of an abort to neutral rudder, s.
    pub neutral_after_s: Option<f64>,
    /// Accepted models beside the truth.
    pub models: Models,
    /// Worlds with a broken invariant.
    pub broken: u64,
}

fn larger(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    [one, other].into_iter().flatten().max_by(f64::total_cmp)
}

impl Worlds {
    fn take(&mut self, ending: Ending) {
        let row = self.depths.entry(ending.depth).or_default();
        row.worlds += 1;
        row.runs += ending.runs as u64;
        row.runs_accepted += ending.accepted as u64;
        row.samples += ending.samples;
        row.neutral_after_s = larger(row.neutral_after_s, ending.neutral_after_s);
        row.models.add(&ending.models);
        *self.outcomes.entry(ending.outcome.clone()).or_default() += 1;
        if !ending.broken.is_empty() {
            row.broken += 1;
            self.broken += 1;
            if self.broken_worlds.len() < MOST_LISTED {
                self.broken_worlds.push(ending);
            }
        }
    }
}

impl Study for WorldStudy {
    type Found = Worlds;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.seeds)
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<Worlds, Failure> {
        let mut worlds = Worlds {
            schema: "seatrial.study_world.v1",
            seed,
            seeds: self.seeds,
            broken: 0,
            depths: BTreeMap::new(),
            outcomes: BTreeMap::new(),
            peak_memory_bytes: None,
            broken_together: Vec::new(),
            broken_worlds: Vec::new(),
        };
        for begun in (0..self.seeds).step_by(AT_A_TIME as usize) {
            let count = AT_A_TIME.min(self.seeds - begun);
            let endings = workers
                .each(count, |world| Some(play(seed.wrapping_add(begun + world), self.depth)));
            endings.into_iter().for_each(|ending| worlds.take(ending));
        }
        let rows = worlds.depths.values();
        worlds.broken_together = rows.flat_map(|row| row.models.broken()).collect();
        worlds.peak_memory_bytes = peak_memory_bytes();
        Ok(worlds)
    }
}

fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

impl Found for Worlds {
    fn text(&self) -> String {
        let mut text = format!(
            "{} worlds from seed {}: {} with a broken invariant\n\n",
            self.seeds, self.seed, self.broken
        );
        let mut table =
            Table::under("depth | worlds | runs | accepted | samples | neutral [s] | broken");
        for (depth, row) in &self.depths {
            table.row(vec![
                depth.name().into(),
                row.worlds.to_string(),
                row.runs.to_string(),
                row.runs_accepted.to_string(),
                row.samples.to_string(),
                number(row.neutral_after_s, 2),
                row.broken.to_string(),
            ]);
        }
        text += &table.to_string();
        let depths = self.depths.iter();
        for (depth, row) in depths.filter(|(_, row)| row.models.accepted > 0) {
            text.push_str(&models(*depth, &row.models));
        }
        let _ = writeln!(text, "\n{}", listed(&self.outcomes));
        if let Some(bytes) = self.peak_memory_bytes {
            let _ = writeln!(text, "most memory: {:.0} MB", bytes as f64 / 1e6);
        }
        for broken in &self.broken_together {
            let _ = writeln!(text, "all worlds: {broken}");
        }
        for ending in &self.broken_worlds {
            for broken in &ending.broken {
                let _ =
                    writeln!(text, "seatrial-lab world --seed {} --seeds 1: {broken}", ending.seed);
            }
        }
        text
    }

    fn is_good(&self) -> bool {
        self.broken == 0 && self.broken_together.is_empty()
    }
}

/// Accepted models beside the truth.
fn models(depth: Depth, models: &Models) -> String {
    let mut table = Table::under(&format!(
        "{}, {} accepted models | beyond 1 half width | [%] | beyond 2 | farthest",
        depth.name(),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Worlds that once broke an invariant, and what was wrong.
    const ONCE_BROKEN: [(u64, &str); 10] = [
        (684, "a stranger says in the vehicle's name that a submarine is a disarmed boat"),
        (1703, "a stranger says in the vehicle's name that a submarine is a disarmed boat"),
        (21438, "the link was lost between the operator's abort and the next sample"),
        (31326, "no depth came while the samples' clock stood still"),
        (55373, "the battery fell low while the autopilot was left alone to prove that it lets go"),
        (94728, "a stick moved while the autopilot was left alone to prove that it lets go"),
        (161037, "a damaged message took the next five releases with it"),
        (233612, "a PX4 vehicle's stick was taken for a channel that MANUAL_CONTROL fills"),
        (
            449709,
            "the report of a moved stick came at the very instant of the first demand, the link was lost later",
        ),
        (807406, "the report of a moved stick came at the very instant of the first demand"),
    ];

    /// Of every depth some; the study of a million has its result in `validation/`.
    #[test]
    fn prop_no_world_breaks_an_invariant() {
        let mut worlds: BTreeMap<Depth, u32> = BTreeMap::new();
        for seed in (1..=400).chain(ONCE_BROKEN.map(|(seed, _)| seed)) {
            let ending = play(seed, None);
            assert_eq!(ending.broken, [""; 0], "seatrial-lab world --seed {seed} --seeds 1");
            *worlds.entry(ending.depth).or_default() += 1;
        }
        assert_eq!(worlds.len(), Depth::ALL.len(), "{worlds:?}");
    }
}

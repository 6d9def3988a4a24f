//! `seatrial-lab lies`: logs that lie or fall short, each kind many times. Is a wrong model accepted?

mod ending;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use seatrial::identification::{ReasonCode, ReasonKind};
use seatrial_app::Error;
use seatrial_app::identify_log::{Options, Windows};
use seatrial_app::workers::Workers;
use seatrial_cli::output::Failure;
use serde::Serialize;

use crate::lies::{Decidability, KINDS, Kind, kind_of_name};
use crate::runner::{Found, Study, counted, listed};
use ending::Ending;

/// Logs that lie or fall short: is a wrong model ever accepted?
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Every log is a simulated voyage with one thing wrong, or nothing; even seeds are identified with windows, odd ones \
without. A model is wrong where a22 or b2 is beyond two half widths of its 95 % interval from the truth. Exit code 4 \
where a wrong model of a decidable log was accepted, or one of an undecidable log without a note.

Example:
  seatrial-lab lies --seeds 2 --kinds time_in_milliseconds --kinds sound_20_hz")]
pub struct LyingLogStudy {
    /// Logs of each kind.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Kinds, or the first letters of several; repeatable [default: all].
    #[arg(long, value_name = "KIND")]
    kinds: Vec<String>,
}

/// `lies --json`.
#[derive(Clone, Debug, Serialize)]
pub struct LyingLogs {
    /// `seatrial.lying_logs.v1`
    pub schema: &'static str,
    /// The first seed.
    pub seed: u64,
    /// Logs of each kind.
    pub seeds: u64,
    /// All kinds that are as decidable.
    pub totals: Vec<Total>,
    /// Kinds of logs with a column that is wired wrongly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wiring: Option<Wiring>,
    /// Each kind.
    pub kinds: Vec<Row>,
}

/// The logs of a kind, or of all kinds that are as decidable.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Total {
    /// Can the log itself show what is wrong with it?
    pub decidability: Decidability,
    /// Logs.
    pub logs: usize,
    /// Logs with an accepted model.
    pub accepted: usize,
    /// Accepted and beyond two half widths of the truth.
    pub wrong: usize,
    /// Wrong without a note on what the log cannot show.
    pub wrong_without_note: usize,
}

/// What became of logs with a column that is wired wrongly.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Wiring {
    /// Logs.
    pub logs: usize,
    /// Accepted and right.
    pub right: usize,
    /// Accepted and beyond two half widths of the truth.
    pub wrong: usize,
    /// Refused, with the column that is wrong among those that the first reason blames.
    pub named: usize,
    /// Another column is blamed, and not the one that is wrong.
    pub accused: usize,
}

/// One kind.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Its name.
    pub kind: &'static str,
    /// What is wrong with its logs.
    pub sentence: &'static str,
    /// How often its logs were accepted, and rightly.
    #[serde(flatten)]
    pub total: Total,
    /// Accepted models outside their 95 % intervals.
    pub outside: usize,
    /// Where its logs are wired wrongly, what became of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wiring: Option<Wiring>,
    /// Reasons of refusals, each with how often.
    pub refused: BTreeMap<String, usize>,
    /// Notes on accepted models, each with how often.
    pub noted: BTreeMap<String, usize>,
    /// What blames another column than the one that is wrong, each with the seeds of its logs.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub accused: BTreeMap<String, Vec<u64>>,
}

/// From logs without a fault to those whose fault no log can show.
const DECIDABILITIES: [Decidability; 3] =
    [Decidability::Sound, Decidability::Decidable, Decidability::Undecidable];

impl LyingLogStudy {
    /// The kinds that are asked for.
    fn chosen(&self) -> Result<Vec<&'static Kind>, Error> {
        let is_known = |name: &str| KINDS.iter().any(|kind| kind.name.starts_with(name));
        if let Some(unknown) = self.kinds.iter().find(|name| !is_known(name)) {
            let known: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
            return Err(Error::Setting(format!(
                "--kinds {unknown}: expected one of {}",
                known.join(", ")
            )));
        }
        let is_chosen = |kind: &&Kind| {
            self.kinds.is_empty()
                || self.kinds.iter().any(|name| match kind_of_name(name) {
                    Some(named) => named.name == kind.name,
                    None => kind.name.starts_with(name.as_str()),
                })
        };
        Ok(KINDS.iter().filter(is_chosen).collect())
    }
}

impl Study for LyingLogStudy {
    type Found = LyingLogs;

    fn runs(&self) -> Result<u64, Failure> {
        Ok(self.seeds * self.chosen()?.len() as u64)
    }

    /// Writes the logs to a folder, one after the other, and identifies them.
    fn run(&self, seed: u64, workers: &Workers) -> Result<LyingLogs, Failure> {
        let kinds = self.chosen()?;
        let folder = tempfile::Builder::new().prefix("seatrial-lies-").tempdir();
        let folder = folder.map_err(Failure::not_saved)?;
        let folder = folder.path();
        let endings = workers.each(self.runs()?, |run| {
            let kind = kinds[(run / self.seeds) as usize];
            Some(ending(kind, seed.wrapping_add(run % self.seeds), folder))
        });
        let endings = endings
            .into_iter()
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| Failure::input(format!("{}: {error}", folder.display())))?;
        let rows: Vec<Row> = kinds
            .iter()
            .zip(endings.chunks(self.seeds as usize))
            .map(|(kind, endings)| Row::of(kind, endings, seed))
            .collect();
        Ok(LyingLogs {
            schema: "seatrial.lying_logs.v1",
            seed,
            seeds: self.seeds,
            totals: totals(&rows),
            wiring: rows.iter().filter_map(|row| row.wiring).reduce(Wiring::with),
            kinds: rows,
        })
    }
}

/// Writes and identifies one log.
fn ending(kind: &Kind, seed: u64, folder: &Path) -> std::io::Result<Ending> {
    let log = kind.log(seed);
    let path = folder.join(format!("{}_{seed}.csv", kind.name));
    std::fs::write(&path, &log.csv)?;
    // Windows are in seconds, and those of a clock in another unit are not.
    let windows = if seed.is_multiple_of(2) && kind.wired != Some("time") {
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
    let mut options = Options::default();
    options.windows = windows;
    let ending = Ending::of(&path, &options, &log.truth);
    std::fs::remove_file(&path)?;
    Ok(ending)
}

impl Row {
    fn of(kind: &'static Kind, endings: &[Ending], first_seed: u64) -> Self {
        let count = |is: &dyn Fn(&Ending) -> bool| endings.iter().filter(|e| is(e)).count();
        // What a log cannot show.
        let is_note = |kind: &ReasonKind| kind.code == ReasonCode::Unchecked;
        let is_noted = |e: &Ending| e.notes.iter().any(is_note);
        let refused = endings.iter().filter_map(|e| e.refused.clone());
        let noted = endings.iter().flat_map(|e| &e.notes);
        let mut accused = BTreeMap::<String, Vec<u64>>::new();
        for (ending, run) in endings.iter().zip(0..) {
            let beside = |column| ending.accusation_beside(column);
            if let Some(code) = kind.wired.and_then(beside) {
                let seeds = accused.entry(code.to_owned()).or_default();
                seeds.push(first_seed.wrapping_add(run));
            }
        }
        Self {
            kind: kind.name,
            sentence: kind.sentence,
            total: Total {
                decidability: kind.decidability,
                logs: endings.len(),
                accepted: count(&|e| e.accepted),
                wrong: count(&Ending::is_wrong),
                wrong_without_note: count(&|e| e.is_wrong() && !is_noted(e)),
            },
            wiring: kind.wired.map(|column| Wiring::of(column, endings)),
            outside: count(&|e| e.farthest.is_some_and(|farthest| farthest > 1.0)),
            refused: counted(refused),
            noted: counted(noted.map(ReasonKind::to_string)),
            accused,
        }
    }
}

impl Wiring {
    fn of(column: &'static str, endings: &[Ending]) -> Self {
        let count = |is: &dyn Fn(&Ending) -> bool| endings.iter().filter(|e| is(e)).count();
        Self {
            logs: endings.len(),
            right: count(&|e| e.accepted && !e.is_wrong()),
            wrong: count(&|e| e.accepted && e.is_wrong()),
            named: count(&|e| !e.accepted && e.names(column)),
            accused: count(&|e| e.accusation_beside(column).is_some()),
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            logs: self.logs + other.logs,
            right: self.right + other.right,
            wrong: self.wrong + other.wrong,
            named: self.named + other.named,
            accused: self.accused + other.accused,
        }
    }
}

impl Total {
    fn with(self, other: Self) -> Self {
        Self {
            decidability: self.decidability,
            logs: self.logs + other.logs,
            accepted: self.accepted + other.accepted,
            wrong: self.wrong + other.wrong,
            wrong_without_note: self.wrong_without_note + other.wrong_without_note,
        }
    }

    /// Logs that did not end as they must.
    fn failed(&self) -> usize {
        match self.decidability {
            Decidability::Undecidable => self.wrong_without_note,
            Decidability::Sound | Decidability::Decidable => self.wrong,
        }
    }
}

fn totals(rows: &[Row]) -> Vec<Total> {
    let total = |decidability| {
        let totals = rows.iter().map(|row| row.total);
        let alike = totals.filter(|total| total.decidability == decidability);
        alike.reduce(Total::with)
    };
    DECIDABILITIES.into_iter().filter_map(total).collect()
}

impl Found for LyingLogs {
    fn text(&self) -> String {
        let mut text = String::new();
        let share = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
        for total in &self.totals {
            let _ = writeln!(
                text,
                "{:<12} {} logs: {} accepted ({:.1} %), {} of them wrong ({:.1} %)",
                total.decidability.name(),
                total.logs,
                total.accepted,
                share(total.accepted, total.logs),
                total.wrong,
                share(total.wrong, total.logs)
            );
        }
        if let Some(wiring) = self.wiring {
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
        for row in &self.kinds {
            let line = format!(
                "{:<28} {:>5}/{:<2} {:>6} {:>8}  {}; {}",
                row.kind,
                row.total.accepted,
                row.total.logs,
                row.total.wrong,
                row.outside,
                listed(&row.refused),
                listed(&row.noted)
            );
            let _ = writeln!(text, "{}", line.trim_end_matches([';', ' ']));
            for (code, seeds) in &row.accused {
                let _ = writeln!(text, "    another column blamed by {code}: seeds {seeds:?}");
            }
        }
        text
    }

    fn is_good(&self) -> bool {
        self.totals.iter().map(Total::failed).sum::<usize>() == 0
    }
}

//! How every study runs: many runs on all cores behind a bar, then one document as text or JSON.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::num::NonZeroUsize;

use seatrial_app::workers::Workers;
use seatrial_cli::output::{Exit, Failure, Output};
use seatrial_cli::progress::of_runs;
use serde::Serialize;

/// The options of a study, then those that every study has.
#[derive(clap::Args, Debug)]
pub struct Args<S: clap::Args> {
    /// What is studied.
    #[command(flatten)]
    pub study: S,
    /// Seed of the first run; the same seed gives the same study.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
}

/// A study of many runs, as its options describe it.
pub trait Study {
    /// What the runs give together.
    type Found: Found;

    /// How many runs there will be.
    fn runs(&self) -> Result<u64, Failure>;

    /// Makes the runs from a seed on. An error where the options ask for what cannot be studied, or where no run gave anything.
    fn run(&self, seed: u64, workers: &Workers) -> Result<Self::Found, Failure>;

    /// Writes the files that the options ask for.
    fn save(&self, _: &Self::Found, _: &Output) -> Result<(), Failure> {
        Ok(())
    }
}

/// What a study found, as `--json` prints it.
pub trait Found: Serialize {
    /// The document for a person to read.
    fn text(&self) -> String;

    /// Is everything as it must be? Otherwise the program ends with exit code 4.
    fn is_good(&self) -> bool {
        true
    }
}

impl<S: Study + clap::Args> Args<S> {
    /// Runs the study, writes its files and prints what it found.
    pub fn conduct(&self, output: &Output) -> Result<Exit, Failure> {
        let bar = of_runs(self.study.runs()?);
        let step = || bar.step();
        let found = self.study.run(self.seed, &Workers::new(self.threads, &step));
        bar.clear();
        let found = found?;
        self.study.save(&found, output)?;
        output.print(&found, || found.text())?;
        Ok(Exit::done_if(found.is_good()))
    }
}

/// Takes one of these by its name.
pub fn named<T: Copy>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |word| {
        let found = all.iter().find(|one| name(**one) == word);
        found.copied().ok_or_else(|| {
            let names: Vec<_> = all.iter().map(|one| name(*one)).collect();
            format!("expected one of {}", names.join(", "))
        })
    }
}

/// How often there is each.
pub fn counted(words: impl IntoIterator<Item = String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for word in words {
        *counts.entry(word).or_insert(0) += 1;
    }
    counts
}

/// Each with its count: `stale_samples 3, low_r2 1`.
pub fn listed<N: Display>(counts: &BTreeMap<String, N>) -> String {
    let listed = counts.iter().map(|(word, count)| format!("{word} {count}"));
    listed.collect::<Vec<_>>().join(", ")
}

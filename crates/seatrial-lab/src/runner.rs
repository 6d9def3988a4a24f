//! How every study runs: many runs on all cores behind a bar, then one document as text or JSON.

use std::num::NonZeroUsize;

use seatrial_app::workers::Workers;
use seatrial_cli::output::{Exit, Failure, Output};
use seatrial_cli::progress::of_runs;
use serde::Serialize;

/// The options of every study.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct RunsOf {
    /// Seed of the first run; the same seed gives the same study.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<NonZeroUsize>,
}

/// A study of many runs, as its options describe it.
pub trait Study {
    /// What the runs give together; `--json` prints it.
    type Found: Serialize;

    /// Seed and threads.
    fn runs_of(&self) -> RunsOf;

    /// How many runs there will be.
    fn runs(&self) -> Result<u64, Failure>;

    /// Makes the runs. An error where the options ask for what cannot be studied, or where no run gave anything.
    fn run(&self, workers: &Workers) -> Result<Self::Found, Failure>;

    /// The document for a person to read.
    fn text(found: &Self::Found) -> String;

    /// Writes the files that the options ask for.
    fn save(&self, _: &Self::Found, _: &Output) -> Result<(), Failure> {
        Ok(())
    }

    /// Is everything as it must be? Otherwise the program ends with exit code 4.
    fn is_good(_: &Self::Found) -> bool {
        true
    }
}

/// Runs a study, writes its files and prints what it found.
pub fn conduct<S: Study>(study: &S, output: &Output) -> Result<Exit, Failure> {
    let bar = of_runs(study.runs()?);
    let found = study.run(&Workers::new(study.runs_of().threads, &|| bar.step()));
    bar.clear();
    let found = found?;
    study.save(&found, output)?;
    output.print(&found, || S::text(&found))?;
    Ok(Exit::done_if(S::is_good(&found)))
}

//! The `seatrial-lab` command: one verb per study.

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use seatrial_cli::output::{Exit, Failure, Output, checked, ended, leave};
use seatrial_cli::screen;
use seatrial_lab::commission::{self, CommissionStudy};
use seatrial_lab::estimators::Estimators;
use seatrial_lab::faults::FaultStudy;
use seatrial_lab::field::FieldStudy;
use seatrial_lab::lying_logs::LyingLogStudy;
use seatrial_lab::manoeuvres::ManoeuvreStudy;
use seatrial_lab::runner::Args;
use seatrial_lab::surge::SurgeStudy;
use seatrial_lab::world::WorldStudy;

/// Studies of seatrial on simulated vehicles and logs, whose truth is known.
#[derive(Parser)]
#[command(name = "seatrial-lab", version, arg_required_else_help = true)]
struct Cli {
    /// Print one JSON document on standard output and nothing else there.
    #[arg(long, global = true, display_order = 900)]
    json: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Estimators(Args<Estimators>),
    Faults(Args<FaultStudy>),
    Lies(Args<LyingLogStudy>),
    Commission(Args<CommissionStudy>),
    Manoeuvres(Args<ManoeuvreStudy>),
    Surge(Args<SurgeStudy>),
    World(Args<WorldStudy>),
    Field(Args<FieldStudy>),
}

impl Verb {
    fn run(&self, output: &Output) -> Result<Exit, Failure> {
        match self {
            Self::Estimators(args) => args.conduct(output),
            Self::Faults(args) => args.conduct(output),
            Self::Lies(args) => args.conduct(output),
            Self::Commission(args) => commission::run(args, output),
            Self::Manoeuvres(args) => args.conduct(output),
            Self::Surge(args) => args.conduct(output),
            Self::World(args) => args.conduct(output),
            Self::Field(args) => args.conduct(output),
        }
    }
}

fn main() -> ExitCode {
    let matches = Cli::command().term_width(screen::width()).try_get_matches();
    let matches = matches.unwrap_or_else(|error| leave(&error));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| leave(&error));
    let ran = checked(&Cli::command(), &matches)
        .and_then(|files| cli.verb.run(&Output::new(cli.json, files)));
    ended(ran)
}

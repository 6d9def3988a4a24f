//! The `seatrial` command: one file per verb.

mod ardupilot_json;
mod autopilot;
mod choice;
mod commission;
mod compare;
mod completions;
mod damage;
mod demo;
mod doctor;
mod export;
#[cfg_attr(not(feature = "parquet"), path = "no_fleet.rs")]
mod fleet;
mod gains;
mod health;
mod help;
mod identify;
mod inspect;
#[cfg_attr(not(feature = "live-view"), expect(dead_code))]
mod live;
mod log;
mod logbook;
mod mcp;
mod model_source;
mod model_text;
mod old_spellings;
mod paper;
mod plan;
mod prior;
mod record;
mod replay;
mod report;
mod serve;
mod ship_manoeuvres;
mod sim;
mod sim_mavlink;
mod speed_table;
mod speeds;
mod surge;
mod track;
mod trial;
mod turn;
mod turn_rates;
mod validate;
mod vehicle;
mod vehicle_check;
mod windows;

use std::process::ExitCode;

use clap::{ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};

use seatrial_cli::{interrupt, output, progress, screen, standard_error, table};

use output::{Exit, Failure, Output, checked, ended};

/// Identify how a marine vehicle steers, at sea, in one compact manoeuvre per speed.
#[derive(Parser)]
#[command(name = "seatrial", version, arg_required_else_help = true)]
struct Cli {
    /// Print one JSON document on standard output and nothing else there.
    #[arg(long, global = true, display_order = 900)]
    json: bool,
    /// Print help with every verb and every option.
    #[arg(long, global = true, display_order = 901, action = ArgAction::HelpLong)]
    help_all: Option<bool>,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Trial(Box<trial::Args>),
    Commission(Box<commission::Args>),
    Plan(Box<plan::Args>),
    Inspect(inspect::Args),
    Sim(sim::Args),
    Identify(identify::Args),
    Validate(validate::Args),
    Compare(compare::Args),
    Logbook(logbook::Args),
    Turn(turn::Args),
    Gains(gains::Args),
    Export(Box<export::Args>),
    Surge(surge::Args),
    Manoeuvres(Box<ship_manoeuvres::Args>),
    Health(health::Args),
    Fleet(fleet::Args),
    Paper(paper::Args),
    Report(report::Args),
    Serve(Box<serve::Args>),
    Mcp(mcp::Args),
    Replay(replay::Args),
    Vehicle(vehicle_check::Args),
    Demo(demo::Args),
    Doctor(doctor::Args),
    Completions(completions::Args),
}

impl Verb {
    fn run(&self, output: &Output) -> Result<Exit, Failure> {
        match self {
            Self::Trial(args) => trial::run(args, output),
            Self::Commission(args) => commission::run(args, output),
            Self::Plan(args) => plan::run(args, output),
            Self::Inspect(args) => inspect::run(args, output),
            Self::Sim(args) => sim::run(args, output),
            Self::Identify(args) => identify::run(args, output),
            Self::Validate(args) => validate::run(args, output),
            Self::Compare(args) => compare::run(args, output),
            Self::Logbook(args) => logbook::run(args, output),
            Self::Turn(args) => turn::run(args, output),
            Self::Gains(args) => gains::run(args, output),
            Self::Export(args) => export::run(args, output),
            Self::Surge(args) => surge::run(args, output),
            Self::Manoeuvres(args) => ship_manoeuvres::run(args, output),
            Self::Health(args) => health::run(args, output),
            Self::Fleet(args) => fleet::run(args, output),
            Self::Paper(args) => paper::run(args, output),
            Self::Report(args) => report::run(args, output),
            Self::Serve(args) => serve::run(args, output),
            Self::Mcp(args) => mcp::run(args, output),
            Self::Replay(args) => replay::run(args, output),
            Self::Vehicle(args) => vehicle_check::run(args, output),
            Self::Demo(args) => demo::run(args, output),
            Self::Doctor(args) => doctor::run(args, output),
            Self::Completions(args) => completions::run(args, Cli::command(), output),
        }
    }
}

fn main() -> ExitCode {
    let words = old_spellings::in_new_words(std::env::args_os().collect());
    if let Err(failure) = old_spellings::run_lab(&words) {
        return ended(Err(failure));
    }
    let is_all = help::is_all(&words);
    let command = help::with_help(Cli::command(), is_all, screen::width());
    let matches = command.try_get_matches_from(words);
    let matches = matches.unwrap_or_else(|error| output::leave(&error));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| output::leave(&error));
    let ran = checked(&Cli::command(), &matches)
        .and_then(|files| cli.verb.run(&Output::new(cli.json, files)));
    ended(ran)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Command;

    fn help_of(verb: &mut Command, helps: &mut Vec<(String, String)>) {
        for long in [true, false] {
            let help = match long {
                true => verb.render_long_help(),
                false => verb.render_help(),
            };
            helps.push((verb.get_name().to_owned(), help.to_string()));
        }
        for below in verb.get_subcommands_mut() {
            help_of(below, helps);
        }
    }

    #[test]
    fn cli_help_fits_80_columns() {
        let mut verbs = help::with_help(Cli::command(), true, 80);
        let mut help = Vec::new();
        help_of(&mut verbs, &mut help);
        assert!(help.len() > 50);
        for (verb, text) in help {
            let too_long: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
            assert_eq!(too_long, [""; 0], "{verb}");
        }
    }

    /// An option that follows a flattened group would stand under the heading of that group.
    #[test]
    fn exact_options_of_a_verb_stand_under_no_heading_of_a_group() {
        let verbs = Cli::command();
        for (verb, option) in [
            ("trial", "report"),
            ("trial", "yes"),
            ("trial", "seed"),
            ("identify", "axis"),
            ("identify", "verbose"),
            ("report", "out"),
        ] {
            let verb_found = verbs.find_subcommand(verb).expect("the verb");
            let found = verb_found
                .get_arguments()
                .find(|a| a.get_id() == option)
                .unwrap_or_else(|| panic!("{verb} --{option}"));
            assert_eq!(found.get_help_heading(), None, "{verb} --{option}");
        }
    }
}

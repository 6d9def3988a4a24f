//! What `--help` shows: ten verbs, and the options that most people need. `--help-all` shows the rest.

use std::ffi::OsStr;

use clap::Command;

use crate::screen::labelled;

/// The verbs of the first page, in the order of a day at sea.
pub const FIRST_VERBS: [&str; 10] = [
    "trial",
    "plan",
    "identify",
    "gains",
    "commission",
    "health",
    "report",
    "serve",
    "demo",
    "vehicle",
];

/// The other verbs, in groups.
const OTHER_VERBS: [(&str, &[&str]); 5] = [
    ("Logs", &["inspect", "validate", "compare", "fleet"]),
    ("Use of a model", &["turn", "surge", "export", "manoeuvres"]),
    ("Earlier trials", &["logbook", "replay"]),
    ("Simulators", &["sim", "paper"]),
    ("This machine", &["doctor", "completions", "mcp", "help"]),
];

/// The options that `--help` shows of the verbs that have most, besides `--json`, `--help` and `--help-all`.
const FIRST_OPTIONS: [(&str, &[&str]); 2] = [
    (
        "trial",
        &[
            "vehicle",
            "plan",
            "logbook",
            "report",
            "record",
            "seed",
            "realtime",
            "full_rudder_deg",
            "yes",
        ],
    ),
    (
        "plan",
        &[
            "plan",
            "time_constant",
            "sample_interval",
            "thrust",
            "amplitude_deg",
            "vehicle",
            "target",
            "compare",
            "out",
        ],
    ),
];

/// Columns before the names of verbs, and between a name and what the verb does.
const MARGIN: usize = 2;

/// Does the command line ask for all verbs and options?
pub fn is_all<Argument: AsRef<OsStr>>(arguments: impl IntoIterator<Item = Argument>) -> bool {
    let mut arguments = arguments.into_iter();
    arguments.any(|argument| argument.as_ref() == "--help-all")
}

/// The command with the help that is asked for, as wide as this.
pub fn with_help(command: Command, is_all: bool, width: usize) -> Command {
    let mut command = command.term_width(width);
    command.build();
    let verbs = match is_all {
        true => all_verbs(&command, width),
        false => format!("Commands:\n{}", verbs(&command, &FIRST_VERBS, width)),
    };
    let more = match is_all {
        true => String::new(),
        false => "\n\n".to_owned()
            + labelled(
                "",
                "`seatrial demo` shows a trial. `seatrial VERB --help` explains a verb. `seatrial --help-all` lists the other verbs.",
                width,
            )
            .trim_end(),
    };
    let page = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{verbs}\nOptions:\n{{options}}{more}"
    );
    let command = command.help_template(page);
    match is_all {
        true => command,
        false => FIRST_OPTIONS.iter().fold(command, with_first_options),
    }
}

fn with_first_options(command: Command, (verb, first): &(&'static str, &[&str])) -> Command {
    command.mut_subcommand(verb, |verb| {
        verb.mut_args(|option| {
            let is_first = first.contains(&option.get_id().as_str()) || option.is_global_set();
            let is_help = option.get_id() == "help";
            option.hide(!is_first && !is_help)
        })
    })
}

fn all_verbs(command: &Command, width: usize) -> String {
    let groups = std::iter::once(("Commands", &FIRST_VERBS[..])).chain(OTHER_VERBS);
    let groups = groups.map(|(name, names)| format!("{name}:\n{}", verbs(command, names, width)));
    groups.collect::<Vec<_>>().join("\n")
}

/// One entry for each verb: its name and what it does.
fn verbs(command: &Command, names: &[&str], width: usize) -> String {
    let longest = command.get_subcommands().map(|verb| verb.get_name().len());
    let longest = longest.max().unwrap_or(0);
    let known = names.iter().filter_map(|name| command.find_subcommand(name));
    let entry = |verb: &Command| {
        let about = verb.get_about().map(ToString::to_string);
        let name = format!("{:MARGIN$}{:longest$}{:MARGIN$}", "", verb.get_name(), "");
        labelled(&name, &about.unwrap_or_default(), width)
    };
    known.map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cli;
    use clap::CommandFactory;

    fn shown(is_all: bool) -> Command {
        with_help(Cli::command(), is_all, 80)
    }

    /// The options that a help page lists; what they do stands further in.
    fn options(help: &str) -> Vec<&str> {
        let is_option = |line: &&str| line.starts_with("      --") || line.starts_with("  -h,");
        let listed = help.split("\nExample").next().unwrap_or_default();
        listed.lines().filter(is_option).map(str::trim).collect()
    }

    #[test]
    fn exact_each_verb_stands_once_in_the_help() {
        let mut named: Vec<&str> =
            OTHER_VERBS.iter().flat_map(|(_, verbs)| *verbs).copied().collect();
        named.extend(FIRST_VERBS);
        named.sort_unstable();
        let command = shown(true);
        let mut verbs: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        verbs.sort_unstable();
        assert_eq!(named, verbs);
    }

    #[test]
    fn exact_the_first_page_shows_ten_verbs_and_the_other_all() {
        let first = shown(false).render_help().to_string();
        let all = shown(true).render_help().to_string();
        let stands = |page: &str, verb: &str| {
            let entry = format!("  {verb} ");
            page.lines().any(|line| line.starts_with(&entry))
        };
        for (_, verbs) in OTHER_VERBS {
            for verb in verbs {
                assert!(!stands(&first, verb), "{verb}");
                assert!(stands(&all, verb), "{verb}");
            }
        }
        for verb in FIRST_VERBS {
            assert!(stands(&first, verb) && stands(&all, verb), "{verb}");
        }
        assert!(first.contains("--help-all"));
    }

    #[test]
    fn exact_trial_and_plan_show_at_most_12_options_and_hide_none_for_good() {
        for (verb, first) in FIRST_OPTIONS {
            let help = |is_all: bool| {
                let mut command = shown(is_all);
                let verb = command.find_subcommand_mut(verb).expect("the verb");
                verb.render_long_help().to_string()
            };
            let (page, all) = (help(false), help(true));
            assert!(options(&page).len() <= 12, "{page}");
            for id in first {
                let option = format!("--{} ", id.replace('_', "-"));
                let found = |line: &&str| format!("{line} ").starts_with(&option);
                assert!(options(&page).iter().any(found), "{verb} {option}");
            }
            assert!(options(&all).len() > 30, "{all}");
        }
    }
}

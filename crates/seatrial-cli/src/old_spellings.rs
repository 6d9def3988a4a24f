//! Spellings of the last release in the words of this one. They work until the next release.

use std::ffi::OsString;
use std::process::Command;

use crate::output::{Exit, Failure};

/// The program of the studies, which lies beside this one where a clone of the project was built.
const LAB: &str = "seatrial-lab";

/// Verbs as they were, and as they are; what follows stays. Of those that begin alike the longest comes first.
const RENAMED: [(&str, &str); 6] = [
    ("sim mavlink", "sim serve"),
    ("sim ardupilot-json", "sim serve --ardupilot-json"),
    ("sim field", "seatrial-lab field"),
    ("study", "seatrial-lab"),
    ("manoeuvres predict", "manoeuvres"),
    ("vehicle check", "vehicle"),
];

/// Where the verb is among the words of a command line: behind the program and the options before it.
fn verb_at(words: &[OsString]) -> usize {
    let is_option = |word: &OsString| word.to_string_lossy().starts_with('-');
    let options = words.iter().skip(1).take_while(|word| is_option(word));
    1 + options.count()
}

/// A command line in the words of today.
pub fn in_new_words(typed: Vec<OsString>) -> Vec<OsString> {
    let verb = verb_at(&typed).min(typed.len());
    let begins_with = |old: &str| {
        let mut words = typed[verb..].iter();
        old.split(' ').all(|old| words.next().is_some_and(|word| word == old))
    };
    let Some((old, new)) = RENAMED.iter().find(|(old, _)| begins_with(old)) else {
        return typed;
    };
    let new: Vec<OsString> = new.split(' ').map(OsString::from).collect();
    let behind = verb + old.split(' ').count();
    [&typed[..verb], &new, &typed[behind..]].concat()
}

/// Runs the program of the studies where a command line asks for it, and ends with its exit code.
pub fn run_lab(words: &[OsString]) -> Result<(), Failure> {
    let verb = verb_at(words);
    if words.get(verb).is_none_or(|word| word != LAB) {
        return Ok(());
    }
    let (mut arguments, options) = (words[verb + 1..].to_vec(), &words[1..verb]);
    // `study` was itself the study of estimators.
    let first = arguments.iter().find(|word| *word != "--json");
    if first.is_none_or(|word| word.to_string_lossy().starts_with('-')) {
        arguments.insert(0, "estimators".into());
    }
    arguments.extend_from_slice(options);
    let name = format!("{LAB}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().map(|own| own.with_file_name(name));
    let program = beside.map_err(Failure::internal)?;
    if !program.is_file() {
        let words: Vec<_> = arguments.iter().map(|word| word.to_string_lossy()).collect();
        return Err(Failure::usage(format!(
            "the studies are a program of their own, {LAB}, which is not beside this one; in a clone of the project: cargo run --release -p {LAB} -- {}",
            words.join(" ")
        )));
    }
    let ended = Command::new(program).args(arguments).status();
    let code = ended.map_err(Failure::internal)?.code();
    std::process::exit(code.unwrap_or(Exit::Internal as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_old_words_become_new_ones_and_others_stay() {
        for (typed, new) in [
            ("seatrial study --runs 4", "seatrial seatrial-lab --runs 4"),
            ("seatrial manoeuvres predict", "seatrial manoeuvres"),
            ("seatrial --json study lies --seeds 2", "seatrial --json seatrial-lab lies --seeds 2"),
            ("seatrial sim mavlink --tcp a:1", "seatrial sim serve --tcp a:1"),
            ("seatrial sim ardupilot-json", "seatrial sim serve --ardupilot-json"),
            ("seatrial sim log --out study", "seatrial sim log --out study"),
            ("seatrial", "seatrial"),
            ("seatrial --json", "seatrial --json"),
        ] {
            let words = typed.split(' ').map(OsString::from).collect();
            let found = in_new_words(words).join(" ".as_ref());
            assert_eq!(found, new);
        }
    }
}

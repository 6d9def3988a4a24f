//! The commands that README and docs print run as they are printed.

use std::path::{Path, PathBuf};
use std::process::Output;

use seatrial_dev::{program, text};

/// A command that goes on until it is stopped, or that needs a vehicle: that it is understood is all that is asserted.
const NOT_RUN: [&str; 4] = [" serve", "--serve", "mavlink:", "ros2:"];

/// What a rehearsal of faults ends in: models, none to use, or an abort.
const OF_A_SCENARIO: [i32; 3] = [0, 4, 5];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The README and every page of the docs.
fn pages() -> Vec<PathBuf> {
    let mut pages = pages_of(&root().join("docs"));
    // Its commands follow each other on a vehicle: commission.rs walks them.
    pages.retain(|page| !page.ends_with("ardupilot.md"));
    pages.push(root().join("README.md"));
    pages.sort();
    pages
}

fn pages_of(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("docs/");
    let paths = entries.map(|entry| entry.expect("a page").path());
    let of = |path: PathBuf| match path.is_dir() {
        true => pages_of(&path),
        false => Vec::from_iter(path.extension().is_some_and(|e| e == "md").then_some(path)),
    };
    paths.flat_map(of).collect()
}

/// Words of the README and the docs together, as `wc -w` counts them: two hours of reading.
const MOST_WORDS: usize = 25_000;

#[test]
fn regress_readme_and_docs_are_read_in_two_hours() {
    let readme = root().join("README.md");
    let pages = pages_of(&root().join("docs")).into_iter().chain([readme]);
    let words: usize =
        pages.map(|page| std::fs::read_to_string(page).unwrap().split_whitespace().count()).sum();
    assert!((1..=MOST_WORDS).contains(&words), "{words} words");
}

/// The fenced blocks of a page that are not of another language.
fn blocks(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut open: Option<(bool, String)> = None;
    for line in page.lines() {
        match (line.trim_start().strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take().filter(|b| b.0).map(|b| b.1)),
            (Some(language), None) => {
                open = Some((matches!(language, "" | "sh"), String::new()));
            }
            (None, Some((_, block))) => *block += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    blocks
}

/// The lines of a block that are commands of seatrial, their continuations joined.
fn commands(block: &str) -> Vec<String> {
    let joined = block.replace("\\\n", " ");
    let lines = joined.lines().map(str::trim);
    let steps = lines.flat_map(|line| line.split(" && "));
    steps.filter(|step| step.starts_with("seatrial ")).map(str::to_owned).collect()
}

/// Commands in the running text, between backticks, without a place for a name of one's own.
fn quoted(page: &str) -> Vec<String> {
    let flat = page.replace('\n', " ");
    let quoted = flat.split('`').skip(1).step_by(2);
    let commands = quoted.filter(|part| part.starts_with("seatrial "));
    let is_open = |part: &&str| {
        let mut words = part.split_whitespace();
        part.contains("...")
            || words.any(|word| {
                word.len() > 1 && word.chars().all(|c| c.is_ascii_uppercase() || c == '_')
            })
    };
    commands
        .filter(|part| !is_open(part))
        .map(|part| part.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect()
}

/// Names a command in the running text a file or a number? Only then it is whole.
fn is_whole(command: &str) -> bool {
    let named = command.split_whitespace().skip(2);
    let mut named = named.filter(|word| !word.starts_with("--"));
    named.any(|word| word.contains('.') || word.bytes().all(|b| b.is_ascii_digit()))
}

/// Runs a command; what it prints goes where `>` says.
fn run(command: &str, folder: &Path, extra: &[&str]) -> Output {
    let (command, file) = match command.split_once(" > ") {
        Some((command, file)) => (command, Some(file)),
        None => (command, None),
    };
    let output =
        program().current_dir(folder).args(words(command)).args(extra).output().expect("it runs");
    if let Some(file) = file {
        std::fs::write(folder.join(file.trim()), &output.stdout).expect("a file");
    }
    output
}

/// The words of a command behind `seatrial`, those in quotes as one.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (place, part) in command.split('"').enumerate() {
        match place % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    words.drain(1..).collect()
}

/// A folder with what lies beside the README, as it is on a clean machine.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("logs")).expect("a folder");
    let sample = folder.path().join("docs/sample");
    std::fs::create_dir_all(&sample).expect("a folder");
    std::fs::copy(root().join("docs/sample/boat.csv"), sample.join("boat.csv"))
        .expect("the sample");
    folder
}

#[test]
fn cli_every_printed_command_runs() {
    let mut run_count = 0;
    for page in pages() {
        let printed = std::fs::read_to_string(&page).expect("a page");
        let whole: Vec<Vec<String>> = blocks(&printed).iter().map(|b| commands(b)).collect();
        let single = quoted(&printed).into_iter();
        let single = single.map(|command| (vec![command.clone()], is_whole(&command)));
        for (block, is_whole) in whole.into_iter().map(|block| (block, true)).chain(single) {
            let folder = folder();
            for command in block {
                let is_run = is_whole && !NOT_RUN.iter().any(|part| command.contains(part));
                let extra: &[&str] = if is_run { &[] } else { &["--help"] };
                let output = run(&command, folder.path(), extra);
                let code = output.status.code().unwrap_or(-1);
                let is_scenario = is_run && command.contains("--scenario");
                // The vehicle has changed: that is what README plays.
                let is_changed = is_run && command.starts_with("seatrial health") && code == 4;
                assert!(
                    code == 0 || is_changed || is_scenario && OF_A_SCENARIO.contains(&code),
                    "{}: {command}: exit {code}\n{}",
                    page.display(),
                    text(&output.stderr)
                );
                run_count += usize::from(is_run);
            }
        }
    }
    assert!(run_count >= 10, "{run_count}");
}

/// What a line of a block in a shell is, where it is no command of seatrial: a test elsewhere runs it, or the page says why none does.
const RUN_ELSEWHERE: [(&str, &str); 12] = [
    (". venv/bin/activate", "xtask python"),
    ("seatrial.", "Python, in the tests of the wheel"),
    ("mkdir -p logs", "the folder is there"),
    ("cargo xtask ", "the test command itself"),
    ("cargo install ", "the installation that every other command here stands for"),
    ("cargo build ", "xtask ros2, and the tests of the recordings"),
    ("cargo rustc ", "xtask embedded"),
    ("cmake ", "xtask embedded"),
    ("gcc ", "xtask embedded"),
    ("target/", "xtask embedded and ros2"),
    ("python3 ", "xtask python, dash and ros2"),
    ("pip install ", "xtask python"),
];

/// Blocks that are run, read or checked, or have a comment above that says why not.
#[test]
fn io_every_block_of_the_docs_is_checked_or_says_why_not() {
    for page in pages() {
        let printed = std::fs::read_to_string(&page).expect("a page");
        let mut lines = printed.lines().enumerate();
        let mut before = "";
        while let Some((number, line)) = lines.next() {
            let Some(language) = line.trim_start().strip_prefix("```") else {
                if !line.trim().is_empty() {
                    before = line;
                }
                continue;
            };
            let body: Vec<&str> = lines
                .by_ref()
                .map(|(_, line)| line)
                .take_while(|line| !line.trim_start().starts_with("```"))
                .collect();
            let is_excused = before.starts_with("<!-- not run: ");
            if let Err(what) = checked(language.trim(), &body.join("\n"))
                && !is_excused
            {
                let line = number + 1;
                panic!(
                    "{} line {line}: {what}; put `<!-- not run: WHY -->` above the block",
                    page.display()
                );
            }
            before = "";
        }
    }
}

fn checked(language: &str, body: &str) -> Result<(), String> {
    match language {
        "" | "sh" => shell_is_run(body),
        "toml" => match toml::from_str::<toml::Table>(body) {
            Ok(_) => Ok(()),
            Err(error) => Err(format!("no TOML: {error}")),
        },
        "json" => match serde_json::from_str::<serde_json::Value>(body) {
            Ok(_) => Ok(()),
            Err(error) => Err(format!("no JSON: {error}")),
        },
        // The wheel's tests run the one, the tests of the library for C compile the other.
        "python" | "c" => Ok(()),
        // A test of xtask compares each with the code of the program that `cargo xtask extending` tests.
        "rust" => Ok(()),
        other => Err(format!("a block of `{other}` that nothing checks")),
    }
}

fn shell_is_run(body: &str) -> Result<(), String> {
    let joined = body.replace("\\\n", " ");
    for line in joined.lines().map(str::trim).filter(|line| !line.is_empty()) {
        for step in line.split(" && ").map(str::trim) {
            let is_ours = step.starts_with("seatrial ");
            if !is_ours && !RUN_ELSEWHERE.iter().any(|(begin, _)| step.starts_with(begin)) {
                return Err(format!("`{step}` that no test runs"));
            }
        }
    }
    Ok(())
}

/// Every scenario plays on the vehicle that its first lines or the README name.
#[test]
fn cli_every_scenario_plays() {
    let folder = folder();
    let scenarios = root().join("crates/seatrial-sim/scenarios");
    let page = std::fs::read_to_string(root().join("docs/faults.md")).expect("docs/faults.md");
    for file in std::fs::read_dir(scenarios).expect("scenarios/") {
        let path = file.expect("a scenario").path();
        let name = path.file_stem().expect("a name").to_string_lossy();
        let scenario = std::fs::read_to_string(&path).expect("a scenario");
        let what = scenario.lines().next().unwrap_or_default();
        let row = format!("| `{name}` | {} |", what.trim_start_matches("# "));
        assert!(page.contains(&row), "docs/faults.md lacks {row}");
        let needs_sea = ["rough_sea", "shoal", "tidal_stream"];
        let vehicle = match needs_sea.iter().any(|part| name.contains(part)) {
            true => "sim:starfish-6dof",
            false => "sim:starfish",
        };
        let command = format!("seatrial trial --vehicle {vehicle} --scenario {name}");
        let output = run(&command, folder.path(), &[]);
        let code = output.status.code().unwrap_or(-1);
        let said = text(&output.stderr);
        assert!(OF_A_SCENARIO.contains(&code), "{command}: exit {code}\n{said}");
    }
}

#[test]
fn cli_completions_name_every_verb_of_this_binary() {
    let folder = tempfile::tempdir().expect("a folder");
    for shell in ["bash", "zsh", "fish"] {
        let output = run(&format!("seatrial completions {shell}"), folder.path(), &[]);
        let script = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0));
        for verb in ["trial", "identify", "doctor", "validate-on"] {
            assert!(script.contains(verb), "{shell}: {verb}");
        }
    }
    let pages = run("seatrial completions --man pages", folder.path(), &[]);
    assert_eq!(pages.status.code(), Some(0), "{}", text(&pages.stderr));
    for page in ["seatrial.1", "seatrial-identify.1", "seatrial-sim-log.1"] {
        assert!(folder.path().join("pages").join(page).exists(), "{page}");
    }
    let version = run("seatrial --version", folder.path(), &[]);
    assert!(text(&version.stdout).starts_with("seatrial "));
}

#[test]
fn cli_the_demonstration_leaves_a_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run("seatrial demo --speed 1000 --no-open", folder.path(), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(folder.path().join("demo.html").exists());
}

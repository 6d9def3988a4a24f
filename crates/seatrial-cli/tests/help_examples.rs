//! The examples of every `--help` run as they are printed and end well.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::{program, program_path, text};

/// A verb by its words, and its help.
struct Page {
    verb: Vec<String>,
    help: String,
}

fn help_of(verb: &[String]) -> String {
    let output = program().args(verb).arg("--help-all").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{verb:?}");
    text(&output.stdout)
}

/// The verbs that a page lists, of any group.
fn verbs_of(help: &str) -> Vec<String> {
    let entries = help.lines().skip_while(|line| !line.starts_with("Commands:"));
    let is_next =
        |line: &&str| ["Options:", "Arguments:"].iter().any(|head| line.starts_with(head));
    let entries = entries.take_while(|line| !is_next(line));
    let entries = entries.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = entries.filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

fn pages(verb: Vec<String>) -> Vec<Page> {
    let help = help_of(&verb);
    let below = verbs_of(&help);
    let below = below.into_iter().flat_map(|name| pages([verb.clone(), vec![name]].concat()));
    let below: Vec<Page> = below.collect();
    std::iter::once(Page { verb, help }).chain(below).collect()
}

/// The commands below the line that says "Example", each on one line.
fn examples(help: &str) -> Vec<String> {
    let mut lines = help.lines();
    let has_begun = lines.any(|line| line.starts_with("Example") && line.ends_with(':'));
    let printed = lines.take_while(|line| has_begun && line.starts_with("  "));
    let printed: String = printed.map(|line| format!("{}\n", &line[2..])).collect();
    let one_a_line = printed.replace("\\\n", " ");
    let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    one_a_line.lines().map(squeezed).collect()
}

/// An example that needs a boat: a test walks docs/ardupilot.md, where it stands.
fn needs_a_boat(command: &str) -> bool {
    command.contains("mavlink:") || command == "seatrial sim serve"
}

/// Runs a command in a folder as a shell does, the program first in its path.
fn shell(command: &str, folder: &Path) -> Command {
    let own = program_path();
    let own = own.parent().unwrap().display();
    let path = format!("{own}:{}", std::env::var("PATH").unwrap());
    let mut shell = Command::new("bash");
    shell.args(["-c", command]).current_dir(folder).env("PATH", path);
    shell.stdin(Stdio::null());
    shell
}

/// The dashboard goes on until it is interrupted, and then ends well.
fn serve(command: &str, folder: &Path) -> Output {
    // A port that is free, so that several of these tests may run at a time.
    let command = command.replace(":8042", ":0");
    let log = folder.join("said.txt");
    let mut server = shell(&format!("exec {command} > said.txt 2>&1"), folder)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !std::fs::read_to_string(&log).is_ok_and(|said| said.contains("http://")) {
        assert!(begun.elapsed() < Duration::from_secs(60), "{command}");
        std::thread::sleep(Duration::from_millis(20));
    }
    crate::signal::send(server.id(), "INT");
    let status = server.wait().unwrap();
    let stderr = std::fs::read(log).unwrap();
    Output { status, stdout: Vec::new(), stderr }
}

fn run(page: &Page, walked: &str) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let commands = examples(&page.help);
    for command in &commands {
        let verb = page.verb.join(" ");
        assert!(!command.contains("--yes"), "{verb}: {command}");
        if needs_a_boat(command) {
            assert!(walked.lines().any(|line| line == command), "{verb}: {command}");
            continue;
        }
        let output = match command.starts_with("seatrial serve") {
            true => serve(command, folder.path()),
            false => shell(command, folder.path()).output().unwrap(),
        };
        assert!(
            output.status.success(),
            "{verb}: {command}: {:?}\n{}{}",
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr)
        );
    }
    commands.len()
}

#[test]
fn cli_every_example_of_every_help_runs_and_ends_well() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/ardupilot.md");
    let walked = std::fs::read_to_string(docs).unwrap();
    let pages = pages(Vec::new());
    // The first page, 25 verbs and the five below `logbook`, `sim`, `manoeuvres` and `vehicle`.
    assert_eq!(pages.len(), 31);
    let without = pages.iter().filter(|page| examples(&page.help).is_empty());
    let without: Vec<String> = without.map(|page| page.verb.join(" ")).collect();
    assert_eq!(without, ["", "sim"]);
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    let Some(page) = pages.get(at) else { break };
                    run(page, &walked);
                }
            });
        }
    });
}

#[test]
fn cli_an_old_spelling_of_help_and_of_a_hidden_option_still_works() {
    let folder = tempfile::tempdir().unwrap();
    let says = |arguments: &[&str]| {
        let output = program().args(arguments).current_dir(folder.path()).output().unwrap();
        (output.status.code(), text(&output.stdout))
    };
    let (exit, page) = says(&["help", "inspect"]);
    assert_eq!((exit, page.contains("Usage: seatrial inspect")), (Some(0), true), "{page}");
    let model = ["--a22", "-0.05", "--b2", "0.0026", "--speed", "7.7"];
    let predicted = |verb: &[&str]| says(&[verb, &model].concat());
    assert_eq!(predicted(&["manoeuvres", "predict"]), predicted(&["manoeuvres"]));
    assert_eq!(predicted(&["manoeuvres"]).0, Some(0));
    assert_eq!(says(&["logbook", "list"]), says(&["logbook"]));
    assert_eq!(says(&["trial"]).0, Some(0));
    assert_eq!(says(&["logbook", "show", "1"]), says(&["logbook", "1"]));
    assert_eq!(says(&["logbook", "diff", "1", "1"]), says(&["logbook", "1", "1"]));
    assert_eq!(says(&["logbook", "verify"]), says(&["logbook", "--verify"]));
    let played = ["--speed", "1000", "--seconds", "2"];
    let served = |verb: &str| says(&[&["sim", verb], &played[..]].concat());
    assert_eq!(served("mavlink"), served("serve"));
    let (_, short) = says(&["trial", "--help"]);
    let (_, all) = says(&["trial", "--help-all"]);
    assert!(!short.contains("--stop-when") && all.contains("--stop-when"));
    let (exit, plan) = says(&["plan", "--stop-when", "a22:10%,b2:5%"]);
    assert_eq!((exit, plan.contains("stop_when")), (Some(0), true), "{plan}");
}

/// The old spellings of the lab run the program beside the own one, and say what to do where there is none.
#[cfg(unix)]
#[test]
fn cli_studies_are_handed_to_the_program_beside() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("seatrial");
    std::fs::copy(program_path(), &own).unwrap();
    let says = |arguments: &[&str]| {
        let output = Command::new(&own).args(arguments).output().unwrap();
        let code = output.status.code();
        (code, text(&output.stdout), text(&output.stderr))
    };
    let (code, _, said) = says(&["study", "lies", "--seeds", "2"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("cargo run --release -p seatrial-lab -- lies --seeds 2"), "{said}");
    let lab = folder.path().join("seatrial-lab");
    std::fs::write(&lab, "#!/bin/sh\necho \"$@\"\nexit 4\n").unwrap();
    std::fs::set_permissions(&lab, std::fs::Permissions::from_mode(0o755)).unwrap();
    for (typed, given) in [
        (&["study", "lies", "--help"][..], "lies --help\n"),
        (&["study"], "estimators\n"),
        (&["--json", "study", "--runs", "4"], "estimators --runs 4 --json\n"),
        (&["study", "--json", "world"], "--json world\n"),
        (&["sim", "field", "--out", "x"], "field --out x\n"),
    ] {
        assert_eq!(says(typed), (Some(4), given.to_owned(), String::new()));
    }
}

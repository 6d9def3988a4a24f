//! One log gets one outcome, wherever it is read, and a text that fits a terminal.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use seatrial::identification::{Outcome, Reader, Verdict};
use seatrial::words::sentence;
use seatrial_app::documents::IdentificationDocument;
use seatrial_app::identify_log::{IdentifiedLog, Options, identify_log};
use seatrial_app::log_page;
use seatrial_lab::lies;

use crate::output::Exit;
use crate::screen::PLAIN_WIDTH;

/// Logs that give a verdict, at least.
const LEAST_LOGS: usize = 60;

/// A log of each kind that lies or is sound, and logs of real and simulated vehicles where they are at hand.
fn logs(folder: &Path) -> Vec<PathBuf> {
    let mut logs = Vec::new();
    for kind in &lies::KINDS {
        let path = folder.join(format!("{}.csv", kind.name));
        std::fs::write(&path, kind.log(1).csv).expect("the log is written");
        logs.push(path);
    }
    for recorded in ["real", "simulated"] {
        let Some(folder) = seatrial_dev::data(recorded) else {
            continue;
        };
        let files = std::fs::read_dir(folder).expect("a folder of logs");
        let paths = files.map(|file| file.expect("a file").path());
        // Of REMUS 100 logs a noisy one in a current stands for all.
        let is_one = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.ends_with(".csv") && (!name.starts_with("remus") || name.contains("n1_c0p3"))
        };
        logs.extend(paths.filter(is_one));
    }
    logs
}

/// What a log gives, of as many threads as there are processors.
fn identified(logs: &[PathBuf]) -> Vec<IdentifiedLog> {
    let (next, found) = (Mutex::new(logs.iter()), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let log = next.lock().unwrap().next();
                    let Some(log) = log else { return };
                    // A log that cannot be read has no model to judge.
                    if let Ok(log) = identify_log(log, &Options::default()) {
                        found.lock().unwrap().push(log);
                    }
                }
            });
        }
    });
    found.into_inner().unwrap()
}

/// Significant figures of the longest number in a text.
fn most_figures(text: &str) -> usize {
    let numbers = text.split(|c: char| !c.is_ascii_digit() && c != '.');
    let figures = |number: &str| {
        let digits = number.trim_end_matches('.').replace('.', "");
        digits.trim_start_matches('0').len()
    };
    numbers.map(figures).max().unwrap_or(0)
}

fn assert_fits(text: &str, speeds: usize, about: &str) {
    let lines = text.lines().count();
    assert!(lines < 15 + speeds, "{about}: {lines} lines\n{text}");
    for line in text.lines() {
        let width = line.chars().count();
        assert!(width <= PLAIN_WIDTH, "{about}: {width} columns\n{text}");
    }
    // The command names the log, whose name may hold a date.
    let printed = text.split("\nNext ").next().unwrap_or_default();
    assert!(most_figures(printed) <= 6, "{about}\n{text}");
}

fn has_no_option(verdict: &Verdict) -> bool {
    verdict.reasons.iter().all(|r| !r.action.contains("--"))
}

#[test]
fn cli_a_log_gets_one_outcome_in_all_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let logs = logs(folder.path());
    let found = identified(&logs);
    assert!(found.len() >= LEAST_LOGS, "{} verdicts", found.len());
    let mut outcomes = Vec::new();
    for log in &found {
        let path = &log.logs.log.path;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let outcome = log.verdict().outcome();
        outcomes.push(outcome);
        let word = outcome.name();

        let text = super::text(log, &format!("seatrial identify {name}"), None, PLAIN_WIDTH);
        assert_eq!(text.lines().next(), Some(word.to_uppercase().as_str()));
        assert_fits(&text, log.models.as_ref().map_or(1, Vec::len), &name);
        let has_numbers = text.contains("1/s^2") || text.contains("K_p");
        let models = log.models.as_deref().unwrap_or_default();
        let is_reported = |outcome| outcome != Outcome::DoNotUse;
        let any_reported =
            models.iter().any(|m| is_reported(m.verdict.outcome())) || is_reported(outcome);
        assert_eq!(has_numbers, any_reported, "{name}\n{text}");

        let page = log_page::page(log, path);
        let banner = page.split("</section>").next().unwrap_or_default();
        let capital = sentence(word);
        assert!(banner.contains(&format!("</span> {capital}</h2>")), "{name}: {word}\n{banner}");

        for reader in [Reader::Terminal, Reader::Dashboard, Reader::Python] {
            let document = IdentificationDocument::of(log).addressed_to(reader);
            let is_silent = reader == Reader::Terminal || has_no_option(&document.verdict);
            assert!(is_silent, "{name}: {:?}", document.verdict);
            let json = serde_json::to_value(&document).expect("JSON");
            let printed = json["verdict"]["outcome"].as_str().expect("an outcome");
            assert_eq!(printed.replace('_', " "), word, "{name}");
            assert_eq!(json["verdict"]["accepted"], Exit::of(log.verdict()) == Exit::Done);
        }
    }
    for outcome in [Outcome::Use, Outcome::UseWithCare, Outcome::NotValidated, Outcome::DoNotUse] {
        assert!(outcomes.contains(&outcome), "no log is {}", outcome.name());
    }
}

/// At every width the verdict, the gain, T, K and what the gain promises; the parameters of the model only where there is room.
#[test]
fn cli_a_narrow_screen_drops_the_parameters_before_the_gain() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("run.csv");
    let out = log.to_str().expect("UTF-8");
    let made = seatrial_dev::run(&["sim", "log", "--seed", "1", "--out", out]);
    assert!(made.status.success());
    let found = identify_log(&log, &Options::default()).expect("a log");
    for (width, has_parameters) in [(60, false), (80, true), (200, true)] {
        let text = super::text(&found, "seatrial identify run.csv", None, width);
        let heading = text.lines().find(|line| line.contains("K_p")).expect("a table");
        let columns: Vec<&str> = heading.split_whitespace().collect();
        for column in ["speed", "T", "K", "overshoot", "K_p", "verdict"] {
            assert!(columns.contains(&column), "{width}: {column}\n{text}");
        }
        assert_eq!(columns.contains(&"a22"), has_parameters, "{width}\n{text}");
        let left_out = match width {
            60 => ["a22, b2, C0, R^2."].as_slice(),
            80 => &["C0, R^2."],
            _ => &[],
        };
        let notes = text.lines().filter(|line| line.contains("On a wider screen"));
        let notes: Vec<&str> = notes.collect();
        assert_eq!(notes.len(), left_out.len(), "{width}\n{text}");
        for (note, left_out) in notes.iter().zip(left_out) {
            assert!(note.ends_with(left_out), "{width}\n{text}");
        }
        let flat = seatrial_dev::unwrapped(&text);
        assert!(flat.contains("A 40 deg course change will overshoot by 0 to 3 deg"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= width), "{width}\n{text}");
    }
}

//! One log has one answer: the terminal, its exit code, the report, the dashboard and the JSON document say the same word.
//!
//! Some logs here; every log of the recorded data and of every kind of lie with `SEATRIAL_LOGS=all`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

use seatrial_dev::{data, program, text};
use seatrial_lab::lies::KINDS;
use serde_json::Value;

/// Logs of the recorded data: of each vehicle and of each outcome, and some that cannot be read.
const RECORDED: [&str; 16] = [
    "real/fuzhou_zz.csv",
    "real/hakusan_ship.csv",
    "real/esso_zigzag_b.csv",
    "real/kvlcc2hsva_Z_20_10_P.csv",
    "real/marin_zz_10_m.csv",
    "real/slocum_amadeus.csv",
    "simulated/first_order_80_s0p5_h0p7.csv",
    "simulated/first_order_70_s0_h0.csv",
    "simulated/remus100_80_native_n0p3_c0.csv",
    "firmware/a1_1.csv",
    "firmware/d_p2_lag_d3_1.csv",
    "native/ardupilot/arducopter_pixhawk4_80k.BIN",
    "native/ardupilot/arduplane_pixhawk_64k.BIN",
    "native/ardupilot/rover_motorboat_50hz_loop.tlog",
    "native/px4/vtol_cubeorange.ulg",
    "native/nmea2000/raymarine-ev1.raw",
];

/// Every other kind of lie, the others with all.
const KIND_STEP: usize = 2;

/// Logs that are held against each other, at least.
const LEAST_LOGS: usize = 60;

fn wants_all() -> bool {
    std::env::var("SEATRIAL_LOGS").is_ok_and(|wish| wish == "all")
}

/// Files below a folder that are logs of one file; a glider's needs its list of sensors beside it.
fn logs_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let extension = extension.to_ascii_lowercase();
        if path.is_dir() {
            logs_below(&path, found);
        } else if ["csv", "bin", "tlog", "ulg", "raw", "all"].contains(&extension.as_str()) {
            found.push(path);
        }
    }
}

fn recorded() -> Vec<PathBuf> {
    if !wants_all() {
        return RECORDED.iter().filter_map(|name| data(name)).collect();
    }
    let mut found = Vec::new();
    for folder in ["real", "simulated", "firmware", "native"] {
        found.extend(data(folder).map(|folder| {
            let mut logs = Vec::new();
            logs_below(&folder, &mut logs);
            logs
        }));
    }
    let mut found = found.concat();
    found.sort();
    found
}

/// Logs that lie, or are sound, written into a folder.
fn made(folder: &Path) -> Vec<PathBuf> {
    let step = if wants_all() { 1 } else { KIND_STEP };
    let kinds = KINDS.iter().step_by(step);
    kinds
        .map(|kind| {
            let path = folder.join(format!("{}.csv", kind.name));
            std::fs::write(&path, kind.log(1).csv).expect("a log");
            path
        })
        .collect()
}

/// A dashboard, until it is dropped.
struct Dashboard {
    process: Child,
    address: String,
}

impl Dashboard {
    fn start(folder: &Path) -> Self {
        let mut process = program()
            .args(["serve", "--listen", "127.0.0.1:0"])
            .current_dir(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let output = process.stdout.take().expect("its output");
        let said = BufReader::new(output).lines().map_while(Result::ok);
        let mut addresses = said.filter_map(|line| {
            let (_, rest) = line.split_once("http://")?;
            Some(rest.split('/').next()?.to_owned())
        });
        let address = addresses.next().expect("an address");
        Self { process, address }
    }

    /// The answer to a log that is dropped on the page.
    fn identify(&self, log: &Path) -> Value {
        let body = std::fs::read(log).expect("the log");
        let mut stream = TcpStream::connect(&self.address).expect("it listens");
        let head = format!(
            "POST /api/v1/logs/identify?name=log HTTP/1.0\r\nHost: {}\r\nContent-Length: {}\r\n\r\n",
            self.address,
            body.len()
        );
        stream.write_all(head.as_bytes()).expect("it reads");
        stream.write_all(&body).expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        let at = answer.windows(4).position(|four| four == b"\r\n\r\n");
        serde_json::from_slice(&answer[at.expect("a head") + 4..]).expect("JSON")
    }
}

impl Drop for Dashboard {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What the report says first.
fn word_of_report(page: &str) -> String {
    let (_, rest) = page.split_once("aria-hidden=\"true\">").expect("a sign");
    let (_, rest) = rest.split_once("</span>").expect("its end");
    let (verdict, _) = rest.split_once('.').expect("a sentence");
    verdict.trim().to_lowercase()
}

/// No line over 80 columns.
fn check_width(said: &str, log: &Path) {
    let log = log.display().to_string();
    for line in said.lines() {
        // The name of a log is the user's, and is not cut.
        let own = line.replace(&log, "");
        assert!(own.chars().count() <= 80, "{log}: {line}");
    }
}

/// No line over 80 columns, no number with more than six significant figures, and not more lines than one can read.
fn check_text(said: &str, speeds: usize, log: &Path) {
    let log = log.display().to_string();
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines.len() <= 15 + speeds, "{log}: {} lines\n{said}", lines.len());
    check_width(said, Path::new(&log));
    // Paths are names, not numbers.
    for word in said.split_whitespace().filter(|word| !word.contains('/')) {
        let number = word.trim_matches(|c: char| !c.is_ascii_digit() && c != '-');
        if number.parse::<f64>().is_err() {
            continue;
        }
        let digits = number.split(['e', 'E']).next().unwrap_or_default();
        let figures = digits.chars().filter(char::is_ascii_digit).collect::<String>();
        let figures = figures.trim_start_matches('0').len();
        assert!(figures <= 6, "{log}: {number}\n{said}");
    }
}

/// What every place says of a log: its outcome in words, or `refused`.
fn answered(log: &Path, folder: &Path, number: usize, dashboard: &Dashboard) -> String {
    let path = log.to_str().expect("UTF-8");
    let run = |verb: &str, extra: &[&str]| {
        let mut command = program();
        command.current_dir(folder);
        command.args([verb, path]).args(extra);
        command.output().expect("it runs")
    };
    let (terminal, json) = (run("identify", &[]), run("identify", &["--json"]));
    let inspected = run("inspect", &[]);
    let report = folder.join(format!("{number}.html"));
    let reported = run("report", &["--out", report.to_str().expect("UTF-8")]);
    let code = json.status.code();
    for other in [&terminal, &inspected, &reported] {
        assert_eq!(other.status.code(), code, "{path}");
    }
    let shown = dashboard.identify(log);
    if code == Some(3) {
        assert_eq!(shown["code"], "log_refused", "{path}: {shown}");
        let message = shown["message"].as_str().expect("a message");
        assert!(!message.contains("--"), "{path}: {message}");
        let said = text(&terminal.stderr);
        assert!(said.lines().count() <= 6, "{path}: {said}");
        return "refused".into();
    }
    let document: Value = serde_json::from_slice(&json.stdout).expect("a document");
    let outcome = document["verdict"]["outcome"].as_str().expect("an outcome");
    let word = outcome.replace('_', " ");
    let expected = if outcome.starts_with("use") { 0 } else { 4 };
    assert_eq!(code, Some(expected), "{path}: {word}");
    let said = text(&terminal.stdout);
    let first = said.lines().next().unwrap_or_default();
    assert_eq!(first.to_lowercase(), word, "{path}: terminal");
    let looked_at = text(&inspected.stdout);
    let capitals = word.to_uppercase();
    assert!(looked_at.lines().any(|line| line == capitals), "{path}: {looked_at}");
    check_width(&looked_at, log);
    let page = std::fs::read_to_string(&report).expect("a report");
    assert_eq!(word_of_report(&page), word, "{path}: report");
    assert_eq!(shown["verdict"]["outcome"], outcome, "{path}: dashboard");
    let document = &shown["document"];
    assert_eq!(document["verdict"]["outcome"], outcome, "{path}: dashboard's document");
    let warnings = document["source"]["warnings"].to_string();
    assert!(!warnings.contains(" --"), "{path}: {warnings}");
    let models = document["models"].as_array();
    for model in models.into_iter().flatten() {
        let of_speed = model["verdict"]["outcome"].as_str().expect("an outcome");
        assert!(outcome != "use" || of_speed == "use", "{path}: {of_speed} under use");
    }
    check_text(&said, models.map_or(1, Vec::len), log);
    word
}

#[test]
fn cli_a_log_has_one_answer_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let dashboard = Dashboard::start(folder.path());
    let logs = [recorded(), made(folder.path())].concat();
    if data("real").is_some() {
        assert!(logs.len() >= LEAST_LOGS, "{} logs", logs.len());
    }
    let next = std::sync::Mutex::new(logs.iter().enumerate());
    let words = std::sync::Mutex::new(std::collections::BTreeMap::<String, usize>::new());
    let work = || {
        loop {
            let log = next.lock().expect("nobody failed").next();
            let Some((number, log)) = log else { return };
            let word = answered(log, folder.path(), number, &dashboard);
            *words.lock().expect("nobody failed").entry(word).or_default() += 1;
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(work);
        }
    });
    let words = words.into_inner().expect("nobody failed");
    eprintln!("{} logs: {words:?}", logs.len());
    assert!(words.len() >= 3, "{words:?}");
}

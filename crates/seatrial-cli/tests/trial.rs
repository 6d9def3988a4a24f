//! `seatrial trial` at the process boundary.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::program;
use serde_json::Value;
use tempfile::TempDir;

/// A folder to run `seatrial` in; every file is named relative to it.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = program();
        command.current_dir(&self.0).args(arguments);
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// `trial --json` with these arguments: what it did and its document.
    fn trial(&self, arguments: &[&str]) -> (Output, Value) {
        let output = self.run(&[&["trial", "--json"], arguments].concat());
        let document = serde_json::from_slice(&output.stdout).unwrap_or_default();
        (output, document)
    }

    /// A trial that is refused with this exit code before anything is recorded; what it said.
    fn refused(&self, exit: i32, arguments: &[&str]) -> String {
        let (output, _) = self.trial(arguments);
        let message = message(&output);
        assert_eq!(output.status.code(), Some(exit), "{message}");
        assert_eq!(output.stdout, b"");
        assert!(message.starts_with("seatrial: "), "{message}");
        message
    }
}

fn message(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn runs(document: &Value) -> &Vec<Value> {
    document["runs"].as_array().unwrap()
}

#[test]
fn cli_the_default_trial_takes_five_accepted_runs_and_under_3_s() {
    let folder = Folder::new();
    let start = Instant::now();
    let (output, document) = folder.trial(&["--report", "trial.html"]);
    // 0.3 s measured; the rest is for a busy machine.
    assert!(start.elapsed() < Duration::from_secs(3));
    assert_eq!(output.status.code(), Some(0), "{}", message(&output));
    assert_eq!(document["schema"], "seatrial.trial.v1");
    assert_eq!(document["outcome"]["state"], "finished");
    assert_eq!(document["seed"], 1);
    let thrusts: Vec<_> = runs(&document).iter().map(|run| &run["thrust"]).collect();
    assert_eq!(thrusts, [0.6, 0.7, 0.8, 0.9, 1.0]);
    for run in runs(&document) {
        assert_eq!(run["verdict"]["accepted"], true);
        assert_eq!(run["identification"]["online"].get("trace"), None);
    }
    let report = std::fs::read_to_string(folder.path("trial.html")).unwrap();
    assert!(report.contains("<html") && report.contains("sim:starfish"));
    assert!(report.trim_end().ends_with("</html>"));
}

#[test]
fn cli_same_seed_same_bytes() {
    let folder = Folder::new();
    let stdout = |logbook, seed| {
        let (output, _) = folder.trial(&["--logbook", logbook, "--seed", seed]);
        assert!(!output.stdout.is_empty(), "{}", message(&output));
        output.stdout
    };
    let first = stdout("a.db", "7");
    assert!(first == stdout("b.db", "7"), "another logbook");
    assert!(first == stdout("a.db", "7"), "the same logbook again");
    assert!(first != stdout("c.db", "8"), "another seed");
}

#[test]
fn cli_the_trace_is_given_on_request() {
    let folder = Folder::new();
    folder.write("plan.toml", "thrusts = [0.8]\n");
    let (_, document) = folder.trial(&["--plan", "plan.toml", "--trace"]);
    let trace = &runs(&document)[0]["identification"]["online"]["trace"];
    // 16.5 s of training at 20 Hz.
    assert_eq!(trace.as_array().unwrap().len(), 330);
}

#[test]
fn cli_other_verbs_read_what_a_trial_writes() {
    let folder = Folder::new();
    let (output, _) = folder.trial(&[]);
    std::fs::write(folder.path("trial.json"), output.stdout).unwrap();
    for verb in ["gains", "turn"] {
        let output = folder.run(&[verb, "--json", "--model", "trial.json"]);
        assert_eq!(output.status.code(), Some(0), "{}", message(&output));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let speeds = document["points"].as_array().map(Vec::len);
        assert_eq!(speeds, Some(5), "{verb}");
    }
    let output = folder.run(&["replay", "seatrial.db", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", message(&output));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["identical"], true);
    assert_eq!(document["results"], 5);
}

#[cfg(unix)]
#[test]
fn cli_a_signal_hands_the_vehicle_back() {
    let interrupt = |signal: &str| {
        let folder = Folder::new();
        let trial = folder
            .command(&["trial", "--json", "--realtime"])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        while !folder.path("seatrial.db").exists() {
            std::thread::sleep(Duration::from_millis(10));
        }
        // The vehicle moves soon after the logbook is there.
        std::thread::sleep(Duration::from_secs(1));
        let start = Instant::now();
        crate::signal::send(trial.id(), signal);
        let output = trial.wait_with_output().unwrap();
        // Two samples of 0.05 s; the rest is for a busy machine and its disk. Undisturbed, the trial goes on for minutes.
        assert!(start.elapsed() < Duration::from_secs(5), "{signal}");
        assert_eq!(output.status.code(), Some(5), "{}", message(&output));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(document["outcome"]["state"], "aborted");
        assert_eq!(document["outcome"]["reason"], "operator");
        let verdict = &runs(&document)[0]["verdict"];
        assert_eq!(verdict["reasons"][0]["code"], "aborted");
        let verified = folder.run(&["logbook", "--verify", "--logbook", "seatrial.db"]);
        assert_eq!(verified.status.code(), Some(0), "{}", message(&verified));
    };
    std::thread::scope(|scope| {
        for signal in ["INT", "TERM"] {
            scope.spawn(move || interrupt(signal));
        }
    });
}

#[test]
fn cli_a_bad_plan_is_exit_3_and_named() {
    let folder = Folder::new();
    folder.write("typo.toml", "thrust = [0.6]\n");
    folder.write("limit.toml", "rudder_limit_rad = 0.2\n");
    folder.write("empty_list.toml", "thrusts = []\n");
    folder.write("photo.toml", "\u{89}PNG\n");
    for (plan, expected) in [
        ("typo.toml", "unknown field `thrust`"),
        ("limit.toml", "training.excitation must be"),
        ("empty_list.toml", "thrusts must be"),
        ("photo.toml", "not a plan"),
        ("missing.toml", "No such file"),
    ] {
        let message = folder.refused(3, &["--plan", plan]);
        assert!(message.contains(plan), "{message}");
        assert!(message.contains(expected), "{message}");
    }
    assert!(!folder.path("seatrial.db").exists());
}

#[test]
fn cli_a_bad_vehicle_is_named() {
    let folder = Folder::new();
    let message = folder.refused(2, &["--vehicle", "sim:nautilus"]);
    assert!(message.contains("sim:nautilus"), "{message}");
    assert!(message.contains("sim:starfish"), "{message}");
    folder.write("nameless.toml", "name = 'x'\n");
    folder.write("wild.toml", &BOAT.replace("gain = 0.1", "gain = nan"));
    for (vehicle, expected) in [
        ("nameless.toml", "missing field `speeds`"),
        ("wild.toml", "heading_hold.gain must be"),
        ("missing.toml", "No such file"),
    ] {
        let message = folder.refused(3, &["--vehicle", &format!("sim:{vehicle}")]);
        assert!(message.contains(vehicle), "{message}");
        assert!(message.contains(expected), "{message}");
    }
    assert!(!folder.path("seatrial.db").exists());
}

#[test]
fn cli_a_logbook_that_cannot_be_is_exit_3() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder
        .write("notes.txt", "not a logbook, but long enough to be read as one".repeat(99).as_str());
    for (logbook, expected) in [
        ("folder", "a directory"),
        ("no_such_folder/seatrial.db", "does its folder exist"),
        ("notes.txt", "not a seatrial logbook"),
    ] {
        let message = folder.refused(3, &["--logbook", logbook]);
        assert!(message.contains(logbook), "{message}");
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn cli_the_trial_prints_what_the_readme_shows() {
    let output = Folder::new().run(&["trial", "--report", "trial.html"]);
    let printed = String::from_utf8(output.stdout).unwrap();
    let readme = include_str!("../../../README.md");
    let shown = readme
        .lines()
        .skip_while(|line| !line.starts_with("USE"))
        .take_while(|line| *line != "```");
    assert!(shown.clone().count() > 9);
    for line in shown {
        assert!(printed.lines().any(|printed| printed == line), "{line}");
    }
}

#[test]
fn cli_a_report_that_cannot_be_saved_is_exit_6() {
    let folder = Folder::new();
    let report = Path::new("no_such_folder").join("trial.html");
    let report = report.to_str().unwrap();
    let output = folder.run(&["trial", "--report", report]);
    assert_eq!(output.status.code(), Some(6));
    let message = message(&output);
    assert!(
        message.contains(&format!("{report}: not saved: No such file or directory")),
        "{message}"
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("USE"), "{text}");
    assert!(!text.contains(report), "{text}");
}

/// Nothing like the Starfish, and exact but for its own resolution.
const BOAT: &str = "
name = 'boat'
initial_thrust = 0.5
[heading_hold]
gain = 0.1
rudder_limit_rad = 0.2
[disturbance]
standard_deviation_rad_s2 = 0.0
correlation_time_s = 2.0
[sensors.compass]
noise_rad = 0.001
[[speeds]]
thrust = 0.5
surge_speed_m_s = 1.0
a22_per_s = -2.0
b2_per_s2 = 1.5
c0_rad_per_s2 = 0.01
[[speeds]]
thrust = 1.0
surge_speed_m_s = 2.0
a22_per_s = -3.0
b2_per_s2 = 4.0
c0_rad_per_s2 = 0.04
";

#[test]
fn recover_a_vehicle_of_a_file() {
    let folder = Folder::new();
    folder.write("boat.toml", BOAT);
    folder.write("plan.toml", "thrusts = [0.5, 1.0]\n");
    let (output, document) = folder.trial(&["--vehicle", "sim:boat.toml", "--plan", "plan.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", message(&output));
    assert_eq!(document["vehicle"], "sim:boat.toml");
    for (run, truth) in runs(&document).iter().zip([[-2.0, 1.5, 0.01], [-3.0, 4.0, 0.04]]) {
        let refined = &run["identification"]["refined"];
        // A thousandth of a radian of compass noise: 1 to 2 % of a22 and b2; C0 is a small difference.
        for ((name, truth), share) in ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"]
            .into_iter()
            .zip(truth)
            .zip([0.03, 0.03, 0.1])
        {
            let found = refined[name].as_f64().unwrap();
            assert!((found / truth - 1.0).abs() < share, "{name} {found}, not {truth}");
        }
    }
}

#[test]
fn cli_a_reversed_rudder_aborts() {
    let folder = Folder::new();
    let reversed = BOAT.replace("b2_per_s2 = ", "b2_per_s2 = -").replace("gain = ", "gain = -");
    folder.write("reversed.toml", &reversed);
    folder.write("plan.toml", "thrusts = [0.5]\n");
    let (output, document) =
        folder.trial(&["--vehicle", "sim:reversed.toml", "--plan", "plan.toml"]);
    assert_eq!(output.status.code(), Some(5), "{}", message(&output));
    assert_eq!(document["outcome"]["state"], "aborted");
    assert_eq!(document["outcome"]["reason"], "reversed_rudder");
    let [run] = &runs(&document)[..] else {
        panic!("{document}");
    };
    assert_eq!(run["verdict"]["accepted"], false);
    assert_eq!(run["identification"], Value::Null);
    let verified = folder.run(&["logbook", "--verify", "--logbook", "seatrial.db"]);
    assert_eq!(verified.status.code(), Some(0), "{}", message(&verified));
}

/// Whatever befalls the vehicle, the logbook keeps it and a replay finds the same.
#[test]
fn cli_a_rehearsal_is_kept_and_replayed() {
    let folder = Folder::new();
    folder.write("plan.toml", "thrusts = [0.6]\n");
    for (fault, exit, reason) in [
        ("kind = 'operator_takeover'", 5, "operator"),
        ("kind = 'link_loss'", 5, "link_lost"),
        ("kind = 'compass_dropout'", 5, "stale_samples"),
        ("kind = 'reordered_samples'\nevery = 20\nfor_s = 2.0", 0, ""),
        ("kind = 'clock_jump'\nby_s = 3.0", 5, "stale_samples"),
    ] {
        let scenario = format!("[[fault]]\nstage = 'training'\nafter_s = 1.0\n{fault}\n");
        folder.write("scenario.toml", &scenario);
        let _ = std::fs::remove_file(folder.path("seatrial.db"));
        let (output, document) =
            folder.trial(&["--plan", "plan.toml", "--scenario", "scenario.toml"]);
        assert_eq!(output.status.code(), Some(exit), "{fault}: {}", message(&output));
        assert_eq!(document["outcome"]["reason"].as_str().unwrap_or(""), reason, "{fault}");
        for verb in ["verify", "show"] {
            let kept = folder.run(&["logbook", verb, "--logbook", "seatrial.db"]);
            assert_eq!(kept.status.code(), Some(0), "{fault}: {}", message(&kept));
        }
        let replayed = folder.run(&["replay", "seatrial.db"]);
        assert_eq!(replayed.status.code(), Some(0), "{fault}: {}", message(&replayed));
    }
}

#[test]
fn cli_a_scenario_that_cannot_be_played_is_named() {
    let folder = Folder::new();
    folder.write("current.toml", "[[fault]]\nkind = 'current_step'\nat_s = 5\n");
    folder.write("typo.toml", "[[fault]]\nkind = 'compas_step'\nat_s = 5\n");
    for (scenario, expected) in [
        ("current.toml", "current_step: this vehicle cannot play it"),
        ("typo.toml", "compas_step: no such kind; expected one of compass_freeze"),
        ("missing.toml", "No such file"),
    ] {
        let message = folder.refused(3, &["--scenario", scenario]);
        assert!(message.contains(scenario) && message.contains(expected), "{message}");
    }
    assert!(!folder.path("seatrial.db").exists());
}

/// The live view is taken away before the answer: its first line begins at the left edge, below the lines that stay.
#[test]
fn cli_the_answer_begins_on_a_clean_screen() {
    let folder = Folder::new();
    let command = format!(
        "stty rows 24 columns 80; {} trial --seed 2",
        seatrial_dev::program_path().display()
    );
    // A terminal that `script` plays. It is asked where its cursor is, and says so beforehand.
    let played = Command::new("script")
        .args(["-qec", &command, "/dev/null"])
        .env("TERM", "xterm")
        .current_dir(&folder.0)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut played) = played else {
        eprintln!("skipped: no `script`");
        return;
    };
    let mut typed = played.stdin.take().unwrap();
    typed.write_all("\x1b[1;1R".repeat(50).as_bytes()).unwrap();
    let mut said = Vec::new();
    let mut shown = played.stdout.take().unwrap();
    shown.read_to_end(&mut said).unwrap();
    drop(typed);
    assert!(played.wait().unwrap().success());
    let said = String::from_utf8_lossy(&said).into_owned();
    let (before, _) =
        said.split_once("\x1b[1;32mUSE\x1b[0m\r\n").unwrap_or_else(|| panic!("{said}"));
    let mut places = before.match_indices('H').filter_map(|(end, _)| {
        let begin = before[..end].rfind("\x1b[")?;
        let (row, column) = before[begin + 2..end].split_once(';')?;
        Some((row.parse::<u16>().ok()?, column.parse::<u16>().ok()?))
    });
    let (_, column) = places.next_back().expect("the live view places the cursor");
    assert_eq!(column, 1);
}

/// The log has the command, not the rudder: the run that fails is told why.
#[test]
fn cli_trial_names_a_rudder_that_stuck() {
    let folder = Folder::new();
    folder.write(
        "stuck.toml",
        "[[fault]]\nkind = \"rudder_jam\"\nstage = \"validation\"\nrun = 1\nafter_s = 3.0\nfor_s = 6.0\n",
    );
    let plan = ["plan", "--thrust", "0.8", "--out", "plan.toml"];
    assert!(folder.command(&plan).output().unwrap().status.success());
    let trial = ["trial", "--plan", "plan.toml", "--scenario", "stuck.toml", "--json"];
    let said = folder.command(&trial).output().unwrap();
    let document: Value = serde_json::from_slice(&said.stdout).unwrap();
    let text = document["runs"][0]["verdict"]["reasons"][0]["text"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    assert!(text.starts_with("The rudder seems to have stuck at "), "{document:#}");
}

/// What a rehearsal with the faults of a scenario prints, and its exit code.
fn rehearsed(folder: &Folder, scenario: &str) -> (String, Option<i32>) {
    let trial = ["trial", "--yes", "--scenario", scenario];
    let said = folder.command(&trial).output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    (text.split_whitespace().collect::<Vec<_>>().join(" "), said.status.code())
}

#[test]
fn cli_the_answer_names_the_fault_of_a_run_that_was_repeated() {
    let folder = Folder::new();
    let (text, code) = rehearsed(&folder, "frozen_compass");
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("Cause Run 1 at 60 % thrust was refused and repeated: From 31.5 s on the compass stood still for 1.9 s"),
        "{text}"
    );
}

/// The command that a remark names prints every remark.
#[test]
fn cli_the_command_that_shows_more_remarks_prints_them() {
    let folder = Folder::new();
    let (text, _) = rehearsed(&folder, "bad_compass");
    assert!(
        text.contains("more remark, shown by seatrial logbook 1 --logbook seatrial.db"),
        "{text}"
    );
    let shown = folder.command(&["logbook", "1"]).output().unwrap();
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.contains("Also   Run 1 at 60 % thrust was refused"), "{shown}");
}

#[test]
fn cli_an_aborted_trial_names_what_its_record_shows_and_leads_to_no_gains() {
    for (scenario, cause) in [
        ("bad_compass", "Cause The trial was aborted: the compass gave no heading for 2.0 s"),
        (
            "bad_rudder",
            "Cause The trial was aborted: the rudder turned the vehicle the other way than at 60 % thrust.",
        ),
    ] {
        let folder = Folder::new();
        let (text, code) = rehearsed(&folder, scenario);
        assert_eq!(code, Some(5), "{text}");
        assert!(text.contains(cause), "{text}");
        assert!(text.contains("Next seatrial report "), "{text}");
    }
    // Models of another steering are no models for gains.
    let folder = Folder::new();
    rehearsed(&folder, "bad_rudder");
    let gains =
        folder.command(&["gains", "--logbook", "seatrial.db", "--campaign", "1"]).output().unwrap();
    let text = String::from_utf8(gains.stdout).unwrap();
    assert_eq!(gains.status.code(), Some(4), "{text}");
    assert!(text.starts_with("DO NOT USE: "), "{text}");
    assert!(!text.contains("--export"), "{text}");
}

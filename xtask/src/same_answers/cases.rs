//! The commands whose answers are recorded.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use crate::shell::{files, shell};

const LOG_EXTENSIONS: [&str; 7] = ["csv", "BIN", "tlog", "ulg", "raw", "all", "dbd"];

/// Logs of `--quick`: one of each format and of each kind of answer.
const QUICK_LOGS: [&str; 9] = [
    "simulated/remus100_80_native_n0p3_c0p3.csv",
    "simulated/first_order_80_s0p5_h0p7.csv",
    "firmware/a2_1.csv",
    "real/fuzhou_zz.csv",
    "real/hakusan_ship.csv",
    "native/ardupilot/ardusub_small.BIN",
    "native/ardupilot/rover_json_physics.tlog",
    "native/px4/vtol_cubeorange.ulg",
    "native/slocum/amadeus-2014-204-05-000.dbd",
];

/// The ArduRover log's passes: the file beside it has the epochs in the autopilot's time, these are seconds of the log.
const ROVER_LOG: &str = "native/ardupilot/rover_json_physics.tlog";
const ROVER_WINDOWS: [[&str; 4]; 2] =
    [["86.6", "97", "100.6", "110"], ["125.6", "136", "139.6", "150"]];

const SCENARIOS: [&str; 12] = [
    "bad_compass",
    "bad_link",
    "bad_rudder",
    "broken_fin",
    "frozen_compass",
    "gremlins",
    "payload_swap",
    "poor_compass",
    "rough_sea",
    "shoal",
    "takeover",
    "tidal_stream",
];

/// Commands that run one after the other in one folder: the name of each document, and the words that make it. `DATA` stands for the
/// folder of the data, `ROOT` for that of the project.
pub type Case = Vec<(String, String)>;

/// Every case, or the quick ones.
pub fn all(data: &Path, quick: bool) -> Result<Vec<Case>> {
    let firmware = serde_json::from_str(&shell().read_file(data.join("firmware/truth.json"))?)?;
    let mut cases = trials(quick);
    for suffix in LOG_EXTENSIONS {
        for path in files(data, suffix)? {
            let log = path.strip_prefix(data)?.to_string_lossy();
            let is_wanted = !quick || QUICK_LOGS.contains(&&*log);
            if is_wanted && !log.ends_with(".marks.csv") {
                cases.extend(of_log(&log, &firmware, quick));
            }
        }
    }
    Ok(cases)
}

/// The options for each pair of training and validation windows that the data come with.
fn windows_of(log: &str, firmware: &Value) -> Vec<String> {
    let options = |[a, b, c, d]: [&str; 4]| {
        format!(" --from {a} --to {b} --validate-from {c} --validate-to {d}")
    };
    match log.split_once('/') {
        Some(("simulated", name)) if name.starts_with("first_order") => {
            vec![options(["10", "26.5", "26.5", "43"])]
        }
        Some(("simulated", _)) => vec![options(["40", "56.5", "56.5", "73"])],
        Some(("firmware", name)) => {
            let mut runs = firmware.as_array().into_iter().flatten();
            let run = runs.find(|run| run["file"] == name);
            let edges = run.map(|run| {
                [&run["train"][0], &run["train"][1], &run["validate"][0], &run["validate"][1]]
            });
            let edges = edges.map(|edges| edges.map(Value::to_string));
            edges.iter().map(|edges| options(edges.each_ref().map(String::as_str))).collect()
        }
        _ if log == ROVER_LOG => {
            ROVER_WINDOWS.map(|edges| options(edges) + " --rudder-range-deg 35").into()
        }
        _ => Vec::new(),
    }
}

fn of_log(log: &str, firmware: &Value, quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |verb: &str, label: &str, options: &str| {
        cases.push(vec![(
            format!("{log}/{verb}{label}"),
            format!("{verb} DATA/{log} --json{options}"),
        )]);
    };
    add("identify", "", "");
    if !quick {
        add("compare", "", "");
    }
    for (number, options) in (1..).zip(windows_of(log, firmware)) {
        let label = format!("-window{number}");
        add("identify", &label, &options);
        add("compare", &label, &options);
        for more in ["--as-paper", "--online=least-squares"] {
            if !quick {
                add("identify", &format!("{label}{more}"), &format!("{options} {more}"));
            }
        }
    }
    cases
}

/// Trials with their own logbooks and, but for most of the first, their replays.
fn trials(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |vehicle: &str, label: &str, seed: u32, options: &str| {
        let name = format!("trial/{vehicle}{label}-{seed:02}");
        let trial = format!("trial --json --seed {seed} --logbook trial.db{options}");
        let mut case = vec![(format!("{name}/trial"), trial)];
        if !options.is_empty() || seed == 1 || seed.is_multiple_of(10) {
            case.push((format!("{name}/replay"), "replay trial.db --json".into()));
        }
        cases.push(case);
    };
    for seed in 1..=if quick { 3 } else { 50 } {
        add("starfish", "", seed, "");
    }
    for seed in 1..=if quick { 1 } else { 3 } {
        for vehicle in ["starfish-6dof", "remus100"] {
            add(vehicle, "", seed, &format!(" --vehicle sim:{vehicle}"));
            add(vehicle, "-pitch", seed, &format!(" --axis pitch --vehicle sim:{vehicle}"));
        }
        add("starfish", "-stop-when", seed, " --stop-when a22:10%,b2:5%");
    }
    for scenario in &SCENARIOS[..if quick { 3 } else { SCENARIOS.len() }] {
        let file = format!("ROOT/crates/seatrial-sim/scenarios/{scenario}.toml");
        let options = format!(" --vehicle sim:starfish-6dof --scenario {file}");
        add("starfish-6dof", &format!("-{scenario}"), 1, &options);
    }
    cases
}

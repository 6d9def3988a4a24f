//! The commands whose answers are recorded.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use crate::shell::{files, shell};
use crate::workspace::root;

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
const ROVER_WINDOWS: [[&str; 4]; 2] = [
    ["86.6", "97", "100.6", "110"],
    ["125.6", "136", "139.6", "150"],
];

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

/// Commands that run one after the other in one folder: the name of each document and the arguments that make it.
pub type Case = Vec<(String, Vec<String>)>;

/// Every case, or the quick ones.
pub fn all(data: &Path, quick: bool) -> Result<Vec<Case>> {
    let windows = serde_json::from_str(&shell().read_file(data.join("firmware/truth.json"))?)?;
    let mut cases = Vec::new();
    for path in files(data)? {
        let log = path.strip_prefix(data)?.to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let is_log = LOG_EXTENSIONS.contains(&&*extension) && !log.ends_with(".marks.csv");
        if is_log && (!quick || QUICK_LOGS.contains(&&*log)) {
            cases.extend(of_log(&path, &log, &windows_of(&log, &windows), quick));
        }
    }
    cases.extend(trials(quick));
    Ok(cases)
}

/// Training and validation windows that the data come with: start and end of training, start and end of validation.
fn windows_of(log: &str, firmware: &Value) -> Vec<[String; 4]> {
    let given: &[[&str; 4]] = match log.split_once('/') {
        Some(("simulated", name)) if name.starts_with("first_order") => {
            &[["10", "26.5", "26.5", "43"]]
        }
        Some(("simulated", _)) => &[["40", "56.5", "56.5", "73"]],
        Some(("firmware", name)) => {
            let runs = firmware.as_array().into_iter().flatten();
            let run = runs.filter(|run| run["file"] == name).take(1);
            let edges = |run: &Value| {
                let edge = |stage: &str, at: usize| run[stage][at].to_string();
                [
                    edge("train", 0),
                    edge("train", 1),
                    edge("validate", 0),
                    edge("validate", 1),
                ]
            };
            return run.map(edges).collect();
        }
        _ if log == ROVER_LOG => &ROVER_WINDOWS,
        _ => &[],
    };
    given
        .iter()
        .map(|windows| windows.map(str::to_owned))
        .collect()
}

fn of_log(path: &Path, log: &str, windows: &[[String; 4]], quick: bool) -> Vec<Case> {
    let path = path.to_string_lossy().into_owned();
    let case = |verb: &str, label: &str, options: &[&str]| {
        let arguments = [&[verb, path.as_str(), "--json"], options].concat();
        vec![(format!("{log}/{verb}{label}"), owned(&arguments))]
    };
    let mut cases = vec![case("identify", "", &[])];
    if !quick {
        cases.push(case("compare", "", &[]));
    }
    for (number, [from, to, validate_from, validate_to]) in (1..).zip(windows) {
        let mut options = vec!["--from", from, "--to", to];
        options.extend([
            "--validate-from",
            validate_from,
            "--validate-to",
            validate_to,
        ]);
        if log == ROVER_LOG {
            options.extend(["--rudder-range-deg", "35"]);
        }
        let label = format!("-window{number}");
        cases.push(case("identify", &label, &options));
        cases.push(case("compare", &label, &options));
        for more in ["--as-paper", "--online=least-squares"]
            .into_iter()
            .filter(|_| !quick)
        {
            let options = [&options[..], &[more]].concat();
            cases.push(case("identify", &format!("{label}{more}"), &options));
        }
    }
    cases
}

fn trials(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let (last, last_of_others, scenarios) = if quick {
        (3, 1, 3)
    } else {
        (50, 3, SCENARIOS.len())
    };
    for seed in 1..=last {
        cases.push(trial(
            "starfish",
            "",
            seed,
            seed == 1 || seed % 10 == 0,
            &[],
        ));
    }
    for seed in 1..=last_of_others {
        for vehicle in ["starfish-6dof", "remus100"] {
            let name = format!("sim:{vehicle}");
            cases.push(trial(vehicle, "", seed, true, &["--vehicle", &name]));
            let pitch = ["--axis", "pitch", "--vehicle", &name];
            cases.push(trial(vehicle, "-pitch", seed, true, &pitch));
        }
        let narrow = ["--stop-when", "a22:10%,b2:5%"];
        cases.push(trial("starfish", "-stop-when", seed, true, &narrow));
    }
    for scenario in &SCENARIOS[..scenarios] {
        let file = root().join(format!("crates/seatrial-sim/scenarios/{scenario}.toml"));
        let options = [
            "--vehicle",
            "sim:starfish-6dof",
            "--scenario",
            &file.to_string_lossy(),
        ];
        cases.push(trial(
            "starfish-6dof",
            &format!("-{scenario}"),
            1,
            true,
            &options,
        ));
    }
    cases
}

/// A trial with its own logbook and, where asked for, its replay.
fn trial(vehicle: &str, label: &str, seed: u32, is_replayed: bool, options: &[&str]) -> Case {
    let name = format!("trial/{vehicle}{label}-{seed:02}");
    let number = seed.to_string();
    let fixed = [
        "trial",
        "--json",
        "--seed",
        &number,
        "--logbook",
        "trial.db",
    ];
    let mut case = vec![(format!("{name}/trial"), owned(&[&fixed, options].concat()))];
    if is_replayed {
        case.push((
            format!("{name}/replay"),
            owned(&["replay", "trial.db", "--json"]),
        ));
    }
    case
}

fn owned(arguments: &[&str]) -> Vec<String> {
    arguments
        .iter()
        .map(|&argument| argument.to_owned())
        .collect()
}

//! The commands whose answers are recorded.

use std::path::Path;

use serde_json::Value;

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

/// Commands that run one after the other in one folder.
pub struct Case {
    /// The name of each document and the arguments that make it.
    pub commands: Vec<(String, Vec<String>)>,
}

impl Case {
    fn one(name: String, arguments: Vec<String>) -> Self {
        Self {
            commands: vec![(name, arguments)],
        }
    }
}

/// Every case, or the quick ones.
pub fn all(data: &Path, quick: bool) -> Result<Vec<Case>, String> {
    let mut logs = Vec::new();
    find_logs(data, data, &mut logs)?;
    logs.sort();
    if quick {
        logs.retain(|log| QUICK_LOGS.contains(&log.as_str()));
    }
    let windows = Windows::read(data)?;
    let mut cases: Vec<Case> = logs
        .iter()
        .flat_map(|log| of_log(data, log, &windows, quick))
        .collect();
    cases.extend(trials(quick)?);
    Ok(cases)
}

fn find_logs(root: &Path, folder: &Path, logs: &mut Vec<String>) -> Result<(), String> {
    let failed = |error| format!("{}: {error}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            find_logs(root, &path, logs)?;
            continue;
        }
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        if LOG_EXTENSIONS.contains(&&*extension) && !name.ends_with(".marks.csv") {
            logs.push(name.into_owned());
        }
    }
    Ok(())
}

/// Training and validation windows that the data come with.
struct Windows {
    firmware: Value,
}

impl Windows {
    fn read(data: &Path) -> Result<Self, String> {
        let path = data.join("firmware/truth.json");
        let said = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = std::fs::read(&path).map_err(|error| said(&error))?;
        let firmware = serde_json::from_slice(&text).map_err(|error| said(&error))?;
        Ok(Self { firmware })
    }

    /// Start and end of training, start and end of validation.
    fn of(&self, log: &str) -> Vec<[String; 4]> {
        let owned = |windows: [&str; 4]| windows.map(str::to_owned);
        match log.split_once('/') {
            Some(("simulated", name)) if name.starts_with("first_order") => {
                vec![owned(["10", "26.5", "26.5", "43"])]
            }
            Some(("simulated", _)) => vec![owned(["40", "56.5", "56.5", "73"])],
            Some(("firmware", name)) => {
                let runs = self.firmware.as_array().into_iter().flatten();
                let run = runs.into_iter().find(|run| run["file"] == name);
                let edge = |run: &Value, stage: &str, at: usize| run[stage][at].to_string();
                let windows = |run| {
                    ["train", "validate"].map(|stage| [edge(run, stage, 0), edge(run, stage, 1)])
                };
                run.map(windows)
                    .map(|[[a, b], [c, d]]| [a, b, c, d])
                    .into_iter()
                    .collect()
            }
            _ if log == ROVER_LOG => ROVER_WINDOWS.map(owned).into(),
            _ => Vec::new(),
        }
    }
}

fn of_log(data: &Path, log: &str, windows: &Windows, quick: bool) -> Vec<Case> {
    let path = data.join(log).to_string_lossy().into_owned();
    let case = |verb: &str, label: &str, options: &[&str]| {
        let arguments = [&[verb, path.as_str(), "--json"], options].concat();
        let arguments = arguments.into_iter().map(str::to_owned).collect();
        Case::one(format!("{log}/{verb}{label}"), arguments)
    };
    let mut cases = vec![case("identify", "", &[])];
    if !quick {
        cases.push(case("compare", "", &[]));
    }
    for (index, window) in windows.of(log).iter().enumerate() {
        let names = ["--from", "--to", "--validate-from", "--validate-to"];
        let mut options: Vec<&str> = names
            .into_iter()
            .zip(window)
            .flat_map(|(name, value)| [name, value.as_str()])
            .collect();
        if log == ROVER_LOG {
            options.extend(["--rudder-range-deg", "35"]);
        }
        let label = format!("-window{}", index + 1);
        cases.push(case("identify", &label, &options));
        cases.push(case("compare", &label, &options));
        if !quick {
            let with = |more: &[&str]| {
                let options = [&options[..], more].concat();
                case("identify", &format!("{label}{}", more.concat()), &options)
            };
            cases.push(with(&["--as-paper"]));
            cases.push(with(&["--online=least-squares"]));
        }
    }
    cases
}

fn trials(quick: bool) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    let last = if quick { 3 } else { 50 };
    for seed in 1..=last {
        let is_replayed = seed == 1 || seed % 10 == 0;
        cases.push(trial("starfish", "", seed, is_replayed, &[]));
    }
    let seeds = if quick { 1..=1 } else { 1..=3 };
    for seed in seeds {
        for vehicle in ["starfish-6dof", "remus100"] {
            let name = format!("sim:{vehicle}");
            cases.push(trial(vehicle, "", seed, true, &["--vehicle", &name]));
            let pitch = ["--axis", "pitch", "--vehicle", &name];
            cases.push(trial(vehicle, "-pitch", seed, true, &pitch));
        }
        let narrow = ["--stop-when", "a22:10%,b2:5%"];
        cases.push(trial("starfish", "-stop-when", seed, true, &narrow));
    }
    let scenarios = if quick { &SCENARIOS[..3] } else { &SCENARIOS };
    for scenario in scenarios {
        let file = std::path::absolute(format!("crates/seatrial-sim/scenarios/{scenario}.toml"));
        let file = file.map_err(|error| error.to_string())?;
        let file = file.to_string_lossy();
        let options = ["--vehicle", "sim:starfish-6dof", "--scenario", &file];
        let label = format!("-{scenario}");
        cases.push(trial("starfish-6dof", &label, 1, true, &options));
    }
    Ok(cases)
}

/// A trial with its own logbook and, where asked for, its replay.
fn trial(vehicle: &str, label: &str, seed: u32, is_replayed: bool, options: &[&str]) -> Case {
    let owned = |arguments: &[&str]| arguments.iter().map(|&a| a.to_owned()).collect();
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
    let mut case = Case::one(format!("{name}/trial"), owned(&[&fixed, options].concat()));
    if is_replayed {
        let arguments = owned(&["replay", "trial.db", "--json"]);
        case.commands.push((format!("{name}/replay"), arguments));
    }
    case
}

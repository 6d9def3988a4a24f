//! What a log and a campaign end in: gains, turning limits, files and the report, as in the terminal.

use std::path::Path;
use std::process::Output;

use seatrial_dev::program;
use serde_json::{Value, json};

use super::server::Server;

fn seatrial(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = program();
    command.args(arguments).current_dir(folder);
    command.output().unwrap()
}

fn json_of(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Every file of a model that is a text, and the command that writes it.
const FILES: [(&str, &[&str]); 8] = [
    ("ardupilot_surface", &["gains", "--export", "ardupilot"]),
    ("ardupilot_underwater", &["gains", "--export", "ardupilot", "--vehicle-type", "underwater"]),
    ("px4_surface", &["gains", "--export", "px4"]),
    ("ros2", &["gains", "--export", "ros2"]),
    ("c", &["gains", "--export", "c"]),
    ("vehicle", &["export", "--to", "vehicle"]),
    ("nav2", &["export", "--to", "nav2"]),
    ("ros2_control", &["export", "--to", "ros2_control"]),
];

#[test]
fn cli_a_log_ends_in_the_terminals_gains_limits_files_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let in_folder = |arguments: &[&str]| seatrial(folder.path(), arguments);
    in_folder(&["sim", "log", "--seed", "1", "--out", "run.csv"]);
    let identified = in_folder(&["identify", "run.csv", "--json"]).stdout;
    std::fs::write(folder.path().join("run.json"), &identified).unwrap();
    let server = Server::start(folder.path(), &[]);
    let log = std::fs::read(folder.path().join("run.csv")).unwrap();
    let identify = server.ask("POST", "/logs/identify?name=run.csv");
    let (status, found) = identify.bytes(log.clone()).send();
    assert_eq!(status, 200, "{found}");

    let order = json!({"origin": "run.json", "document": found["document"]});
    let (status, limits) = server.ask("POST", "/models/limits").json(&order).send();
    assert_eq!(status, 200, "{limits}");
    let model = |verb: &[&str]| in_folder(&[verb, &["--model", "run.json"]].concat());
    assert_eq!(limits["gains"], json_of(&model(&["gains", "--json"])));
    assert_eq!(limits["turning"], json_of(&model(&["turn", "--json"])));
    assert_eq!(limits["unusable"], Value::Null);
    for (name, verb) in FILES {
        let path = format!("/models/files/{name}");
        let (status, file) = server.ask("POST", &path).json(&order).send_for_bytes();
        let file = String::from_utf8(file).unwrap();
        assert_eq!(status, 200, "{name}: {file}");
        let printed = String::from_utf8(model(verb).stdout).unwrap();
        assert_eq!(file, printed, "{name}");
    }
    let report = server.ask("POST", "/logs/report?name=run.csv");
    let (status, page) = report.bytes(log).send_for_bytes();
    in_folder(&["report", "run.csv", "--out", "run.html"]);
    let same = std::fs::read(folder.path().join("run.html")).unwrap();
    assert!(status == 200 && page == same);
}

#[test]
fn cli_a_model_that_is_warned_of_is_written_where_that_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let in_folder = |arguments: &[&str]| seatrial(folder.path(), arguments);
    in_folder(&["sim", "log", "--seed", "1", "--out", "run.csv"]);
    // One doublet: nothing validates it.
    let training = ["identify", "run.csv", "--from", "0", "--to", "28", "--json"];
    let document = json_of(&in_folder(&training));
    std::fs::write(folder.path().join("run.json"), document.to_string()).unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut order = json!({"origin": "run.json", "document": document});
    let file = |order: &Value| {
        let file = server.ask("POST", "/models/files/ardupilot_surface");
        file.json(order).send_for_bytes()
    };
    let (status, refused) = file(&order);
    let refused: Value = serde_json::from_slice(&refused).unwrap();
    assert_eq!((status, &refused["code"]), (422, &json!("gain_warned_of")));
    let export = ["gains", "--model", "run.json", "--export", "ardupilot"];
    let terminal = in_folder(&export);
    let said = String::from_utf8(terminal.stderr).unwrap();
    let words = refused["message"].as_str().unwrap();
    assert!(said.contains(words), "{said} holds {words}");
    assert!(terminal.stdout.is_empty());
    let (_, limits) = server.ask("POST", "/models/limits").json(&order).send();
    assert_eq!(limits["unusable"], refused["message"]);

    order["stated"] = json!({"accept": true});
    let (status, written) = file(&order);
    assert_eq!(status, 200);
    let accepted = in_folder(&[&export[..], &["--accept"]].concat());
    assert_eq!(written, accepted.stdout);
}

/// Live tells a trial that is over by the verdict of its campaign, as History does.
#[test]
fn cli_live_and_history_judge_a_campaign_alike() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    for (campaign, scenario, outcome) in [
        (1, "broken_fin", "do_not_use"),
        (2, "bad_compass", "do_not_use"),
        (3, "heavier_payload", "use"),
    ] {
        let order = json!({"vehicle": "sim:starfish", "seed": 1, "scenario": scenario});
        server.start_trial(&lease, &order);
        let live = server.wait_for_end();
        let kept = server.get(&format!("/campaigns/{campaign}"));
        assert_eq!(live["verdict"]["outcome"], outcome, "{scenario}");
        assert_eq!(live["verdict"], kept["verdict"], "{scenario}");
        assert_eq!(live["runs"], kept["runs"], "{scenario}");
        // The list says it, too, and the campaign every reason that its verdict counts.
        let listed = server.get("/campaigns")[campaign - 1].clone();
        assert_eq!(listed["verdict"], outcome, "{scenario}");
        let others = kept["verdict"]["other_causes"].as_u64().unwrap() as usize;
        assert!(kept["reasons"].as_array().unwrap().len() > others, "{kept}");
    }
}

#[test]
fn cli_a_campaign_ends_in_the_terminals_limits_and_vehicle_file() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    let vehicles = server.get("/vehicles");
    let scenarios = vehicles["scenarios"].as_array().unwrap();
    assert!(scenarios.iter().any(|one| one["name"] == "heavier_payload"));
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = json!([0.6, 0.9]);
    let mut order = json!({"vehicle": "sim:starfish", "seed": 1, "plan": plan,
        "scenario": "/etc/passwd"});
    let (status, refused) = server.ask("POST", "/trial").lease(&lease).json(&order).send();
    assert_eq!((status, &refused["code"]), (422, &json!("unknown_scenario")));
    order["scenario"] = json!("heavier_payload");
    assert_eq!(server.start_trial(&lease, &order), 1);
    assert_eq!(server.wait_for_end()["outcome"]["finished"], true);
    let shown = seatrial(folder.path(), &["logbook", "1", "--json"]);
    assert!(String::from_utf8(shown.stdout).unwrap().contains("heavier_payload"));

    let track = |options: &[&str]| {
        let export = ["logbook", "export", "1", "--out", "track.gpx"];
        seatrial(folder.path(), &[&export[..], options].concat())
    };
    let refused = track(&[]);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--origin LAT,LON"));
    assert!(track(&["--origin", "-54.33,10.15"]).status.success());
    let gpx = std::fs::read_to_string(folder.path().join("track.gpx")).unwrap();
    // Two speeds of 45 s, a point a second.
    assert!((80..110).contains(&gpx.matches("<time>20").count()), "{gpx}");
    assert!(gpx.contains("lat=\"-54.3") && gpx.contains("lon=\"10.1"), "{gpx}");

    let limits = server.get("/campaigns/1/limits");
    let terminal =
        |verb: &[&str]| seatrial(folder.path(), &[verb, &["--logbook", "seatrial.db"]].concat());
    let of_source = |mut document: Value| {
        // The server calls its logbook by its whole path.
        document["source"] = Value::Null;
        document
    };
    let gains = json_of(&terminal(&["gains", "--json"]));
    assert_eq!(of_source(limits["gains"].clone()), of_source(gains));
    let turning = json_of(&terminal(&["turn", "--json"]));
    assert_eq!(of_source(limits["turning"].clone()), of_source(turning));
    let (status, vehicle) = server.ask("GET", "/campaigns/1/files/vehicle").send_for_bytes();
    let vehicle = String::from_utf8(vehicle).unwrap();
    assert_eq!(status, 200, "{vehicle}");
    let printed = String::from_utf8(terminal(&["export", "--to", "vehicle"]).stdout).unwrap();
    let numbers = |text: &str| {
        let lines = text.lines().filter(|line| !line.starts_with("source"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(numbers(&vehicle), numbers(&printed));
    let param = |query: &str| {
        let path = format!("/campaigns/1/files/ardupilot_surface{query}");
        server.ask("GET", &path).send_for_bytes()
    };
    let (status, refused) = param("");
    let refused: Value = serde_json::from_slice(&refused).unwrap();
    assert_eq!((status, &refused["code"]), (422, &json!("rehearsal")));
    assert_eq!(param("?rehearsal=true").0, 200);
}

//! `seatrial serve` and `trial --serve` at the process boundary, over trials on the simulator.

mod blueos;
mod broken_off;
mod commission;
mod logs;
mod mavlink;
mod models;
pub mod server;
mod slow;
mod soak;
mod stalled;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use seatrial_dev::{program, python_with};
use serde_json::{Value, json};
use server::Server;

fn starfish(seed: u64) -> Value {
    json!({"vehicle": "sim:starfish", "seed": seed})
}

fn kind(message: &Value) -> &str {
    message["type"].as_str().unwrap()
}

/// Two trials, watched and looked up.
#[test]
fn cli_trials_are_started_watched_compared_and_downloaded() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut viewer = server.viewer(&json!({}));
    let snapshot = viewer.next();
    assert_eq!(kind(&snapshot), "snapshot");
    assert_eq!(snapshot["trial"], Value::Null);

    let lease = server.control("Anna");
    let order =
        json!({"vehicle": "sim:starfish", "seed": 1, "configuration": "clean", "note": "calm"});
    assert_eq!(server.start_trial(&lease, &order), 1);
    let seen = viewer.until(|message| kind(message) == "trial_ended");
    let count = |wanted: &str| seen.iter().filter(|message| kind(message) == wanted).count();
    assert_eq!(count("control"), 1);
    assert_eq!(count("trial_started"), 1);
    let ended: Vec<&Value> = seen.iter().filter(|message| kind(message) == "run_ended").collect();
    assert!(ended.len() >= 5, "{}", ended.len());
    assert_eq!(count("stage_started"), 3 * ended.len());
    let run = &ended[0]["run"];
    assert!(run["model"]["a22_per_s"]["interval_95"][0].is_number(), "{run}");
    assert!(ended[0]["validation"]["time_s"].as_array().unwrap().len() > 100);
    let numbers: Vec<u64> = seen
        .iter()
        .filter(|message| kind(message) != "heartbeat")
        .map(|message| message["sequence"].as_u64().unwrap())
        .collect();
    assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "{numbers:?}");
    let samples = || {
        seen.iter().filter(|m| kind(m) == "samples").flat_map(|m| m["samples"].as_array().unwrap())
    };
    assert!(samples().count() > 1000);
    assert!(samples().any(|sample| sample["simulated_heading_rad"].is_number()));
    assert_eq!(seen.last().unwrap()["outcome"]["finished"], true);
    server.wait_for_end();

    let order = json!({"vehicle": "sim:starfish", "seed": 2, "configuration": "payload"});
    assert_eq!(server.start_trial(&lease, &order), 2);
    server.wait_for_end();
    let campaigns = server.get("/campaigns");
    assert_eq!(campaigns[0]["notes"], "calm");
    assert_eq!(campaigns[1]["state"], "finished");
    let compared = server.get("/compare?a=1&b=2");
    assert_eq!(compared["thrusts"].as_array().unwrap().len(), 5);
    assert_eq!(compared["thrusts"][0]["differences"].as_array().unwrap().len(), 7);
    assert!(compared["what_changed"]["reasons"][0]["text"].is_string());
    let schedule = server.get("/campaigns/1/schedule?speed_m_s=1.3");
    assert!(schedule["at"]["proportional_gain"]["value"].as_f64().unwrap() > 0.0, "{schedule}");
    assert!(schedule["points"][0]["point"]["steady_turning_radius_m"][0]["interval_95"].is_array());
    let series = server.get("/campaigns/1/runs/1/series");
    assert!(series["simulated_heading_rad"].as_array().unwrap().iter().any(Value::is_number));

    let download = |name: &str| {
        let (status, file) = server.ask("GET", &format!("/campaigns/1/{name}")).send_for_bytes();
        assert_eq!(status, 200, "{name}");
        file
    };
    let report = download("report.html");
    assert!(report.trim_ascii_start().starts_with(b"<!DOCTYPE html>"));
    assert!(download("samples.csv").starts_with(b"time_s,heading_rad,rudder_rad"));
    assert!(download("samples.mcap").starts_with(b"\x89MCAP"));
    assert!(
        String::from_utf8(download("gains.param?rehearsal=true")).unwrap().contains("ATC_STR_RAT_")
    );

    // The operator's word goes before the verdict, and one speed is run again.
    let review = json!({"accepted": false, "note": "a ferry passed"});
    let (status, run) =
        server.ask("POST", "/campaigns/1/runs/1/review").lease(&lease).json(&review).send();
    assert_eq!(status, 200, "{run}");
    assert_eq!((&run["accepted"], &run["review"]["by"]), (&json!(false), &json!("Anna")));
    let detail = server.get("/campaigns/1");
    assert!(!detail["counting_runs"].as_array().unwrap().contains(&json!(1)));
    let again = json!({"campaign": 1, "thrust": 0.6});
    let (status, trial) = server.ask("POST", "/trial/repeat").lease(&lease).json(&again).send();
    assert_eq!(
        (status, &trial["seed"], &trial["configuration"]),
        (201, &json!(2), &json!("clean")),
        "{trial}"
    );
    assert_eq!(server.wait_for_end()["runs"].as_array().unwrap().len(), 1);

    let audit = server.get("/audit");
    let commands: Vec<&str> =
        audit.as_array().unwrap().iter().map(|c| c["command"].as_str().unwrap()).collect();
    assert_eq!(
        commands,
        [
            "repeat_speed",
            "conduct_trial",
            "review_run",
            "start_trial",
            "conduct_trial",
            "start_trial",
            "conduct_trial",
            "take_control"
        ]
    );
    assert_eq!(audit[0]["actor"], "Anna");
    assert_eq!(server.interrupt(), Some(0));
}

#[test]
fn cli_abort_in_mid_doublet() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    let mut viewer = server.viewer(&json!({"lease": lease}));
    let mut order = starfish(1);
    order["realtime_factor"] = json!(10);
    server.start_trial(&lease, &order);
    viewer.until(|message| {
        let samples = message["samples"].as_array();
        samples.is_some_and(|samples| {
            let is_doublet =
                |s: &Value| s["stage"] == "train" && s["rudder_rad"].as_f64().unwrap().abs() > 0.2;
            kind(message) == "samples" && samples.iter().any(is_doublet)
        })
    });
    // Also who has no control may.
    let (status, trial) = server.ask("POST", "/trial/abort").send();
    assert_eq!(status, 202, "{trial}");
    let seen = viewer.until(|message| kind(message) == "trial_ended");
    assert_eq!(seen.last().unwrap()["outcome"]["reason"], "operator");
    assert_eq!(server.wait_for_end()["outcome"]["finished"], false);
    assert_eq!(server.get("/campaigns")[0]["state"], "aborted");
    let (status, refused) = server.ask("POST", "/trial/abort").send();
    assert_eq!((status, &refused["code"]), (409, &json!("no_trial")));
    let results = || -> Vec<Value> {
        let audit = server.get("/audit");
        let entries = audit.as_array().unwrap().iter();
        entries.map(|entry| entry["result"].clone()).collect()
    };
    // An abort is answered before its entry is on the disk.
    let begun = Instant::now();
    while results().len() < 5 && begun.elapsed() < Duration::from_secs(10) {
        thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(results(), ["no_trial", "done", "done", "done", "done"]);
}

#[test]
fn cli_only_who_may_does() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--require-token", "--host", "boat.local"]);
    let [operator, viewer] = [server.tokens[0].clone(), server.tokens[1].clone()];
    let code =
        |(status, body): (u16, Value)| (status, body["code"].as_str().unwrap_or("").to_owned());
    let is = |status: u16, code: &str| (status, code.to_owned());
    let ask = |token: Option<&str>, server: &mut Server, method: &str, path: &str| {
        server.token = token.map(String::from);
        server.ask(method, path).json(&json!({"name": "Eve"})).send()
    };
    assert_eq!(code(ask(None, &mut server, "GET", "/status")), is(401, "token_needed"));
    assert_eq!(code(ask(Some("guess"), &mut server, "GET", "/status")), is(401, "token_needed"));
    assert_eq!(ask(Some(&viewer), &mut server, "GET", "/status").1["role"], "viewer");
    assert_eq!(
        code(ask(Some(&viewer), &mut server, "POST", "/control")),
        is(403, "operators_only")
    );
    assert_eq!(
        code(ask(Some(&viewer), &mut server, "POST", "/trial/abort")),
        is(403, "operators_only")
    );

    // A page of another site, and one whose name was made to resolve to us.
    server.token = Some(operator.clone());
    let post = || server.ask("POST", "/control").json(&json!({"name": "Anna"}));
    assert_eq!(
        code(post().header("Origin", "http://evil.example").send()),
        is(403, "origin_refused")
    );
    assert_eq!(code(post().host("evil.example").send()), is(403, "host_refused"));
    let own = post().host("boat.local:80").header("Origin", "http://boat.local:80").send();
    assert_eq!(own.0, 200, "{}", own.1);
    // The second operator is told who has control.
    let (status, taken) = server.ask("POST", "/control").json(&json!({"name": "Ben"})).send();
    assert_eq!(status, 409);
    assert!(taken["message"].as_str().unwrap().starts_with("Anna has control since"), "{taken}");
    assert_eq!(
        code(server.ask("POST", "/trial").json(&starfish(1)).send()),
        is(409, "control_taken")
    );
    let audit = server.get("/audit");
    assert_eq!(audit[0]["result"], "control_taken");
    assert_eq!(audit[0]["address"], "127.0.0.1");

    // The live stream: the token comes with the first message, never in the address.
    for (hello, first) in [
        (json!({}), "goodbye"),
        (json!({"token": "guess"}), "goodbye"),
        (json!({"token": viewer}), "snapshot"),
    ] {
        assert_eq!(kind(&server.viewer(&hello).next()), first, "{hello}");
    }
    let upgrade = server.ask("GET", "/live").header("Origin", "http://evil.example").send();
    assert_eq!(code(upgrade), is(403, "origin_refused"));
    // Kept as hashes.
    let kept = std::fs::read_to_string(folder.path().join("seatrial.tokens.json")).unwrap();
    assert!(!kept.contains(&operator) && !kept.contains(&viewer));
}

#[test]
fn cli_nonsense_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    for (method, path, body, status, code) in [
        ("GET", "/nowhere", json!(null), 404, "not_found"),
        ("PUT", "/status", json!(null), 405, "method_not_allowed"),
        ("GET", "/campaigns/7", json!(null), 404, "not_found"),
        ("GET", "/campaigns/first", json!(null), 404, "not_found"),
        ("GET", "/compare?a=1", json!(null), 422, "not_understood"),
        ("GET", "/live", json!(null), 426, "websocket_expected"),
        ("POST", "/trial", json!({"vehicle": "sim:/etc/passwd"}), 422, "unknown_vehicle"),
        ("POST", "/trial", json!({"vehicle": "sim:starfish", "speed": 9}), 422, "not_understood"),
        (
            "POST",
            "/trial",
            json!({"vehicle": "sim:starfish", "plan": {"thrusts": [2]}}),
            422,
            "plan_refused",
        ),
        (
            "POST",
            "/trial",
            json!({"vehicle": "sim:starfish", "realtime_factor": 0}),
            422,
            "out_of_range",
        ),
        ("POST", "/trial/repeat", json!({"campaign": 9, "thrust": 0.6}), 404, "not_found"),
        (
            "POST",
            "/campaigns/1/runs/1/review",
            json!({"accepted": true, "note": "x"}),
            422,
            "not_reviewable",
        ),
    ] {
        let (found, refused) = server.ask(method, path).lease(&lease).json(&body).send();
        assert_eq!(
            (found, refused["code"].as_str()),
            (status, Some(code)),
            "{method} {path}: {refused}"
        );
    }
    let preview = json!({"vehicle": "sim:starfish"});
    let (status, preview) = server.ask("POST", "/plans/preview").json(&preview).send();
    assert_eq!((status, &preview["is_enough"]), (200, &json!(true)), "{preview}");
    let order = json!({"vehicle": "sim:remus100"});
    let (status, preflight) = server.ask("POST", "/preflight").json(&order).send();
    assert_eq!(
        (status, preflight["checks"].as_array().map(Vec::len)),
        (200, Some(3)),
        "{preflight}"
    );
}

/// A viewer that never reads holds up neither the trial nor who reads, and who comes back gets what he missed.
#[test]
fn cli_slow_viewers_hold_up_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    let slow: Vec<_> = (0..8).map(|_| server.viewer(&json!({}))).collect();
    let mut leaves = server.viewer(&json!({}));
    let snapshot = leaves.next();
    drop(leaves);
    server.start_trial(&lease, &starfish(1));
    let trial = server.wait_for_end();
    assert_eq!(trial["outcome"]["finished"], true);
    assert_eq!(server.get("/status")["health"]["not_shown"], 0);

    let (stream, after) = (&snapshot["stream"], &snapshot["sequence"]);
    let mut back = server.viewer(&json!({"stream": stream, "after": after}));
    let first = back.next();
    assert_eq!(first["sequence"], json!(after.as_u64().unwrap() + 1));
    assert!(["control", "trial_started"].contains(&kind(&first)), "{first}");
    back.until(|message| kind(message) == "trial_ended");
    let mut stranger = server.viewer(&json!({"stream": "another", "after": after}));
    assert_eq!(kind(&stranger.next()), "snapshot");
    drop(slow);
}

#[test]
fn cli_a_trial_of_the_command_line_is_shown_and_aborted() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let mut child = program()
        .args(["trial", "--realtime", "--serve", "127.0.0.1:0", "--logbook"])
        .arg(&logbook)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = said.next().unwrap().unwrap();
    let address = line.split("http://").nth(1).unwrap().trim_end_matches('/').to_owned();
    let mut server = Server { child, address, tokens: Vec::new(), token: None };
    // The dashboard is announced before the vehicle is taken, and shows no trial until then.
    let begun = Instant::now();
    let trial = loop {
        let trial = server.get("/status")["trial"].clone();
        if !trial.is_null() {
            break trial;
        }
        assert!(begun.elapsed() < Duration::from_secs(30));
        thread::sleep(Duration::from_millis(10));
    };
    assert_eq!((&trial["campaign"], &trial["running"]), (&json!(1), &json!(true)));
    server.viewer(&json!({})).until(|message| kind(message) == "samples");
    assert_eq!(server.ask("POST", "/trial/abort").send().0, 202);
    assert_eq!(server.child.wait().unwrap().code(), Some(5));
}

#[test]
fn cli_the_example_in_python_runs() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let example =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples/dashboard_client.py");
    let Some(python) = python_with("urllib.request") else {
        return;
    };
    let run = Command::new(python)
        .arg(example)
        .arg(format!("http://{}/", server.address))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert!(said.lines().count() >= 5 && said.contains("accepted"), "{said}");
}

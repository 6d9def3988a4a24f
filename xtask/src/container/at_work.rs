//! The container's command at work: from the container file, as its user and as process 1, in a root that it cannot write but for
//! `/data`, beside a vehicle that it reaches through a router of MAVLink as on BlueOS.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::router::Router;
use super::sandbox::Sandbox;
use super::{FILE, MEMORY, arguments, instructions};
use crate::environment::NO_PYTHON;
use crate::http::{Client, json as document};
use crate::long_log::long_log;
use crate::steps::skipped;
use crate::target::in_target;
use crate::wheel;

const STATIC: &str = "x86_64-unknown-linux-musl";
/// Largest image, bytes.
const IMAGE: u64 = 25_000_000;
/// A long log of ArduPilot, MB.
const LONG_LOG_MB: &str = "62";
/// The programming interface.
const API: &str = "/api/v1";
const JSON: (&str, &str) = ("Content-Type", "application/json");
/// How much faster than a real one the vehicle is.
const SPEED: &str = "20";
/// Something that a person or BlueOS does.
type Stage = fn(&Client, &[&str]) -> Result<(), String>;

const PATIENCE: Duration = Duration::from_secs(120);
const FOLDER: &str = "container";

/// Runs the command, opens the page and logs, makes a trial over MAVLink, and fails where image or memory are larger than promised.
pub fn check() -> Result<(), String> {
    if !wheel::has_tools() {
        return skipped("the container", NO_PYTHON);
    }
    let binary = wheel::command_for(STATIC)?;
    let text = std::fs::read_to_string(FILE).map_err(|error| format!("{FILE}: {error}"))?;
    let sandbox = Sandbox::made(&in_target(FOLDER), &binary, &text, &user(&text)?)?;
    let image = sandbox.image_bytes()?;
    let words = arguments(&text);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let router = Router::start(after(&words, "--vehicle")?)?;
    let mut vehicle = Command::new(&binary)
        .args(["sim", "mavlink", "--speed", SPEED])
        .args(["--udp", &router.vehicle_side()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("{}: {error}", binary.display()))?;
    let memory = used(&sandbox, &words);
    let _ = vehicle.kill();
    let _ = vehicle.wait();
    let memory = memory?;
    eprintln!("== image of {:.1} MB", image as f64 / 1e6);
    within("image", image, IMAGE)?;
    within("memory", memory, MEMORY)
}

fn within(what: &str, is: u64, may_be: u64) -> Result<(), String> {
    match is <= may_be {
        true => Ok(()),
        false => Err(format!("{what}: {is} bytes, more than {may_be}")),
    }
}

fn user(text: &str) -> Result<String, String> {
    let user = instructions(text, "USER").last().unwrap_or_default();
    let id = user.split(':').next().unwrap_or_default();
    match id.parse::<u32>() {
        Ok(_) => Ok(id.to_owned()),
        Err(_) => Err(format!("{FILE}: USER {user}: expected a number")),
    }
}

/// The word after an option.
fn after<'a>(words: &[&'a str], option: &str) -> Result<&'a str, String> {
    let pair = words.windows(2).find(|pair| pair[0] == option);
    pair.map(|pair| pair[1])
        .ok_or_else(|| format!("{FILE}: the command has no {option}"))
}

/// Works as a person and BlueOS do; the most memory that the command ever had, bytes.
fn used(sandbox: &Sandbox, words: &[&str]) -> Result<u64, String> {
    let mut container = sandbox.run(words)?;
    let (_, port) = after(words, "--listen")?
        .rsplit_once(':')
        .unwrap_or_default();
    let host = format!("{}:{port}", after(words, "--host")?);
    let client = Client {
        address: format!("127.0.0.1:{port}"),
        host,
        token: Some(container.token.clone()),
    };
    let stages: [(&str, Stage); 4] = [
        ("the page and BlueOS", the_page),
        ("a log", a_log),
        ("a long log", a_long_log),
        ("a trial", a_trial),
    ];
    for (name, stage) in stages {
        let begun = Instant::now();
        stage(&client, words).map_err(|error| format!("{name}: {error}\n{}", container.said()))?;
        let most = container.most_memory()?;
        eprintln!(
            "== {name}: {:.1} s, at most {:.1} MiB of memory so far",
            begun.elapsed().as_secs_f64(),
            most as f64 / f64::from(1 << 20)
        );
    }
    let memory = container.most_memory()?;
    container.ends_when_asked()?;
    sandbox.has_written_only_its_data()?;
    Ok(memory)
}

fn the_page(client: &Client, _: &[&str]) -> Result<(), String> {
    let page = client.get("/")?;
    let scripts = page.split("./assets/").skip(1);
    let files: Vec<&str> = scripts.filter_map(|rest| rest.split('"').next()).collect();
    if files.is_empty() {
        return Err("the page names no files".into());
    }
    for file in files {
        client.get(&format!("/assets/{file}"))?;
    }
    let service = client.get("/register_service")?;
    let service = document(&service)?;
    holds(
        service["name"] == "seatrial",
        "BlueOS does not find the service",
        &service,
    )
}

fn a_log(client: &Client, _: &[&str]) -> Result<(), String> {
    let log = std::fs::read("docs/sample/boat.csv").map_err(|error| error.to_string())?;
    let found = client.post(&format!("{API}/logs/identify?name=boat.csv"), &[], &log)?;
    let outcome = &found["document"]["verdict"]["outcome"];
    holds(
        outcome == "use",
        "the sample log has no model to use",
        outcome,
    )
}

fn a_long_log(client: &Client, _: &[&str]) -> Result<(), String> {
    let path = long_log(in_target(FOLDER).join("long.bin"), LONG_LOG_MB)?;
    let log = std::fs::read(path).map_err(|error| error.to_string())?;
    let found = client.post(&format!("{API}/logs/identify?name=long.bin"), &[], &log)?;
    let source = &found["document"]["source"];
    let read = source["samples_read"].as_u64().unwrap_or(0);
    holds(read > 10_000, "the long log was not read", source)
}

/// One speed on the vehicle that the command names.
fn a_trial(client: &Client, words: &[&str]) -> Result<(), String> {
    let post = |path: &str, lease: &str, body: Value| {
        let headers = [JSON, ("seatrial-lease", lease)];
        client.post(
            &format!("{API}{path}"),
            &headers,
            body.to_string().as_bytes(),
        )
    };
    let lease = post("/control", "", json!({"name": "container"}))?;
    let lease = lease["lease"].as_str().unwrap_or_default();
    let mut plan = document(&client.get(&format!("{API}/plans/default"))?)?;
    plan["thrusts"] = json!([0.6]);
    let order = json!({"vehicle": after(words, "--vehicle")?, "plan": plan, "agreed": true});
    post("/trial", lease, order)?;
    let begun = Instant::now();
    let trial = loop {
        let trial = document(&client.get(&format!("{API}/status"))?)?["trial"].clone();
        if trial["running"] == false {
            break trial;
        }
        if begun.elapsed() > PATIENCE {
            return Err(format!("it does not end: {trial}"));
        }
        std::thread::sleep(Duration::from_millis(200));
    };
    holds(
        trial["outcome"]["finished"] == true,
        "it was not finished",
        &trial,
    )?;
    let report = client.get(&format!("{API}/campaigns/1/report.html"))?;
    holds(
        report.contains("</html>"),
        "no report",
        &json!(report.len()),
    )
}

fn holds(is: bool, otherwise: &str, found: &Value) -> Result<(), String> {
    match is {
        true => Ok(()),
        false => Err(format!("{otherwise}: {found}")),
    }
}

//! The container's command at work: from the container file, as its user and as process 1, in a root that it cannot write but for
//! `/data`, beside a vehicle that it reaches through a router of MAVLink as on BlueOS.

use std::net::UdpSocket;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use serde_json::json;

use super::sandbox::Container;
use super::{MEMORY, arguments, text};
use crate::http::Client;
use crate::long_log::long_log;
use crate::shell::{Run, command, patiently};
use crate::wheel;
use crate::workspace::in_target;

const STATIC: &str = "x86_64-unknown-linux-musl";
/// Largest image, bytes.
const IMAGE: u64 = 25_000_000;
/// A long log of ArduPilot, MB.
const LONG_LOG_MB: &str = "62";
/// The programming interface.
const API: &str = "/api/v1";
/// How much faster than a real one the vehicle is.
const SPEED: &str = "20";
/// Larger than any frame of MAVLink.
const LARGEST: usize = 1 << 16;
const PATIENCE: Duration = Duration::from_secs(120);

/// Something that a person or BlueOS does: a name, and what is done with the vehicle that the command names.
type Stage = (&'static str, fn(&mut Client, &str) -> Result<()>);
const STAGES: [Stage; 4] = [
    ("the page and BlueOS", the_page),
    ("a log", a_log),
    ("a long log", a_long_log),
    ("a trial", a_trial),
];

/// Runs the command, opens the page and logs, makes a trial over MAVLink, and fails where image or memory are larger than promised.
pub fn check() -> Result<()> {
    let binary = wheel::command_for(STATIC)?;
    let text = text()?;
    let words = arguments(&text);
    let after = |option: &str| {
        let pair = words.windows(2).find(|pair| pair[0] == option);
        let pair = pair.with_context(|| format!("the command has no {option}"));
        Ok::<_, anyhow::Error>(pair?[1].as_str())
    };
    let vehicle = after("--vehicle")?;
    let (_, mavlink_port) = vehicle.rsplit_once(':').unwrap_or_default();
    let router = format!("127.0.0.1:{mavlink_port}");
    let socket = UdpSocket::bind(&router).with_context(|| router.clone())?;
    std::thread::spawn(move || pass_on(&socket));
    let mut simulated = command!("{binary} sim serve --speed {SPEED} --udp {router}");
    let _simulated = simulated.silent().begin()?;

    let mut container = Container::start(&in_target("container"), &binary, &text)?;
    let (_, port) = after("--listen")?.rsplit_once(':').unwrap_or_default();
    let mut client = Client::of(&format!("127.0.0.1:{port}"))?;
    client.host = format!("{}:{port}", after("--host")?);
    client.headers = vec![format!("Authorization: Bearer {}", container.token)];
    for (name, stage) in STAGES {
        let begun = Instant::now();
        stage(&mut client, vehicle).with_context(|| format!("{name}\n{}", container.said()))?;
        let (seconds, most) = (begun.elapsed().as_secs_f64(), container.most_memory()?);
        let mebibytes = most as f64 / f64::from(1 << 20);
        eprintln!("== {name}: {seconds:.1} s, at most {mebibytes:.1} MiB of memory so far");
        ensure!(most <= MEMORY, "memory: {most} bytes, more than {MEMORY}");
    }
    container.ends_when_asked()?;
    let image = container.image_bytes()?;
    eprintln!("== image of {:.1} MB", image as f64 / 1e6);
    ensure!(image <= IMAGE, "image: {image} bytes, more than {IMAGE}");
    Ok(())
}

/// Routes MAVLink as BlueOS does: what one sends goes to all others that have sent something.
fn pass_on(socket: &UdpSocket) {
    let mut datagram = vec![0; LARGEST];
    let mut known = Vec::new();
    loop {
        // A refused datagram of one that is gone is reported here; the next one may arrive.
        let Ok((length, sender)) = socket.recv_from(&mut datagram) else {
            continue;
        };
        if !known.contains(&sender) {
            known.push(sender);
        }
        for receiver in known.iter().filter(|known| **known != sender) {
            let _ = socket.send_to(&datagram[..length], receiver);
        }
    }
}

fn the_page(client: &mut Client, _: &str) -> Result<()> {
    // A person has no token yet, BlueOS has none at all.
    let headers = std::mem::take(&mut client.headers);
    client.page()?;
    let service = client.document("/register_service")?;
    ensure!(service["name"] == "seatrial", "BlueOS does not find the service: {service}");
    client.headers = headers;
    Ok(())
}

fn a_log(client: &mut Client, _: &str) -> Result<()> {
    let found = client
        .post(&format!("{API}/logs/identify?name=boat.csv"), Path::new("docs/sample/boat.csv"))?;
    let outcome = &found["document"]["verdict"]["outcome"];
    ensure!(outcome == "use", "the sample log has no model to use: {outcome}");
    Ok(())
}

fn a_long_log(client: &mut Client, _: &str) -> Result<()> {
    let log = long_log("container/long.bin", LONG_LOG_MB)?;
    let found = client.post(&format!("{API}/logs/identify?name=long.bin"), &log)?;
    let source = &found["document"]["source"];
    let read = source["samples_read"].as_u64().unwrap_or(0);
    ensure!(read > 10_000, "the long log was not read: {source}");
    Ok(())
}

/// One speed on the vehicle that the command names.
fn a_trial(client: &mut Client, vehicle: &str) -> Result<()> {
    let control = client.order(&format!("{API}/control"), &json!({"name": "container"}))?;
    let lease = control["lease"].as_str().context("no lease")?;
    client.headers.push(format!("seatrial-lease: {lease}"));
    let mut plan = client.document(&format!("{API}/plans/default"))?;
    plan["thrusts"] = json!([0.6]);
    let order = json!({"vehicle": vehicle, "plan": plan, "agreed": true});
    client.order(&format!("{API}/trial"), &order)?;
    let trial = patiently(PATIENCE, "the trial ends", || {
        let trial = client.document(&format!("{API}/status"))?["trial"].clone();
        Ok((trial["running"] == false).then_some(trial))
    })?;
    ensure!(trial["outcome"]["finished"] == true, "it was not finished: {trial}");
    let report = client.get(&format!("{API}/campaigns/1/report.html"))?;
    ensure!(report.contains("</html>"), "no report: {} bytes", report.len());
    Ok(())
}

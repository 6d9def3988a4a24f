//! A trial on an autopilot, which a vehicle in a process of its own plays.

use std::net::{TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::program;
use serde_json::{Value, json};

use super::kind;
use super::server::{PATIENCE, Server};

/// Ended when dropped.
pub struct Boat {
    process: Child,
    pub address: String,
}

impl Boat {
    /// So many times as fast as a real one.
    pub fn launch(speed: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        drop(listener);
        let process = program()
            .args(["sim", "serve", "--speed", speed, "--seconds", "600", "--tcp", &place])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while TcpStream::connect(&place).is_err() {
            assert!(begun.elapsed() < PATIENCE);
            std::thread::sleep(Duration::from_millis(20));
        }
        Self { process, address: format!("mavlink:tcp:{place}") }
    }
}

impl Drop for Boat {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn cli_a_trial_on_an_autopilot_is_agreed_to_and_aborted_by_the_button() {
    let boat = Boat::launch("5");
    let folder = tempfile::tempdir().unwrap();
    let options = ["--vehicle", &boat.address, "--full-rudder-deg", "14.9"];
    let server = Server::start(folder.path(), &options);
    let vehicles = server.get("/vehicles")["vehicles"].clone();
    let named = |vehicle: &&Value| vehicle["name"] == *boat.address;
    let found = vehicles.as_array().unwrap().iter().find(named).unwrap();
    assert_eq!(found["is_simulated"], false);

    let lease = server.control("Anna");
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = json!([0.6]);
    let mut order = json!({"vehicle": boat.address, "plan": plan});
    let (status, preflight) = server.ask("POST", "/preflight").json(&order).send();
    assert_eq!((status, &preflight["ready"]), (200, &json!(true)), "{preflight}");
    assert!(!preflight["changes"].as_array().unwrap().is_empty());
    let start = |order: &Value| server.ask("POST", "/trial").lease(&lease).json(order).send();
    let (status, refused) = start(&order);
    assert_eq!((status, &refused["code"]), (422, &json!("agreement_needed")));

    order["agreed"] = json!(true);
    let mut viewer = server.viewer(&json!({"lease": lease}));
    assert_eq!(server.start_trial(&lease, &order), 1);
    viewer.until(|message| message["stage"] == "train");
    viewer.until(|message| {
        let samples = message["samples"].as_array();
        samples.is_some_and(|s| s.iter().any(|s| s["rudder_rad"].as_f64().unwrap().abs() > 0.2))
    });
    let (status, trial) = server.ask("POST", "/trial/abort").send();
    assert_eq!(status, 202, "{trial}");
    let seen = viewer.until(|message| kind(message) == "trial_ended");
    let ended = seen.last().unwrap();
    assert_eq!(ended["outcome"]["reason"], "operator", "{ended}");
    // Everything is put back: there is nothing else to be warned of.
    let given_back = "the vehicle was given back: the operator asked for it";
    assert_eq!(ended["warnings"], json!([given_back]));
    assert!(!folder.path().join("seatrial.restore.toml").exists());

    // It can be taken again.
    assert_eq!(server.start_trial(&lease, &order), 2);
    server.ask("POST", "/trial/abort").send();
    assert_eq!(server.wait_for_end()["outcome"]["finished"], false);
}

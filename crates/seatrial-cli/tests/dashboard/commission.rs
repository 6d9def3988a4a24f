//! A commission of the dashboard, on the autopilot that `sim serve` plays.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::kind;
use super::mavlink::Boat;
use super::server::{PATIENCE, Server};

/// The commission that runs, or the last one.
fn state(server: &Server) -> Value {
    server.get("/commission")["commission"].clone()
}

#[test]
fn cli_a_commission_of_the_dashboard_is_shown_agreed_to_and_reported() {
    let boat = Boat::launch("4");
    let folder = tempfile::tempdir().unwrap();
    let options = ["--vehicle", &boat.address, "--full-rudder-deg", "14.9"];
    let server = Server::start(folder.path(), &options);
    let vehicles = server.get("/vehicles")["vehicles"].clone();
    let with_gains: Vec<&Value> = vehicles
        .as_array()
        .unwrap()
        .iter()
        .filter(|vehicle| vehicle["has_gains"] == true)
        .collect();
    assert_eq!(with_gains.len(), 1);
    assert_eq!(with_gains[0]["name"], *boat.address);
    assert!(state(&server).is_null());

    // A campaign of that vehicle.
    let lease = server.control("Anna");
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = json!([0.6]);
    let trial = json!({"vehicle": boat.address, "plan": plan, "agreed": true});
    assert_eq!(server.start_trial(&lease, &trial), 1);
    assert_eq!(server.wait_for_end()["outcome"]["finished"], true);

    // The gains now beside those proposed; nothing is touched.
    let mut order = json!({"vehicle": boat.address, "campaign": 1});
    let ask = |path: &str, order: &Value| server.ask("POST", path).lease(&lease).json(order).send();
    let (status, preview) = ask("/commission/preview", &order);
    assert_eq!((status, &preview["ready"]), (200, &json!(true)), "{preview}");
    let parameters = preview["proposed"]["parameters"].as_array().unwrap();
    let feed_forward = parameters.iter().find(|one| one["name"] == "ATC_STR_RAT_FF");
    assert_eq!(feed_forward.unwrap()["from"], 0.2, "{preview}");
    assert!(!folder.path().join("seatrial.restore.toml").exists());

    // It is agreed to, by who has control, with what was shown.
    let (status, refused) = ask("/commission", &order);
    assert_eq!((status, &refused["code"]), (422, &json!("agreement_needed")));
    order["agreed"] = json!(true);
    order["proposal"] = json!("another");
    let (status, refused) = ask("/commission", &order);
    assert_eq!((status, &refused["code"]), (409, &json!("proposal_changed")));
    let (status, refused) = server.ask("POST", "/commission").json(&order).send();
    assert_eq!(status, 409, "{refused}");

    // It is stopped by the abort of a trial: the old gains are back.
    order["proposal"] = preview["proposed"]["proposal"].clone();
    let mut viewer = server.viewer(&json!({"lease": lease}));
    let (status, begun) = ask("/commission", &order);
    assert_eq!((status, &begun["running"]), (201, &json!(true)), "{begun}");
    let (status, refused) = ask("/trial", &trial);
    assert_eq!((status, &refused["code"]), (409, &json!("trial_running")));
    let seen = |server: &Server| server.get("/commission?after=0")["next"].as_u64().unwrap();
    let began = Instant::now();
    while seen(&server) < 20 {
        assert!(began.elapsed() < PATIENCE, "{}", state(&server));
        std::thread::sleep(Duration::from_millis(20));
    }
    let shown = server.get("/commission?after=10");
    let sample = shown["samples"][5].clone();
    assert!(sample["heading_rad"].is_number() && sample["wanted_rad"].is_number(), "{sample}");
    assert_eq!(server.ask("POST", "/trial/abort").send().0, 204);
    let messages = viewer.until(|message| {
        kind(message) == "commission" && message["commission"]["running"] == false
    });
    let ended = messages.last().unwrap()["commission"].clone();
    assert_eq!(ended["ended"], "aborted", "{ended}");
    assert_eq!(ended["needs_restoring"], false, "{ended}");
    assert!(!folder.path().join("seatrial.restore.toml").exists());
    assert_eq!(state(&server)["ended"], "aborted");

    // Undisturbed, the new gains are proven and stay, and the command that undoes it is told.
    let (status, begun) = ask("/commission", &order);
    assert_eq!(status, 201, "{begun}");
    let began = Instant::now();
    while state(&server)["running"] == true {
        assert!(began.elapsed() < 3 * PATIENCE, "{}", state(&server));
        std::thread::sleep(Duration::from_millis(100));
    }
    let ended = state(&server);
    assert_eq!(ended["ended"], "kept", "{ended}");
    let undo = ended["undo"].as_str().unwrap();
    assert!(
        undo.starts_with("seatrial vehicle restore ") && undo.ends_with(&boat.address),
        "{undo}"
    );
    assert!(ended["new"]["settling_s"].is_number(), "{ended}");
    undone(&server, &boat, &lease);
    let audit = server.get("/audit");
    let commands = audit.as_array().unwrap().iter();
    assert_eq!(commands.filter(|entry| entry["command"] == "commission").count(), 5);
}

/// The old gains are shown beside those that the commission left, agreed to by who has control, and put back once.
fn undone(server: &Server, boat: &Boat, lease: &str) {
    let order = json!({"vehicle": boat.address});
    let ask = |path: &str, order: &Value| {
        let request = server.ask("POST", &format!("/commission/{path}"));
        request.lease(lease).json(order).send()
    };
    let (status, shown) = ask("undo/preview", &order);
    assert_eq!(status, 200, "{shown}");
    assert_eq!(shown["file"], "seatrial.old-gains.toml");
    let parameters = shown["parameters"].as_array().unwrap().clone();
    let named = |name: &str| parameters.iter().find(|one| one["name"] == name).cloned();
    let feed_forward = named("ATC_STR_RAT_FF").unwrap();
    assert!(feed_forward["to"] == 0.2 && feed_forward["from"] != 0.2, "{shown}");

    let agreed = json!({"vehicle": boat.address, "undo": shown["undo"], "agreed": true});
    let (status, refused) = ask("undo", &json!({"vehicle": boat.address, "undo": shown["undo"]}));
    assert_eq!((status, &refused["code"]), (422, &json!("agreement_needed")));
    let (status, refused) =
        ask("undo", &json!({"vehicle": boat.address, "undo": "x", "agreed": true}));
    assert_eq!((status, &refused["code"]), (409, &json!("undo_changed")));
    let (status, refused) = server.ask("POST", "/commission/undo").json(&agreed).send();
    assert_eq!(status, 409, "{refused}");
    let (status, done) = ask("undo", &agreed);
    assert_eq!((status, &done["complete"]), (200, &json!(true)), "{done}");
    let said = done["line"].as_str().unwrap();
    assert!(!said.contains("another has control"), "{said}");
    let now = state(server);
    assert!(now["undo"].is_null());
    assert_eq!(now["ended"], "put_back");
    assert!(now["line"].as_str().unwrap().contains("an undo"), "{now}");
    let (status, refused) = ask("undo/preview", &order);
    assert_eq!((status, &refused["code"]), (422, &json!("nothing_to_undo")));
}

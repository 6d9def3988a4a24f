//! A server that is killed in mid campaign.

use seatrial_dev::program;
use serde_json::json;

use super::kind;
use super::server::Server;

/// The next server closes the campaign, tells viewers that it is another stream, and goes on at the speed that was broken off.
#[test]
fn cli_a_killed_campaign_is_closed_and_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &[]);
    let lease = server.control("Anna");
    let mut viewer = server.viewer(&json!({}));
    let snapshot = viewer.next();
    let order = json!({"vehicle": "sim:starfish", "seed": 1, "realtime_factor": 10, "configuration": "payload"});
    server.start_trial(&lease, &order);
    viewer.until(|message| kind(message) == "run_ended");
    assert_eq!(server.get("/campaigns")[0]["state"], "running");
    // At once: on a busy machine a viewer hears late.
    viewer.until(|message| message["stage"] == "train");
    server.child.kill().unwrap();
    server.child.wait().unwrap();

    let server = Server::start(folder.path(), &[]);
    let broken_off = server.get("/campaigns/1");
    assert_eq!(broken_off["campaign"]["state"], "interrupted");
    assert_eq!(broken_off["runs"][0]["accepted"], true, "{broken_off}");
    assert_eq!(broken_off["runs"][1]["reasons"][0]["code"], "interrupted");
    let hello = json!({"stream": snapshot["stream"], "after": snapshot["sequence"]});
    let again = server.viewer(&hello).next();
    assert_eq!(kind(&again), "snapshot");
    assert_ne!(again["stream"], snapshot["stream"]);

    let lease = server.control("Ben");
    let go_on = |campaign: u32| {
        server.ask("POST", "/trial/go-on").lease(&lease).json(&json!({"campaign": campaign})).send()
    };
    let (status, trial) = go_on(1);
    assert_eq!((status, &trial["campaign"]), (201, &json!(2)), "{trial}");
    assert_eq!(trial["plan"]["thrusts"], json!([0.7, 0.8, 0.9, 1.0]));
    assert_eq!(trial["configuration"], "payload");
    assert_eq!(server.wait_for_end()["outcome"]["finished"], true);
    assert_eq!(server.get("/campaigns/1"), broken_off);
    let (status, refused) = go_on(2);
    assert_eq!((status, &refused["code"]), (422, &json!("nothing_left")));
    let gone_on = &server.get("/audit")[1];
    assert_eq!(gone_on["command"], "go_on");
    assert!(gone_on["details"].to_string().contains("campaign"), "{gone_on}");
    drop(server);

    let verified = program()
        .args(["logbook", "--verify", "--logbook"])
        .arg(folder.path().join("seatrial.db"))
        .output()
        .unwrap();
    assert!(verified.status.success(), "{}", String::from_utf8_lossy(&verified.stderr));
}

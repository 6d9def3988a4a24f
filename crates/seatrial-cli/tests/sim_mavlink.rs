//! Trials on the vehicles that `sim serve` plays.

use std::net::TcpListener;
use std::process::Stdio;

use seatrial_dev::program;
use serde_json::Value;

/// ArduSub and PX4, five times as fast as real ones, to which half a second between heartbeats is 2.5 s of the 5 s that their
/// failsafe allows; everything is put back.
#[test]
fn cli_other_kinds_of_autopilots() {
    let kinds: [(&str, &[&str]); 2] = [("sub", &[]), ("px4", &["--steering-outputs", "1"])];
    std::thread::scope(|scope| {
        for (profile, options) in kinds {
            scope.spawn(move || sails(profile, options));
        }
    });
}

fn sails(profile: &str, options: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), "thrusts = [0.6]\n").unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = listener.local_addr().unwrap().to_string();
    drop(listener);
    let seatrial = |arguments: &[&str]| {
        let mut command = program();
        command.args(arguments).current_dir(folder.path());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let played = ["sim", "serve", "--speed", "5", "--seconds", "600"];
    let mut boat = seatrial(&[&played[..], &["--profile", profile, "--tcp", &place]].concat())
        .spawn()
        .unwrap();
    while std::net::TcpStream::connect(&place).is_err() {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let address = format!("mavlink:tcp:{place}");
    let trial = ["trial", "--yes", "--json", "--plan", "plan.toml"];
    let vehicle = ["--full-rudder-deg", "14.9", "--vehicle", &address];
    let output = seatrial(&[&trial[..], &vehicle, options].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    boat.kill().unwrap();
    boat.wait().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    // Its model may be refused on a busy machine: the vehicle is in a hurry.
    assert!(matches!(output.status.code(), Some(0 | 4)), "{errors}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["outcome"]["state"], "finished", "{errors}");
    assert!(errors.contains("mode restored; restored"), "{errors}");
    assert!(!folder.path().join("seatrial.restore.toml").exists());
}

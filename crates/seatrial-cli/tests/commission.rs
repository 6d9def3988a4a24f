//! `seatrial commission` on the autopilot that `sim serve` plays: from a trial to proven gains and back.

use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Stdio};

use seatrial_dev::{document, program, run_in, text, unwrapped};
use serde_json::Value;

/// A quick boat with an autopilot's heading, whose full rudder is 0.6 rad.
const BOAT: &str = r#"
name = "launch"
rudder_limit_rad = 0.6
initial_thrust = 0.5

[servo]
time_constant_s = 0.08

[sensors.compass]
noise_rad = 0.002
resolution_rad = 0.0

[sensors.gyro]
noise_rad_s = 0.002

[[speeds]]
thrust = 0.5
surge_speed_m_s = 1.5
a22_per_s = -2.5
b2_per_s2 = 2.5
c0_rad_per_s2 = 0.02

[[speeds]]
thrust = 1.0
surge_speed_m_s = 3.0
a22_per_s = -5.0
b2_per_s2 = 10.0
c0_rad_per_s2 = 0.04
"#;

/// A boat that our own controller steers, its rudder half as strong again at full thrust as a constant gain takes it for.
const OWN_BOAT: &str = r#"
name = "launch"
rudder_limit_rad = 0.6
initial_thrust = 0.5

[servo]
time_constant_s = 0.02

[sensors.compass]
noise_rad = 0.002
resolution_rad = 0.0

[sensors.gyro]
noise_rad_s = 0.002

[[speeds]]
thrust = 0.5
surge_speed_m_s = 1.5
a22_per_s = -0.8
b2_per_s2 = 0.8
c0_rad_per_s2 = 0.01

[[speeds]]
thrust = 1.0
surge_speed_m_s = 3.0
a22_per_s = -1.6
b2_per_s2 = 4.8
c0_rad_per_s2 = 0.01
"#;

/// Times faster than a real vehicle. The autopilot waits for a heartbeat for 0.3 s of ours.
const SPEED: &str = "4";

/// A vehicle that plays until it is dropped.
struct Boat {
    process: Child,
    address: String,
}

impl Boat {
    fn start(folder: &Path, vehicle: &str) -> Self {
        Self::start_as("rover", folder, vehicle)
    }

    fn start_as(profile: &str, folder: &Path, vehicle: &str) -> Self {
        std::fs::write(folder.join("boat.toml"), BOAT).unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let place = listener.local_addr().unwrap().to_string();
        drop(listener);
        let process = program()
            .current_dir(folder)
            .args(["sim", "serve", "--vehicle", vehicle])
            .args(["--profile", profile])
            .args(["--speed", SPEED, "--tcp", &place])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while std::net::TcpStream::connect(&place).is_err() {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        Self { process, address: format!("mavlink:tcp:{place}") }
    }

    /// The options that reach it.
    fn link(&self) -> [&str; 4] {
        ["--vehicle", &self.address, "--full-rudder-deg", "34.37747"]
    }
}

impl Drop for Boat {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn commission(folder: &Path, boat: &Boat, source: &[&str]) -> (Option<i32>, Value, String) {
    let fixed = ["commission", "--json", "--yes", "--plan", "plan.toml"];
    let output = run_in(folder, &[&fixed[..], &boat.link(), source].concat());
    let errors = text(&output.stderr);
    (output.status.code(), document(&output), errors)
}

#[test]
fn cli_gains_from_a_trial_are_proven_kept_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let boat = Boat::start(folder, "sim:boat.toml");
    std::fs::write(folder.join("plan.toml"), "thrusts = [0.5]\n").unwrap();
    let trial = ["trial", "--yes", "--plan", "plan.toml"];
    let trial = run_in(folder, &[&trial[..], &boat.link()].concat());
    assert_eq!(trial.status.code(), Some(0), "{}", text(&trial.stderr));
    // One next command, on the screen and in the report, which says what the autopilot runs.
    let next = format!("seatrial commission --vehicle {}", boat.address);
    let said = unwrapped(&text(&trial.stdout));
    assert!(said.contains(&format!("Next {next}")), "{said}");
    let report = run_in(folder, &["report", "--logbook", "seatrial.db", "--out", "trial.html"]);
    assert_eq!(report.status.code(), Some(0), "{}", text(&report.stderr));
    let page = std::fs::read_to_string(folder.join("trial.html")).unwrap();
    assert!(page.contains(&next) && page.contains("ArduPilot Rover"));

    let (code, found, errors) = commission(folder, &boat, &["--logbook", "seatrial.db"]);
    assert_eq!(code, Some(0), "{errors}");
    assert_eq!(found["ending"]["state"], "kept", "{errors}");
    assert!(found["line"].as_str().unwrap().starts_with("KEPT"), "{found}");
    let feed_forward = found["changes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|change| change["name"] == "ATC_STR_RAT_FF")
        .unwrap();
    assert_eq!(feed_forward["from"], 0.2);
    // Damping by rudder effect and the autopilot's division by the speed: 2.5/(2.5 0.6) 1.5 = 2.5, to the model's error.
    let proposed = feed_forward["to"].as_f64().unwrap();
    assert!((proposed / 2.5 - 1.0).abs() < 0.1, "{proposed}");
    assert!(!folder.join("seatrial.restore.toml").exists());

    let undo = folder.join("seatrial.old-gains.toml");
    let kept = std::fs::read_to_string(&undo).unwrap();
    assert!(kept.contains("[parameters.ATC_STR_RAT_FF]\nnumber = 0.2\n"), "{kept}");
    let restore = ["vehicle", "restore", "--yes", "seatrial.old-gains.toml"];
    let restored = run_in(folder, &[&restore[..], &boat.link()].concat());
    assert_eq!(restored.status.code(), Some(0), "{}", text(&restored.stderr));
    assert!(!undo.exists());

    // A model that turns twice as well as the boat.
    let wrong = r#"{"source": {}, "models": [{"surge_speed_m_s": 1.5, "verdict": {"accepted": true}, "identification":
        {"online": {"a22_per_s": -2.5, "b2_per_s2": 5.0, "c0_rad_per_s2": 0.02}, "verdict": {"accepted": true}}}]}"#;
    std::fs::write(folder.join("wrong.json"), wrong).unwrap();
    let (code, found, errors) = commission(folder, &boat, &["--model", "wrong.json"]);
    assert_eq!(code, Some(4), "{errors}");
    assert_eq!(found["ending"]["state"], "refused", "{errors}");
    assert!(!folder.join("seatrial.restore.toml").exists());
    assert!(!undo.exists());
}

/// A trial, a commission and its undoing under ArduSub, whose thrust ahead takes two fifths of what steers.
#[test]
fn cli_gains_of_a_submarine_are_proven_kept_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let slow = [("-2.5", "-0.6"), ("-5.0", "-1.2"), ("= 2.5", "= 0.6"), ("= 10.0", "= 2.4")];
    let slow = slow.iter().fold(BOAT.to_string(), |text, (from, to)| text.replace(from, to));
    std::fs::write(folder.join("sub.toml"), slow).unwrap();
    let boat = Boat::start_as("sub", folder, "sim:sub.toml");
    std::fs::write(folder.join("plan.toml"), "thrusts = [0.8]\n").unwrap();
    let trial = ["trial", "--yes", "--plan", "plan.toml"];
    let trial = run_in(folder, &[&trial[..], &boat.link()].concat());
    assert_eq!(trial.status.code(), Some(0), "{}", text(&trial.stderr));
    let next = format!("Next seatrial commission --vehicle {}", boat.address);
    let said = unwrapped(&text(&trial.stdout));
    assert!(said.contains(&next), "{said}");
    let (code, found, errors) = commission(folder, &boat, &["--logbook", "seatrial.db"]);
    assert_eq!(code, Some(0), "{errors}");
    assert_eq!(found["ending"]["state"], "kept", "{errors}");
    let names: Vec<&str> = found["changes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|change| change["name"].as_str())
        .collect();
    for name in ["ATC_ANG_YAW_P", "ATC_RAT_YAW_P", "ATC_SLEW_YAW"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(!folder.join("seatrial.restore.toml").exists());
    let restore = ["vehicle", "restore", "--yes", "seatrial.old-gains.toml"];
    let restored = run_in(folder, &[&restore[..], &boat.link()].concat());
    let errors = text(&restored.stderr);
    assert_eq!(restored.status.code(), Some(0), "{errors}");

    // A model that does not say at which thrust it was found.
    let bare = r#"{"source": {}, "models": [{"surge_speed_m_s": 2.4, "verdict": {"accepted": true}, "identification":
        {"online": {"a22_per_s": -4.0, "b2_per_s2": 6.4, "c0_rad_per_s2": 0.02}, "verdict": {"accepted": true}}}]}"#;
    std::fs::write(folder.join("bare.json"), bare).unwrap();
    let output = ["commission", "--yes", "--plan", "plan.toml", "--model", "bare.json"];
    let output = run_in(folder, &[&output[..], &boat.link()].concat());
    assert_eq!(output.status.code(), Some(4));
    let errors = unwrapped(&text(&output.stderr));
    assert!(errors.contains("the model says no thrust"), "{errors}");
}

/// Where the heading controller is ours: the gain of each speed against the constant one of the slowest, on a boat of which
/// that is half too much at full thrust.
#[test]
fn cli_gains_of_our_own_heading_controller_are_proven_at_every_speed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("boat.toml"), OWN_BOAT).unwrap();
    std::fs::write(folder.join("plan.toml"), "thrusts = [0.5, 1.0]\n").unwrap();
    let vehicle = ["--vehicle", "sim:boat.toml"];
    let trial = ["trial", "--plan", "plan.toml"];
    let trial = run_in(folder, &[&trial[..], &vehicle].concat());
    assert_eq!(trial.status.code(), Some(0), "{}", text(&trial.stderr));
    let output = run_in(folder, &[&["commission", "--json"][..], &vehicle].concat());
    let (found, errors) = (document(&output), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let speeds = found["speeds"].as_array().unwrap();
    assert_eq!(speeds.len(), 2, "{found}");
    for speed in speeds {
        assert_eq!(speed["ending"]["state"], "kept", "{errors}");
    }
    let gain = |speed: &Value, which: &str| speed[which]["proportional_gain"].as_f64().unwrap();
    assert_eq!(gain(&speeds[0], "constant"), gain(&speeds[0], "scheduled"));
    let share = gain(&speeds[1], "scheduled") / gain(&speeds[1], "constant");
    assert!((share * 1.5 - 1.0).abs() < 0.15, "{share}");
    let overshoot = |which: &str| speeds[1][which]["overshoot"].as_f64().unwrap();
    assert!(overshoot("new") < 0.5 * overshoot("old"), "{errors}");
}

/// Compass and sea move its heading by more than a degree, which is nobody's fault; without repeats and their scatter two speeds were proven.
#[test]
fn cli_gains_of_a_noisy_starfish_are_proven_at_every_speed() {
    let folder = tempfile::tempdir().unwrap();
    let vehicle = ["--vehicle", "sim:starfish", "--json"];
    run_in(folder.path(), &[&["trial"][..], &vehicle].concat());
    let output = run_in(folder.path(), &[&["commission"][..], &vehicle].concat());
    let found = document(&output);
    let speeds = found["speeds"].as_array().unwrap();
    assert_eq!(speeds.len(), 5, "{found}");
    for speed in speeds {
        assert_eq!(speed["ending"]["state"], "kept", "{}", text(&output.stderr));
    }
}

#[test]
fn cli_a_commission_without_a_model_an_envelope_or_an_autopilot_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.json"), "{}").unwrap();
    for (arguments, code, expected) in [
        (&["--vehicle", "mavlink:udp:127.0.0.1:1"][..], 3, "seatrial.db"),
        (&["--vehicle", "mavlink:udp:127.0.0.1:1", "--step-deg", "200"], 2, "from 5 to 90"),
        (&["--vehicle", "mavlink:udp:127.0.0.1:1", "--model", "model.json"], 3, "model.json"),
    ] {
        let output = run_in(folder.path(), &[&["commission"], arguments].concat());
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {errors}");
        assert!(errors.contains(expected), "{arguments:?}: {errors}");
    }
}

/// Every command of docs/ardupilot.md in turn, on the vehicle that the page plays.
#[test]
fn cli_the_page_for_an_ardupilot_boat_is_walked() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/ardupilot.md");
    let page = std::fs::read_to_string(page).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let boat = Boat::start(folder.path(), "sim:starfish");
    // Not those that install, and not the vehicle itself.
    let is_walked = |line: &&str| line.starts_with("seatrial ") && !line.contains(" sim serve");
    let mut commissioned = false;
    for line in page.lines().filter(is_walked) {
        let line = line.replace("mavlink:udp:127.0.0.1:14550", &boat.address);
        let mut arguments: Vec<&str> = line.split(' ').skip(1).collect();
        // Nobody is at the terminal whom it could ask.
        let asking: [&[&str]; 3] = [&["trial"], &["commission"], &["vehicle", "restore"]];
        if asking.iter().any(|verb| arguments.starts_with(verb)) {
            arguments.push("--yes");
        }
        let output = run_in(folder.path(), &arguments);
        let (said, errors) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{line}\n{said}{errors}");
        if arguments[0] == "commission" {
            assert!(said.starts_with("KEPT"), "{said}");
            commissioned = true;
        }
    }
    assert!(commissioned);
    assert!(!folder.path().join("seatrial.old-gains.toml").exists());
}

//! `seatrial logbook` at the process boundary.

use seatrial::log::LambdaReason;
use seatrial_core::state_variable_filter::Hold;
use std::path::Path;
use std::process::Output;

use seatrial::campaign::{FullRudder, Run, Stage, StageSpan};
use seatrial::identification::{
    Convergence, EstimateMethod, Identification, Intervals, LeastSquares, Online, Reason,
    ReasonCode, Refined, RejectedSamples, Settings, Verdict,
};
use seatrial::{Step, Window};
use seatrial_core::{AbortReason, Action, Outcome, Sample, Steering, YawModel};
use seatrial_dev::{program, text, unwrapped};
use seatrial_logbook::{Logbook, NewCampaign, Recorder};
use serde_json::Value;

fn seatrial(logbook: &Path, arguments: &[&str]) -> Output {
    program().arg("logbook").args(arguments).arg("--logbook").arg(logbook).output().unwrap()
}

/// The text that a successful call printed.
fn printed(logbook: &Path, arguments: &[&str]) -> String {
    let output = seatrial(logbook, arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn identification(model: YawModel<f64>) -> Identification {
    let around = |value: f64, half: f64| [value - half, value + half];
    let verdict =
        Verdict { accepted: true, reasons: vec![Reason::new(ReasonCode::Ok, "fit to use")] };
    let window = Window { from_s: 0.0, to_s: 10.0 };
    Identification {
        training: window,
        samples_used: 200,
        samples_rejected: RejectedSamples::default(),
        settings: Settings {
            as_paper: false,
            lambda_rad_s: 1.5,
            lambda_because: LambdaReason::Given,
            heading_hold: Hold::FirstOrder,
            initial_covariance: 1e6,
            forgetting_factor: 1.0,
            servo: None,
        },
        online: Online {
            method: EstimateMethod::InstrumentalVariable,
            model,
            delta0_rad: model.delta0_rad(),
            covariance: [[0.0; 3]; 3],
            least_squares: LeastSquares { model, covariance: [[0.0; 3]; 3] },
            batch: None,
            theta_at: Default::default(),
            convergence: Convergence { detected_s: None, threshold: 1e-3, consecutive: 10 },
            trace: Vec::new(),
        },
        refined: Some(Refined {
            method: EstimateMethod::AveragedRestrictedLikelihood,
            model,
            delta0_rad: model.delta0_rad(),
            interval_95: Intervals {
                a22_per_s: around(model.a22_per_s, 0.03),
                b2_per_s2: around(model.b2_per_s2, 0.03),
                c0_rad_per_s2: around(model.c0_rad_per_s2, 0.001),
                delta0_rad: None,
            },
            covariance: [[0.0; 3]; 3],
            heading_noise_rad: 0.001,
            disturbance_rad_s2: 0.0,
        }),
        nomoto: model.nomoto(),
        restoring: None,
        validation: None,
        higher_order: None,
        lag_effect: None,
        loop_timing: None,
        valid_range: None,
        verdict,
    }
}

/// A campaign of one accepted run with this model.
fn record(logbook: &Path, configuration: &str, model: YawModel<f64>) {
    let new = NewCampaign { configuration, ..REHEARSAL };
    record_trial(logbook, &new, model, Some(Outcome::Finished));
}

const REHEARSAL: NewCampaign = NewCampaign {
    configuration: "bare",
    notes: None,
    software_version: "0.1.0",
    vehicle: "sim:starfish",
    seed: Some(7),
    rudder_limit_rad: 0.26,
    full_rudder: None,
    scenario: None,
    plan: "",
};

/// Records a trial of a campaign that ended with this outcome; without one it was killed.
fn record_trial(logbook: &Path, new: &NewCampaign, model: YawModel<f64>, outcome: Option<Outcome>) {
    let mut recorder = Recorder::begin(Logbook::open(logbook).unwrap(), new).unwrap();
    let steps: Vec<Step> = (0..200)
        .map(|k| Step {
            sample: Sample {
                time_s: f64::from(k) * 0.05,
                heading_rad: 1.0 / 3.0,
                depth_m: Some(2.0),
                ..Sample::default()
            },
            stage: Some(Stage::Train),
            action: Action {
                steering: Steering::HoldHeading(0.1),
                thrust: Some(0.8),
                outcome: None,
            },
            estimate: None,
        })
        .collect();
    recorder.begin_run(1, 0.8, 1).unwrap();
    for step in &steps {
        recorder.step(*step).unwrap();
    }
    let identification = identification(model);
    let run = Run {
        number: 1,
        thrust: 0.8,
        attempt: 1,
        surge_speed_m_s: Some(1.63),
        stages: vec![StageSpan { stage: Stage::Train, window: identification.training }],
        record: steps.iter().map(|step| step.sample).collect(),
        verdict: identification.verdict.clone(),
        identification: Some(identification),
    };
    recorder.finish_run(&run).unwrap();
    if let Some(outcome) = outcome {
        recorder.finish(outcome).unwrap();
    }
}

#[test]
fn cli_logbook_lists_shows_compares_and_exports() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, "bare", YawModel::from_theta([-1.07, 1.08, 0.012]));
    record(&logbook, "sonar", YawModel::from_theta([-1.06, 0.98, 0.012]));

    let list: Value = serde_json::from_str(&printed(&logbook, &["list", "--json"])).unwrap();
    assert_eq!(list["campaigns"][1]["configuration"], "sonar");
    assert_eq!(list["campaigns"][1]["runs_accepted"], 1);
    assert!(printed(&logbook, &["list"]).contains("bare"));

    let shown = printed(&logbook, &["show", "1"]);
    for expected in [
        "course change will overshoot by 1 to 2 deg",
        "0.501",
        "0.935",
        "1.01",
        "use",
        "Next   seatrial gains",
    ] {
        assert!(shown.contains(expected), "{expected} in {shown}");
    }
    let last: Value = serde_json::from_str(&printed(&logbook, &["show", "--json"])).unwrap();
    assert_eq!(last["campaign"]["id"], 2);
    assert_eq!(last["runs"][0]["identification"]["refined"]["b2_per_s2"], 0.98);

    let diff = printed(&logbook, &["diff", "bare", "2"]);
    // 0.10 against sqrt(0.03^2 + 0.03^2) = 0.042.
    assert!(diff.contains("B is lower, by 2.4 times"), "{diff}");
    assert!(diff.contains("the same within the intervals"), "{diff}");
    let diff: Value =
        serde_json::from_str(&printed(&logbook, &["diff", "1", "2", "--json"])).unwrap();
    assert!(diff["thrusts"][0]["b2_per_s2"]["ratio"].as_f64().unwrap() < -1.0);
    assert_eq!(diff["thrusts"][0]["delta0_rad"]["ratio"], Value::Null);

    let csv = printed(&logbook, &["export", "1", "--run", "1"]);
    let mut lines = csv.lines();
    assert!(lines.next().unwrap().starts_with("run,stage,time_s,heading_rad,rudder_rad"));
    let row: Vec<&str> = lines.nth(3).unwrap().split(',').collect();
    assert_eq!(row[..6], ["1", "train", "0.15000000000000002", "0.3333333333333333", "0.0", ""]);
    assert_eq!(csv.lines().count(), 201);
    let out = folder.path().join("results.json");
    printed(&logbook, &["export", "--json", "--out", out.to_str().unwrap()]);
    let results: Value = serde_json::from_slice(&std::fs::read(out).unwrap()).unwrap();
    assert_eq!(results["campaign"]["configuration"], "sonar");
}

#[test]
fn cli_logbook_verify_tells_whole_from_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, "bare", YawModel::from_theta([-1.07, 1.08, 0.012]));
    assert!(printed(&logbook, &["verify"]).contains("whole"));

    // One letter of the verdict, in place.
    let mut bytes = std::fs::read(&logbook).unwrap();
    let at = bytes.windows(10).position(|word| word == b"fit to use").unwrap();
    bytes[at] = b'h';
    std::fs::write(&logbook, bytes).unwrap();
    let damaged = seatrial(&logbook, &["verify"]);
    assert_eq!(damaged.status.code(), Some(3));
    assert!(text(&damaged.stdout).contains("campaign 1, run 1: "));
    let json: Value =
        serde_json::from_slice(&seatrial(&logbook, &["verify", "--json"]).stdout).unwrap();
    assert_eq!(json["whole"], false);
    assert_eq!(json["damage"][0]["place"], "campaign 1, run 1");
    // Nothing that steers a vehicle comes from it.
    for verb in ["gains", "turn"] {
        let refused = program().arg(verb).arg("--logbook").arg(&logbook).output();
        let refused = refused.unwrap();
        assert_eq!(refused.status.code(), Some(3), "{verb}");
        assert!(text(&refused.stderr).contains("logbook is damaged: campaign 1, run 1"));
        assert_eq!(text(&refused.stdout), "");
    }
}

/// The newer of two campaigns is damaged: the older one is shown with this as the reason, and no gain comes from it.
#[test]
fn cli_one_damaged_campaign_is_named_where_another_one_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    for configuration in ["first", "second"] {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        record(&logbook, configuration, model);
    }
    let whole = std::fs::read(&logbook).unwrap();
    let verdicts = whole.windows(10).enumerate();
    let verdicts = verdicts.filter(|(_, word)| *word == b"fit to use");
    let damages_the_second = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] = b'h';
        std::fs::write(&logbook, bytes).unwrap();
        printed(&logbook, &["list"]).contains("campaign 2: DAMAGED")
    };
    assert!(verdicts.map(|(at, _)| at).any(damages_the_second));
    let page = folder.path().join("page.html");
    let mut report = program();
    report.arg("report").arg("--logbook").arg(&logbook);
    let told = report.arg("--out").arg(&page).output().unwrap();
    let told = text(&told.stderr);
    assert!(told.contains("campaign 2, is damaged"), "{told}");
    let server = crate::dashboard::server::Server::start(folder.path(), &[]);
    for place in ["schedule", "gains.param?rehearsal=true"] {
        let asked = server.ask("GET", &format!("/campaigns/1/{place}"));
        let (status, refused) = asked.send();
        assert_eq!(status, 422, "{place}: {refused}");
        let message = refused["message"].as_str().unwrap();
        assert!(message.contains("campaign 2"), "{message}");
    }
}

/// Of a logbook that was cut off to nothing nobody may believe that it is whole.
#[test]
fn cli_logbook_an_empty_file_is_not_whole() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    std::fs::write(&logbook, "").unwrap();
    let verified = seatrial(&logbook, &["verify"]);
    assert_eq!(verified.status.code(), Some(3));
    assert!(text(&verified.stdout).contains("file: it holds no logbook"));
}

/// Names come from files and over the network: none of them commands a terminal.
#[test]
fn cli_names_cannot_command_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let hostile = "pay\u{1b}[2J\u{9b}31mload";
    record(&logbook, hostile, YawModel::from_theta([-1.0, 1.0, 0.0]));
    for arguments in
        [&["list"][..], &["show"], &["show", "--json"], &["list", "--json"], &["diff", "1", "none"]]
    {
        let output = seatrial(&logbook, arguments);
        let printed = text(&output.stdout) + &text(&output.stderr);
        assert!(printed.contains("pay\\u"), "{arguments:?}: {printed:?}");
        assert!(!printed.contains(['\u{1b}', '\u{9b}']), "{printed:?}");
    }
}

/// A trial on a boat, a rehearsal, a trial that was aborted and one that was killed.
fn four_campaigns(logbook: &Path) {
    let on_a_boat = NewCampaign {
        vehicle: "mavlink:udp:0.0.0.0:14550",
        seed: None,
        full_rudder: Some(FullRudder { angle_rad: 0.6, is_assumed: true }),
        ..REHEARSAL
    };
    let aborted = Some(Outcome::Aborted(AbortReason::Operator));
    let trials = [
        (&on_a_boat, -1.1, Some(Outcome::Finished)),
        (&REHEARSAL, -1.2, Some(Outcome::Finished)),
        (&on_a_boat, -1.3, aborted),
        (&on_a_boat, -1.4, None),
    ];
    for (new, a22_per_s, outcome) in trials {
        let model = YawModel::from_theta([a22_per_s, 1.0, 0.0]);
        record_trial(logbook, new, model, outcome);
    }
}

#[test]
fn cli_the_last_trial_of_a_vehicle_that_was_accepted_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    four_campaigns(&logbook);
    let ask = |arguments: &[&str]| {
        let mut command = program();
        command.args(arguments).arg("--logbook").arg(&logbook);
        let output = command.output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let damping = |arguments: &[&str]| {
        let (code, document, printed) = ask(&[arguments, &["--json"]].concat());
        assert_eq!(code, Some(0), "{printed}");
        let document: Value = serde_json::from_str(&document).unwrap();
        (document["points"][0]["a22_per_s"].as_f64().unwrap(), printed)
    };
    for verb in ["gains", "turn"] {
        let (a22_per_s, printed) = damping(&[verb]);
        assert_eq!(a22_per_s, -1.1, "{verb}");
        assert!(
            printed.contains("campaign 1 is taken; the newest, campaign 4, is not finished"),
            "{printed}"
        );
        assert_eq!(damping(&[verb, "--campaign", "bare"]).0, -1.1);
        let (a22_per_s, printed) = damping(&[verb, "--campaign", "3"]);
        assert_eq!(a22_per_s, -1.3);
        assert!(printed.contains("was aborted"), "{printed}");
        assert!(
            unwrapped(&ask(&[verb]).1).contains(
                "Campaign 1 on vehicle mavlink:udp:0.0.0.0:14550, configuration bare, 20"
            )
        );
    }
    let page = folder.path().join("page.html");
    let (code, _, printed) = ask(&["report", "--out", page.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{printed}");
    // Shown is the last that was accepted, a rehearsal too.
    assert!(printed.contains("campaign 2 is taken"), "{printed}");
    let replayed = program().arg("replay").arg(&logbook).output().unwrap();
    let printed = text(&replayed.stderr);
    assert!(printed.contains("campaign 2 is taken"), "{printed}");
}

#[test]
fn cli_a_rehearsal_is_exported_only_when_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    four_campaigns(&logbook);
    let export = |arguments: &[&str]| {
        let mut command = program();
        command.args(["gains", "--export"]).args(arguments);
        let output = command.arg("--logbook").arg(&logbook).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, file, _) = export(&["ardupilot"]);
    assert_eq!(code, Some(0));
    let file = file.replace("\n#  ", " ");
    for comment in [
        "# Campaign 1 on vehicle mavlink:udp:0.0.0.0:14550, configuration bare, 20",
        "# full steering was ASSUMED to be 34.4 degrees",
    ] {
        assert!(file.contains(comment), "{file}");
    }
    for format in ["ardupilot", "px4", "ros2", "json", "c"] {
        let (code, file, printed) = export(&[format, "--campaign", "2"]);
        assert_eq!((code, file.as_str()), (Some(2), ""), "{format}");
        assert!(printed.contains("--rehearsal takes them all the same"), "{printed}");
        let (code, file, printed) = export(&[format, "--campaign", "2", "--rehearsal"]);
        assert_eq!(code, Some(0), "{printed}");
        assert!(file.contains("REHEARSAL on a simulator"), "{file}");
    }
}

/// A campaign from before the full rudder was kept.
#[test]
fn cli_an_autopilot_whose_full_rudder_is_not_known_gets_no_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let before = NewCampaign { vehicle: "mavlink:udp:0.0.0.0:14550", seed: None, ..REHEARSAL };
    let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
    record_trial(&logbook, &before, model, Some(Outcome::Finished));
    let export = |arguments: &[&str]| {
        let mut command = program();
        command.args(["gains", "--export", "ardupilot"]).args(arguments);
        let output = command.arg("--logbook").arg(&logbook).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, file, printed) = export(&[]);
    assert_eq!((code, file.as_str()), (Some(2), ""));
    assert!(printed.contains("--full-rudder-deg DEG (35"), "{printed}");
    assert_eq!(export(&["--full-rudder-deg", "35"]).0, Some(0));
}

/// A trial on a vehicle that does not answer leaves nothing behind.
#[test]
fn cli_nothing_is_written_before_the_vehicle_answers() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let trial = |vehicle: &str| {
        let mut command = program();
        command.args(["trial", "--yes", "--vehicle", vehicle, "--logbook"]);
        command.arg(&logbook).output().unwrap().status.code()
    };
    // Nobody answers on the discard port.
    let nobody = "mavlink:udpout:127.0.0.1:9";
    assert_eq!(trial(nobody), Some(5));
    assert!(!logbook.exists());
    record(&logbook, "bare", YawModel::from_theta([-1.07, 1.08, 0.012]));
    let before = std::fs::read(&logbook).unwrap();
    assert_eq!(trial(nobody), Some(5));
    assert_eq!(std::fs::read(&logbook).unwrap(), before);
}

#[test]
fn cli_logbook_that_is_none_is_exit_3_with_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let refused = |arguments: &[&str], expected: &str| {
        let output = seatrial(&logbook, arguments);
        assert_eq!(output.status.code(), Some(3));
        assert_eq!(text(&output.stdout), "");
        let message = text(&output.stderr);
        assert!(message.contains(expected), "{message}");
    };
    for verb in ["list", "show", "export", "verify"] {
        refused(&[verb], "`seatrial trial --logbook");
    }
    record(&logbook, "bare", YawModel::from_theta([-1.07, 1.08, 0.012]));
    refused(&["show", "9"], "no campaign 9; it holds campaign 1");
    refused(&["diff", "1", "sonar"], "no configuration \"sonar\"; it holds: bare");
    refused(&["export", "1", "--run", "2"], "no run 2");
    std::fs::write(&logbook, "time_s,heading_rad\n".repeat(9)).unwrap();
    refused(&["list"], "not a seatrial logbook");
}

//! `seatrial logbook` at the process boundary.

use seatrial::time_scale::LambdaReason;
use seatrial_core::state_variable_filter::Hold;
use std::path::Path;
use std::process::Output;

use seatrial::Step;
use seatrial::campaign::{Run, Stage, StageSpan};
use seatrial::identification::{
    Convergence, EstimateMethod, Identification, Intervals, LeastSquares, Online, Reason,
    ReasonCode, Refined, RejectedSamples, Settings, Verdict,
};
use seatrial::record::Window;
use seatrial_core::{Action, Outcome, Sample, Steering, YawModel};
use seatrial_dev::{program, text};
use seatrial_logbook::{Logbook, NewCampaign, Recorder};
use serde_json::Value;

fn seatrial(logbook: &Path, arguments: &[&str]) -> Output {
    program()
        .arg("logbook")
        .args(arguments)
        .arg("--logbook")
        .arg(logbook)
        .output()
        .unwrap()
}

/// The text that a successful call printed.
fn printed(logbook: &Path, arguments: &[&str]) -> String {
    let output = seatrial(logbook, arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn identification(model: YawModel<f64>) -> Identification {
    let around = |value: f64, half: f64| [value - half, value + half];
    let verdict = Verdict {
        accepted: true,
        reasons: vec![Reason::new(ReasonCode::Ok, "fit to use")],
    };
    let window = Window {
        from_s: 0.0,
        to_s: 10.0,
    };
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
            least_squares: LeastSquares {
                model,
                covariance: [[0.0; 3]; 3],
            },
            batch: None,
            theta_at: Default::default(),
            convergence: Convergence {
                detected_s: None,
                threshold: 1e-3,
                consecutive: 10,
            },
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
    let new = NewCampaign {
        configuration,
        notes: None,
        software_version: "0.1.0",
        vehicle: "sim:starfish",
        seed: Some(7),
        rudder_limit_rad: 0.26,
        plan: "",
    };
    let mut recorder = Recorder::begin(Logbook::open(logbook).unwrap(), &new).unwrap();
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
        stages: vec![StageSpan {
            stage: Stage::Train,
            window: identification.training,
        }],
        record: steps.iter().map(|step| step.sample).collect(),
        verdict: identification.verdict.clone(),
        identification: Some(identification),
    };
    recorder.finish_run(&run).unwrap();
    recorder.finish(Outcome::Finished).unwrap();
}

#[test]
fn cli_logbook_lists_shows_compares_and_exports() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, "bare", YawModel::from_theta([-1.07, 1.08, 0.012]));
    record(
        &logbook,
        "sonar",
        YawModel::from_theta([-1.06, 0.98, 0.012]),
    );

    let list: Value = serde_json::from_str(&printed(&logbook, &["list", "--json"])).unwrap();
    assert_eq!(list["campaigns"][1]["configuration"], "sonar");
    assert_eq!(list["campaigns"][1]["runs_accepted"], 1);
    assert!(printed(&logbook, &["list"]).contains("bare"));

    let shown = printed(&logbook, &["show", "1"]);
    for expected in [
        "-1.070",
        "[-1.100 -1.040]",
        "0.01111",
        "0.93",
        "1.01",
        "use",
    ] {
        assert!(shown.contains(expected), "{expected} in {shown}");
    }
    let last: Value = serde_json::from_str(&printed(&logbook, &["show", "--json"])).unwrap();
    assert_eq!(last["campaign"]["id"], 2);
    assert_eq!(
        last["runs"][0]["identification"]["refined"]["b2_per_s2"],
        0.98
    );

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
    assert!(
        lines
            .next()
            .unwrap()
            .starts_with("run,stage,time_s,heading_rad,rudder_rad")
    );
    let row: Vec<&str> = lines.nth(3).unwrap().split(',').collect();
    assert_eq!(
        row[..6],
        [
            "1",
            "train",
            "0.15000000000000002",
            "0.3333333333333333",
            "0.0",
            ""
        ]
    );
    assert_eq!(csv.lines().count(), 201);
    let out = folder.path().join("results.json");
    printed(
        &logbook,
        &["export", "--json", "--out", out.to_str().unwrap()],
    );
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
    let at = bytes
        .windows(10)
        .position(|word| word == b"fit to use")
        .unwrap();
    bytes[at] = b'h';
    std::fs::write(&logbook, bytes).unwrap();
    let damaged = seatrial(&logbook, &["verify"]);
    assert_eq!(damaged.status.code(), Some(3));
    assert!(text(&damaged.stdout).contains("campaign 1, run 1: "));
    let json: Value =
        serde_json::from_slice(&seatrial(&logbook, &["verify", "--json"]).stdout).unwrap();
    assert_eq!(json["whole"], false);
    assert_eq!(json["damage"][0]["place"], "campaign 1, run 1");
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
    refused(
        &["diff", "1", "sonar"],
        "no configuration \"sonar\"; it holds: bare",
    );
    refused(&["export", "1", "--run", "2"], "no run 2");
    std::fs::write(&logbook, "time_s,heading_rad\n".repeat(9)).unwrap();
    refused(&["list"], "not a seatrial logbook");
}

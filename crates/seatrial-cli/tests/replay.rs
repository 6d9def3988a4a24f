//! `seatrial replay` at the process boundary, on trials of the simulated vehicle.

use std::path::Path;
use std::process::{Command, Output};

use seatrial::campaign::Run;
use seatrial::identification::Verdict;
use seatrial::logbook::{Logbook, NewCampaign, Recorder, Step};
use seatrial::record::Record;
use seatrial_core::{AbortReason, Event, List, Outcome, Plan, Trial, Vehicle};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde_json::Value;

/// Runs a trial at two speeds into a logbook. Before each step `intervene` may abort the trial, and
/// after it change what is recorded.
fn record(logbook: &Path, mut intervene: impl FnMut(usize, &mut Trial<f64>, Option<&mut Step>)) {
    let plan = Plan {
        thrusts: List::from_slice(&[0.6, 0.8]).unwrap(),
        ..Plan::paper()
    };
    let new = NewCampaign {
        configuration: "bare",
        notes: None,
        software_version: "0.1.0",
        vehicle: "sim:starfish",
        seed: Some(3),
        rudder_limit_rad: plan.rudder_limit_rad,
        plan: &toml::to_string(&plan).unwrap(),
    };
    let mut recorder = Recorder::begin(Logbook::open(logbook).unwrap(), &new).unwrap();
    let mut trial = Trial::new(plan).unwrap();
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 3).unwrap();
    let mut record = Record::default();
    let mut run = (1, 0.6, 1);
    let result = |(number, thrust, attempt): (u32, f64, u32), record: &mut Record| Run {
        number,
        thrust,
        attempt,
        surge_speed_m_s: None,
        stages: Vec::new(),
        record: std::mem::take(record),
        identification: None,
        verdict: Verdict {
            accepted: false,
            reasons: Vec::new(),
        },
    };
    for k in 0.. {
        let sample = vehicle.next_sample().unwrap().unwrap();
        intervene(k, &mut trial, None);
        let mut step = Step::take(&mut trial, sample);
        let mut in_a_run = !record.samples.is_empty();
        while let Some(event) = trial.take_event() {
            match event {
                Event::RunStarted {
                    number,
                    thrust,
                    attempt,
                } => {
                    run = (number, thrust, attempt);
                    recorder.begin_run(number, thrust, attempt).unwrap();
                    in_a_run = true;
                }
                Event::RunFinished { .. } => {
                    recorder.finish_run(&result(run, &mut record)).unwrap();
                    in_a_run = false;
                }
                _ => {}
            }
        }
        if in_a_run {
            record.samples.push(sample);
        }
        intervene(k, &mut trial, Some(&mut step));
        recorder.step(step).unwrap();
        vehicle.act(&step.action).unwrap();
        if let Some(outcome) = step.action.outcome {
            if in_a_run {
                recorder.finish_run(&result(run, &mut record)).unwrap();
            }
            recorder.finish(outcome).unwrap();
            return;
        }
    }
}

fn replay(logbook: &Path) -> (Output, Value) {
    let output = Command::new(env!("CARGO_BIN_EXE_seatrial"))
        .args(["replay", "--json"])
        .arg(logbook)
        .output()
        .unwrap();
    let document = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output, document)
}

#[test]
fn parity_a_finished_trial_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let mut samples = 0;
    record(&logbook, |_, _, step| {
        samples += usize::from(step.is_some())
    });
    let (output, document) = replay(&logbook);
    assert_eq!(output.status.code(), Some(0), "{document}");
    assert_eq!(document["samples"], samples);
    // Two training stages of 330 samples.
    assert_eq!(document["estimates"], 660);
    assert_eq!(document["first_difference"], Value::Null);
    let campaign = Logbook::open_read_only(&logbook)
        .unwrap()
        .campaigns()
        .unwrap();
    assert_eq!((campaign[0].runs, campaign[0].runs_finished), (2, 2));
}

#[test]
fn parity_an_abort_from_outside_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    // While settling, while training, and in the middle of a deflection.
    for (k, at) in [3, 500, 580].into_iter().enumerate() {
        let logbook = folder.path().join(format!("{k}.db"));
        record(&logbook, |k, trial, step| {
            if k == at && step.is_none() {
                trial.abort(AbortReason::Operator);
            }
        });
        let (output, document) = replay(&logbook);
        assert_eq!(output.status.code(), Some(0), "{document}");
        // The step of the abort is neutral rudder, the next one hands back.
        assert_eq!(document["samples"], at + 2);
        let entry = Logbook::open_read_only(&logbook)
            .unwrap()
            .campaigns()
            .unwrap();
        let aborted = Outcome::Aborted(AbortReason::Operator);
        assert_eq!(
            entry[0].state,
            seatrial::logbook::State::Ended { outcome: aborted }
        );
    }
}

#[test]
fn parity_the_last_bit_of_one_estimate_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let mut changed = None;
    record(&logbook, |k, _, step| {
        if let (None, Some(step)) = (changed, step)
            && let Some(estimate) = &mut step.estimate
            && estimate.b2_per_s2 != 0.0
        {
            estimate.b2_per_s2 = f64::from_bits(estimate.b2_per_s2.to_bits() ^ 1);
            changed = Some(k);
        }
    });
    let (output, document) = replay(&logbook);
    assert_eq!(output.status.code(), Some(4));
    assert_eq!(document["identical"], false);
    let difference = &document["first_difference"];
    assert_eq!(difference["sample"], changed.unwrap());
    assert_eq!(difference["run"], 1);
    let found = difference["found"].as_str().unwrap();
    assert!(
        found.starts_with("estimate_b2_per_s2: recorded "),
        "{found}"
    );
    assert!(!found.contains(';'), "one value differs: {found}");
}

#[test]
fn cli_replay_of_nothing_is_exit_3() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let (missing, _) = replay(&logbook);
    assert_eq!(missing.status.code(), Some(3));
    let new = NewCampaign {
        configuration: "bare",
        notes: None,
        software_version: "0.1.0",
        vehicle: "sim:starfish",
        seed: None,
        rudder_limit_rad: 0.26,
        plan: "",
    };
    drop(Recorder::begin(Logbook::open(&logbook).unwrap(), &new).unwrap());
    let (empty, _) = replay(&logbook);
    assert_eq!(empty.status.code(), Some(3));
    let message = String::from_utf8(empty.stderr).unwrap();
    assert!(message.contains("no sample to replay"), "{message}");
}

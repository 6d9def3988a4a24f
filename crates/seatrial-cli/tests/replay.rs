//! `seatrial replay` at the process boundary, on trials of the simulated vehicle.

use std::path::Path;
use std::process::Output;

use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial_app::conduct::{Watch, conduct};
use seatrial_app::trials::replay::Replay;
use seatrial_core::{AbortReason, List, Outcome, Plan, Trial, YawModel};
use seatrial_dev::program;
use seatrial_logbook::{Logbook, NewCampaign, Recorder, State};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde_json::Value;

const NEW: NewCampaign = NewCampaign {
    configuration: "bare",
    notes: None,
    software_version: "0.1.0",
    vehicle: "sim:starfish",
    seed: Some(3),
    rudder_limit_rad: 0.26,
    full_rudder: None,
    scenario: None,
    plan: "",
};

/// Records a trial; the operator may abort it, a gremlin may change an estimate in the record.
struct Record {
    recorder: Recorder,
    samples: usize,
    abort_before: Option<usize>,
    /// The process is gone once it has kept the result of this run.
    killed_after_run: Option<u32>,
    is_killed: bool,
    gremlin: fn(usize, &mut YawModel<f64>),
}

impl Watch for Record {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        if !self.is_killed {
            self.recorder.begin_run(number, thrust, attempt).unwrap();
        }
    }
    fn step(&mut self, step: &Step, _: &Trial<f64>) {
        if self.is_killed {
            return;
        }
        let mut step = *step;
        if let Some(estimate) = &mut step.estimate {
            (self.gremlin)(self.samples, estimate);
        }
        self.recorder.step(step).unwrap();
        self.samples += 1;
    }
    fn run_ended(&mut self, run: &mut Run) {
        if !self.is_killed {
            self.recorder.finish_run(run).unwrap();
            self.is_killed = self.killed_after_run == Some(run.number);
        }
    }
    fn wants_abort(&mut self) -> bool {
        !self.is_killed && self.abort_before == Some(self.samples)
    }
}

/// A trial of two speeds in a logbook; its number of samples.
fn record(
    logbook: &Path,
    abort_before: Option<usize>,
    gremlin: fn(usize, &mut YawModel<f64>),
) -> usize {
    record_until_killed(logbook, None, abort_before, gremlin)
}

fn record_until_killed(
    logbook: &Path,
    killed_after_run: Option<u32>,
    abort_before: Option<usize>,
    gremlin: fn(usize, &mut YawModel<f64>),
) -> usize {
    let plan = Plan { thrusts: List::from_slice(&[0.6, 0.8]).unwrap(), ..Plan::paper() };
    let new = NewCampaign { plan: &toml::to_string(&plan).unwrap(), ..NEW };
    let mut record = Record {
        recorder: Recorder::begin(Logbook::open(logbook).unwrap(), &new).unwrap(),
        samples: 0,
        abort_before,
        killed_after_run,
        is_killed: false,
        gremlin,
    };
    let about = Campaign {
        software_version: new.software_version.into(),
        configuration: new.configuration.into(),
        seed: new.seed,
        ..Campaign::of(new.vehicle, &plan)
    };
    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 3).unwrap();
    let conducted = conduct(&mut vehicle, plan, about, &mut record).unwrap();
    let outcome = conducted.campaign.outcome.unwrap();
    if !record.is_killed {
        record.recorder.finish(outcome).unwrap();
    }
    record.samples
}

fn replay(logbook: &Path) -> (Output, Value) {
    let output = program().args(["replay", "--json"]).arg(logbook).output().unwrap();
    let document = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output, document)
}

#[test]
fn parity_a_finished_trial_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let samples = record(&logbook, None, |_, _| ());
    let (output, document) = replay(&logbook);
    assert_eq!(output.status.code(), Some(0), "{document}");
    assert_eq!(document["samples"], samples);
    // Two training stages of 330 samples.
    assert_eq!(document["estimates"], 660);
    assert_eq!(document["results"], 2);
    assert_eq!(document["first_difference"], Value::Null);
}

#[test]
fn parity_an_operators_abort_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    // At once, while settling, while training, and while validating.
    for abort_before in [0, 3, 500, 700] {
        let logbook = folder.path().join(format!("{abort_before}.db"));
        let samples = record(&logbook, Some(abort_before), |_, _| ());
        assert_eq!(samples, abort_before + 2);
        let entry = Logbook::open_read_only(&logbook).unwrap().campaigns().unwrap();
        let outcome = Outcome::Aborted(AbortReason::Operator);
        assert_eq!(entry[0].state, State::Ended { outcome });
        let (output, document) = replay(&logbook);
        assert_eq!(output.status.code(), Some(0), "{document}");
        assert_eq!(document["samples"], samples);
    }
}

/// The sample that ended a run is kept after the run's result, and a process may be killed in between.
#[test]
fn parity_a_trial_killed_after_a_result_replays_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for (killed_after_run, results) in [(1, 1), (2, 2)] {
        let logbook = folder.path().join(format!("{killed_after_run}.db"));
        let samples = record_until_killed(&logbook, Some(killed_after_run), None, |_, _| ());
        let (output, document) = replay(&logbook);
        assert_eq!(output.status.code(), Some(0), "{document}");
        assert_eq!(document["samples"], samples);
        assert_eq!(document["results"], results);
    }
    // Of a run that was aborted the reason was in the sample that is missing.
    let logbook = folder.path().join("aborted.db");
    let samples = record_until_killed(&logbook, Some(1), Some(500), |_, _| ());
    let (output, document) = replay(&logbook);
    assert_eq!(output.status.code(), Some(0), "{document}");
    assert_eq!((&document["samples"], &document["results"]), (&samples.into(), &0.into()));
    assert_eq!(document["runs_without_their_end"], serde_json::json!([1]));
    let printed = program().arg("replay").arg(&logbook).output().unwrap();
    let printed = String::from_utf8(printed.stdout).unwrap();
    assert!(printed.contains("run 1 was stopped after the last sample kept"), "{printed}");
}

/// A difference is a line that can be read, whatever is recorded.
#[test]
fn cli_a_difference_is_short() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, None, |_, _| ());
    let change = rusqlite::Connection::open(&logbook).unwrap();
    change
        .execute_batch(
            "UPDATE estimate SET identification = json_remove(identification, '$.refined')",
        )
        .unwrap();
    let output = program().arg("replay").arg(&logbook).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.len() < 1000, "{} bytes", printed.len());
    assert_eq!(output.status.code(), Some(4), "{printed}");
}

#[test]
fn parity_the_last_bit_of_one_estimate_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, None, |sample, estimate| {
        if sample == 400 {
            estimate.b2_per_s2 = f64::from_bits(estimate.b2_per_s2.to_bits() ^ 1);
        }
    });
    let (output, document) = replay(&logbook);
    assert_eq!(output.status.code(), Some(4));
    assert_eq!(document["identical"], false);
    let difference = &document["first_difference"];
    assert_eq!(difference["sample"], 400);
    assert_eq!(difference["run"], 1);
    let found = difference["found"].as_str().unwrap();
    assert!(found.starts_with("estimate_b2_per_s2: recorded "), "{found}");
    assert!(!found.contains(';'), "one value differs: {found}");
}

#[test]
fn parity_a_result_that_comes_out_otherwise_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    record(&logbook, None, |_, _| ());
    let read = Logbook::open_read_only(&logbook).unwrap();
    let entry = read.campaigns().unwrap().remove(0);
    let plan: Plan<f64> = toml::from_str(&entry.plan).unwrap();
    let mut recording = read.recording(entry.id).unwrap();
    let refined = recording.campaign.runs[1].identification.as_mut().unwrap().refined.as_mut();
    refined.unwrap().interval_95.a22_per_s[0] -= 1e-9;
    let replay = Replay::of(plan, &recording).unwrap();
    assert_eq!(replay.results, 1);
    let difference = replay.first_difference.unwrap();
    assert_eq!(difference.run, Some(2));
    let place = "result.identification.refined.interval_95.a22_per_s[0]: recorded ";
    assert!(difference.found.starts_with(place), "{}", difference.found);
}

#[test]
fn cli_replay_of_nothing_is_exit_3() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let (missing, _) = replay(&logbook);
    assert_eq!(missing.status.code(), Some(3));
    drop(Recorder::begin(Logbook::open(&logbook).unwrap(), &NEW).unwrap());
    let (empty, _) = replay(&logbook);
    assert_eq!(empty.status.code(), Some(3));
    let message = String::from_utf8(empty.stderr).unwrap();
    assert!(message.contains("no sample to replay"), "{message}");
}

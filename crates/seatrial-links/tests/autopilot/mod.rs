//! Trials on a vehicle that speaks MAVLink, in made-up time: bad links, pilots, failsafes, a process that is gone.

mod any_message;
mod exported;
mod forged;
mod links;
mod mishaps;
mod preflight;
pub mod sea;
mod second_station;
mod stations;

use seatrial::Step;
use seatrial::campaign::Campaign;
use seatrial_app::conduct::{TrialResult, Watch, conduct};
use seatrial_core::{List, Plan, Trial};
use seatrial_links::autopilot::{Autopilot, Backup, Settings, Stop};
use seatrial_links::handover::Check;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use sea::{FULL_RUDDER_RAD, Sea};

fn starfish() -> VehicleConfig {
    VehicleConfig::starfish()
}

fn plan() -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[0.6]).unwrap(), ..Plan::paper() }
}

fn settings() -> Settings {
    Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the paper's".into()),
        ..Settings::default()
    }
}

fn about() -> Campaign {
    Campaign { rudder_limit_rad: FULL_RUDDER_RAD, ..Campaign::of("mavlink", &Plan::paper()) }
}

/// Keeps every step, and aborts when it is told.
#[derive(Default)]
struct Witness {
    pub steps: Vec<Step>,
    pub abort_from_s: Option<f64>,
    pub stop_from_s: Option<f64>,
}

impl Watch for Witness {
    fn step(&mut self, step: &Step, _trial: &Trial<f64>) {
        self.steps.push(*step);
        let is_gone = self.stop_from_s.is_some_and(|from_s| step.sample.time_s >= from_s);
        assert!(!is_gone, "the process is gone");
    }

    fn wants_abort(&mut self) -> bool {
        let last_s = self.steps.last().map_or(0.0, |step| step.sample.time_s);
        self.abort_from_s.is_some_and(|from_s| last_s >= from_s)
    }
}

fn failures(checks: &[Check]) -> Vec<String> {
    let failed = checks.iter().filter(|check| !check.passed);
    failed.map(|check| format!("{}: {}", check.name, check.text)).collect()
}

/// A vehicle that is ours, and what would put it back.
fn taken(sea: Sea) -> (Autopilot<Sea>, Backup) {
    taken_with(sea, settings())
}

fn taken_with(sea: Sea, settings: Settings) -> (Autopilot<Sea>, Backup) {
    let mut autopilot = Autopilot::new(sea, settings, None);
    let preflight = autopilot.inspect();
    assert_eq!(failures(&preflight.checks), [""; 0]);
    let mut kept = None;
    let checks = autopilot.take_control(&preflight.changes, &mut |backup| {
        kept = Some(backup.clone());
        Ok(())
    });
    assert_eq!(failures(&checks), [""; 0]);
    (autopilot, kept.unwrap())
}

fn run(autopilot: &mut Autopilot<Sea>, witness: &mut Witness) -> TrialResult<Stop> {
    conduct(autopilot, plan(), about(), witness).unwrap()
}

fn assert_as_before(sea: &Sea) {
    assert_eq!(sea.boat.parameter("RC_OVERRIDE_TIME"), Some(3.0));
    assert_eq!(sea.boat.parameter("FS_GCS_ENABLE"), Some(0.0));
}

/// The estimates of the steps again, bit for bit.
fn assert_replays(steps: &[Step]) {
    let mut trial = Trial::new(plan()).unwrap();
    // The two steps of an operator's abort are nothing that samples tell.
    let is_over = steps.last().is_some_and(|step| step.action.outcome.is_some());
    for step in &steps[..steps.len() - if is_over { 2 } else { 0 }] {
        let again = Step::take(&mut trial, step.sample);
        let bits = |step: &Step| step.estimate.map(|model| model.theta().map(f64::to_bits));
        assert_eq!(bits(&again), bits(step));
        while trial.take_event().is_some() {}
    }
}

fn assert_near(campaign: &Campaign, truth: [f64; 2], share: f64) {
    let run = campaign.runs.last().unwrap();
    let identification = run.identification.as_ref().expect("a model");
    let model = identification.model();
    for (found, truth) in [model.a22_per_s, model.b2_per_s2].into_iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < share, "{found} for {truth}");
    }
}

fn truth(config: &VehicleConfig) -> [f64; 2] {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    let model = vehicle.truth(0.6).model;
    [model.a22_per_s, model.b2_per_s2]
}

/// Quiet water: the tolerance of the issue is for the link, not for the sea.
fn calm() -> VehicleConfig {
    let mut config = starfish().noise_free();
    config.sensors.compass.noise_rad = 0.003;
    config
}

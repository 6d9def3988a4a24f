//! Trials on vehicles that go on while their runs are judged.

use seatrial::identification::ReasonCode;
use std::convert::Infallible;

use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial_app::conduct::{NoWatch, Watch, conduct};
use seatrial_app::trials::replay::Replay;
use seatrial_core::{AbortReason, Action, List, Outcome, Plan, Sample, Trial, Vehicle};
use seatrial_logbook::{Keeper, Logbook, NewCampaign, Recorder};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

fn about() -> Campaign {
    Campaign::of("live", &Plan::paper())
}

fn plan() -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[0.6, 0.8]).unwrap(), ..Plan::paper() }
}

/// Does not wait for anybody; its link may end.
struct Live {
    vehicle: FirstOrderVehicle,
    ends_s: f64,
}

impl Live {
    fn until(ends_s: f64) -> Self {
        Self { vehicle: FirstOrderVehicle::new(VehicleConfig::starfish(), 3).unwrap(), ends_s }
    }
}

impl Vehicle<f64> for Live {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        let sample = self.vehicle.next_sample()?;
        Ok(sample.filter(|sample| sample.time_s < self.ends_s))
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        self.vehicle.act(action)
    }

    fn is_live(&self) -> bool {
        true
    }
}

/// The runs that have begun and ended, and the steps between.
#[derive(Default)]
struct Reporter {
    begun: Vec<u32>,
    ended: Vec<u32>,
    /// Steps of the second run before the first had its verdict.
    meanwhile: u32,
}

impl Watch for Reporter {
    fn run_started(&mut self, number: u32, _thrust: f64, _attempt: u32) {
        self.begun.push(number);
    }

    fn step(&mut self, _: &Step, _: &Trial<f64>) {
        self.meanwhile += u32::from(self.begun.len() == 2 && self.ended.is_empty());
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.ended.push(run.number);
    }
}

#[test]
fn exact_a_live_vehicle_does_not_wait_for_its_judge() {
    let mut reporter = Reporter::default();
    let live = conduct(&mut Live::until(f64::INFINITY), plan(), about(), &mut reporter).unwrap();
    assert!(reporter.meanwhile > 0);
    assert_eq!((reporter.begun, reporter.ended), (vec![1, 2], vec![1, 2]));

    let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 3).unwrap();
    let mut reporter = Reporter::default();
    let waited = conduct(&mut vehicle, plan(), about(), &mut reporter).unwrap();
    assert_eq!(reporter.meanwhile, 0);
    assert_eq!(live.campaign, waited.campaign);
}

#[test]
fn recover_a_verdict_that_is_still_waited_for_when_the_link_is_lost() {
    let whole = conduct(&mut Live::until(f64::INFINITY), plan(), about(), &mut NoWatch);
    let first = whole.unwrap().campaign.runs.swap_remove(0);
    // Three samples into the second run.
    let ends_s = first.record.samples.last().unwrap().time_s + 0.18;
    let mut reporter = Reporter::default();
    let lost = conduct(&mut Live::until(ends_s), plan(), about(), &mut reporter).unwrap();
    let campaign = lost.campaign;
    assert_eq!(campaign.outcome, Some(Outcome::Aborted(AbortReason::LinkLost)));
    let [judged, stopped] = campaign.runs.as_slice() else {
        panic!("two runs were begun");
    };
    assert_eq!(*judged, first);
    assert_eq!(stopped.verdict.reasons[0].code, ReasonCode::Aborted);
    assert_eq!(stopped.record.samples.len(), 3);
    assert_eq!(reporter.ended, [1, 2]);
}

struct Released(Keeper);

impl Watch for Released {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.0.run_started(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.0.step(step, trial);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.0.run_ended(run);
        self.0.release(run);
    }
}

/// What the logbook has is not held in memory, and can be had back.
#[test]
fn io_a_late_verdict_is_kept_with_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seatrial.db");
    let new = NewCampaign {
        configuration: "default",
        notes: None,
        software_version: "test",
        vehicle: "live",
        seed: None,
        rudder_limit_rad: 0.26,
        full_rudder: None,
        scenario: None,
        plan: "",
    };
    let recorder = Recorder::begin(Logbook::open(&path).unwrap(), &new).unwrap();
    let number = recorder.campaign();
    let mut keeper = Released(Keeper::new(recorder, true));
    let mut vehicle = Live::until(f64::INFINITY);
    let mut campaign = conduct(&mut vehicle, plan(), about(), &mut keeper).unwrap().campaign;
    assert_eq!(keeper.0.end(campaign.outcome, || false).unsaved, [""; 0]);
    for run in &campaign.runs {
        let identification = run.identification.as_ref().unwrap();
        assert_eq!(run.record.samples.capacity(), 0);
        assert_eq!(identification.online.trace.capacity(), 0);
    }

    let logbook = Logbook::open_read_only(&path).unwrap();
    assert_eq!(logbook.verify().unwrap().damage, []);
    logbook.fill(number, &mut campaign).unwrap();
    let mut vehicle = Live::until(f64::INFINITY);
    let whole = conduct(&mut vehicle, plan(), about(), &mut NoWatch).unwrap();
    assert_eq!(campaign, whole.campaign);
    let replay = Replay::of(plan(), &logbook.recording(number).unwrap()).unwrap();
    assert_eq!((replay.results, replay.first_difference), (2, None));
}

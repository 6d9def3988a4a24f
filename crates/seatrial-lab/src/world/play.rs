//! One world from its first sample to its end, and what is not as it must be.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

use crate::faults::{Rehearsal, Why};
use crate::observer::{Observer, Shared};
use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial_app::conduct::{Judging, TrialResult, Watch, conduct_judging};
use seatrial_app::{Error, TrialPlan};
use seatrial_core::{Outcome, Steering, Trial};
use seatrial_sim::faults::LinkLost;
use seatrial_sim::sensors::Chance;
use seatrial_sim::{FaultyVehicle, Scenario, SimulatedConfig};

use super::drawn::{Depth, Interrupted, World};
use super::ending::{Ending, about};
use super::kept::Kept;
use super::linked;
use super::outputs;

/// From the condition of an abort to neutral rudder, s, while samples come.
const NEUTRAL_WITHIN_S: f64 = 0.5;
/// A world of so many is played twice and must be the same.
const TWICE: u64 = 64;
/// Share of the runs after whose result the files are looked at before the next sample comes.
const LOOKED_AT_AFTER_RUNS: f64 = 0.3;

/// Plays the world of a seed, as deep as is asked for or as the seed chooses.
pub fn play(seed: u64, depth: Option<Depth>) -> Ending {
    let mut ending = play_once(seed, depth);
    if seed.is_multiple_of(TWICE) && play_once(seed, depth) != ending {
        ending.broken.push("played twice, it is not the same".into());
    }
    ending
}

fn play_once(seed: u64, depth: Option<Depth>) -> Ending {
    let world = World::of(seed, depth);
    let mut ending = Ending::of(&world);
    let played = catch_unwind(AssertUnwindSafe(|| match world.depth {
        Depth::Linked => linked::play(&world, &mut ending),
        Depth::Outputs => outputs::play(&world, &mut ending),
        _ => on_vehicle(&world, &mut ending),
    }));
    match played {
        Ok(Ok(())) => {}
        Ok(Err(error)) => ending.broken.push(format!("it cannot be played: {error}")),
        Err(_) => ending.broken.push("a panic".into()),
    }
    ending
}

fn setting(error: &dyn fmt::Display) -> Error {
    Error::Setting(error.to_string())
}

fn on_vehicle(world: &World, ending: &mut Ending) -> Result<(), Error> {
    let (plan, about) = (world.plan, about(world));
    let config = SimulatedConfig::FirstOrder(Box::new(world.vehicle.clone()));
    let vehicle = config.vehicle(world.seed).map_err(|error| setting(&error))?;
    let scenario = Scenario { faults: world.faults.clone(), ..Scenario::default() };
    let vehicle = FaultyVehicle::new(vehicle, &scenario, world.seed);
    let vehicle = vehicle.map_err(|error| setting(&error))?;
    // Each sample may come twice, and each run may be repeated.
    let longest_s = plan.longest_s() * f64::from(1 + plan.max_repeats);
    let most_samples = (3.0 * longest_s / plan.sample_interval_s) as u64;
    let is_whole = world.depth == Depth::Whole;
    let mut observer = Observer::new(vehicle, most_samples, is_whole);
    let plan_text = toml::to_string(&plan).map_err(|error| setting(&error))?;
    let mut witness = Witness::new(world, observer.shared.clone());
    if matches!(world.depth, Depth::Kept | Depth::Whole) {
        witness.kept = Some(Kept::new(&about, &plan_text)?);
    }
    let judging = match is_whole {
        true => Judging::Whole,
        false => Judging::ByTrial,
    };
    let checked = TrialPlan::from(plan).checked();
    let checked = checked.map_err(|error| setting(&error))?;
    let TrialResult { campaign, fault } =
        conduct_judging(&mut observer, &checked, about, &mut witness, judging);
    ending.take(&campaign);
    (ending.samples, ending.digest) = (observer.samples, observer.digest());
    check_runs(&campaign, &witness, ending);
    check_end(&campaign, fault, &observer, ending);
    if is_whole {
        check_models(&campaign, &Rehearsal::new(config, plan), &observer, ending);
    }
    if let Some(kept) = witness.kept {
        ending.broken.extend(kept.broken(&campaign, plan, is_whole));
    }
    Ok(())
}

/// Every run that began ended, and is in the campaign.
fn check_runs(campaign: &Campaign, witness: &Witness, ending: &mut Ending) {
    let in_campaign: Vec<u32> = campaign.runs.iter().map(|run| run.number).collect();
    let expected: Vec<u32> = (1..).take(witness.begun.len()).collect();
    if [&witness.begun, &witness.ended, &in_campaign].iter().any(|runs| **runs != expected) {
        ending.broken.push(format!(
            "runs {:?} began, {:?} ended, {in_campaign:?} are in the campaign",
            witness.begun, witness.ended
        ));
    }
}

/// It ends; the vehicle has neutral rudder in time and then its heading and its own thrust.
fn check_end(
    campaign: &Campaign,
    fault: Option<LinkLost>,
    observer: &Observer,
    ending: &mut Ending,
) {
    if observer.is_endless() || campaign.outcome.is_none() {
        ending.broken.push("it does not end".into());
    }
    if fault.is_some() && campaign.outcome == Some(Outcome::Finished) {
        ending.broken.push("finished on a lost link".into());
    }
    let is_released = observer.last.is_some_and(|action| {
        let is_neutral =
            matches!(action.steering, Steering::HoldHeading(_) | Steering::Rudder(0.0));
        is_neutral && action.thrust.is_none()
    });
    if !is_released {
        ending.broken.push(format!("the vehicle was left with {:?}", observer.last));
    }
    let Some(Outcome::Aborted(reason)) = campaign.outcome else {
        return;
    };
    if let (Some(neutral), Some(condition_s)) = (observer.neutral, observer.condition_s(reason)) {
        let after_s = (neutral.attended_s - condition_s).max(0.0);
        ending.neutral_after_s = Some(after_s);
        if after_s > NEUTRAL_WITHIN_S {
            ending.broken.push(format!("neutral {after_s:.2} s after {}", Why::Aborted(reason)));
        }
    }
}

/// Accepted models beside the truth.
fn check_models(
    campaign: &Campaign,
    rehearsal: &Rehearsal,
    observer: &Observer,
    ending: &mut Ending,
) {
    for run in campaign.runs.iter().filter(|run| run.verdict.accepted) {
        let found = run.identification.as_ref();
        let distances = found.and_then(|found| rehearsal.distances(run, found, &observer.instants));
        let Some(distances) = distances else {
            let number = run.number;
            let text = format!("run {number} is accepted without a refined model");
            ending.broken.push(text);
            continue;
        };
        ending.take_model(run.number, distances);
    }
}

/// Watches the trial, keeps it, and interrupts it.
struct Witness {
    shared: Rc<Shared>,
    at_s: f64,
    interrupted: Option<Interrupted>,
    chance: Chance,
    kept: Option<Kept>,
    begun: Vec<u32>,
    ended: Vec<u32>,
}

impl Witness {
    fn new(world: &World, shared: Rc<Shared>) -> Self {
        let interruption = world.interruption;
        Self {
            shared,
            at_s: interruption.map_or(0.0, |i| i.at * world.plan.longest_s()),
            interrupted: interruption.map(|i| i.kind),
            chance: world.chance.clone(),
            kept: None,
            begun: Vec::new(),
            ended: Vec::new(),
        }
    }

    fn is_due(&self) -> bool {
        self.shared.time_s.get() >= self.at_s
    }
}

impl Watch for Witness {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.begun.push(number);
        if let Some(kept) = &mut self.kept {
            kept.begin_run(number, thrust, attempt);
        }
    }

    fn step(&mut self, step: &Step, _: &Trial<f64>) {
        let is_due = self.is_due();
        let Some(kept) = &mut self.kept else { return };
        kept.step(step);
        let taken = self.interrupted.filter(|kind| is_due && *kind != Interrupted::Abort);
        if let Some(kind) = taken {
            self.interrupted = None;
            kept.interrupt(kind, &mut self.chance);
        }
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.ended.push(run.number);
        let Some(kept) = &mut self.kept else { return };
        kept.end_run(run);
        if self.chance.uniform() < LOOKED_AT_AFTER_RUNS {
            kept.interrupt(Interrupted::Killed, &mut self.chance);
        }
    }

    fn wants_abort(&mut self) -> bool {
        let wants = self.interrupted == Some(Interrupted::Abort) && self.is_due();
        if wants {
            self.shared.is_asked.set(true);
        }
        wants
    }
}

//! Trials that the server runs.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::campaign::Run;
use seatrial::conduct::{Pace, Watch};
use seatrial::identification::Refined;
use seatrial::logbook::{CampaignId, Keeper, Logbook, NewCampaign, Recorder, Step};
use seatrial::{Campaign, preview};
use seatrial_core::{List, Outcome, Plan, Trial};
use serde_json::Value;

use crate::api::{Check, PlanOrder, PlanPreview, Preflight, RepeatOrder, TrialOrder, TrialState};
use crate::convert::now;
use crate::live::Tap;
use crate::refusal::Refusal;
use crate::shared::Shared;
use crate::workshop::{Craft, Take};

/// Slower than this an abort would have to wait for the vehicle's next sample.
const SLOWEST: f64 = 0.1;
/// Longest name of a configuration and longest note, characters.
const LONGEST_NAME: usize = 200;
pub const LONGEST_NOTE: usize = 4000;

/// The place of the one trial.
#[derive(Debug, Default)]
pub struct Slot {
    running: Option<Running>,
}

#[derive(Debug)]
struct Running {
    /// `None` while the vehicle is being taken.
    campaign: Option<i64>,
    stop: Arc<AtomicBool>,
}

impl Slot {
    /// The campaign that runs.
    pub fn campaign(&self) -> Option<i64> {
        self.running.as_ref()?.campaign
    }

    /// What ends the trial that runs.
    pub fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.running.as_ref()?.stop))
    }

    /// Takes the place for a trial that ends when the flag is set.
    pub fn occupy(&mut self, campaign: Option<i64>, stop: Arc<AtomicBool>) -> Result<(), Refusal> {
        if self.running.is_some() {
            return Err(Refusal::conflict(
                "trial_running",
                "a trial runs; wait for its end or abort it",
            ));
        }
        self.running = Some(Running { campaign, stop });
        Ok(())
    }

    /// Gives the place free.
    pub fn leave(&mut self) {
        self.running = None;
    }
}

/// The place while a trial of the server has it; free again when dropped, whatever ends the trial.
struct Place {
    shared: Arc<Shared>,
    /// Tells of the end while nobody can take the place yet: who is told of it may begin the next trial.
    last_word: Option<Box<dyn FnOnce() + Send>>,
}

impl Place {
    fn take(shared: &Arc<Shared>, stop: &Arc<AtomicBool>) -> Result<Self, Refusal> {
        shared.slot().occupy(None, Arc::clone(stop))?;
        Ok(Self {
            shared: Arc::clone(shared),
            last_word: None,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut slot = self.shared.slot();
        if let Some(tell) = self.last_word.take() {
            tell();
        }
        slot.leave();
    }
}

/// A plan in JSON; the paper's where there is none.
pub fn plan_of(plan: Option<Value>) -> Result<Plan<f64>, Refusal> {
    let refused = |why: String| Refusal::unprocessable("plan_refused", format!("the plan: {why}"));
    let plan = match plan {
        None => Plan::paper(),
        Some(plan) => serde_json::from_value(plan).map_err(|error| refused(error.to_string()))?,
    };
    Trial::new(plan).map_err(|error| refused(error.to_string()))?;
    Ok(plan)
}

/// What a plan will do.
pub fn preview(shared: &Shared, order: PlanOrder) -> Result<PlanPreview, Refusal> {
    let plan = plan_of(order.plan)?;
    shared.vehicle(&order.vehicle)?;
    let preview = previewed(shared, &order.vehicle, &plan)?;
    Ok(PlanPreview::of(&plan, &preview))
}

fn previewed(
    shared: &Shared,
    vehicle: &str,
    plan: &Plan<f64>,
) -> Result<preview::Preview, Refusal> {
    let preview = shared.workshop.preview(vehicle, plan);
    preview.map_err(|why| Refusal::unprocessable("no_preview", why))
}

/// The checklist before a trial.
pub fn preflight(shared: &Shared, order: PlanOrder) -> Result<Preflight, Refusal> {
    let plan = plan_of(order.plan)?;
    let vehicle = shared.vehicle(&order.vehicle)?;
    if !vehicle.is_simulated && shared.slot().stop().is_some() {
        return Err(Refusal::conflict(
            "trial_running",
            "a trial runs on the vehicle",
        ));
    }
    let check = |name: &str, passed: bool, text: String| Check {
        name: name.into(),
        passed,
        text,
    };
    let mut preflight = shared
        .workshop
        .preflight(&order.vehicle, &plan)
        .map_err(|why| Refusal::unprocessable("not_reached", why))?;
    let fits = match previewed(shared, &order.vehicle, &plan) {
        Ok(preview) => {
            let fits = preview.outcome == Some(Outcome::Finished);
            let text = match preview.outcome {
                Some(Outcome::Finished) => format!("the plan takes {:.0} s", preview.duration_s),
                Some(Outcome::Aborted(reason)) => {
                    format!(
                        "on the expected vehicle it is aborted: {reason}; change the plan or its envelope"
                    )
                }
                None => "the plan does not end".into(),
            };
            check("plan", fits, text)
        }
        Err(refusal) => check("plan", true, format!("not previewed: {}", refusal.message)),
    };
    let free = shared.slot().stop().is_none();
    let text = if free {
        "no trial runs"
    } else {
        "a trial runs; wait for its end or abort it"
    };
    preflight.checks.push(fits);
    preflight.checks.push(check("free", free, text.into()));
    preflight.ready = preflight.checks.iter().all(|check| check.passed);
    Ok(preflight)
}

/// The order that runs one speed of a campaign again.
pub fn repeat(shared: &Shared, order: RepeatOrder) -> Result<TrialOrder, Refusal> {
    let entry = shared.reader()?.entry(CampaignId(order.campaign))?;
    let mut plan: Plan<f64> = toml::from_str(&entry.plan).map_err(|error| {
        Refusal::unprocessable("plan_refused", format!("the campaign's plan: {error}"))
    })?;
    if !plan.thrusts.contains(&order.thrust) {
        return Err(Refusal::unprocessable(
            "no_such_thrust",
            format!(
                "campaign {} has no speed of thrust {}",
                order.campaign, order.thrust
            ),
        ));
    }
    plan.thrusts = List::from_slice(&[order.thrust]).unwrap_or_default();
    Ok(TrialOrder {
        vehicle: entry.vehicle,
        plan: Some(serde_json::to_value(plan).map_err(Refusal::internal)?),
        seed: order.seed.or(entry.seed.map(|seed| seed.wrapping_add(1))),
        realtime_factor: order.realtime_factor,
        configuration: Some(entry.configuration),
        note: None,
        agreed: order.agreed,
    })
}

/// Starts a trial: takes the vehicle, enters the campaign, conducts it on a thread of its own.
pub fn start(shared: &Arc<Shared>, order: TrialOrder) -> Result<TrialState, Refusal> {
    let plan_is_given = order.plan.is_some();
    let plan = plan_of(order.plan.clone())?;
    let vehicle = shared.vehicle(&order.vehicle)?;
    check(&order, vehicle.is_simulated)?;
    let stop = Arc::new(AtomicBool::new(false));
    let place = Place::take(shared, &stop)?;
    let seed = order.seed.unwrap_or(1);
    let craft = shared.workshop.take(&Take {
        vehicle: order.vehicle.clone(),
        plan,
        plan_is_given,
        seed,
        stop: Arc::clone(&stop),
    });
    let mut craft = craft.map_err(|why| Refusal::unprocessable("vehicle_refused", why))?;
    let about = Campaign {
        software_version: env!("CARGO_PKG_VERSION").into(),
        vehicle: order.vehicle,
        configuration: order.configuration.unwrap_or_else(|| "default".into()),
        seed: vehicle.is_simulated.then_some(seed),
        rudder_limit_rad: plan.rudder_limit_rad,
        runs: Vec::new(),
        outcome: None,
    };
    let recorder = begun(shared, &about, order.note.as_deref(), &plan).inspect_err(|_| {
        craft.hand_back();
    })?;
    let state = TrialState::begun(recorder.campaign(), &about, &plan, order.realtime_factor);
    if let Some(running) = &mut shared.slot().running {
        running.campaign = Some(state.campaign);
    }
    let tap = shared.live.tap();
    tap.started(state.clone(), &plan);
    let watched = Watched {
        keeper: Keeper::new(recorder),
        tap,
        pace: order.realtime_factor.map(Pace::new),
        stop,
    };
    std::thread::spawn(move || conduct(craft, plan, about, watched, place));
    Ok(state)
}

fn begun(
    shared: &Shared,
    about: &Campaign,
    note: Option<&str>,
    plan: &Plan<f64>,
) -> Result<Recorder, Refusal> {
    let plan = toml::to_string_pretty(plan).map_err(Refusal::internal)?;
    let new = NewCampaign {
        configuration: &about.configuration,
        notes: note,
        software_version: &about.software_version,
        vehicle: &about.vehicle,
        seed: about.seed,
        rudder_limit_rad: about.rudder_limit_rad,
        plan: &plan,
    };
    Ok(Recorder::begin(Logbook::open(&shared.logbook)?, &new)?)
}

fn check(order: &TrialOrder, is_simulated: bool) -> Result<(), Refusal> {
    let refused = |code, message: &str| Err(Refusal::unprocessable(code, message));
    if let Some(factor) = order.realtime_factor {
        if !is_simulated {
            return refused(
                "not_simulated",
                "realtime_factor goes with a simulated vehicle",
            );
        }
        if !(SLOWEST..=1e6).contains(&factor) {
            return refused("out_of_range", "realtime_factor: expected 0.1 to 1000000");
        }
    }
    if !is_simulated && !order.agreed {
        return refused(
            "agreement_needed",
            "a vehicle that moves must be agreed to: say \"agreed\": true",
        );
    }
    let name = order.configuration.as_deref().unwrap_or("default");
    if name.trim().is_empty() || name.chars().count() > LONGEST_NAME {
        return refused(
            "out_of_range",
            "configuration: expected 1 to 200 characters",
        );
    }
    if order
        .note
        .as_ref()
        .is_some_and(|note| note.chars().count() > LONGEST_NOTE)
    {
        return refused("out_of_range", "note: expected at most 4000 characters");
    }
    Ok(())
}

/// Conducts a trial to its end, whatever that is.
fn conduct(
    mut craft: Box<dyn Craft>,
    plan: Plan<f64>,
    about: Campaign,
    mut watched: Watched,
    mut place: Place,
) {
    let conducted = catch_unwind(AssertUnwindSafe(|| {
        craft.conduct(plan, about, &mut watched)
    }));
    // The vehicle first: what is told and saved can wait.
    let not_put_back = catch_unwind(AssertUnwindSafe(|| craft.hand_back()));
    let mut warnings = Vec::new();
    let outcome = match conducted {
        Ok(Ok(conducted)) => {
            let fault = conducted
                .fault
                .map(|fault| format!("the vehicle was given back: {fault}"));
            warnings.extend(fault);
            conducted.campaign.outcome
        }
        Ok(Err(why)) => {
            warnings.push(why);
            None
        }
        Err(_) => {
            warnings.push(
                "the trial ended by a fault of the program; the vehicle was given back".into(),
            );
            None
        }
    };
    warnings.extend(not_put_back.unwrap_or_else(|_| Some("the hand-back failed".into())));
    warnings.extend(watched.keeper.end(outcome));
    let tap = watched.tap;
    place.last_word = Some(Box::new(move || tap.ended(outcome, warnings)));
}

impl TrialState {
    /// A trial that has just begun.
    pub fn begun(
        campaign: CampaignId,
        about: &Campaign,
        plan: &Plan<f64>,
        realtime_factor: Option<f64>,
    ) -> Self {
        Self {
            campaign: campaign.0,
            running: true,
            vehicle: about.vehicle.clone(),
            configuration: about.configuration.clone(),
            seed: about.seed,
            realtime_factor,
            started: now(),
            plan: serde_json::to_value(plan).unwrap_or_default(),
            progress: None,
            estimate: None,
            envelope: Vec::new(),
            runs: Vec::new(),
            validation: None,
            outcome: None,
            warnings: Vec::new(),
        }
    }
}

/// Who watches a trial that the server runs: the logbook, the viewers, the clock, the operator.
struct Watched {
    keeper: Keeper,
    tap: Tap,
    pace: Option<Pace>,
    stop: Arc<AtomicBool>,
}

impl Watch for Watched {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keeper.run_started(number, thrust, attempt);
        self.tap.run_started(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.keeper.step(step, trial);
        self.tap.step(step, trial);
        if let Some(pace) = &mut self.pace {
            pace.wait(step.sample.time_s);
        }
    }

    fn wants_intervals(&self) -> bool {
        true
    }

    fn interval(&mut self, refined: &Refined) {
        self.tap.interval(refined);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.tap.run_ended(run);
        // After the viewers, because it takes the record out.
        self.keeper.run_ended(run);
    }

    fn wants_abort(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

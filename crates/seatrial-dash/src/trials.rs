//! Trials that the server runs.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};

use seatrial::Step;
use seatrial::campaign::Run;
use seatrial::identification::{ReasonCode, Refined};
use seatrial::{Campaign, preview};
use seatrial_app::conduct::{Pace, Watch};
use seatrial_core::{List, Outcome, Plan, Trial};
use seatrial_logbook::{CampaignEntry, CampaignId, Keeper, Logbook, NewCampaign, Recorder};
use serde_json::Value;

use crate::api::{
    Check, GoOnOrder, PlanOrder, PlanPreview, Preflight, RepeatOrder, TrialOrder, TrialState,
};
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
    let mut plan = entered_plan(&entry)?;
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
    another(
        entry,
        &plan,
        order.seed,
        order.realtime_factor,
        order.agreed,
    )
}

/// The order that goes on with a campaign that ended early, at the first speed that is not done.
pub fn go_on(shared: &Shared, order: GoOnOrder) -> Result<TrialOrder, Refusal> {
    let id = order.campaign;
    let logbook = shared.reader()?;
    let entry = logbook.entry(CampaignId(id))?;
    let plan = entered_plan(&entry)?;
    let campaign = logbook.campaign(entry.id)?;
    let thrusts = List::from_slice(speeds_left(&plan, &campaign.runs)).unwrap_or_default();
    if thrusts.is_empty() {
        return Err(Refusal::unprocessable(
            "nothing_left",
            format!("campaign {id} has been at every speed of its plan; repeat one of them"),
        ));
    }
    let plan = Plan { thrusts, ..plan };
    another(
        entry,
        &plan,
        order.seed,
        order.realtime_factor,
        order.agreed,
    )
}

/// The speeds of a plan from the first that is not done. One is done when its last run was accepted or used up the attempts; a run
/// that was not judged yet when the next one began is neither.
fn speeds_left<'a>(plan: &'a Plan<f64>, runs: &[Run]) -> &'a [f64] {
    let is_done = |tries: &[Run]| {
        tries.last().is_some_and(|last| {
            let mut reasons = last.verdict.reasons.iter();
            let broke_off =
                reasons.any(|r| matches!(r.code, ReasonCode::Aborted | ReasonCode::Interrupted));
            last.verdict.accepted || (!broke_off && last.attempt > plan.max_repeats)
        })
    };
    let speeds = runs.chunk_by(|_, next| next.attempt > 1);
    let done = speeds.take_while(|tries| is_done(tries)).count();
    plan.thrusts.get(done..).unwrap_or_default()
}

fn entered_plan(entry: &CampaignEntry) -> Result<Plan<f64>, Refusal> {
    toml::from_str(&entry.plan).map_err(|error| {
        Refusal::unprocessable("plan_refused", format!("the campaign's plan: {error}"))
    })
}

/// The order of another trial on the same vehicle in the same configuration, with the next seed where none is asked for.
fn another(
    entry: CampaignEntry,
    plan: &Plan<f64>,
    seed: Option<u64>,
    realtime_factor: Option<f64>,
    agreed: bool,
) -> Result<TrialOrder, Refusal> {
    Ok(TrialOrder {
        vehicle: entry.vehicle,
        plan: Some(serde_json::to_value(plan).map_err(Refusal::internal)?),
        seed: seed.or(entry.seed.map(|seed| seed.wrapping_add(1))),
        realtime_factor,
        configuration: Some(entry.configuration),
        note: None,
        agreed,
    })
}

/// What the conductor does.
pub type Work = Box<dyn FnOnce() + Send>;

/// A thread for the one trial. It is there before the server's own threads, which let it go first, as a thread is as nice as the
/// one that started it.
pub fn conductor() -> Sender<Work> {
    let (works, work) = channel::<Work>();
    std::thread::spawn(move || {
        for work in work {
            // The next trial needs the thread, too.
            let _ = catch_unwind(AssertUnwindSafe(work));
        }
    });
    works
}

/// Starts a trial: takes the vehicle, enters the campaign, conducts it on the conductor's thread.
pub fn start(shared: &Arc<Shared>, order: TrialOrder) -> Result<TrialState, Refusal> {
    let plan = plan_of(order.plan.clone())?;
    let vehicle = shared.vehicle(&order.vehicle)?;
    check(&order, vehicle.is_simulated)?;
    let stop = Arc::new(AtomicBool::new(false));
    let place = Place::take(shared, &stop)?;
    let (answer, answered) = channel();
    let work = move || match begin(order, plan, vehicle.is_simulated, stop, place) {
        Ok((state, under_way)) => {
            // The trial goes on also where nobody waits for the answer any more.
            let _ = answer.send(Ok(state));
            under_way.conduct();
        }
        Err(refusal) => {
            let _ = answer.send(Err(refusal));
        }
    };
    let gone = || Refusal::internal("a bug: the trial could not be begun");
    shared.conductor.send(Box::new(work)).map_err(|_| gone())?;
    answered.recv().unwrap_or_else(|_| Err(gone()))
}

fn begin(
    order: TrialOrder,
    plan: Plan<f64>,
    is_simulated: bool,
    stop: Arc<AtomicBool>,
    place: Place,
) -> Result<(TrialState, UnderWay), Refusal> {
    let shared = Arc::clone(&place.shared);
    let seed = order.seed.unwrap_or(1);
    let craft = shared.workshop.take(&Take {
        vehicle: order.vehicle.clone(),
        plan,
        plan_is_given: order.plan.is_some(),
        seed,
        stop: Arc::clone(&stop),
    });
    let mut craft = craft.map_err(|why| Refusal::unprocessable("vehicle_refused", why))?;
    let about = Campaign {
        software_version: env!("CARGO_PKG_VERSION").into(),
        vehicle: order.vehicle,
        configuration: order.configuration.unwrap_or_else(|| "default".into()),
        seed: is_simulated.then_some(seed),
        rudder_limit_rad: plan.rudder_limit_rad,
        runs: Vec::new(),
        outcome: None,
    };
    let recorder = begun(&shared, &about, order.note.as_deref(), &plan).inspect_err(|_| {
        craft.hand_back();
    })?;
    let state = TrialState::begun(recorder.campaign(), &about, &plan, order.realtime_factor);
    if let Some(running) = &mut shared.slot().running {
        running.campaign = Some(state.campaign);
    }
    let tap = shared.live.tap();
    tap.started(state.clone(), &plan);
    let watched = Watched {
        keeper: Keeper::new(recorder, !is_simulated),
        tap,
        pace: order.realtime_factor.map(Pace::new),
        stop,
    };
    let under_way = UnderWay {
        craft,
        plan,
        about,
        watched,
        place,
    };
    Ok((state, under_way))
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

/// A trial that has begun.
struct UnderWay {
    craft: Box<dyn Craft>,
    plan: Plan<f64>,
    about: Campaign,
    watched: Watched,
    place: Place,
}

impl UnderWay {
    /// Conducts it to its end, whatever that is.
    fn conduct(self) {
        let Self {
            mut craft,
            plan,
            about,
            mut watched,
            mut place,
        } = self;
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
        warnings.extend(watched.keeper.end(outcome).unsaved);
        let tap = watched.tap;
        place.last_word = Some(Box::new(move || tap.ended(outcome, warnings)));
    }
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
        self.keeper.run_ended(run);
        self.tap.run_ended(run);
        self.keeper.release(run);
    }

    fn wants_abort(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial::Record;
    use seatrial::identification::{Reason, Verdict};

    fn run(attempt: u32, accepted: bool, code: ReasonCode) -> Run {
        Run {
            number: 1,
            thrust: 0.6,
            attempt,
            surge_speed_m_s: None,
            stages: Vec::new(),
            record: Record::default(),
            identification: None,
            verdict: Verdict {
                accepted,
                reasons: vec![Reason {
                    code,
                    text: String::new(),
                }],
            },
        }
    }

    #[test]
    fn exact_a_campaign_goes_on_at_the_first_speed_that_is_not_done() {
        let plan = Plan {
            thrusts: List::from_slice(&[0.6, 0.7, 0.8]).unwrap(),
            max_repeats: 1,
            ..Plan::paper()
        };
        let good = || run(1, true, ReasonCode::Ok);
        let left = |runs: &[Run]| speeds_left(&plan, runs).to_vec();
        assert_eq!(left(&[]), [0.6, 0.7, 0.8]);
        assert_eq!(left(&[good()]), [0.7, 0.8]);
        assert_eq!(
            left(&[good(), run(1, false, ReasonCode::Interrupted)]),
            [0.7, 0.8]
        );
        assert_eq!(
            left(&[good(), run(1, false, ReasonCode::LowR2)]),
            [0.7, 0.8]
        );
        let twice = [
            good(),
            run(1, false, ReasonCode::LowR2),
            run(2, false, ReasonCode::LowR2),
        ];
        assert_eq!(left(&twice), [0.8]);
        let aborted = [
            good(),
            run(1, false, ReasonCode::LowR2),
            run(2, false, ReasonCode::Aborted),
        ];
        assert_eq!(left(&aborted), [0.7, 0.8]);
        let unjudged = [
            run(1, false, ReasonCode::Interrupted),
            run(1, false, ReasonCode::Interrupted),
        ];
        assert_eq!(left(&unjudged), [0.6, 0.7, 0.8]);
        assert!(left(&[good(), good(), good()]).is_empty());
    }
}

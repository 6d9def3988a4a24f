//! Trials that the server starts, and what is asked before one.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

use seatrial::preview::Budget;
use seatrial_app::trials::order::{
    self, Order, OrderError, RepeatError, Sinks, TrialUnderWay, VehicleError, plan_that_repeats,
    plan_to_go_on, previewed,
};
use seatrial_app::trials::simulator::{Scenario, Simulator};
use seatrial_app::{CheckedPlan, TrialPlan};
use seatrial_logbook::{CampaignEntry, CampaignId, Circumstances};

use crate::api::{
    GoOnOrder, PlanOrder, PlanPreview, Preflight, RepeatOrder, Role, TrialOrder, TrialState,
};
use crate::refusal::Refusal;
use crate::server_state::{Caller, LONGEST_NOTE, ServerState, Work};
use crate::slot::TrialPlace;

/// Slower than this an abort would have to wait for the vehicle's next sample.
const SLOWEST: f64 = 0.1;
/// Longest name of a configuration, characters.
const LONGEST_NAME: usize = 200;

/// The plan of an order; the paper's where there is none.
fn plan_of(plan: Option<TrialPlan>) -> Result<CheckedPlan, Refusal> {
    let checked = plan.unwrap_or_default().checked();
    checked.map_err(|why| Refusal::unprocessable("plan_refused", format!("the plan: {why}")))
}

/// What somebody may have computed: samples, some 200 bytes each, and time.
#[derive(Clone, Copy)]
pub struct Allowance {
    samples: usize,
    longest: Duration,
}

impl Allowance {
    /// What the caller may have computed. A viewer's is a long plan of a quick vehicle.
    pub fn of(caller: &Caller) -> Self {
        match caller.role {
            Some(Role::Operator) => Self { samples: 500_000, longest: Duration::from_secs(10) },
            _ => Self { samples: 100_000, longest: Duration::from_secs(2) },
        }
    }

    /// Does something within it, as long as the client waits for the answer.
    fn spend<T>(self, is_waited_for: &AtomicBool, call: impl FnOnce(&Budget) -> T) -> T {
        let begun = Instant::now();
        let is_wanted = || is_waited_for.load(Ordering::Relaxed) && begun.elapsed() < self.longest;
        call(&Budget::while_wanted(self.samples, &is_wanted))
    }
}

/// What a plan will do.
pub fn preview(
    shared: &ServerState,
    order: PlanOrder,
    allowance: Allowance,
    is_waited_for: &AtomicBool,
) -> Result<PlanPreview, Refusal> {
    let plan = plan_of(order.plan)?;
    let vehicle = shared.vehicle(&order.vehicle)?;
    let preview = allowance
        .spend(is_waited_for, |budget| previewed(vehicle, &plan, budget))
        .map_err(|error| Refusal::unprocessable("no_preview", error))?;
    Ok(PlanPreview::of(&plan, &preview))
}

/// The checklist before a trial.
pub fn preflight(
    shared: &ServerState,
    order: PlanOrder,
    allowance: Allowance,
    is_waited_for: &AtomicBool,
) -> Result<Preflight, Refusal> {
    let plan = plan_of(order.plan)?;
    let vehicle = shared.vehicle(&order.vehicle)?;
    let is_free = !shared.slot.is_taken();
    if !vehicle.is_simulated() && !is_free {
        return Err(Refusal::conflict("trial_running", "a trial runs on the vehicle"));
    }
    let found = allowance
        .spend(is_waited_for, |budget| order::preflight(vehicle, &plan, is_free, budget))
        .map_err(|error| Refusal::unprocessable("not_reached", error))?;
    Ok(found.into())
}

/// The trial that runs one speed of a campaign again.
pub fn repeat(shared: &ServerState, order: RepeatOrder) -> Result<TrialOrder, Refusal> {
    let entry = shared.reader()?.entry(CampaignId(order.campaign))?;
    let plan = plan_that_repeats(&entry, order.thrust)?;
    Ok(TrialOrder {
        realtime_factor: order.realtime_factor,
        agreed: order.agreed,
        ..another(entry, plan, order.seed)
    })
}

/// The trial that goes on with a campaign that ended early, at the first speed that is not done.
pub fn go_on(shared: &ServerState, order: GoOnOrder) -> Result<TrialOrder, Refusal> {
    let logbook = shared.reader()?;
    let entry = logbook.entry(CampaignId(order.campaign))?;
    let campaign = logbook.campaign(entry.id)?;
    let plan = plan_to_go_on(&entry, &campaign.runs)?;
    Ok(TrialOrder {
        realtime_factor: order.realtime_factor,
        agreed: order.agreed,
        ..another(entry, plan, order.seed)
    })
}

/// Another trial on the vehicle of a campaign, in its configuration, with the next seed where none is asked for.
fn another(entry: CampaignEntry, plan: TrialPlan, seed: Option<u64>) -> TrialOrder {
    TrialOrder {
        vehicle: entry.vehicle,
        plan: Some(plan),
        seed: seed.or(entry.seed.map(|seed| seed.wrapping_add(1))),
        configuration: Some(entry.configuration),
        ..TrialOrder::default()
    }
}

/// A thread for the one trial. It is there before the server's own threads, which let it go first: a thread is as nice as
/// the one that started it.
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
pub fn start(
    shared: &Arc<ServerState>,
    wanted: TrialOrder,
    operator: &str,
) -> Result<TrialState, Refusal> {
    let plan_is_given = wanted.plan.is_some();
    let plan = plan_of(wanted.plan)?;
    let is_simulated = shared.vehicle(&wanted.vehicle)?.is_simulated();
    check(&wanted, is_simulated)?;
    let faulty = faulty(&wanted)?;
    let stop = Arc::default();
    let shown = shared.slot.take(&stop, shared.live.tap())?;
    let order = Order {
        plan,
        plan_is_given,
        seed: wanted.seed.unwrap_or(1),
        configuration: wanted.configuration.unwrap_or_else(|| "default".into()),
        notes: wanted.note,
        circumstances: Circumstances {
            operator: Some(operator.to_owned()),
            ..Circumstances::default()
        },
        realtime_factor: wanted.realtime_factor,
        is_agreed: true,
        stop,
    };
    let (answer, answered) = channel();
    let served = Arc::clone(shared);
    let work = move || match begin(&served, &wanted.vehicle, faulty.as_ref(), order, shown) {
        Ok(under_way) => {
            // The trial goes on also where nobody waits for the answer any more.
            let _ = answer.send(Ok(TrialState::of(under_way.begun())));
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

/// The simulator that plays the faults of a scenario that comes with the program; no file of this machine is read.
fn faulty(wanted: &TrialOrder) -> Result<Option<Simulator>, Refusal> {
    let Some(scenario) = &wanted.scenario else {
        return Ok(None);
    };
    let known: Vec<&str> = Scenario::built_in().into_iter().map(|(name, _)| name).collect();
    if !known.contains(&scenario.as_str()) {
        return Err(Refusal::unprocessable(
            "unknown_scenario",
            format!("scenario {scenario:?}: expected one of {}", known.join(", ")),
        ));
    }
    let simulator = Simulator::new(&wanted.vehicle, Some(Path::new(scenario)));
    let simulator = simulator.map_err(|error| Refusal::unprocessable("vehicle_refused", error))?;
    Ok(Some(simulator))
}

fn begin(
    shared: &ServerState,
    vehicle: &str,
    faulty: Option<&Simulator>,
    order: Order,
    shown: TrialPlace,
) -> Result<TrialUnderWay, Refusal> {
    let vehicle = match faulty {
        Some(simulator) => simulator,
        None => shared.vehicle(vehicle)?,
    };
    let sinks =
        Sinks { logbook: shared.logbook.clone(), views: vec![Box::new(shown)], ..Sinks::default() };
    Ok(order::begin(vehicle, order, sinks)?)
}

fn check(wanted: &TrialOrder, is_simulated: bool) -> Result<(), Refusal> {
    let refused = |code, message: &str| Err(Refusal::unprocessable(code, message));
    if let Some(factor) = wanted.realtime_factor {
        if !is_simulated {
            return refused("not_simulated", "realtime_factor goes with a simulated vehicle");
        }
        if !(SLOWEST..=1e6).contains(&factor) {
            return refused("out_of_range", "realtime_factor: expected 0.1 to 1000000");
        }
    }
    if wanted.scenario.is_some() && !is_simulated {
        return refused("not_simulated", "scenario goes with a simulated vehicle");
    }
    if !is_simulated && !wanted.agreed {
        return refused(
            "agreement_needed",
            "a vehicle that moves must be agreed to: say \"agreed\": true",
        );
    }
    let name = wanted.configuration.as_ref();
    if name.is_some_and(|name| name.trim().is_empty() || name.chars().count() > LONGEST_NAME) {
        return refused("out_of_range", "configuration: expected 1 to 200 characters");
    }
    let length = wanted.note.as_ref().map_or(0, |note| note.chars().count());
    if length > LONGEST_NOTE {
        return refused("out_of_range", "note: expected at most 4000 characters");
    }
    Ok(())
}

impl From<RepeatError> for Refusal {
    fn from(error: RepeatError) -> Self {
        let code = match error {
            RepeatError::Plan(_) => "plan_refused",
            RepeatError::NoSuchThrust { .. } => "no_such_thrust",
            RepeatError::NothingLeft { .. } => "nothing_left",
        };
        Self::unprocessable(code, error)
    }
}

impl From<OrderError> for Refusal {
    fn from(error: OrderError) -> Self {
        match error {
            OrderError::Plan(_) => Self::unprocessable("plan_refused", error),
            OrderError::PlanText(_) => Self::internal(error),
            OrderError::Vehicle(VehicleError::Internal(_)) => Self::internal(error),
            OrderError::Vehicle(_) => Self::unprocessable("vehicle_refused", error),
            OrderError::Logbook(error) => error.into(),
        }
    }
}

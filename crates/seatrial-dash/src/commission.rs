//! Commissions that the server runs: gains into an autopilot, tried by heading steps.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;

use seatrial::gains::commission::{Foreseen, Range, Response};
use seatrial::identification::Reader;
use seatrial_app::advice::addressed;
use seatrial_app::trials::campaign_models::of_entry;
use seatrial_app::trials::commission::{
    AutopilotContact, CommissionResult, ControlLoss, Ending, GainsLease, GainsVehicle, Order,
    Proposal, PutBack, Request, RestoreFile, conduct, models_for,
};
use seatrial_app::trials::order::{Change, plan_of_campaign};
use seatrial_core::{CascadeSettings, Sample, SchedulePoint};
use seatrial_logbook::CampaignId;

use crate::api::{
    CommissionEnd, CommissionOrder, CommissionPreview, CommissionSample, CommissionState,
    ExpectedSteps, MeasuredSteps, ParameterBack, ProposedGains, UndoOrder, UndoPreview, Undone,
};
use crate::board::Board;
use crate::convert::now;
use crate::refusal::Refusal;
use crate::server_state::ServerState;
use crate::slot::Place;

/// Size of the steps where nobody says another, rad.
const STEP_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// What is said of a commission whose old gains an operator has put back.
const UNDONE: &str = "an undo has put the gains from before the commission back";

/// What is asked for, and of whom.
struct CommissionJob<'a> {
    vehicle: &'a dyn GainsVehicle,
    request: Request,
}

impl<'a> CommissionJob<'a> {
    fn of(shared: &'a ServerState, order: &CommissionOrder) -> Result<Self, Refusal> {
        let vehicle = shared.autopilot(&order.vehicle)?;
        let logbook = shared.reader()?;
        let entry = logbook.entry(CampaignId(order.campaign))?;
        let no_model = |error| Refusal::unprocessable("no_model", error);
        let models = of_entry(&logbook, &entry).map_err(no_model)?;
        let models = models_for(models, order.rehearsal, vehicle.full_rudder());
        let plan = plan_of_campaign(&entry).map_err(|error| {
            Refusal::unprocessable("plan_refused", format!("the campaign's plan: {error}"))
        })?;
        let request = Request {
            models: models.map_err(no_model)?,
            plan: plan.plan,
            at_speed_m_s: order.at_speed_m_s,
            step_rad: order.step_rad.unwrap_or(STEP_RAD),
        };
        request.check().map_err(|error| Refusal::unprocessable("out_of_range", error))?;
        Ok(Self { vehicle, request })
    }

    fn reach(&self, stop: &Arc<AtomicBool>) -> Result<Box<dyn AutopilotContact>, Refusal> {
        let reached = self.vehicle.reach(&self.request.plan, stop);
        reached.map_err(|error| Refusal::unprocessable("vehicle_refused", error))
    }

    fn proposal(
        &self,
        reached: &dyn AutopilotContact,
    ) -> Result<(Proposal, ProposedGains), Refusal> {
        let proposal = self.request.proposal(reached);
        let proposal = proposal.map_err(|error| Refusal::unprocessable("no_gains", error))?;
        let shown = proposed_gains(&proposal, reached.changes(&proposal.settings));
        Ok((proposal, shown))
    }
}

/// What a commission would do; the vehicle is looked at and not touched.
pub fn preview(
    shared: &ServerState,
    order: &CommissionOrder,
) -> Result<CommissionPreview, Refusal> {
    if shared.slot.is_taken() {
        return Err(Refusal::conflict(
            "trial_running",
            "a trial or a commission runs on a vehicle; wait for its end or abort it",
        ));
    }
    let asked = CommissionJob::of(shared, order)?;
    let reached = asked.reach(&Arc::default())?;
    let preflight = reached.preflight().clone();
    let proposal = match preflight.is_passed() {
        true => asked.proposal(reached.as_ref()).map(|(_, shown)| Some(shown)),
        false => Ok(None),
    };
    let is_passed = preflight.is_passed();
    let checklist = crate::api::Preflight::from(preflight);
    let (proposed, refused) = match proposal {
        Ok(proposed) => (proposed, None),
        Err(refusal) => (None, Some(refusal.message)),
    };
    Ok(CommissionPreview {
        ready: is_passed && proposed.is_some(),
        checks: checklist.checks,
        changes: checklist.changes,
        refused,
        proposed,
    })
}

/// Starts a commission: looks at the vehicle again, takes it, and conducts the steps on the conductor's thread.
pub fn start(
    shared: &Arc<ServerState>,
    order: CommissionOrder,
) -> Result<CommissionState, Refusal> {
    if !order.agreed {
        return Err(Refusal::unprocessable(
            "agreement_needed",
            "a vehicle that moves and whose gains change must be agreed to: say \"agreed\": true",
        ));
    }
    // What can be refused without the vehicle is refused at once.
    CommissionJob::of(shared, &order)?;
    let stop = Arc::default();
    let place = shared.slot.place(&stop)?;
    let (answer, answered) = channel();
    let served = Arc::clone(shared);
    let work = move || {
        // The commission goes on also where nobody waits for the answer any more.
        let begun = |state: &CommissionState| {
            let _ = answer.send(Ok(state.clone()));
        };
        if let Err(refusal) = run(&served, &order, &stop, place, &begun) {
            let _ = answer.send(Err(refusal));
        }
    };
    let gone = || Refusal::internal("a bug: the commission could not be begun");
    shared.conductor.send(Box::new(work)).map_err(|_| gone())?;
    answered.recv().unwrap_or_else(|_| Err(gone()))
}

fn run(
    shared: &ServerState,
    order: &CommissionOrder,
    stop: &Arc<AtomicBool>,
    place: Place,
    begun: &dyn Fn(&CommissionState),
) -> Result<(), Refusal> {
    let asked = CommissionJob::of(shared, order)?;
    let reached = asked.reach(stop)?;
    let mut checks = reached.preflight().checks.iter();
    if let Some(failed) = checks.find(|check| !check.passed) {
        return Err(Refusal::unprocessable(
            "vehicle_refused",
            format!("{}: {}", failed.name, failed.text),
        ));
    }
    let (proposal, shown) = asked.proposal(reached.as_ref())?;
    let seen = order.proposal.as_ref();
    if seen.is_some_and(|seen| *seen != shown.proposal) {
        return Err(Refusal::conflict(
            "proposal_changed",
            "the autopilot's gains or the campaign are not those that were shown: look at the proposal again",
        ));
    }
    let taken = reached.take();
    let mut vehicle = WatchedVehicle {
        inner: taken.map_err(|error| Refusal::unprocessable("vehicle_refused", error))?,
        board: shared.commission.clone(),
        wanted_rad: None,
    };
    let state = CommissionState {
        running: true,
        vehicle: order.vehicle.clone(),
        campaign: order.campaign,
        started: now(),
        proposed: shown,
        stages: Vec::new(),
        old: None,
        new: None,
        ended: None,
        line: None,
        undo: None,
        needs_restoring: false,
    };
    let tap = shared.live.tap();
    shared.commission.begin(state.clone());
    tap.commission(state.clone());
    begun(&state);
    let work = Order { proposal: &proposal, envelope: asked.request.plan.envelope, stop };
    let found = conduct(&mut vehicle, &work, &mut |text| {
        let stage = addressed(text, Reader::Dashboard);
        shared.commission.change(&tap, |state| state.stages.push(stage));
    });
    // Who sees the end may begin the next one.
    drop(place);
    shared.commission.change(&tap, |state| ended(state, &found));
    Ok(())
}

/// What of a trial or a commission could be put back; nothing is written.
pub fn preview_undo(shared: &ServerState, order: &UndoOrder) -> Result<UndoPreview, Refusal> {
    let stop = Arc::default();
    let _place = shared.slot.place(&stop)?;
    let kept = kept(shared, order, &stop)?;
    let file = kept.file.file_name().unwrap_or_default();
    Ok(UndoPreview {
        undo: name_of_undo(&kept),
        file: file.to_string_lossy().into_owned(),
        has_mode: kept.mode.is_some(),
        parameters: kept.parameters.into_iter().map(parameter_back).collect(),
    })
}

/// Puts it back, where it is what a preview has shown.
pub fn undo(shared: &ServerState, order: &UndoOrder) -> Result<Undone, Refusal> {
    if !order.agreed {
        return Err(Refusal::unprocessable(
            "agreement_needed",
            "parameters that are written must be agreed to: say \"agreed\": true",
        ));
    }
    let stop = Arc::default();
    let place = shared.slot.place(&stop)?;
    let kept = kept(shared, order, &stop)?;
    if order.undo.as_ref() != Some(&name_of_undo(&kept)) {
        return Err(Refusal::conflict(
            "undo_changed",
            "the autopilot's values or what is kept of them are not those that were shown: look again",
        ));
    }
    let done = shared.autopilot(&order.vehicle)?.put_back(&kept.file, &stop);
    drop(place);
    let done = done.map_err(|error| Refusal::unprocessable("vehicle_refused", error))?;
    let line = addressed(&done.line, Reader::Dashboard);
    let tap = shared.live.tap();
    shared.commission.change(&tap, |state| {
        if done.is_complete && state.vehicle == order.vehicle {
            state.undo = None;
            state.needs_restoring = false;
            state.ended = Some(CommissionEnd::PutBack);
            state.line = Some(UNDONE.into());
        }
    });
    Ok(Undone {
        complete: done.is_complete,
        line,
        parameters: done.parameters.into_iter().map(parameter_back).collect(),
    })
}

fn kept(
    shared: &ServerState,
    order: &UndoOrder,
    stop: &Arc<AtomicBool>,
) -> Result<RestoreFile, Refusal> {
    let kept = shared.autopilot(&order.vehicle)?.kept(stop);
    kept.map_err(|error| Refusal::unprocessable("nothing_to_undo", error))
}

fn name_of_undo(kept: &RestoreFile) -> String {
    let mut hasher = DefaultHasher::new();
    (&kept.file, kept.mode).hash(&mut hasher);
    for value in &kept.parameters {
        (&value.name, value.from.map(f64::to_bits), value.to.to_bits()).hash(&mut hasher);
    }
    format!("{:016x}", hasher.finish())
}

fn parameter_back(value: PutBack) -> ParameterBack {
    ParameterBack { name: value.name, from: value.from, to: value.to }
}

fn ended(state: &mut CommissionState, found: &CommissionResult) {
    state.running = false;
    state.line = Some(addressed(&found.line(), Reader::Dashboard));
    state.needs_restoring = found.not_put_back.is_some();
    state.old = found.old.as_ref().map(measured);
    state.new = found.new.as_ref().map(measured);
    let (ended, undo) = match &found.ending {
        Ending::Kept { undo } => (CommissionEnd::Kept, Some(undo.clone())),
        Ending::PutBack { .. } => (CommissionEnd::PutBack, None),
        Ending::Refused => (CommissionEnd::Refused, None),
        Ending::Aborted { .. } => (CommissionEnd::Aborted, None),
    };
    state.ended = Some(ended);
    state.undo = undo;
}

fn proposed_gains(proposal: &Proposal, changes: Vec<Change>) -> ProposedGains {
    let mut hasher = DefaultHasher::new();
    for change in &changes {
        (&change.name, change.from.to_bits(), change.to.to_bits()).hash(&mut hasher);
    }
    proposal.test.step_rad.to_bits().hash(&mut hasher);
    ProposedGains {
        proposal: format!("{:016x}", hasher.finish()),
        parameters: changes,
        surge_speed_m_s: proposal.model.surge_speed_m_s,
        step_rad: proposal.test.step_rad,
        duration_s: proposal.duration_s(),
        distance_m: proposal.distance_m(),
        old_expected: expected(&proposal.old_foreseen),
        new_expected: expected(&proposal.new_foreseen),
    }
}

fn expected(foreseen: &Foreseen) -> ExpectedSteps {
    let bounds = |range: Range| [range.low, range.high];
    ExpectedSteps {
        overshoot: bounds(foreseen.overshoot),
        settling_s: bounds(foreseen.settling_s),
        rudder_per_s: bounds(foreseen.activity_per_s),
    }
}

fn measured(response: &Response) -> MeasuredSteps {
    MeasuredSteps {
        overshoot: response.overshoot,
        settling_s: response.settling_s,
        steady_error_rad: response.steady_error_rad,
        rudder_per_s: response.activity_per_s,
    }
}

/// A vehicle whose samples are shown.
struct WatchedVehicle {
    inner: Box<dyn GainsLease>,
    board: Board,
    wanted_rad: Option<f64>,
}

impl GainsLease for WatchedVehicle {
    fn next_sample(&mut self) -> Result<Sample<f64>, ControlLoss> {
        let sample = self.inner.next_sample()?;
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        self.board.sample(CommissionSample {
            time_s: sample.time_s,
            heading_rad: finite(sample.heading_rad),
            wanted_rad: self.wanted_rad,
            rudder: finite(sample.rudder_rad),
        });
        Ok(sample)
    }

    fn steer_to(&mut self, heading_rad: f64, model: &SchedulePoint<f64>) {
        self.inner.steer_to(heading_rad, model);
        self.wanted_rad = Some(heading_rad);
    }

    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), ControlLoss> {
        self.inner.write(settings)
    }

    fn keep(&mut self) -> Result<String, ControlLoss> {
        self.inner.keep()
    }

    fn hand_back(&mut self) -> Option<String> {
        self.inner.hand_back()
    }
}

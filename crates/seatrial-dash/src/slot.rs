//! The place of the one trial, and how a trial in it is shown.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use seatrial::campaign::Run;
use seatrial::identification::{Reader, Refined};
use seatrial::{Campaign, Step};
use seatrial_app::advice::addressed;
use seatrial_app::conduct::Watch;
use seatrial_app::trials::order::{CampaignStart, View};
use seatrial_core::Trial;

use crate::api::TrialState;
use crate::convert::utc;
use crate::live::Tap;
use crate::refusal::Refusal;

/// The place of the one trial.
#[derive(Clone, Debug, Default)]
pub struct Slot(Arc<Mutex<Option<SlotHolder>>>);

#[derive(Debug)]
struct SlotHolder {
    /// `None` while the vehicle is being taken, and of a commission.
    campaign: Option<i64>,
    is_commission: bool,
    stop: Arc<AtomicBool>,
}

/// The place of the one trial, had by a commission until this is dropped.
#[derive(Debug)]
pub struct Place(Slot);

impl Drop for Place {
    fn drop(&mut self) {
        *self.0.running() = None;
    }
}

impl Slot {
    fn running(&self) -> MutexGuard<'_, Option<SlotHolder>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The campaign that runs.
    pub fn campaign(&self) -> Option<i64> {
        self.running().as_ref()?.campaign
    }

    /// Does a trial have the place?
    pub fn is_taken(&self) -> bool {
        self.running().is_some()
    }

    /// The campaign that runs, if any, and what ends it; `None` where no trial has the place.
    pub fn stop(&self) -> Option<(Option<i64>, Arc<AtomicBool>)> {
        let running = self.running();
        let running = running.as_ref()?;
        Some((running.campaign, Arc::clone(&running.stop)))
    }

    /// Is it a commission that has the place?
    pub fn is_commission(&self) -> bool {
        let running = self.running();
        running.as_ref().is_some_and(|running| running.is_commission)
    }

    /// Takes the place for a commission that ends when the flag is set.
    pub fn place(&self, stop: &Arc<AtomicBool>) -> Result<Place, Refusal> {
        self.enter(stop, true)?;
        Ok(Place(self.clone()))
    }

    fn enter(&self, stop: &Arc<AtomicBool>, is_commission: bool) -> Result<(), Refusal> {
        let mut running = self.running();
        if let Some(running) = running.as_ref() {
            let what = match running.is_commission {
                true => "a commission runs; wait for its end or abort it",
                false => "a trial runs; wait for its end or abort it",
            };
            return Err(Refusal::conflict("trial_running", what));
        }
        *running = Some(SlotHolder { campaign: None, is_commission, stop: Arc::clone(stop) });
        Ok(())
    }

    /// Takes the place for a trial that ends when the flag is set, and that is shown through the tap.
    pub fn take(&self, stop: &Arc<AtomicBool>, tap: Tap) -> Result<TrialPlace, Refusal> {
        self.enter(stop, false)?;
        Ok(TrialPlace { slot: self.clone(), tap, has_place: true })
    }
}

/// A trial that the dashboard shows. It has the place of the one trial until it has ended or this is dropped.
#[derive(Debug)]
pub struct TrialPlace {
    slot: Slot,
    tap: Tap,
    has_place: bool,
}

impl Drop for TrialPlace {
    fn drop(&mut self) {
        if self.has_place {
            *self.slot.running() = None;
        }
    }
}

impl View for TrialPlace {
    fn begun(&mut self, begun: &CampaignStart) {
        if let Some(running) = self.slot.running().as_mut() {
            running.campaign = Some(begun.campaign.0);
        }
        self.tap.started(TrialState::of(begun), &begun.plan);
    }

    /// Shows the end and frees the slot under one lock: a client that sees the end may begin the next trial.
    fn ended(&mut self, campaign: &Campaign, warnings: &[String]) {
        let mut running = self.slot.running();
        let warnings = warnings.iter().map(|text| addressed(text, Reader::Dashboard));
        self.tap.ended(campaign, warnings.collect());
        *running = None;
        self.has_place = false;
    }
}

impl Watch for TrialPlace {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.tap.run_started(number, thrust, attempt);
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        self.tap.step(step, trial);
    }

    fn wants_intervals(&self) -> bool {
        true
    }

    fn interval(&mut self, refined: &Refined) {
        self.tap.interval(refined);
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.tap.run_ended(run);
    }
}

impl TrialState {
    /// A trial that has just begun.
    pub(crate) fn of(begun: &CampaignStart) -> Self {
        let about = &begun.about;
        Self {
            campaign: begun.campaign.0,
            running: true,
            vehicle: about.vehicle.clone(),
            configuration: about.configuration.clone(),
            seed: about.seed,
            realtime_factor: begun.realtime_factor,
            started: utc(begun.time),
            plan: *begun.plan,
            progress: None,
            estimate: None,
            envelope: Vec::new(),
            runs: Vec::new(),
            validation: None,
            verdict: None,
            outcome: None,
            warnings: Vec::new(),
        }
    }
}

//! One trial from its order to the vehicle's return, for the terminal and the dashboard alike.
//!
//! ```text
//! begin   take the vehicle, enter the campaign in the logbook, show it
//! conduct run the plan; hand the vehicle back; then keep, record and show how it ended
//! ```
//!
//! The vehicle goes before everything else: it is handed back before anything is written or shown, also where the program
//! fails.

mod again;
mod recording_thread;
mod sink_watch;
mod vehicle;
mod vehicle_loan;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;

use seatrial::Campaign;
use seatrial_core::{InvalidSetting, Plan, Vehicle};
use seatrial_logbook::{CampaignId, Circumstances, Logbook, NewCampaign, Recorder};
use seatrial_logs::RowWriter;

use crate::conduct::{Judging, NoWatch, Pace, TrialResult, Watch, conduct, conduct_judging};
use crate::trials::recording::Recording;
use crate::{CheckedPlan, TrialPlan};
use sink_watch::SinkWatch;
use vehicle_loan::VehicleLoan;

pub use again::{RepeatError, plan_of_campaign, plan_that_repeats, plan_to_go_on};
pub use seatrial_links::handover::{Change, Check, Preflight};
pub use vehicle::{
    Terms, TrialVehicle, VehicleError, VehicleFault, VehicleLease, preflight, previewed, taken,
};

/// What is to be run.
#[derive(Clone, Debug)]
pub struct Order {
    /// The plan.
    pub plan: CheckedPlan,
    /// Was the plan given, or is it the default?
    pub plan_is_given: bool,
    /// Seed of a simulated vehicle.
    pub seed: u64,
    /// Name of the vehicle's configuration, its payload.
    pub configuration: String,
    /// Notes on the configuration.
    pub notes: Option<String>,
    /// Who conducts it, and where. The firmware is the vehicle's to say.
    pub circumstances: Circumstances,
    /// How many times faster than real time a simulated vehicle runs; `None` is as fast as it can.
    pub realtime_factor: Option<f64>,
    /// Has somebody agreed that the vehicle moves?
    pub is_agreed: bool,
    /// Set when the operator wants the vehicle back.
    pub stop: Arc<AtomicBool>,
}

/// Where a trial is kept and shown.
#[derive(Default)]
pub struct Sinks {
    /// The logbook; made where there is none.
    pub logbook: PathBuf,
    /// A log that grows with the trial.
    pub recording: Option<Recording>,
    /// Where each sample is shown with its estimate.
    pub rows: Vec<Box<dyn RowWriter>>,
    /// Views of the trial.
    pub views: Vec<Box<dyn View>>,
}

/// A view of a trial from its entry in the logbook to its end. It cannot delay the trial.
pub trait View: Watch {
    /// The campaign is in the logbook, and its first sample comes next.
    fn begun(&mut self, _begun: &CampaignStart) {}

    /// The vehicle's link was lost, or the program failed: why the vehicle is given back.
    fn faulted(&mut self, _why: &str) {}

    /// The vehicle was handed back and everything is kept, except for what the warnings say. The records of the runs that the logbook
    /// has are left out.
    fn ended(&mut self, _campaign: &Campaign, _warnings: &[String]) {}
}

/// A campaign that begins.
#[derive(Clone, Debug)]
pub struct CampaignStart {
    /// Its number in the logbook.
    pub campaign: CampaignId,
    /// What it is of; without runs.
    pub about: Campaign,
    /// The plan.
    pub plan: CheckedPlan,
    /// How many times faster than real time it runs; `None` is as fast as it can.
    pub realtime_factor: Option<f64>,
    /// When it begins.
    pub time: SystemTime,
}

/// Why no trial was begun. The vehicle was not taken, or has been handed back.
#[derive(Debug, thiserror::Error)]
pub enum OrderError {
    /// The plan has a field that is out of range.
    #[error("the plan: {0}")]
    Plan(#[from] InvalidSetting),
    /// The plan cannot be written down.
    #[error("the plan: {0}")]
    PlanText(#[from] toml::ser::Error),
    /// The vehicle cannot be used.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The campaign cannot be entered.
    #[error(transparent)]
    Logbook(#[from] seatrial_logbook::Error),
}

/// A trial whose vehicle was taken and whose campaign was entered.
pub struct TrialUnderWay {
    vehicle: Box<dyn VehicleLease>,
    begun: CampaignStart,
    watched: SinkWatch,
}

/// What came of a trial.
#[derive(Debug)]
pub struct OrderResult {
    /// Number of its campaign in the logbook.
    pub number: CampaignId,
    /// Every run; without an outcome where a fault of the program ended it. Records and traces of runs that the
    /// logbook has are left out: [`Logbook::fill`] puts them back.
    pub campaign: Campaign,
    /// Why the vehicle was given back before the trial's end.
    pub fault: Option<String>,
    /// Does the logbook hold all of it?
    pub is_kept: bool,
    /// What could not be saved or put back.
    pub unsaved: Vec<String>,
}

/// Takes a vehicle and enters its campaign in the logbook of `sinks`.
///
/// # Errors
/// A vehicle whose rudder lag is out of its range or that cannot be taken, or a logbook that cannot be written. The vehicle was then
/// not taken, or has been handed back.
pub fn begin(
    vehicle: &dyn TrialVehicle,
    mut order: Order,
    sinks: Sinks,
) -> Result<TrialUnderWay, OrderError> {
    let knows_no_lag = !order.plan_is_given && order.plan.rudder_lag_s == 0.0;
    if knows_no_lag && order.plan.axis.is_yaw() {
        let rudder_lag_s = vehicle.rudder_lag_s();
        order.plan = TrialPlan { rudder_lag_s, ..*order.plan }.checked()?;
    }
    vehicle::check_axis(vehicle, order.plan.axis)?;
    let plan_text = toml::to_string_pretty(&*order.plan)?;
    // Nothing is written before the vehicle has answered.
    Logbook::check_writable(&sinks.logbook)?;
    let mut taken = vehicle.take(&Terms {
        plan: &order.plan,
        plan_is_given: order.plan_is_given,
        seed: order.seed,
        is_agreed: order.is_agreed,
        stop: &order.stop,
    })?;
    let about = campaign_on(vehicle, &order);
    let new = NewCampaign {
        configuration: &about.configuration,
        notes: order.notes.as_deref(),
        software_version: &about.software_version,
        vehicle: &about.vehicle,
        seed: about.seed,
        rudder_limit_rad: about.rudder_limit_rad,
        full_rudder: about.full_rudder,
        scenario: about.scenario.as_deref(),
        plan: &plan_text,
    };
    let circumstances = Circumstances {
        firmware: taken.firmware().or(order.circumstances.firmware.clone()),
        ..order.circumstances.clone()
    };
    let recorder = entered(&sinks.logbook, &new, &circumstances);
    let recorder = recorder.inspect_err(|_| {
        taken.hand_back();
    })?;
    let begun = CampaignStart {
        campaign: recorder.campaign(),
        about,
        plan: order.plan,
        realtime_factor: order.realtime_factor,
        time: SystemTime::now(),
    };
    let Sinks { recording, mut rows, mut views, .. } = sinks;
    rows.extend(taken.rows());
    views.iter_mut().for_each(|view| view.begun(&begun));
    let pace = order.realtime_factor.map(Pace::new);
    let watched = SinkWatch::new(recorder, taken.is_live(), recording, rows, views)
        .paced(pace)
        .stopped_by(order.stop);
    Ok(TrialUnderWay { vehicle: taken, begun, watched })
}

/// Enters a campaign, and who conducts it where.
fn entered(
    path: &Path,
    new: &NewCampaign,
    circumstances: &Circumstances,
) -> Result<Recorder, seatrial_logbook::Error> {
    let recorder = Recorder::begin(Logbook::open(path)?, new)?;
    if !circumstances.is_unknown() {
        Logbook::open(path)?.enter_circumstances(recorder.campaign(), circumstances)?;
    }
    Ok(recorder)
}

impl TrialUnderWay {
    /// The campaign.
    pub fn begun(&self) -> &CampaignStart {
        &self.begun
    }

    /// Conducts the trial to its end, whatever that is, and hands the vehicle back.
    pub fn conduct(self) -> OrderResult {
        let Self { vehicle, begun, mut watched } = self;
        let mut vehicle = VehicleLoan::new(vehicle);
        let about = begun.about.clone();
        let conducted = catch_unwind(AssertUnwindSafe(|| {
            let judging = Judging::Whole;
            conduct_judging(&mut vehicle, &begun.plan, about, &mut watched, judging)
        }));
        let not_put_back = vehicle.hand_back();
        let (campaign, fault) = match conducted {
            Ok(TrialResult { campaign, fault }) => (campaign, fault.map(|f| f.to_string())),
            Err(_) => (begun.about, Some("a fault of the program".into())),
        };
        let fault = fault.map(|why| format!("the vehicle was given back: {why}"));
        if let Some(why) = &fault {
            watched.faulted(why);
        }
        watched.end(begun.campaign, campaign, fault, not_put_back)
    }
}

/// Runs a trial on a simulated vehicle that nobody watches or keeps.
pub fn rehearse<V: Vehicle<f64>>(
    vehicle: &mut V,
    name: &str,
    seed: u64,
    plan: Plan<f64>,
) -> Result<TrialResult<V::Error>, InvalidSetting> {
    let about = Campaign { seed: Some(seed), ..Campaign::of(name, &plan) };
    conduct(vehicle, plan, about, &mut NoWatch)
}

fn campaign_on(vehicle: &dyn TrialVehicle, order: &Order) -> Campaign {
    Campaign {
        configuration: order.configuration.clone(),
        seed: vehicle.is_simulated().then_some(order.seed),
        full_rudder: vehicle.full_rudder(),
        scenario: vehicle.scenario(),
        ..Campaign::of(vehicle.name(), &order.plan)
    }
}

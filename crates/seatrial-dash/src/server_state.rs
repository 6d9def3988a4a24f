//! What every request sees.

use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use seatrial_app::trials::{commission::GainsVehicle, order::TrialVehicle};
use seatrial_logbook::{Logbook, NewCommand};
use serde::Serialize;
use tokio::sync::{Semaphore, watch};

use crate::access::{Claim, Leases, Rates, Tokens};
use crate::api::Role;
use crate::board::Board;
use crate::convert::name_of;
use crate::live::Live;
use crate::refusal::Refusal;
use crate::slot::Slot;
use crate::uploads::Uploads;

/// Longest note, characters.
pub const LONGEST_NOTE: usize = 4000;

/// What the conductor does.
pub type Work = Box<dyn FnOnce() + Send>;

/// What every request sees.
pub struct ServerState {
    /// The vehicles that trials may be run on.
    pub vehicles: Vec<Box<dyn TrialVehicle>>,
    /// The vehicles whose autopilot's gains may be tried.
    pub autopilots: Vec<Box<dyn GainsVehicle>>,
    pub logbook: PathBuf,
    /// For commands and reviews; trials have a writer of their own.
    pub writer: Mutex<Logbook>,
    pub tokens: Option<Tokens>,
    pub is_loopback: bool,
    pub hosts: Vec<String>,
    pub rates: Rates,
    pub leases: Leases,
    pub live: Live,
    pub viewers: AtomicU32,
    /// Where uploads lie while they are read, beside lists of sensors that were sent.
    pub uploads: Uploads,
    pub slot: Slot,
    /// The commission that runs, or the last one.
    pub commission: Board,
    /// How many requests may wait for a disk or compute at a time. An abort waits for none of them.
    pub lanes: Arc<Semaphore>,
    /// Where trials are conducted.
    pub conductor: Sender<Work>,
    pub closing: watch::Sender<bool>,
}

/// The sender of a request.
#[derive(Clone, Debug)]
pub struct Caller {
    /// What the caller may do; `None` while no token is known: a live stream sends its own in the first message.
    pub role: Option<Role>,
    pub address: IpAddr,
    pub lease: Option<String>,
}

impl ServerState {
    /// The logbook as it is now.
    pub fn reader(&self) -> Result<Logbook, Refusal> {
        Ok(Logbook::open_read_only(&self.logbook)?)
    }

    /// The vehicle of that name.
    pub fn vehicle(&self, name: &str) -> Result<&dyn TrialVehicle, Refusal> {
        let mut vehicles = self.vehicles.iter().map(|vehicle| vehicle.as_ref());
        vehicles.find(|vehicle| vehicle.name() == name).ok_or_else(|| {
            let known: Vec<&str> = self.vehicles.iter().map(|known| known.name()).collect();
            Refusal::unprocessable(
                "unknown_vehicle",
                format!("vehicle {name:?}: expected one of {}", known.join(", ")),
            )
        })
    }

    /// The vehicle of that name whose autopilot's gains may be tried.
    pub fn autopilot(&self, name: &str) -> Result<&dyn GainsVehicle, Refusal> {
        let mut autopilots = self.autopilots.iter().map(|vehicle| vehicle.as_ref());
        autopilots
            .find(|vehicle| vehicle.name() == name)
            .ok_or_else(|| {
                Refusal::unprocessable(
                    "no_autopilot",
                    format!("vehicle {name:?} is no autopilot behind MAVLink that this server was started with (--vehicle)"),
                )
            })
    }

    /// The name of who may command by this call.
    pub fn commander(&self, caller: &Caller) -> Result<String, Refusal> {
        must_be_operator(caller)?;
        match self.leases.claim(caller.lease.as_deref()) {
            Claim::Yours { name, .. } => Ok(name),
            Claim::Taken { by, since } => Err(taken(&by, &since)),
            Claim::Free => Err(Refusal::conflict(
                "control_needed",
                "nobody has control: take it with POST /api/v1/control and send its lease in the header seatrial-lease",
            )),
        }
    }

    /// Enters a command in the audit trail. What cannot be entered is said and does not undo the command.
    pub fn audit(
        &self,
        caller: &Caller,
        actor: &str,
        command: &str,
        details: &impl Serialize,
        result: Result<(), &Refusal>,
    ) {
        let details = serde_json::to_string(details).unwrap_or_default();
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        let entered = writer.enter_command(&NewCommand {
            actor,
            address: &caller.address.to_string(),
            command,
            details: &details,
            result: result.map_or_else(|refusal| refusal.code, |()| "done"),
        });
        if let Err(error) = entered {
            eprintln!("seatrial: the audit trail: {error}");
        }
    }

    /// Carries out a command of the caller who has control, and enters it in the audit trail.
    pub fn command<T>(
        &self,
        caller: &Caller,
        command: &str,
        details: &impl Serialize,
        done: impl FnOnce(&str) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        let (actor, result) = match self.commander(caller) {
            Ok(name) => {
                let result = done(&name);
                (name, result)
            }
            Err(refusal) => (caller.role.map_or_else(String::new, name_of), Err(refusal)),
        };
        self.audit(caller, &actor, command, details, result.as_ref().map(|_| ()));
        result
    }

    /// Lets a viewer in, if there is room.
    pub fn admit(self: &Arc<Self>) -> Option<Seat> {
        let seat = Seat(Arc::clone(self));
        (self.viewers.fetch_add(1, Ordering::Relaxed) < MOST_VIEWERS).then_some(seat)
    }

    /// Asks the trial to end; the number of its campaign, which it does not have while the vehicle is being taken.
    pub fn stop_trial(&self) -> Result<Option<i64>, Refusal> {
        let (campaign, stop) =
            self.slot.stop().ok_or_else(|| Refusal::conflict("no_trial", "no trial runs"))?;
        stop.store(true, Ordering::Relaxed);
        Ok(campaign)
    }
}

/// Viewers at a time.
pub const MOST_VIEWERS: u32 = 512;

/// A viewer's seat, free again when dropped.
pub struct Seat(Arc<ServerState>);

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Refuses callers who may only watch.
pub fn must_be_operator(caller: &Caller) -> Result<(), Refusal> {
    match caller.role {
        Some(Role::Operator) => Ok(()),
        _ => Err(Refusal::new(
            StatusCode::FORBIDDEN,
            "operators_only",
            "your token is a viewer's; commands and uploads need an operator's",
        )),
    }
}

/// A refusal that names who has control.
pub fn taken(by: &str, since: &str) -> Refusal {
    Refusal::conflict(
        "control_taken",
        format!("{by} has control since {since}; ask for it to be given back"),
    )
}

//! Autopilots that speak MAVLink: the link, preflight, taking one, handing it back.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use seatrial::FullRudder;
use seatrial::preview::{Budget, Prior};
use seatrial_core::{Plan, RudderSense};
use seatrial_links::autopilot::{
    Autopilot, AutopilotThread, Backup, HandBack, Profile, Response, Settings, SteeringOutputs,
};
use seatrial_links::link::{Address, Key, Signing, Transport};

use super::attendant::tell_all;
use super::{Attendant, hand_back_text, limits, no_prior, refuse};
use crate::trials::order::{Preflight, Terms, TrialVehicle, VehicleError, VehicleLease, taken};

/// The rudder at full steering where nobody says another, degrees.
pub const ASSUMED_FULL_RUDDER_DEG: f64 = 35.0;

/// How an autopilot is reached, and what nobody but its people knows of it.
#[derive(Clone, Debug)]
pub struct MavlinkOptions {
    /// Our system id.
    pub system_id: u8,
    /// System id of the vehicle; `None`: the first autopilot that is heard.
    pub vehicle_id: Option<u8>,
    /// Kind of autopilot; `None`: as it says.
    pub profile: Option<Profile>,
    /// Rudder angle at full steering, rad; `None`: [`ASSUMED_FULL_RUDDER_DEG`].
    pub full_rudder_rad: Option<f64>,
    /// Outputs that steer; `None`: as the parameters say.
    pub outputs: Option<SteeringOutputs>,
    /// There is no remote control: a change of mode from a ground station takes the vehicle over.
    pub without_remote_control: bool,
    /// Lowest charge of the battery, percent.
    pub lowest_battery_percent: i8,
    /// Rudder per heading error while a heading is held.
    pub heading_gain: f64,
    /// A key of 32 bytes or 64 hexadecimal digits: every frame is signed, and none without a signature is taken.
    pub signing_key: Option<PathBuf>,
}

/// Signing with the key of a file.
pub fn signing(path: Option<&Path>, link_id: u8) -> Result<Option<Signing>, VehicleError> {
    let Some(path) = path else {
        return Ok(None);
    };
    let key = Key::load(path).map_err(VehicleError::unreachable)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now_s = now.map_err(VehicleError::internal)?.as_secs_f64();
    Ok(Some(Signing::new(key, link_id, now_s)))
}

fn parsed(address: &str) -> Result<Address, VehicleError> {
    address.parse().map_err(|error| VehicleError::setting(format!("--vehicle mavlink:{error}")))
}

impl MavlinkOptions {
    /// The rudder at full steering.
    pub fn full_rudder(&self) -> FullRudder {
        let assumed_rad = ASSUMED_FULL_RUDDER_DEG.to_radians();
        FullRudder {
            angle_rad: self.full_rudder_rad.unwrap_or(assumed_rad),
            is_assumed: self.full_rudder_rad.is_none(),
        }
    }

    /// The link to an address, with the settings of a plan where there is one.
    pub fn open(
        &self,
        address: &str,
        plan: Option<&Plan<f64>>,
        is_given: bool,
        abort: &Arc<AtomicBool>,
    ) -> Result<Autopilot<Transport>, VehicleError> {
        let address = parsed(address)?;
        let full_rudder = self.full_rudder();
        let defaults = Settings::default();
        let settings = Settings {
            system_id: self.system_id,
            vehicle: self.vehicle_id,
            profile: self.profile,
            full_rudder_rad: full_rudder.angle_rad,
            is_full_rudder_assumed: full_rudder.is_assumed,
            outputs: self.outputs.clone(),
            sample_interval_s: plan.map_or(defaults.sample_interval_s, |p| p.sample_interval_s),
            lowest_battery_percent: self.lowest_battery_percent,
            without_remote_control: self.without_remote_control,
            heading_gain: self.heading_gain,
            heading_rudder_rad: plan
                .map_or(defaults.heading_rudder_rad, |p| 0.8 * p.rudder_limit_rad),
            trying_thrust: plan
                .and_then(|plan| plan.thrusts.first().copied())
                .unwrap_or(defaults.trying_thrust),
            most_asked: plan.map_or(defaults.most_asked, |plan| {
                let highest = plan.thrusts.iter().copied().fold(0.0, f64::max);
                highest + plan.rudder_limit_rad / full_rudder.angle_rad
            }),
            is_reversed: plan
                .is_some_and(|plan| plan.envelope.rudder_sense == RudderSense::Negative),
            envelope: plan.filter(|_| is_given).map(limits),
            abort: Arc::clone(abort),
            ..defaults
        };
        if let Some(plan) = plan
            && plan.rudder_limit_rad > settings.full_rudder_rad
        {
            return Err(VehicleError::setting(format!(
                "the plan's rudder_limit_rad is {:.1} degrees, more than the {:.1} degrees of --full-rudder-deg",
                plan.rudder_limit_rad.to_degrees(),
                full_rudder.angle_rad.to_degrees()
            )));
        }
        let wire = Transport::open(&address)
            .map_err(|error| VehicleError::unreachable(format!("mavlink:{address}: {error}")))?;
        let signing = signing(self.signing_key.as_deref(), 0)?;
        Ok(Autopilot::new(wire, settings, signing))
    }
}

/// An autopilot behind MAVLink that trials may be run on, and whose gains may be tried.
#[derive(Clone)]
pub struct OnMavlink {
    pub(super) name: String,
    pub(super) address: String,
    pub(super) options: MavlinkOptions,
    /// What a trial changes is kept here until it is put back.
    backup: PathBuf,
    pub(super) logbook: PathBuf,
    pub(super) attendant: Arc<dyn Attendant>,
}

impl OnMavlink {
    /// The autopilot at an address.
    pub fn new(
        name: &str,
        address: &str,
        options: MavlinkOptions,
        logbook: &Path,
        attendant: Arc<dyn Attendant>,
    ) -> Result<Self, VehicleError> {
        parsed(address)?;
        Ok(Self {
            name: name.into(),
            address: address.into(),
            options,
            backup: logbook.with_extension("restore.toml"),
            logbook: logbook.into(),
            attendant,
        })
    }

    /// Looks at the vehicle, asks, and takes it. Whatever fails, it is handed back.
    fn taken(&self, terms: &Terms) -> Result<AutopilotThread<Transport>, VehicleError> {
        let backup = &self.backup;
        if backup.exists() {
            return Err(VehicleError::refused(format!(
                "{}: a trial before has not put everything back; run `seatrial vehicle restore {} --vehicle {}`",
                backup.display(),
                backup.display(),
                self.name
            )));
        }
        let opened =
            self.options.open(&self.address, Some(terms.plan), terms.plan_is_given, terms.stop);
        // The link stays alive while we think, ask and judge.
        let mut autopilot = AutopilotThread::new(opened?);
        let preflight = autopilot.autopilot().inspect();
        let attendant = self.attendant.as_ref();
        tell_all(attendant, &preflight);
        refuse(&preflight.checks)?;
        if !terms.is_agreed && !attendant.agrees()? {
            return Err(VehicleError::refused("not agreed to; nothing was changed"));
        }
        if terms.stop.load(Ordering::Relaxed) {
            return Err(VehicleError::refused("asked to end; nothing was changed"));
        }
        let checks = autopilot
            .autopilot()
            .take_control(&preflight.changes, &mut |stored| keep(backup, stored));
        checks.iter().for_each(|check| attendant.check(check));
        if let Err(refused) = refuse(&checks) {
            let left = hand_back(&mut autopilot, backup, &self.name, attendant);
            left.iter().for_each(|line| attendant.tell(line));
            return Err(refused);
        }
        Ok(autopilot)
    }
}

impl TrialVehicle for OnMavlink {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &str {
        "an autopilot that speaks MAVLink: it moves"
    }

    fn is_simulated(&self) -> bool {
        false
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        Some(self.options.full_rudder())
    }

    fn prior(&self, _: &Plan<f64>, _: &Budget) -> Result<Prior, VehicleError> {
        no_prior(&self.name)
    }

    fn inspect(&self, plan: &Plan<f64>) -> Result<Preflight, VehicleError> {
        let opened = self.options.open(&self.address, Some(plan), true, &Arc::default());
        Ok(opened?.inspect())
    }

    fn take(&self, terms: &Terms) -> Result<Box<dyn VehicleLease>, VehicleError> {
        let (backup, name) = (self.backup.clone(), self.name.clone());
        let attendant = Arc::clone(&self.attendant);
        let hand_back =
            move |autopilot: &mut _| hand_back(autopilot, &backup, &name, attendant.as_ref());
        let autopilot = self.taken(terms)?;
        let firmware = autopilot.autopilot().firmware();
        Ok(taken(autopilot, hand_back, None, Some(firmware)))
    }
}

/// Hands an autopilot back; what could not be put back.
fn hand_back(
    autopilot: &mut AutopilotThread<Transport>,
    backup: &Path,
    vehicle: &str,
    attendant: &dyn Attendant,
) -> Option<String> {
    let (done, response) = {
        let mut autopilot = autopilot.autopilot();
        (autopilot.hand_back(), autopilot.response().clone())
    };
    attendant.tell(&hand_back_text(&done));
    if let Some(line) = response_text(&response) {
        attendant.tell(&line);
    }
    left_over(&done, backup, vehicle)
}

/// What a hand-back has left, the backup being there only while something can be restored from it.
pub(super) fn left_over(done: &HandBack, backup: &Path, vehicle: &str) -> Option<String> {
    if done.needs_restoring() {
        return Some(format!(
            "not everything was put back; run `seatrial vehicle restore {} --vehicle {vehicle}`",
            backup.display()
        ));
    }
    let removed = match std::fs::remove_file(backup) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Some(format!("{}: {error}", backup.display()))
        }
        _ => None,
    };
    let neutral = "the outputs were not seen neutral: look at the vehicle";
    removed.or((!done.is_complete()).then(|| neutral.into()))
}

/// How soon commands went out after their samples; `None` where there were none.
fn response_text(response: &Response) -> Option<String> {
    let (count, longest_ms) = (response.count(), 1e3 * response.longest_s());
    let most_ms = 1e3 * response.quantile_s(0.999)?;
    Some(format!(
        "{count} commands, 99.9 % of them within {most_ms:.2} ms of their sample, the longest {longest_ms:.2} ms"
    ))
}

/// Writes a backup so that it survives a crash of this machine.
pub(super) fn keep(path: &Path, backup: &Backup) -> std::io::Result<()> {
    let text = toml::to_string_pretty(backup).map_err(std::io::Error::other)?;
    let mut file = std::fs::File::create_new(path)
        .map_err(|error| std::io::Error::other(format!("{}: {error}", path.display())))?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

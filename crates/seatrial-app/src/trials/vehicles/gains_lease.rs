//! An autopilot behind MAVLink whose gains are tried.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial_core::{CascadeSettings, Plan, Sample, SchedulePoint, Vehicle};
use seatrial_links::autopilot::{Ahead, AutopilotThread, Backup, HeadingControl, cascade};
use seatrial_links::link::Transport;

use super::mavlink::{OnMavlink, keep, left_over};
use super::{Attendant, hand_back_text, refuse};
use crate::trials::commission::{
    AutopilotContact, Control, ControlLoss, GainsLease, GainsVehicle, RestoreFile, RestoreResult,
};
use crate::trials::order::{Change, Preflight, VehicleError};

impl GainsVehicle for OnMavlink {
    fn reach(
        &self,
        plan: &Plan<f64>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Box<dyn AutopilotContact>, VehicleError> {
        let files = Files::beside(&self.logbook);
        files.refuse_left_over(&self.name)?;
        let opened = self.options.open(&self.address, Some(plan), true, stop)?;
        let full_rudder_rad = opened.full_rudder_rad();
        // The link stays alive while somebody thinks and agrees.
        let autopilot = AutopilotThread::new(opened);
        let (found, control) = autopilot.autopilot().inspect_heading();
        Ok(Box::new(MavlinkContact {
            autopilot,
            changes: found.changes.clone(),
            preflight: found,
            control,
            files,
            full_rudder_rad,
            sample_interval_s: plan.sample_interval_s,
            name: self.name.clone(),
            attendant: Arc::clone(&self.attendant),
        }))
    }

    fn kept(&self, stop: &Arc<AtomicBool>) -> Result<RestoreFile, VehicleError> {
        self.look_at_kept(stop)
    }

    fn put_back(&self, file: &Path, stop: &Arc<AtomicBool>) -> Result<RestoreResult, VehicleError> {
        self.put_kept_back(file, stop)
    }
}

/// An autopilot that was looked at.
struct MavlinkContact {
    autopilot: AutopilotThread<Transport>,
    preflight: Preflight,
    /// Until the hand-back.
    changes: Vec<Change>,
    control: Option<HeadingControl>,
    files: Files,
    full_rudder_rad: f64,
    sample_interval_s: f64,
    name: String,
    attendant: Arc<dyn Attendant>,
}

impl AutopilotContact for MavlinkContact {
    fn preflight(&self) -> &Preflight {
        &self.preflight
    }

    fn control(&self, model: &SchedulePoint<f64>) -> Option<Control> {
        let control = self.control?;
        Some(Control {
            settings: control.settings_at(model.surge_speed_m_s),
            loop_interval_s: control.loop_interval_s,
            sample_interval_s: self.sample_interval_s,
            output_scale: control.output_scale(model.surge_speed_m_s),
            steering_taken: control.steering_taken(model.thrust),
            keeps_speed: matches!(control.ahead, Ahead::Speed { .. }),
            rate_noise_rad_s: control.rate_noise_under_way_rad_s(),
        })
    }

    fn default_speed_m_s(&self) -> Option<f64> {
        self.control?.default_speed_m_s()
    }

    fn changes(&self, to: &CascadeSettings<f64>) -> Vec<Change> {
        let from = self.control.map(|control| control.settings);
        let changes = from.map(|from| cascade::differences(&from, to));
        changes.into_iter().flatten().collect()
    }

    fn take(self: Box<Self>) -> Result<Box<dyn GainsLease>, VehicleError> {
        let Some(control) = self.control else {
            return Err(VehicleError::refused("its steering gains were not read"));
        };
        Ok(Box::new(MavlinkGainsLease::take(*self, control)?))
    }
}

/// The files beside a logbook that hold what was changed.
struct Files {
    /// While the commission runs.
    restore: PathBuf,
    /// After it, where the new gains stay.
    undo: PathBuf,
}

impl Files {
    /// Beside this logbook.
    fn beside(logbook: &Path) -> Self {
        let free = (1..).map(|number| match number {
            1 => logbook.with_extension("old-gains.toml"),
            number => logbook.with_extension(format!("old-gains-{number}.toml")),
        });
        Self {
            restore: logbook.with_extension("restore.toml"),
            undo: free
                .take(1000)
                .find(|path| !path.exists())
                .unwrap_or_else(|| logbook.with_extension("old-gains.toml")),
        }
    }

    /// Refuses where something is left to be restored.
    fn refuse_left_over(&self, vehicle: &str) -> Result<(), VehicleError> {
        let path = self.restore.display();
        match self.restore.exists() {
            true => Err(VehicleError::refused(format!(
                "{path}: what ran before has not put everything back; run `seatrial vehicle restore {path} --vehicle {vehicle}`"
            ))),
            false => Ok(()),
        }
    }
}

/// A vehicle that was taken in its heading mode.
struct MavlinkGainsLease {
    autopilot: AutopilotThread<Transport>,
    control: HeadingControl,
    /// What the autopilot has now.
    settings: CascadeSettings<f64>,
    files: Files,
    full_rudder_rad: f64,
    name: String,
    attendant: Arc<dyn Attendant>,
}

impl MavlinkGainsLease {
    /// Takes it. Where that fails, it has been handed back.
    fn take(reached: MavlinkContact, control: HeadingControl) -> Result<Self, VehicleError> {
        let restore = reached.files.restore.clone();
        let checks = reached
            .autopilot
            .autopilot()
            .take_heading(&reached.changes, &mut |backup| keep(&restore, backup));
        let mut vehicle = Self {
            autopilot: reached.autopilot,
            settings: control.settings,
            control,
            files: reached.files,
            full_rudder_rad: reached.full_rudder_rad,
            name: reached.name,
            attendant: Arc::clone(&reached.attendant),
        };
        let attendant = reached.attendant.as_ref();
        checks.iter().for_each(|check| attendant.check(check));
        if let Err(refused) = refuse(&checks) {
            let left = vehicle.hand_back();
            left.iter().for_each(|text| attendant.tell(text));
            return Err(refused);
        }
        Ok(vehicle)
    }

    fn lost(&self, why: String) -> ControlLoss {
        ControlLoss { reason: self.autopilot.ended_for(), why }
    }

    fn stopped(&self) -> Option<ControlLoss> {
        let stopped = self.autopilot.autopilot().stopped().map(ToString::to_string);
        stopped.map(|why| self.lost(why))
    }
}

impl GainsLease for MavlinkGainsLease {
    fn next_sample(&mut self) -> Result<Sample<f64>, ControlLoss> {
        let next = self.autopilot.next_sample().map_err(|stop| stop.to_string());
        let next = next.and_then(|sample| sample.ok_or_else(|| "the vehicle is not ours".into()));
        let sample = next.map_err(|why| self.lost(why))?;
        Ok(Sample { rudder_rad: sample.rudder_rad / self.full_rudder_rad, ..sample })
    }

    fn steer_to(&mut self, heading_rad: f64, model: &SchedulePoint<f64>) {
        let drive = self.control.drive(model.surge_speed_m_s, model.thrust);
        self.autopilot.autopilot().steer_to(heading_rad, drive);
    }

    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), ControlLoss> {
        for (name, value) in cascade::writes(&self.settings, settings) {
            let is_written = self.autopilot.autopilot().write_parameter(name, value);
            if let Some(stopped) = self.stopped() {
                return Err(stopped);
            }
            if !is_written {
                return Err(self.lost(format!("{name} could not be set to {value}")));
            }
        }
        self.settings = *settings;
        Ok(())
    }

    fn keep(&mut self) -> Result<String, ControlLoss> {
        if let Some(stopped) = self.stopped() {
            return Err(stopped);
        }
        // The disk may hang; the autopilot is tended meanwhile, and handed back with its old gains where that takes too long.
        let before = self.autopilot.autopilot().gains_before();
        keep(&self.files.undo, &before).map_err(|error| self.lost(error.to_string()))?;
        let kept = self.autopilot.autopilot().keep_gains();
        let Some(kept) = kept else {
            return Err(self
                .stopped()
                .unwrap_or_else(|| self.lost("the vehicle is not ours".into())));
        };
        replace(&self.files.restore, &kept).map_err(|error| self.lost(error.to_string()))?;
        Ok(format!(
            "seatrial vehicle restore {} --vehicle {}",
            self.files.undo.display(),
            self.name
        ))
    }

    fn hand_back(&mut self) -> Option<String> {
        let done = self.autopilot.autopilot().hand_back();
        self.attendant.tell(&hand_back_text(&done));
        left_over(&done, &self.files.restore, &self.name)
    }
}

/// Puts a backup in the place of another, so that one of both is always there.
fn replace(path: &Path, backup: &Backup) -> std::io::Result<()> {
    let beside = path.with_extension("new");
    keep(&beside, backup)?;
    std::fs::rename(&beside, path)
}

//! An autopilot behind MAVLink whose gains are tried.

use std::path::{Path, PathBuf};

use seatrial_app::commission::{GainedVehicle, Lost};
use seatrial_core::{CascadeSettings, Sample, Vehicle};
use seatrial_links::autopilot::{Backup, HeadingControl, Tended, cascade};
use seatrial_links::handover::Change;
use seatrial_links::link::Transport;

use super::named;
use crate::autopilot::{hand_back_text, keep, left_over, line, refuse};
use crate::output::{Failure, say};

/// The files beside a logbook that hold what was changed.
pub struct Files {
    /// While the commission runs.
    restore: PathBuf,
    /// After it, where the new gains stay.
    undo: PathBuf,
}

impl Files {
    /// Beside this logbook.
    pub fn beside(logbook: &Path) -> Self {
        let free = (1..).map(|number| match number {
            1 => named(logbook, "old-gains.toml"),
            number => named(logbook, &format!("old-gains-{number}.toml")),
        });
        Self {
            restore: named(logbook, "restore.toml"),
            undo: free
                .take(1000)
                .find(|path| !path.exists())
                .unwrap_or_else(|| named(logbook, "old-gains.toml")),
        }
    }

    /// Refuses where something is left to be restored.
    pub fn refuse_left_over(&self, vehicle: &str) -> Result<(), Failure> {
        let path = self.restore.display();
        match self.restore.exists() {
            true => Err(Failure::aborted(format!(
                "{path}: what ran before has not put everything back; run `seatrial vehicle restore {path} --vehicle {vehicle}`"
            ))),
            false => Ok(()),
        }
    }
}

/// A vehicle that was taken in its heading mode.
pub struct OnHeading {
    autopilot: Tended<Transport>,
    control: HeadingControl,
    /// What the autopilot has now.
    settings: CascadeSettings<f64>,
    files: Files,
    full_rudder_rad: f64,
}

impl OnHeading {
    /// Takes it. Where that fails, it has been handed back.
    pub fn take(
        autopilot: Tended<Transport>,
        changes: &[Change],
        control: HeadingControl,
        files: Files,
        full_rudder_rad: f64,
    ) -> Result<Self, Failure> {
        let restore = files.restore.clone();
        let checks = autopilot
            .autopilot()
            .take_heading(changes, &mut |backup| keep(&restore, backup));
        let mut vehicle = Self {
            autopilot,
            settings: control.settings,
            control,
            files,
            full_rudder_rad,
        };
        checks.iter().map(line).for_each(say);
        if let Err(failure) = refuse(&checks) {
            vehicle.hand_back().iter().for_each(say);
            return Err(failure);
        }
        Ok(vehicle)
    }

    fn lost(&self, why: String) -> Lost {
        Lost {
            reason: self.autopilot.ended_for(),
            why,
        }
    }

    fn stopped(&self) -> Option<Lost> {
        let stopped = self
            .autopilot
            .autopilot()
            .stopped()
            .map(ToString::to_string);
        stopped.map(|why| self.lost(why))
    }
}

impl GainedVehicle for OnHeading {
    fn next_sample(&mut self) -> Result<Sample<f64>, Lost> {
        let next = self.autopilot.next_sample();
        match next {
            Ok(Some(sample)) => Ok(Sample {
                rudder_rad: sample.rudder_rad / self.full_rudder_rad,
                ..sample
            }),
            Ok(None) => Err(self.lost("the vehicle is not ours".into())),
            Err(stop) => Err(self.lost(stop.to_string())),
        }
    }

    fn steer_to(&mut self, heading_rad: f64, speed_m_s: Option<f64>) {
        let share = speed_m_s
            .zip(self.control.default_speed_m_s)
            .map_or(1.0, |(speed, default)| speed / default);
        self.autopilot.autopilot().steer_to(heading_rad, share);
    }

    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), Lost> {
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

    fn keep(&mut self) -> Result<String, Lost> {
        if let Some(stopped) = self.stopped() {
            return Err(stopped);
        }
        let saved = {
            let mut autopilot = self.autopilot.autopilot();
            keep(&self.files.undo, &autopilot.gains_before())
                .and_then(|()| replace(&self.files.restore, &autopilot.keep_gains()))
        };
        saved.map_err(|error| self.lost(error.to_string()))?;
        Ok(format!(
            "seatrial vehicle restore {} --vehicle VEHICLE",
            self.files.undo.display()
        ))
    }

    fn hand_back(&mut self) -> Option<String> {
        let done = self.autopilot.autopilot().hand_back();
        say(hand_back_text(&done));
        left_over(&done, &self.files.restore)
    }
}

/// Puts a backup in the place of another, so that one of both is always there.
fn replace(path: &Path, backup: &Backup) -> std::io::Result<()> {
    let beside = path.with_extension("new");
    keep(&beside, backup)?;
    std::fs::rename(&beside, path)
}

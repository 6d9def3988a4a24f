//! What a trial or a commission has changed on an autopilot and kept in a file, put back.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial_links::autopilot::{Autopilot, Backup, HandBack, PutBack};
use seatrial_links::link::Transport;

use super::mavlink::OnMavlink;
use crate::Error;
use crate::trials::commission::{RestoreFile, RestoreResult};
use crate::trials::order::VehicleError;
use crate::trials::vehicles::hand_back_text;

/// The backup of a file, refused where no trial and no commission has written it.
///
/// # Errors
/// A file that cannot be read, or with a parameter or a value that neither changes.
pub fn read_backup(path: &Path) -> Result<Backup, Error> {
    let read = std::fs::read_to_string(path).map_err(|error| error.to_string());
    let backup: Backup = read
        .and_then(|text| toml::from_str(&text).map_err(|error| format!("not a backup: {error}")))
        .map_err(|error| Error::Input(format!("{}: {error}", path.display())))?;
    let (foreign, impossible) = (backup.foreign_names(), backup.impossible_values());
    match foreign.is_empty() {
        true if impossible.is_empty() => Ok(backup),
        true => Err(Error::Input(format!(
            "{}: no autopilot had {}; nothing was written",
            path.display(),
            impossible.join("; ")
        ))),
        false => Err(Error::Input(format!(
            "{}: not a backup of a trial or a commission, which never change {}; nothing was written",
            path.display(),
            foreign.join(", ")
        ))),
    }
}

/// Each parameter as it is and as a backup would make it.
///
/// # Errors
/// The vehicle of the backup is not heard.
pub fn compared(
    autopilot: &mut Autopilot<Transport>,
    backup: &Backup,
    vehicle: &str,
) -> Result<Vec<PutBack>, Error> {
    autopilot.look_at(backup).ok_or_else(|| {
        Error::Rejected(format!(
            "{vehicle}: system {}, whose parameters these are, is not heard; nothing was written",
            backup.system
        ))
    })
}

/// Writes a backup to its vehicle and reads it back; where everything is as it was, the file is removed.
///
/// # Errors
/// The file cannot be removed.
pub fn restored(
    autopilot: &mut Autopilot<Transport>,
    backup: &Backup,
    path: &Path,
) -> std::io::Result<HandBack> {
    let done = autopilot.restore(backup);
    if done.is_complete() {
        std::fs::remove_file(path)
            .map_err(|error| std::io::Error::other(format!("{}: {error}", path.display())))?;
    }
    Ok(done)
}

impl OnMavlink {
    /// What is to be put back first: what a trial has left, then the gains before the newest commission.
    fn kept_file(&self) -> Result<PathBuf, VehicleError> {
        let gains = (2..1000).map(|number| format!("old-gains-{number}.toml"));
        let names = std::iter::once("old-gains.toml".to_owned()).chain(gains);
        let files = names.map(|name| self.logbook.with_extension(name));
        let left = self.logbook.with_extension("restore.toml");
        let newest = match left.exists() {
            true => Some(left),
            false => files.take_while(|path| path.exists()).last(),
        };
        newest.ok_or_else(|| {
            VehicleError::refused(
                "nothing of a trial or a commission is left to put back, or it was put back already",
            )
        })
    }

    fn reached(&self, stop: &Arc<AtomicBool>) -> Result<Autopilot<Transport>, VehicleError> {
        self.options.open(&self.address, None, false, stop)
    }

    /// What could be put back: each parameter as it is and as it would be. Nothing is written.
    pub(super) fn look_at_kept(&self, stop: &Arc<AtomicBool>) -> Result<RestoreFile, VehicleError> {
        let file = self.kept_file()?;
        let backup = read_backup(&file).map_err(VehicleError::refused)?;
        let parameters = compared(&mut self.reached(stop)?, &backup, &self.name)
            .map_err(VehicleError::refused)?;
        Ok(RestoreFile { file, parameters, mode: backup.mode })
    }

    /// Puts back what a file holds.
    pub(super) fn put_kept_back(
        &self,
        file: &Path,
        stop: &Arc<AtomicBool>,
    ) -> Result<RestoreResult, VehicleError> {
        let backup = read_backup(file).map_err(VehicleError::refused)?;
        let done = restored(&mut self.reached(stop)?, &backup, file);
        let done = done.map_err(VehicleError::refused)?;
        Ok(RestoreResult {
            is_complete: done.is_complete(),
            line: hand_back_text(&done),
            parameters: done.values,
        })
    }
}

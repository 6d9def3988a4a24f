//! What can go wrong with a logbook.

use std::path::{Path, PathBuf};

use rusqlite::ErrorCode;

use super::damage::unreadable;

/// Why a logbook could not be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no such file.
    #[error("{path}: no such logbook; `seatrial trial --logbook {path}` makes one", path = .0.display())]
    Missing(PathBuf),
    /// The file is something else.
    #[error("{path}: not a seatrial logbook but {found}; give another file with --logbook", path = .path.display())]
    NotALogbook {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
    },
    /// A later version of seatrial wrote it.
    #[error("{path}: logbook of schema {found}, this seatrial knows up to {known}; use the seatrial that wrote it, or a newer one", path = .path.display())]
    Newer {
        /// The file.
        path: PathBuf,
        /// Its schema version.
        found: usize,
        /// The newest schema version known here.
        known: usize,
    },
    /// Its schema is not the one that seatrial writes.
    #[error("{path}: the logbook was altered: {found}, and no seatrial does that, so that nothing in it is used; take a copy from before", path = .path.display())]
    Altered {
        /// The file.
        path: PathBuf,
        /// The part of the schema, and what is wrong with it.
        found: String,
    },
    /// The file cannot be opened or read.
    #[error("{path}: the logbook cannot be opened: {cause}", path = .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause, in words.
        cause: String,
    },
    /// The file holds something that no seatrial writes.
    #[error("{path}: the logbook is damaged: {place}: {found}; `seatrial logbook --verify` lists what is whole", path = .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The row.
        place: String,
        /// What is wrong with it.
        found: String,
    },
    /// The logbook holds no such campaign.
    #[error("{path}: no campaign {wanted}; it holds {held}", path = .path.display())]
    NoCampaign {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// What there is.
        held: String,
    },
    /// The file could not be written.
    #[error("{path}: not saved: {cause}", path = .path.display())]
    NotSaved {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        cause: String,
    },
    /// A result that the logbook cannot give back bit for bit.
    #[error("run {run}: not saved: {found}")]
    Inexact {
        /// Number of the run.
        run: u32,
        /// What cannot be kept.
        found: String,
    },
}

impl Error {
    /// Was it something to be saved that was not (rather than something that cannot be read)?
    pub fn is_not_saved(&self) -> bool {
        matches!(self, Self::NotSaved { .. } | Self::Inexact { .. })
    }

    /// Why it cannot be opened. Then nothing lists what of it is whole.
    pub(super) fn opening(path: &Path, error: &rusqlite::Error) -> Self {
        match Self::reading(path, error) {
            Self::Damaged { path, found, .. } => Self::Unreadable {
                path,
                cause: format!("{found}; take a copy from before the damage"),
            },
            other => other,
        }
    }

    pub(super) fn reading(path: &Path, error: &rusqlite::Error) -> Self {
        let path = path.to_path_buf();
        match error.sqlite_error_code() {
            Some(ErrorCode::NotADatabase) => Self::NotALogbook {
                path,
                found: "something else, or a logbook whose beginning was overwritten".into(),
            },
            Some(ErrorCode::DatabaseCorrupt) => Self::Damaged {
                path,
                place: "the file".into(),
                found: unreadable(error),
            },
            Some(ErrorCode::CannotOpen | ErrorCode::PermissionDenied) => Self::Unreadable {
                path,
                cause: format!("{error}; does its folder exist, and may you open files there?"),
            },
            Some(ErrorCode::ReadOnly) => Self::Unreadable {
                path,
                cause: format!("{error}; make the file and its folder writable"),
            },
            Some(ErrorCode::OperationInterrupted) => Self::Unreadable {
                path,
                cause: "reading takes longer than any logbook of its size needs; it is damaged, or was altered".into(),
            },
            Some(_) => Self::Unreadable {
                path,
                cause: unreadable(error),
            },
            None => Self::Damaged {
                path,
                place: "the file".into(),
                found: unreadable(error),
            },
        }
    }

    pub(super) fn writing(path: &Path, error: &rusqlite::Error) -> Self {
        let advice = match error.sqlite_error_code() {
            Some(ErrorCode::DiskFull) => "free some space or give another disk with --logbook",
            Some(ErrorCode::SystemIoFailure) => "the disk may be full or failing",
            Some(ErrorCode::ReadOnly) => "make the file and its folder writable",
            Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
                "another process holds it; give this trial a logbook of its own"
            }
            _ => "give another file with --logbook",
        };
        Self::NotSaved { path: path.to_path_buf(), cause: format!("{error}; {advice}") }
    }
}

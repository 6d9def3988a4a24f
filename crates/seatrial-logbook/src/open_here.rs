//! Does this process have a logbook open?
//!
//! Where a process closes any file, POSIX takes away all locks that the process has on this file. Reading a file of a logbook beside SQLite
//! would take away those of every connection of the process.

use std::sync::{Mutex, PoisonError};

static OPEN: Mutex<usize> = Mutex::new(0);

/// Lives as long as a connection to a logbook.
#[derive(Debug)]
pub(super) struct OpenHere;

impl OpenHere {
    /// Before a logbook is opened: what is to be read beside SQLite is read where this process has none open.
    pub(super) fn after<T>(alone: impl FnOnce() -> T) -> (Self, Option<T>) {
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        let found = (*open == 0).then(alone);
        *open += 1;
        (Self, found)
    }
}

impl Drop for OpenHere {
    fn drop(&mut self) {
        *OPEN.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
    }
}

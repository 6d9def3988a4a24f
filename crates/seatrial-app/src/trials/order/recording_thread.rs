//! A recording that grows beside a trial.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use seatrial_logs::Row;

use crate::outputs::OutputError;
use crate::trials::recording::Recording;

/// Rows that may wait for the disk: half an hour of a trial at 20 Hz.
const WAITING: usize = 36_000;
/// Longest wait for the disk at the end of a trial whose operator asked for it.
const ASKED_TO_END: Duration = Duration::from_secs(3);
/// Between two looks whether all is written.
const LOOK: Duration = Duration::from_millis(10);

enum Entry {
    Row(Box<Row>),
    RunEnded,
}

/// Writes a recording on a thread of its own: a disk takes longer than a rudder may wait. A simulator waits for the disk; a
/// vehicle does not, and rows that find no room are left out.
pub(super) struct RecordingThread {
    entries: SyncSender<Entry>,
    thread: JoinHandle<Vec<String>>,
    is_live: bool,
    is_left_out: bool,
}

impl RecordingThread {
    pub(super) fn start(recording: Recording, is_live: bool) -> Self {
        let (entries, to_write) = sync_channel(if is_live { WAITING } else { 0 });
        Self {
            entries,
            thread: std::thread::spawn(move || write(recording, &to_write)),
            is_live,
            is_left_out: false,
        }
    }

    pub(super) fn take(&mut self, row: Row) {
        self.enter(Entry::Row(Box::new(row)));
    }

    pub(super) fn run_ended(&mut self) {
        self.enter(Entry::RunEnded);
    }

    fn enter(&mut self, entry: Entry) {
        // The thread ends before its entries only by a panic, which `finish` tells.
        if !self.is_live {
            let _ = self.entries.send(entry);
        } else if let Err(TrySendError::Full(_)) = self.entries.try_send(entry) {
            self.is_left_out = true;
        }
    }

    /// Waits until all is written; a disk that is held up is given up soon after `is_asked_to_end` says so. Returns what could
    /// not be written.
    pub(super) fn finish(self, is_asked_to_end: impl Fn() -> bool) -> Vec<String> {
        let Self { entries, thread, .. } = self;
        drop(entries);
        let left_out =
            "the recording's disk was held up for too long; part of the trial is missing in it";
        let mut unsaved: Vec<String> =
            self.is_left_out.then(|| left_out.into()).into_iter().collect();
        let begun = Instant::now();
        while !thread.is_finished() {
            if is_asked_to_end() && begun.elapsed() > ASKED_TO_END {
                unsaved.push("the recording's disk does not answer; its end is missing".into());
                return unsaved;
            }
            std::thread::sleep(LOOK);
        }
        let fault =
            |_| vec!["the recording was not written to its end: a fault of the program".into()];
        unsaved.extend(thread.join().unwrap_or_else(fault));
        unsaved
    }
}

fn write(mut recording: Recording, entries: &Receiver<Entry>) -> Vec<String> {
    let mut unsaved = Vec::new();
    for entry in entries {
        note(
            &mut unsaved,
            match entry {
                Entry::Row(row) => recording.take(*row),
                Entry::RunEnded => recording.run_ended(),
            },
        );
    }
    note(&mut unsaved, recording.finish());
    unsaved
}

fn note(unsaved: &mut Vec<String>, written: Result<(), OutputError>) {
    if let Err(error) = written {
        let why = error.to_string();
        if !unsaved.contains(&why) {
            unsaved.push(why);
        }
    }
}

//! Keeps a trial in the logbook while it is conducted.

use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use seatrial_core::Outcome;

use super::{Error, Recorder};
use seatrial::Step;
use seatrial::campaign::Run;

/// Entries that may wait for the disk: half an hour of a trial at 20 Hz, some 20 MB. Further ones of a live vehicle are left out;
/// the run that misses one is kept in memory, whole.
const WAITING: usize = 36_000;
/// Longest wait for the disk at the end of a trial whose operator asked for it.
const ASKED_TO_END: Duration = Duration::from_secs(3);
/// Between two looks whether all is written.
const LOOK: Duration = Duration::from_millis(10);

/// Writes what it watches into the logbook, on a thread of its own, because a disk takes longer than a rudder may wait.
/// What cannot be kept is noted and does not stop the trial.
#[derive(Debug)]
pub struct Keeper {
    entries: Option<SyncSender<Entry>>,
    /// An answer to each run that has ended: it has been seen to.
    seen_to: Receiver<()>,
    thread: Option<JoinHandle<KeeperReport>>,
    is_live: bool,
    /// What did not get to the thread.
    left_out: KeeperReport,
}

#[derive(Debug)]
enum Entry {
    RunStarted { number: u32, thrust: f64, attempt: u32 },
    Step(Box<Step>),
    RunEnded(Box<Run>),
    Ended(Outcome),
}

/// What came of keeping a trial.
#[derive(Debug, Default)]
pub struct KeeperReport {
    /// Why something could not be kept.
    pub unsaved: Vec<String>,
    /// Runs that the logbook does not have, whole.
    pub runs: Vec<Run>,
}

impl Keeper {
    /// Keeps with this recorder. On a vehicle that is [live](seatrial_core::Vehicle::is_live) the trial does not wait for a
    /// run to be sealed; any other does, so that what is reported of a run is in the logbook.
    pub fn new(recorder: Recorder, is_live: bool) -> Self {
        let (entries, to_keep) = sync_channel(WAITING);
        let (tell, seen_to) = channel();
        let thread = std::thread::spawn(move || keep(recorder, &to_keep, &tell));
        Self {
            entries: Some(entries),
            seen_to,
            thread: Some(thread),
            is_live,
            left_out: KeeperReport::default(),
        }
    }

    /// Keeps that a run began.
    pub fn begin_run(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.enter(Entry::RunStarted { number, thrust, attempt });
    }

    /// Keeps a step of the trial.
    pub fn keep(&mut self, step: &Step) {
        self.enter(Entry::Step(Box::new(*step)));
    }

    /// Keeps a run that has ended, whole.
    pub fn end_run(&mut self, run: &Run) {
        self.enter(Entry::RunEnded(Box::new(run.clone())));
        if !self.is_live {
            let _ = self.seen_to.recv();
        }
    }

    /// Takes record and trace out of a run that has ended, so that memory does not grow with a trial's runs;
    /// [`Logbook::fill`](super::Logbook::fill) puts them back, and [`end`](Self::end) gives those that the logbook does not have.
    pub fn release(&self, run: &mut Run) {
        run.record.samples = Vec::new();
        if let Some(identification) = &mut run.identification {
            identification.online.trace = Vec::new();
        }
    }

    /// Enters how the campaign ended, and waits until all is written; a disk that is held up is given up soon after
    /// `is_asked_to_end` says so.
    pub fn end(
        mut self,
        outcome: Option<Outcome>,
        is_asked_to_end: impl Fn() -> bool,
    ) -> KeeperReport {
        if let Some(outcome) = outcome {
            self.enter(Entry::Ended(outcome));
        }
        self.entries = None;
        let mut kept = self.written(is_asked_to_end);
        kept.runs.append(&mut self.left_out.runs);
        kept.unsaved.append(&mut self.left_out.unsaved);
        kept
    }

    fn enter(&mut self, entry: Entry) {
        let Some(entries) = &self.entries else {
            return;
        };
        // The thread ends before its entries only by a panic, which `end` tells.
        if !self.is_live {
            let _ = entries.send(entry);
            return;
        }
        if let Err(TrySendError::Full(entry)) = entries.try_send(entry) {
            let why = "the logbook's disk was held up for too long; part of the trial was not kept";
            self.left_out.note(why);
            if let Entry::RunEnded(run) = entry {
                self.left_out.runs.push(*run);
            }
        }
    }

    fn written(&mut self, is_asked_to_end: impl Fn() -> bool) -> KeeperReport {
        let Some(thread) = self.thread.take() else {
            return KeeperReport::default();
        };
        let begun = Instant::now();
        while !thread.is_finished() {
            if is_asked_to_end() && begun.elapsed() > ASKED_TO_END {
                let why = "the logbook's disk does not answer; the end of the trial was not kept";
                return KeeperReport { unsaved: vec![why.into()], runs: Vec::new() };
            }
            std::thread::sleep(LOOK);
        }
        thread.join().unwrap_or_else(|_| KeeperReport {
            unsaved: vec!["the logbook was not written to its end: a fault of the program".into()],
            runs: Vec::new(),
        })
    }
}

/// Writes what has come.
impl Drop for Keeper {
    fn drop(&mut self) {
        self.entries = None;
        self.written(|| false);
    }
}

/// Enters one after the other until nobody has any more.
fn keep(mut recorder: Recorder, entries: &Receiver<Entry>, seen_to: &Sender<()>) -> KeeperReport {
    let mut kept = KeeperReport::default();
    for entry in entries {
        let entered = match entry {
            Entry::RunStarted { number, thrust, attempt } => {
                recorder.begin_run(number, thrust, attempt)
            }
            Entry::Step(step) => recorder.step(*step),
            Entry::RunEnded(run) => {
                let sealed = recorder.finish_run(&run);
                if sealed.is_err() {
                    kept.runs.push(*run);
                }
                let _ = seen_to.send(());
                sealed
            }
            Entry::Ended(outcome) => {
                kept.entered(recorder.finish(outcome));
                break;
            }
        };
        kept.entered(entered);
    }
    kept
}

impl KeeperReport {
    fn entered(&mut self, entered: Result<(), Error>) {
        if let Err(error) = entered {
            self.note(&error.to_string());
        }
    }

    fn note(&mut self, unsaved: &str) {
        if !self.unsaved.iter().any(|known| known == unsaved) {
            self.unsaved.push(unsaved.into());
        }
    }

    /// Puts the runs that the logbook does not have back among those of a campaign; why they were not kept.
    pub fn put_back(self, runs: &mut [Run]) -> Vec<String> {
        for whole in self.runs {
            if let Some(run) = runs.iter_mut().find(|run| run.number == whole.number) {
                *run = whole;
            }
        }
        self.unsaved
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::recorder::tests::{begun, run, step};
    use crate::{CampaignId, Logbook};

    /// Each of the steps is a second long, so that each is written for itself.
    #[test]
    fn io_a_disk_that_is_held_up_holds_up_no_rudder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seatrial.db");
        let mut keeper = Keeper::new(begun(&path), true);
        let run = run(100);
        let holder = Logbook::hold(&path).unwrap();
        let begun = Instant::now();
        keeper.begin_run(1, 0.6, 1);
        for second in 0..100 {
            keeper.keep(&step(second));
        }
        let mut reported = run.clone();
        keeper.end_run(&reported);
        keeper.release(&mut reported);
        // The lock is waited for 5 s.
        assert!(begun.elapsed() < Duration::from_secs(1));
        assert!(reported.record.samples.is_empty());
        drop(holder);
        assert_eq!(keeper.end(Some(Outcome::Finished), || false).unsaved, [""; 0]);
        let logbook = Logbook::open_read_only(&path).unwrap();
        assert_eq!(logbook.campaign(CampaignId(1)).unwrap().runs, [run]);
    }

    #[test]
    fn io_a_run_that_the_logbook_refused_comes_back_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seatrial.db");
        let mut keeper = Keeper::new(begun(&path), true);
        keeper.begin_run(1, 0.6, 1);
        // Its record has a sample that never came.
        let run = run(1);
        let mut reported = run.clone();
        keeper.end_run(&reported);
        keeper.release(&mut reported);
        let mut runs = [reported];
        let kept = keeper.end(Some(Outcome::Finished), || false);
        let unsaved = kept.put_back(&mut runs);
        assert_eq!(unsaved.len(), 1, "{unsaved:?}");
        assert_eq!(runs, [run]);
    }
    /// A disk that hangs for good: the trial goes on, and its end does not wait once the operator has asked for it.
    #[test]
    fn io_a_disk_that_hangs_for_good_is_given_up_when_asked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("seatrial.db");
        let mut keeper = Keeper::new(begun(&path), true);
        let run = run(100);
        let _holder = Logbook::hold(&path).unwrap();
        let asked = Instant::now();
        keeper.begin_run(1, 0.6, 1);
        for second in 0..WAITING {
            keeper.keep(&step(second as u32));
        }
        keeper.end_run(&run);
        assert!(asked.elapsed() < Duration::from_secs(1));
        let mut reported = [run.clone()];
        keeper.release(&mut reported[0]);
        let unsaved = keeper.end(None, || true).put_back(&mut reported);
        // The lock is waited for 5 s each time.
        assert!(asked.elapsed() < 2 * ASKED_TO_END);
        assert!(unsaved.iter().any(|why| why.contains("does not answer")));
        assert_eq!(reported, [run]);
    }
}

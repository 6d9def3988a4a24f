//! A link that is kept alive while nobody waits for it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;
use std::time::Duration;

use seatrial_core::{AbortReason, Action, Sample, Vehicle};

use super::{Autopilot, Stop};
use crate::link::Wire;

/// Between two looks at the link.
const LOOK: Duration = Duration::from_millis(5);
/// Reads of one look: more than comes between two, and not so many that a trial would have to wait.
const READS: u32 = 8;

/// A vehicle whose trial was ended is fetched by the trial within this time, s, or handed back without it.
const NOT_FETCHED_S: f64 = 0.5;

/// An [`Autopilot`] with a thread of its own: heartbeats go out, what is asked for is asked for again, headings are held
/// and dangers are seen also while the operator is asked or the logbook's disk is slow. Should the trial not come back in time, the
/// thread lets go of the vehicle. Dropping it hands the vehicle back.
pub struct AutopilotThread<W: Wire + Send + 'static> {
    autopilot: Arc<Mutex<Autopilot<W>>>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<W: Wire + Send + 'static> AutopilotThread<W> {
    /// Tends it from now on.
    pub fn new(autopilot: Autopilot<W>) -> Self {
        let autopilot = Arc::new(Mutex::new(autopilot));
        let is_over = Arc::new(AtomicBool::new(false));
        let thread = std::thread::spawn({
            let (autopilot, is_over) = (Arc::clone(&autopilot), Arc::clone(&is_over));
            move || {
                while !is_over.load(Ordering::Relaxed) {
                    match autopilot.try_lock() {
                        Ok(mut autopilot) => autopilot.tend(),
                        Err(TryLockError::Poisoned(error)) => error.into_inner().tend(),
                        // The holder of the lock pumps.
                        Err(TryLockError::WouldBlock) => {}
                    }
                    std::thread::sleep(LOOK);
                }
            }
        });
        Self { autopilot, is_over, thread: Some(thread) }
    }

    /// The autopilot, until the guard is dropped.
    pub fn autopilot(&self) -> MutexGuard<'_, Autopilot<W>> {
        self.autopilot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<W: Wire> Autopilot<W> {
    fn tend(&mut self) {
        for _ in 0..READS {
            let now_s = self.wire.now_s();
            if !self.pump(now_s) {
                break;
            }
        }
        if self.is_left_alone() {
            self.handed_back = Some(self.hand_back());
        }
    }

    /// The trial has ended, and whoever conducts it is held up by something else.
    fn is_left_alone(&self) -> bool {
        let absent_s = self.wire.now_s() - self.attended_s;
        self.backup.is_some() && self.stopped.is_some() && absent_s > NOT_FETCHED_S
    }
}

impl<W: Wire + Send + 'static> Vehicle<f64> for AutopilotThread<W> {
    type Error = Stop;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Stop> {
        self.autopilot().next_sample()
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Stop> {
        self.autopilot().act(action)
    }

    fn is_live(&self) -> bool {
        true
    }

    fn ended_for(&self) -> Option<AbortReason> {
        self.autopilot().ended_for()
    }
}

impl<W: Wire + Send + 'static> Drop for AutopilotThread<W> {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing more to tell; the vehicle is handed back all the same.
            let _ = thread.join();
        }
    }
}

//! Text that holds up nobody: a thread of its own writes it. A terminal that was stopped, or a pipe that nobody reads, then loses
//! text and costs no time.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, channel, sync_channel};
use std::time::{Duration, Instant};

/// Texts that may wait to be written. Further ones are left out.
const WAITING: usize = 512;
/// Longest wait at the end for what has not been written yet.
const END: Duration = Duration::from_secs(1);
/// Between two looks whether there is room.
const LOOK: Duration = Duration::from_millis(10);

/// One thing to be written or drawn.
type Job = Box<dyn FnOnce() + Send>;

/// Texts on their way to a terminal that may be stopped.
#[derive(Debug)]
pub struct TextQueue {
    jobs: SyncSender<Job>,
    left_out: AtomicU32,
}

impl Default for TextQueue {
    fn default() -> Self {
        let (jobs, to_do) = sync_channel::<Job>(WAITING);
        std::thread::spawn(move || to_do.into_iter().for_each(|job| job()));
        Self { jobs, left_out: AtomicU32::new(0) }
    }
}

impl TextQueue {
    /// Writes or draws as soon as the thread is free; leaves it out where too much waits already.
    pub fn write(&self, job: impl FnOnce() + Send + 'static) {
        if self.jobs.try_send(Box::new(job)).is_err() {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// How many texts were left out since this was asked last.
    pub fn left_out(&self) -> u32 {
        self.left_out.swap(0, Ordering::Relaxed)
    }

    /// Waits a moment until all is written.
    pub fn finish(&self) {
        let (tell, told) = channel();
        let mut last: Job = Box::new(move || {
            // Nobody waits any more where the time was up.
            let _ = tell.send(());
        });
        let until = Instant::now() + END;
        while let Err(TrySendError::Full(job)) = self.jobs.try_send(last) {
            if Instant::now() >= until {
                return;
            }
            last = job;
            std::thread::sleep(LOOK);
        }
        let _ = told.recv_timeout(until.saturating_duration_since(Instant::now()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A terminal that is stopped takes one text and gives it back only when it goes on.
    #[test]
    fn io_a_stopped_terminal_costs_text_and_no_time() {
        let queue = TextQueue::default();
        let (go_on, stopped) = channel::<()>();
        let begun = Instant::now();
        queue.write(move || {
            let _ = stopped.recv();
        });
        for _ in 0..2 * WAITING {
            queue.write(|| {});
        }
        queue.finish();
        assert!(begun.elapsed() < 2 * END);
        assert!(queue.left_out() as usize >= WAITING - 1);
        drop(go_on);
        queue.finish();
        queue.write(|| {});
        assert_eq!(queue.left_out(), 0);
    }
}

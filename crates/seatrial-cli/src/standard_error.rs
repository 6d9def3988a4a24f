//! Standard error that holds up nobody: once a vehicle may be ours, a thread of its own writes there. A terminal that was
//! stopped, or a pipe that nobody reads, then loses text and costs no time.

use std::sync::OnceLock;
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

static QUEUE: OnceLock<SyncSender<Job>> = OnceLock::new();
static LEFT_OUT: AtomicU32 = AtomicU32::new(0);

/// From now on nobody waits for standard error.
pub fn detach() {
    QUEUE.get_or_init(|| {
        let (queue, jobs) = sync_channel::<Job>(WAITING);
        std::thread::spawn(move || jobs.into_iter().for_each(|job| job()));
        queue
    });
}

/// Writes or draws as soon as standard error takes it; at once where it is not detached.
pub fn write(job: impl FnOnce() + Send + 'static) {
    let Some(queue) = QUEUE.get() else {
        return job();
    };
    if queue.try_send(Box::new(job)).is_err() {
        LEFT_OUT.fetch_add(1, Ordering::Relaxed);
    }
}

/// Waits a moment until all is written. Returns how many texts were left out since this was asked last.
pub fn finish() -> u32 {
    if let Some(queue) = QUEUE.get() {
        let (tell, told) = channel();
        let mut last: Job = Box::new(move || {
            // Nobody waits any more where the time was up.
            let _ = tell.send(());
        });
        let until = Instant::now() + END;
        while let Err(TrySendError::Full(job)) = queue.try_send(last) {
            if Instant::now() >= until {
                break;
            }
            last = job;
            std::thread::sleep(LOOK);
        }
        let _ = told.recv_timeout(until.saturating_duration_since(Instant::now()));
    }
    LEFT_OUT.swap(0, Ordering::Relaxed)
}

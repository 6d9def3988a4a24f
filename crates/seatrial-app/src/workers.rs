//! Many runs on several threads.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// As many threads as asked for, or one for each core.
pub fn threads(asked: Option<NonZeroUsize>) -> usize {
    asked
        .or_else(|| thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
}

/// Threads, and what is called after every run.
pub struct Workers<'a> {
    threads: usize,
    done: &'a (dyn Fn() + Sync),
}

impl<'a> Workers<'a> {
    /// As many as asked for, or one for each core; `done` is called after every run.
    pub fn new(asked: Option<NonZeroUsize>, done: &'a (dyn Fn() + Sync)) -> Self {
        let threads = threads(asked);
        Self { threads, done }
    }

    /// What `work` makes of 0 to `runs`, in their order whatever the threads; `None` leaves a run out.
    pub fn each<T: Send>(&self, runs: u64, work: impl Fn(u64) -> Option<T> + Sync) -> Vec<T> {
        let next = AtomicU64::new(0);
        let worker = || {
            let mut found = Vec::new();
            loop {
                let run = next.fetch_add(1, Ordering::Relaxed);
                if run >= runs {
                    return found;
                }
                found.extend(work(run).map(|result| (run, result)));
                (self.done)();
            }
        };
        let mut results: Vec<(u64, T)> = thread::scope(|scope| {
            let workers: Vec<_> = (0..self.threads).map(|_| scope.spawn(worker)).collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_default())
                .collect()
        });
        results.sort_by_key(|(run, _)| *run);
        results.into_iter().map(|(_, result)| result).collect()
    }
}

//! Many runs on several threads.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

/// As many threads as asked for, or one for each core.
pub fn threads(asked: Option<NonZeroUsize>) -> usize {
    asked.or_else(|| thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get)
}

/// What `work` makes of each item, in their order, on a thread for each core; in place where there is one core or item, or no
/// threads, as in a browser.
pub fn of_each<I: Sync, T: Send>(items: &[I], work: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let threads = threads(None).min(items.len()).max(1);
    let workers = Workers { threads, done: &|| {} };
    workers.each(items.len() as u64, |index| Some(work(&items[index as usize])))
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

    /// What `work` makes of 0 to `runs`, in their order whatever the threads; `None` leaves a run out. A panic of `work` is one of the
    /// caller. One thread is the caller's own.
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
            let others: Vec<_> = (1..self.threads).map(|_| scope.spawn(worker)).collect();
            let mut results = worker();
            for other in others {
                match other.join() {
                    Ok(more) => results.extend(more),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            results
        });
        results.sort_by_key(|(run, _)| *run);
        results.into_iter().map(|(_, result)| result).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_results_stand_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..100).collect();
        let squares = of_each(&items, |item| item * item);
        assert_eq!(squares, items.iter().map(|i| i * i).collect::<Vec<_>>());
        assert!(of_each(&[] as &[u64], |item| *item).is_empty());
    }

    #[test]
    #[should_panic(expected = "item 7")]
    fn exact_a_panic_is_the_callers() {
        let items: Vec<u64> = (0..20).collect();
        of_each(&items, |item| assert_ne!(*item, 7, "item 7"));
    }
}

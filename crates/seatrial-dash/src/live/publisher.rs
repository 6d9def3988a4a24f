//! Makes messages from the trial's reports, on a thread of its own.

use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use super::SAMPLES_EVERY;
use super::picture::Picture;
use super::tap::{Counts, Report};
use crate::background::go_last;

/// Between two messages about the link.
const HEALTH_EVERY: Duration = Duration::from_secs(1);

pub struct Publisher {
    pub reports: Receiver<Report>,
    pub picture: Weak<Mutex<Picture>>,
    pub counts: Arc<Counts>,
}

impl Publisher {
    /// Takes the reports at intervals: waking this thread for each step would cost the trial a system call.
    pub fn run(self) {
        go_last();
        let mut looked = Instant::now();
        let mut first = None;
        // The server is gone where the picture is.
        while let Some(picture) = self.picture.upgrade() {
            let trial_runs = {
                let mut picture = picture.lock().unwrap_or_else(PoisonError::into_inner);
                for report in first.take().into_iter().chain(self.reports.try_iter()) {
                    if matches!(report, Report::Step(_)) {
                        self.counts.waiting.fetch_sub(1, Ordering::Relaxed);
                    }
                    picture.take(report);
                }
                picture.flush();
                picture.not_shown(self.counts.not_shown.load(Ordering::Relaxed));
                if looked.elapsed() >= HEALTH_EVERY {
                    picture.publish_health();
                    looked = Instant::now();
                }
                picture.trial().is_some_and(|trial| trial.running)
            };
            drop(picture);
            if trial_runs {
                std::thread::sleep(SAMPLES_EVERY);
            } else {
                match self.reports.recv() {
                    Ok(report) => first = Some(report),
                    Err(_) => return,
                }
            }
        }
    }
}

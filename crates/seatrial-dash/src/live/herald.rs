//! Makes messages of what the trial tells.

use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

use super::SAMPLES_EVERY;
use super::picture::Picture;
use super::tap::{Counts, Told};
use crate::background::go_last;

/// Between two messages about the link.
const HEALTH_EVERY: Duration = Duration::from_secs(1);

pub struct Herald {
    pub told: Receiver<Told>,
    pub picture: Weak<Mutex<Picture>>,
    pub counts: Arc<Counts>,
}

impl Herald {
    /// Looks at what was told when its time has come: to be woken for each step would cost the trial a system call.
    pub fn run(self) {
        go_last();
        let mut looked = Instant::now();
        let mut first = None;
        // The server is gone where the picture is.
        while let Some(picture) = self.picture.upgrade() {
            let trial_runs = {
                let mut picture = picture.lock().unwrap_or_else(PoisonError::into_inner);
                for told in first.take().into_iter().chain(self.told.try_iter()) {
                    if matches!(told, Told::Step(_)) {
                        self.counts.waiting.fetch_sub(1, Ordering::Relaxed);
                    }
                    picture.take(told);
                }
                picture.flush();
                picture.not_shown(self.counts.not_shown.load(Ordering::Relaxed));
                if looked.elapsed() >= HEALTH_EVERY {
                    picture.tell_health();
                    looked = Instant::now();
                }
                picture.trial().is_some_and(|trial| trial.running)
            };
            drop(picture);
            if trial_runs {
                std::thread::sleep(SAMPLES_EVERY);
            } else {
                match self.told.recv() {
                    Ok(told) => first = Some(told),
                    Err(_) => return,
                }
            }
        }
    }
}

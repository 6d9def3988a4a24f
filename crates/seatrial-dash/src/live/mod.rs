//! The live stream. The trial tells and never waits; a herald on a thread of its own makes messages and keeps the picture
//! for who comes later; viewers that read too slowly lose messages and are told so.

mod herald;
mod picture;
mod tap;
mod thinned;

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use tokio::sync::broadcast;

use crate::api::{Health, LiveEvent, LiveMessage, TrialState};
use herald::Herald;
use picture::Picture;
pub use tap::Tap;

/// Between two messages with samples.
const SAMPLES_EVERY: Duration = Duration::from_millis(50);
/// Between two heartbeats.
pub const HEARTBEAT_EVERY: Duration = Duration::from_secs(5);

/// A message with its number. All viewers share its bytes.
pub type Message = (u64, Utf8Bytes);

/// The viewers' end of the stream.
#[derive(Clone, Debug)]
pub struct Live {
    picture: Arc<Mutex<Picture>>,
    tap: Tap,
}

impl Live {
    /// Starts the herald; it ends with the last tap.
    pub fn start(stream: String) -> Self {
        let (to_herald, told) = channel();
        let tap = Tap {
            herald: to_herald,
            counts: Arc::default(),
        };
        let picture = Arc::new(Mutex::new(Picture::new(stream)));
        let herald = Herald {
            told,
            picture: Arc::downgrade(&picture),
            counts: Arc::clone(&tap.counts),
        };
        std::thread::spawn(move || herald.run());
        Self { picture, tap }
    }

    /// The trial's end.
    pub fn tap(&self) -> Tap {
        self.tap.clone()
    }

    /// The trial that runs, or the last one, and its link.
    pub fn trial(&self) -> (Option<TrialState>, Option<Health>) {
        let picture = self.picture();
        (picture.trial().cloned(), picture.health_now())
    }

    /// What was missed since a message of a stream, or a snapshot; and what comes.
    pub fn join(
        &self,
        stream: Option<&str>,
        after: Option<u64>,
    ) -> (Vec<Message>, broadcast::Receiver<Message>) {
        let picture = self.picture();
        let missed = after.and_then(|after| picture.missed(stream?, after));
        let first = missed.unwrap_or_else(|| vec![picture.snapshot()]);
        (first, picture.subscribe())
    }

    /// A message outside the count of events.
    pub fn aside(&self, event: LiveEvent) -> Message {
        let sequence = self.picture().sequence();
        (sequence, text(&LiveMessage { sequence, event }))
    }

    fn picture(&self) -> MutexGuard<'_, Picture> {
        self.picture.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn text(message: &LiveMessage) -> Utf8Bytes {
    serde_json::to_string(message).unwrap_or_default().into()
}

//! The live stream. The trial sends reports and never waits; a thread makes messages from them and keeps a picture for viewers
//! that come later. A viewer that reads too slowly loses messages, and gets a message that says so.

mod decimator;
mod picture;
mod publisher;
mod tap;

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::ws::Utf8Bytes;
use tokio::sync::broadcast;

use crate::api::{Health, LiveEvent, LiveMessage, TrialState};
use picture::Picture;
use publisher::Publisher;
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
    /// Starts the publisher; it ends with the last tap.
    pub fn start(stream: String) -> Self {
        let (to_publisher, reports) = channel();
        let tap = Tap { publisher: to_publisher, counts: Arc::default() };
        let picture = Arc::new(Mutex::new(Picture::new(stream)));
        let publisher = Publisher {
            reports,
            picture: Arc::downgrade(&picture),
            counts: Arc::clone(&tap.counts),
        };
        std::thread::spawn(move || publisher.run());
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

//! Standard error that holds up nobody, once a vehicle may be ours.

use std::sync::OnceLock;

use seatrial_app::text_queue::TextQueue;

static QUEUE: OnceLock<TextQueue> = OnceLock::new();

/// From now on nobody waits for standard error.
pub fn detach() {
    QUEUE.get_or_init(TextQueue::default);
}

/// May a vehicle have been ours?
pub fn is_detached() -> bool {
    QUEUE.get().is_some()
}

/// Writes or draws as soon as standard error takes it; at once where it is not detached.
pub fn write(job: impl FnOnce() + Send + 'static) {
    match QUEUE.get() {
        Some(queue) => queue.write(job),
        None => job(),
    }
}

/// Waits a moment until all is written. Returns how many texts were left out since this was asked last.
pub fn finish() -> u32 {
    let Some(queue) = QUEUE.get() else {
        return 0;
    };
    queue.finish();
    queue.left_out()
}

//! Middlewares that carry ROS 2.

#[cfg(feature = "ros2")]
mod dds;
mod wire;
#[cfg(feature = "ros2-zenoh")]
mod zenoh;

use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

#[cfg(feature = "ros2-zenoh")]
pub(super) use self::zenoh::OverZenoh;
#[cfg(feature = "ros2")]
pub(super) use dds::Dds;

use super::Heard;

const DIAGNOSTICS_TOPIC: &str = "/diagnostics";

/// The next of what threads of a middleware have heard, with the time since the beginning when it came, s; waited for so long, s.
fn next_heard(
    heard: &Receiver<(Instant, Heard)>,
    begin: Instant,
    wait_s: f64,
) -> Option<(f64, Heard)> {
    let received = match Duration::try_from_secs_f64(wait_s) {
        Ok(wait) => heard.recv_timeout(wait).ok(),
        Err(_) => heard.try_recv().ok(),
    };
    let (came, heard) = received?;
    Some((came.saturating_duration_since(begin).as_secs_f64(), heard))
}

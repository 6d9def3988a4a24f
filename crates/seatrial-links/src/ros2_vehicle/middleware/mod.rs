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

use serde::de::DeserializeOwned;

use super::{Description, FeedbackType, Heard, MiddlewareError};

const DIAGNOSTICS_TOPIC: &str = "/diagnostics";

/// Says what could not be made or done.
fn failed<E: std::fmt::Display>(what: &str) -> impl FnOnce(E) -> MiddlewareError + '_ {
    move |error| format!("{what}: {error}").into()
}

/// A topic that is listened to: its name, its type, and whether a lost message is sent again.
type Source<'a> = (&'a str, wire::Kind, bool);

/// What listens to topics.
trait Listener {
    /// Takes what the messages of a topic are for us.
    fn hear<M: DeserializeOwned + Send + 'static>(
        &mut self,
        source: Source,
        heard: impl Fn(M) -> Option<Heard> + Send + Sync + 'static,
    ) -> Result<(), MiddlewareError>;

    /// Listens to every topic of a description.
    fn hear_all(&mut self, description: &Description) -> Result<(), MiddlewareError> {
        if let Some(imu) = &description.imu {
            let source = (imu.topic.as_str(), wire::IMU, imu.reliable);
            self.hear(source, |imu: wire::Imu| Some(Heard::Imu(imu.motion())))?;
        }
        if let Some(odometry) = &description.odometry {
            let source = (odometry.topic.as_str(), wire::ODOMETRY, odometry.reliable);
            self.hear(source, |odometry: wire::Odometry| Some(Heard::Odometry(odometry.motion())))?;
        }
        let Some(feedback) = &description.feedback else {
            return Ok(());
        };
        let kind = wire::kind_of_feedback(feedback.kind);
        let source = (feedback.topic.as_str(), kind, feedback.reliable);
        match feedback.kind {
            FeedbackType::JointState => {
                let joint = feedback.joint.clone().unwrap_or_default();
                self.hear(source, move |state: wire::JointState| state.rudder(&joint))
            }
            FeedbackType::Float64 => {
                self.hear(source, |number: wire::Float64| Some(number.rudder()))
            }
            FeedbackType::Float32 => {
                self.hear(source, |number: wire::Float32| Some(number.rudder()))
            }
        }
    }
}

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

//! Estimates as a topic.

use std::io;

use seatrial_core::YawModel;

use super::middleware_error::MiddlewareError;

/// Name of the topic of estimates.
pub const ESTIMATE_TOPIC: &str = "/seatrial/estimate";

/// An estimate and the time of the sample it was made with.
#[derive(Clone, Copy, Debug)]
pub struct TimedEstimate {
    /// Time of the sample, s.
    pub time_s: f64,
    /// a22, b2 and C0.
    pub model: YawModel<f64>,
    /// Half widths of their 95 % intervals.
    pub half_widths: Option<[f64; 3]>,
    /// Step norm of the parameters (39).
    pub step_norm: f64,
}

/// Publishes estimates as messages of `std_msgs/Float64MultiArray`; what is missing is not a number.
pub struct EstimateTopic(Publish);

type Publish = Box<dyn FnMut(&TimedEstimate) -> Result<(), MiddlewareError>>;

impl EstimateTopic {
    /// A topic that estimates are published on by this function.
    pub fn new(
        publish: impl FnMut(&TimedEstimate) -> Result<(), MiddlewareError> + 'static,
    ) -> Self {
        Self(Box::new(publish))
    }

    /// Publishes an estimate.
    pub fn publish(&mut self, estimate: &TimedEstimate) -> io::Result<()> {
        (self.0)(estimate).map_err(|error| io::Error::other(format!("{ESTIMATE_TOPIC}: {error}")))
    }
}

//! Estimates as a topic.

use std::io;

use super::wire::Float64MultiArray;
use crate::{Row, RowWriter};

/// The topic of estimates and what its numbers are.
pub(super) const TOPIC: &str = "/seatrial/estimate";
const LABEL: &str = "time_s,a22_per_s,b2_per_s2,c0_rad_per_s2,half_width_a22_per_s,half_width_b2_per_s2,half_width_c0_rad_per_s2,step_norm";

/// Estimates as messages of `std_msgs/Float64MultiArray`; what is missing is no number.
pub struct EstimateTopic(Publish);

type Publish = Box<dyn FnMut(Float64MultiArray) -> Result<(), String>>;

impl EstimateTopic {
    pub(super) fn new(
        publish: impl FnMut(Float64MultiArray) -> Result<(), String> + 'static,
    ) -> Self {
        Self(Box::new(publish))
    }
}

impl RowWriter for EstimateTopic {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        let Some(estimate) = row.estimate else {
            return Ok(());
        };
        let mut data = vec![row.sample.time_s];
        data.extend(estimate.model.theta());
        data.extend(estimate.half_widths.unwrap_or([f64::NAN; 3]));
        data.push(estimate.step_norm);
        let published = (self.0)(Float64MultiArray::of(LABEL, data));
        published.map_err(|error| io::Error::other(format!("{TOPIC}: {error}")))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(())
    }
}

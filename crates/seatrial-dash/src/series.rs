//! Records as columns of the programming interface.

use crate::api::LogSeries;

impl From<seatrial_app::series::LogSeries> for LogSeries {
    fn from(series: seatrial_app::series::LogSeries) -> Self {
        Self {
            time_s: series.time_s,
            heading_rad: series.heading_rad,
            rudder: series.rudder,
            yaw_rate_rad_s: series.yaw_rate_rad_s,
            simulated_heading_rad: series.simulated_heading_rad,
        }
    }
}

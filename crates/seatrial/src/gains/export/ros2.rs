//! ROS 2 parameters.

use std::fmt::Write as _;

use super::{Schedule, comment, decimal};

impl Schedule {
    /// A parameter file of ROS 2 for a node `heading_controller`: the schedule as arrays.
    ///
    /// ```
    /// use seatrial::GainAllowance;
    /// use seatrial::gains::{DAMPING_RATIO, export::Schedule};
    /// use seatrial_core::{NoGain, SchedulePoint, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
    /// let point = SchedulePoint { thrust: Some(0.8), surge_speed_m_s: Some(1.6), model };
    /// let schedule =
    ///     Schedule::design("trial 3", &[(point, GainAllowance::default())], DAMPING_RATIO, 0.26)?;
    /// assert!(schedule.ros2_yaml().contains("heading_controller:"));
    /// # Ok::<(), NoGain>(())
    /// ```
    pub fn ros2_yaml(&self) -> String {
        let mut text = format!(
            "# Heading gains by seatrial from {}\n# {}\n# {}\n{}heading_controller:\n  ros__parameters:\n    \
             damping_ratio: {}\n    rudder_limit_rad: {}\n    schedule:\n",
            comment(&self.source),
            self.law,
            self.allows_for(),
            self.note_lines("# "),
            decimal(self.damping_ratio),
            decimal(self.rudder_limit_rad)
        );
        for (name, unit, values) in self.columns() {
            let values: Vec<String> = values.into_iter().map(decimal).collect();
            let _ = writeln!(text, "      {name}: [{}]  # {unit}", values.join(", "));
        }
        text
    }
}

//! A C header.

use std::fmt::Write as _;

use super::{Schedule, comment, decimal};

impl Schedule {
    /// The schedule as a table in C99, slowest first.
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
    /// assert!(schedule.c_header().contains("#ifndef"));
    /// # Ok::<(), NoGain>(())
    /// ```
    pub fn c_header(&self) -> String {
        let columns = self.columns();
        let mut text = format!(
            "/* Heading gains by seatrial from {}\n *\n * {}\n * {}\n *\n{} \
             * Rows in increasing order of their first column; interpolate between them, do not extrapolate. */\n\
             #ifndef SEATRIAL_GAINS_H\n#define SEATRIAL_GAINS_H\n\n\
             #define SEATRIAL_DAMPING_RATIO {}\n\
             #define SEATRIAL_RUDDER_LIMIT_RAD {}\n\
             #define SEATRIAL_GAINS_COUNT {}\n\n\
             struct seatrial_gains {{\n",
            comment(&self.source),
            self.law,
            self.allows_for(),
            self.note_lines(" * "),
            decimal(self.damping_ratio),
            decimal(self.rudder_limit_rad),
            self.points.len()
        );
        for (name, unit, _) in &columns {
            let _ = writeln!(text, "    double {name}; /* {unit} */");
        }
        text +=
            "};\n\nstatic const struct seatrial_gains seatrial_gains[SEATRIAL_GAINS_COUNT] = {\n";
        for row in 0..self.points.len() {
            let values: Vec<String> =
                columns.iter().map(|(.., values)| decimal(values[row])).collect();
            let _ = writeln!(text, "    {{{}}},", values.join(", "));
        }
        text + "};\n\n#endif\n"
    }
}

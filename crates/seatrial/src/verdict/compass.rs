//! What a compass does to a model where it disagrees with the gyro.
//!
//! Fresh data pass through the same compass, so that no validation shows these. Without a gyro in the record nothing does:
//! swing the compass, and read it with its own time.

use super::{Weighing, degrees, percent, three_figures};
use crate::identify::compass::CompassError;

/// Share by which the heading may change more or less than the yaw rate says: b2 is wrong by as much, and the
/// scale of a gyro is good to 3 %.
const LARGEST_SCALE_ERROR: f64 = 0.05;

/// Time by which the heading may be later than the yaw rate, in time constants of the vehicle: a22 is wrong by some
/// twice that.
const LATEST: f64 = 0.075;

impl Weighing {
    pub(super) fn compass(&mut self, found: &CompassError, a22_per_s: f64) {
        if let Some(jump_rad) = found.largest_jump_rad {
            self.reject(
                "compass_error",
                format!(
                    "within a second the heading parts by {} deg from where the yaw rate takes it, which no vehicle does: the compass jumped, stuck or was disturbed, or the clock jumped; repeat the run, away from iron and electric currents",
                    degrees(jump_rad)
                ),
            );
        }
        if let Some(scale) = found.scale_error.filter(|x| x.abs() > LARGEST_SCALE_ERROR) {
            let (share, more) = (
                percent(scale.abs()),
                if scale > 0.0 { "more" } else { "less" },
            );
            self.reject(
                "compass_deviation",
                format!(
                    "the heading changes by {share} % {more} than the yaw rate says, and b2 is wrong by as much: the compass deviates on these headings, or the gyro's scale is wrong; swing the compass, or turn a full circle and compare the gyro's angle with 360 deg"
                ),
            );
        }
        if let Some(late_s) = found.late_s.filter(|x| x * a22_per_s.abs() > LATEST) {
            self.reject(
                "compass_late",
                format!(
                    "the heading is {} s later than the yaw rate, which makes the vehicle look slower than it is: the compass is filtered, held, or logged with the time of its arrival; log it with the time of the measurement, or identify from the gyro's attitude",
                    three_figures(late_s)
                ),
            );
        }
    }
}

//! The ranges of the numbers in a vehicle file.

use std::f64::consts::FRAC_PI_2;

use super::{IdentifiedVehicle, SCHEMA};
use crate::config_error::{ConfigError, invalid};
use crate::range::{check, within, within_if_given};

/// Shortest drag length, s at the fastest speed.
const SHORTEST_DRAG_S: f64 = 0.05;

impl IdentifiedVehicle {
    /// Names the first field that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        if self.schema != SCHEMA {
            let requirement = "seatrial.vehicle.v1, the version that this seatrial reads";
            return Err(invalid("schema", requirement, &self.schema));
        }
        self.check_rudder()?;
        self.check_surge_and_noise()?;
        if self.speeds.is_empty() {
            return Err(invalid("speed", "a list of at least one speed", "empty"));
        }
        for k in 0..self.speeds.len() {
            self.check_speed(k)?;
        }
        self.check_drag()
    }

    /// A drag that stops a vehicle within a few hundredths of a second is no vehicle's, and is not followed in steps of 5 ms.
    fn check_drag(&self) -> Result<(), ConfigError> {
        let fastest_m_s = self.speeds.last().map_or(0.0, |p| p.surge_speed_m_s);
        let length_m = self.surge.drag_length_m.unwrap_or(f64::INFINITY);
        check(
            "surge.drag_length_m",
            length_m,
            length_m >= SHORTEST_DRAG_S * fastest_m_s,
            "at least the way at the fastest speed in 0.05 s",
        )
    }

    fn check_rudder(&self) -> Result<(), ConfigError> {
        let rudder = &self.rudder;
        within!(rudder.limit_rad, 1e-3, FRAC_PI_2, "rad")?;
        within!(rudder.lag_s, 0.0, 600.0, "s")?;
        within!(rudder.delay_s, 0.0, 60.0, "s")?;
        within_if_given!(rudder.rate_limit_rad_s, 1e-4, 1e3, "rad/s")
    }

    fn check_surge_and_noise(&self) -> Result<(), ConfigError> {
        let (surge, sample_interval_s) = (&self.surge, self.sample_interval_s);
        within_if_given!(sample_interval_s, 1e-3, 60.0, "s")?;
        within!(surge.time_constant_s, 1e-3, 1e5, "s")?;
        within_if_given!(surge.drag_length_m, 1e-2, 1e6, "m")?;
        within_if_given!(surge.turning_drag_m, 0.0, 1e6, "m")?;
        let Some(noise) = &self.noise else {
            return Ok(());
        };
        within!(noise.heading_rad, 0.0, 1.0, "rad")?;
        within!(noise.disturbance_rad_s2, 0.0, 1e3, "rad/s^2")?;
        within_if_given!(noise.disturbance_time_s, 1e-3, 1e5, "s")
    }

    fn check_speed(&self, k: usize) -> Result<(), ConfigError> {
        let speed = &self.speeds[k];
        let before = k.checked_sub(1).map(|k| &self.speeds[k]);
        let above =
            |now: f64, last: Option<f64>, most: f64| now > last.unwrap_or(0.0) && now <= most;
        let field = |name: &str| format!("speed[{k}].{name}");
        for (name, value, holds, requirement) in [
            (
                "thrust",
                speed.thrust,
                above(speed.thrust, before.map(|p| p.thrust), 1.0),
                "above 0 and the thrust before, and at most 1",
            ),
            (
                "surge_speed_m_s",
                speed.surge_speed_m_s,
                above(speed.surge_speed_m_s, before.map(|p| p.surge_speed_m_s), 100.0),
                "above 0 and the speed before, and at most 100 m/s",
            ),
            (
                "a22_per_s",
                speed.a22_per_s,
                speed.a22_per_s.abs() <= 1e3,
                "a number from -1000 to 1000 1/s",
            ),
            (
                "b2_per_s2",
                speed.b2_per_s2,
                (1e-9..=1e6).contains(&speed.b2_per_s2.abs()),
                "a number other than 0, to 1000000 1/s^2 on either side",
            ),
            (
                "c0_rad_per_s2",
                speed.c0_rad_per_s2,
                speed.c0_rad_per_s2.abs() <= 1e3,
                "a number from -1000 to 1000 rad/s^2",
            ),
            (
                "seen_rudder_rad",
                speed.seen_rudder_rad.unwrap_or(0.0),
                speed.seen_rudder_rad.is_none_or(|seen| (0.0..=FRAC_PI_2).contains(&seen)),
                "absent or an angle from 0 to 1.5708 rad",
            ),
        ] {
            if !holds {
                return Err(invalid(field(name), requirement, value));
            }
        }
        speed
            .covariance
            .map_or(Ok(()), |covariance| check_covariance(&covariance, field("covariance")))
    }
}

fn check_covariance(covariance: &[[f64; 3]; 3], field: String) -> Result<(), ConfigError> {
    let requirement =
        "absent or three rows of three, symmetric, no variance below 0, no correlation beyond 1";
    match is_a_covariance(covariance) {
        true => Ok(()),
        false => Err(invalid(field, requirement, format!("{covariance:?}"))),
    }
}

fn is_a_covariance(covariance: &[[f64; 3]; 3]) -> bool {
    (0..3).all(|i| {
        let variance = covariance[i][i];
        (0.0..=1e12).contains(&variance)
            && (0..3).all(|j| {
                let most = (variance * covariance[j][j]).sqrt();
                let asymmetry = (covariance[i][j] - covariance[j][i]).abs();
                // Rounding of decimal digits in a file.
                covariance[i][j].abs() <= most * (1.0 + 1e-9) && asymmetry <= 1e-9 * most
            })
    })
}

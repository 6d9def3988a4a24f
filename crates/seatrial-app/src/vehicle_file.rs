//! The vehicle file of models: what a simulator, planner or controller needs, with what nobody measured named.

use seatrial::gains::longest;
use seatrial_core::RudderUnit;
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::{
    IdentifiedSpeed, NoiseEstimate, Provenance, Rudder, SCHEMA, SurgeLaw,
};

use crate::Error;
use crate::models::{ModelPoint, Models};

/// Time constant of the speed where no record tells it, in time constants of the yaw at the slowest speed.
const ASSUMED_SURGE_TIME: f64 = 2.0;

/// What is said of a vehicle besides its models. Absent: what the source knows, or an assumption that the file names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VehicleOverrides {
    /// Name of the vehicle.
    pub name: Option<String>,
    /// Rudder at full steering, rad, of models whose rudder is a fraction of full.
    pub full_rudder_rad: Option<f64>,
    /// Time constant of the rudder's lag, s.
    pub lag_s: Option<f64>,
    /// Dead time before it, s.
    pub delay_s: Option<f64>,
    /// Fastest motion of the rudder, rad/s.
    pub rate_limit_rad_s: Option<f64>,
    /// Time constant of the speed after a change of thrust, s.
    pub surge_time_constant_s: Option<f64>,
}

impl VehicleOverrides {
    /// The vehicle of these models, checked.
    pub fn vehicle(&self, models: &Models) -> Result<IdentifiedVehicle, Error> {
        let mut assumptions = Vec::new();
        let angle_rad = self.radians_per_rudder(models)?;
        let speeds = speeds(models, angle_rad, &mut assumptions)?;
        let timing = longest(models.points.iter().map(|point| point.allowance));
        let rudder = Rudder {
            limit_rad: models.rudder_limit_rad * angle_rad,
            lag_s: self.lag_s.unwrap_or_else(|| {
                // What a loop waits for is the lag and a sample of the record.
                let record_s = timing.sample_interval_s.unwrap_or(0.0);
                rounded((timing.delay_s - record_s).max(0.0))
            }),
            delay_s: self.delay_s.unwrap_or(0.0),
            rate_limit_rad_s: self.rate_limit_rad_s,
        };
        if timing.sample_interval_s.is_none() && self.lag_s.is_none() {
            assumptions.push(
                "rudder.lag_s is ASSUMED 0: the source does not tell a lag of the rudder".into(),
            );
        }
        let vehicle = IdentifiedVehicle {
            schema: SCHEMA.into(),
            name: self.name(models),
            sample_interval_s: timing.sample_interval_s,
            rudder,
            surge: self.surge(models, &speeds, &mut assumptions),
            noise: noise(models),
            speeds,
            provenance: Provenance { assumptions, ..provenance(models) },
        };
        vehicle
            .check()
            .map_err(|error| Error::Input(format!("{}: as a vehicle: {error}", models.origin)))?;
        Ok(vehicle)
    }

    fn name(&self, models: &Models) -> String {
        let of_trial = models.trial.as_ref().map(|trial| trial.vehicle.clone());
        self.name.clone().or(of_trial).unwrap_or_else(|| "vehicle".into())
    }

    /// How many rad a unit of the models' rudder is.
    fn radians_per_rudder(&self, models: &Models) -> Result<f64, Error> {
        let stated = self.full_rudder_rad;
        if let Some(angle_rad) = stated.filter(|angle| !(*angle > 0.0 && *angle < 1.57)) {
            return Err(Error::Setting(format!(
                "--full-steering-deg {}: expected an angle above 0 and below 90 degrees",
                angle_rad.to_degrees()
            )));
        }
        match models.rudder_unit {
            RudderUnit::Rad => Ok(1.0),
            RudderUnit::FullRudder => stated.ok_or_else(|| {
                Error::Setting(format!(
                    "{}: its rudder is a fraction of full, and a vehicle needs the angle: give the one at full steering with --full-steering-deg DEG",
                    models.origin
                ))
            }),
        }
    }

    fn surge(
        &self,
        models: &Models,
        speeds: &[IdentifiedSpeed],
        assumptions: &mut Vec<String>,
    ) -> SurgeLaw {
        let middle_m_s =
            speeds.iter().map(|p| p.surge_speed_m_s).sum::<f64>() / speeds.len() as f64;
        let found = models.surge.as_ref();
        let from_trial_s = found.and_then(|surge| surge.time_constant_s(middle_m_s));
        if let Some(time_constant_s) = self.surge_time_constant_s {
            return linear(time_constant_s);
        }
        if let (Some(surge), Some(time_constant_s)) = (found, from_trial_s) {
            if surge.turning_drag_m.is_none() {
                assumptions.push(
                    "surge.turning_drag_m is not identifiable from this record and is ASSUMED 0: no accepted run lost speed in its turns; a U-turn under full rudder tells it".into(),
                );
            }
            return SurgeLaw {
                time_constant_s,
                drag_length_m: surge.drag_length_m,
                turning_drag_m: surge.turning_drag_m,
            };
        }
        assumptions.push(
            "surge is not identifiable from this record, and surge.time_constant_s is ASSUMED to be two time constants of the yaw: no run began with a change of speed; plan a second thrust, such as a step from 100 to 40 % (`seatrial plan --thrust 1 --thrust 0.4`), or give it with --surge-time-constant".into(),
        );
        let yaw_s = speeds.first().map_or(1.0, |p| 1.0 / p.a22_per_s.abs());
        linear((ASSUMED_SURGE_TIME * yaw_s).clamp(1e-3, 1e5))
    }
}

fn linear(time_constant_s: f64) -> SurgeLaw {
    SurgeLaw { time_constant_s, drag_length_m: None, turning_drag_m: None }
}

/// To a microsecond: what the difference of two times in seconds leaves.
fn rounded(time_s: f64) -> f64 {
    (time_s * 1e6).round() / 1e6
}

/// The speeds, slowest first. Where no thrust is known it is taken to be proportional to the speed.
fn speeds(
    models: &Models,
    angle_rad: f64,
    assumptions: &mut Vec<String>,
) -> Result<Vec<IdentifiedSpeed>, Error> {
    let known = |point: &ModelPoint| {
        point.point.surge_speed_m_s.ok_or_else(|| {
            Error::Input(format!(
                "{}: {} has no forward speed, and a vehicle needs one: give a single model's with --speed M_S, or a log or trial with a speed",
                models.origin,
                point.name()
            ))
        })
    };
    let speeds_m_s: Vec<f64> = models.points.iter().map(known).collect::<Result<_, _>>()?;
    let fastest_m_s = speeds_m_s.iter().copied().fold(0.0, f64::max);
    if models.points.iter().any(|point| point.point.thrust.is_none()) {
        assumptions.push(
            "thrust is ASSUMED proportional to speed, full at the fastest: the source does not tell it".into(),
        );
    }
    let has_thrusts = models.points.iter().all(|point| point.point.thrust.is_some());
    let speed = |(point, surge_speed_m_s): (&ModelPoint, &f64)| {
        let model = point.point.model;
        let scale = [1.0, 1.0 / angle_rad, 1.0];
        let scaled = |covariance: [[f64; 3]; 3]| {
            std::array::from_fn(|i| std::array::from_fn(|j| covariance[i][j] * scale[i] * scale[j]))
        };
        IdentifiedSpeed {
            thrust: point
                .point
                .thrust
                .filter(|_| has_thrusts)
                .unwrap_or(surge_speed_m_s / fastest_m_s),
            surge_speed_m_s: *surge_speed_m_s,
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2 / angle_rad,
            c0_rad_per_s2: model.c0_rad_per_s2,
            covariance: point.covariance.map(scaled),
            seen_rudder_rad: point.valid_range.map(|range| range.largest_rudder() * angle_rad),
        }
    };
    let mut found: Vec<IdentifiedSpeed> =
        models.points.iter().zip(&speeds_m_s).map(speed).collect();
    found.sort_by(|a, b| a.surge_speed_m_s.total_cmp(&b.surge_speed_m_s));
    Ok(found)
}

/// The noise of all records together.
fn noise(models: &Models) -> Option<NoiseEstimate> {
    let found: Vec<[f64; 2]> = models.points.iter().filter_map(|p| p.noise).collect();
    let mean = |k: usize| {
        let squares: f64 = found.iter().map(|noise| noise[k] * noise[k]).sum();
        (squares / found.len() as f64).sqrt()
    };
    (!found.is_empty()).then(|| NoiseEstimate {
        heading_rad: mean(0),
        disturbance_rad_s2: mean(1),
        disturbance_time_s: None,
    })
}

fn provenance(models: &Models) -> Provenance {
    let trial = models.trial.as_ref();
    Provenance {
        source: models.origin.clone(),
        vehicle: trial.map_or(String::new(), |trial| trial.vehicle.clone()),
        configuration: trial.map_or(String::new(), |trial| trial.configuration.clone()),
        trial_started: trial.and_then(|trial| trial.started.clone()).unwrap_or_default(),
        software_version: env!("CARGO_PKG_VERSION").into(),
        is_rehearsal: trial.is_some_and(|trial| trial.is_rehearsal),
        assumptions: Vec::new(),
        cautions: models.notes(),
    }
}

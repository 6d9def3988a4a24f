//! Schedule files: models over speed or thrust, in TOML.

use std::path::Path;

use seatrial::GainAllowance;
use seatrial::identification::ReasonCode;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::schedule::CAPACITY;
use seatrial_core::{RudderUnit, SchedulePoint, YawModel};
use serde::{Deserialize, Serialize};

use super::statement::ModelStatement;
use super::{ModelPoint, Models, given, limit_or_default, read_text};
use crate::Error;
use crate::documents::Source;
use crate::identify_log::SpeedModel;

/// How the schedule file looks, for help texts.
pub const SCHEDULE_FILE_HELP: &str = "\
A schedule file is TOML with one [[point]] for each speed (thrust is a fraction of full; thrust, \
surge_speed_m_s and c0_rad_per_s2 may be left out; full_rudder_rad is the rudder at full steering, where \
it is not the rudder limit):
  rudder_limit_rad = 0.26
  [[point]]
  thrust = 0.6
  surge_speed_m_s = 1.07
  a22_per_s = -0.95
  b2_per_s2 = 0.60
  c0_rad_per_s2 = 0.0072
`seatrial identify LOG --schedule FILE` adds what a gain allows for: a22_interval_95_per_s, covariance of [a22, b2, C0], \
gain_a22_per_s (the vehicle that the gain is made for), delay_s, sample_interval_s and may_be_unstable, \
which gives no gain. Without them a gain allows for nothing.";

/// A schedule file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ScheduleFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    rudder_limit_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    full_rudder_rad: Option<f64>,
    #[serde(default)]
    rudder_unit: RudderUnit,
    point: Vec<ScheduleFilePoint>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ScheduleFilePoint {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    a22_per_s: f64,
    b2_per_s2: f64,
    #[serde(default)]
    c0_rad_per_s2: f64,
    /// 95 % interval of a22, 1/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    a22_interval_95_per_s: Option<[f64; 2]>,
    /// Covariance of [a22, b2, C0].
    #[serde(skip_serializing_if = "Option::is_none")]
    covariance: Option<[[f64; 3]; 3]>,
    /// a22 of the vehicle that the gain is made for, 1/s, where it is not the end of the interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    gain_a22_per_s: Option<f64>,
    /// Dead time of the loop, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    delay_s: Option<f64>,
    /// Interval of a sampled controller, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    sample_interval_s: Option<f64>,
    /// Of the vehicles that explain the log some are not steered by any gain of this model.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    may_be_unstable: bool,
}

impl ScheduleFilePoint {
    /// The model of a speed of a log, with all that its gain allows for.
    fn of(speed: &SpeedModel) -> Option<Self> {
        let identification = speed.identification.as_ref()?;
        let model = identification.model();
        let refined = identification.refined.as_ref();
        let timing = identification.loop_timing;
        Some(Self {
            thrust: speed.thrust,
            surge_speed_m_s: speed.surge_speed_m_s,
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
            a22_interval_95_per_s: refined.map(|refined| refined.interval_95.a22_per_s),
            covariance: refined.map(|refined| refined.covariance),
            gain_a22_per_s: identification.gain_vehicle().map(|vehicle| vehicle.a22_per_s),
            delay_s: timing.map(|timing| timing.delay_s),
            sample_interval_s: timing.and_then(|timing| timing.sample_interval_s),
            may_be_unstable: identification.verdict.has(&ReasonCode::Unstable),
        })
    }

    fn stated(&self) -> ModelStatement {
        ModelStatement {
            theta: self.model().theta(),
            intervals: [self.a22_interval_95_per_s, None, None],
            covariance: self.covariance,
            gain_a22_per_s: self.gain_a22_per_s,
            amounts: vec![("delay_s", self.delay_s), ("sample_interval_s", self.sample_interval_s)],
            ..ModelStatement::default()
        }
    }

    fn model(&self) -> YawModel<f64> {
        YawModel::from_theta([self.a22_per_s, self.b2_per_s2, self.c0_rad_per_s2])
    }

    fn into_model(self) -> ModelPoint {
        ModelPoint {
            covariance: self.covariance,
            allowance: GainAllowance {
                damping_per_s: GainAllowance::damping_of(
                    self.a22_per_s,
                    self.stated().least_damped_per_s(),
                    self.may_be_unstable,
                ),
                timing: LoopTiming {
                    delay_s: self.delay_s.unwrap_or(0.0),
                    sample_interval_s: self.sample_interval_s,
                },
            },
            ..ModelPoint::exact(SchedulePoint {
                thrust: self.thrust,
                surge_speed_m_s: self.surge_speed_m_s,
                model: self.model(),
            })
        }
    }
}

/// The models of a [schedule file](SCHEDULE_FILE_HELP).
///
/// # Errors
/// A file that cannot be read, is no schedule, or has a number out of its range or an interval that does not hold its value.
pub fn of_schedule_file(path: &Path) -> Result<Models, Error> {
    let file: ScheduleFile = toml::from_str(&read_text(path)?).map_err(|error| {
        Error::Input(format!("{}: {error}\n{SCHEDULE_FILE_HELP}", path.display()))
    })?;
    if file.point.is_empty() {
        return Err(Error::Input(format!(
            "{}: no [[point]]\n{SCHEDULE_FILE_HELP}",
            path.display()
        )));
    }
    if let Some(wrong) = contradiction(&file.point) {
        return Err(Error::Setting(format!("{}: {wrong}", path.display())));
    }
    for (number, point) in (1..).zip(&file.point) {
        if let Some(wrong) = point.stated().wrong() {
            let wrong = format!("{}: point {number}: {wrong}", path.display());
            return Err(Error::Setting(wrong));
        }
    }
    let points = file.point.into_iter().map(ScheduleFilePoint::into_model);
    Ok(Models {
        origin: path.display().to_string(),
        points: points.collect(),
        rudder_limit_rad: limit_or_default(
            file.rudder_limit_rad.or(file.full_rudder_rad),
            file.rudder_unit,
        ),
        rudder_unit: file.rudder_unit,
        full_rudder: given(file.full_rudder_rad),
        trial: None,
        cautions: Vec::new(),
        surge: None,
        passed_over: None,
        rejected: Vec::new(),
        promised: None,
    })
}

/// What is wrong with the points together, where something is: a schedule has one model for a thrust or a speed.
fn contradiction(points: &[ScheduleFilePoint]) -> Option<String> {
    if points.len() > CAPACITY {
        return Some(format!("{} points: a schedule holds at most {CAPACITY}", points.len()));
    }
    let key = |point: &ScheduleFilePoint| (point.thrust, point.surge_speed_m_s);
    let (second, first) = points.iter().enumerate().find_map(|(i, point)| {
        let first = points[..i].iter().position(|other| key(other) == key(point))?;
        Some((i, first))
    })?;
    Some(format!(
        "points {} and {} are of the same thrust and speed: keep one of them",
        first + 1,
        second + 1
    ))
}

/// The accepted models of a log as the text of a schedule file.
pub fn write_schedule_file(models: &[SpeedModel], log: &Source) -> Result<String, Error> {
    let accepted = models.iter().filter(|model| model.verdict.accepted);
    let schedule = ScheduleFile {
        rudder_limit_rad: None,
        full_rudder_rad: log.description.full_rudder_rad,
        rudder_unit: log.rudder_unit,
        point: accepted.filter_map(ScheduleFilePoint::of).collect(),
    };
    if schedule.point.is_empty() {
        return Err(Error::Rejected("no model was accepted, and no schedule is written".into()));
    }
    toml::to_string(&schedule).map_err(|error| Error::Setting(error.to_string()))
}

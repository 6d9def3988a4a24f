//! Schedule files: models over speed or thrust, in TOML.

use std::path::Path;

use seatrial_core::{RudderUnit, SchedulePoint, YawModel};
use serde::{Deserialize, Serialize};

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
  c0_rad_per_s2 = 0.0072";

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
}

/// The models of a [schedule file](SCHEDULE_FILE_HELP).
///
/// # Errors
/// A file that cannot be read, is no schedule or has a number out of its range.
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
    let point = |p: ScheduleFilePoint| {
        ModelPoint::exact(SchedulePoint {
            thrust: p.thrust,
            surge_speed_m_s: p.surge_speed_m_s,
            model: YawModel::from_theta([p.a22_per_s, p.b2_per_s2, p.c0_rad_per_s2]),
        })
    };
    Ok(Models {
        origin: path.display().to_string(),
        points: file.point.into_iter().map(point).collect(),
        rudder_limit_rad: limit_or_default(file.rudder_limit_rad, file.rudder_unit),
        rudder_unit: file.rudder_unit,
        full_rudder: given(file.full_rudder_rad),
        trial: None,
        cautions: Vec::new(),
        surge: None,
        passed_over: None,
        rejected: Vec::new(),
    })
}

/// The accepted models of a log as the text of a schedule file.
pub fn write_schedule_file(models: &[SpeedModel], log: &Source) -> Result<String, Error> {
    let point = |speed: &SpeedModel| {
        let model = speed.identification.as_ref()?.model();
        Some(ScheduleFilePoint {
            thrust: speed.thrust,
            surge_speed_m_s: speed.surge_speed_m_s,
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
        })
    };
    let accepted = models.iter().filter(|model| model.verdict.accepted);
    let schedule = ScheduleFile {
        rudder_limit_rad: None,
        full_rudder_rad: log.description.full_rudder_rad,
        rudder_unit: log.rudder_unit,
        point: accepted.filter_map(point).collect(),
    };
    if schedule.point.is_empty() {
        return Err(Error::Rejected(
            "no model was accepted, and no schedule is written".into(),
        ));
    }
    toml::to_string(&schedule).map_err(|error| Error::Setting(error.to_string()))
}

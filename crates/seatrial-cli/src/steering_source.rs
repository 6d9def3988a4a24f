//! Where `turn`, `gains` and `plan` get their models: the command line, an identification, a trial, a logbook, a
//! schedule file.

use std::path::{Path, PathBuf};

use seatrial::GainAllowance;
use seatrial::propagation::{covariance_of_intervals, interval_95};
use seatrial_core::RudderUnit;
use seatrial_core::heading_loop::LoopTiming;
use seatrial_core::schedule::ScheduleKey;
use seatrial_core::{SchedulePoint, SpeedSchedule, YawModel};
use seatrial_logbook::Logbook;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::logbook::chosen_campaign;
use crate::output::Failure;
use crate::table::decimals;

/// The rudder limit where neither the command line nor the source has one: the paper's, rad.
const DEFAULT_RUDDER_LIMIT_RAD: f64 = 0.26;

/// How the schedule file looks, for help texts.
pub const SCHEDULE_FILE_HELP: &str = "\
A schedule file is TOML with one [[point]] for each speed (thrust is a fraction of full; thrust,
surge_speed_m_s and c0_rad_per_s2 may be left out):
  rudder_limit_rad = 0.26
  [[point]]
  thrust = 0.6
  surge_speed_m_s = 1.07
  a22_per_s = -0.95
  b2_per_s2 = 0.60
  c0_rad_per_s2 = 0.0072";

/// The options that give one model or several.
#[derive(clap::Args, Debug)]
pub struct SourceArgs {
    /// a22 of a single model, 1/s, negative for a course-stable vehicle.
    #[arg(
        long,
        value_name = "PER_S",
        requires = "b2",
        conflicts_with_all = ["model", "schedule"],
        allow_negative_numbers = true
    )]
    a22: Option<f64>,
    /// b2 of the single model, 1/s^2.
    #[arg(
        long,
        value_name = "PER_S2",
        requires = "a22",
        allow_negative_numbers = true
    )]
    b2: Option<f64>,
    /// C0 of the single model, rad/s^2; 0 without.
    #[arg(
        long,
        value_name = "RAD_PER_S2",
        requires = "a22",
        allow_negative_numbers = true
    )]
    c0: Option<f64>,
    /// Forward speed of a single model, m/s.
    #[arg(long, value_name = "M_S", conflicts_with = "schedule")]
    speed: Option<f64>,
    /// Document of `seatrial identify --json` or `seatrial trial --json`.
    #[arg(long, value_name = "FILE", conflicts_with = "schedule")]
    model: Option<PathBuf>,
    /// Schedule of models over speed or thrust, TOML.
    #[arg(long, value_name = "FILE")]
    schedule: Option<PathBuf>,
    /// Logbook with a trial: the models of its accepted runs.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["a22", "model", "schedule", "speed"]
    )]
    logbook: Option<PathBuf>,
    /// Number of the campaign in the logbook; the last one where it is left out.
    #[arg(long, value_name = "NUMBER", requires = "logbook")]
    campaign: Option<i64>,
    /// Largest rudder angle, degrees; else the plan's or the source's, else 14.9 (0.26 rad).
    #[arg(long, value_name = "DEG")]
    rudder_limit_deg: Option<f64>,
}

/// Models with their uncertainty, slowest first.
pub struct Source {
    /// For people.
    pub origin: String,
    /// At least one.
    pub points: Vec<SourcePoint>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// In what that and the rudder of the models are.
    pub rudder_unit: RudderUnit,
    /// What the source itself says against its models.
    pub rejected: Vec<String>,
}

/// A model with its uncertainty.
pub struct SourcePoint {
    /// Thrust, speed and model.
    pub point: SchedulePoint<f64>,
    /// Covariance of [a22, b2, C0].
    pub covariance: Option<[[f64; 3]; 3]>,
    /// What a gain for this model allows for.
    pub allowance: GainAllowance,
    /// Heading noise, rad, and yaw acceleration disturbance, rad/s^2, found on its record.
    pub noise: Option<[f64; 2]>,
}

/// A value and, where the source knows its uncertainty, a 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// `[low, high]`
    pub interval_95: Option<[f64; 2]>,
}

impl Estimate {
    /// For a table: the value, then half the width of the interval.
    pub fn text(&self, least_decimals: usize, scale: f64) -> String {
        let value = self.value * scale;
        let digits = decimals(value, least_decimals);
        match self.interval_95 {
            Some([low, high]) => {
                format!(
                    "{value:.digits$} ±{:.digits$}",
                    (high - low) / 2.0 * scale.abs()
                )
            }
            None => format!("{value:.digits$}"),
        }
    }
}

impl SourcePoint {
    /// A quantity of the model with its interval. `None` where the model has no such quantity.
    pub fn estimate(&self, quantity: impl Fn(&YawModel<f64>) -> Option<f64>) -> Option<Estimate> {
        let value = quantity(&self.point.model).filter(|value| value.is_finite())?;
        let interval = |covariance| interval_95(&self.point.model, covariance, &quantity);
        Some(Estimate {
            value,
            interval_95: self.covariance.as_ref().and_then(interval),
        })
    }

    /// `80 %`, `1.63 m/s` or `model` for messages.
    pub fn name(&self) -> String {
        match (self.point.thrust, self.point.surge_speed_m_s) {
            (Some(thrust), _) => format!("{:.0} % thrust", thrust * 100.0),
            (None, Some(speed)) => format!("{speed:.2} m/s"),
            (None, None) => "the model".into(),
        }
    }
}

impl Source {
    /// The models as a schedule by this key.
    pub fn schedule(&self, key: ScheduleKey) -> Result<SpeedSchedule<f64>, Failure> {
        let points: Vec<SchedulePoint<f64>> = self.points.iter().map(|p| p.point).collect();
        SpeedSchedule::new(key, &points)
            .map_err(|error| Failure::input(format!("{}: {error}", self.origin)))
    }

    /// Prints on standard error what the source says against its models.
    pub fn warn(&self) {
        for reason in &self.rejected {
            eprintln!("seatrial: warning: {}: {reason}", self.origin);
        }
    }
}

/// A schedule file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScheduleFile {
    rudder_limit_rad: Option<f64>,
    #[serde(default)]
    rudder_unit: RudderUnit,
    point: Vec<ScheduleFilePoint>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScheduleFilePoint {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    a22_per_s: f64,
    b2_per_s2: f64,
    #[serde(default)]
    c0_rad_per_s2: f64,
}

impl SourceArgs {
    /// Is any model given?
    pub fn is_given(&self) -> bool {
        self.a22.is_some()
            || [&self.model, &self.schedule, &self.logbook]
                .into_iter()
                .any(Option::is_some)
    }

    /// The rudder limit of the command line, rad.
    pub fn rudder_limit_rad(&self) -> Option<f64> {
        self.rudder_limit_deg.map(f64::to_radians)
    }

    /// Reads the models.
    pub fn read(&self) -> Result<Source, Failure> {
        let mut source = match (&self.model, &self.schedule, &self.logbook) {
            (Some(path), ..) => from_document(path, self.speed)?,
            (None, Some(path), _) => from_schedule(path)?,
            (None, None, Some(path)) => from_logbook(path, self.campaign)?,
            (None, None, None) => self.single_model()?,
        };
        if let Some(limit_rad) = self.rudder_limit_rad() {
            source.rudder_limit_rad = limit_rad;
        }
        if !(source.rudder_limit_rad > 0.0 && source.rudder_limit_rad.is_finite()) {
            return Err(Failure::usage(format!(
                "rudder limit {} rad: expected a positive angle",
                source.rudder_limit_rad
            )));
        }
        for point in &source.points {
            let SchedulePoint {
                thrust,
                surge_speed_m_s,
                model,
            } = point.point;
            let keys = [thrust, surge_speed_m_s];
            if !model.theta().iter().all(|p| p.is_finite())
                || !keys.iter().flatten().all(|k| k.is_finite() && *k > 0.0)
            {
                return Err(Failure::input(format!(
                    "{}: {}: a22, b2 and C0 must be finite, speed and thrust positive",
                    source.origin,
                    point.name()
                )));
            }
        }
        let key = |p: &SourcePoint| p.point.thrust.or(p.point.surge_speed_m_s).unwrap_or(0.0);
        source.points.sort_by(|a, b| key(a).total_cmp(&key(b)));
        Ok(source)
    }

    fn single_model(&self) -> Result<Source, Failure> {
        let (Some(a22), Some(b2)) = (self.a22, self.b2) else {
            return Err(Failure::usage(
                "no model: give --a22 and --b2, --model FILE, --schedule FILE or --logbook FILE",
            ));
        };
        Ok(Source {
            origin: "the model given".into(),
            points: vec![SourcePoint {
                point: SchedulePoint {
                    thrust: None,
                    surge_speed_m_s: self.speed,
                    model: YawModel::from_theta([a22, b2, self.c0.unwrap_or(0.0)]),
                },
                covariance: None,
                allowance: GainAllowance::default(),
                noise: None,
            }],
            rudder_limit_rad: DEFAULT_RUDDER_LIMIT_RAD,
            rudder_unit: RudderUnit::Rad,
            rejected: Vec::new(),
        })
    }
}

fn read_text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))
}

/// The models of a schedule file.
pub fn from_schedule(path: &Path) -> Result<Source, Failure> {
    let file: ScheduleFile = toml::from_str(&read_text(path)?).map_err(|error| {
        Failure::input(format!("{}: {error}\n{SCHEDULE_FILE_HELP}", path.display()))
    })?;
    if file.point.is_empty() {
        return Err(Failure::input(format!(
            "{}: no [[point]]\n{SCHEDULE_FILE_HELP}",
            path.display()
        )));
    }
    let point = |p: ScheduleFilePoint| SourcePoint {
        point: SchedulePoint {
            thrust: p.thrust,
            surge_speed_m_s: p.surge_speed_m_s,
            model: YawModel::from_theta([p.a22_per_s, p.b2_per_s2, p.c0_rad_per_s2]),
        },
        covariance: None,
        allowance: GainAllowance::default(),
        noise: None,
    };
    Ok(Source {
        origin: path.display().to_string(),
        points: file.point.into_iter().map(point).collect(),
        rudder_limit_rad: limit_or_default(file.rudder_limit_rad, file.rudder_unit),
        rudder_unit: file.rudder_unit,
        rejected: Vec::new(),
    })
}

/// Where the rudder is a fraction of full, so is its limit.
fn limit_or_default(limit: Option<f64>, unit: RudderUnit) -> f64 {
    limit.unwrap_or(match unit {
        RudderUnit::Rad => DEFAULT_RUDDER_LIMIT_RAD,
        RudderUnit::FullRudder => 1.0,
    })
}

/// The models of the accepted runs of a campaign.
fn from_logbook(path: &Path, number: Option<i64>) -> Result<Source, Failure> {
    let logbook = Logbook::open_read_only(path)?;
    let entry = chosen_campaign(&logbook, number)?;
    let origin = format!("{}, campaign {}", path.display(), entry.id.0);
    let campaign = logbook.campaign(entry.id)?;
    let points: Vec<SourcePoint> = campaign
        .accepted_runs()
        .into_iter()
        .filter_map(|run| {
            let identification = run.identification.as_ref()?;
            let refined = identification.refined.as_ref();
            Some(SourcePoint {
                point: SchedulePoint {
                    thrust: Some(run.thrust),
                    surge_speed_m_s: run.surge_speed_m_s,
                    model: identification.model(),
                },
                covariance: refined.map(|refined| refined.covariance),
                allowance: GainAllowance::of(identification),
                noise: refined.map(|r| [r.heading_noise_rad, r.disturbance_rad_s2]),
            })
        })
        .collect();
    if points.is_empty() {
        return Err(Failure::input(format!(
            "{origin}: no accepted run in this trial"
        )));
    }
    Ok(Source {
        origin,
        points,
        rudder_limit_rad: campaign.rudder_limit_rad,
        rudder_unit: RudderUnit::Rad,
        rejected: Vec::new(),
    })
}

/// The models of an identification or of the accepted runs of a trial.
pub fn from_document(path: &Path, speed: Option<f64>) -> Result<Source, Failure> {
    let origin = path.display().to_string();
    let expected = "expected a document of `seatrial identify --json` or `seatrial trial --json`";
    let document: Value = serde_json::from_str(&read_text(path)?)
        .map_err(|error| Failure::input(format!("{origin}: {error}; {expected}")))?;
    let campaign = document.get("campaign").unwrap_or(&document);
    let rudder_unit = document.pointer("/source/rudder_unit");
    let rudder_unit = rudder_unit
        .and_then(|unit| RudderUnit::deserialize(unit).ok())
        .unwrap_or_default();
    let limit = campaign.get("rudder_limit_rad").and_then(Value::as_f64);
    let mut source = Source {
        origin,
        points: Vec::new(),
        rudder_limit_rad: limit_or_default(limit, rudder_unit),
        rudder_unit,
        rejected: Vec::new(),
    };
    let runs = campaign.get("runs").or_else(|| campaign.get("models"));
    if let Some(runs) = runs.and_then(Value::as_array) {
        let number = |run: &Value, field| run.get(field).and_then(Value::as_f64);
        // The last accepted run of a thrust counts.
        for (index, run) in runs.iter().enumerate().filter(|(_, run)| accepted(run)) {
            let thrust = number(run, "thrust");
            let identification = run.get("identification").unwrap_or(run);
            let (model, covariance) = model_of(identification).map_err(|why| {
                Failure::input(format!("{}: run {}: {why}", source.origin, index + 1))
            })?;
            source
                .points
                .retain(|p| thrust.is_none() || p.point.thrust != thrust);
            source.points.push(SourcePoint {
                point: SchedulePoint {
                    thrust,
                    surge_speed_m_s: number(run, "surge_speed_m_s"),
                    model,
                },
                covariance,
                allowance: allowance_of(identification, &model),
                noise: noise_of(identification),
            });
        }
        for (index, run) in runs.iter().enumerate().filter(|(_, run)| !accepted(run)) {
            let thrust = number(run, "thrust");
            if source.points.iter().all(|p| p.point.thrust != thrust) {
                source.rejected.push(format!(
                    "run {} is not accepted, and no other was made at its thrust",
                    index + 1
                ));
            }
        }
        if source.points.is_empty() {
            return Err(Failure::input(format!(
                "{}: no accepted run in this trial",
                source.origin
            )));
        }
    } else {
        let identification = document.get("identification").unwrap_or(&document);
        if !accepted(identification) {
            let reason = "the verdict on this model is not `accepted`: see the reasons there";
            source.rejected.push(reason.into());
        }
        let (model, covariance) = model_of(identification)
            .map_err(|why| Failure::input(format!("{}: {why}; {expected}", source.origin)))?;
        source.points.push(SourcePoint {
            point: SchedulePoint {
                thrust: None,
                surge_speed_m_s: speed,
                model,
            },
            covariance,
            allowance: allowance_of(identification, &model),
            noise: noise_of(identification),
        });
    }
    // The models are behind a servo that was given.
    let servo = |time| document["source"]["servo"][time].as_f64();
    for time in ["delay_s", "lag_s"] {
        for point in &mut source.points {
            point.allowance.timing.delay_s += servo(time).unwrap_or(0.0);
        }
    }
    Ok(source)
}

fn allowance_of(identification: &Value, model: &YawModel<f64>) -> GainAllowance {
    let interval = identification.pointer("/refined/interval_95/a22_per_s");
    let interval = interval.and_then(|interval| <[f64; 2]>::deserialize(interval).ok());
    let timing = identification.get("loop_timing");
    GainAllowance {
        damping_per_s: interval.map_or(0.0, |interval| {
            GainAllowance::damping_per_s(model.a22_per_s, interval)
        }),
        timing: timing
            .and_then(|timing| LoopTiming::deserialize(timing).ok())
            .unwrap_or_default(),
    }
}

fn noise_of(identification: &Value) -> Option<[f64; 2]> {
    let refined = identification.get("refined")?;
    let number = |field: &str| refined.get(field)?.as_f64();
    Some([number("heading_noise_rad")?, number("disturbance_rad_s2")?])
}

/// Not rejected by a verdict.
fn accepted(value: &Value) -> bool {
    value
        .pointer("/verdict/accepted")
        .and_then(Value::as_bool)
        .unwrap_or(true)
}

type ModelAndCovariance = (YawModel<f64>, Option<[[f64; 3]; 3]>);

/// The refined estimate where there is one, else the online one, whose P is no covariance.
fn model_of(identification: &Value) -> Result<ModelAndCovariance, String> {
    let refined = identification.get("refined").filter(|v| v.is_object());
    let online = identification.get("online").filter(|v| v.is_object());
    let estimate = refined
        .or(online)
        .ok_or("neither `refined` nor `online` is there")?;
    let number = |field: &str| {
        estimate
            .get(field)
            .and_then(Value::as_f64)
            .ok_or_else(|| format!("`{field}` is missing or not a number"))
    };
    let model = YawModel::from_theta([
        number("a22_per_s")?,
        number("b2_per_s2")?,
        number("c0_rad_per_s2")?,
    ]);
    let of = |value: &Value| <[[f64; 3]; 3]>::deserialize(value).ok();
    let covariance = refined.and_then(|refined| {
        let given = refined.get("covariance").and_then(of);
        given.or_else(|| {
            let interval =
                |name: &str| <[f64; 2]>::deserialize(refined.get("interval_95")?.get(name)?).ok();
            Some(covariance_of_intervals([
                interval("a22_per_s")?,
                interval("b2_per_s2")?,
                interval("c0_rad_per_s2")?,
            ]))
        })
    });
    Ok((model, covariance))
}

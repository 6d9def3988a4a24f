//! The plan of a trial with what its conductor adds, and its TOML files.

use std::ops::Deref;
use std::path::Path;

use seatrial::log::{InvalidServo, Servo};
use seatrial::preview::Target;
use seatrial_core::{Axis, InvalidSetting, Plan, Trial};
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, Deserializer};

use crate::Error;

/// What a trial does. In files and documents the fields of the plan stand beside those of the conductor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialPlan {
    /// Dead time of the rudder behind the command that the vehicle reports, s. The trial takes the rudder as it is
    /// reported; its runs are identified from the one behind the servo.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rudder_delay_s: f64,
    /// Time constant with which the rudder follows the command that the vehicle reports, s; 0 where it reports the rudder
    /// itself.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rudder_lag_s: f64,
    /// Time constant with which the yaw rate of the vehicle follows its rudder, s, where the plan was made for it: a rehearsal without
    /// a vehicle plays one like it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_s: Option<f64>,
    /// The plan that the vehicle follows.
    #[serde(flatten)]
    pub plan: Plan<f64>,
    /// End training as soon as the intervals are this narrow, once the manoeuvre is over: the trial itself knows no
    /// interval, its conductor looks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_when: Option<Target>,
}

/// What stands in a file beside the fields of [`Plan`].
const CONDUCTORS_FIELDS: [&str; 4] =
    ["rudder_delay_s", "rudder_lag_s", "time_constant_s", "stop_when"];

/// The record of a run is kept in memory, some 200 bytes a sample.
const MOST_SAMPLES_OF_A_RUN: f64 = 5e6;

fn is_zero(time_s: &f64) -> bool {
    *time_s == 0.0
}

impl TrialPlan {
    /// The plan, where every setting is in its range; else the first that is not.
    ///
    /// ```
    /// use seatrial_app::TrialPlan;
    ///
    /// let plan = TrialPlan { rudder_lag_s: 200.0, ..TrialPlan::default() };
    /// assert_eq!(plan.checked().map_err(|error| error.field).err(), Some("rudder_lag_s"));
    /// ```
    pub fn checked(self) -> Result<CheckedPlan, InvalidSetting> {
        if self.stop_when.is_some_and(|target| !target.is_valid()) {
            return Err(InvalidSetting {
                field: "stop_when",
                requirement: "a22, b2 or both, each a fraction above 0 and below 1",
            });
        }
        if self.stop_when.is_some() && self.axis == Axis::Pitch {
            return Err(InvalidSetting {
                field: "stop_when",
                requirement: "left out on the axis of pitch, whose intervals are known after the run",
            });
        }
        let trial = Trial::new(self.plan)?;
        let run_s =
            self.settle.at_most_s + self.training.duration_s() + self.validation.duration_s();
        if run_s / self.sample_interval_s > MOST_SAMPLES_OF_A_RUN {
            return Err(InvalidSetting {
                field: "sample_interval_s",
                requirement: "so long that a run has at most 5000000 samples; make its stages shorter or this longer",
            });
        }
        Servo::new(self.rudder_delay_s, self.rudder_lag_s).map_err(
            |InvalidServo { name, .. }| InvalidSetting {
                field: if name == "lag" { "rudder_lag_s" } else { "rudder_delay_s" },
                requirement: "a time from 0 to 100 s",
            },
        )?;
        Ok(CheckedPlan { settings: self, trial })
    }

    /// The plan with another servo behind the command that the vehicle reports; what is not given stays.
    ///
    /// # Errors
    /// Times below 0 or above 100 s.
    pub fn behind_servo(self, delay_s: Option<f64>, lag_s: Option<f64>) -> Result<Self, Error> {
        let rudder_delay_s = delay_s.unwrap_or(self.rudder_delay_s);
        let rudder_lag_s = lag_s.unwrap_or(self.rudder_lag_s);
        Servo::new(rudder_delay_s, rudder_lag_s)
            .map_err(|invalid| Error::Setting(format!("--rudder-{invalid}")))?;
        Ok(Self { rudder_delay_s, rudder_lag_s, ..self })
    }

    /// The servo behind the command that the vehicle reports, where the rudder is late.
    pub(crate) fn servo(&self) -> Option<Servo> {
        let servo = Servo::new(self.rudder_delay_s, self.rudder_lag_s).ok()?;
        (servo.late_s() > 0.0).then_some(servo)
    }

    /// The plan of a TOML text. An error names its line.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        let with_line = |mut error: toml::de::Error| {
            error.set_input(Some(text));
            error
        };
        let mut table = DeTable::parse(text)?;
        let mut of_conductor = Spanned::new(table.span(), DeTable::new());
        for field in CONDUCTORS_FIELDS {
            let entry = table.get_mut().remove_entry(field);
            of_conductor.get_mut().extend(entry);
        }
        // Flattened, a plan's error has no line: the plan is read by itself.
        let plan = Plan::deserialize(Deserializer::from(table)).map_err(with_line)?;
        let conducted = Self::deserialize(Deserializer::from(of_conductor)).map_err(with_line)?;
        Ok(Self { plan, ..conducted })
    }

    /// The paper's plan in the time of a vehicle whose yaw rate follows the rudder with this time constant, s.
    pub fn for_time_constant(time_constant_s: f64, sample_interval_s: f64) -> Self {
        Self {
            time_constant_s: Some(time_constant_s),
            ..Plan::for_time_constant(time_constant_s, sample_interval_s).into()
        }
    }
}

impl From<Plan<f64>> for TrialPlan {
    fn from(plan: Plan<f64>) -> Self {
        Self { plan, ..Self::default() }
    }
}

impl Deref for TrialPlan {
    type Target = Plan<f64>;

    fn deref(&self) -> &Plan<f64> {
        &self.plan
    }
}

/// A plan that was checked when it was made, by [`TrialPlan::checked`]. A change of it is another plan, to be checked in its turn.
#[derive(Clone, Copy, Debug)]
pub struct CheckedPlan {
    settings: TrialPlan,
    trial: Trial<f64>,
}

impl CheckedPlan {
    /// The trial that follows it, before its first sample.
    pub(crate) fn trial(&self) -> Trial<f64> {
        self.trial
    }
}

impl Deref for CheckedPlan {
    type Target = TrialPlan;

    fn deref(&self) -> &TrialPlan {
        &self.settings
    }
}

/// The plan of a file, or the axis' own where there is no file: the paper's for yaw, [`Plan::pitch`] for pitch. What a file
/// leaves out is that of the same plan. A file that names another axis than `axis` is refused.
pub fn load_plan(path: Option<&Path>, axis: Option<Axis>) -> Result<CheckedPlan, Error> {
    let Some(path) = path else {
        let plan = TrialPlan::from(own_plan(axis.unwrap_or_default()));
        return plan.checked().map_err(|error| Error::Setting(error.to_string()));
    };
    let failure = |problem: String| Error::Input(format!("{}: {problem}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| failure(error.to_string()))?;
    let named = axis_of(&text);
    if let (Some(named), Some(axis)) = (named, axis)
        && named != axis
    {
        let [named, wanted] = [named, axis].map(Axis::angle);
        return Err(failure(format!(
            "a plan for {named}, not for {wanted}; leave --axis out, or take another plan"
        )));
    }
    let plan = read(&text, named.or(axis).unwrap_or_default())
        .map_err(|error| failure(format!("not a plan: {error}")))?;
    plan.checked().map_err(|error| failure(error.to_string()))
}

fn own_plan(axis: Axis) -> Plan<f64> {
    match axis {
        Axis::Yaw => Plan::paper(),
        Axis::Pitch => Plan::pitch(),
    }
}

/// The axis that a plan names, if it names one that there is.
fn axis_of(text: &str) -> Option<Axis> {
    #[derive(Deserialize)]
    struct AxisField {
        axis: Option<Axis>,
    }
    toml::from_str::<AxisField>(text).ok()?.axis
}

fn read(text: &str, axis: Axis) -> Result<TrialPlan, toml::de::Error> {
    if axis == Axis::Yaw {
        return TrialPlan::parse(text);
    }
    let mut plan = toml::Table::try_from(own_plan(axis)).unwrap_or_default();
    replace(&mut plan, toml::from_str(text)?);
    plan.try_into()
}

/// Fields of `given` go before those of `base`, table by table.
fn replace(base: &mut toml::Table, given: toml::Table) {
    for (name, value) in given {
        match (base.get_mut(&name), value) {
            // A manoeuvre of another kind has other fields.
            (Some(toml::Value::Table(base)), toml::Value::Table(given)) if name != "excitation" => {
                replace(base, given);
            }
            (_, value) => {
                base.insert(name, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_what_a_plan_of_pitch_leaves_out_is_that_of_the_plan_for_pitch() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        let load = |text: &str, axis| {
            std::fs::write(&path, text).unwrap();
            load_plan(Some(&path), axis)
        };
        let plan =
            load("thrusts = [0.8]\n[envelope]\nroll_max_rad = 0.3\n", Some(Axis::Pitch)).unwrap();
        let mut expected = Plan::pitch();
        expected.thrusts = seatrial_core::List::from_slice(&[0.8]).unwrap();
        expected.envelope.roll_max_rad = 0.3;
        assert_eq!(plan.plan, expected);
        assert_eq!(load("axis = \"pitch\"\n", None).unwrap().plan, Plan::pitch());
        assert_eq!(load("", None).unwrap().plan, Plan::paper());
        for (text, axis, said) in [
            ("axis = \"pitch\"\n", Some(Axis::Yaw), "a plan for pitch, not for heading"),
            ("thrusts = []\n", Some(Axis::Pitch), "thrusts must be"),
            ("amplitude = 1\n", Some(Axis::Pitch), "unknown field `amplitude`"),
            ("axis = \"roll\"\n", None, "unknown variant `roll`"),
        ] {
            let refused = load(text, axis).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }

    #[test]
    fn io_what_the_conductor_adds_stands_beside_the_plan() {
        let plan = TrialPlan {
            stop_when: Some(Target { a22: Some(0.1), b2: None }),
            rudder_lag_s: 0.2,
            ..Plan::paper().into()
        };
        let text = toml::to_string_pretty(&plan).unwrap();
        assert_eq!(TrialPlan::parse(&text).unwrap(), plan);
        let json = serde_json::to_value(plan).unwrap();
        assert_eq!((&json["stop_when"]["a22"], &json["max_repeats"]), (&0.1.into(), &2.into()));
        assert_eq!(serde_json::from_value::<TrialPlan>(json).unwrap(), plan);
        for (text, said) in [
            ("stop_when = { a22 = 0.1 }\nsail = 1\n", "unknown field `sail`"),
            ("stop_when = { a22 = 0.1 }\nsail = 1\n", "line 2"),
            ("stop_when = { a22 = \"x\" }\n", "invalid type"),
            ("thrusts = [0.6]\nstop_when = { a22 = \"x\" }\n", "line 2"),
            ("thrusts = [0.6]\nsail = 1\n", "line 2"),
        ] {
            let refused = TrialPlan::parse(text).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
        let wide = TrialPlan::parse("stop_when = { a22 = 2.0 }").unwrap();
        assert_eq!(wide.checked().unwrap_err().field, "stop_when");
    }
}

//! Scenario files: which faults, and when.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use super::built_in;
use super::invalid::{InvalidFault, InvalidRandom};
use super::kind::{Kind, Values};
use super::stages::Moment;
use crate::range::not_negative;
use crate::sensors::Chance;

/// The faults of a rehearsal.
///
/// ```
/// let text = r#"
/// [[fault]]
/// kind = "compass_freeze"      # every kind and its numbers: seatrial_sim::faults::Kind
/// at_s = 31.5                  # on the vehicle's clock
/// for_s = 3.0                  # absent: to the end
///
/// [[fault]]
/// kind = "rudder_offset"
/// angle_rad = 0.05
/// stage = "training"           # settle, training, decay, validation or between
/// run = 2                      # the second time that the stage begins; absent: the first
/// after_s = 1.0                # into the stage; absent: at its start
///
/// [random]                     # and more, by the vehicle's seed
/// count = 2
/// kinds = ["compass_spike", "clock_jump"]   # absent: any that the vehicle can play
/// from_s = 20.0
/// to_s = 120.0
///
/// [sensors.compass]            # conditions: sensors, timing, disturbance, servo and sea as in a vehicle's file
/// latency_s = 0.1
/// "#;
/// let scenario = seatrial_sim::Scenario::from_toml(text)?;
/// assert_eq!(scenario.faults.len(), 2);
/// # Ok::<(), seatrial_sim::ScenarioError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenario {
    /// Faults with a time.
    pub faults: Vec<Fault>,
    /// Faults that chance chooses.
    pub random: Option<Random>,
    /// What the vehicle meets: tables of its own file that take the place of its numbers.
    pub conditions: toml::Table,
}

/// A fault and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What happens.
    pub kind: Kind,
    /// Its numbers, in the order of [`Kind::parameters`].
    pub values: [f64; 2],
    /// When it begins.
    pub onset: Onset,
    /// How long it lasts, s; for ever where absent.
    pub for_s: Option<f64>,
}

/// When a fault begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onset {
    /// At this time of the vehicle, s.
    Time(f64),
    /// In a stage.
    Stage {
        /// The stage.
        stage: Moment,
        /// The time that it begins, 1 for the first.
        run: u32,
        /// Time from the start of the stage, s.
        after_s: f64,
    },
}

/// Faults that chance chooses, each with numbers and length of its own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Random {
    /// How many.
    pub count: u32,
    /// The kinds of faults to draw from; where absent, all that the vehicle can play.
    pub kinds: Option<Vec<Kind>>,
    /// Not before, s.
    #[serde(default)]
    pub from_s: f64,
    /// Before, s.
    pub to_s: f64,
}

/// A scenario that cannot be played.
#[derive(Debug, Error)]
pub enum ScenarioError {
    /// The file cannot be read, and none of this name comes with the program.
    #[error("{}: {source}; scenarios that need no file are {}", path.display(), built_in::names())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The text is not a scenario.
    #[error("not a scenario: {0}")]
    Syntax(#[from] toml::de::Error),
    /// A fault is not as it has to be.
    #[error("fault {number}, {kind}: {problem}")]
    Fault {
        /// 1 for the first fault.
        number: usize,
        /// Its kind as the file has it.
        kind: String,
        /// What is wrong with it.
        problem: InvalidFault,
    },
    /// The random faults are not as they have to be.
    #[error("random.{0}")]
    Random(InvalidRandom),
    /// Any of these in a file.
    #[error("{}: {source}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<ScenarioError>,
    },
}

/// A scenario as its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    fault: Vec<Entry>,
    random: Option<Random>,
    sensors: Option<toml::Table>,
    timing: Option<toml::Table>,
    disturbance: Option<toml::Table>,
    servo: Option<toml::Table>,
    sea: Option<toml::Table>,
}

#[derive(Deserialize)]
struct Entry {
    kind: String,
    at_s: Option<f64>,
    stage: Option<Moment>,
    run: Option<u32>,
    after_s: Option<f64>,
    for_s: Option<f64>,
    #[serde(flatten)]
    parameters: BTreeMap<String, toml::Value>,
}

impl Scenario {
    /// One fault.
    pub fn of(fault: Fault) -> Self {
        Self { faults: vec![fault], ..Self::default() }
    }

    /// The scenario of a TOML text.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        let file: File = toml::from_str(text)?;
        let faults = file
            .fault
            .into_iter()
            .enumerate()
            .map(|(k, entry)| {
                let kind = entry.kind.clone();
                entry.fault().map_err(|problem| ScenarioError::Fault {
                    number: k + 1,
                    kind,
                    problem,
                })
            })
            .collect::<Result<_, _>>()?;
        if let Some(random) = &file.random {
            random.check().map_err(ScenarioError::Random)?;
        }
        let conditions = [
            ("sensors", file.sensors),
            ("timing", file.timing),
            ("disturbance", file.disturbance),
            ("servo", file.servo),
            ("sea", file.sea),
        ];
        Ok(Self {
            faults,
            random: file.random,
            conditions: conditions
                .into_iter()
                .filter_map(|(name, table)| Some((name.to_owned(), table?.into())))
                .collect(),
        })
    }

    /// Names of the scenarios that come with the program, each with a sentence about it.
    pub fn built_in() -> Vec<(&'static str, &'static str)> {
        built_in::all()
    }

    /// The scenario of a TOML file, or one that comes with the program by its name: `bad_compass`.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(source) => built_in::text_of(&path.to_string_lossy())
                .map(str::to_owned)
                .ok_or_else(|| ScenarioError::Read { path: path.to_owned(), source })?,
        };
        Self::from_toml(&text).map_err(|error| ScenarioError::InFile {
            path: path.to_owned(),
            source: Box::new(error),
        })
    }
}

impl Entry {
    fn fault(self) -> Result<Fault, InvalidFault> {
        let kind = Kind::of_name(&self.kind).ok_or(InvalidFault::UnknownKind)?;
        let mut given = Vec::new();
        for (name, value) in &self.parameters {
            let number = match value {
                toml::Value::Float(number) => *number,
                toml::Value::Integer(number) => *number as f64,
                other => {
                    return Err(InvalidFault::NotANumber {
                        name: name.clone(),
                        found: other.to_string(),
                    });
                }
            };
            given.push((name.as_str(), number));
        }
        let fault =
            Fault { kind, values: values(kind, given)?, onset: self.onset()?, for_s: self.for_s };
        let times = [("at_s", self.at_s), ("after_s", self.after_s), ("for_s", self.for_s)];
        match times.iter().find(|(_, time)| time.is_some_and(|time| !not_negative(time))) {
            Some((name, _)) => Err(InvalidFault::Time { name }),
            None => Ok(fault),
        }
    }

    fn onset(&self) -> Result<Onset, InvalidFault> {
        match (self.at_s, self.stage) {
            (Some(time_s), None) if self.run.is_none() && self.after_s.is_none() => {
                Ok(Onset::Time(time_s))
            }
            (None, Some(stage)) if self.run != Some(0) => Ok(Onset::Stage {
                stage,
                run: self.run.unwrap_or(1),
                after_s: self.after_s.unwrap_or(0.0),
            }),
            (None, Some(_)) => Err(InvalidFault::RunZero),
            _ => Err(InvalidFault::Onset),
        }
    }
}

/// The numbers of a kind: those given by name, or the defaults.
fn values<'a>(
    kind: Kind,
    given: impl IntoIterator<Item = (&'a str, f64)>,
) -> Result<Values, InvalidFault> {
    let parameters = kind.parameters();
    let mut values = Values::default();
    for (value, parameter) in values.iter_mut().zip(parameters) {
        *value = parameter.default;
    }
    for (name, number) in given {
        let found = parameters.iter().position(|p| p.name == name);
        let Some((k, parameter)) = found.map(|k| (k, &parameters[k])) else {
            return Err(InvalidFault::UnknownParameter { kind, name: name.to_owned() });
        };
        let [least, greatest] = parameter.range;
        if !(least..=greatest).contains(&number) {
            return Err(InvalidFault::OutOfRange {
                name: name.to_owned(),
                least,
                greatest,
                found: number,
            });
        }
        values[k] = number;
    }
    Ok(values)
}

impl Random {
    fn check(&self) -> Result<(), InvalidRandom> {
        if !(self.from_s >= 0.0 && self.to_s > self.from_s && not_negative(self.to_s)) {
            return Err(InvalidRandom::Interval);
        }
        match &self.kinds {
            _ if self.count > MOST_RANDOM => Err(InvalidRandom::Count { most: MOST_RANDOM }),
            Some(kinds) if kinds.is_empty() => Err(InvalidRandom::NoKinds),
            _ => Ok(()),
        }
    }

    /// The faults of a seed, chosen from the kinds that can be played.
    pub(super) fn faults(&self, playable: &[Kind], seed: u64) -> Vec<Fault> {
        let [mut chance] = Chance::sources(seed ^ OF_FAULTS);
        let kinds = self.kinds.as_deref().unwrap_or(playable);
        (0..self.count)
            .map(|_| {
                let kind = kinds[(chance.uniform() * kinds.len() as f64) as usize];
                let time_s = self.from_s + (self.to_s - self.from_s) * chance.uniform();
                Fault::drawn(kind, Onset::Time(time_s), &mut chance)
            })
            .collect()
    }
}

/// More faults by chance than a trial has samples make no rehearsal.
const MOST_RANDOM: u32 = 10_000;

/// Keeps the faults of a seed apart from its noise.
const OF_FAULTS: u64 = 0x000f_a017;

/// Longest of the faults by chance that pass, s.
const PASSES_WITHIN_S: f64 = 5.0;

impl Fault {
    /// A fault of usual size by chance; half of them pass.
    pub fn drawn(kind: Kind, onset: Onset, chance: &mut Chance) -> Self {
        let mut values = Values::default();
        for (value, parameter) in values.iter_mut().zip(kind.parameters()) {
            let [from, to] = parameter.usual;
            *value = from + (to - from) * chance.uniform();
        }
        let passes = chance.uniform() < 0.5;
        let length_s = PASSES_WITHIN_S * chance.uniform();
        Self { kind, values, onset, for_s: passes.then_some(length_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_faults_of_a_file_are_named() {
        let fault = |lines: &str| format!("[[fault]]\nkind = \"compass_step\"\n{lines}");
        for (text, expected) in [
            (fault(""), "fault 1, compass_step: expected either at_s, or stage"),
            (fault("at_s = 1.0\nstage = \"decay\""), "expected either at_s"),
            (fault("at_s = -1.0"), "at_s must be a number from 0 to 1e9"),
            (fault("at_s = 1.0\nsise_rad = 1.0"), "compass_step takes no sise_rad, but size_rad"),
            (fault("at_s = 1.0\nsize_rad = 9.0"), "size_rad must be a number from"),
            (fault("at_s = 1.0\nsize_rad = \"big\""), "size_rad must be a number, not"),
            (fault("stage = \"tea\""), "unknown variant `tea`"),
            (fault("stage = \"decay\"\nrun = 0"), "run counts from 1"),
            ("[[fault]]\nkind = \"gremlin\"\nat_s = 1.0".into(), "fault 1, gremlin: no such kind"),
            ("[random]\ncount = 1\nto_s = 0.0".into(), "random.to_s must be a number above"),
            ("[[fualt]]".into(), "unknown field `fualt`"),
        ] {
            let message = Scenario::from_toml(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn exact_defaults_and_names() {
        let text = "[[fault]]\nkind = \"compass_spike\"\nstage = \"decay\"\nevery_s = 3";
        let scenario = Scenario::from_toml(text).unwrap();
        let expected = Fault {
            kind: Kind::CompassSpike,
            values: [1.0, 3.0],
            onset: Onset::Stage { stage: Moment::Decay, run: 1, after_s: 0.0 },
            for_s: None,
        };
        assert_eq!(scenario, Scenario::of(expected));
        for kind in Kind::ALL {
            let name = format!("\"{}\"", kind.name());
            assert_eq!(toml::Value::try_from(kind).unwrap().to_string(), name);
        }
    }

    #[test]
    fn prop_chance_draws_what_can_be_played() {
        let random = Random { count: 200, kinds: None, from_s: 5.0, to_s: 6.0 };
        let drawn = random.faults(&Kind::ALL, 3);
        assert_eq!(drawn, random.faults(&Kind::ALL, 3));
        assert_ne!(drawn, random.faults(&Kind::ALL, 4));
        for fault in drawn {
            let parameters = fault.kind.parameters();
            for (value, parameter) in fault.values.iter().zip(parameters) {
                let [least, greatest] = parameter.range;
                assert!((least..=greatest).contains(value), "{fault:?}");
            }
            assert!(matches!(fault.onset, Onset::Time(t) if (5.0..6.0).contains(&t)));
        }
    }
}

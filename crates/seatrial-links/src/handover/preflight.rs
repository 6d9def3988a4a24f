//! What a look at a vehicle has found.

use serde::Serialize;

/// One thing that must be so.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// In a word or two.
    pub name: &'static str,
    /// Is it so?
    pub passed: bool,
    /// What was found, and where it is not so what to do.
    pub text: String,
}

/// A parameter that is changed for the trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The parameter.
    pub name: String,
    /// What it is.
    pub from: f64,
    /// What it will be until the hand-back.
    pub to: f64,
    /// Why the parameter is changed.
    pub why: &'static str,
}

/// What a look at the vehicle has found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Preflight {
    /// What it is.
    pub vehicle: String,
    /// What must be so.
    pub checks: Vec<Check>,
    /// Parameters that a trial changes and puts back.
    pub changes: Vec<Change>,
}

impl Preflight {
    /// The preflight of a vehicle that has not been heard yet.
    pub(crate) fn begin() -> Self {
        Self {
            vehicle: "no vehicle".into(),
            ..Self::default()
        }
    }

    /// Is everything as it must be?
    pub fn is_passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
    }

    pub(crate) fn check(&mut self, name: &'static str, passed: bool, text: impl Into<String>) {
        let text = text.into();
        self.checks.push(Check { name, passed, text });
    }
}

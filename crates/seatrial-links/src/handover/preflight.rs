//! What a look at a vehicle has found.

use serde::{Deserialize, Serialize};

/// One look before a trial.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Check {
    /// Short and stable.
    pub name: String,
    /// Does it allow a trial?
    pub passed: bool,
    /// What was found; where it does not pass, also what to do.
    pub text: String,
}

/// A parameter of the autopilot that is other during the trial.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Change {
    /// The parameter.
    pub name: String,
    /// Its value now.
    pub from: f64,
    /// Its value during the trial.
    pub to: f64,
    /// Why.
    pub why: String,
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
        Self { vehicle: "no vehicle".into(), ..Self::default() }
    }

    /// Is everything as it must be?
    pub fn is_passed(&self) -> bool {
        self.checks.iter().all(|check| check.passed)
    }

    /// Adds a check by its name.
    pub fn check(&mut self, name: &str, passed: bool, text: impl Into<String>) {
        self.checks.push(Check { name: name.into(), passed, text: text.into() });
    }
}

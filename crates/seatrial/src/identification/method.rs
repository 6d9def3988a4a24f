//! Names of the methods by which an estimate was made.

use std::fmt;

use seatrial_core::estimator::Method;
use serde::{Deserialize, Serialize};

/// By which method an estimate was made. In documents its name is in snake case: `least_squares`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EstimateMethod {
    /// Recursive least squares.
    LeastSquares,
    /// The recursive instrumental variable.
    InstrumentalVariable,
    /// The restricted likelihood, averaged over the disturbance.
    AveragedRestrictedLikelihood,
    /// A first-order model behind a rudder lag.
    RudderLag,
    /// The model whose simulation is nearest to the heading.
    OutputError,
    /// Hypotheses of several structures, weighed by prediction of data left out.
    WeighedHypotheses,
    /// Prediction errors of heading and gyro of ordinary steering.
    PredictionError,
    /// A method that this version does not know, from a document that another version wrote.
    #[serde(untagged)]
    Other(String),
}

impl EstimateMethod {
    /// In words: `least squares`.
    ///
    /// ```
    /// use seatrial::identification::EstimateMethod;
    ///
    /// assert_eq!(EstimateMethod::LeastSquares.words(), "least squares");
    /// ```
    pub fn words(&self) -> String {
        self.to_string().replace('_', " ")
    }
}

impl fmt::Display for EstimateMethod {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

impl From<Method> for EstimateMethod {
    fn from(method: Method) -> Self {
        match method {
            Method::LeastSquares => Self::LeastSquares,
            Method::InstrumentalVariable => Self::InstrumentalVariable,
        }
    }
}

//! Tests of prediction errors: are they white, do they follow the rudder?

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::chi_squared::chance_beyond;

/// Lags of the whiteness test, comparisons: one time constant of the vehicle.
const WHITENESS_LAGS: usize = 20;

/// Lags of the rudder test, and comparisons from one to the next: one and a half time constants.
const RUDDER_LAGS: usize = 6;
const RUDDER_LAG_STRIDE: usize = 5;

/// A statistic that is chi-squared distributed where nothing is left to explain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualTest {
    /// The statistic.
    pub statistic: f64,
    /// Its degrees of freedom, which it has on average.
    pub degrees_of_freedom: f64,
    /// How often chance gives as much.
    pub p_value: f64,
}

impl ResidualTest {
    fn new(statistic: f64, degrees_of_freedom: usize) -> Option<Self> {
        let degrees_of_freedom = degrees_of_freedom as f64;
        let p_value = chance_beyond(degrees_of_freedom, statistic.max(0.0))?;
        statistic.is_finite().then_some(Self { statistic, degrees_of_freedom, p_value })
    }
}

/// Tests of one-step-ahead prediction errors e.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualTests {
    /// Ljung and Box (1978): n (n + 2) sum over lags l of rho_l^2/(n - l).
    pub whiteness: ResidualTest,
    /// Do the errors follow earlier rudder angles x: (sum e x)^T (sum x x^T)^-1 (sum e x) / var(e).
    pub rudder_correlation: ResidualTest,
}

impl ResidualTests {
    /// `None` where the record is too short or the rudder lay still.
    pub(crate) fn of(innovations: &[f64], rudder_rad: &[f64]) -> Option<Self> {
        let n = innovations.len();
        if n <= 2 * WHITENESS_LAGS.max(RUDDER_LAGS * RUDDER_LAG_STRIDE) {
            return None;
        }
        let variance = innovations.iter().map(|e| e * e).sum::<f64>() / n as f64;
        Some(Self {
            whiteness: whiteness(innovations, variance)?,
            rudder_correlation: rudder_correlation(innovations, variance, rudder_rad)?,
        })
    }
}

fn whiteness(e: &[f64], variance: f64) -> Option<ResidualTest> {
    let n = e.len() as f64;
    let term = |lag: usize| {
        let product: f64 = e.iter().zip(&e[lag..]).map(|(a, b)| a * b).sum();
        (product / (n * variance)).powi(2) / (n - lag as f64)
    };
    let sum: f64 = (1..=WHITENESS_LAGS).map(term).sum();
    ResidualTest::new(n * (n + 2.0) * sum, WHITENESS_LAGS)
}

fn rudder_correlation(e: &[f64], variance: f64, rudder_rad: &[f64]) -> Option<ResidualTest> {
    let mean = rudder_rad.iter().sum::<f64>() / rudder_rad.len() as f64;
    let longest = RUDDER_LAGS * RUDDER_LAG_STRIDE;
    let mut correlation = SVector::<f64, RUDDER_LAGS>::zeros();
    let mut normal = SMatrix::<f64, RUDDER_LAGS, RUDDER_LAGS>::zeros();
    for k in longest..e.len() {
        let earlier = SVector::<f64, RUDDER_LAGS>::from_fn(|i, _| {
            rudder_rad[k - (i + 1) * RUDDER_LAG_STRIDE] - mean
        });
        correlation += earlier * e[k];
        normal += earlier * earlier.transpose();
    }
    let solved = normal.cholesky()?.solve(&correlation);
    ResidualTest::new(correlation.dot(&solved) / variance, RUDDER_LAGS)
}

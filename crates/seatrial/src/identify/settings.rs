//! How to identify.

use seatrial_core::estimator::{EstimatorSettings, Method};

/// 1/P0 is a ridge against the sum of squared yaw rates, which are small numbers in a slow vehicle: P0 is
/// at least this over the square of a typical rate, lambda times the heading's range. The paper's vehicle
/// keeps the 1e6 of the core.
const COVARIANCE_TIMES_SQUARED_RATE: f64 = 1e4;

/// How to identify. The default is the instrumental variable with filters derived from the data, then the refined estimate
/// with intervals; it keeps no trace.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct IdentifySettings {
    /// Equations (16)-(31) and the recursion to the letter.
    pub as_paper: bool,
    /// The online estimator.
    pub method: Method,
    /// Pole of the state variable filter, rad/s. `None` derives it from the data; the paper's is 1.
    pub lambda_rad_s: Option<f64>,
    /// Keep the estimate after every sample.
    pub trace: bool,
    /// Estimate from the whole record, too, with intervals: nearly all of the time that identifying takes.
    pub refine: bool,
}

impl IdentifySettings {
    /// The paper's: least squares at lambda 1 rad/s.
    ///
    /// ```
    /// use seatrial::identify::IdentifySettings;
    ///
    /// // No interval: the paper has none.
    /// assert!(IdentifySettings::default().refine && !IdentifySettings::paper().refine);
    /// ```
    pub const fn paper() -> Self {
        Self {
            as_paper: true,
            method: Method::LeastSquares,
            lambda_rad_s: None,
            trace: false,
            refine: false,
        }
    }

    pub(super) fn estimator(
        &self,
        lambda_rad_s: f64,
        heading_range_rad: f64,
    ) -> EstimatorSettings<f64> {
        if self.as_paper {
            return EstimatorSettings {
                lambda_rad_s,
                method: self.method,
                ..EstimatorSettings::paper()
            };
        }
        let settings = EstimatorSettings::for_lambda(lambda_rad_s);
        let yaw_rate_rad_s = lambda_rad_s * heading_range_rad;
        EstimatorSettings {
            initial_covariance: settings
                .initial_covariance
                .max(COVARIANCE_TIMES_SQUARED_RATE / (yaw_rate_rad_s * yaw_rate_rad_s)),
            method: self.method,
            ..settings
        }
    }
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            as_paper: false,
            method: Method::InstrumentalVariable,
            lambda_rad_s: None,
            trace: false,
            refine: true,
        }
    }
}

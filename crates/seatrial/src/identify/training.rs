//! A training window made ready for the online estimator.

use seatrial_core::estimator::EstimatorSettings;
use seatrial_core::{Sample, YawModel};

use super::error::{IdentifyError, WindowUse};
use super::online::{self, Pass, Segment};
use super::refusal::{refuse_record, rudder_constant};
use super::settings::IdentifySettings;
use super::validation;
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window, duration_s, median_interval_s};
use crate::time_scale::{ChosenLambda, LambdaReason, TimeScale};

/// The filters are warmed on the data before the window, up to this many of their time constants: what
/// remains of their start is then below rounding; for a first estimate, 4e-8 of it.
const SETTLING_TIME_CONSTANTS: f64 = 40.0;
const FIRST_SETTLING_TIME_CONSTANTS: f64 = 20.0;

/// Without such data the filters start at the equilibrium of the window's first sample, and this many of
/// their time constants, (1 + 5) e^-5 = 4 % of a wrong start left, pass before anything is learnt,
/// but at most this share of the window.
const WARMING_TIME_CONSTANTS: f64 = 5.0;
const LARGEST_WARMING_SHARE: f64 = 0.1;

/// A training window, looked at: what every method begins from.
pub struct Training<'a> {
    pub samples: &'a [Sample<f64>],
    pub estimator: EstimatorSettings<f64>,
    pub lambda_because: LambdaReason,
    pub segment: Segment<'a>,
    pub keep_trace: bool,
}

impl<'a> Training<'a> {
    pub fn new(
        record: &'a Record,
        training: Window,
        settings: &IdentifySettings,
    ) -> Result<Self, IdentifyError> {
        let samples = record.window(training);
        if samples.is_empty() {
            return Err(IdentifyError::empty_window(WindowUse::Training, training, record));
        }
        let heading_range_rad = validation::heading_range_rad(samples);
        let manoeuvre = manoeuvre_to_learn_from(record, samples)?;
        let choice = choose_lambda(record, samples, &manoeuvre, heading_range_rad, settings);
        Ok(Self {
            samples,
            estimator: settings.estimator(choice.lambda_rad_s, heading_range_rad),
            lambda_because: choice.because,
            segment: segment(
                record,
                samples,
                &manoeuvre,
                settings,
                choice.lambda_rad_s,
                SETTLING_TIME_CONSTANTS,
            ),
            keep_trace: settings.trace,
        })
    }

    pub fn estimate(&self) -> Result<Pass, IdentifyError> {
        online::estimate(&self.segment, self.estimator, self.keep_trace)
            .map_err(IdentifyError::Setting)
    }
}

/// The manoeuvre of a record from which a model may be tried, or the reason why none can.
pub fn manoeuvre_to_learn_from(
    record: &Record,
    samples: &[Sample<f64>],
) -> Result<Manoeuvre, IdentifyError> {
    let found = Manoeuvre::find(samples);
    let amplitude = found.as_ref().map_or(0.0, |m| m.amplitude_rad);
    let (heading_range_rad, unit) = (validation::heading_range_rad(samples), record.rudder_unit);
    let times_are_shared = record.units.times_are_shared;
    let refused =
        refuse_record(samples.len(), amplitude, unit, heading_range_rad, times_are_shared);
    let found = match refused {
        Some(reason) => Err(reason),
        None => found.ok_or_else(|| rudder_constant(amplitude, unit)),
    };
    found.map_err(IdentifyError::Refused)
}

/// What the estimator is given for a filter of this lambda.
fn segment<'a>(
    record: &'a Record,
    samples: &'a [Sample<f64>],
    manoeuvre: &Manoeuvre,
    settings: &IdentifySettings,
    lambda_rad_s: f64,
    settling_time_constants: f64,
) -> Segment<'a> {
    let from_s = samples.first().map_or(0.0, |s| s.time_s);
    let settling = if settings.as_paper {
        &[]
    } else {
        record.window(Window {
            from_s: from_s - settling_time_constants / lambda_rad_s,
            to_s: from_s,
        })
    };
    let warming_s = if settings.as_paper || !settling.is_empty() {
        0.0
    } else {
        (WARMING_TIME_CONSTANTS / lambda_rad_s).min(LARGEST_WARMING_SHARE * duration_s(samples))
    };
    Segment {
        settling,
        training: samples,
        learns_from_s: from_s + warming_s,
        excited_by_s: manoeuvre.both_sides_used_s(),
    }
}

pub fn choose_lambda(
    record: &Record,
    samples: &[Sample<f64>],
    manoeuvre: &Manoeuvre,
    heading_range_rad: f64,
    settings: &IdentifySettings,
) -> ChosenLambda {
    if let Some(lambda_rad_s) = settings.lambda_rad_s {
        return ChosenLambda { lambda_rad_s, because: LambdaReason::Given };
    }
    if settings.as_paper {
        return ChosenLambda { lambda_rad_s: 1.0, because: LambdaReason::Paper };
    }
    let interval_s = median_interval_s(samples).unwrap_or(0.0);
    let time_scale = TimeScale {
        half_period_s: manoeuvre.half_period_s().unwrap_or(interval_s),
        interval_s,
        duration_s: duration_s(samples),
    };
    time_scale.choose_lambda(|lambda_rad_s| -> Option<YawModel<f64>> {
        let segment = segment(
            record,
            samples,
            manoeuvre,
            settings,
            lambda_rad_s,
            FIRST_SETTLING_TIME_CONSTANTS,
        );
        online::run(&segment, settings.estimator(lambda_rad_s, heading_range_rad), |_, _, _| {})
            .ok()
            .map(|estimator| estimator.model())
    })
}

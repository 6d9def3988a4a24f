//! A model against data that it was not made from.

use seatrial_core::model::YawState;
use seatrial_core::validation::{self, GoodnessOfFit};
use seatrial_core::{PitchModel, PitchState, Real, Sample, YawModel};

use super::error::{IdentifyError, WindowUse};
use crate::identification::Validation;
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window};
use crate::savitzky_golay::SavitzkyGolay;

/// A lead-in is quiet if the mean headings of its two halves differ by less than this share of the heading's
/// whole range.
const QUIET_SHARE: f64 = 0.1;

/// The derivative of the heading is taken over so many of the vehicle's time constants: more blurs the yaw
/// rate, fewer let the compass noise through; within these numbers of samples either side.
const DERIVATIVE_TIME_CONSTANTS: f64 = 1.5;
const DERIVATIVE_SAMPLES: (usize, usize) = (2, 60);

/// Validation data: a record, which may be the training record, and a window on it.
#[derive(Clone, Copy, Debug)]
pub struct ValidationData<'a> {
    /// The record.
    pub record: &'a Record,
    /// The window, half open.
    pub window: Window,
}

/// R^2 of the heading of validation data with the offset estimated again. `None` where they tell none.
pub(super) fn heading_r2(model: YawModel<f64>, data: ValidationData) -> Option<f64> {
    let found = validate(model, data.record, data.window).ok()?;
    found.r2_heading_offset_refit
}

/// Simulates `model` over a window of a record and compares (35)-(37).
pub fn validate(
    model: YawModel<f64>,
    record: &Record,
    window: Window,
) -> Result<Validation, IdentifyError> {
    of_window(record, window, |samples| goodness_of_fit(model, samples))
}

/// What a score says of the samples of a window.
pub(super) fn of_window(
    record: &Record,
    window: Window,
    score: impl Fn(&[Sample<f64>]) -> GoodnessOfFit<f64>,
) -> Result<Validation, IdentifyError> {
    let samples = record.window(window);
    if samples.is_empty() {
        return Err(IdentifyError::empty_window(WindowUse::Validation, window, record));
    }
    let fit = score(samples);
    Ok(Validation {
        window: window.known_part(samples),
        r2_heading: fit.r2_heading,
        r2_heading_offset_refit: fit.r2_heading_offset_refit,
        r2_yaw_rate: fit.r2_yaw_rate,
        samples: fit.samples as usize,
        horizon_s: None,
    })
}

/// R^2 of heading and of yaw rate, the latter measured or, where it is not, the derivative of the
/// measured heading.
///
/// The simulation starts from the mean heading of the lead-in: what comes before the first movement
/// of the rudder, if the vehicle is quiet there for a time constant. Otherwise the initial heading and yaw rate are fitted.
pub fn goodness_of_fit(model: YawModel<f64>, samples: &[Sample<f64>]) -> GoodnessOfFit<f64> {
    let lead_in_s = quiet_lead_in_s(samples);
    let fit = compared(model, lead_in_s, samples);
    match fit.r2_yaw_rate {
        Some(_) => fit,
        None => with_derived_yaw_rate(model, samples, lead_in_s, fit),
    }
}

/// [`goodness_of_fit`] without the derivative of the heading: of the yaw rate only where it is measured.
pub(super) fn fit_of_what_is_measured(
    model: YawModel<f64>,
    samples: &[Sample<f64>],
) -> GoodnessOfFit<f64> {
    compared(model, quiet_lead_in_s(samples), samples)
}

/// [`goodness_of_fit`] by the measured yaw rate or by the derivative of the heading, whichever the model explains
/// better: a slow vehicle's yaw rate drowns in the noise of its gyro, not in that of its compass.
pub(super) fn fit_by_the_clearer_rate(
    model: YawModel<f64>,
    samples: &[Sample<f64>],
) -> GoodnessOfFit<f64> {
    let lead_in_s = quiet_lead_in_s(samples);
    let measured = compared(model, lead_in_s, samples);
    let derived = with_derived_yaw_rate(model, samples, lead_in_s, measured);
    if derived.r2_yaw_rate > measured.r2_yaw_rate { derived } else { measured }
}

/// The simulation whose R^2 of heading [`goodness_of_fit`] states, at each of these usable samples, by a model of first order, or of pitch with
/// its restoring moment m, 1/s^2. `offset_again`: with the offset that fits these samples.
pub fn simulated_by(
    model: YawModel<f64>,
    restoring_per_s2: Option<f64>,
    samples: &[Sample<f64>],
    offset_again: bool,
) -> Vec<YawState<f64>> {
    let Some(first) = samples.first() else {
        return Vec::new();
    };
    let lead_in_s = quiet_lead_in_s(samples);
    let mut validation = validation::Validation::new(model, lead_in_s).righted_by(restoring_per_s2);
    samples.iter().for_each(|sample| validation.compare(sample));
    // Pitch oscillates about its trim and shows no rest.
    let is_known = restoring_per_s2.is_none() && shows_rest(lead_in_s, -1.0 / model.a22_per_s);
    let [heading_rad, yaw_rate_rad_s, offset_rad_s2] =
        validation.heading_start(!is_known, offset_again);
    let model = YawModel { c0_rad_per_s2: model.c0_rad_per_s2 + offset_rad_s2, ..model };
    let mut state = YawState { heading_rad: first.heading_rad + heading_rad, yaw_rate_rad_s };
    let mut states = vec![state];
    for pair in samples.windows(2) {
        let interval_s = pair[1].time_s - pair[0].time_s;
        state = match restoring_per_s2 {
            None => model.advance(state, pair[0].rudder_rad, interval_s),
            Some(m) => righted(&model, m, state, pair[0].rudder_rad, interval_s),
        };
        states.push(state);
    }
    states
}

/// The state of a vehicle that m rights, 1/s^2, an interval later.
fn righted(
    model: &YawModel<f64>,
    restoring_per_s2: f64,
    state: YawState<f64>,
    rudder_rad: f64,
    interval_s: f64,
) -> YawState<f64> {
    let start = PitchState { pitch_rad: state.heading_rad, pitch_rate_rad_s: state.yaw_rate_rad_s };
    let after = PitchModel::righted(model, restoring_per_s2).advance(start, rudder_rad, interval_s);
    YawState { heading_rad: after.pitch_rad, yaw_rate_rad_s: after.pitch_rate_rad_s }
}

/// From the mean of the lead-in or, where it is shorter than a time constant and shows no rest, from any start.
fn compared(model: YawModel<f64>, lead_in_s: f64, samples: &[Sample<f64>]) -> GoodnessOfFit<f64> {
    let mut validation = validation::Validation::new(model, lead_in_s);
    samples.iter().for_each(|sample| validation.compare(sample));
    match shows_rest(lead_in_s, -1.0 / model.a22_per_s) {
        true => validation.goodness_of_fit(),
        false => validation.goodness_of_fit_from_any_start(),
    }
}

/// Is a vehicle of this time constant known to be at rest after a quiet lead-in?
pub(crate) fn shows_rest(lead_in_s: f64, time_constant_s: f64) -> bool {
    lead_in_s >= time_constant_s && lead_in_s > 0.0
}

fn with_derived_yaw_rate(
    model: YawModel<f64>,
    samples: &[Sample<f64>],
    lead_in_s: f64,
    fit: GoodnessOfFit<f64>,
) -> GoodnessOfFit<f64> {
    let rate =
        derived_yaw_rate(model, samples).map(|with_rate| compared(model, lead_in_s, &with_rate));
    GoodnessOfFit {
        r2_yaw_rate: rate.and_then(|rate| rate.r2_yaw_rate),
        r2_yaw_rate_offset_refit: rate.and_then(|rate| rate.r2_yaw_rate_offset_refit),
        ..fit
    }
}

/// Length of the quiet part before the first movement of the rudder, s, at most half a period of
/// the rudder; 0 where there is none.
pub fn quiet_lead_in_s(samples: &[Sample<f64>]) -> f64 {
    let (Some(first), Some(manoeuvre)) = (samples.first(), Manoeuvre::find(samples)) else {
        return 0.0;
    };
    let to_first_move_s = manoeuvre.starts_s - first.time_s;
    let lead_in_s =
        manoeuvre.half_period_s().map_or(0.0, |half_period_s| half_period_s.min(to_first_move_s));
    let end = samples.partition_point(|sample| sample.time_s < first.time_s + lead_in_s);
    let (first_half, second_half) = samples[..end].split_at(end / 2);
    let drift =
        mean_from(first.heading_rad, second_half) - mean_from(first.heading_rad, first_half);
    if drift.abs() <= QUIET_SHARE * heading_range_rad(samples) { lead_in_s } else { 0.0 }
}

/// Mean heading less `origin_rad`, rad, which the vehicle is near to.
fn mean_from(origin_rad: f64, samples: &[Sample<f64>]) -> f64 {
    let sum: f64 = samples
        .iter()
        .map(|sample| Real::wrapped(sample.heading_rad - origin_rad))
        .filter(|turned| turned.is_finite())
        .sum();
    sum / samples.len().max(1) as f64
}

/// Largest less smallest unwrapped heading, rad; what is not finite is left out.
pub fn heading_range_rad<'a>(samples: impl IntoIterator<Item = &'a Sample<f64>>) -> f64 {
    let mut last = None;
    let (mut unwrapped, mut low, mut high) = (0.0, 0.0_f64, 0.0_f64);
    for heading in
        samples.into_iter().map(|sample| sample.heading_rad).filter(|heading| heading.is_finite())
    {
        unwrapped += Real::wrapped(heading - last.unwrap_or(heading));
        last = Some(heading);
        low = low.min(unwrapped);
        high = high.max(unwrapped);
    }
    high - low
}

/// The samples with the derivative of their heading as yaw rate. `None` where too few are usable.
pub(crate) fn derived_yaw_rate(
    model: YawModel<f64>,
    samples: &[Sample<f64>],
) -> Option<Vec<Sample<f64>>> {
    let mut usable: Vec<Sample<f64>> = Vec::with_capacity(samples.len());
    let mut headings: Vec<f64> = Vec::with_capacity(samples.len());
    for sample in samples {
        let last = usable.last();
        let is_usable = sample.time_s.is_finite()
            && sample.heading_rad.is_finite()
            && sample.rudder_rad.is_finite()
            && last.is_none_or(|last| sample.time_s > last.time_s);
        if is_usable {
            let step =
                last.map_or(0.0, |last| Real::wrapped(sample.heading_rad - last.heading_rad));
            headings.push(headings.last().unwrap_or(&sample.heading_rad) + step);
            usable.push(*sample);
        }
    }
    let times: Vec<f64> = usable.iter().map(|sample| sample.time_s).collect();
    let interval_s = (times.last()? - times.first()?) / (times.len() - 1).max(1) as f64;
    let (least, most) = DERIVATIVE_SAMPLES;
    let half_window =
        (0.5 * DERIVATIVE_TIME_CONSTANTS / (model.a22_per_s.abs() * interval_s)) as usize;
    let rates = SavitzkyGolay::new(half_window.clamp(least, most), 2)
        .and_then(|filter| filter.derivative(&times, &headings))
        .ok()?;
    for (sample, rate) in usable.iter_mut().zip(rates) {
        sample.yaw_rate_rad_s = Some(rate);
    }
    Some(usable)
}

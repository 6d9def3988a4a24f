//! From a record to a model: the online estimate, fresh data and the verdict.

pub mod batch;
pub mod bound;
pub(crate) mod compass;
mod edges;
pub mod evenly_sampled;
pub mod fresh;
pub mod joined;
pub mod lag;
mod measured;
pub mod online;
pub mod output_error;
pub mod peak;
pub mod refine;
#[cfg(test)]
mod seas;
pub mod second_order;
pub mod simplex;
mod simulation;
mod training;
mod unexplained;
pub mod whitening;

use seatrial_core::Sample;
use seatrial_core::estimator::{EstimatorSettings, InvalidSetting, Method};

use crate::gain_allowance::sampled;
use crate::identification::{Identification, Reason, Refined, Settings};
use crate::manoeuvre::Manoeuvre;
use crate::record::{Record, Window, duration_s, median_interval_s};
use crate::time_scale::ChosenLambda;
use crate::verdict::{self, Evidence};
use compass::CompassError;
use edges::Edges;
use joined::Joined;
use lag::LagTest;
use online::Pass;
use second_order::SwayYawModel;
pub(crate) use training::Training;
use training::{choose_lambda, manoeuvre_to_learn_from};
use unexplained::{Unexplained, higher_order};

/// 1/P0 is a ridge against the sum of squared yaw rates, which are small numbers in a slow vehicle: P0 is
/// at least this over the square of a typical rate, lambda times the heading's range. The paper's vehicle
/// keeps the 1e6 of the core.
const COVARIANCE_TIMES_SQUARED_RATE: f64 = 1e4;

/// What a likeliest model leaves of the error of a mean rudder: the rest passes for its initial state and its offset.
const LEFT_OF_A_MEAN: f64 = 0.25;

/// How to identify.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    pub const fn paper() -> Self {
        Self {
            as_paper: true,
            method: Method::LeastSquares,
            lambda_rad_s: None,
            trace: false,
            refine: false,
        }
    }

    fn estimator(&self, lambda_rad_s: f64, heading_range_rad: f64) -> EstimatorSettings<f64> {
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

/// Fresh data: a record, which may be the training record, and a window on it.
#[derive(Clone, Copy, Debug)]
pub struct Fresh<'a> {
    /// The record.
    pub record: &'a Record,
    /// The window, half open.
    pub window: Window,
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// No sample lies in a window.
    #[error("{0}")]
    EmptyWindow(String),
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(InvalidSetting),
    /// Nothing can be estimated from these samples.
    #[error("{}", .0.text)]
    Refused(Reason),
}

impl IdentifyError {
    fn empty_window(name: &str, window: Window, record: &Record) -> Self {
        let span = match (record.samples.first(), record.samples.last()) {
            (Some(first), Some(last)) => {
                format!("the log runs from {} s to {} s", first.time_s, last.time_s)
            }
            _ => "the log has no samples".into(),
        };
        Self::EmptyWindow(format!(
            "no sample lies in the {name} window, {window}; {span}"
        ))
    }
}

/// Identifies the yaw model from the training window of a record, and validates it on fresh data.
///
/// The filters are warmed on what the record holds before the window. The excitation counts as over when the
/// rudder has been laid to both hands and comes back from the second: the end of a doublet, the end of
/// the first cycle of a zig-zag. From there on convergence is watched and the instrument is used.
pub fn identify(
    record: &Record,
    training: Window,
    fresh: Option<Fresh>,
    settings: &IdentifySettings,
) -> Result<Identification, IdentifyError> {
    let prepared = Training::new(record, training, settings)?;
    let pass = prepared.estimate()?;
    let used = Settings {
        as_paper: settings.as_paper,
        lambda_because: prepared.lambda_because,
        ..Settings::of(&prepared.estimator)
    };
    let window = known_part(training, prepared.samples);
    assess_with_others(record, window, fresh, pass, used, settings.refine, &[])
        .map(|(alone, _)| alone)
}

/// The pole of the state variable filter by a first estimate from a window; an error where it gives none.
pub fn lambda_of(record: &Record, window: Window) -> Result<ChosenLambda, IdentifyError> {
    let samples = record.window(window);
    let heading_range_rad = fresh::heading_range_rad(samples);
    let manoeuvre = manoeuvre_to_learn_from(record, samples)?;
    let settings = IdentifySettings::default();
    Ok(choose_lambda(
        record,
        samples,
        &manoeuvre,
        heading_range_rad,
        &settings,
    ))
}

/// Refines an online estimate on its training record, validates it on fresh data and gives the verdict.
///
/// The refined model, where there is one, is the one that is validated and goes to the controller: it uses
/// every sample at its true weight and states how sure it is. Where the record shows more than a first-order
/// model, the online estimate takes its place with a wider interval; where a lagging rudder explains all of it, the
/// model behind the lag. Where the rudder moved far while samples were lost, the heading tells when; where there is so
/// little noise that the mean of the rudder over such an interval is not enough, the online estimate is used as well. Under a
/// large disturbance the intervals reach the online estimate; where fresh data give another
/// model, they reach it, and that of C0 takes the sea of the fresh data into account.
pub fn assess(
    record: &Record,
    training: Window,
    fresh: Option<Fresh>,
    pass: Pass,
    settings: Settings,
) -> Result<Identification, IdentifyError> {
    let refine = !settings.as_paper;
    assess_with_others(record, training, fresh, pass, settings, refine, &[]).map(|(alone, _)| alone)
}

/// The same with the refined estimates of other manoeuvres of the same speed joined to the record's own.
fn assess_with_others(
    record: &Record,
    training: Window,
    fresh: Option<Fresh>,
    pass: Pass,
    settings: Settings,
    refine: bool,
    others: &[(Window, Refined)],
) -> Result<(Identification, Option<Joined>), IdentifyError> {
    let samples = record.window(training);
    let heading_range_rad = fresh::heading_range_rad(samples);
    let manoeuvre = manoeuvre_to_learn_from(record, samples)?;
    let edges = Edges::of(&pass.accepted);
    let placed = refine.then(|| edges.placed(Some(pass.online.model)));
    let known = placed
        .as_ref()
        .map_or(&*pass.accepted, |placed| &*placed.samples);
    let refined = refine
        .then(|| refine::refine(known, Some(pass.online.model)).ok())
        .flatten();
    let is_blurred = |refined: &Refined| {
        let wrong_rad = refined.model.b2_per_s2.abs() * edges.coarseness_rad_s2();
        refined.heading_noise_rad < LEFT_OF_A_MEAN * wrong_rad
    };
    let blurred = refined.as_ref().is_some_and(is_blurred);
    let sharp = refined.as_ref().filter(|_| !blurred);
    let lag = sharp.and_then(|refined| LagTest::of(known, refined));
    let unexplained =
        sharp.and_then(|refined| Unexplained::of(known, refined, manoeuvre.amplitude_rad, lag));
    let (mismatch, disturbed) = match &unexplained {
        Some(unexplained) if unexplained.is_structural() => (Some(unexplained.share), None),
        Some(unexplained) => (None, unexplained.is_large().then_some(unexplained.share)),
        None => (None, None),
    };
    let lag_effect = sharp
        .filter(|_| mismatch.is_none())
        .and_then(|refined| lag?.effect_of_an_ordinary_lag(known, refined));
    let higher_order = higher_order(unexplained, fresh)?;
    let simulated = (mismatch.is_some() || blurred)
        .then(|| output_error::output_error(known, Some(pass.online.model)).ok())
        .flatten();
    let lagging = higher_order
        .as_ref()
        .filter(|h| h.estimate.is_first_order_behind_a_lag())
        .filter(|_| mismatch.is_some());
    let alone = refined.map(|refined| match (lagging, simulated) {
        (Some(lagging), _) => refine::behind_the_lag(&refined, &lagging.estimate),
        (None, Some(simulated)) => refine::around_online(&refined, pass.online.model, &simulated),
        (None, None) => refined,
    });
    let alone = match &placed {
        Some(placed) => alone.map(|alone| refine::widened(&alone, &placed.covariance)),
        None => alone,
    };
    let alone = match disturbed {
        Some(_) => alone.map(|alone| refine::reaching(&alone, pass.online.model)),
        None => alone,
    };
    let together = alone
        .as_ref()
        .and_then(|alone| joined::join(training, alone, others));
    let (refined, joined) = match together {
        Some((refined, joined)) => (Some(refined), Some(joined)),
        None => (alone, None),
    };
    let model = refined.as_ref().map_or(pass.online.model, |r| r.model);
    let lagging = lagging.map(|lagging| SwayYawModel {
        a22_per_s: model.a22_per_s,
        b2_per_s2: model.b2_per_s2,
        c0_rad_per_s2: model.c0_rad_per_s2,
        ..lagging.estimate.model
    });
    let validation = fresh
        .map(|fresh| match &lagging {
            Some(lagging) => second_order::validate(lagging, fresh.record, fresh.window),
            None => fresh::validate(model, fresh.record, fresh.window),
        })
        .transpose()?;
    let training_fit = match &lagging {
        Some(lagging) => second_order::goodness_of_fit(lagging, &pass.accepted),
        None => fresh::fit_by_the_clearer_rate(model, &pass.accepted),
    };
    let other = fresh.filter(|fresh| refine && fresh.window != training);
    let fresh_samples = other.map(|fresh| fresh.record.usable(fresh.window));
    // What a lagging rudder leaves of a first-order model is no match for the model behind the lag.
    let is_comparable = |fresh: &Refined| lagging.is_none() || fresh.method != NEAREST;
    let of_fresh = fresh_samples
        .as_deref()
        .and_then(fresh_estimate)
        .filter(is_comparable);
    let loop_timing = median_interval_s(samples)
        .filter(|_| !settings.as_paper)
        .map(|interval_s| sampled(interval_s, lagging.as_ref().map_or(0.0, |l| l.rudder_lag_s)));
    let verdict = verdict::judge(&Evidence {
        samples_used: pass.samples_used,
        samples_rejected: pass.rejected.total(),
        rudder_amplitude_rad: manoeuvre.amplitude_rad,
        rudder_hands_rad: manoeuvre.hands_rad(samples),
        rudder_unit: record.rudder_unit,
        heading_range_rad,
        heading_step_rad: measured::smallest_heading_step_rad(samples),
        surge_speed_m_s: measured::surge_speeds_m_s(samples),
        interval_s: measured::usual_and_long_interval_s(samples),
        online: pass.online.model,
        needs_interval: refine,
        compass: CompassError::of(&pass.accepted),
        refined: refined.as_ref(),
        mismatch,
        disturbed,
        higher_order: higher_order.as_ref(),
        lag_effect: lag_effect.as_ref(),
        residual: lag.and_then(|lag| lag.residual),
        hidden_edges: edges.count(),
        training_fit,
        validation,
        fresh_jump_rad: fresh_samples
            .as_deref()
            .and_then(|samples| CompassError::of(samples).largest_jump_rad),
        fresh: of_fresh.as_ref(),
        validation_rudder_amplitude_rad: fresh
            .and_then(|fresh| Manoeuvre::find(fresh.record.window(fresh.window)))
            .map(|manoeuvre| manoeuvre.amplitude_rad),
    });
    let refined = match (refined, fresh_samples, &of_fresh) {
        (Some(refined), Some(samples), Some(fresh)) => {
            let length = duration_s(&samples) / duration_s(known);
            Some(refine::reaching_fresh(&refined, fresh, length))
        }
        (refined, ..) => refined,
    };
    let identification = Identification {
        training,
        samples_used: pass.samples_used,
        samples_rejected: pass.rejected,
        settings,
        nomoto: model.nomoto(),
        online: pass.online,
        refined,
        validation,
        higher_order,
        lag_effect,
        loop_timing,
        verdict,
    };
    Ok((identification, joined))
}

/// The method of output error: of the model nearest to data that are not of first order.
const NEAREST: &str = "output_error";

/// The estimate from fresh data alone: the refined one where a first-order model explains them, or else output error's.
pub fn fresh_estimate(samples: &[Sample<f64>]) -> Option<Refined> {
    let manoeuvre = Manoeuvre::find(samples)?;
    let edges = Edges::of(samples);
    let placed = edges.placed(None);
    let samples = &*placed.samples;
    let refined = refine::refine(samples, None).ok()?;
    let lag = LagTest::of(samples, &refined);
    let is_structural = Unexplained::of(samples, &refined, manoeuvre.amplitude_rad, lag)
        .is_some_and(|unexplained| unexplained.is_structural());
    let estimate = match is_structural {
        true => {
            let nearest = output_error::output_error(samples, Some(refined.model)).ok()?;
            let covariance = nearest.covariance.into();
            refine::around(&refined, nearest.model, covariance, NEAREST)
        }
        false => refined,
    };
    Some(refine::widened(&estimate, &placed.covariance))
}

/// The window as far as there are samples: no end is infinite.
pub(crate) fn known_part(window: Window, samples: &[Sample<f64>]) -> Window {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return window;
    };
    Window {
        from_s: if window.from_s.is_finite() {
            window.from_s
        } else {
            first.time_s
        },
        to_s: if window.to_s.is_finite() {
            window.to_s
        } else {
            last.time_s + median_interval_s(samples).unwrap_or(0.0)
        },
    }
}

//! A steering model against data that it was not made from.

use nalgebra::{DMatrix, DVector, Vector4};
use seatrial_core::model::YawState;
use seatrial_core::validation::GoodnessOfFit;
use seatrial_core::{Real, Sample, YawModel};

use crate::identification::{Identification, Validation};
use crate::identify::error::IdentifyError;
use crate::identify::validation;
use crate::likelihood::steering_model::{SteeringModel, SteeringState, first_order_at};
use crate::record::{Record, Window, unwrapped_rad};

/// R^2 of the heading of validation data with the offset estimated again. `None` where they tell none.
pub(super) fn heading_r2(model: &SteeringModel, data: validation::ValidationData) -> Option<f64> {
    let found = validate(model, data.record, data.window).ok()?;
    found.r2_heading_offset_refit
}

/// Simulates `model` over a window of a record and compares (35)-(37), as
/// [`crate::identify::validation::validate`] does a first-order model.
pub fn validate(
    model: &SteeringModel,
    record: &Record,
    window: Window,
) -> Result<Validation, IdentifyError> {
    validation::of_window(record, window, |samples| goodness_of_fit(model, samples))
}

/// R^2 of heading and of yaw rate, the latter measured or, where it is not, the derivative of the
/// measured heading.
///
/// The simulation starts without drift, from the mean heading and the mean measured yaw rate, 0 where it is not
/// measured, of the quiet lead-in. Where that is shorter than a time constant, the initial heading and yaw rate are fitted. A sample whose time, heading or
/// rudder is not finite, or whose time does not increase, is left out.
pub fn goodness_of_fit(model: &SteeringModel, samples: &[Sample<f64>]) -> GoodnessOfFit<f64> {
    let record: Record = samples.iter().copied().collect();
    let usable = record.usable(Window::ALL);
    if usable.is_empty() {
        return GoodnessOfFit::default();
    }
    let headings = unwrapped_headings(&usable);
    let run = ValidationRun::new(model, &usable, &headings, samples);
    let measured = measured_yaw_rates(&usable);
    let rates = measured.or_else(|| run.derived_yaw_rates());
    let of = |signal: fn(&SteeringState) -> f64, measured: &[f64]| {
        (run.r2(signal, measured, Offset::OfTheModel), run.r2(signal, measured, Offset::Fitted))
    };
    let (r2_heading, r2_heading_offset_refit) = of(|state| state.heading_rad, &headings);
    let (r2_yaw_rate, r2_yaw_rate_offset_refit) =
        rates.map(|rates| of(|state| state.yaw_rate_rad_s, &rates)).unwrap_or_default();
    GoodnessOfFit {
        r2_heading,
        r2_heading_offset_refit,
        r2_yaw_rate,
        r2_yaw_rate_offset_refit,
        samples: usable.len() as u32,
    }
}

/// The simulation whose R^2 of heading is stated: heading and yaw rate at each of these usable samples, headings unwrapped from the first
/// one's. It starts as the score does, with the offset of the model or, `offset_again`, with the one that fits these samples.
pub fn simulated(
    found: &Identification,
    samples: &[Sample<f64>],
    offset_again: bool,
) -> Vec<YawState<f64>> {
    let restoring_per_s2 = found.restoring.map(|m| m.refined_per_s2);
    match found.simulated() {
        Some(model) => simulated_by(model, samples, offset_again),
        None => validation::simulated_by(found.model(), restoring_per_s2, samples, offset_again),
    }
}

/// [`simulated`] by a steering model.
fn simulated_by(
    model: &SteeringModel,
    samples: &[Sample<f64>],
    offset_again: bool,
) -> Vec<YawState<f64>> {
    let Some(first) = samples.first() else {
        return Vec::new();
    };
    let headings = unwrapped_headings(samples);
    let run = ValidationRun::new(model, samples, &headings, samples);
    let offset = match offset_again {
        true => Offset::Fitted,
        false => Offset::OfTheModel,
    };
    let fitted = run.fitted(|state| state.heading_rad, &headings, offset);
    let change = fitted.map_or_else(Change::zeros, |(change, _)| change);
    let turns_rad = first.heading_rad - headings[0];
    let state = |state: SteeringState| YawState {
        heading_rad: state.heading_rad + turns_rad,
        yaw_rate_rad_s: state.yaw_rate_rad_s,
    };
    run.states(change).into_iter().map(state).collect()
}

/// The headings of usable samples without jumps, rad.
fn unwrapped_headings(samples: &[Sample<f64>]) -> Vec<f64> {
    let first_rad = samples.first().map_or(0.0, |s| s.heading_rad.wrapped());
    unwrapped_rad(first_rad, samples.iter().map(|s| s.heading_rad))
}

/// The longest time constant of the linear part, s.
fn slowest_s(model: &SteeringModel) -> f64 {
    let nomoto = model.nomoto().map(|nomoto| nomoto.t1_s.abs());
    nomoto.unwrap_or(-1.0 / model.a22_per_s)
}

/// Does it hold a straight course by itself?
fn is_course_stable(model: &SteeringModel) -> bool {
    let times = model.nomoto().map(|nomoto| [nomoto.t1_s, nomoto.t2_s]);
    times.map_or(model.a22_per_s < 0.0, |times| times.iter().all(|t| *t > 0.0))
}

fn mean<'a>(values: impl ExactSizeIterator<Item = &'a f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.sum::<f64>() / count
}

/// `None` unless every sample has one.
fn measured_yaw_rates(samples: &[Sample<f64>]) -> Option<Vec<f64>> {
    samples.iter().map(|sample| sample.yaw_rate_rad_s.filter(|rate| rate.is_finite())).collect()
}

/// Is the offset C0 estimated again?
#[derive(Clone, Copy, PartialEq)]
enum Offset {
    OfTheModel,
    Fitted,
}

/// Validation samples and where their simulation starts.
struct ValidationRun<'a> {
    model: &'a SteeringModel,
    samples: &'a [Sample<f64>],
    start: SteeringState,
    is_start_known: bool,
}

/// Changes of the initial heading, rad, the initial yaw rate, rad/s, the offset, rad/s^2, and what sway remembers at first, rad.
type Change = Vector4<f64>;

/// Shares of the samples that the start is fitted to in turn where a fit to all of them ends under this R^2: a course-unstable model leaves them where
/// its start is a little off.
const BEGINNINGS: [f64; 6] = [0.06, 0.12, 0.25, 0.4, 0.65, 1.0];
const GOOD_FIT: f64 = 0.9;

impl<'a> ValidationRun<'a> {
    /// Over usable samples with their unwrapped headings; the quiet lead-in is that of `recorded`.
    fn new(
        model: &'a SteeringModel,
        samples: &'a [Sample<f64>],
        headings: &[f64],
        recorded: &[Sample<f64>],
    ) -> Self {
        let lead_in_s = validation::quiet_lead_in_s(recorded);
        let begins_s = samples.first().map_or(0.0, |first| first.time_s);
        let lead_in = samples.partition_point(|sample| sample.time_s < begins_s + lead_in_s).max(1);
        let rates = measured_yaw_rates(samples);
        Self {
            model,
            samples,
            start: SteeringState {
                heading_rad: mean(headings.iter().take(lead_in)),
                yaw_rate_rad_s: rates.map_or(0.0, |rates| mean(rates.iter().take(lead_in))),
                drift_rad: 0.0,
            },
            is_start_known: is_course_stable(model)
                && validation::shows_rest(lead_in_s, slowest_s(model)),
        }
    }

    /// Over the time constants that the vehicle has at the yaw rates of this run, or those of its turns where sway makes them shorter.
    fn derived_yaw_rates(&self) -> Option<Vec<f64>> {
        let model = self.model;
        let states = model.simulate(self.samples, self.start);
        let rates: Vec<f64> = states.iter().map(|s| s.yaw_rate_rad_s.abs()).collect();
        let damped_per_s = model.a22_per_s - model.quadratic_per_rad * mean(rates.iter());
        let largest_rad = self.samples.iter().map(|s| s.rudder_rad.abs()).fold(0.0, f64::max);
        let [of_turns_per_s, ..] = first_order_at(&model.vehicle(), 0.0, largest_rad);
        let as_first_order = YawModel {
            // No first-order model is near where this is no number.
            a22_per_s: damped_per_s.min(of_turns_per_s),
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
        };
        let derived = validation::derived_yaw_rate(as_first_order, self.samples)?;
        measured_yaw_rates(&derived)
    }

    fn states(&self, change: Change) -> Vec<SteeringState> {
        let model =
            SteeringModel { c0_rad_per_s2: self.model.c0_rad_per_s2 + change[2], ..*self.model };
        let start = SteeringState {
            heading_rad: self.start.heading_rad + change[0],
            yaw_rate_rad_s: self.start.yaw_rate_rad_s + change[1],
            drift_rad: self.start.drift_rad + change[3],
        };
        model.simulate(self.samples, start)
    }

    /// The first of the samples alone.
    fn beginning(&self, share: f64) -> Self {
        let count = ((share * self.samples.len() as f64).ceil() as usize).min(self.samples.len());
        Self { samples: &self.samples[..count], ..*self }
    }

    fn simulated(&self, signal: fn(&SteeringState) -> f64, change: Change) -> Vec<f64> {
        self.states(change).iter().map(signal).collect()
    }

    /// 1 - J/Var (35). `None` where the signal did not vary.
    fn r2_at(
        &self,
        signal: fn(&SteeringState) -> f64,
        measured: &[f64],
        change: Change,
    ) -> Option<f64> {
        let simulated = self.simulated(signal, change);
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|e| e * e).sum::<f64>();
        let errors = squares(&mut measured.iter().zip(&simulated).map(|(m, s)| m - s));
        let centre = mean(measured.iter());
        let variation = squares(&mut measured.iter().map(|m| m - centre));
        let r2 = 1.0 - errors / variation;
        (variation > 0.0 && r2.is_finite()).then_some(r2)
    }

    fn r2(
        &self,
        signal: fn(&SteeringState) -> f64,
        measured: &[f64],
        offset: Offset,
    ) -> Option<f64> {
        Some(self.fitted(signal, measured, offset)?.1)
    }

    /// The change that is fitted and its R^2, the best.
    fn fitted(
        &self,
        signal: fn(&SteeringState) -> f64,
        measured: &[f64],
        offset: Offset,
    ) -> Option<(Change, f64)> {
        let of_start = (!self.is_start_known).then_some([0, 1]);
        let of_offset = (offset == Offset::Fitted).then_some(2);
        let of_sway = (!self.is_start_known && self.model.a21_per_s2 != 0.0).then_some(3);
        let free: Vec<usize> =
            (of_start.into_iter().flatten()).chain(of_offset).chain(of_sway).collect();
        let direct = self.fitted_from(signal, measured, &free, Change::zeros())?;
        if direct.1 > GOOD_FIT || self.is_start_known {
            return Some(direct);
        }
        let (mut from, mut patient) = (Change::zeros(), None);
        for share in BEGINNINGS {
            let beginning = self.beginning(share);
            let part = &measured[..beginning.samples.len()];
            patient = beginning.fitted_from(signal, part, &free, from);
            from = patient.map_or(from, |(change, _)| change);
        }
        // The last beginning is the whole.
        Some(match patient {
            Some(patient) if patient.1 > direct.1 => patient,
            _ => direct,
        })
    }

    /// Newton's method on the sum of squares from a change, with secants of the simulation and steps that are halved until they gain.
    fn fitted_from(
        &self,
        signal: fn(&SteeringState) -> f64,
        measured: &[f64],
        free: &[usize],
        from: Change,
    ) -> Option<(Change, f64)> {
        const MOST_STEPS: u32 = 8;
        const SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.02];
        let mut best = (from, self.r2_at(signal, measured, from)?);
        for _ in 0..if free.is_empty() { 0 } else { MOST_STEPS } {
            let Some(step) = self.gauss_newton_step(signal, measured, free, best.0) else {
                break;
            };
            let next = SHARES.iter().find_map(|share| {
                let change = best.0 + *share * step;
                let r2 = self.r2_at(signal, measured, change)?;
                (r2 > best.1).then_some((change, r2))
            });
            match next {
                Some(next) => best = next,
                None => break,
            }
        }
        Some(best)
    }

    /// Secants of the simulation for derivatives; `None` where they do not determine the step.
    fn gauss_newton_step(
        &self,
        signal: fn(&SteeringState) -> f64,
        measured: &[f64],
        free: &[usize],
        change: Change,
    ) -> Option<Change> {
        let spread = 1e-4 * self.model.b2_per_s2.abs();
        let here = self.simulated(signal, change);
        let sensitivity = |i: &usize| {
            let above = self.simulated(signal, change + Change::ith(*i, spread));
            let slopes = above.iter().zip(&here).map(|(a, h)| (a - h) / spread);
            DVector::from_iterator(here.len(), slopes)
        };
        // A heading that starts elsewhere does nothing to the yaw rate.
        let (free, columns): (Vec<usize>, Vec<DVector<f64>>) = free
            .iter()
            .map(|i| (*i, sensitivity(i)))
            .filter(|(_, column)| column.norm_squared() > 0.0)
            .unzip();
        if columns.is_empty() {
            return None;
        }
        let sensitivities = DMatrix::from_columns(&columns);
        let missed = measured.iter().zip(&here).map(|(m, h)| m - h);
        let missed = DVector::from_iterator(here.len(), missed);
        let normal = sensitivities.tr_mul(&sensitivities).cholesky()?;
        let step = normal.solve(&sensitivities.tr_mul(&missed));
        let mut of_all = Change::zeros();
        for (i, of_i) in free.iter().zip(step.iter()) {
            of_all[*i] = *of_i;
        }
        Some(of_all)
    }
}

//! Filtering and batch least squares in one pass over evenly sampled arrays.

use std::f64::consts::PI;
use std::ops::Range;

use seatrial_core::fixed_rate::FixedRateSettings;
use seatrial_core::state_variable_filter::{FilterStep, StateVariableFilter};
use seatrial_core::{Hold, InvalidSetting, Real, YawModel};
use serde::Serialize;

use super::sums::NormalEquations;
use crate::figures::three_figures;
use crate::record::Window;

/// An interval between two samples may differ from the mean one by this share of it.
const LARGEST_UNEVENNESS: f64 = 0.01;

/// Samples that are looked at, and then filtered while they are still in the cache.
const PIECE: usize = 1 << 15;

/// A record as its columns, one sample every so many seconds.
#[derive(Clone, Copy, Debug)]
pub struct EvenlySampled<'a> {
    /// Times, s.
    pub time_s: &'a [f64],
    /// Headings, rad, wrapped or not.
    pub heading_rad: &'a [f64],
    /// Rudder angles, rad, each held until the next sample.
    pub rudder_rad: &'a [f64],
}

/// The batch least squares estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BatchEstimate {
    /// From the first sample to the last, half open.
    pub training: Window,
    /// Samples.
    pub samples_used: usize,
    /// Mean interval between samples, s.
    pub interval_s: f64,
    /// Pole of the state variable filter, rad/s.
    pub lambda_rad_s: f64,
    /// The parameters.
    #[serde(flatten)]
    pub model: YawModel<f64>,
}

/// Why there is no batch estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// The columns are no evenly sampled record.
    #[error("{0}")]
    Record(String),
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(#[from] InvalidSetting),
    /// Heading and rudder do not determine three parameters.
    #[error(
        "nothing excites the vehicle: heading and rudder do not determine the three parameters; deflect the rudder to both sides"
    )]
    Unexcited,
}

impl<'a> EvenlySampled<'a> {
    /// The samples in a window. An error where the columns have different lengths.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::identify::evenly_sampled::EvenlySampled;
    ///
    /// let columns = [[0.0, 0.1, 0.2, 0.3]; 3];
    /// let record =
    ///     EvenlySampled { time_s: &columns[0], heading_rad: &columns[1], rudder_rad: &columns[2] };
    /// let part = record.within(Window { from_s: 0.1, to_s: 0.3 })?;
    /// assert_eq!(part.time_s, [0.1, 0.2]);
    /// let uneven = EvenlySampled { rudder_rad: &columns[2][1..], ..record };
    /// assert!(uneven.within(Window::ALL).is_err());
    /// # Ok::<(), seatrial::identify::evenly_sampled::BatchError>(())
    /// ```
    pub fn within(self, window: Window) -> Result<Self, BatchError> {
        self.check_lengths()?;
        let first_at = |time_s: f64| self.time_s.partition_point(|t| *t < time_s);
        let (from, to) = (first_at(window.from_s), first_at(window.to_s));
        Ok(self.part(from..to.max(from)))
    }

    fn check_lengths(&self) -> Result<(), BatchError> {
        let count = self.time_s.len();
        for (name, column) in [("heading", self.heading_rad), ("rudder", self.rudder_rad)] {
            if column.len() != count {
                return Err(BatchError::Record(format!(
                    "{name} has {} values and time has {count}; expected as many",
                    column.len()
                )));
            }
        }
        Ok(())
    }

    fn part(self, range: Range<usize>) -> Self {
        Self {
            time_s: &self.time_s[range.clone()],
            heading_rad: &self.heading_rad[range.clone()],
            rudder_rad: &self.rudder_rad[range],
        }
    }

    /// The least squares solution (34) of the record, filtered at `lambda_rad_s`, rad/s.
    ///
    /// ```text
    /// Theta = (sum phi phi^T)^-1 sum phi psi''_f,   phi = [psi'_f, delta_f, 1]       (32)-(34)
    /// ```
    ///
    /// Source: (16)-(34) with filters from zero state and both signals held between samples, as `--as-paper` has them. For
    /// records of a million samples, which it reads once and of which it keeps nine sums: a damaged or uneven sample is an
    /// error, and there is no interval and no verdict.
    ///
    /// ```
    /// use seatrial::identify::evenly_sampled::EvenlySampled;
    ///
    /// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// # let mut state = seatrial_core::model::YawState::<f64>::default();
    /// # let sample = |k: u32| {
    /// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
    /// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
    /// #     state = vehicle.advance(state, rudder_rad, 0.05);
    /// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
    /// # };
    /// # let record: seatrial::Record = (0..660).map(sample).collect();
    /// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
    /// let column =
    ///     |of: fn(&seatrial::Sample<f64>) -> f64| record.samples.iter().map(of).collect::<Vec<_>>();
    /// let (time_s, heading_rad) = (column(|s| s.time_s), column(|s| s.heading_rad));
    /// let rudder_rad = column(|s| s.rudder_rad);
    /// let even = EvenlySampled { time_s: &time_s, heading_rad: &heading_rad, rudder_rad: &rudder_rad };
    /// let found = even.least_squares(1.0)?;
    /// // The heading held between samples biases it by a few per cent, as in the paper.
    /// assert!((found.model.b2_per_s2 / 1.08 - 1.0).abs() < 0.1);
    /// let shorter = EvenlySampled { rudder_rad: &rudder_rad[1..], ..even };
    /// assert!(shorter.within(seatrial::Window::ALL).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn least_squares(self, lambda_rad_s: f64) -> Result<BatchEstimate, BatchError> {
        self.check_lengths()?;
        let count = self.time_s.len();
        let (Some(first_s), Some(last_s)) = (self.time_s.first(), self.time_s.last()) else {
            return Err(BatchError::Record("no sample lies in the window".into()));
        };
        let interval_s = (last_s - first_s) / (count - 1) as f64;
        let settings = FixedRateSettings { lambda_rad_s, ..FixedRateSettings::paper(interval_s) };
        settings.check()?;
        let mut regression = Regression::new(&settings);
        let mut heading = UnwrappedHeading::default();
        for from in (0..count).step_by(PIECE) {
            let to = (from + PIECE).min(count);
            self.part(from..(to + 1).min(count)).check(from, interval_s)?;
            regression.extend(heading.of(&self.heading_rad[from..to]), &self.rudder_rad[from..to]);
        }
        Ok(BatchEstimate {
            training: Window { from_s: *first_s, to_s: last_s + interval_s },
            samples_used: count,
            interval_s,
            lambda_rad_s,
            model: regression.sums.solve().ok_or(BatchError::Unexcited)?,
        })
    }

    /// Every value finite and the intervals even, or where they are not; `offset` samples stand before.
    fn check(self, offset: usize, interval_s: f64) -> Result<(), BatchError> {
        let tolerance_s = LARGEST_UNEVENNESS * interval_s;
        let is_even =
            |(now, before): (&f64, &f64)| (now - before - interval_s).abs() <= tolerance_s;
        let steps = || self.time_s[1..].iter().zip(self.time_s);
        // Without a way out in the middle, so that several samples are looked at at a time.
        let are_finite = |column: &[f64]| column.iter().fold(true, |all, v| all & v.is_finite());
        let are_even = steps().fold(true, |all, step| all & is_even(step));
        if are_even && are_finite(self.heading_rad) && are_finite(self.rudder_rad) {
            return Ok(());
        }
        for (name, column) in [("heading", self.heading_rad), ("rudder", self.rudder_rad)] {
            if let Some(at) = column.iter().position(|value| !value.is_finite()) {
                return Err(BatchError::Record(format!(
                    "{name} of sample {} is {}; expected a number: leave such samples out, or use an estimate that rejects them",
                    offset + at,
                    column[at]
                )));
            }
        }
        let at = steps().position(|step| !is_even(step)).unwrap_or_default();
        Err(BatchError::Record(format!(
            "sample {} comes {} s after the one before, the mean interval is {} s; expected even intervals: \
             other estimates take samples as they come",
            offset + at + 1,
            three_figures(self.time_s[at + 1] - self.time_s[at]),
            three_figures(interval_s),
        )))
    }
}

/// The filtered signals of a record, summed piece by piece.
struct Regression {
    settings: FixedRateSettings<f64>,
    step: FilterStep<f64>,
    /// Filters of heading and rudder, from the first sample on.
    filters: Option<[StateVariableFilter<f64>; 2]>,
    sums: NormalEquations,
}

impl Regression {
    fn new(settings: &FixedRateSettings<f64>) -> Self {
        let mut step = FilterStep::new(settings.lambda_rad_s);
        step.set_interval(settings.sample_interval_s);
        Self { settings: *settings, step, filters: None, sums: NormalEquations::default() }
    }

    /// Takes in the next samples, rad, the headings unwrapped.
    fn extend(&mut self, heading_rad: &[f64], rudder_rad: &[f64]) {
        let mut samples = heading_rad.iter().zip(rudder_rad);
        let (step, hold) = (self.step, self.settings.heading_hold);
        let row = |heading: &StateVariableFilter<f64>, rudder: &StateVariableFilter<f64>| {
            let regressor = [heading.first_derivative(&step), rudder.smoothed()];
            (regressor, heading.second_derivative(&step))
        };
        let [mut heading, mut rudder] = match self.filters {
            Some(filters) => filters,
            None => {
                let Some((heading_rad, rudder_rad)) = samples.next() else {
                    return;
                };
                let start = self.settings.filter_start;
                let filters = [heading_rad, rudder_rad];
                let [heading, rudder] = filters.map(|w| StateVariableFilter::new(*w, start));
                self.sums.extend(std::iter::once(row(&heading, &rudder)));
                [heading, rudder]
            }
        };
        self.sums.extend(samples.map(|(heading_rad, rudder_rad)| {
            heading.advance(*heading_rad, hold, &step);
            rudder.advance(*rudder_rad, Hold::ZeroOrder, &step);
            row(&heading, &rudder)
        }));
        self.filters = Some([heading, rudder]);
    }
}

/// Headings continued over +-pi from piece to piece.
#[derive(Default)]
struct UnwrappedHeading {
    last_rad: Option<f64>,
    offset_rad: f64,
    buffer: Vec<f64>,
}

impl UnwrappedHeading {
    /// The piece as it stands where it never jumps by more than half a turn.
    fn of<'a>(&'a mut self, piece: &'a [f64]) -> &'a [f64] {
        let last_rad = self.last_rad.unwrap_or(piece[0]);
        self.last_rad = piece.last().copied();
        let steps = piece[1..].iter().zip(piece);
        let within = steps.fold(true, |all, (now, before)| all & ((now - before).abs() <= PI));
        if within && self.offset_rad == 0.0 && (piece[0] - last_rad).abs() <= PI {
            return piece;
        }
        let before = std::iter::once(&last_rad).chain(piece);
        let offset_rad = &mut self.offset_rad;
        self.buffer.clear();
        self.buffer.extend(piece.iter().zip(before).map(|(now, before)| {
            let step = now - before;
            *offset_rad += step.wrapped() - step;
            now + *offset_rad
        }));
        &self.buffer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::model::YawState;

    const TRUTH: [f64; 3] = [-1.07, 1.08, 0.012];
    const INTERVAL_S: f64 = 0.05;

    /// Time, heading and rudder of a noise-free zig-zag of two pieces and a bit.
    fn columns() -> [Vec<f64>; 3] {
        let model = YawModel::from_theta(TRUTH);
        let mut state = YawState::default();
        let mut columns = [vec![], vec![], vec![]];
        for k in 0..2 * PIECE + 700 {
            let rudder_rad = if k % 160 < 80 { 0.26 } else { -0.26 };
            let sample = [k as f64 * INTERVAL_S, state.heading_rad, rudder_rad];
            for (column, value) in columns.iter_mut().zip(sample) {
                column.push(value);
            }
            state = model.advance(state, rudder_rad, INTERVAL_S);
        }
        columns
    }

    fn record(columns: &[Vec<f64>; 3]) -> EvenlySampled<'_> {
        EvenlySampled { time_s: &columns[0], heading_rad: &columns[1], rudder_rad: &columns[2] }
    }

    fn error_of(columns: &[Vec<f64>; 3]) -> String {
        let estimate = record(columns).least_squares(1.5);
        estimate.unwrap_err().to_string()
    }

    #[test]
    fn regress_columns_of_different_lengths_are_an_error() {
        let columns = [vec![0.0; 9], vec![0.0; 9], vec![0.0; 8]];
        let found = record(&columns).least_squares(1.5);
        assert!(matches!(found, Err(BatchError::Record(_))), "{found:?}");
    }

    #[test]
    fn recover_the_model_of_a_wrapped_record() {
        let mut columns = columns();
        let as_it_turned = record(&columns).least_squares(1.5).unwrap();
        for heading in &mut columns[1] {
            *heading = heading.wrapped();
        }
        let wrapped = record(&columns).least_squares(1.5).unwrap();
        let turned = as_it_turned.model.theta();
        for ((found, turned), truth) in wrapped.model.theta().into_iter().zip(turned).zip(TRUTH) {
            // The heading is held between samples, as in the paper: lambda h/2 = 4 %.
            assert!((found - truth).abs() < 0.06 * truth.abs().max(0.2), "{found}");
            // The same record to rounding.
            assert!((found - turned).abs() < 1e-7 * turned.abs(), "{found} {turned}");
        }
    }

    #[test]
    fn exact_a_window_is_its_samples() {
        let columns = columns();
        let window = Window { from_s: 10.0, to_s: 60.0 };
        let within = record(&columns).within(window).unwrap();
        let found = within.least_squares(1.5).unwrap();
        let part = columns.clone().map(|column| column[200..1200].to_vec());
        assert_eq!(found, record(&part).least_squares(1.5).unwrap());
        assert_eq!(found.samples_used, 1000);
    }

    #[test]
    fn regress_what_is_no_even_record_is_refused_with_its_place() {
        let mut late = columns();
        late[0][PIECE] += 0.01;
        assert!(error_of(&late).contains(&format!("sample {PIECE} comes 0.06")));
        let mut missing = columns();
        missing[1][PIECE + 5] = f64::NAN;
        let text = error_of(&missing);
        assert!(text.contains(&format!("heading of sample {} is NaN", PIECE + 5)), "{text}");
        let mut still = columns();
        still[2].fill(0.0);
        still[1].fill(0.3);
        assert_eq!(record(&still).least_squares(1.5), Err(BatchError::Unexcited));
        let [time, heading, mut rudder] = columns();
        rudder.pop();
        let uneven = [time, heading, rudder];
        let all = Window { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };
        assert!(record(&uneven).within(all).is_err());
    }
}

//! The tables: summary, Tables II, III and V of the paper, every run.

use seatrial_core::heading_loop::HeadingLoop;
use seatrial_core::{Axis, HeadingGain, Nomoto, RudderUnit, YawModel};

use super::curves::usable;
use super::headline::Tone;
use super::log_model::LogModel;
use super::number::{
    MISSING, decimals, decimals_or_missing, joined, percent, r2, rudder_unit, significant,
};
use super::speed_figures::{Speed, gain_interval};
use seatrial::campaign::{Campaign, Run, Stage};
use seatrial::gains::DAMPING_RATIO;
use seatrial::identification::{Identification, Intervals, Outcome, Verdict, interval_95};
use seatrial::identify::simplex;
use seatrial::identify::validation::goodness_of_fit;
use seatrial::words::{named_columns, within};

/// A table with a title and a note below it.
pub(super) struct Table {
    pub title: &'static str,
    pub note: String,
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
}

pub(super) struct Column {
    pub name: String,
    /// Empty where there is none.
    pub unit: String,
}

#[derive(Default)]
pub(super) struct Cell {
    pub text: String,
    /// A second, smaller line: the interval.
    pub detail: String,
    /// CSS class.
    pub class: &'static str,
    /// Where a click leads, `#run-3`.
    pub link: String,
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self { text, ..Self::default() }
    }
}

impl Cell {
    pub fn words(text: String) -> Self {
        Self { class: "words", ..Self::from(text) }
    }

    /// A value with its interval on a second line, both with the decimals that the interval's
    /// width deserves.
    fn with_interval(value: f64, interval: Option<[f64; 2]>) -> Self {
        let Some(interval) = interval else {
            return significant(value, 3).into();
        };
        let shown = |value: f64| match value.is_finite() {
            true => within(value, Some(interval)).replace('-', "−"),
            false => MISSING.to_owned(),
        };
        let [low, high] = interval.map(shown);
        Self { detail: format!("{low} … {high}"), ..Self::from(shown(value)) }
    }

    fn verdict(outcome: Outcome) -> Self {
        let tone = Tone::from(outcome);
        Self { class: tone.class(), ..Self::from(format!("{} {}", tone.sign(), outcome.name())) }
    }
}

/// The columns of a heading, `Thrust | Speed [m/s]`: names with units in brackets.
pub(super) fn under(heading: &str) -> Vec<Column> {
    let columns = named_columns(heading);
    columns.map(|(name, unit)| Column { name, unit }).collect()
}

/// The cells of a22, b2, C0 and delta0 of the model that goes to the controller.
fn parameters(identification: &Identification, unit: RudderUnit) -> [Cell; 4] {
    let (scale, _) = rudder_unit(unit);
    let model = identification.model();
    let intervals = identification.refined.as_ref().map(|r| r.interval_95);
    let interval = |of: fn(&Intervals) -> [f64; 2]| intervals.as_ref().map(of);
    let shown = |pair: [f64; 2]| pair.map(|angle| scale * angle);
    [
        Cell::with_interval(model.a22_per_s, interval(|i| i.a22_per_s)),
        Cell::with_interval(model.b2_per_s2, interval(|i| i.b2_per_s2)),
        Cell::with_interval(model.c0_rad_per_s2, interval(|i| i.c0_rad_per_s2)),
        model.delta0_rad().map_or(MISSING.to_owned().into(), |d| {
            let interval = intervals.and_then(|i| i.delta0_rad).map(shown);
            Cell::with_interval(scale * d, interval)
        }),
    ]
}

/// The columns of a summary whose rudder is in this unit. The loop's are known of a trial only.
fn summary_columns(unit: RudderUnit, has_loop: bool) -> Vec<Column> {
    let (_, rudder) = rudder_unit(unit);
    let [authority, nomoto_k, gain] = match unit {
        RudderUnit::Rad => ["1/s²", "1/s", "°/°"],
        RudderUnit::FullRudder => ["1/s² per full rudder", "1/s per full rudder", "full/rad"],
    };
    let of_loop = match has_loop {
        true => " | Phase margin [°] | Gain margin [×] | Overshoot [%]",
        false => "",
    };
    under(&format!(
        "Thrust | Speed [m/s] | Verdict | Nomoto T [s] | Nomoto K [{nomoto_k}] | Damping a₂₂ [1/s] | Authority b₂ [{authority}] | \
         Offset C₀ [rad/s²] | Offset δ₀ [{rudder}] | R² [validation] | Gain Kₚ [{gain}]{of_loop}"
    ))
}

/// The columns of a summary of pitch.
fn pitch_columns() -> Vec<Column> {
    under(
        "Thrust | Speed [m/s] | Verdict | Damping a [1/s] | Restoring m [1/s²] | Authority b [1/s²] | \
            Offset c [rad/s²] | Trim −c/b [°] | R² [validation]",
    )
}

/// a, m, b, c, the elevator that holds the vehicle level, and R^2 of a model of pitch. One that is not to be used has no numbers here.
fn pitch_cells(identification: Option<&Identification>, outcome: Outcome) -> Vec<Cell> {
    let shown = identification.filter(|_| outcome != Outcome::DoNotUse);
    let Some((found, m)) = shown.and_then(|found| Some((found, found.restoring?))) else {
        return std::iter::repeat_with(missing).take(6).collect();
    };
    let model = found.model();
    let intervals = found.refined.as_ref().map(|refined| refined.interval_95);
    let interval = |of: fn(&Intervals) -> [f64; 2]| intervals.as_ref().map(of);
    let trim = |delta0_rad: f64| -delta0_rad.to_degrees();
    let trim_interval =
        intervals.and_then(|i| i.delta0_rad).map(|[low, high]| [trim(high), trim(low)]);
    let validation = found.validation.and_then(|v| v.r2_heading_offset_refit);
    vec![
        Cell::with_interval(model.a22_per_s, interval(|i| i.a22_per_s)),
        Cell::with_interval(m.refined_per_s2, Some(m.interval_95_per_s2)),
        Cell::with_interval(model.b2_per_s2, interval(|i| i.b2_per_s2)),
        Cell::with_interval(model.c0_rad_per_s2, interval(|i| i.c0_rad_per_s2)),
        model
            .delta0_rad()
            .map_or_else(missing, |delta0| Cell::with_interval(trim(delta0), trim_interval)),
        r2(validation).into(),
    ]
}

/// What the columns of pitch mean.
const PITCH_NOTE: &str = "θ'' = a θ' + m θ + b δe + c. Small print below a value: its 95 % interval. Trim is the elevator that holds the vehicle level.";

/// T, K, a22, b2, C0, delta0 and R^2 of a model. One that is not to be used has no numbers here.
fn model_cells(
    identification: Option<&Identification>,
    outcome: Outcome,
    unit: RudderUnit,
) -> Vec<Cell> {
    let shown = identification.filter(|_| outcome != Outcome::DoNotUse);
    let Some(identification) = shown else {
        return std::iter::repeat_with(missing).take(7).collect();
    };
    let nomoto_cell = |of: fn(Nomoto<f64>) -> f64| {
        let interval = identification.refined.as_ref().and_then(|refined| {
            interval_95(&refined.model, &refined.covariance, |model| model.nomoto().map(of))
        });
        let nomoto = identification.nomoto;
        nomoto.map_or_else(missing, |nomoto| Cell::with_interval(of(nomoto), interval))
    };
    let judged = identification.validation.and_then(|v| v.judged_r2_heading());
    let mut cells = vec![nomoto_cell(|nomoto| nomoto.t_s), nomoto_cell(|nomoto| nomoto.k_per_s)];
    cells.extend(parameters(identification, unit));
    cells.push(r2(judged).into());
    cells
}

fn missing() -> Cell {
    MISSING.to_owned().into()
}

/// What the small print of a summary means.
fn summary_note<'a>(mut identifications: impl Iterator<Item = &'a Identification>) -> String {
    let intervals = if identifications.any(|i| i.refined.is_some()) {
        "Small print below a value: its 95 % interval."
    } else {
        "These are live estimates without intervals."
    };
    format!("{intervals} Kₚ gives no more than about 5 % overshoot (damping ratio 0.71).")
}

/// What the columns of the control loop mean.
const LOOP_NOTE: &str = "Rudder = Kₚ (wanted heading − heading) + feed-forward, within the rudder limit; the feed-forward is −δ₀. Kₚ allows for a \
     sample of delay, the hold over a sample and a rudder lag that the record tells, and for the least damped model of the 95 % interval. Margins \
     count the same delays: the gain may grow by the gain margin before the loop is unstable.";

/// One line per thrust: the run that decides about it, with what goes into the autopilot.
pub(super) fn summary(campaign: &Campaign, whole: &Verdict, speeds: &[Speed]) -> Table {
    let runs = campaign.deciding_runs();
    let note = summary_note(runs.iter().filter_map(|run| run.identification.as_ref()));
    let rows = runs.into_iter().map(|run| {
        let outcome = run.verdict_within(whole).outcome();
        let mut row = vec![
            Cell { link: run_anchor(run), ..percent(run.thrust).into() },
            decimals_or_missing(run.surge_speed_m_s, 2).into(),
            Cell::verdict(outcome),
        ];
        let identification = run.identification.as_ref();
        if campaign.axis == Axis::Pitch {
            row.extend(pitch_cells(identification, outcome));
            return row;
        }
        row.extend(model_cells(identification, outcome, RudderUnit::Rad));
        let speed = speeds.iter().find(|speed| std::ptr::eq(speed.run, run));
        row.extend(loop_cells(speed));
        row
    });
    Table {
        title: "Summary",
        note: match campaign.axis {
            Axis::Pitch => PITCH_NOTE.to_owned(),
            Axis::Yaw if speeds.is_empty() => note,
            Axis::Yaw => format!("{note} {LOOP_NOTE}"),
        },
        rows: rows.collect(),
        columns: match campaign.axis {
            Axis::Yaw => summary_columns(RudderUnit::Rad, true),
            Axis::Pitch => pitch_columns(),
        },
    }
}

/// K_p with the margins and the overshoot that it gives.
fn loop_cells(speed: Option<&Speed>) -> [Cell; 4] {
    let gain = speed.and_then(|speed| Some((speed, speed.gain?.proportional_gain)));
    let margins = speed.and_then(|speed| speed.margins);
    let phase = margins.and_then(|m| m.phase_margin_rad);
    let overshoot = gain
        .and_then(|(speed, gain)| HeadingLoop::new(&speed.point.model, gain).ok())
        .map(|closed| 100.0 * closed.overshoot());
    [
        gain.map_or_else(missing, |(speed, gain)| Cell {
            class: "strong",
            ..gain_cell(speed, gain)
        }),
        decimals_or_missing(phase.map(f64::to_degrees), 0).into(),
        decimals_or_missing(margins.and_then(|m| m.gain_margin), 1).into(),
        decimals_or_missing(overshoot, 1).into(),
    ]
}

/// One line for each model of a log.
pub(super) fn log_summary(models: &[LogModel], unit: RudderUnit, axis: Axis) -> Table {
    let identifications = models.iter().filter_map(|model| model.identification);
    // Few logs say the thrust: then there is no column for it.
    let first = usize::from(models.iter().all(|model| model.thrust.is_none()));
    let rows = models.iter().map(|model| {
        let thrust = model.thrust.map_or_else(|| MISSING.to_owned(), percent);
        let mut row = vec![
            thrust.into(),
            decimals_or_missing(model.surge_speed_m_s, 2).into(),
            Cell::verdict(model.outcome),
        ];
        if axis == Axis::Pitch {
            row.extend(pitch_cells(model.identification, model.outcome));
            return row.split_off(first);
        }
        row.extend(model_cells(model.identification, model.outcome, unit));
        let is_usable = model.outcome != Outcome::DoNotUse;
        let gain = model.gain().filter(|_| is_usable);
        row.push(gain.map_or_else(missing, |gain| significant(gain, 3).into()));
        row.split_off(first)
    });
    Table {
        title: "Summary",
        note: match axis {
            Axis::Yaw => summary_note(identifications),
            Axis::Pitch => PITCH_NOTE.to_owned(),
        },
        rows: rows.collect(),
        columns: match axis {
            Axis::Yaw => summary_columns(unit, false).split_off(first),
            Axis::Pitch => pitch_columns().split_off(first),
        },
    }
}

fn gain_cell(speed: &Speed, gain: f64) -> Cell {
    Cell::with_interval(gain, gain_interval(speed))
}

pub(super) fn run_anchor(run: &Run) -> String {
    format!("#run-{}", run.number)
}

/// The cells of a model as the paper's Tables II, III and V print it.
fn as_printed(model: &YawModel<f64>) -> Vec<Cell> {
    vec![
        decimals(model.a22_per_s, 2).into(),
        decimals(model.b2_per_s2, 2).into(),
        decimals(model.c0_rad_per_s2, 4).into(),
        decimals_or_missing(model.delta0_rad().map(f64::to_degrees), 2).into(),
    ]
}

const AS_PRINTED: &str =
    "Thrust [%] | Speed [m/s] | a₂₂ [1/s] | b₂ [1/s²] | C₀ [rad/s²] | δ₀ [°] | R² [validation]";

fn thrust_and_speed(speed: &Speed) -> Vec<Cell> {
    vec![
        decimals(100.0 * speed.run.thrust, 0).into(),
        decimals_or_missing(speed.run.surge_speed_m_s, 2).into(),
    ]
}

fn validation_r2(speed: &Speed, model: &YawModel<f64>) -> Cell {
    let window = speed.run.stage(Stage::Validate);
    let samples = window.map(|window| speed.run.record.window(window));
    r2(samples.and_then(|s| goodness_of_fit(*model, s).r2_heading)).into()
}

/// Table II: the estimate made sample by sample on the vehicle.
pub(super) fn online(speeds: &[Speed]) -> Table {
    let rows = speeds.iter().map(|speed| {
        let model = &speed.identification.online.model;
        let mut row = thrust_and_speed(speed);
        row.extend(as_printed(model));
        row.push(validation_r2(speed, model));
        row.push(decimals_or_missing(speed.identification.online.convergence.detected_s, 1).into());
        row
    });
    Table {
        title: "Live estimates",
        note: "As Table II of the paper: what the vehicle knew at the end of each training stage, estimated sample by sample.".to_owned(),
        rows: rows.collect(),
        columns: under(&format!("{AS_PRINTED} | At rest after [s]")),
    }
}

/// Table III: the paper's offline method on the same training records.
pub(super) fn offline(speeds: &[Speed]) -> Table {
    let rows = speeds.iter().filter_map(|speed| {
        let window = speed.identification.training;
        let samples = usable(speed.run.record.window(window));
        let minimum = simplex::fit_as_paper(&samples)?;
        let model = YawModel::from_theta(minimum.at);
        let mut row = thrust_and_speed(speed);
        row.extend(as_printed(&model));
        row.push(validation_r2(speed, &model));
        row.push(minimum.iterations.to_string().into());
        Some(row)
    });
    Table {
        title: "Offline simplex search",
        note: "As Table III of the paper: the conventional method, a simplex search from zero over whole simulations of the same training records. \
               It should agree with the live estimates; it is printed for comparison only and goes nowhere."
            .to_owned(),
        rows: rows.collect(),
        columns: under(&format!("{AS_PRINTED} | Iterations")),
    }
}

/// The gain to load beside the one that Table V of the paper prints.
pub(super) fn gains_of_paper(speeds: &[Speed]) -> Table {
    let rows = speeds.iter().map(|speed| {
        let mut row = thrust_and_speed(speed);
        let gain = speed.gain.map(|gain| gain.proportional_gain);
        row.push(decimals_or_missing(gain, 2).into());
        let paper = HeadingGain::design(&speed.point.model, DAMPING_RATIO).ok();
        row.push(decimals_or_missing(paper.map(|g| g.proportional_gain), 2).into());
        row
    });
    Table {
        title: "The paper’s gain",
        note: "Equation (57) allows neither for delay nor for what the interval leaves open."
            .to_owned(),
        rows: rows.collect(),
        columns: under("Thrust [%] | Speed [m/s] | Kₚ [°/°] | Kₚ (57) [°/°]"),
    }
}

/// Every run with its reasons.
pub(super) fn runs(campaign: &Campaign, whole: &Verdict) -> Table {
    let rows = campaign.runs.iter().map(|run| {
        let duration = run.record.samples.first().zip(run.record.samples.last());
        let duration = duration.map(|(first, last)| last.time_s - first.time_s);
        vec![
            Cell { link: run_anchor(run), ..run.number.to_string().into() },
            percent(run.thrust).into(),
            run.attempt.to_string().into(),
            decimals_or_missing(run.surge_speed_m_s, 2).into(),
            decimals_or_missing(duration, 1).into(),
            run.record.samples.len().to_string().into(),
            Cell::verdict(run.verdict_within(whole).outcome()),
            Cell::words(joined(&run.reasons_within(whole))),
        ]
    });
    Table {
        title: "Every run",
        note: "In the order in which they were made, rejected and repeated ones included."
            .to_owned(),
        rows: rows.collect(),
        columns: under(
            "Run | Thrust | Attempt | Speed [m/s] | Duration [s] | Samples | Verdict | Why",
        ),
    }
}

//! Tables II, III and V again, from simulated trials of vehicles that have the paper's values for truth.

use std::fmt::Write as _;

use seatrial::campaign::{Campaign, Run};
use seatrial::identify::simplex;
use seatrial::identify::validation::validate;
use seatrial::verdict::three_figures;
use seatrial_core::heading_control::HeadingGain;
use seatrial_core::{Plan, YawModel};
use seatrial_sim::plant::SpeedPoint;
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
use serde::Serialize;

use super::tables::{Row, TABLE_II, TABLE_III, TABLE_III_ITERATIONS, TABLE_V};
use crate::trials::order::rehearse;

/// Seeds of the trials: of Tables II and III, of Table V, and of its repeated run.
const SEEDS: [u64; 3] = [1, 2, 3];

/// Row of Table V that repeats the thrust of the row before.
const REPEATED: usize = 3;

/// A table of the paper, identified again.
#[derive(Serialize)]
pub struct RecreatedTable {
    /// Number in the paper.
    pub table: &'static str,
    /// What was done.
    pub about: &'static str,
    /// One row for each of the paper's.
    pub rows: Vec<RecreatedRow>,
}

/// One row: the truth given to the simulated vehicle, and what came back.
#[derive(Serialize)]
pub struct RecreatedRow {
    /// Thrust, percent.
    pub thrust_percent: u32,
    /// Steady speed found, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The truth: the values that the paper identified.
    pub truth: YawModel<f64>,
    /// The estimate.
    pub estimate: YawModel<f64>,
    /// Its 95 % intervals of a22, b2 and C0; none for the simplex.
    pub interval_95: Option<[[f64; 2]; 3]>,
    /// R^2 of heading on validation data as printed, and here.
    pub r2_printed: f64,
    /// R^2 of heading on validation data here.
    pub r2: Option<f64>,
    /// Iterations as printed and here, Table III.
    pub iterations: Option<[u32; 2]>,
    /// K_p of the estimate, Table V.
    pub proportional_gain: Option<f64>,
}

/// Tables of the paper that no vehicle or no plan can be made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecreationError {
    /// The vehicle.
    #[error(transparent)]
    Vehicle(#[from] seatrial_sim::ConfigError),
    /// The plan.
    #[error(transparent)]
    Plan(#[from] seatrial_core::InvalidSetting),
}

/// Runs the trials.
pub fn tables() -> Result<Vec<RecreatedTable>, RecreationError> {
    let first = trial(&TABLE_II, SEEDS[0])?;
    let (repeat, others): (Vec<_>, Vec<_>) =
        TABLE_V.iter().enumerate().partition(|(i, _)| *i == REPEATED);
    let rows = |rows: Vec<(usize, &Row)>| rows.into_iter().map(|(_, row)| *row).collect::<Vec<_>>();
    let (repeat, others) = (rows(repeat), rows(others));
    let mut fifth = refined_rows(&trial(&others, SEEDS[1])?, &others);
    fifth.extend(refined_rows(&trial(&repeat, SEEDS[2])?, &repeat));
    fifth.sort_by_key(|row| row.thrust_percent);
    Ok(vec![
        RecreatedTable {
            table: "II",
            about: "A trial of sim:starfish, whose truth is Table II; the refined estimates.",
            rows: refined_rows(&first, &TABLE_II),
        },
        RecreatedTable {
            table: "III",
            about: "The paper's simplex search on the training records of that trial; the truth is still Table II.",
            rows: simplex_rows(&first),
        },
        RecreatedTable {
            table: "V",
            about: "A trial of a vehicle whose truth is Table V, the second run at 80 % a trial of its own.",
            rows: fifth,
        },
    ])
}

/// A trial of a vehicle with these rows for truth, at their thrusts.
fn trial(truth: &[Row], seed: u64) -> Result<Campaign, RecreationError> {
    let speeds = truth
        .iter()
        .map(|row| SpeedPoint {
            thrust: f64::from(row.thrust_percent) / 100.0,
            surge_speed_m_s: row.surge_speed_m_s,
            a22_per_s: row.a22_per_s,
            b2_per_s2: row.b2_per_s2,
            c0_rad_per_s2: row.c0_rad_per_s2,
        })
        .collect::<Vec<_>>();
    let mut plan = Plan::paper();
    let thrusts: Vec<f64> = speeds.iter().map(|speed| speed.thrust).collect();
    plan.thrusts = seatrial_core::List::from_slice(&thrusts).unwrap_or_default();
    let config = VehicleConfig { initial_thrust: thrusts[0], speeds, ..VehicleConfig::starfish() };
    let mut vehicle = FirstOrderVehicle::new(config, seed)?;
    Ok(rehearse(&mut vehicle, "sim", seed, plan)?.campaign)
}

fn refined_rows(campaign: &Campaign, truth: &[Row]) -> Vec<RecreatedRow> {
    let row_of = |run: &&Run| -> Option<RecreatedRow> {
        let identification = run.identification.as_ref()?;
        let refined = identification.refined.as_ref()?;
        let truth = truth.iter().find(|row| is_at(row, run))?;
        let interval = &refined.interval_95;
        Some(RecreatedRow {
            interval_95: Some([interval.a22_per_s, interval.b2_per_s2, interval.c0_rad_per_s2]),
            r2: identification.validation.and_then(|v| v.r2_heading),
            ..row(run, truth, refined.model)
        })
    };
    campaign.accepted_runs().iter().filter_map(row_of).collect()
}

fn simplex_rows(campaign: &Campaign) -> Vec<RecreatedRow> {
    let row_of = |run: &&Run| -> Option<RecreatedRow> {
        let identification = run.identification.as_ref()?;
        let index = TABLE_II.iter().position(|row| is_at(row, run))?;
        let minimum = simplex::fit_as_paper(&run.record.usable(identification.training))?;
        let model = YawModel::from_theta(minimum.at);
        let window = identification.validation?.window;
        Some(RecreatedRow {
            r2_printed: TABLE_III[index].r2,
            r2: validate(model, &run.record, window).ok()?.r2_heading,
            iterations: Some([TABLE_III_ITERATIONS[index], minimum.iterations]),
            ..row(run, &TABLE_II[index], model)
        })
    };
    campaign.accepted_runs().iter().filter_map(row_of).collect()
}

fn is_at(row: &Row, run: &Run) -> bool {
    f64::from(row.thrust_percent) / 100.0 == run.thrust
}

fn row(run: &Run, truth: &Row, estimate: YawModel<f64>) -> RecreatedRow {
    RecreatedRow {
        thrust_percent: truth.thrust_percent,
        surge_speed_m_s: run.surge_speed_m_s,
        truth: YawModel::from_theta([truth.a22_per_s, truth.b2_per_s2, truth.c0_rad_per_s2]),
        estimate,
        interval_95: None,
        r2_printed: truth.r2,
        r2: None,
        iterations: None,
        proportional_gain: HeadingGain::design(&estimate, core::f64::consts::FRAC_1_SQRT_2)
            .ok()
            .map(|gain| gain.proportional_gain),
    }
}

/// True parameters that lie inside their 95 % interval, of all that have one.
pub fn covered(tables: &[RecreatedTable]) -> (usize, usize) {
    let inside = |row: &RecreatedRow| -> Vec<bool> {
        let intervals = row.interval_95.iter().flatten();
        intervals
            .zip(row.truth.theta())
            .map(|([low, high], truth)| (*low..=*high).contains(&truth))
            .collect()
    };
    let all: Vec<bool> = tables.iter().flat_map(|t| &t.rows).flat_map(inside).collect();
    (all.iter().filter(|covered| **covered).count(), all.len())
}

/// The tables in Markdown.
pub fn markdown(tables: &[RecreatedTable]) -> String {
    let mut text = String::from(
        "\n## Tables II, III and V re-created\n\n\
         Simulated trials of vehicles whose truth is what the paper identified, under this simulator's noise and \
         disturbance, not those of the reservoir. Each cell is the estimate with its 95 % interval, the truth in \
         parentheses.\n",
    );
    for table in tables {
        let _ = write!(
            text,
            "\n### Table {}\n\n{}\n\n| thrust % | speed m/s | a22 1/s | b2 1/s^2 | C0 rad/s^2 | R^2 (printed) | K_p | iterations (printed) |\n|---:|---:|---|---|---|---|---:|---|\n",
            table.table, table.about
        );
        for row in &table.rows {
            let cell = |i: usize| {
                let interval = row.interval_95.map_or_else(String::new, |intervals| {
                    let [low, high] = intervals[i].map(three_figures);
                    format!(", {low} to {high}")
                });
                format!(
                    "{}{interval} ({})",
                    three_figures(row.estimate.theta()[i]),
                    row.truth.theta()[i]
                )
            };
            let number = |value: Option<f64>, digits: usize| {
                value.map_or_else(String::new, |value| format!("{value:.digits$}"))
            };
            let iterations = row
                .iterations
                .map_or_else(String::new, |[printed, here]| format!("{here} ({printed})"));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} ({}) | {} | {iterations} |",
                row.thrust_percent,
                number(row.surge_speed_m_s, 2),
                cell(0),
                cell(1),
                cell(2),
                number(row.r2, 3),
                row.r2_printed,
                number(row.proportional_gain, 2),
            );
        }
    }
    text
}

/// The tables as CSV, one line for each row.
pub fn csv(tables: &[RecreatedTable]) -> String {
    let mut text = String::from(
        "table,thrust_percent,surge_speed_m_s,parameter,truth,estimate,low_95,high_95,r2_printed,r2\n",
    );
    for table in tables {
        for row in &table.rows {
            for (i, name) in ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"].iter().enumerate() {
                let bound = |side: usize| {
                    row.interval_95
                        .map_or_else(String::new, |intervals| intervals[i][side].to_string())
                };
                let optional =
                    |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
                let _ = writeln!(
                    text,
                    "{},{},{},{name},{},{},{},{},{},{}",
                    table.table,
                    row.thrust_percent,
                    optional(row.surge_speed_m_s),
                    row.truth.theta()[i],
                    row.estimate.theta()[i],
                    bound(0),
                    bound(1),
                    row.r2_printed,
                    optional(row.r2)
                );
            }
        }
    }
    text
}

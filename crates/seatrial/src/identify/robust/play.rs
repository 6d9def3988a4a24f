//! A rudder with play: its fin follows the command only when the slack of the linkage is taken up.

use super::hypothesis::Hypothesis;
use super::linearised::COLUMNS;
use super::misfit::left;
use super::noise::whitened_products;
use super::record::{B2, DELAY, FIRST, LAG2, PARAMETERS, Record};
use crate::likelihood::leg::fin_behind;

/// Plays that are looked for, from stop to stop, in amplitudes of the rudder.
pub const PLAYS: [f64; 6] = [0.02, 0.05, 0.1, 0.15, 0.25, 0.4];

/// Columns of parameters, the residual, and what each play adds.
const ALL: usize = COLUMNS + PLAYS.len();

/// Twice the log of how much likelier a record must be with play: a first look, before the record is held against both in full.
pub const LIKELIER: f64 = 12.0;

/// The play from stop to stop, rad, that makes a record likeliest under one lag and disturbance. `None` where none makes it clearly likelier.
///
/// ```text
/// 2 log L(p) - 2 log L(0) = (RSS_0 - RSS_p) / sigma^2,   psi_p = psi + b2 G (fin_p - u)
/// ```
///
/// G turns rudder into heading; RSS is what the linearised, whitened record leaves once all parameters are fitted.
pub fn likely_play_rad(record: &Record, block: usize, hypothesis: &Hypothesis) -> Option<f64> {
    let peak = &hypothesis.peak;
    let around = record.linearised(&peak.point, block, peak.prompt);
    let point = &peak.point;
    let fins = PLAYS.map(|share| {
        let fin_rad = fin_behind(&record.rudder_rad, share * record.amplitude_rad);
        record.mean_rudder_responses(&fin_rad, &point.dynamics(), block)
    });
    let rows = around.rows.iter().enumerate().map(|(k, row)| {
        let mut all = [0.0; ALL];
        let (of_record, of_plays) = all.split_at_mut(COLUMNS);
        of_record.copy_from_slice(row);
        for (of_play, fin) in of_plays.iter_mut().zip(&fins) {
            *of_play = point.0[B2] * (fin[k] - row[B2]);
        }
        all
    });
    let (products, _) = whitened_products(&around.time_s, rows, &peak.noise);
    let held: &[usize] = match peak.prompt {
        true => &[FIRST, DELAY, LAG2],
        false => &[FIRST, LAG2],
    };
    let none = left(&of_fin(&products, None), held)?;
    let variance = peak.noise_rad * peak.noise_rad;
    let plays = PLAYS.iter().enumerate().filter_map(|(i, share)| {
        let with_play = left(&of_fin(&products, Some(COLUMNS + i)), held)?;
        Some(((none - with_play) / variance, share * record.amplitude_rad))
    });
    let (likelier, play_rad) = plays.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (likelier > LIKELIER).then_some(play_rad)
}

/// Products of the parameters' columns and the residual, which is less by what a play adds.
fn of_fin(products: &[[f64; ALL]; ALL], play: Option<usize>) -> [[f64; COLUMNS]; COLUMNS] {
    let of = |i: usize, j: usize| products[i.min(j)][i.max(j)];
    let mut of_fin: [[f64; COLUMNS]; COLUMNS] =
        core::array::from_fn(|i| core::array::from_fn(|j| of(i, j)));
    let Some(play) = play else { return of_fin };
    for (i, row) in of_fin.iter_mut().enumerate() {
        row[PARAMETERS] -= of(i, play);
    }
    of_fin[PARAMETERS][PARAMETERS] += of(play, play) - of(PARAMETERS, play);
    of_fin
}

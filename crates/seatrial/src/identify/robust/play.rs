//! A rudder with play: its fin follows the command only when the slack of the linkage is taken up.

use super::average::Hypothesis;
use super::linearised::COLUMNS;
use super::noise::whiten;
use super::record::{A22, B2, C0, DELAY, HEADING, PARAMETERS, RATE, Record};
use super::symmetric::invert;

/// Plays that are looked for, from stop to stop, in amplitudes of the rudder.
const PLAYS: [f64; 6] = [0.02, 0.05, 0.1, 0.15, 0.25, 0.4];

/// Columns of parameters, the residual, and what each play adds.
const ALL: usize = COLUMNS + PLAYS.len();

/// Twice the log of how much likelier a record must be with play: a first look, before the record is held against both in full.
const LIKELIER: f64 = 12.0;

/// The fin behind play, rad: at rest it stands where the first command is.
///
/// ```text
/// f_k = min(max(f_(k-1), u_k - p/2), u_k + p/2),   f_0 = u_0
/// ```
pub fn fin_behind(rudder_rad: &[f64], play_rad: f64) -> Vec<f64> {
    let half_rad = 0.5 * play_rad;
    let mut fin_rad = rudder_rad.first().copied().unwrap_or(0.0);
    (rudder_rad.iter())
        .map(|command_rad| {
            fin_rad = fin_rad.clamp(command_rad - half_rad, command_rad + half_rad);
            fin_rad
        })
        .collect()
}

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
    let added: Vec<Vec<f64>> = (PLAYS.iter())
        .map(|share| added_heading_rad(record, block, hypothesis, share * record.amplitude_rad))
        .collect();
    let mut rows: Vec<[f64; ALL]> = (around.rows.iter().enumerate())
        .map(|(k, row)| {
            core::array::from_fn(|j| match j.checked_sub(COLUMNS) {
                None => row[j],
                Some(play) => added[play][k],
            })
        })
        .collect();
    whiten(&around.time_s, &mut rows, &peak.noise);
    let mut gram = [[0.0; ALL]; ALL];
    for row in &rows {
        for i in 0..ALL {
            for j in 0..ALL {
                gram[i][j] += row[i] * row[j];
            }
        }
    }
    let free: &[usize] = match peak.prompt {
        true => &[B2, C0, HEADING, RATE, A22],
        false => &[B2, C0, HEADING, RATE, A22, DELAY],
    };
    let variance = peak.noise_rad * peak.noise_rad;
    let none = left(&gram, free, None, variance)?;
    let plays = PLAYS.iter().enumerate().filter_map(|(i, share)| {
        let likelier = (none - left(&gram, free, Some(COLUMNS + i), variance)?) / variance;
        Some((likelier, share * record.amplitude_rad))
    });
    let (likelier, play_rad) = plays.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (likelier > LIKELIER).then_some(play_rad)
}

/// What a play adds to the heading of each comparison, rad.
fn added_heading_rad(
    record: &Record,
    block: usize,
    hypothesis: &Hypothesis,
    play_rad: f64,
) -> Vec<f64> {
    let point = &hypothesis.peak.point;
    let b2_per_s2 = point.0[B2];
    let fin = record.with_rudder(fin_behind(&record.rudder_rad, play_rad));
    let of = |record: &Record| record.mean_responses(&point.dynamics(), block);
    (of(&fin).iter().zip(of(record)))
        .map(|(fin, command)| b2_per_s2 * (fin[B2] - command[B2]))
        .collect()
}

/// Sum of squares that the parameters leave of the residual less one column.
fn left(
    gram: &[[f64; ALL]; ALL],
    free: &[usize],
    less: Option<usize>,
    variance: f64,
) -> Option<f64> {
    let residual = |i: usize| gram[i][PARAMETERS] - less.map_or(0.0, |less| gram[i][less]);
    let mut information = [[0.0; PARAMETERS]; PARAMETERS];
    for i in 0..PARAMETERS {
        match free.contains(&i) {
            true => free.iter().for_each(|&j| information[i][j] = gram[i][j]),
            false => information[i][i] = variance,
        }
    }
    let (inverse, _) = invert(&information)?;
    let explained: f64 = (free.iter())
        .map(|&i| {
            free.iter()
                .map(|&j| residual(i) * inverse[i][j] * residual(j))
                .sum::<f64>()
        })
        .sum();
    let square =
        residual(PARAMETERS) - less.map_or(0.0, |less| gram[less][PARAMETERS] - gram[less][less]);
    Some(square - explained)
}

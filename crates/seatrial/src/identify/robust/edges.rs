//! What the unknown times of the rudder's movements leave uncertain.

use super::hypothesis::Hypothesis;
use super::noise::whiten;
use super::record::{A22, B2, C0, DELAY, PARAMETERS, Record};
use super::response::gains;

/// The largest movements count: smaller ones add nothing.
const MOST_EDGES: usize = 200;

/// Movements that are whitened together.
const TOGETHER: usize = 8;

/// Covariance of a22, b2 and C0 from a rudder that is renewed less often than the record has rows.
///
/// ```text
/// P = (H^2 - h^2)/12 sum_i g_i g_i^T,   g_i = d theta / d t_i
/// ```
///
/// | symbol | meaning |
/// |---|---|
/// | H, h | interval at which the rudder is renewed, and the sample interval, s |
/// | t_i | time of the rudder's i-th movement, unknown to H; to h it is within the record's own timing |
pub fn of_edges(record: &Record, hypothesis: &Hypothesis, block: usize) -> [[f64; 3]; 3] {
    let variance_s2 = (record.timing_s.powi(2) - record.interval_s.powi(2)) / 12.0;
    if variance_s2 <= 0.0 {
        return [[0.0; 3]; 3];
    }
    let peak = &hypothesis.peak;
    let around = record.linearised(&peak.point, block, peak.prompt);
    let mut rows = around.rows;
    whiten(&around.time_s, &mut rows, &peak.noise);
    let covariance_here = peak.covariance_at_the_point();
    let precision = 1.0 / (peak.noise_rad * peak.noise_rad);
    let influences: Vec<[f64; 3]> = (rows.iter())
        .map(|row| {
            [A22, B2, C0].map(|i| {
                let of_row = (0..PARAMETERS).map(|j| covariance_here[i][j] * row[j]);
                precision * of_row.sum::<f64>()
            })
        })
        .collect();
    let point = &peak.point.0;
    let mut covariance = [[0.0; 3]; 3];
    for edges in edges(record).chunks(TOGETHER) {
        let response = |time_s: &f64| -> [f64; TOGETHER] {
            core::array::from_fn(|e| {
                let (at_s, step_rad) = edges.get(e).copied().unwrap_or((f64::INFINITY, 0.0));
                let since_s = time_s - at_s - point[DELAY];
                match since_s > 0.0 {
                    true => point[B2] * step_rad * gains(point[A22], since_s).0,
                    false => 0.0,
                }
            })
        };
        let mut responses: Vec<_> = around.time_s.iter().map(response).collect();
        whiten(&around.time_s, &mut responses, &peak.noise);
        for e in 0..edges.len() {
            let moved: [f64; 3] = core::array::from_fn(|i| {
                let terms = influences.iter().zip(&responses);
                terms.map(|(influence, r)| influence[i] * r[e]).sum()
            });
            for (i, row) in covariance.iter_mut().enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum += variance_s2 * moved[i] * moved[j];
                }
            }
        }
    }
    covariance
}

/// Time, s, and size, rad, of the largest movements of the rudder.
fn edges(record: &Record) -> Vec<(f64, f64)> {
    let pairs = record.rudder_rad.windows(2).zip(&record.time_s[1..]);
    let mut edges: Vec<(f64, f64)> = pairs
        .map(|(pair, time_s)| (*time_s, pair[1] - pair[0]))
        .filter(|(_, step_rad)| *step_rad != 0.0)
        .collect();
    edges.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    edges.truncate(MOST_EDGES);
    edges
}

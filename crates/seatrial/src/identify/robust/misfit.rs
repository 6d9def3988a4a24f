//! What a first-order model leaves that a hull, not the sea, would explain.

use super::hypothesis::Hypothesis;
use super::linearised::COLUMNS;
use super::noise::whitened_products;
use super::record::{PARAMETERS, Record};
use super::response::{Dynamics, responses};
use super::symmetric::Factorisation;

/// Columns of the hull: cross-flow damping r|r| and two sways that follow the yaw rate.
const HULL: usize = 3;

/// Time constants of the sways, in time constants of the vehicle.
const SWAYS: [f64; 2] = [0.5, 2.0];

/// Columns of parameters and hull, and the residual.
const ALL: usize = COLUMNS + HULL;

/// Chi-square of three parameters for what a hull adds to a first-order model, under one lag and disturbance (a score test).
///
/// ```text
/// r' = a22 r + b2 delta_a + C0 + d + sum c_i h_i,   h = r|r|, r low-passed at T/2, r low-passed at 2T;   H0: c = 0
/// chi2 = (RSS_0 - RSS_c) / (RSS_c / (n - p)) of the whitened, linearised record
/// ```
///
/// r is the simulated yaw rate. A disturbance of the sea knows nothing of it: 99.9 % of chi2 are under 16.3. `None` where the columns are
/// not independent.
pub fn of_the_hull(record: &Record, block: usize, hypothesis: &Hypothesis) -> Option<f64> {
    let point = &hypothesis.peak.point;
    let prompt = hypothesis.peak.prompt;
    let around = record.linearised(point, block, prompt);
    let hull = hull_columns(record, &point.dynamics(), &record.simulate(point));
    let share = 1.0 / block as f64;
    let rows = around.rows.iter().enumerate().map(|(i, row)| -> [f64; ALL] {
        core::array::from_fn(|j| match j {
            0..PARAMETERS => row[j],
            PARAMETERS..COLUMNS => row[j],
            _ => hull[j - COLUMNS][i * block..(i + 1) * block].iter().sum::<f64>() * share,
        })
    });
    let (products, _) = whitened_products(&around.time_s, rows, &hypothesis.peak.noise);
    let held: &[usize] = if prompt { &[4, 6, 7] } else { &[4] };
    let with = left(&products, held)?;
    let held: Vec<usize> = held.iter().copied().chain(COLUMNS..ALL).collect();
    let without = left(&products, &held)?;
    let free = around.rows.len() as f64 - ALL as f64;
    Some((without - with) / (with / free))
}

/// Responses of the heading to what a hull adds.
fn hull_columns(record: &Record, dynamics: &Dynamics, heading_rad: &[f64]) -> [Vec<f64>; HULL] {
    let time_s = &record.time_s;
    let mut rate_rad_s: Vec<f64> = (heading_rad.windows(2).zip(time_s.windows(2)))
        .map(|(psi, t)| (psi[1] - psi[0]) / (t[1] - t[0]))
        .collect();
    rate_rad_s.push(rate_rad_s.last().copied().unwrap_or(0.0));
    let prompt = Dynamics { lag_s: 0.0, shift_s: 0.0, ..*dynamics };
    let response = |input: &[f64]| -> Vec<f64> {
        let rows = responses(time_s, input, &prompt);
        rows.iter().map(|row| row[0]).collect()
    };
    let scale = record.rate_scale(dynamics.a22_per_s);
    let [quick, slow] = SWAYS.map(|sway| {
        let time_constant_s = sway / scale;
        let mut now = rate_rad_s.first().copied().unwrap_or(0.0);
        let steps = rate_rad_s.iter().zip(time_s.windows(2));
        let mut low: Vec<f64> = steps
            .map(|(rate, t)| {
                let before = now;
                now = rate + (now - rate) * libm::exp(-(t[1] - t[0]) / time_constant_s);
                before
            })
            .collect();
        low.push(now);
        response(&low)
    });
    let square: Vec<f64> = rate_rad_s.iter().map(|r| r * r.abs()).collect();
    [response(&square), quick, slow]
}

/// Sum of squares that the columns but the held ones leave of the residual in column `PARAMETERS`, from the products of all, of which those
/// with i <= j count. `None` where they are not independent.
pub fn left<const N: usize>(products: &[[f64; N]; N], held: &[usize]) -> Option<f64> {
    let is_free = |i: usize| i != PARAMETERS && !held.contains(&i);
    let of = |i: usize, j: usize| products[i.min(j)][i.max(j)];
    let information: [[f64; N]; N] = core::array::from_fn(|i| {
        core::array::from_fn(|j| match is_free(i) && is_free(j) {
            true => of(i, j),
            false => f64::from(u8::from(i == j)),
        })
    });
    let right = core::array::from_fn(|i| match is_free(i) {
        true => of(i, PARAMETERS),
        false => 0.0,
    });
    let explained = Factorisation::of(&information)?.square_of(&right);
    Some(of(PARAMETERS, PARAMETERS) - explained)
}

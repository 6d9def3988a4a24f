//! An estimator of one's own: the model integrated twice, so that nothing is differentiated.
//!
//! ```text
//! psi'' = a22 psi' + b2 delta + C0
//! psi = psi_0 + r_0 t + a22 I(psi - psi_0) + b2 I(I(delta)) + C0 t^2/2
//! ```
//!
//! | symbol | identifier | unit | positive |
//! |---|---|---|---|
//! | psi | `heading_rad` | rad | to starboard |
//! | delta | `rudder_rad` | rad | to starboard |
//! | a22, b2, C0 | `YawModel` | 1/s, 1/s^2, rad/s^2 | |
//! | I | the integral from the first sample on | | |
//!
//! Least squares of this line over the samples of a manoeuvre, linear in a22, b2, C0, r_0 and psi_0, which need not be the first heading.
//! Exact for a rudder that is held between samples, but for the trapezoids of the heading. No bounds are stated.

use seatrial_core::{Sample, YawModel};

/// The model of a manoeuvre; `None` where its samples do not tell the five apart.
pub fn model(samples: &[Sample<f64>]) -> Option<YawModel<f64>> {
    let mut normal = [[0.0; 6]; 5];
    let first = samples.first()?;
    let (mut turned_rad, mut heading_s, mut rudder_s, mut rudder_s2) = (0.0, 0.0, 0.0, 0.0);
    for pair in samples.windows(2) {
        let interval_s = pair[1].time_s - pair[0].time_s;
        let before_rad = turned_rad;
        turned_rad += wrapped(pair[1].heading_rad - pair[0].heading_rad);
        heading_s += 0.5 * interval_s * (before_rad + turned_rad);
        rudder_s2 += interval_s * (rudder_s + 0.5 * interval_s * pair[0].rudder_rad);
        rudder_s += interval_s * pair[0].rudder_rad;
        let t = pair[1].time_s - first.time_s;
        let row = [heading_s, rudder_s2, 0.5 * t * t, t, 1.0, turned_rad];
        for (i, line) in normal.iter_mut().enumerate() {
            for (j, sum) in line.iter_mut().enumerate() {
                *sum += row[i] * row[j];
            }
        }
    }
    let [a22_per_s, b2_per_s2, c0_rad_per_s2, ..] = solved(normal)?;
    Some(YawModel {
        a22_per_s,
        b2_per_s2,
        c0_rad_per_s2,
    })
}

fn wrapped(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle_rad - turn * (angle_rad / turn).round()
}

/// Gauss's elimination with the largest pivot.
fn solved(mut lines: [[f64; 6]; 5]) -> Option<[f64; 5]> {
    for at in 0..5 {
        let largest = (at..5).max_by(|a, b| lines[*a][at].abs().total_cmp(&lines[*b][at].abs()))?;
        lines.swap(at, largest);
        let pivot = lines[at];
        if pivot[at].abs() < 1e-12 {
            return None;
        }
        for (row, line) in lines.iter_mut().enumerate() {
            if row != at {
                let factor = line[at] / pivot[at];
                line.iter_mut()
                    .zip(pivot)
                    .for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    let solution = [0, 1, 2, 3, 4].map(|at| lines[at][5] / lines[at][at]);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

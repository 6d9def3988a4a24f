//! A record linearised around one vehicle.

use super::record::{
    A22, B2, C0, DELAY, HEADING, LAG2, PARAMETERS, Point, RATE, Record, explained,
};
use super::symmetric::invert;

/// Columns: derivatives of the heading by all parameters, and the residual.
pub const COLUMNS: usize = PARAMETERS + 1;

/// Derivatives and residual of each comparison around a point.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// The point.
    pub point: Point,
    /// Mean time of each comparison, s.
    pub time_s: Vec<f64>,
    /// Means over each comparison.
    pub rows: Vec<[f64; COLUMNS]>,
}

impl Record {
    /// Around a point, with the means of `block` samples. A `prompt` rudder's delay and lag are held: their derivatives are 0.
    pub fn linearised(&self, point: &Point, block: usize, prompt: bool) -> Linearised {
        let steps = self.steps(point);
        let here = self.mean_responses(&point.dynamics(), block);
        let free: &[usize] = if prompt { &[A22] } else { &[A22, DELAY, LAG2] };
        let moved = free.iter().map(|&parameter| {
            let mut moved = *point;
            moved.0[parameter] += steps[parameter - A22];
            self.mean_responses(&moved.dynamics(), block)
        });
        let moved: Vec<Vec<[f64; 5]>> = moved.collect();
        let headings_rad = self.mean_headings_rad(block);
        let rows = here.iter().zip(headings_rad).enumerate();
        let rows = rows.map(|(k, (responses, heading_rad))| {
            let heading = explained(responses, point);
            let mut row = [0.0; COLUMNS];
            row[..5].copy_from_slice(responses);
            for (i, moved) in moved.iter().enumerate() {
                row[A22 + i] = (explained(&moved[k], point) - heading) / steps[i];
            }
            row[PARAMETERS] = heading_rad - heading;
            row
        });
        Linearised {
            point: *point,
            rows: rows.collect(),
            time_s: self.time_s.chunks_exact(block).map(mean).collect(),
        }
    }

    /// Small steps of a22, s and v for differences.
    fn steps(&self, point: &Point) -> [f64; 3] {
        let h = self.interval_s;
        [
            1e-4 * point.0[A22].abs().max(1.0 / self.duration_s()),
            0.01 * h,
            0.05 * point.0[LAG2] + 0.01 * h * h,
        ]
    }

    /// The vehicle whose simulation is nearest among a grid of dampings and lags, in a thousand comparisons. `None` where the rudder does
    /// nothing.
    pub fn start(&self) -> Option<Point> {
        const POINTS: i32 = 20;
        const COMPARISONS: usize = 1000;
        let block = (self.time_s.len() / COMPARISONS).max(1);
        let headings_rad = self.mean_headings_rad(block);
        let slowest = 0.5 / self.duration_s();
        let fastest = 0.4 / self.interval_s;
        let ratio = ((fastest / slowest).ln() / f64::from(POINTS - 1)).exp();
        let dampings = (0..POINTS).map(|i| -slowest * ratio.powi(i));
        dampings
            .chain([slowest])
            .flat_map(|a22| [0.0, 0.15, 0.4].map(|share| (a22, share / a22.abs())))
            .filter_map(|(a22, lag_s)| {
                let mut point = Point([0.0; PARAMETERS]);
                point.0[A22] = a22;
                point.0[DELAY] = lag_s;
                point.0[LAG2] = lag_s * lag_s;
                linear_fit(
                    &self.mean_responses(&point.dynamics(), block),
                    &headings_rad,
                    &point,
                )
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, point)| point)
    }

    /// Of each comparison, rad.
    fn mean_headings_rad(&self, block: usize) -> Vec<f64> {
        let headings_rad = self.heading_rad.chunks_exact(block);
        headings_rad.map(mean).collect()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Sum of squares and point of the best b2, C0, psi0 and r0 at given dynamics.
fn linear_fit(responses: &[[f64; 5]], headings_rad: &[f64], point: &Point) -> Option<(f64, Point)> {
    const LINEAR: [usize; 4] = [B2, C0, HEADING, RATE];
    let mut gram = [[0.0; 5]; 5];
    for (responses, heading) in responses.iter().zip(headings_rad) {
        let row = [responses[0], responses[1], 1.0, responses[3], *heading];
        for i in 0..5 {
            for j in 0..5 {
                gram[i][j] += row[i] * row[j];
            }
        }
    }
    let information: [[f64; 4]; 4] = core::array::from_fn(|i| core::array::from_fn(|j| gram[i][j]));
    let (inverse, _) = invert(&information)?;
    let mut found = *point;
    let mut residual = gram[4][4];
    for i in LINEAR {
        found.0[i] = (0..4).map(|j| inverse[i][j] * gram[j][4]).sum();
        residual -= found.0[i] * gram[i][4];
    }
    Some((residual, found))
}

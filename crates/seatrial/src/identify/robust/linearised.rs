//! A record linearised around one vehicle.

use super::record::{A22, B2, C0, DELAY, HEADING, LAG2, PARAMETERS, Point, RATE, Record};
use super::response::Dynamics;
use super::symmetric::invert;

/// Columns: derivatives of the heading by all parameters, and the residual.
pub const COLUMNS: usize = PARAMETERS + 1;

/// Derivatives and residual of each comparison around a point.
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// The point.
    pub point: Point,
    /// Mean time of each comparison, s.
    pub time_s: Vec<f64>,
    /// Means over each comparison.
    pub rows: Vec<[f64; COLUMNS]>,
}

impl Record {
    /// Around a point, with the means of `block` samples. A `prompt` rudder's delay and lag are held: their derivatives are 0.
    pub fn linearised(&self, point: &Point, block: usize, prompt: bool) -> Linearisation {
        let steps = self.steps(point);
        let moved = |parameter: usize| {
            let mut moved = *point;
            moved.0[parameter] += steps[parameter - A22];
            moved.dynamics()
        };
        let here = point.dynamics();
        let rows = match prompt {
            true => self.rows_around(point, block, &[here, moved(A22)], &steps),
            false => {
                let all = [here, moved(A22), moved(DELAY), moved(LAG2)];
                self.rows_around(point, block, &all, &steps)
            }
        };
        Linearisation {
            point: *point,
            rows,
            time_s: self.time_s.chunks_exact(block).map(mean).collect(),
        }
    }

    /// Derivatives by differences between the first of several dynamics and those with a22, s and v moved by such steps.
    fn rows_around<const L: usize>(
        &self,
        point: &Point,
        block: usize,
        dynamics: &[Dynamics; L],
        steps: &[f64; 3],
    ) -> Vec<[f64; COLUMNS]> {
        self.mean_responses(dynamics, block, |k, responses| {
            let mut row = [0.0; COLUMNS];
            let mut headings = [0.0; L];
            for (i, of_lanes) in responses.iter().enumerate() {
                row[i] = of_lanes[0];
                for (heading, response) in headings.iter_mut().zip(of_lanes) {
                    *heading += response * point.0[i];
                }
            }
            for (i, heading) in headings[1..].iter().enumerate() {
                row[A22 + i] = (heading - headings[0]) / steps[i];
            }
            let measured = &self.heading_rad[k * block..(k + 1) * block];
            row[PARAMETERS] = mean(measured) - headings[0];
            row
        })
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

    /// The vehicle whose simulation is nearest, in some hundred comparisons, among a grid of dampings, of a prompt rudder or one of the known
    /// delay, and then of dampings about that one with two lags. `None` where the rudder does nothing.
    pub fn start(&self) -> Option<Point> {
        const POINTS: i32 = 20;
        /// Every so many of them are looked at first, then those about the best one.
        const APART: usize = 3;
        /// How many dampings on either side of the best one are looked at with lags.
        const BESIDE: usize = 3;
        /// In time constants of the vehicle.
        const LAGS: [f64; 2] = [0.15, 0.4];
        let slowest = 0.5 / self.duration_s();
        let fastest = 0.4 / self.interval_s;
        let ratio = libm::exp(libm::log(fastest / slowest) / f64::from(POINTS - 1));
        let mut dampings = vec![slowest];
        dampings.extend((0..POINTS).map(|i| -slowest * ratio.powi(i)));
        let known_s = self.known_delay_s.unwrap_or(0.0).max(0.0);
        let prompt = |dampings: &[f64]| {
            let points = dampings.iter().map(|a22| Point::lagging(*a22, known_s));
            self.nearest_of(&points.collect::<Vec<_>>())
        };
        let about = |a22: f64, beside: usize| {
            let place = dampings.iter().position(|damping| *damping == a22)?;
            let (first, last) = (place.saturating_sub(beside), place + beside);
            Some(&dampings[first..dampings.len().min(last + 1)])
        };
        let coarse: Vec<f64> = dampings.iter().step_by(APART).copied().collect();
        let (square, best) = prompt(&coarse)?;
        let mut between = about(best.0[A22], APART - 1)?.to_vec();
        between.retain(|a22| *a22 != best.0[A22]);
        let (square, best) = match prompt(&between) {
            Some((nearer, between)) if nearer < square => (nearer, between),
            _ => (square, best),
        };
        if self.known_delay_s.is_some() {
            return Some(best);
        }
        let lagging: Vec<Point> = (about(best.0[A22], BESIDE)?.iter())
            .flat_map(|a22| LAGS.map(|share| Point::lagging(*a22, share / a22.abs())))
            .collect();
        match self.nearest_of(&lagging) {
            Some((with_lag, lagging)) if with_lag < square => Some(lagging),
            _ => Some(best),
        }
    }

    /// Sum of squares and the one of several points whose simulation is nearest.
    fn nearest_of(&self, points: &[Point]) -> Option<(f64, Point)> {
        const COMPARISONS: usize = 150;
        /// Points that go side by side.
        const TOGETHER: usize = 4;
        let block = (self.time_s.len() / COMPARISONS).max(1);
        points
            .chunks(TOGETHER)
            .flat_map(|points| {
                let last = points[points.len() - 1];
                let filled = core::array::from_fn(|i| points.get(i).copied().unwrap_or(last));
                self.linear_fits::<TOGETHER>(&filled, block)
            })
            .flatten()
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Sum of squares and point of the best b2, C0, psi0 and r0 at the dynamics of each point.
    fn linear_fits<const L: usize>(
        &self,
        points: &[Point; L],
        block: usize,
    ) -> [Option<(f64, Point)>; L] {
        let mut products = [[[0.0; L]; 5]; 5];
        let dynamics = points.each_ref().map(Point::dynamics);
        self.mean_responses(&dynamics, block, |k, responses| {
            let heading = mean(&self.heading_rad[k * block..(k + 1) * block]);
            let [of_b2, of_c0, of_heading, of_rate, _] = *responses;
            let row = [of_b2, of_c0, of_heading, of_rate, [heading; L]];
            for i in 0..5 {
                for j in i..5 {
                    for l in 0..L {
                        products[i][j][l] += row[i][l] * row[j][l];
                    }
                }
            }
        });
        core::array::from_fn(|l| {
            let products =
                core::array::from_fn(|i| core::array::from_fn(|j| products[i.min(j)][i.max(j)][l]));
            linear_fit(&products, &points[l])
        })
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Sum of squares and point of the best b2, C0, psi0 and r0 at given dynamics, from the products of their responses and the heading.
fn linear_fit(products: &[[f64; 5]; 5], point: &Point) -> Option<(f64, Point)> {
    const LINEAR: [usize; 4] = [B2, C0, HEADING, RATE];
    let information: [[f64; 4]; 4] =
        core::array::from_fn(|i| core::array::from_fn(|j| products[i][j]));
    let (inverse, _) = invert(&information)?;
    let mut found = *point;
    let mut residual = products[4][4];
    for i in LINEAR {
        found.0[i] = (0..4).map(|j| inverse[i][j] * products[j][4]).sum();
        residual -= found.0[i] * products[i][4];
    }
    Some((residual, found))
}

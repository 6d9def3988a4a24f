//! Is what a hypothesis takes for a sea one? Draws of the sea say how far its estimate may lie from that of output error (Hausman 1978), and
//! how large the free run's error may be.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::filter::{Gains, innovations};
use super::fit::{Fit, Problem};
use super::gear::angles;
use super::hypothesis::{Noise, Vehicle};
use super::leg::Leg;
use super::motion::{Motion, State};
use crate::draw::Draw;

/// Draws of a sea.
const DRAWS: usize = 60;

/// Share of the heading's deviation that nobody cares for.
pub const NEGLIGIBLE: f64 = 0.005;

/// Share of a parameter that nobody cares for.
const NEGLIGIBLE_SHARE: f64 = 0.01;

/// How far from what its draws give a sea lies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeaTest {
    /// Squared distance of damping and authority from those of output error, over the draws' covariance.
    pub distance: f64,
    /// Log error of the free run less the draws' mean, in their deviations.
    pub error: f64,
}

impl SeaTest {
    /// The limits are those of a prototype of this method. There, in 100 true seas the distance was at most 5.5 and the error -1.8 to +1.6; of six records of a tanker model five have 16 or more, or an
    /// error under -2.5.
    pub fn is_a_sea(&self) -> bool {
        self.distance < 16.0 && -2.5 < self.error && self.error < 4.5
    }
}

/// Tests a sea against output error under the same structure. `None` where either determines nothing.
pub fn sea_test(problem: &Problem, calm: &Fit, sea: &Fit) -> Option<SeaTest> {
    let of = |fit: &Fit| -> Option<DMatrix<f64>> {
        let factor = fit.information.clone().cholesky()?;
        Some(factor.solve(&fit.jacobian.transpose()) / fit.variance_rad2)
    };
    let (to_calm, to_sea) = (of(calm)?, of(sea)?);
    let negligible = (NEGLIGIBLE * problem.scale.heading_rad).powi(2);
    let (gains, _) = problem.all_gains(&sea.x, &sea.noise);
    let mut draw = Draw::new(1);
    let mut apart = Vec::with_capacity(DRAWS);
    let mut errors = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        let [added, whitened] = drawn(problem, sea, &gains, &mut draw);
        let by_calm = -(&to_calm * &added);
        let by_sea = -(&to_sea * (whitened - &sea.errors));
        apart.push(Vector2::new(by_calm[0] - by_sea[0], by_calm[1] - by_sea[1]));
        let left = added + &calm.jacobian * by_calm;
        errors.push(libm::log(left.norm_squared() / left.len() as f64 + negligible));
    }
    let count = DRAWS as f64;
    let mean = apart.iter().sum::<Vector2<f64>>() / count;
    let mut covariance: Matrix2<f64> =
        apart.iter().map(|d| (d - mean) * (d - mean).transpose()).sum::<Matrix2<f64>>()
            / (count - 1.0);
    for i in 0..2 {
        covariance[(i, i)] += (NEGLIGIBLE_SHARE * sea.x[i]).powi(2);
    }
    let away = Vector2::new(calm.x[0] - sea.x[0], calm.x[1] - sea.x[1]);
    let distance = away.dot(&covariance.cholesky()?.solve(&away));
    let mean = errors.iter().sum::<f64>() / count;
    let deviation = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt();
    let actual = calm.errors.norm_squared() / calm.errors.len() as f64 + negligible;
    let error = (libm::log(actual) - mean) / deviation.max(0.05);
    Some(SeaTest { distance, error })
}

/// A draw of the sea with heading noise: what it adds to the headings, and the innovations of the sea's own filter then.
fn drawn(
    problem: &Problem,
    sea: &Fit,
    gains: &[Option<Gains>],
    draw: &mut Draw,
) -> [DVector<f64>; 2] {
    let vehicle = problem.vehicle(&sea.x);
    let noise_rad = sea.variance_rad2.sqrt();
    let (mut added, mut whitened) = (Vec::new(), Vec::new());
    for (leg, record) in problem.legs.iter().enumerate() {
        let wander = wander(record, &vehicle, &sea.noise, noise_rad, draw);
        let mut moved = record.clone();
        for (heading, added) in moved.heading_rad.iter_mut().zip(&wander) {
            *heading += added;
        }
        let angles = angles(record, &vehicle);
        let start = problem.start_of(&sea.x, leg);
        let range = [0, record.len()];
        let own = gains[leg].as_ref();
        whitened.extend(innovations(&moved, range, &vehicle, &start, own, &angles));
        added.extend(wander);
    }
    [DVector::from_vec(added), DVector::from_vec(whitened)]
}

/// Heading that a draw of the sea adds by the dynamics linearised along the record, with heading noise, rad.
fn wander(
    leg: &Leg,
    vehicle: &Vehicle,
    noise: &Noise,
    noise_rad: f64,
    draw: &mut Draw,
) -> Vec<f64> {
    let slopes = leg.slopes_rad_s();
    let [sea, time_s] = noise.sea;
    let sea_rad_s2 = sea * noise_rad;
    let mut motion = Motion::new(vehicle, noise);
    let mut x: State = [0.0, 0.0, 0.0, sea_rad_s2 * draw.normal()];
    let mut headings = Vec::with_capacity(leg.len());
    for (i, at_s) in leg.time_s.iter().enumerate() {
        headings.push(x[0] + noise_rad * draw.normal());
        let Some(next_s) = leg.time_s.get(i + 1) else {
            break;
        };
        let h = next_s - at_s;
        motion.set(vehicle.damping_about(slopes[i]), h);
        motion.advance(&mut x, 0.0);
        let kept = libm::exp(-h / time_s);
        x[3] += sea_rad_s2 * (1.0 - kept * kept).sqrt() * draw.normal();
    }
    headings
}

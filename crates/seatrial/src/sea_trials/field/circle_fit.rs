//! A circle through the track of a turn, with standard errors: the measured radius of Fig. 15.

use nalgebra::{Matrix3, Vector3};

/// The shortest arc that is fitted, rad (30 degrees): below it the sagitta is under 3.5 % of the
/// radius and of the order of the position noise.
pub const SHORTEST_ARC_RAD: f64 = std::f64::consts::PI / 6.0;

/// The largest residual and the largest standard error of the radius, as fractions of it.
pub const LARGEST_RELATIVE_ERROR: f64 = 0.25;

/// A circle fitted to points.
///
/// Minimises `sum_i (d_i - R)^2`, with d_i the distance of point i from the centre, by
/// Levenberg-Marquardt from the algebraic fit of Taubin (IEEE PAMI 13, 1991). The standard errors
/// are those of linearised least squares, sigma^2 (J^T J)^-1 with n - 3 degrees of freedom: they
/// assume that the points err independently.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircleFit {
    /// Centre, in the axes of the points, m.
    pub centre_m: [f64; 2],
    /// Radius, m.
    pub radius_m: f64,
    /// Standard errors of the centre, m.
    pub centre_standard_error_m: [f64; 2],
    /// Standard error of the radius, m.
    pub radius_standard_error_m: f64,
    /// sigma: standard deviation of the distance from the circle, m.
    pub residual_m: f64,
    /// The part of the circle that the points cover: all but the largest gap between them, rad.
    pub arc_rad: f64,
}

/// Why there is no circle.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoCircle {
    /// Three points always lie on a circle and say nothing about its error.
    #[error("{found} points; a circle with its error needs at least 4")]
    TooFewPoints {
        /// Points given.
        found: usize,
    },
    /// NaN or infinite.
    #[error("point {index} (from 0) is not finite")]
    NonFinite {
        /// Which point.
        index: usize,
    },
    /// The points lie on a line or on one spot.
    #[error(
        "the points lie on a straight line: the vehicle did not turn in this part of the track"
    )]
    Collinear,
    /// The points cover too little of a circle.
    #[error(
        "the points cover {:.0} degrees of a circle, at least {:.0} are needed: take a longer part of the turn",
        arc_rad.to_degrees(), SHORTEST_ARC_RAD.to_degrees()
    )]
    ShortArc {
        /// Arc covered, rad.
        arc_rad: f64,
    },
    /// The points do not lie near any circle.
    #[error(
        "the points lie {residual_m:.2} m from a circle of {radius_m:.2} m: this is not one turn"
    )]
    NotRound {
        /// Radius found, m.
        radius_m: f64,
        /// Standard deviation of the distance from the circle, m.
        residual_m: f64,
    },
    /// Noise hides the radius.
    #[error(
        "radius {radius_m:.2} m with a standard error of {standard_error_m:.2} m: the noise hides the circle"
    )]
    Uncertain {
        /// Radius found, m.
        radius_m: f64,
        /// Its standard error, m.
        standard_error_m: f64,
    },
}

impl CircleFit {
    /// The circle closest to the points, each in any two rectangular axes, m.
    ///
    /// ```
    /// use seatrial::sea_trials::field::{CircleFit, NoCircle};
    ///
    /// let circle: Vec<_> = (0..60)
    ///     .map(|k| 0.1 * f64::from(k))
    ///     .map(|angle| [3.0 + 10.0 * angle.cos(), -2.0 + 10.0 * angle.sin()])
    ///     .collect();
    /// let fit = CircleFit::new(&circle)?;
    /// assert!((fit.radius_m - 10.0).abs() < 1e-6);
    /// // Three points say nothing about their error.
    /// assert_eq!(CircleFit::new(&circle[..3]), Err(NoCircle::TooFewPoints { found: 3 }));
    /// # Ok::<(), NoCircle>(())
    /// ```
    pub fn new(points: &[[f64; 2]]) -> Result<Self, NoCircle> {
        if let Some(index) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(NoCircle::NonFinite { index });
        }
        if points.len() < 4 {
            return Err(NoCircle::TooFewPoints { found: points.len() });
        }
        let n = points.len() as f64;
        let centroid = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / n);
        let centred: Vec<[f64; 2]> =
            points.iter().map(|p| [p[0] - centroid[0], p[1] - centroid[1]]).collect();
        let start = taubin(&centred).ok_or(NoCircle::Collinear)?;
        let (circle, normal, cost) = refine(&centred, start);

        let arc_rad = arc_covered(&centred, circle);
        if arc_rad < SHORTEST_ARC_RAD {
            return Err(NoCircle::ShortArc { arc_rad });
        }
        let residual_m = (cost / (n - 3.0)).sqrt();
        if residual_m > LARGEST_RELATIVE_ERROR * circle[2] {
            return Err(NoCircle::NotRound { radius_m: circle[2], residual_m });
        }
        let covariance = normal.try_inverse().ok_or(NoCircle::Collinear)?;
        let standard_error = |i: usize| residual_m * covariance[(i, i)].sqrt();
        let fit = Self {
            centre_m: [circle[0] + centroid[0], circle[1] + centroid[1]],
            radius_m: circle[2],
            centre_standard_error_m: [standard_error(0), standard_error(1)],
            radius_standard_error_m: standard_error(2),
            residual_m,
            arc_rad,
        };
        if fit.radius_standard_error_m > LARGEST_RELATIVE_ERROR * fit.radius_m {
            return Err(NoCircle::Uncertain {
                radius_m: fit.radius_m,
                standard_error_m: fit.radius_standard_error_m,
            });
        }
        Ok(fit)
    }
}

/// Taubin's fit of points about their centroid: with z = x^2 + y^2 and zm its mean, the direction in
/// which ((z - zm)/(2 sqrt zm), x, y) varies least. `None` where the points lie on a line.
fn taubin(points: &[[f64; 2]]) -> Option<Vector3<f64>> {
    let square = |p: &[f64; 2]| p[0] * p[0] + p[1] * p[1];
    let mean_square = points.iter().map(square).sum::<f64>() / points.len() as f64;
    let scale = 2.0 * mean_square.sqrt();
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|p| Vector3::new((square(p) - mean_square) / scale, p[0], p[1]))
        .map(|row| row * row.transpose())
        .sum();
    let spread = scatter.fixed_view::<2, 2>(1, 1).symmetric_eigenvalues();
    // A line up to rounding: the squares of offsets under 1e-8 of its length.
    if spread.min() <= 1e-16 * spread.max() {
        return None;
    }
    let eigen = scatter.symmetric_eigen();
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let (a, b, c) = (least[0] / scale, least[1], least[2]);
    let circle = Vector3::new(
        -b / (2.0 * a),
        -c / (2.0 * a),
        (b * b + c * c + 4.0 * a * a * mean_square).sqrt() / (2.0 * a.abs()),
    );
    circle.iter().all(|x| x.is_finite()).then_some(circle)
}

/// Levenberg-Marquardt on (x, y, R): the best circle, J^T J and the sum of squares there.
fn refine(points: &[[f64; 2]], start: Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>, f64) {
    const ITERATIONS: usize = 200;
    let mut circle = start;
    let (mut cost, mut gradient, mut normal) = linearised(points, circle);
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let mut damped = normal;
        for i in 0..3 {
            damped[(i, i)] *= 1.0 + damping;
        }
        let Some(step) = damped.try_inverse().map(|inverse| inverse * gradient) else {
            break;
        };
        let tried = circle - step;
        let (tried_cost, tried_gradient, tried_normal) = linearised(points, tried);
        if tried_cost <= cost {
            circle = tried;
            (cost, gradient, normal) = (tried_cost, tried_gradient, tried_normal);
            damping *= 0.1;
        } else {
            damping *= 10.0;
        }
        if step.norm() <= 1e-14 * circle.norm() {
            break;
        }
    }
    (circle, normal, cost)
}

/// Sum of squares, J^T e and J^T J of e_i = d_i - R.
fn linearised(points: &[[f64; 2]], circle: Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let mut sums = (0.0, Vector3::zeros(), Matrix3::zeros());
    for p in points {
        let (dx, dy) = (circle[0] - p[0], circle[1] - p[1]);
        let distance = libm::hypot(dx, dy).max(f64::MIN_POSITIVE);
        let error = distance - circle[2];
        let row = Vector3::new(dx / distance, dy / distance, -1.0);
        sums.0 += error * error;
        sums.1 += row * error;
        sums.2 += row * row.transpose();
    }
    sums
}

/// The full turn less the largest gap between neighbouring points, seen from the centre.
fn arc_covered(points: &[[f64; 2]], circle: Vector3<f64>) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    let mut bearings: Vec<f64> =
        points.iter().map(|p| libm::atan2(p[1] - circle[1], p[0] - circle[0])).collect();
    bearings.sort_unstable_by(f64::total_cmp);
    let around = bearings[0] + turn - bearings[bearings.len() - 1];
    let largest_gap = bearings.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    turn - largest_gap
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x = 12.3 + 9.2 cos th + 0.15 sin(37 k + 1), y = -4.5 + 9.2 sin th + 0.15 cos(23 k + 2)
    fn noisy_arc(arc_rad: f64, count: u32) -> Vec<[f64; 2]> {
        (0..count)
            .map(|k| {
                let k = f64::from(k);
                let (sin, cos) = (0.3 + k * arc_rad / f64::from(count - 1)).sin_cos();
                [
                    12.3 + 9.2 * cos + 0.15 * (37.0 * k + 1.0).sin(),
                    -4.5 + 9.2 * sin + 0.15 * (23.0 * k + 2.0).cos(),
                ]
            })
            .collect()
    }

    /// scipy.optimize.least_squares(lambda p: hypot(x - p[0], y - p[1]) - p[2], xtol=ftol=gtol=1e-15),
    /// standard errors from inv(jac.T @ jac) * fun @ fun / (40 - 3), 40 points of `noisy_arc`.
    #[test]
    fn val_scipy_circle_and_standard_errors() {
        for (arc_rad, circle, errors) in [
            (
                3.5,
                [12.298546693843411, -4.49482169614281, 9.195251008359225],
                [0.029279830790395752, 0.0416999072818990, 0.030119792382953606],
            ),
            (
                std::f64::consts::PI / 3.0,
                [12.241917330957847, -4.544735401154112, 9.2698875279593],
                [0.28716168000149495, 0.30861282409701557, 0.39840042175801327],
            ),
        ] {
            let fit = CircleFit::new(&noisy_arc(arc_rad, 40)).unwrap();
            let found = [fit.centre_m[0], fit.centre_m[1], fit.radius_m];
            let found_errors = [
                fit.centre_standard_error_m[0],
                fit.centre_standard_error_m[1],
                fit.radius_standard_error_m,
            ];
            for i in 0..3 {
                // The cost is flat to its rounding within 1e-7 standard errors or so of the minimum.
                assert!((found[i] - circle[i]).abs() < 1e-6 * errors[i], "{found:?}");
                assert!((found_errors[i] - errors[i]).abs() < 1e-6 * errors[i]);
            }
            // The ends of the arc are displaced by the noise, at most 0.15 m of 9.2 m each.
            assert!((fit.arc_rad - arc_rad).abs() < 2.0 * 0.15 * 2.0 / 9.2);
        }
    }

    #[test]
    fn exact_noise_free_circle_anywhere() {
        for (x, y, radius) in [(0.0, 0.0, 1.0), (1e5, -3e5, 8.1), (3.0, 4.0, 1e4)] {
            let points: Vec<[f64; 2]> = (0..60)
                .map(|k| 0.05 * f64::from(k))
                .map(|angle: f64| [x + radius * angle.cos(), y + radius * angle.sin()])
                .collect();
            let fit = CircleFit::new(&points).unwrap();
            // Rounding of the coordinates themselves, 3e5 * 1e-16, times the conditioning of the arc.
            let tolerance = 1e-8 * radius.max(1.0);
            assert!((fit.radius_m - radius).abs() < tolerance);
            assert!((fit.centre_m[0] - x).abs() < tolerance);
            assert!((fit.centre_m[1] - y).abs() < tolerance);
            assert!((fit.arc_rad - 59.0 * 0.05).abs() < 1e-8);
        }
    }

    #[test]
    fn exact_refusals_have_reasons() {
        let line: Vec<[f64; 2]> = (0..20).map(|k| [f64::from(k), 2.0 * f64::from(k)]).collect();
        assert_eq!(CircleFit::new(&line), Err(NoCircle::Collinear));
        assert_eq!(CircleFit::new(&[[1.0, 2.0]; 9]), Err(NoCircle::Collinear));
        assert_eq!(CircleFit::new(&line[..3]), Err(NoCircle::TooFewPoints { found: 3 }));
        assert_eq!(
            CircleFit::new(&[[0.0, 0.0], [f64::NAN, 0.0]]),
            Err(NoCircle::NonFinite { index: 1 })
        );
        assert!(matches!(
            CircleFit::new(&noisy_arc(0.4, 40)[..20]),
            Err(NoCircle::ShortArc { .. })
        ));
        let grid: Vec<[f64; 2]> = (0..25).map(|k| [f64::from(k % 5), f64::from(k / 5)]).collect();
        assert!(matches!(CircleFit::new(&grid), Err(NoCircle::NotRound { .. })));
        let few = CircleFit::new(&noisy_arc(0.6, 12));
        assert!(matches!(few, Err(NoCircle::Uncertain { .. })), "{few:?}");
    }
}

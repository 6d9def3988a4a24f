//! The paper's conventional offline method: simplex search over repeated simulation, section V.

use seatrial_core::Sample;
use seatrial_core::YawModel;
use seatrial_core::model::YawState;

use super::validation::quiet_lead_in_s;

/// When the search stops and how large its first simplex is.
///
/// The paper gives the two tolerances and the zero start vector, but not the first simplex. With
/// the usual 0.00025 beside a zero vector the function tolerance is met after a few iterations, far
/// from the minimum; an edge of 0.05 lets the search begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplexSettings {
    /// Edge of the first simplex, in the units of each parameter.
    pub first_edge: f64,
    /// Largest distance of any vertex from the best one, per parameter.
    pub parameter_tolerance: f64,
    /// Largest difference of cost between any vertex and the best one.
    pub function_tolerance: f64,
    /// The search gives up after this many iterations.
    pub iteration_limit: u32,
}

impl SimplexSettings {
    /// Section V: parameter tolerance 0.01, function tolerance 0.0001.
    ///
    /// ```
    /// use seatrial::identify::simplex::SimplexSettings;
    ///
    /// assert!(SimplexSettings::paper().iteration_limit > 100);
    /// ```
    pub const fn paper() -> Self {
        Self {
            first_edge: 0.05,
            parameter_tolerance: 0.01,
            function_tolerance: 1e-4,
            iteration_limit: 600,
        }
    }
}

/// Where a search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum<const N: usize> {
    /// The best vertex.
    pub at: [f64; N],
    /// Its cost.
    pub cost: f64,
    /// Simplices looked at, the first one included.
    pub iterations: u32,
    /// Were both tolerances met, rather than the iteration limit?
    pub converged: bool,
}

/// The model with the least root mean square heading error (38), searched from the zero vector.
///
/// ```text
/// J(Theta) = sqrt(1/N sum_k (psi_real(t_k) - psi_sim(t_k))^2)      (38)
/// ```
///
/// `samples` must have unwrapped headings; `start` is the vehicle's state at the first of them.
pub fn fit(
    samples: &[Sample<f64>],
    start: YawState<f64>,
    settings: &SimplexSettings,
) -> Minimum<3> {
    let cost = |theta: &[f64; 3]| heading_error_rms(&YawModel::from_theta(*theta), samples, start);
    minimise(cost, [0.0; 3], settings)
}

/// The paper's offline method on a training record with unwrapped headings: from rest at the mean heading of
/// the quiet lead-in. `None` without a sample.
///
/// ```
/// use seatrial::identify::simplex::fit_as_paper;
///
/// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
/// # let mut state = seatrial_core::model::YawState::<f64>::default();
/// # let sample = |k: u32| {
/// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
/// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
/// #     state = vehicle.advance(state, rudder_rad, 0.05);
/// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
/// # };
/// # let record: seatrial::Record = (0..660).map(sample).collect();
/// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
/// let found = fit_as_paper(&record.samples[..330]).ok_or("a record with samples")?;
/// assert!((found.at[0] + 1.07).abs() < 0.05);
/// assert!(fit_as_paper(&[]).is_none());
/// # Ok::<(), &str>(())
/// ```
pub fn fit_as_paper(samples: &[Sample<f64>]) -> Option<Minimum<3>> {
    let first = samples.first()?;
    let lead_in_s = quiet_lead_in_s(samples);
    let end = samples.partition_point(|sample| sample.time_s < first.time_s + lead_in_s);
    let lead_in = &samples[..end.max(1)];
    let start = YawState {
        heading_rad: lead_in.iter().map(|s| s.heading_rad).sum::<f64>() / lead_in.len() as f64,
        yaw_rate_rad_s: 0.0,
    };
    Some(fit(samples, start, &SimplexSettings::paper()))
}

/// Root mean square of measured less simulated heading (38), rad.
fn heading_error_rms(model: &YawModel<f64>, samples: &[Sample<f64>], start: YawState<f64>) -> f64 {
    let mut state = start;
    let mut sum = 0.0;
    for (k, sample) in samples.iter().enumerate() {
        let error = sample.heading_rad - state.heading_rad;
        sum += error * error;
        if let Some(next) = samples.get(k + 1) {
            state = runge_kutta_4(model, state, sample.rudder_rad, next.time_s - sample.time_s);
        }
    }
    (sum / samples.len() as f64).sqrt()
}

/// One step of the classical fourth-order Runge-Kutta method for (11) with the rudder held.
fn runge_kutta_4(
    model: &YawModel<f64>,
    state: YawState<f64>,
    rudder: f64,
    h: f64,
) -> YawState<f64> {
    let acceleration = |rate: f64| model.yaw_acceleration(rate, rudder);
    let rate_1 = state.yaw_rate_rad_s;
    let slope_1 = acceleration(rate_1);
    let rate_2 = rate_1 + 0.5 * h * slope_1;
    let slope_2 = acceleration(rate_2);
    let rate_3 = rate_1 + 0.5 * h * slope_2;
    let slope_3 = acceleration(rate_3);
    let rate_4 = rate_1 + h * slope_3;
    let slope_4 = acceleration(rate_4);
    YawState {
        heading_rad: state.heading_rad + h / 6.0 * (rate_1 + 2.0 * rate_2 + 2.0 * rate_3 + rate_4),
        yaw_rate_rad_s: rate_1 + h / 6.0 * (slope_1 + 2.0 * slope_2 + 2.0 * slope_3 + slope_4),
    }
}

/// Nelder and Mead's simplex search with the usual coefficients: reflection 1, expansion 2,
/// contraction 1/2, shrinkage 1/2.
///
/// Source: J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7
/// (1965), reference 24 of the paper. A cost that is not a number counts as infinite.
///
/// ```
/// use seatrial::identify::simplex::{SimplexSettings, minimise};
///
/// let settings = SimplexSettings {
///     first_edge: 0.1,
///     parameter_tolerance: 1e-6,
///     function_tolerance: 1e-9,
///     iteration_limit: 500,
/// };
/// let found = minimise(|[x, y]| (x - 1.0).powi(2) + 4.0 * (y + 2.0).powi(2), [0.0; 2], &settings);
/// assert!(found.converged && (found.at[1] + 2.0).abs() < 1e-4);
/// ```
pub fn minimise<const N: usize>(
    mut objective: impl FnMut(&[f64; N]) -> f64,
    start: [f64; N],
    settings: &SimplexSettings,
) -> Minimum<N> {
    let mut vertex = |at: [f64; N]| {
        let cost = objective(&at);
        Vertex { at, cost: if cost.is_nan() { f64::INFINITY } else { cost } }
    };
    let mut simplex = vec![vertex(start)];
    for axis in 0..N {
        let mut at = start;
        at[axis] += settings.first_edge;
        simplex.push(vertex(at));
    }
    simplex.sort_by(Vertex::by_cost);

    let mut iterations = 1;
    let converged = loop {
        let best = simplex[0];
        if simplex.iter().all(|v| v.within(&best, settings)) {
            break true;
        }
        if iterations >= settings.iteration_limit {
            break false;
        }
        match replacement(&simplex, &mut vertex) {
            Some(replacement) => simplex[N] = replacement,
            None => {
                for v in &mut simplex[1..] {
                    *v = vertex(std::array::from_fn(|i| best.at[i] + 0.5 * (v.at[i] - best.at[i])));
                }
            }
        }
        simplex.sort_by(Vertex::by_cost);
        iterations += 1;
    };
    Minimum { at: simplex[0].at, cost: simplex[0].cost, iterations, converged }
}

/// The better vertex on the line from the worst one through the centre of the others. `None` where there is none and the
/// simplex shrinks. The vertices are in order of cost.
fn replacement<const N: usize>(
    simplex: &[Vertex<N>],
    vertex: &mut impl FnMut([f64; N]) -> Vertex<N>,
) -> Option<Vertex<N>> {
    let (best, second_worst, worst) = (simplex[0], simplex[N - 1], simplex[N]);
    let centre = centre_of(&simplex[..N]);
    let on_the_line = |factor: f64| -> [f64; N] {
        std::array::from_fn(|i| centre[i] + factor * (centre[i] - worst.at[i]))
    };
    let reflected = vertex(on_the_line(1.0));
    if reflected.cost < best.cost {
        let expanded = vertex(on_the_line(2.0));
        let is_better = expanded.cost < reflected.cost;
        Some(if is_better { expanded } else { reflected })
    } else if reflected.cost < second_worst.cost {
        Some(reflected)
    } else if reflected.cost < worst.cost {
        Some(vertex(on_the_line(0.5))).filter(|outside| outside.cost <= reflected.cost)
    } else {
        Some(vertex(on_the_line(-0.5))).filter(|inside| inside.cost < worst.cost)
    }
}

#[derive(Clone, Copy)]
struct Vertex<const N: usize> {
    at: [f64; N],
    cost: f64,
}

impl<const N: usize> Vertex<N> {
    fn by_cost(a: &Self, b: &Self) -> std::cmp::Ordering {
        a.cost.total_cmp(&b.cost)
    }

    fn within(&self, best: &Self, settings: &SimplexSettings) -> bool {
        let distance = self.at.iter().zip(&best.at).map(|(a, b)| (a - b).abs());
        distance.fold(0.0, f64::max) <= settings.parameter_tolerance
            && (self.cost - best.cost).abs() <= settings.function_tolerance
    }
}

fn centre_of<const N: usize>(vertices: &[Vertex<N>]) -> [f64; N] {
    std::array::from_fn(|i| vertices.iter().map(|v| v.at[i]).sum::<f64>() / vertices.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIGHT: SimplexSettings = SimplexSettings {
        first_edge: 0.05,
        parameter_tolerance: 1e-9,
        function_tolerance: 1e-16,
        iteration_limit: 2000,
    };

    #[test]
    fn prop_simplex_finds_the_minimum_of_rosenbrock() {
        let rosenbrock = |x: &[f64; 2]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let found = minimise(rosenbrock, [-1.2, 1.0], &TIGHT);
        assert!(found.converged);
        // The cost is flat to rounding within about 1e-8 of the minimum.
        assert!((found.at[0] - 1.0).abs() < 1e-6 && (found.at[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn prop_simplex_finds_the_minimum_of_scaled_quadratics() {
        for scale in [0.1, 1.0, 30.0] {
            let target = [0.3, -1.7, 0.04];
            let quadratic = |x: &[f64; 3]| -> f64 {
                (0..3).map(|i| scale * (i + 1) as f64 * (x[i] - target[i]).powi(2)).sum()
            };
            let found = minimise(quadratic, [0.0; 3], &TIGHT);
            assert!(found.converged);
            for (a, b) in found.at.iter().zip(target) {
                // Square root of the function tolerance, with room for the flattest axis.
                assert!((a - b).abs() < 1e-6, "{:?}", found.at);
            }
        }
    }

    #[test]
    fn prop_simplex_gives_up_at_its_limit_and_survives_not_a_number() {
        let stopped = minimise(
            |x: &[f64; 2]| x[0] + x[1],
            [0.0; 2],
            &SimplexSettings { iteration_limit: 40, ..TIGHT },
        );
        assert!(!stopped.converged);
        assert_eq!(stopped.iterations, 40);
        let holed = |x: &[f64; 1]| {
            if x[0] > 0.5 { f64::NAN } else { (x[0] - 0.4).powi(2) }
        };
        let found = minimise(holed, [0.0], &TIGHT);
        // Quadratic minimum, as above.
        assert!((found.at[0] - 0.4).abs() < 1e-6);
    }

    /// Runge-Kutta against the exact solution: the local error is of fifth order in the step.
    #[test]
    fn exact_runge_kutta_matches_the_exact_discretisation() {
        let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let start = YawState { heading_rad: 0.3, yaw_rate_rad_s: -0.2 };
        let numerical = runge_kutta_4(&model, start, 0.26, 0.05);
        let exact = model.advance(start, 0.26, 0.05);
        // (a h)^5 / 120 = 4e-9 times the rate.
        assert!((numerical.yaw_rate_rad_s - exact.yaw_rate_rad_s).abs() < 4e-9);
        assert!((numerical.heading_rad - exact.heading_rad).abs() < 4e-9);
    }
}

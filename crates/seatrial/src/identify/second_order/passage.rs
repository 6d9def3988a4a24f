//! What a linear model of yaw rate and drift does over some time.

type Square = [[f64; 2]; 2];

const IDENTITY: Square = [[1.0, 0.0], [0.0, 1.0]];

/// (r, w)' = J (r, w) + f,  psi' = r, over t with a constant f:
///
/// ```text
/// (r, w) <- Phi (r, w) + Gamma f,   psi <- psi + Gamma_1 (r, w) + H_1 f
/// Phi = exp(J t),  Gamma = integral of Phi,  H = integral of Gamma; the index 1 is the first row
/// ```
///
/// By the series of the integral of H to 1e-10, of a time of which J makes no more than a half, doubled to the whole.
#[derive(Clone, Copy)]
pub(super) struct Linear {
    /// What is carried over, and what a force on the yaw rate gives.
    pub(super) passage: Passage,
    /// Heading, yaw rate and drift that a force of 1 on the drift gives.
    pub(super) to_drift: [f64; 3],
    /// What forces on yaw rate and drift give that grow by 1 in a second from minus half the time.
    pub(super) slopes: [[f64; 3]; 2],
}

/// How heading, yaw rate and drift lead to those some time later.
#[derive(Clone, Copy)]
pub(super) struct Passage {
    /// s
    pub(super) interval_s: f64,
    /// From yaw rate and drift to both.
    pub(super) state: Square,
    /// From yaw rate and drift to the heading, s.
    pub(super) heading_s: [f64; 2],
    /// Heading, yaw rate and drift that a force of 1 on the yaw rate gives.
    pub(super) to_rate: [f64; 3],
    /// As over the comparison before?
    pub(super) is_same: bool,
}

impl Passage {
    /// No time.
    pub(super) const NONE: Self = Self {
        interval_s: 0.0,
        state: IDENTITY,
        heading_s: [0.0; 2],
        to_rate: [0.0; 3],
        is_same: false,
    };

    /// Heading, yaw rate and drift afterwards, with a force on the yaw rate.
    #[inline(always)]
    pub(super) fn of(&self, [psi, r, w]: [f64; 3], force: f64) -> [f64; 3] {
        let [[s_rr, s_rw], [s_wr, s_ww]] = self.state;
        let [psi_r, psi_w] = self.heading_s;
        let [f_psi, f_r, f_w] = self.to_rate;
        [
            psi + psi_r * r + psi_w * w + f_psi * force,
            s_rr * r + s_rw * w + f_r * force,
            s_wr * r + s_ww * w + f_w * force,
        ]
    }

    /// This passage and then another one.
    pub(super) fn then(&self, next: &Self) -> Self {
        let carried = |r: f64, w: f64| next.of([0.0, r, w], 0.0);
        let [[s_rr, s_rw], [s_wr, s_ww]] = self.state;
        let [of_rate, of_drift] = [carried(s_rr, s_wr), carried(s_rw, s_ww)];
        Self {
            interval_s: self.interval_s + next.interval_s,
            state: [[of_rate[1], of_drift[1]], [of_rate[2], of_drift[2]]],
            heading_s: [
                self.heading_s[0] + of_rate[0],
                self.heading_s[1] + of_drift[0],
            ],
            to_rate: next.of(self.to_rate, 1.0),
            is_same: false,
        }
    }
}

impl Linear {
    /// No time.
    pub(super) const NONE: Self = Self {
        passage: Passage::NONE,
        to_drift: [0.0; 3],
        slopes: [[0.0; 3]; 2],
    };

    /// `jacobian` is J, 1/s.
    pub(super) fn over(jacobian: &Square, interval_s: f64) -> Self {
        const TERMS: u32 = 9;
        const MOST_DOUBLINGS: u32 = 30;
        let size = interval_s * jacobian.as_flattened().iter().map(|j| j.abs()).sum::<f64>();
        let mut t = interval_s;
        let mut doublings = 0;
        while size * t > 0.5 * interval_s && doublings < MOST_DOUBLINGS {
            t *= 0.5;
            doublings += 1;
        }
        // The integral of H over t^3 is the sum of (J t)^n/(n + 3)!, the highest power first.
        let scaled = jacobian.map(|row| row.map(|j| j * t));
        let mut series = IDENTITY;
        for n in (1..TERMS).rev() {
            series = with(
                &times(&product(&scaled, &series), 1.0 / f64::from(n + 3)),
                1.0,
            );
        }
        let mut third = times(&series, t * t * t / 6.0);
        let mut heading = with(&product(jacobian, &third), 0.5 * t * t);
        let mut gain = with(&product(jacobian, &heading), t);
        let mut state = with(&product(jacobian, &gain), 1.0);
        for _ in 0..doublings {
            third = sum(
                &sum(&third, &product(&state, &third)),
                &sum(&times(&heading, t), &times(&gain, 0.5 * t * t)),
            );
            heading = sum(&sum(&heading, &product(&state, &heading)), &times(&gain, t));
            gain = sum(&gain, &product(&state, &gain));
            state = product(&state, &state);
            t *= 2.0;
        }
        let half_s = 0.5 * interval_s;
        let slope = sum(&heading, &times(&gain, -half_s));
        let slope_heading = sum(&third, &times(&heading, -half_s));
        let column = |of_heading: &Square, of_both: &Square, j: usize| {
            [of_heading[0][j], of_both[0][j], of_both[1][j]]
        };
        Self {
            passage: Passage {
                interval_s,
                state,
                heading_s: gain[0],
                to_rate: column(&heading, &gain, 0),
                is_same: false,
            },
            to_drift: column(&heading, &gain, 1),
            slopes: [0, 1].map(|j| column(&slope_heading, &slope, j)),
        }
    }
}

/// A matrix and a multiple of the identity.
fn with(matrix: &Square, diagonal: f64) -> Square {
    let [[a, b], [c, d]] = *matrix;
    [[a + diagonal, b], [c, d + diagonal]]
}

fn times(matrix: &Square, factor: f64) -> Square {
    matrix.map(|row| row.map(|element| factor * element))
}

fn sum(left: &Square, right: &Square) -> Square {
    core::array::from_fn(|i| core::array::from_fn(|j| left[i][j] + right[i][j]))
}

fn product(left: &Square, right: &Square) -> Square {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| left[i][0] * right[0][j] + left[i][1] * right[1][j])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vehicle without sway has a solution in closed form.
    #[test]
    fn exact_passage_of_a_vehicle_without_sway() {
        let a: f64 = -0.9;
        for t in [0.05, 0.7, 20.0] {
            let passage = Linear::over(&[[a, 0.0], [0.0, -0.3]], t).passage;
            let [psi, r, w] = passage.of([0.2, 0.5, 0.4], 0.3);
            let (decay, gain) = ((a * t).exp(), (a * t).exp_m1() / a);
            // The series stops at 0.5^9/12!.
            assert!((r - (decay * 0.5 + gain * 0.3)).abs() < 1e-9);
            assert!((psi - (0.2 + gain * 0.5 + 0.3 * (gain - t) / a)).abs() < 1e-9);
            assert!((w - 0.4 * (-0.3 * t).exp()).abs() < 1e-9);
        }
    }

    #[test]
    fn exact_two_passages_are_one() {
        let jacobian = [[-0.9, 0.2], [-1.0, -0.6]];
        let half = Linear::over(&jacobian, 0.8).passage;
        let twice = half.of(half.of([0.1, -0.2, 0.3], 0.4), 0.4);
        let composed = half.then(&half).of([0.1, -0.2, 0.3], 0.4);
        let once = Linear::over(&jacobian, 1.6)
            .passage
            .of([0.1, -0.2, 0.3], 0.4);
        for i in 0..3 {
            // Rounding, and the series.
            assert!((twice[i] - once[i]).abs() < 1e-9, "{twice:?} {once:?}");
            assert!(
                (composed[i] - once[i]).abs() < 1e-9,
                "{composed:?} {once:?}"
            );
        }
    }

    /// Forces that grow, against small steps of constant ones.
    #[test]
    fn exact_slopes_of_forces() {
        const STEPS: u32 = 20_000;
        let jacobian = [[-0.9, 0.2], [-1.0, -0.6]];
        let whole = Linear::over(&jacobian, 1.5);
        let step = Linear::over(&jacobian, 1.5 / f64::from(STEPS));
        let growth = |k| 1.5 * (f64::from(k) + 0.5) / f64::from(STEPS) - 0.75;
        let on_rate = (0..STEPS).fold([0.0; 3], |state, k| step.passage.of(state, growth(k)));
        let on_drift = (0..STEPS).fold([0.0; 3], |state, k| {
            let carried = step.passage.of(state, 0.0);
            core::array::from_fn(|i| carried[i] + step.to_drift[i] * growth(k))
        });
        for (found, expected) in whole.slopes.iter().zip([on_rate, on_drift]) {
            for (found, expected) in found.iter().zip(expected) {
                // Steps of 0.1 ms.
                assert!((found - expected).abs() < 1e-7, "{found} {expected}");
            }
        }
    }
}

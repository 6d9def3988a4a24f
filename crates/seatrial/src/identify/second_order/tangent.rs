//! What the state of a model with cross-flow damping depends on, over some time.

use super::passage::Passage;
use crate::sway_yaw::model::{SwayYawModel, SwayYawState};

/// To the yaw rate and the drift before (two columns), the yaw acceleration b2 delta + C0, a22, a21, a11 and k; one is not used.
const COLUMNS: usize = 8;
pub(super) const TO_RATE: usize = 0;
pub(super) const TO_DRIFT: usize = 1;
pub(super) const TO_INPUT: usize = 2;
pub(super) const TO_A22: usize = 3;
pub(super) const TO_A21: usize = 4;
pub(super) const TO_A11: usize = 5;
pub(super) const TO_CROSS_FLOW: usize = 6;

type Columns = [f64; COLUMNS];

/// Derivatives of heading, yaw rate and drift after that time.
#[derive(Clone, Copy)]
pub(super) struct Tangent {
    heading: Columns,
    rate: Columns,
    drift: Columns,
}

/// M' = J M + F along a simulation.
struct Slope {
    jacobian: [[f64; 2]; 2],
    to_rate: Columns,
    to_drift: Columns,
}

impl Slope {
    fn at(model: &SwayYawModel, state: &SwayYawState, side: f64) -> Self {
        let (r, w) = (state.yaw_rate_rad_s, state.drift_rad);
        let (mut to_rate, mut to_drift) = ([0.0; COLUMNS], [0.0; COLUMNS]);
        to_rate[TO_INPUT] = 1.0;
        to_rate[TO_A22] = r;
        to_rate[TO_A21] = w;
        to_rate[TO_CROSS_FLOW] = side * w * r;
        to_drift[TO_A11] = w;
        Self {
            jacobian: model.jacobian(state, side),
            to_rate,
            to_drift,
        }
    }

    #[inline(always)]
    fn of(&self, rate: &Columns, drift: &Columns) -> (Columns, Columns) {
        let [[r_r, r_w], [w_r, w_w]] = self.jacobian;
        let (mut of_rate, mut of_drift) = (self.to_rate, self.to_drift);
        for i in 0..COLUMNS {
            of_rate[i] += r_r * rate[i] + r_w * drift[i];
            of_drift[i] += w_r * rate[i] + w_w * drift[i];
        }
        (of_rate, of_drift)
    }
}

#[inline(always)]
fn ahead(from: &Columns, h: f64, slope: &Columns) -> Columns {
    let mut next = *from;
    for i in 0..COLUMNS {
        next[i] += h * slope[i];
    }
    next
}

impl Tangent {
    /// By one step of Runge and Kutta's fourth-order formula of `h` s along a simulation, of which begin, middle and end are known and
    /// whose drift does not change its sign.
    pub(super) fn over(model: &SwayYawModel, h: f64, along: [&SwayYawState; 3]) -> Self {
        let [begin, middle, end] =
            along.map(|state| Slope::at(model, state, along[1].drift_rad.signum()));
        let (mut rate, mut drift) = ([0.0; COLUMNS], [0.0; COLUMNS]);
        rate[TO_RATE] = 1.0;
        drift[TO_DRIFT] = 1.0;
        let (r1, w1) = begin.of(&rate, &drift);
        let rate_2 = ahead(&rate, 0.5 * h, &r1);
        let (r2, w2) = middle.of(&rate_2, &ahead(&drift, 0.5 * h, &w1));
        let rate_3 = ahead(&rate, 0.5 * h, &r2);
        let (r3, w3) = middle.of(&rate_3, &ahead(&drift, 0.5 * h, &w2));
        let rate_4 = ahead(&rate, h, &r3);
        let (r4, w4) = end.of(&rate_4, &ahead(&drift, h, &w3));
        let mut heading = [0.0; COLUMNS];
        for i in 0..COLUMNS {
            heading[i] = (rate[i] + 2.0 * (rate_2[i] + rate_3[i]) + rate_4[i]) * (h / 6.0);
            rate[i] += (r1[i] + 2.0 * (r2[i] + r3[i]) + r4[i]) * (h / 6.0);
            drift[i] += (w1[i] + 2.0 * (w2[i] + w3[i]) + w4[i]) * (h / 6.0);
        }
        Self {
            heading,
            rate,
            drift,
        }
    }

    /// The sensitivities of heading, yaw rate and drift at comparison `i`.
    pub(super) fn column(&self, i: usize) -> [f64; 3] {
        [self.heading[i], self.rate[i], self.drift[i]]
    }

    /// What it does to deviations, over `h` s.
    pub(super) fn passage(&self, h: f64) -> Passage {
        Passage {
            interval_s: h,
            state: [
                [self.rate[TO_RATE], self.rate[TO_DRIFT]],
                [self.drift[TO_RATE], self.drift[TO_DRIFT]],
            ],
            heading_s: [self.heading[TO_RATE], self.heading[TO_DRIFT]],
            to_rate: self.column(TO_INPUT),
            is_same: false,
        }
    }
}

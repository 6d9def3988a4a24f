//! The order of the yaw model that a record supports, and the model of that order.

use serde::{Deserialize, Serialize};

use super::model::SwayYawModel;
use super::residual_tests::ResidualTests;

/// Likelihood ratio that each parameter more must bring, in log n. Schwarz's 1 is for one structure whose parameters the
/// simpler model determines; here the best of seven is taken, and a11 means nothing without sway. Set on simulated
/// first-order plants.
const PRICE: f64 = 1.5;

/// What the yaw model has besides the first order's a22, b2 and C0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Structure {
    /// Sway acts on yaw in proportion: a21.
    pub sway_coupling: bool,
    /// Drift damps the yaw rate: k.
    pub cross_flow: bool,
    /// The rudder lags: T_d.
    pub rudder_lag: bool,
}

impl Structure {
    /// The first-order model.
    pub const FIRST_ORDER: Self = Self {
        sway_coupling: false,
        cross_flow: false,
        rudder_lag: false,
    };

    /// A first-order vehicle behind a slow servo.
    pub const LAGGING_RUDDER: Self = Self {
        rudder_lag: true,
        ..Self::FIRST_ORDER
    };

    /// Sway in proportion alone: the second-order Nomoto model.
    pub const LINEAR: Self = Self {
        sway_coupling: true,
        ..Self::FIRST_ORDER
    };

    /// Has yaw a second state?
    pub fn has_sway(&self) -> bool {
        self.sway_coupling || self.cross_flow
    }

    /// The likelihood ratio against first order that chance explains, by the number of comparisons.
    pub fn price(&self, comparisons: usize) -> f64 {
        PRICE * self.extra_parameters() as f64 * libm::log(comparisons as f64)
    }

    /// Parameters besides a22, b2 and C0.
    pub fn extra_parameters(&self) -> usize {
        [
            self.sway_coupling,
            self.cross_flow,
            self.has_sway(),
            self.rudder_lag,
        ]
        .into_iter()
        .filter(|has| *has)
        .count()
    }

    /// In words.
    pub fn in_words(&self) -> &'static str {
        match (self.sway_coupling, self.cross_flow, self.rudder_lag) {
            (false, false, false) => "first order",
            (false, false, true) => "first order with a lagging rudder",
            (true, false, false) => "second order",
            (true, false, true) => "second order with a lagging rudder",
            (false, true, false) => "sway and yaw coupled by cross-flow damping",
            (false, true, true) => {
                "sway and yaw coupled by cross-flow damping, with a lagging rudder"
            }
            (true, true, false) => "second order with cross-flow damping",
            (true, true, true) => "second order with cross-flow damping and a lagging rudder",
        }
    }
}

/// 95 % intervals, each `[low, high]`; `None` where the structure does without the parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SwayYawIntervals {
    /// a22, 1/s.
    pub a22_per_s: [f64; 2],
    /// b2, 1/s^2.
    pub b2_per_s2: [f64; 2],
    /// C0, rad/s^2.
    pub c0_rad_per_s2: [f64; 2],
    /// a21, 1/s^2.
    pub a21_per_s2: Option<[f64; 2]>,
    /// a11, 1/s.
    pub a11_per_s: Option<[f64; 2]>,
    /// k, 1/(rad s).
    pub cross_flow_per_rad_s: Option<[f64; 2]>,
    /// T_d, s.
    pub rudder_lag_s: Option<[f64; 2]>,
}

/// Why this order: what a verdict can say in words.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelOrder {
    /// The structure that the record supports.
    pub structure: Structure,
    /// Twice the log likelihood of the best structure that has more than the first order, less that of the
    /// first order.
    pub likelihood_ratio: f64,
    /// The least likelihood ratio of that structure when first order may blame a disturbance that the quiet part of
    /// the record allows.
    pub cautious_likelihood_ratio: f64,
    /// What both must exceed: 1.5 log n for each parameter more.
    pub threshold: f64,
    /// Comparisons n.
    pub comparisons: usize,
    /// Tests of the prediction errors of the first order.
    pub first_order_residual: Option<ResidualTests>,
}

impl ModelOrder {
    /// Does the record ask for more than the first order?
    pub fn exceeds_first_order(&self) -> bool {
        self.structure != Structure::FIRST_ORDER
    }

    /// Is the first order not to be relied upon, even if what it misses cannot be named? Schwarz's price decides.
    pub fn leans_beyond_first_order(&self) -> bool {
        self.evidence() > self.threshold / PRICE
    }

    /// Does the likelihood ratio that counts exceed what chance explains?
    pub fn is_beyond_chance(&self) -> bool {
        self.evidence() > self.threshold
    }

    /// The likelihood ratio that counts: the smaller one.
    pub fn evidence(&self) -> f64 {
        self.likelihood_ratio.min(self.cautious_likelihood_ratio)
    }
}

impl std::fmt::Display for ModelOrder {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let ratio = self.evidence();
        let threshold = self.threshold;
        if self.exceeds_first_order() {
            write!(
                f,
                "the record asks for {}: its likelihood ratio against first order is at least {ratio:.1}, \
                 where chance explains {threshold:.1}",
                self.structure.in_words()
            )
        } else {
            write!(
                f,
                "first order is enough: the best model with more has a likelihood ratio of \
                 {ratio:.1}, where chance explains {threshold:.1}"
            )
        }
    }
}

/// The model of the order that a record supports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SecondOrder {
    /// The decision.
    pub order: ModelOrder,
    /// The parameters; those that the structure does without are 0.
    pub model: SwayYawModel,
    /// 95 % intervals, given the structure.
    pub interval_95: SwayYawIntervals,
    /// Covariance of [a22, b2, C0], given the structure.
    pub covariance: [[f64; 3]; 3],
    /// Standard deviation of the heading noise found, rad.
    pub heading_noise_rad: f64,
    /// Standard deviation of the yaw acceleration disturbance, rad/s^2, where the record asks for one.
    pub disturbance_rad_s2: Option<f64>,
}

impl SecondOrder {
    /// Is the vehicle of first order behind a lag that the record determines? Of two equal poles neither is known.
    pub fn is_first_order_behind_a_lag(&self) -> bool {
        self.order.structure == Structure::LAGGING_RUDDER
            && self
                .interval_95
                .rudder_lag_s
                .is_some_and(|[shortest_s, _]| shortest_s > 0.0)
    }
}

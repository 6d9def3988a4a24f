//! Second link of the chain: which kind of vehicle explains the record.

use super::OrderSearch;
use super::misfit::is_large_share;
use super::prepared::Prepared;
use super::second_order;
use super::whole_record::robust_estimate;
use crate::identification::{LagEffect, Refined};
use crate::sway_yaw::{ResidualTests, SecondOrder};

/// Which kind of vehicle explains the record. The `share` of a misfit is that of the rudder's own effect.
#[derive(Clone, Debug)]
pub enum Explained {
    /// A first-order vehicle.
    FirstOrder {
        /// The estimate.
        fit: FirstOrderFit,
    },
    /// A first-order vehicle that something other than the rudder turns.
    Disturbed {
        /// The estimate.
        fit: FirstOrderFit,
        /// The disturbance.
        share: f64,
    },
    /// A first-order vehicle whose rudder lags.
    BehindLag {
        /// The estimate behind the lag.
        refined: Refined,
        /// What a rudder that acts at once leaves unexplained.
        share: f64,
        /// The model behind the lag.
        lagging: SecondOrder,
    },
    /// A vehicle that is not of first order.
    HigherOrder {
        /// The first-order vehicle whose simulation is nearest.
        refined: Refined,
        /// Its misfit.
        share: f64,
        /// The model of higher order, where the record can name it.
        beyond: Option<SecondOrder>,
    },
    /// A first-order vehicle, as far as is known: the hidden edges of the rudder matter more than the noise.
    Blurred {
        /// The first-order estimate.
        refined: Refined,
    },
    /// Nothing was refined: it was not asked for, or no peak of the likelihood was found.
    Unrefined,
}

/// A refined first-order estimate that describes its record.
#[derive(Clone, Debug)]
pub struct FirstOrderFit {
    /// The estimate.
    pub refined: Refined,
    /// Are its prediction errors white?
    pub residual: Option<ResidualTests>,
    /// What a rudder lag that the log does not contain would do to it.
    pub lag_effect: Option<LagEffect>,
    /// Lag and shift of the rudder together, s.
    pub delay_s: f64,
    /// Covariance of [a22, b2, C0], were that known to be so.
    pub covariance_given_delay: [[f64; 3]; 3],
}

impl Explained {
    /// Estimates from the whole record and asks what a first-order vehicle leaves unexplained.
    pub(super) fn of(prepared: &Prepared, order: OrderSearch) -> Self {
        let samples = prepared.samples();
        let found = prepared
            .is_to_be_refined()
            .then(|| robust_estimate(samples).ok())
            .flatten();
        let Some(found) = found else {
            return Self::Unrefined;
        };
        let share = found.robust.share;
        if prepared.is_blurred(&found.refined) {
            return Self::Blurred {
                refined: found.refined,
            };
        }
        if found.is_nearest() {
            return Self::HigherOrder {
                beyond: match order {
                    OrderSearch::Done => second_order::fit(samples)
                        .ok()
                        .filter(|estimate| estimate.order.exceeds_first_order()),
                    OrderSearch::Skipped => None,
                },
                refined: found.refined,
                share,
            };
        }
        if let (Some(lagging), Some(lag)) = (found.lagging(), found.robust.lag) {
            return Self::BehindLag {
                refined: found.refined,
                share: lag.share_without,
                lagging,
            };
        }
        let fit = FirstOrderFit {
            lag_effect: found.lag_effect(),
            delay_s: found.delay_s(),
            covariance_given_delay: found.robust.covariance_given_delay,
            residual: found.residual,
            refined: found.refined,
        };
        match is_large_share(share) {
            true => Self::Disturbed { fit, share },
            false => Self::FirstOrder { fit },
        }
    }

    /// Misfit of a first-order model, a share of the rudder's effect, where the vehicle is not of first order.
    pub fn structural_misfit(&self) -> Option<f64> {
        match self {
            Self::BehindLag { share, .. } | Self::HigherOrder { share, .. } => Some(*share),
            _ => None,
        }
    }

    /// Lag and shift of the rudder together, s, where a first-order vehicle describes its record.
    pub fn delay_s(&self) -> Option<f64> {
        match self {
            Self::BehindLag { lagging, .. } => Some(lagging.model.rudder_lag_s),
            _ => self.first_order().map(|fit| fit.delay_s),
        }
    }

    /// The estimate of a vehicle of first order that describes its record.
    pub fn first_order(&self) -> Option<&FirstOrderFit> {
        match self {
            Self::FirstOrder { fit } | Self::Disturbed { fit, .. } => Some(fit),
            _ => None,
        }
    }

    /// The model of the order that the record supports, where that is more than the first.
    pub fn higher_order(&self) -> Option<&SecondOrder> {
        match self {
            Self::HigherOrder { beyond, .. } => beyond.as_ref(),
            Self::BehindLag { lagging, .. } => Some(lagging),
            Self::FirstOrder { .. }
            | Self::Disturbed { .. }
            | Self::Blurred { .. }
            | Self::Unrefined => None,
        }
    }
}

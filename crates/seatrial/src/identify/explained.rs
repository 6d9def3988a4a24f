//! Second link of the chain: which kind of vehicle explains the record.

use super::OrderSearch;
use super::misfit::is_large_share;
use super::prepared::Prepared;
use super::second_order;
use super::whole_record::robust_estimate;
use crate::identification::{LagEffect, Refined};
use crate::sway_yaw::{ResidualTests, SecondOrder};
use seatrial_core::Sample;

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
        lagging: Box<SecondOrder>,
        /// Play of the rudder, rad, where the record asks for it.
        play_rad: Option<f64>,
    },
    /// A vehicle that is not of first order.
    HigherOrder {
        /// The first-order vehicle whose simulation is nearest.
        refined: Refined,
        /// Its misfit.
        share: f64,
        /// Models of higher order, the likeliest first, where the record can name them.
        beyond: Vec<SecondOrder>,
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
    /// Play of the rudder from stop to stop, rad, where the record asks for it.
    pub play_rad: Option<f64>,
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
                    OrderSearch::Done => models_beyond_first_order(samples),
                    OrderSearch::Skipped => Vec::new(),
                },
                refined: found.refined,
                share,
            };
        }
        if let (Some(lagging), Some(lag)) = (found.lagging(), found.robust.lag) {
            return Self::BehindLag {
                refined: found.refined,
                share: lag.share_without,
                lagging: Box::new(lagging),
                play_rad: found.robust.play_rad,
            };
        }
        let fit = FirstOrderFit {
            lag_effect: found.lag_effect(),
            delay_s: found.delay_s(),
            covariance_given_delay: found.robust.covariance_given_delay,
            play_rad: found.robust.play_rad,
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

    /// Play of the rudder from stop to stop, rad, where the record asks for it.
    pub fn play_rad(&self) -> Option<f64> {
        match self {
            Self::BehindLag { play_rad, .. } => *play_rad,
            _ => self.first_order()?.play_rad,
        }
    }

    /// The estimate of a vehicle of first order that describes its record.
    pub fn first_order(&self) -> Option<&FirstOrderFit> {
        match self {
            Self::FirstOrder { fit } | Self::Disturbed { fit, .. } => Some(fit),
            _ => None,
        }
    }

    /// The models of the orders that the record supports, where that is more than the first; the likeliest first.
    pub fn higher_orders(&self) -> &[SecondOrder] {
        match self {
            Self::HigherOrder { beyond, .. } => beyond,
            Self::BehindLag { lagging, .. } => std::slice::from_ref(&**lagging),
            Self::FirstOrder { .. }
            | Self::Disturbed { .. }
            | Self::Blurred { .. }
            | Self::Unrefined => &[],
        }
    }
}

/// The likeliest first.
fn models_beyond_first_order(samples: &[Sample<f64>]) -> Vec<SecondOrder> {
    match second_order::fit_all(samples) {
        Ok(found) if found.likeliest.order.exceeds_first_order() => {
            let mut models = found.others;
            models.insert(0, found.likeliest);
            models
        }
        _ => Vec::new(),
    }
}

//! Second link of the chain: which kind of vehicle explains the record.

use super::lag::LagTest;
use super::misfit::Misfit;
use super::prepared::Prepared;
use super::refined::refined_estimate;
use crate::identification::{LagEffect, Refined};
use crate::sway_yaw::{ResidualTests, SecondOrder};

/// Which kind of vehicle explains the record. The `share` of a misfit is that of the rudder's own effect.
#[derive(Clone, Debug)]
pub enum Explained {
    /// A first-order vehicle.
    FirstOrder {
        /// The estimate.
        fit: FirstOrderFit,
        /// A model beyond the first order that is likelier, but explains no more than a small misfit.
        beyond: Option<SecondOrder>,
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
        /// The estimate that takes the lag for damping and a disturbance.
        refined: Refined,
        /// Its misfit.
        share: f64,
        /// The model behind the lag.
        lagging: SecondOrder,
    },
    /// A vehicle that is not of first order.
    HigherOrder {
        /// The first-order estimate.
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
}

impl Explained {
    /// Refines the online estimate and measures the misfit of the refined one.
    pub fn of(prepared: &Prepared) -> Self {
        let samples = prepared.samples();
        let refined = prepared
            .is_to_be_refined()
            .then(|| refined_estimate(samples, Some(prepared.online)).ok())
            .flatten();
        let Some(refined) = refined else {
            return Self::Unrefined;
        };
        if prepared.is_blurred(&refined) {
            return Self::Blurred { refined };
        }
        let lag = LagTest::of(samples, &refined);
        let amplitude_rad = prepared.log.rudder_amplitude_rad;
        let fit = |refined: Refined| FirstOrderFit {
            residual: lag.and_then(|lag| lag.residual),
            lag_effect: lag.and_then(|lag| lag.effect_of_an_ordinary_lag(samples, &refined)),
            refined,
        };
        match Misfit::of(samples, &refined, amplitude_rad, lag) {
            Some(misfit) if misfit.is_structural() => Self::beyond_first_order(refined, misfit),
            Some(misfit) if misfit.is_large() => Self::Disturbed {
                fit: fit(refined),
                share: misfit.share,
            },
            misfit => Self::FirstOrder {
                fit: fit(refined),
                beyond: misfit.and_then(Misfit::higher_order),
            },
        }
    }

    fn beyond_first_order(refined: Refined, misfit: Misfit) -> Self {
        let share = misfit.share;
        match misfit.higher_order() {
            Some(lagging) if lagging.is_first_order_behind_a_lag() => Self::BehindLag {
                refined,
                share,
                lagging,
            },
            beyond => Self::HigherOrder {
                refined,
                share,
                beyond,
            },
        }
    }

    /// Misfit of a first-order model, a share of the rudder's effect, where the vehicle is not of first order.
    pub fn structural_misfit(&self) -> Option<f64> {
        match self {
            Self::BehindLag { share, .. } | Self::HigherOrder { share, .. } => Some(*share),
            _ => None,
        }
    }

    /// The estimate of a vehicle of first order that describes its record.
    pub fn first_order(&self) -> Option<&FirstOrderFit> {
        match self {
            Self::FirstOrder { fit, .. } | Self::Disturbed { fit, .. } => Some(fit),
            _ => None,
        }
    }

    /// The model of the order that the record supports, where that is more than the first.
    pub fn higher_order(&self) -> Option<&SecondOrder> {
        match self {
            Self::FirstOrder { beyond, .. } | Self::HigherOrder { beyond, .. } => beyond.as_ref(),
            Self::BehindLag { lagging, .. } => Some(lagging),
            Self::Disturbed { .. } | Self::Blurred { .. } | Self::Unrefined => None,
        }
    }
}

//! Second link of the chain: which kind of vehicle explains the record.

use super::OrderSearch;
use super::beyond::{beyond_first_order, is_a_sea, is_telling};
use super::excited_segment::most_excited;
use super::heading_gain::Vehicles;
use super::misfit::{disturbance_share, is_large_share};
use super::residual_tests::ResidualTests;
use super::steering_validation;
use super::training_record::TrainingRecord;
use super::validation::ValidationData;
use super::whole_record::{WholeRecord, robust_estimate};
use crate::identification::{HigherOrder, LagEffect, Refined};
use crate::likelihood::{Parameter, SteeringModel, contest_of};

/// Which kind of vehicle explains the record. The `share` of a misfit is that of the rudder's own effect.
#[derive(Clone, Debug)]
pub enum Explanation {
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
        lagging: Box<HigherOrder>,
        /// Play of the rudder, rad, where the record asks for it.
        play_rad: Option<f64>,
    },
    /// A vehicle that is not of first order.
    HigherOrder {
        /// The first-order vehicle that is nearest.
        refined: Refined,
        /// Its misfit.
        share: f64,
        /// The model of higher order, where the contest of hypotheses names one.
        beyond: Option<Box<HigherOrder>>,
        /// Is the first-order vehicle the one whose simulation is nearest, not the one with the same steady turn?
        nearest: bool,
        /// The first-order estimate by itself, which validation data are compared with.
        alone: Option<Box<Refined>>,
        /// The vehicles that explain the record alike, which the heading gain must hold on, where the contest names some.
        vehicles: Option<Vehicles>,
        /// Play of the rudder, rad, where the record asks for it.
        play_rad: Option<f64>,
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

impl Explanation {
    /// Estimates from the whole record and asks what a first-order vehicle leaves unexplained.
    pub(super) fn of(
        training_record: &TrainingRecord,
        order: OrderSearch,
        data: Option<ValidationData>,
    ) -> Self {
        let samples = training_record.samples();
        let found =
            training_record.is_to_be_refined().then(|| robust_estimate(samples).ok()).flatten();
        let Some(found) = found else {
            return Self::Unrefined;
        };
        if training_record.is_blurred(&found.refined) {
            return Self::Blurred { refined: found.refined };
        }
        let found = match order == OrderSearch::Done && found.asks_for_more(samples) {
            true => match Self::by_contest(training_record, found, data) {
                Ok(explanation) => return explanation,
                Err(found) => *found,
            },
            false => found,
        };
        let share = found.robust.share;
        if found.is_nearest() {
            return Self::HigherOrder {
                beyond: None,
                refined: found.refined,
                share,
                nearest: true,
                alone: None,
                vehicles: None,
                play_rad: None,
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

    /// The whole table of hypotheses against the record; the first-order estimate where it is that of a sea, or nothing better is known.
    ///
    /// What a sea explains as well as a hull does is the hull's where this predicts the validation data much better.
    fn by_contest(
        training_record: &TrainingRecord,
        found: WholeRecord,
        data: Option<ValidationData>,
    ) -> Result<Self, Box<WholeRecord>> {
        let samples = training_record.samples();
        let mut legs = Vec::new();
        let Some(contest) = contest_of(most_excited(samples), &mut legs) else {
            return Err(Box::new(found));
        };
        let is_a_sea = is_a_sea(&contest, found.is_nearest());
        let (contest, sea) = match is_a_sea {
            true => (contest.clone().calm(), Some(contest.in_a_sea())),
            false => (contest, None),
        };
        let amplitude_rad = training_record.log.rudder_amplitude_rad;
        let (hull, beyond) = beyond_first_order(&contest, amplitude_rad);
        let sea = sea.and_then(|sea| {
            let (refined, beyond) = beyond_first_order(&sea, amplitude_rad);
            Some((refined?, beyond))
        });
        let first_order = match &sea {
            Some((_, sea)) => sea.model,
            None => found.steering_model(),
        };
        let is_proven = predicts_much_better(&beyond.model, &first_order, data);
        if is_a_sea && !is_proven {
            return Self::in_a_sea(sea, found, amplitude_rad);
        }
        if hull.is_none() && !found.is_nearest() {
            return Err(Box::new(found));
        }
        let interval_s = training_record.interval_s.unwrap_or(0.0);
        let share = found.robust.share;
        let told = hull.filter(is_telling);
        let vehicles = Some(Vehicles::of(&contest, interval_s, amplitude_rad));
        let is_play = found.robust.play_rad.is_some() || contest.asks_for_play();
        Ok(Self::HigherOrder {
            play_rad: beyond.model.play_rad.filter(|_| is_play),
            alone: Some(Box::new(found.refined.clone())),
            nearest: told.is_none(),
            refined: told.unwrap_or(found.refined),
            share,
            beyond: Some(Box::new(beyond)),
            vehicles,
        })
    }

    /// A first-order vehicle in a sea: as the contest sees it where the robust estimate takes the sea for a hull.
    fn in_a_sea(
        sea: Option<(Refined, HigherOrder)>,
        found: WholeRecord,
        amplitude_rad: f64,
    ) -> Result<Self, Box<WholeRecord>> {
        let (true, Some((refined, lagging))) = (found.is_nearest(), sea) else {
            return Err(Box::new(found));
        };
        let share = disturbance_share(&refined, amplitude_rad);
        if lagging.structure.has(Parameter::Lag) {
            return Ok(Self::BehindLag {
                refined,
                share: found.robust.share,
                lagging: Box::new(lagging),
                play_rad: None,
            });
        }
        let fit = FirstOrderFit {
            residual: found.residual,
            lag_effect: None,
            delay_s: lagging.model.rudder_lag_s,
            covariance_given_delay: refined.covariance,
            play_rad: None,
            refined,
        };
        Ok(Self::Disturbed { fit, share })
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
            Self::BehindLag { play_rad, .. } | Self::HigherOrder { play_rad, .. } => *play_rad,
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

    /// The first-order estimates that one of validation data is compared with: the one that is handed over and, where it is that of another
    /// structure, the one by itself. None where the gear has a largest rate: it looks like another vehicle at another angle.
    pub fn compared<'a>(&'a self, refined: &'a Refined) -> Vec<&'a Refined> {
        let is_slow = |beyond: &HigherOrder| beyond.structure.has(Parameter::RateLimit);
        match self {
            Self::HigherOrder { beyond: Some(beyond), .. } if is_slow(beyond) => Vec::new(),
            Self::HigherOrder { nearest: false, alone: Some(alone), .. } => vec![refined, alone],
            _ => vec![refined],
        }
    }

    /// The vehicles that the heading gain must hold on, where there are others than the first-order one.
    pub fn vehicles(&self) -> Option<&Vehicles> {
        match self {
            Self::HigherOrder { vehicles, .. } => vehicles.as_ref(),
            _ => None,
        }
    }

    /// The model beyond first order, where there is one.
    pub fn beyond(&self) -> Option<&HigherOrder> {
        match self {
            Self::HigherOrder { beyond, .. } => beyond.as_deref(),
            Self::BehindLag { lagging, .. } => Some(lagging),
            _ => None,
        }
    }
}

/// A model is much better that leaves less than this of what the other one leaves of validation data, in mean square.
pub const MUCH_BETTER: f64 = 0.3;

/// Does this model leave less than a third of what the other one leaves of the heading of validation data, in mean square, and no more of the
/// yaw rate? A sea wanders into the heading, less into the yaw rate.
pub fn predicts_much_better(
    model: &SteeringModel,
    other: &SteeringModel,
    data: Option<ValidationData>,
) -> bool {
    let left = |model| {
        let data = data?;
        let found = steering_validation::validate(model, data.record, data.window).ok()?;
        Some([found.r2_heading_offset_refit?, found.r2_yaw_rate?].map(|r2| 1.0 - r2))
    };
    let (Some([heading, rate]), Some([other_heading, other_rate])) = (left(model), left(other))
    else {
        return false;
    };
    heading < MUCH_BETTER * other_heading && rate <= other_rate
}

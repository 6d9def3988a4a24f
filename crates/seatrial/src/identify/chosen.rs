//! Third link of the chain: the model that goes to the controller, and where it comes from.

use seatrial_core::YawModel;

use super::explained::Explained;
use super::joined::{self, Joined};
use super::prepared::Prepared;
use super::second_order::{SecondOrder, SwayYawModel};
use super::{output_error, refine};
use crate::identification::Refined;
use crate::record::Window;

/// Where the model that goes to the controller comes from.
#[derive(Clone, Debug)]
pub enum ModelSource {
    /// The online estimate by itself, without an interval.
    Online,
    /// The refined estimate of a first-order vehicle.
    Refined,
    /// The online estimate with the interval of output error.
    OnlineWithInterval,
    /// The first-order vehicle behind this lagging rudder.
    BehindLag(SwayYawModel),
}

/// The model that goes to the controller.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The model.
    pub model: YawModel<f64>,
    /// Where it comes from.
    pub source: ModelSource,
    /// The model with its interval; `None` where the online estimate stands by itself.
    pub refined: Option<Refined>,
    /// The manoeuvres of the same speed that it was joined with.
    pub joined: Option<Joined>,
}

impl Chosen {
    /// Chooses by what explains the record, widens the interval by what else is uncertain, and joins the refined estimates of
    /// other manoeuvres of the same speed.
    pub fn of(prepared: &Prepared, explained: &Explained, others: &[(Window, Refined)]) -> Self {
        let Some((estimate, origin)) = estimate(prepared, explained) else {
            return Self {
                model: prepared.online,
                source: ModelSource::Online,
                refined: None,
                joined: None,
            };
        };
        let widened = refine::widened(&estimate, &prepared.edge_covariance());
        let alone = match explained {
            Explained::Disturbed { .. } => refine::reaching(&widened, prepared.online),
            _ => widened,
        };
        let (refined, joined) = match joined::join(prepared.training, &alone, others) {
            Some((together, joined)) => (together, Some(joined)),
            None => (alone, None),
        };
        Self {
            model: refined.model,
            source: origin.source(refined.model),
            refined: Some(refined),
            joined,
        }
    }

    /// The model behind a lagging rudder, where that is the one that was chosen.
    pub fn lagging(&self) -> Option<&SwayYawModel> {
        match &self.source {
            ModelSource::BehindLag(lagging) => Some(lagging),
            _ => None,
        }
    }
}

/// From what an estimate was made, before other manoeuvres are joined to it.
enum Origin<'a> {
    Refined,
    Online,
    Lagging(&'a SecondOrder),
}

impl Origin<'_> {
    fn source(&self, model: YawModel<f64>) -> ModelSource {
        match self {
            Self::Refined => ModelSource::Refined,
            Self::Online => ModelSource::OnlineWithInterval,
            Self::Lagging(estimate) => ModelSource::BehindLag(SwayYawModel {
                a22_per_s: model.a22_per_s,
                b2_per_s2: model.b2_per_s2,
                c0_rad_per_s2: model.c0_rad_per_s2,
                ..estimate.model
            }),
        }
    }
}

/// The estimate by what explains the record. `None` where nothing was refined.
fn estimate<'a>(prepared: &Prepared, explained: &'a Explained) -> Option<(Refined, Origin<'a>)> {
    match explained {
        Explained::Unrefined => None,
        Explained::FirstOrder { fit, .. } | Explained::Disturbed { fit, .. } => {
            Some((fit.refined.clone(), Origin::Refined))
        }
        Explained::BehindLag {
            refined, lagging, ..
        } => Some((
            refine::behind_the_lag(refined, lagging),
            Origin::Lagging(lagging),
        )),
        Explained::HigherOrder { refined, .. } | Explained::Blurred { refined } => {
            let nearest = output_error::output_error(prepared.samples(), Some(prepared.online));
            Some(match nearest {
                Ok(nearest) => (
                    refine::around_online(refined, prepared.online, &nearest),
                    Origin::Online,
                ),
                Err(_) => (refined.clone(), Origin::Refined),
            })
        }
    }
}

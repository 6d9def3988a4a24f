//! Third link of the chain: the model that goes to the controller, and where it comes from.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::YawModel;

use super::explanation::Explanation;
use super::intervals;
use super::joint_estimate::{self, JointEstimate};
use super::output_error::{OutputError, output_error};
use super::steering_validation;
use super::training_record::TrainingRecord;
use super::validation::{self, ValidationData};
use crate::identification::HigherOrder;
use crate::identification::{EstimateMethod, Refined};
use crate::likelihood::SteeringModel;
use crate::record::Window;

/// R^2 of validation data by which a candidate predicts them clearly worse than another.
const CLEARLY_WORSE: f64 = 0.05;

/// Where the model that goes to the controller comes from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ModelSource {
    /// The online estimate by itself, without an interval.
    Online,
    /// The refined estimate of a first-order vehicle.
    Refined,
    /// The first-order vehicle whose simulation is nearest, of a vehicle of higher order.
    Nearest,
    /// The online estimate with the interval of output error.
    OnlineWithInterval,
    /// The first-order vehicle behind this lagging rudder.
    BehindLag(SteeringModel),
    /// The first-order vehicle with the steady turn of this one.
    Beyond(SteeringModel),
}

/// The model that goes to the controller.
#[derive(Clone, Debug)]
pub struct ModelChoice {
    /// The model.
    pub model: YawModel<f64>,
    /// Where it comes from.
    pub source: ModelSource,
    /// The model with its interval; `None` where the online estimate stands by itself.
    pub refined: Option<Refined>,
    /// The manoeuvres of the same speed that it was joined with.
    pub joined: Option<JointEstimate>,
}

impl ModelChoice {
    /// Chooses by what explains the record, widens the interval by what else is uncertain, and joins the refined estimates of
    /// other manoeuvres of the same speed.
    ///
    /// Where the vehicle is not of first order, the candidate is chosen that predicts the validation data better.
    pub fn of(
        training_record: &TrainingRecord,
        explanation: &Explanation,
        others: &[(Window, Refined)],
        data: Option<ValidationData>,
    ) -> Self {
        let Some((estimate, origin)) = estimate(training_record, explanation, data) else {
            return Self {
                model: training_record.online,
                source: ModelSource::Online,
                refined: None,
                joined: None,
            };
        };
        let alone = intervals::widened(&estimate, &training_record.edge_covariance());
        let (refined, joined) = match joint_estimate::join(training_record.training, &alone, others)
        {
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
    pub fn lagging(&self) -> Option<&SteeringModel> {
        match &self.source {
            ModelSource::BehindLag(lagging) => Some(lagging),
            _ => None,
        }
    }

    /// The model that is simulated where that is more than the first-order one.
    pub fn simulated(&self) -> Option<&SteeringModel> {
        match &self.source {
            ModelSource::BehindLag(model) | ModelSource::Beyond(model) => Some(model),
            _ => None,
        }
    }
}

/// From what an estimate was made, before other manoeuvres are joined to it.
enum Origin<'a> {
    Refined,
    Nearest,
    Online,
    Lagging(&'a HigherOrder),
    Beyond(&'a HigherOrder),
}

impl Origin<'_> {
    fn source(&self, model: YawModel<f64>) -> ModelSource {
        match self {
            Self::Refined => ModelSource::Refined,
            Self::Nearest => ModelSource::Nearest,
            Self::Online => ModelSource::OnlineWithInterval,
            Self::Beyond(estimate) => ModelSource::Beyond(estimate.model),
            Self::Lagging(estimate) => ModelSource::BehindLag(SteeringModel {
                a22_per_s: model.a22_per_s,
                b2_per_s2: model.b2_per_s2,
                c0_rad_per_s2: model.c0_rad_per_s2,
                ..estimate.model
            }),
        }
    }
}

/// The estimate by what explains the record. `None` where nothing was refined.
fn estimate<'a>(
    training_record: &TrainingRecord,
    explanation: &'a Explanation,
    data: Option<ValidationData>,
) -> Option<(Refined, Origin<'a>)> {
    match explanation {
        Explanation::Unrefined => None,
        Explanation::FirstOrder { fit } | Explanation::Disturbed { fit, .. } => {
            Some((fit.refined.clone(), Origin::Refined))
        }
        Explanation::BehindLag { refined, lagging, .. } => {
            Some((refined.clone(), Origin::Lagging(lagging)))
        }
        Explanation::HigherOrder {
            refined,
            beyond: Some(beyond),
            nearest: false,
            alone: Some(alone),
            ..
        } => {
            let (first, origin) = better_predicting(alone, training_record.online, data);
            Some(match predicts_worse(&beyond.model, &first.model, data) {
                true => (first, origin),
                false => (refined.clone(), Origin::Beyond(beyond)),
            })
        }
        Explanation::HigherOrder { refined, .. } => {
            Some(better_predicting(refined, training_record.online, data))
        }
        Explanation::Blurred { refined } => {
            let nearest = output_error(training_record.samples(), Some(training_record.online));
            Some(match nearest {
                Ok(nearest) => {
                    (around_online(refined, training_record.online, &nearest), Origin::Online)
                }
                Err(_) => (refined.clone(), Origin::Refined),
            })
        }
    }
}

/// Does the model beyond first order predict the heading of validation data worse than a first-order one, with the trained offset
/// or with the offset estimated again?
fn predicts_worse(
    model: &SteeringModel,
    first_order: &YawModel<f64>,
    data: Option<ValidationData>,
) -> bool {
    let scores = || {
        let beyond = steering_validation::heading_r2(model, data?);
        beyond.zip(validation::heading_r2(*first_order, data?))
    };
    scores().is_some_and(|(beyond, first)| beyond < first)
}

/// The online estimate, or the nearest simulation where that predicts the heading of the validation data clearly better with the offset
/// estimated again, and where there are none.
///
/// The interval covers what the two disagree about, unless one predicts the data clearly worse.
fn better_predicting<'a>(
    nearest: &Refined,
    online: YawModel<f64>,
    data: Option<ValidationData>,
) -> (Refined, Origin<'a>) {
    let score = |model| validation::heading_r2(model, data?);
    let lead = (score(online).zip(score(nearest.model)))
        .map(|(of_online, of_nearest)| of_online - of_nearest)
        .filter(|lead| *lead > -CLEARLY_WORSE);
    let Some(lead) = lead else {
        return (nearest.clone(), Origin::Nearest);
    };
    let shift = Vector3::from(online.theta()) - Vector3::from(nearest.model.theta());
    let apart = match lead < CLEARLY_WORSE {
        true => shift * shift.transpose(),
        false => Matrix3::zeros(),
    };
    let covariance = Matrix3::from(nearest.covariance) + apart;
    let method = EstimateMethod::InstrumentalVariable;
    let online = intervals::around(nearest, online, covariance, method);
    (online, Origin::Online)
}

/// The online estimate in place of the refined one, for a record of a vehicle that is not of first order.
///
/// The instrument weighs the manoeuvre's own frequencies and is least wrong there (mean R^2 of headings of validation data
/// 0.88 against 0.84 on the six-degree-of-freedom REMUS 100, of yaw rate 0.97 against 0.82 on the
/// free-running tanker KVLCC2). Its interval is that of output error with residuals correlated in time,
/// widened by the distance between the two estimates.
fn around_online(refined: &Refined, online: YawModel<f64>, simulated: &OutputError) -> Refined {
    let shift = Vector3::from(online.theta()) - Vector3::from(simulated.model.theta());
    let covariance = Matrix3::from(simulated.covariance) + shift * shift.transpose();
    intervals::around(refined, online, covariance, EstimateMethod::InstrumentalVariable)
}

//! Turning limits to either side, from models and over speed.

use seatrial::identification::with_steady_gain;
use seatrial_core::RudderUnit;
use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::turning::{RadiusMinimum, TurningOverSpeed};
use seatrial_core::{SchedulePoint, Side, Turn, YawModel};
use serde::Serialize;

use crate::Error;
use crate::models::{Estimate, ModelPoint, Models, TrialOrigin};

/// A U-turn under full rudder that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredUTurn {
    /// Speed before the turn, m/s.
    pub surge_speed_m_s: f64,
    /// Radius of a circle through its track, m.
    pub radius_m: f64,
}

/// `turn --json`.
#[derive(Clone, Debug, Serialize)]
pub struct TurningLimits {
    /// `seatrial.turn.v1`
    pub schema: &'static str,
    /// Where the models come from.
    pub source: String,
    /// Full rudder, in `rudder_unit`.
    pub rudder_limit_rad: f64,
    /// In what the rudder is.
    pub rudder_unit: RudderUnit,
    /// Heading change whose time is given, rad.
    pub heading_change_rad: f64,
    /// The trial that the models are of.
    pub trial: Option<String>,
    /// Radius of the measured U-turn over the model's steady radius at its speed.
    pub u_turn_ratio: Option<f64>,
    /// Why the models are not to be used, where the source says so.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rejected: Vec<String>,
    /// Where the rudder limit or the speed is beyond what a model was seen with.
    pub beyond_range: Vec<String>,
    /// Limits of each model.
    pub points: Vec<PointLimits>,
    /// Limits over speed, where at least two speeds are known.
    pub over_speed: Vec<OverSpeed>,
}

/// Limits of one model.
#[derive(Clone, Debug, Serialize)]
pub struct PointLimits {
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// The rudder's trim, rad.
    pub delta0_rad: Option<f64>,
    /// Nomoto's time constant, s.
    pub nomoto_t_s: Option<Estimate>,
    /// Nomoto's gain, 1/s.
    pub nomoto_k_per_s: Option<Estimate>,
    /// To starboard and to port.
    #[serde(rename = "hands")]
    pub sides: [SideLimits; 2],
}

/// Limits to one side.
#[derive(Clone, Debug, Serialize)]
pub struct SideLimits {
    /// The side.
    #[serde(rename = "hand")]
    pub side: Side,
    /// Why there is no turn to this side.
    pub refused: Option<String>,
    /// Full rudder with its sign, rad.
    pub rudder_rad: Option<f64>,
    /// Steady yaw rate, magnitude, rad/s.
    pub yaw_rate_rad_s: Option<Estimate>,
    /// Time until the yaw rate is within 2 %, s.
    pub rise_time_s: Option<Estimate>,
    /// Time of a U-turn, s.
    pub u_turn_time_s: Option<Estimate>,
    /// Its path over pi, m.
    pub u_turn_mean_radius_m: Option<Estimate>,
    /// Radius of the circle of a long turn, m.
    pub steady_turning_radius_m: Option<Estimate>,
    /// The steady radius times the ratio of the measured U-turn; the interval is the model's alone.
    pub circle_by_u_turn_m: Option<Estimate>,
    /// Time of the heading change with a yaw rate that rises and falls evenly, s.
    pub trapezoid_time_s: Option<Estimate>,
    /// Time of the heading change under full rudder, s.
    pub full_rudder_time_s: Option<Estimate>,
}

/// The paper's (52): mean a22, fitted b2, no offset.
#[derive(Clone, Debug, Serialize)]
pub struct OverSpeed {
    /// b2 over speed.
    #[serde(flatten)]
    pub fit: AuthorityFit<f64>,
    /// Mean a22, 1/s.
    pub mean_a22_per_s: f64,
    /// Speeds among which the least radius is looked for, m/s.
    pub searched_m_s: [f64; 2],
    /// The least radius.
    pub minimum: Option<RadiusMinimum<f64>>,
    /// Why there is none.
    pub refused: Option<String>,
}

impl TurningLimits {
    /// The limits of these models for a heading change, rad. The least radius is looked for up to a speed, m/s, or to the
    /// fastest model; the circles of a measured U-turn are those of the models times the ratio found there.
    pub fn of(
        models: &Models,
        heading_change_rad: f64,
        up_to_speed_m_s: Option<f64>,
        measured: Option<MeasuredUTurn>,
    ) -> Result<Self, Error> {
        if !heading_change_rad.is_finite() {
            return Err(Error::Setting("--heading-change-deg: expected a number".into()));
        }
        let u_turn_ratio = measured.map(|u_turn| ratio(u_turn, models)).transpose()?;
        let limits =
            |point: &ModelPoint| point_limits(point, models, heading_change_rad, u_turn_ratio);
        Ok(Self {
            schema: "seatrial.turn.v1",
            source: models.origin.clone(),
            rudder_limit_rad: models.rudder_limit_rad,
            rudder_unit: models.rudder_unit,
            heading_change_rad,
            trial: models.trial.as_ref().map(TrialOrigin::text),
            u_turn_ratio,
            rejected: models.rejected.clone(),
            beyond_range: models.beyond_range(),
            points: models.points.iter().map(limits).collect(),
            over_speed: over_speed(models, up_to_speed_m_s)?,
        })
    }

    /// Is there a side to which a model does not turn, or are the models not to be used?
    pub fn is_refused(&self) -> bool {
        if !self.rejected.is_empty() {
            return true;
        }
        let mut sides = self.points.iter().flat_map(|point| &point.sides);
        sides.any(|side| side.refused.is_some())
    }
}

/// Speeds outside the identified ones by this factor are too far for a ratio.
const FAR: f64 = 1.1;

/// The measured radius over the model's, mean of both sides and linear in speed between the points.
fn ratio(u_turn: MeasuredUTurn, source: &Models) -> Result<f64, Error> {
    let refused = |reason: &str| Error::Setting(format!("--measured-u-turn: {reason}"));
    let mut radii: Vec<[f64; 2]> = source
        .points
        .iter()
        .filter_map(|point| {
            let speed_m_s = point.point.surge_speed_m_s?;
            let known = with_steady_turn(point, source.rudder_limit_rad)?;
            let radius = |side| {
                let turn = Turn::new(&known.point.model, source.rudder_limit_rad, side).ok()?;
                Some(turn.steady_turning_radius_m(speed_m_s))
            };
            Some([speed_m_s, 0.5 * (radius(Side::Starboard)? + radius(Side::Port)?)])
        })
        .collect();
    radii.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let speed_m_s = u_turn.surge_speed_m_s;
    let (Some([slowest, _]), Some([fastest, _])) = (radii.first(), radii.last()) else {
        return Err(refused("no model here has a speed and turns to both sides"));
    };
    if speed_m_s < slowest / FAR || speed_m_s > fastest * FAR {
        return Err(refused(&format!(
            "{speed_m_s} m/s is far from the identified speeds, {slowest:.2} to {fastest:.2} m/s"
        )));
    }
    let above = radii.partition_point(|[speed, _]| *speed < speed_m_s);
    let predicted_m = match (above.checked_sub(1), radii.get(above)) {
        (Some(below), Some([v1, r1])) => {
            let [v0, r0] = radii[below];
            r0 + (r1 - r0) * (speed_m_s - v0) / (v1 - v0)
        }
        (Some(below), None) => radii[below][1],
        (None, _) => radii[0][1],
    };
    Ok(u_turn.radius_m / predicted_m)
}

/// Why there is no turn where the hypotheses leave it open.
const OPEN_TURN: &str = "the record does not show how tight a long turn gets: vehicles that explain it alike turn at very different rates; record a turn that is held until the yaw rate settles";

/// The model with the steady turn of the hypotheses that explain its record, where it is not made of them. `None` where they leave the turn open.
fn with_steady_turn(point: &ModelPoint, rudder_rad: f64) -> Option<ModelPoint> {
    let Some(turn) = point.steady_turn else {
        return Some(*point);
    };
    let log_gain = turn.log_gain_at(rudder_rad);
    let (model, covariance) =
        with_steady_gain(&point.point.model, &point.covariance.unwrap_or_default(), log_gain)?;
    let mut turning = *point;
    turning.point.model = model;
    turning.covariance = point.covariance.and(Some(covariance));
    Some(turning)
}

fn point_limits(
    point: &ModelPoint,
    source: &Models,
    heading_change_rad: f64,
    u_turn_ratio: Option<f64>,
) -> PointLimits {
    let SchedulePoint { thrust, surge_speed_m_s, model } = point.point;
    let turning = with_steady_turn(point, source.rudder_limit_rad);
    let limits = |side: Side| {
        let turn = |model: &YawModel<f64>| Turn::new(model, source.rudder_limit_rad, side);
        let of = |quantity: &dyn Fn(Turn<f64>) -> Option<f64>| {
            let known = turning.as_ref()?;
            known.estimate(|model| quantity(turn(model).ok()?))
        };
        let found = match &turning {
            Some(known) => turn(&known.point.model).map_err(|reason| reason.to_string()),
            None => Err(OPEN_TURN.into()),
        };
        SideLimits {
            side,
            refused: found.as_ref().err().cloned(),
            rudder_rad: found.ok().map(|turn| turn.rudder_rad),
            yaw_rate_rad_s: of(&|turn| Some(turn.yaw_rate_rad_s)),
            rise_time_s: of(&|turn| Some(turn.rise_time_s())),
            u_turn_time_s: of(&|turn| Some(turn.u_turn_time_s())),
            u_turn_mean_radius_m: of(&|turn| Some(turn.u_turn_mean_radius_m(surge_speed_m_s?))),
            steady_turning_radius_m: of(&|turn| {
                Some(turn.steady_turning_radius_m(surge_speed_m_s?))
            }),
            circle_by_u_turn_m: of(&|turn| {
                Some(u_turn_ratio? * turn.steady_turning_radius_m(surge_speed_m_s?))
            }),
            trapezoid_time_s: of(&|turn| Some(turn.trapezoid_time_s(heading_change_rad))),
            full_rudder_time_s: of(&|turn| Some(turn.full_rudder_time_s(heading_change_rad))),
        }
    };
    PointLimits {
        thrust,
        surge_speed_m_s,
        model,
        delta0_rad: model.delta0_rad(),
        nomoto_t_s: point.estimate(|model| Some(model.nomoto()?.t_s)),
        nomoto_k_per_s: point.estimate(|model| Some(model.nomoto()?.k_per_s)),
        sides: [Side::Starboard, Side::Port].map(limits),
    }
}

/// Both fits of b2 over speed, where at least two speeds are known.
fn over_speed(source: &Models, up_to: Option<f64>) -> Result<Vec<OverSpeed>, Error> {
    let points: Vec<SchedulePoint<f64>> =
        source.points.iter().map(|p| p.point).filter(|p| p.surge_speed_m_s.is_some()).collect();
    let mean_a22_per_s =
        points.iter().map(|p| p.model.a22_per_s).sum::<f64>() / points.len() as f64;
    let mut fits = Vec::new();
    for form in [AuthorityForm::ThroughZero, AuthorityForm::WithConstant] {
        let Ok(fit) = AuthorityFit::new(&points, form) else {
            if up_to.is_some() {
                return Err(Error::Setting(
                    "--up-to-speed needs a source with at least two different speeds".into(),
                ));
            }
            return Ok(fits);
        };
        let searched_m_s = [fit.speed_range_m_s[0], up_to.unwrap_or(fit.speed_range_m_s[1])];
        let minimum = TurningOverSpeed {
            a22_per_s: mean_a22_per_s,
            authority: fit,
            rudder_limit_rad: source.rudder_limit_rad,
        }
        .minimum_radius(searched_m_s[0], searched_m_s[1]);
        fits.push(OverSpeed {
            fit,
            mean_a22_per_s,
            searched_m_s,
            minimum: minimum.ok().flatten(),
            refused: minimum.err().map(|reason| reason.to_string()),
        });
    }
    Ok(fits)
}

#[cfg(test)]
mod tests {
    use seatrial::identification::SteadyTurn;

    use super::*;

    fn point(log_gain: Option<[f64; 2]>) -> ModelPoint {
        let mut point = ModelPoint::exact(SchedulePoint {
            thrust: None,
            surge_speed_m_s: Some(2.0),
            model: YawModel::from_theta([-1.0, 0.5, 0.0]),
        });
        point.covariance = Some([[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 0.0]]);
        point.steady_turn = log_gain.map(|log_gain| SteadyTurn { log_gain, at: None });
        point
    }

    #[test]
    fn exact_a_turn_is_as_tight_as_the_hypotheses_say() {
        let models = Models::given(YawModel::default(), None);
        let limits = |steady| point_limits(&point(steady), &models, 1.0, None).sides;
        let rate = |steady| limits(steady)[0].yaw_rate_rad_s.unwrap();
        assert!((rate(None).value - 0.5 * 0.26).abs() < 1e-12);
        // K of 0.8 1/s, known to a deviation of 5 %.
        let found = rate(Some([0.8_f64.ln(), 0.0025]));
        assert!((found.value - 0.8 * 0.26).abs() < 1e-12);
        let [low, high] = found.interval_95.unwrap();
        assert!(((high - low) / (2.0 * 1.96 * 0.05 * found.value) - 1.0).abs() < 1e-3);
        // A deviation of 50 %.
        let [one, other] = limits(Some([0.8_f64.ln(), 0.25]));
        assert!(one.yaw_rate_rad_s.is_none() && one.refused == other.refused);
        assert!(one.refused.unwrap().contains("how tight a long turn gets"));
    }
}

//! Do the models of one campaign, or of one log, fit together over speed? A model that is sound by itself may still be that of
//! another vehicle: a fin that broke between two speeds leaves every run's own validation intact.
//!
//! ```text
//! u rises with thrust
//! b2(u) between b2 ~ u^0 (rudder in the propeller's race) and b2 ~ u^2 (rudder in the free stream)
//! |a22|(u) does not fall as u rises
//! ```
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | u | `surge_speed_m_s` | m/s |
//! | a22 | `a22_per_s` | 1/s |
//! | b2 | `b2_per_s2` | 1/s^2 per rad of rudder |
//!
//! Source: lift of a foil at constant thrust settings, Fossen (2011), section 7.2; equation (51) of the paper is a case
//! of it. Each pair of neighbouring speeds is compared; two values part where their 95 % intervals, each widened by
//! `MODEL_SCATTER` for the manoeuvre itself, do not meet. Valid for speeds at least `LEAST_SPEED_RATIO` apart; closer
//! pairs are compared as equal speeds.
//!
//! Another load changes the moment of inertia: a22 and b2 change by one factor, which no pair of speeds shows. So all speeds are held
//! against one law with a step before the k-th of them:
//!
//! ```text
//! ln |a22| = alpha + q ln u + theta [k or faster]
//! ln |b2|  = beta  + p ln u + theta [k or faster]
//! ```
//!
//! by least squares weighted with the covariance of each model and `LAW_SCATTER`, and with beliefs on q and p. The step is noted where
//! it is more than `LEAST_STEP` standard deviations. Valid for three speeds or more. Of 20 rehearsals whose moment of inertia rises by a
//! quarter behind the second of five speeds, 20 were noted; of 60 sound ones of three vehicles, none.

use crate::identification::{EstimateMethod, Reason, ReasonCode, Refined, Subject};
use crate::identify::robust::symmetric::invert;
use crate::propagation::NORMAL_95;

/// Share by which a sound model of one speed differs from repeat to repeat beyond its interval: sea, trim, battery.
const MODEL_SCATTER: f64 = 0.1;

/// Speeds nearer than this ratio count as equal, and so does a speed that falls by less while thrust rises.
const LEAST_SPEED_RATIO: f64 = 1.03;

/// b2 may rise a little faster than u^2 where the fin's own efficiency rises with its Reynolds number.
const STEEPEST_AUTHORITY: f64 = 2.3;

/// Standard deviation of ln a22 and ln b2 of one sound vehicle about a power of the speed, beside that of the estimates.
const LAW_SCATTER: f64 = 0.05;

/// Belief on an exponent of the speed: mean and standard deviation. Damping grows from none to somewhat more than in proportion, the rudder's
/// effect from u to u^2.
const DAMPING_EXPONENT: [f64; 2] = [0.8, 0.8];
const AUTHORITY_EXPONENT: [f64; 2] = [1.3, 0.6];

/// Standard deviations from which a step of the law is noted: chance gives that in at most one sound campaign of ninety.
const LEAST_STEP: f64 = 3.0;

/// What one speed of a campaign or of a log gave.
#[derive(Clone, Copy, Debug)]
pub struct SpeedResult<'a> {
    /// Thrust as a fraction of full, where it is known.
    pub thrust: Option<f64>,
    /// Mean forward speed in training, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model and its intervals.
    pub refined: &'a Refined,
}

/// What contradicts the belief that one and the same vehicle ran all speeds; empty where nothing does.
///
/// `results` in any order; the reasons are in order of thrust, or of speed where a thrust is not known. Pairs without a speed
/// are compared by thrust alone; what has neither is left out.
pub fn contradictions(results: &[SpeedResult]) -> Vec<Reason> {
    let (ordered, knows_thrust) = in_order(results);
    ordered
        .windows(2)
        .filter(|pair| pair[0].0 < pair[1].0)
        .flat_map(|pair| of_neighbours(pair[0], pair[1], knows_thrust))
        .collect()
}

/// The results with their thrusts, or speeds where a thrust is not known, in that order; what has neither is left out.
fn in_order<'a, 'b>(results: &'b [SpeedResult<'a>]) -> (Vec<(f64, &'b SpeedResult<'a>)>, bool) {
    let knows_thrust = results.iter().all(|result| result.thrust.is_some());
    let order = |r: &SpeedResult| if knows_thrust { r.thrust } else { r.surge_speed_m_s };
    let ordered = results.iter().filter_map(|result| Some((order(result)?, result)));
    let mut ordered: Vec<(f64, &SpeedResult)> = ordered.collect();
    ordered.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    (ordered, knows_thrust)
}

/// What speaks for another load from one speed on: both parameters change by one factor beside what the speed explains.
pub(crate) fn load_change(results: &[SpeedResult]) -> Option<Reason> {
    let (ordered, knows_thrust) = in_order(results);
    let speeds: Option<Vec<LogSpeed>> = ordered.iter().map(|(_, at)| LogSpeed::of(at)).collect();
    let speeds = speeds.filter(|speeds| speeds.len() >= 3)?;
    let steps = (1..speeds.len()).filter_map(|k| Some((k, step_at(&speeds, k)?)));
    let (k, [step, deviation]) =
        steps.max_by(|(_, a), (_, b)| (a[0] / a[1]).abs().total_cmp(&(b[0] / b[1]).abs()))?;
    if step.abs() <= LEAST_STEP * deviation {
        return None;
    }
    let from = match knows_thrust {
        true => format!("{:.0} % thrust", 100.0 * ordered[k].0),
        false => format!("{:.2} m/s", ordered[k].0),
    };
    let percent = 100.0 * (libm::exp(step) - 1.0).abs();
    let slower = if step < 0.0 { "less" } else { "more" };
    Some(Reason {
        text: format!(
            "From {from} on the vehicle answers the rudder {slower} quickly than at the speeds below: its load may have changed in mid campaign."
        ),
        action:
            "Check that nothing shifted, came aboard or went, then repeat all speeds with one load."
                .into(),
        ..Reason::new(
            ReasonCode::SpeedsDiffer.of(Subject::Damping),
            format!(
                "from {from} on the damping and the rudder's effect are both {percent:.0} % {slower} than one law over the speeds explains, which is {:.1} standard deviations",
                (step / deviation).abs()
            ),
        )
    })
}

/// A model over its speed, in logarithms.
struct LogSpeed {
    speed: f64,
    /// Of |a22| and |b2|.
    values: [f64; 2],
    /// Inverse of their covariance.
    weights: [[f64; 2]; 2],
}

impl LogSpeed {
    fn of(at: &SpeedResult) -> Option<Self> {
        let refined = at.refined;
        let (model, intervals, covariance) =
            (&refined.model, &refined.interval_95, &refined.covariance);
        let share =
            |value: f64, [low, high]: [f64; 2]| ((high - low) / (2.0 * NORMAL_95 * value)).abs();
        let [a22, b2] = [
            share(model.a22_per_s, intervals.a22_per_s),
            share(model.b2_per_s2, intervals.b2_per_s2),
        ];
        let correlation = covariance[0][1] / (covariance[0][0] * covariance[1][1]).sqrt();
        let correlation = match correlation.is_finite() {
            true => correlation * (model.a22_per_s * model.b2_per_s2).signum(),
            false => 0.0,
        };
        let both = correlation * a22 * b2;
        let scatter = LAW_SCATTER * LAW_SCATTER;
        let (weights, _) = invert(&[[a22 * a22 + scatter, both], [both, b2 * b2 + scatter]])?;
        let logarithm = |value: f64| Some(libm::log(value.abs())).filter(|log| log.is_finite());
        Some(Self {
            speed: logarithm(at.surge_speed_m_s?)?,
            values: [logarithm(model.a22_per_s)?, logarithm(model.b2_per_s2)?],
            weights,
        })
    }
}

/// The step theta of the law before the k-th speed, and its standard deviation.
fn step_at(speeds: &[LogSpeed], k: usize) -> Option<[f64; 2]> {
    let (mut matrix, mut vector) = ([[0.0; 5]; 5], [0.0; 5]);
    for (exponent, [mean, deviation]) in [(1, DAMPING_EXPONENT), (3, AUTHORITY_EXPONENT)] {
        matrix[exponent][exponent] = 1.0 / (deviation * deviation);
        vector[exponent] = mean / (deviation * deviation);
    }
    for (at, one) in speeds.iter().enumerate() {
        let step = if at < k { 0.0 } else { 1.0 };
        let rows = [[1.0, one.speed, 0.0, 0.0, step], [0.0, 0.0, 1.0, one.speed, step]];
        for (m, left) in rows.iter().enumerate() {
            for (n, right) in rows.iter().enumerate() {
                let weight = one.weights[m][n];
                for ((row, value), left) in matrix.iter_mut().zip(&mut vector).zip(left) {
                    *value += weight * left * one.values[n];
                    for (cell, right) in row.iter_mut().zip(right) {
                        *cell += weight * left * right;
                    }
                }
            }
        }
    }
    let (inverse, _) = invert(&matrix)?;
    let step: f64 = (0..5).map(|j| inverse[4][j] * vector[j]).sum();
    Some([step, inverse[4][4].sqrt()])
}

/// Two neighbours, each with its thrust, or its speed where a thrust is not known.
fn of_neighbours(
    (low, slower): (f64, &SpeedResult),
    (high, faster): (f64, &SpeedResult),
    knows_thrust: bool,
) -> Vec<Reason> {
    let speed_ratio = match (slower.surge_speed_m_s, faster.surge_speed_m_s) {
        (Some(slow), Some(fast)) if slow > 0.0 => fast / slow,
        _ => high / low,
    };
    let places = match knows_thrust {
        true => format!("{:.0} and {:.0} % thrust", 100.0 * low, 100.0 * high),
        false => format!("{low:.2} and {high:.2} m/s"),
    };
    let factors = [1.0, libm::pow(speed_ratio.max(1.0), STEEPEST_AUTHORITY)];
    let reason = |code, change: &str, against: &str, detail: &str| Reason {
        text: format!("Between {places} {change}{against}."),
        ..Reason::new(code, format!("between {places} {change}{detail}, and repeat both speeds"))
    };
    let speed = (speed_ratio * LEAST_SPEED_RATIO < 1.0).then(|| {
        let percent = 100.0 * (1.0 - speed_ratio);
        reason(
            ReasonCode::SpeedsDiffer.of(Subject::Speed),
            &format!("the speed fell by {percent:.0} % although thrust rose"),
            "",
            ": look for a fouled or damaged propeller, a weak battery or a current",
        )
    });
    let parted = |code, name: &str, of: fn(&Refined) -> Magnitude| {
        let factor = factor_outside(of(slower.refined), of(faster.refined), factors)?;
        let percent = 100.0 * (factor - 1.0).abs();
        let moved = if factor < 1.0 { "fell" } else { "rose" };
        Some(reason(
            code,
            &format!("{name} {moved} by {percent:.0} %"),
            ", as that of one vehicle does not",
            &format!(
                " while the speed changed by a factor of {speed_ratio:.2}: one of the two models is not that of this vehicle; check the fins and the load"
            ),
        ))
    };
    let authority =
        parted(ReasonCode::SpeedsDiffer.of(Subject::Rudder), "the rudder's effect", |refined| {
            Magnitude::widened(refined.model.b2_per_s2, refined.interval_95.b2_per_s2)
        });
    let damping =
        parted(ReasonCode::SpeedsDiffer.of(Subject::Damping), "the yaw damping", |refined| {
            Magnitude::widened(refined.model.a22_per_s, refined.interval_95.a22_per_s)
        })
        .filter(|_| are_alike(slower.refined, faster.refined));
    let found = [authority, damping, speed].into_iter().flatten().collect();
    fin_and_propeller(found, &places)
}

/// Is the damping of both the same thing? A first-order vehicle with the steady turn and the slowness of one with sway has another damping than
/// the one whose simulation is nearest.
fn are_alike(one: &Refined, other: &Refined) -> bool {
    let [one, other] = [one, other].map(|r| r.method == EstimateMethod::WeighedHypotheses);
    one == other
}

/// A rudder that does less and a propeller that does less are one event, with one thing to do.
fn fin_and_propeller(mut found: Vec<Reason>, places: &str) -> Vec<Reason> {
    let at = |kind| found.iter().position(|reason| reason.kind() == kind);
    let (Some(authority), Some(speed)) = (
        at(ReasonCode::SpeedsDiffer.of(Subject::Rudder)),
        at(ReasonCode::SpeedsDiffer.of(Subject::Speed)),
    ) else {
        return found;
    };
    let speed = found.remove(speed);
    let authority = &mut found[authority];
    authority.text = format!(
        "Between {places} the rudder's effect changed and the speed fell although thrust rose: fin and propeller are not what they were."
    );
    authority.action =
        "Look at fins and propeller: something broke or is caught in them. Then repeat both speeds."
            .into();
    authority.detail += &format!("; {}", speed.measured());
    found
}

/// By which factor a parameter changed. `None` where the interval at the faster speed meets that of the slower speed
/// times some factor within `factors`: a change of speed explains it.
fn factor_outside(slower: Magnitude, faster: Magnitude, factors: [f64; 2]) -> Option<f64> {
    let expected = [slower.interval[0] * factors[0], slower.interval[1] * factors[1]];
    let meets = faster.interval[0] <= expected[1] && expected[0] <= faster.interval[1];
    (!meets).then(|| faster.value / slower.value).filter(|factor| factor.is_finite())
}

/// The size of a parameter, whose sign depends on the sense of the rudder, and its 95 % interval.
struct Magnitude {
    value: f64,
    interval: [f64; 2],
}

impl Magnitude {
    /// The interval widened by `MODEL_SCATTER` on either side.
    fn widened(value: f64, interval: [f64; 2]) -> Self {
        let [low, high] = match value < 0.0 {
            true => [-interval[1], -interval[0]],
            false => interval,
        };
        let scatter = MODEL_SCATTER * value.abs();
        Self { value: value.abs(), interval: [low - scatter, high + scatter] }
    }
}

#[cfg(test)]
mod tests {
    use seatrial_core::YawModel;

    use super::*;
    use crate::identification::Intervals;
    use crate::identification::ReasonKind;

    /// A model known to 3 %.
    fn refined(a22_per_s: f64, b2_per_s2: f64) -> Refined {
        let known_to_3_percent =
            |value: f64| [value - 0.03 * value.abs(), value + 0.03 * value.abs()];
        Refined {
            method: EstimateMethod::AveragedRestrictedLikelihood,
            model: YawModel { a22_per_s, b2_per_s2, c0_rad_per_s2: 0.0 },
            delta0_rad: None,
            interval_95: Intervals {
                a22_per_s: known_to_3_percent(a22_per_s),
                b2_per_s2: known_to_3_percent(b2_per_s2),
                c0_rad_per_s2: [-0.001, 0.001],
                delta0_rad: None,
            },
            covariance: [[0.0; 3]; 3],
            heading_noise_rad: 0.0,
            disturbance_rad_s2: 0.0,
        }
    }

    /// A speed of a campaign: thrust, 0 where it is not known, speed, a22 and b2.
    type Speed = (f64, f64, f64, f64);

    const TABLE_II: [Speed; 5] = [
        (0.6, 1.07, -0.91, 0.58),
        (0.7, 1.36, -0.99, 0.87),
        (0.8, 1.59, -1.07, 1.08),
        (0.9, 1.90, -1.31, 1.39),
        (1.0, 2.19, -1.51, 1.71),
    ];

    /// What a check says of these speeds.
    fn said<R>(speeds: &[Speed], check: impl Fn(&[SpeedResult]) -> R) -> R {
        let models: Vec<Refined> =
            speeds.iter().map(|(_, _, a22, b2)| refined(*a22, *b2)).collect();
        let results: Vec<SpeedResult> = speeds
            .iter()
            .zip(&models)
            .map(|((thrust, speed, ..), refined)| SpeedResult {
                thrust: Some(*thrust).filter(|thrust| *thrust > 0.0),
                surge_speed_m_s: Some(*speed),
                refined,
            })
            .collect();
        check(&results)
    }

    fn codes(speeds: &[Speed]) -> Vec<ReasonKind> {
        let reasons = said(speeds, contradictions).into_iter();
        reasons.map(|reason| reason.kind()).collect()
    }

    /// Table II of the paper: nothing in it is contradicted.
    #[test]
    fn val_paper_table_ii_is_one_vehicle() {
        assert_eq!(codes(&TABLE_II), []);
    }

    /// Each neighbour by itself is within what a speed explains; all together are not.
    #[test]
    fn exact_another_load_in_mid_campaign_is_seen() {
        assert_eq!(said(&TABLE_II, load_change), None);
        for from in [2, 3] {
            let loaded = |(k, of): (usize, &Speed)| match k < from {
                true => *of,
                false => (of.0, of.1, of.2 / 1.35, of.3 / 1.35),
            };
            let loaded: Vec<_> = TABLE_II.iter().enumerate().map(loaded).collect();
            let found = said(&loaded, load_change).unwrap();
            let place = format!("From {:.0} % thrust on", 100.0 * TABLE_II[from].0);
            assert!(found.text.starts_with(&place), "{found:?}");
            assert!(found.text.contains("less quickly"), "{found:?}");
        }
        assert_eq!(said(&TABLE_II[..2], load_change), None);
    }

    #[test]
    fn exact_a_broken_fin_is_seen() {
        let broken = [(0.6, 1.07, -0.91, 0.58), (0.7, 1.2, -0.95, 0.21)];
        assert_eq!(codes(&broken), [ReasonCode::SpeedsDiffer.of(Subject::Rudder)]);
        let swapped = [(0.7, 1.2, 0.95, -0.21), (0.6, 1.07, 0.91, -0.58)];
        assert_eq!(codes(&swapped), [ReasonCode::SpeedsDiffer.of(Subject::Rudder)]);
    }

    /// Only dampings of one kind of model are held against each other.
    #[test]
    fn exact_a_damping_beyond_first_order_is_not_held_against_one_of_first_order() {
        let mut models = [refined(-1.15, 0.54), refined(-0.46, 0.60)];
        let codes = |models: &[Refined; 2]| {
            let result = |at: usize| SpeedResult {
                thrust: Some([0.6, 0.7][at]),
                surge_speed_m_s: Some([1.07, 1.36][at]),
                refined: &models[at],
            };
            let found = contradictions(&[result(0), result(1)]).into_iter();
            found.map(|reason| reason.kind()).collect::<Vec<_>>()
        };
        assert_eq!(codes(&models), [ReasonCode::SpeedsDiffer.of(Subject::Damping)]);
        models[1].method = EstimateMethod::WeighedHypotheses;
        assert_eq!(codes(&models), []);
    }

    /// A log may not tell the thrust.
    #[test]
    fn exact_a_broken_fin_is_seen_without_thrust() {
        let broken = [(0.0, 1.2, -0.95, 0.21), (0.0, 1.07, -0.91, 0.58)];
        assert_eq!(codes(&broken), [ReasonCode::SpeedsDiffer.of(Subject::Rudder)]);
        let sound = [(0.0, 1.36, -0.99, 0.87), (0.0, 1.07, -0.91, 0.58)];
        assert_eq!(codes(&sound), []);
    }

    #[test]
    fn exact_a_fin_and_a_propeller_that_broke_are_one_cause() {
        let models = [refined(-0.91, 0.58), refined(-0.8, 0.2)];
        let result = |at: usize, speed| SpeedResult {
            thrust: Some([0.6, 0.7][at]),
            surge_speed_m_s: Some(speed),
            refined: &models[at],
        };
        let found = contradictions(&[result(0, 1.07), result(1, 0.84)]);
        let [only] = found.as_slice() else {
            panic!("{found:?}");
        };
        assert!(only.text.contains("fin and propeller"), "{only:?}");
        assert!(only.detail.contains("the speed fell by 21 %"), "{only:?}");
    }

    #[test]
    fn exact_a_speed_that_falls_is_seen() {
        let slower = [(0.6, 1.5, -0.9, 0.58), (0.7, 1.2, -0.9, 0.58)];
        assert_eq!(codes(&slower), [ReasonCode::SpeedsDiffer.of(Subject::Speed)]);
    }
}

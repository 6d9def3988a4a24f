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

use crate::identification::{Reason, ReasonCode, Refined};

/// Share by which a sound model of one speed differs from repeat to repeat beyond its interval: sea, trim, battery.
const MODEL_SCATTER: f64 = 0.1;

/// Speeds nearer than this ratio count as equal, and so does a speed that falls by less while thrust rises.
const LEAST_SPEED_RATIO: f64 = 1.03;

/// b2 may rise a little faster than u^2 where the fin's own efficiency rises with its Reynolds number.
const STEEPEST_AUTHORITY: f64 = 2.3;

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
    let knows_thrust = results.iter().all(|result| result.thrust.is_some());
    let order = |result: &SpeedResult| match knows_thrust {
        true => result.thrust,
        false => result.surge_speed_m_s,
    };
    let mut ordered: Vec<(f64, &SpeedResult)> = results
        .iter()
        .filter_map(|result| Some((order(result)?, result)))
        .collect();
    ordered.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    ordered
        .windows(2)
        .filter(|pair| pair[0].0 < pair[1].0)
        .flat_map(|pair| of_neighbours(pair[0], pair[1], knows_thrust))
        .collect()
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
        ..Reason::new(
            code,
            format!("between {places} {change}{detail}, and repeat both speeds"),
        )
    };
    let speed = (speed_ratio * LEAST_SPEED_RATIO < 1.0).then(|| {
        let percent = 100.0 * (1.0 - speed_ratio);
        reason(
            ReasonCode::SpeedFalls,
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
    let authority = parted(
        ReasonCode::AuthorityChanged,
        "the rudder's effect",
        |refined| Magnitude::widened(refined.model.b2_per_s2, refined.interval_95.b2_per_s2),
    );
    let damping = parted(ReasonCode::DampingChanged, "the yaw damping", |refined| {
        Magnitude::widened(refined.model.a22_per_s, refined.interval_95.a22_per_s)
    });
    let found = [authority, damping, speed].into_iter().flatten().collect();
    fin_and_propeller(found, &places)
}

/// A rudder that does less and a propeller that does less are one event, with one thing to do.
fn fin_and_propeller(mut found: Vec<Reason>, places: &str) -> Vec<Reason> {
    let at = |code| found.iter().position(|reason| reason.code == code);
    let (Some(authority), Some(speed)) =
        (at(ReasonCode::AuthorityChanged), at(ReasonCode::SpeedFalls))
    else {
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
    let expected = [
        slower.interval[0] * factors[0],
        slower.interval[1] * factors[1],
    ];
    let meets = faster.interval[0] <= expected[1] && expected[0] <= faster.interval[1];
    (!meets)
        .then(|| faster.value / slower.value)
        .filter(|factor| factor.is_finite())
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
        Self {
            value: value.abs(),
            interval: [low - scatter, high + scatter],
        }
    }
}

#[cfg(test)]
mod tests {
    use seatrial_core::YawModel;

    use super::*;
    use crate::identification::{EstimateMethod, Intervals};

    /// A model known to 3 %.
    fn refined(a22_per_s: f64, b2_per_s2: f64) -> Refined {
        let known_to_3_percent =
            |value: f64| [value - 0.03 * value.abs(), value + 0.03 * value.abs()];
        Refined {
            method: EstimateMethod::AveragedRestrictedLikelihood,
            model: YawModel {
                a22_per_s,
                b2_per_s2,
                c0_rad_per_s2: 0.0,
            },
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

    fn codes(speeds: &[(f64, f64, f64, f64)]) -> Vec<ReasonCode> {
        let models: Vec<Refined> = speeds
            .iter()
            .map(|(_, _, a22, b2)| refined(*a22, *b2))
            .collect();
        let results: Vec<SpeedResult> = speeds
            .iter()
            .zip(&models)
            .map(|((thrust, speed, ..), refined)| SpeedResult {
                thrust: Some(*thrust).filter(|thrust| *thrust > 0.0),
                surge_speed_m_s: Some(*speed),
                refined,
            })
            .collect();
        contradictions(&results)
            .into_iter()
            .map(|reason| reason.code)
            .collect()
    }

    /// Table II of the paper: nothing in it is contradicted.
    #[test]
    fn val_paper_table_ii_is_one_vehicle() {
        let paper = [
            (0.6, 1.07, -0.91, 0.58),
            (0.7, 1.36, -0.99, 0.87),
            (0.8, 1.59, -1.07, 1.08),
            (0.9, 1.90, -1.31, 1.39),
            (1.0, 2.19, -1.51, 1.71),
        ];
        assert_eq!(codes(&paper), []);
    }

    #[test]
    fn exact_a_broken_fin_is_seen() {
        let broken = [(0.6, 1.07, -0.91, 0.58), (0.7, 1.2, -0.95, 0.21)];
        assert_eq!(codes(&broken), [ReasonCode::AuthorityChanged]);
        let swapped = [(0.7, 1.2, 0.95, -0.21), (0.6, 1.07, 0.91, -0.58)];
        assert_eq!(codes(&swapped), [ReasonCode::AuthorityChanged]);
    }

    /// A log may not tell the thrust.
    #[test]
    fn exact_a_broken_fin_is_seen_without_thrust() {
        let broken = [(0.0, 1.2, -0.95, 0.21), (0.0, 1.07, -0.91, 0.58)];
        assert_eq!(codes(&broken), [ReasonCode::AuthorityChanged]);
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
        assert_eq!(codes(&slower), [ReasonCode::SpeedFalls]);
    }
}

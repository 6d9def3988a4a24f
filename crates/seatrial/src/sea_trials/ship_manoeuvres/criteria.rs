//! The criteria of MSC.137(76).

use serde::Serialize;

use super::{Stopping, TurningCircle, ZigZag};

/// What the IMO requires of one figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Criterion {
    /// The paragraph of MSC.137(76).
    pub clause: &'static str,
    /// The figure.
    pub name: &'static str,
    /// Its unit: `deg` or ship lengths.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// The most that is allowed.
    pub limit: f64,
    /// Does it hold?
    pub holds: bool,
}

/// Paragraph 5.3.4: the track reach of a stop with full astern is at most 15 ship lengths. An administration may allow 20 for a ship of large
/// displacement. Of a ship that was not dead in the water at the end there is no criterion.
///
/// ```
/// use seatrial::sea_trials::ship_manoeuvres::{Stopping, stopping_criterion};
///
/// let stop = |track_reach_m| Stopping {
///     is_dead_in_the_water: true,
///     track_reach_m,
///     head_reach_m: 900.0,
///     lateral_deviation_m: 50.0,
///     time_s: 300.0,
///     surge_speed_m_s: 7.0,
/// };
/// // 10 and 20 lengths of a ship of 100 m.
/// let holds = |stop| stopping_criterion(100.0, &stop).map(|criterion| criterion.holds);
/// assert_eq!([holds(stop(1000.0)), holds(stop(2000.0))], [Some(true), Some(false)]);
/// let coasting = Stopping { is_dead_in_the_water: false, ..stop(1000.0) };
/// assert_eq!(stopping_criterion(100.0, &coasting), None);
/// ```
pub fn stopping_criterion(length_m: f64, stop: &Stopping) -> Option<Criterion> {
    let reach = stop.track_reach_m / length_m;
    let criterion = criterion("5.3.4", "track reach of the stop", "L", reach, 15.0);
    stop.is_dead_in_the_water.then_some(criterion)
}

/// The criteria of a ship of this length at this speed, for the figures that are there:
///
/// ```text
/// 5.3.1    advance <= 4.5 L, tactical diameter <= 5 L
/// 5.3.2    track until 10 degrees of heading under 10 degrees of rudder <= 2.5 L
/// 5.3.3.1  first overshoot of the 10/10 <= 10 degrees for L/V < 10 s, 20 for L/V >= 30 s, else 5 + L/(2V)
/// 5.3.3.2  second overshoot of the 10/10 <= 25 degrees, 40, else 17.5 + 0.75 L/V
/// 5.3.3.3  first overshoot of the 20/20 <= 25 degrees
/// ```
///
/// with L in m and V in m/s. They are made for ships of 100 m and more with rudder and propeller.
///
/// ```
/// use seatrial::sea_trials::ship_manoeuvres::{TurningCircle, criteria};
/// use seatrial_core::Side;
///
/// let circle = TurningCircle {
///     side: Side::Starboard,
///     rudder_rad: 0.61,
///     advance_m: 400.0,
///     transfer_m: 200.0,
///     tactical_diameter_m: 550.0,
///     times_s: [60.0, 120.0],
/// };
/// // 4 of 4.5 lengths, and 5.5 of 5.
/// let holds =
///     criteria(100.0, 7.0, [None, None], &[circle]).iter().map(|c| c.holds).collect::<Vec<_>>();
/// assert_eq!(holds, [true, false]);
/// ```
pub fn criteria(
    length_m: f64,
    surge_speed_m_s: f64,
    zig_zags: [Option<&ZigZag>; 2],
    circles: &[TurningCircle],
) -> Vec<Criterion> {
    let [ten, twenty] = zig_zags;
    let turning = turning_ability(length_m, circles);
    let initial_turning = ten.map(|ten| {
        let reach = ten.initial_turning_track_m / length_m;
        criterion("5.3.2", "initial turning, track reach", "L", reach, 2.5)
    });
    let yaw_checking = yaw_checking_ability(length_m / surge_speed_m_s, ten, twenty);
    turning.into_iter().flatten().chain(initial_turning).chain(yaw_checking).collect()
}

/// 5.3.1, of the widest circle.
fn turning_ability(length_m: f64, circles: &[TurningCircle]) -> Option<[Criterion; 2]> {
    let widest = |of: fn(&TurningCircle) -> f64| {
        let widest_m = circles.iter().map(of).reduce(f64::max);
        widest_m.map(|widest_m| widest_m / length_m)
    };
    let (advance, diameter) = (widest(|c| c.advance_m)?, widest(|c| c.tactical_diameter_m)?);
    Some([
        criterion("5.3.1", "advance", "L", advance, 4.5),
        criterion("5.3.1", "tactical diameter", "L", diameter, 5.0),
    ])
}

/// 5.3.3, where `seconds` is L/V.
fn yaw_checking_ability(
    seconds: f64,
    ten: Option<&ZigZag>,
    twenty: Option<&ZigZag>,
) -> Vec<Criterion> {
    let between = |short: f64, long: f64, formula: f64| match seconds {
        s if s < 10.0 => short,
        s if s >= 30.0 => long,
        _ => formula,
    };
    let first = between(10.0, 20.0, 5.0 + 0.5 * seconds);
    let second = between(25.0, 40.0, 17.5 + 0.75 * seconds);
    [
        ("5.3.3.1", "first overshoot angle, 10/10", ten, 0, first),
        ("5.3.3.2", "second overshoot angle, 10/10", ten, 1, second),
        ("5.3.3.3", "first overshoot angle, 20/20", twenty, 0, 25.0),
    ]
    .into_iter()
    .filter_map(|(clause, name, zig_zag, k, limit_deg)| {
        let overshoot_rad = zig_zag?.overshoots_rad.get(k)?;
        Some(criterion(clause, name, "deg", overshoot_rad.to_degrees(), limit_deg))
    })
    .collect()
}

fn criterion(
    clause: &'static str,
    name: &'static str,
    unit: &'static str,
    value: f64,
    limit: f64,
) -> Criterion {
    Criterion { clause, name, unit, value, limit, holds: value <= limit }
}

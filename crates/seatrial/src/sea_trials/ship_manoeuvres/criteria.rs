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
pub fn stopping_criterion(length_m: f64, stop: &Stopping) -> Option<Criterion> {
    let value = stop.track_reach_m / length_m;
    stop.is_dead_in_the_water.then_some(Criterion {
        clause: "5.3.4",
        name: "track reach of the stop",
        unit: "L",
        value,
        limit: 15.0,
        holds: value <= 15.0,
    })
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
pub fn criteria(
    length_m: f64,
    surge_speed_m_s: f64,
    zig_zags: [Option<&ZigZag>; 2],
    circles: &[TurningCircle],
) -> Vec<Criterion> {
    let seconds = length_m / surge_speed_m_s;
    let between = |short: f64, long: f64, formula: f64| match seconds {
        s if s < 10.0 => short,
        s if s >= 30.0 => long,
        _ => formula,
    };
    let criterion = |clause, name, unit, value: f64, limit: f64| Criterion {
        clause,
        name,
        unit,
        value,
        limit,
        holds: value <= limit,
    };
    let mut found = Vec::new();
    let widest = |of: fn(&TurningCircle) -> f64| circles.iter().map(of).reduce(f64::max);
    if let (Some(advance), Some(diameter)) =
        (widest(|c| c.advance_m), widest(|c| c.tactical_diameter_m))
    {
        found.push(criterion("5.3.1", "advance", "L", advance / length_m, 4.5));
        found.push(criterion(
            "5.3.1",
            "tactical diameter",
            "L",
            diameter / length_m,
            5.0,
        ));
    }
    let [ten, twenty] = zig_zags;
    if let Some(ten) = ten {
        let reach = ten.initial_turning_track_m / length_m;
        found.push(criterion(
            "5.3.2",
            "initial turning, track reach",
            "L",
            reach,
            2.5,
        ));
        let overshoots = [
            (
                "5.3.3.1",
                "first overshoot angle, 10/10",
                between(10.0, 20.0, 5.0 + 0.5 * seconds),
            ),
            (
                "5.3.3.2",
                "second overshoot angle, 10/10",
                between(25.0, 40.0, 17.5 + 0.75 * seconds),
            ),
        ];
        for ((clause, name, limit), overshoot) in overshoots.into_iter().zip(&ten.overshoots_rad) {
            found.push(criterion(
                clause,
                name,
                "deg",
                overshoot.to_degrees(),
                limit,
            ));
        }
    }
    if let Some(overshoot) = twenty.and_then(|twenty| twenty.overshoots_rad.first()) {
        let name = "first overshoot angle, 20/20";
        found.push(criterion(
            "5.3.3.3",
            name,
            "deg",
            overshoot.to_degrees(),
            25.0,
        ));
    }
    found
}

//! Two motors or fins, one to each side, that steer together.

use crate::Quantity;
use crate::name::{ColumnName, clipped};

/// The sides of two motors or fins.
const SIDES: [[&str; 2]; 3] = [["left", "right"], ["port", "starboard"], ["port", "stbd"]];

/// What a log without a column for this quantity cannot tell, or how two motors among its columns tell it.
pub(crate) fn without(quantity: Quantity, columns: &[String]) -> String {
    let motors = motors(columns);
    // A comma parts the names of the option.
    let is_rudder = |name: &&String| name.to_lowercase().contains("rudder") && !name.contains(',');
    let rudders: Vec<String> = columns.iter().filter(is_rudder).cloned().collect();
    let together = of_two_sides(quantity, &motors);
    match (together.is_empty(), &rudders[..]) {
        (false, _) => together,
        (true, [first, second]) if !of_two_sides(quantity, &rudders).is_empty() => format!(
            "; the mean of two rudders is --rudder '{},-{}'",
            clipped(first),
            clipped(second)
        ),
        _ => quantity.without().into(),
    }
}

/// Is this the name of a motor?
pub(crate) fn is_of_a_motor(name: &str) -> bool {
    const MOTORS: [&str; 6] = ["thrust", "motor", "prop", "engine", "throttle", "pwm"];
    let name = name.to_lowercase();
    MOTORS.iter().any(|motor| name.contains(motor)) || SIDES.concat().contains(&name.as_str())
}

fn motors(columns: &[String]) -> Vec<String> {
    let of_motors = columns.iter().filter(|name| is_of_a_motor(name));
    of_motors.cloned().collect()
}

/// The only two motors of a log, one to each side, port first: half their difference steers where no other column does.
pub(crate) fn motors_that_steer(columns: &[String]) -> Option<[String; 2]> {
    let motors: [String; 2] = motors(columns).try_into().ok()?;
    // Rudders and fins may turn with each other or against.
    const BLADES: [&str; 4] = ["rudder", "fin", "flap", "elev"];
    let is_a_blade = |name: &String| BLADES.iter().any(|blade| name.to_lowercase().contains(blade));
    let steers = |name: &String| ColumnName::new(name).fit(Quantity::Rudder).is_some();
    let is_else = |name: &String| steers(name) && !motors.contains(name);
    if motors.iter().any(is_a_blade) || columns.iter().any(is_else) {
        return None;
    }
    let on = |motor: &String, side: &str| motor.to_lowercase().contains(side);
    let [first, second] = &motors;
    SIDES.iter().find_map(|[port, starboard]| {
        let are = |a, b| on(a, port) && on(b, starboard);
        match (are(first, second), are(second, first)) {
            (true, false) => Some([first.clone(), second.clone()]),
            (false, true) => Some([second.clone(), first.clone()]),
            _ => None,
        }
    })
}

/// What two motors or fins, one to each side, are taken for together.
pub(crate) fn of_two_sides(quantity: Quantity, candidates: &[String]) -> String {
    let [first, second] = candidates else {
        return String::new();
    };
    let has = |side: &str| {
        let of = |name: &String| name.to_lowercase().contains(side);
        of(first) || of(second)
    };
    match quantity == Quantity::Rudder && SIDES.iter().any(|sides| sides.iter().all(|s| has(s))) {
        true => format!(
            "; two motors or fins that turn against each other are taken together by --rudder '{},{}'",
            clipped(first),
            clipped(second)
        ),
        false => String::new(),
    }
}

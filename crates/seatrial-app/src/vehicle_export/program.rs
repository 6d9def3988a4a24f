//! Targets that are programs: the equations of the vehicle in their language.

use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::{head, plain};

/// What a language writes for a number that is not there, and for one without bound.
struct Words {
    none: &'static str,
    infinite: &'static str,
}

const PYTHON: Words = Words { none: "None", infinite: "float(\"inf\")" };
/// An FMU's parameters are numbers: 0 says that there is none.
const C: Words = Words { none: "0.0", infinite: "0.0" };
const JULIA: Words = Words { none: "nothing", infinite: "Inf" };
const OCTAVE: Words = Words { none: "[]", infinite: "Inf" };

pub(super) fn numpy(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/numpy.py");
    filled(template, &docstring(vehicle, &[]), vehicle, &PYTHON)
}

pub(super) fn casadi(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/casadi.py");
    let cannot = (vehicle.rudder.delay_s > 0.0).then(|| {
        let delay_s = vehicle.rudder.delay_s;
        format!(
            "the rudder's dead time of {delay_s} s, RUDDER_DELAY_S: pass the command of so long ago"
        )
    });
    let cannot: Vec<String> = cannot.into_iter().collect();
    filled(template, &docstring(vehicle, &cannot), vehicle, &PYTHON)
}

pub(super) fn mujoco(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/mujoco.py");
    filled(template, &docstring(vehicle, &[]), vehicle, &PYTHON)
}

pub(super) fn octave(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/octave.m");
    let lines = head(vehicle, &[]);
    let head: Vec<String> = lines.iter().map(|line| format!("% {line}")).collect();
    filled(template, &head.join("\n"), vehicle, &OCTAVE)
}

pub(super) fn control_systems(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/control_systems.jl");
    let cannot = [
        "limit and rate of the rudder, and the offset C0, which are constants beside the models",
        "how the speed follows the thrust, and what a turn costs of it",
    ];
    let lines = head(vehicle, &cannot.map(str::to_owned));
    let head: Vec<String> = lines.iter().map(|line| format!("# {line}")).collect();
    filled(template, &head.join("\n"), vehicle, &JULIA)
}

/// The source code of an FMU, which names the token that it is instantiated with `@TOKEN@`.
pub(super) fn fmu(vehicle: &IdentifiedVehicle) -> String {
    let template = include_str!("templates/fmu.c")
        .replace("@POINTS@", &vehicle.speeds.len().to_string())
        .replace("@FASTEST@", &number(vehicle.fastest_thrust()));
    filled(&template, &head(vehicle, &[]).join("\n"), vehicle, &C)
}

fn docstring(vehicle: &IdentifiedVehicle, cannot: &[String]) -> String {
    let lines = head(vehicle, cannot).join("\n");
    format!("\"\"\"{}\n\"\"\"", lines.replace('"', "'"))
}

fn filled(template: &str, head: &str, vehicle: &IdentifiedVehicle, words: &Words) -> String {
    let column = |of: fn(&IdentifiedSpeed) -> f64| {
        let numbers: Vec<String> = vehicle.speeds.iter().map(|p| number(of(p))).collect();
        numbers.join(", ")
    };
    let rudder = &vehicle.rudder;
    let surge = &vehicle.surge;
    let known = |value: Option<f64>, absent: &str| value.map_or(absent.to_owned(), number);
    [
        ("@HEADER@", head.to_owned()),
        ("@NAME@", identifier(&vehicle.name)),
        ("@THRUST@", column(|p| p.thrust)),
        ("@SPEED@", column(|p| p.surge_speed_m_s)),
        ("@A22@", column(|p| p.a22_per_s)),
        ("@B2@", column(|p| p.b2_per_s2)),
        ("@C0@", column(|p| p.c0_rad_per_s2)),
        ("@LIMIT@", number(rudder.limit_rad)),
        ("@LAG@", number(rudder.lag_s)),
        ("@DELAY@", number(rudder.delay_s)),
        ("@RATE@", known(rudder.rate_limit_rad_s, words.infinite)),
        ("@SURGE_T@", number(surge.time_constant_s)),
        ("@DRAG@", known(surge.drag_length_m, words.none)),
        ("@TURNING@", known(surge.turning_drag_m, "0.0")),
    ]
    .iter()
    .fold(template.to_owned(), |text, (place, value)| text.replace(place, value))
}

/// A number as every language reads floating point.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A name that every language takes for one.
pub(super) fn identifier(name: &str) -> String {
    let name: String = plain(name)
        .chars()
        .take(60)
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    match name.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => name,
        _ => format!("vehicle_{name}"),
    }
}

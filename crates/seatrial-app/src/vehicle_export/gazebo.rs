//! SDF of Gazebo: a link with the damping of the vehicle in `gz-sim-hydrodynamics-system`.

use std::fmt::Write as _;

use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use super::{head, plain, single_speed};

/// Mass and yaw inertia of the link: accelerations are identified, so that forces follow from any.
const MASS_KG: f64 = 100.0;
const INERTIA_KG_M2: f64 = 25.0;
/// Damping across the hull per mass, 1/m, that keeps the velocity along the heading: the drift in a turn is 5 cm times the yaw rate.
const SWAY_DAMPING_PER_M: f64 = 20.0;

/// The model of a vehicle whose damping, offset and drag are those at a speed.
///
/// The plugin's wrench is sum c_ij v_j + c_ijk v_j v_k + c_ijabsk v_j |v_k| in the link's axes, forward, port and up, with the yaw rate
/// counterclockwise (`buildDampingMatrix` in gz-sim's `HydrodynamicsUtils.hh`):
///
/// ```text
/// nRabsU = I a22/u0        a22 grows with the speed
/// nUU    = -I C0/u0^2      C0 grows with its square; counterclockwise
/// xUabsU = -m/l, or xU = -m/T
/// xRR    = m (1/20 m - d_r)    the drift of 5 cm times r that yV leaves takes u' = v r, which this gives back
/// ```
pub(super) fn sdf(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> String {
    let u0 = at.surge_speed_m_s;
    let surge = &vehicle.surge;
    let turning_drag_m = surge.drag_length_m.and(surge.turning_drag_m).unwrap_or(0.0);
    let mut cannot = single_speed(vehicle, at);
    cannot.push(
        "rudder and thruster: give the link the wrench that the comment in it says, by a plugin of your own or a thruster and a fin of this strength".into(),
    );
    let mut derivatives = vec![
        ("nRabsU", INERTIA_KG_M2 * at.a22_per_s / u0),
        ("nUU", -INERTIA_KG_M2 * at.c0_rad_per_s2 / (u0 * u0)),
        ("yV", -MASS_KG * SWAY_DAMPING_PER_M * u0),
        ("xRR", MASS_KG * (1.0 / SWAY_DAMPING_PER_M - turning_drag_m)),
    ];
    let thrust = match surge.drag_length_m {
        Some(l) => {
            derivatives.push(("xUabsU", -MASS_KG / l));
            format!("X = {:?} u_s |u_s| N", MASS_KG / l)
        }
        None => {
            let t = surge.time_constant_s;
            derivatives.push(("xU", -MASS_KG / t));
            format!("X = {:?} u_s N", MASS_KG / t)
        }
    };
    let mut text = String::from("<?xml version=\"1.0\"?>\n<!--\n");
    for line in head(vehicle, &cannot) {
        // Two hyphens may not stand in a comment of XML.
        let _ = writeln!(text, "  {}", line.replace("--", "- -"));
    }
    let speeds = vehicle.speeds.iter();
    let table: Vec<String> =
        speeds.map(|p| format!("{:?}: {:?}", p.thrust, p.surge_speed_m_s)).collect();
    let name = model_name(&vehicle.name);
    let _ = write!(
        text,
        "-->\n<sdf version=\"1.9\">\n  <model name=\"{name}\">\n    <link name=\"base_link\">\n      \
         <!-- Rudder of delta rad, starboard positive: N = {:?} u |u| delta N m about the link's z, up.\n           \
         Thrust for the steady speed u_s m/s: {thrust}; thrust to u_s: {}. -->\n      \
         <inertial>\n        <mass>{MASS_KG:?}</mass>\n        <inertia>\n          <ixx>{INERTIA_KG_M2:?}</ixx>\n          \
         <ixy>0.0</ixy>\n          <ixz>0.0</ixz>\n          <iyy>{INERTIA_KG_M2:?}</iyy>\n          <iyz>0.0</iyz>\n          \
         <izz>{INERTIA_KG_M2:?}</izz>\n        </inertia>\n      </inertial>\n    </link>\n    \
         <plugin filename=\"gz-sim-hydrodynamics-system\" name=\"gz::sim::systems::Hydrodynamics\">\n      \
         <link_name>base_link</link_name>\n      <disable_added_mass>true</disable_added_mass>\n      \
         <disable_coriolis>true</disable_coriolis>\n",
        -INERTIA_KG_M2 * at.b2_per_s2 / (u0 * u0),
        table.join(", ")
    );
    for (name, value) in derivatives {
        let _ = writeln!(text, "      <{name}>{value:?}</{name}>");
    }
    text + "    </plugin>\n  </model>\n</sdf>\n"
}

/// A name that SDFormat takes: not `world`, without `::`, and not between two pairs of underscores, which are its own.
fn model_name(name: &str) -> String {
    let name = plain(name).replace(['<', '>', '&', '"', '\'', ':'], "_");
    let is_reserved = name.trim().is_empty()
        || name == "world"
        || (name.starts_with("__") && name.ends_with("__"));
    match is_reserved {
        true => format!("vehicle {name}"),
        false => name,
    }
}

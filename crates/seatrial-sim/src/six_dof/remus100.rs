//! The REMUS 100.
//!
//! Where the numbers come from:
//!
//! | number | source |
//! |---|---|
//! | length 1.6 m, diameter 0.19 m, water 1026 kg/m^3 | F |
//! | mass: neutrally buoyant spheroid of that size, 31.0 kg; its moments of inertia | F |
//! | centre of gravity 0.02 m below that of buoyancy | F (P: 0.0196 m) |
//! | added mass: Lamb's factors; in roll 0.3 of the moment of inertia | F |
//! | planform 0.7 l d, frontal drag 0.42, hull lift slope and Oswald efficiency | F; the drag from A |
//! | cross-flow drag 1.2 | F: Hoerner's curve at a beam of twice half the draught |
//! | no Munk moment: the linear damping stands for it | F |
//! | linear damping: 20 s, ratios 0.3 and 0.8, yaw 1 s | F; yaw less the fins' share, below |
//! | fin area 0.00665 m^2, effective aspect ratio 2.21 | P, and F for the area |
//! | lift slope of rudders 0.5, elevators 0.7 per rad; 0.8 m aft; limit 15 deg; lag 0.1 s | F |
//! | propeller: diameter, K_T, K_Q, 1 - w = 0.944, t = 0.1, a tenth of its torque on the hull, 1525 rpm, 1 s | F; w from A |
//! | fin profile drag 0.01, stall at 0.4 rad, centre of pressure 0.1 m off the axis | assumed: thin fins of low aspect ratio |
//! | centre of lift 0.03 m ahead of the origin | assumed, see below |
//! | gains of the depth controller | tuned by hand |
//!
//! F: T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), section 8.4.2, and
//! the REMUS 100 of his public vehicle simulators. P: T. Prestero, Verification of a Six-Degree of Freedom
//! Simulation Model for the REMUS Autonomous Underwater Vehicle, MIT/WHOI (2001). A: Allen, Vorus and Prestero,
//! OCEANS 2000, 1869-1873.
//!
//! F turns the fins' deflection into force but not the flow that turning and drift bring to them. Here fins feel
//! it, so that their damping in yaw at 2 m/s is taken from the 1 s that stands for all of it in F. The
//! hull's lift, in F only in the vertical plane, acts in every plane; where on the axis is not published with
//! it, and every 0.01 m moves the identified a22 by 3 to 4 %. 0.03 m brings a22 and b2
//! into the middle of what is identified from logs of F's model (`val_fossen_remus100_logs`).

use core::f64::consts::PI;

use super::actuator::Actuator;
use super::config::SixDofConfig;
use super::depth_hold::DepthHold;
use super::fins::Fin;
use super::foil::Foil;
use super::hydrodynamics::{Hull, linear_damping, spheroid_factors};
use super::propeller::Propeller;
use super::rigid_body::{GRAVITY_M_S2, RigidBody};
use super::sea::Sea;
use crate::config::{HeadingHold, HelmConfig};
use crate::plant::{Disturbance, Servo};
use crate::sensors::{Sensors, Timing};

const DENSITY_KG_M3: f64 = 1026.0;
const LENGTH_M: f64 = 1.6;
const DIAMETER_M: f64 = 0.19;
const FIN_AREA_M2: f64 = 0.00665;
const FIN_ARM_M: f64 = LENGTH_M / 2.0;
const RUDDER_LIFT_SLOPE: f64 = 0.5;
const ELEVATOR_LIFT_SLOPE: f64 = 0.7;
const LUMPED_YAW_TIME_S: f64 = 1.0;
/// Speed at which the fins' damping is taken from the lumped one, m/s.
const LUMPED_AT_M_S: f64 = 2.0;

/// The REMUS 100 at 2 m depth in still water.
pub fn config() -> SixDofConfig {
    let rigid_body = rigid_body();
    SixDofConfig {
        name: "remus100".to_owned(),
        hull: hull(&rigid_body),
        rigid_body,
        fins: Fin::cruciform(FIN_ARM_M, 0.1, foil(RUDDER_LIFT_SLOPE), foil(ELEVATOR_LIFT_SLOPE))
            .to_vec(),
        propeller: Propeller {
            diameter_m: 0.14,
            thrust_coefficients: [0.4566, (0.1798 - 0.4566) / 0.6632],
            torque_coefficients: [0.0700, (0.0312 - 0.0700) / 0.6632],
            thrust_deduction: 0.1,
            wake_fraction: 1.0 - 0.944,
            torque_on_hull: 0.1,
            full_speed_rev_s: 1525.0 / 60.0,
            dead_band: 0.0,
            time_constant_s: 1.0,
        },
        rudder: ACTUATOR,
        elevator: ACTUATOR,
        depth_hold: DepthHold {
            depth_m: 2.0,
            pitch_per_depth_rad_m: 0.1,
            pitch_per_integral_rad_m_s: 0.01,
            pitch_limit_rad: 0.3,
            elevator_per_pitch: 1.0,
        },
        helm: HelmConfig {
            rudder_limit_rad: 0.26,
            initial_thrust: 0.6,
            initial_heading_rad: 0.0,
            heading_hold: HeadingHold::default(),
            disturbance: Disturbance::default(),
            sensors: Sensors::default(),
            timing: Timing::default(),
        },
        sea: Sea { density_kg_m3: DENSITY_KG_M3, current: Vec::new(), waves: None, bottom: None },
    }
}

/// 15 degrees and 0.1 s.
const ACTUATOR: Actuator = Actuator {
    limit_rad: PI / 12.0,
    servo: Servo { time_constant_s: 0.1, rate_limit_rad_s: None },
    dead_band_rad: 0.0,
    backlash_rad: 0.0,
};

fn foil(lift_slope_per_rad: f64) -> Foil {
    Foil {
        area_m2: FIN_AREA_M2,
        lift_slope_per_rad,
        aspect_ratio: 2.21,
        profile_drag: 0.01,
        stall_rad: 0.4,
    }
}

fn rigid_body() -> RigidBody {
    let (a, b) = (LENGTH_M / 2.0, DIAMETER_M / 2.0);
    let mass_kg = 4.0 / 3.0 * PI * DENSITY_KG_M3 * a * b * b;
    let transverse = 0.2 * mass_kg * (a * a + b * b);
    RigidBody {
        mass_kg,
        inertia_kg_m2: [0.4 * mass_kg * b * b, transverse, transverse],
        centre_of_gravity_m: [0.0, 0.0, 0.02],
        centre_of_buoyancy_m: [0.0; 3],
        buoyancy_n: mass_kg * GRAVITY_M_S2,
    }
}

fn hull(body: &RigidBody) -> Hull {
    let [roll, pitch, yaw] = body.inertia_kg_m2;
    let [k1, k2, k_rotation] = spheroid_factors(LENGTH_M, DIAMETER_M);
    let mut hull = Hull {
        length_m: LENGTH_M,
        diameter_m: DIAMETER_M,
        planform_area_m2: 0.7 * LENGTH_M * DIAMETER_M,
        frontal_drag: 0.42,
        cross_flow_drag: 1.2,
        centre_of_lift_m: 0.03,
        added_mass: [
            k1 * body.mass_kg,
            k2 * body.mass_kg,
            k2 * body.mass_kg,
            0.3 * roll,
            k_rotation * pitch,
            k_rotation * yaw,
        ],
        munk_moment: false,
        linear_damping: [0.0; 6],
    };
    let righting_n_m = body.weight_n() * body.centre_of_gravity_m[2];
    let mass = body.mass_matrix() + hull.added_mass_matrix();
    hull.linear_damping = linear_damping(&mass, righting_n_m, LUMPED_YAW_TIME_S);
    // Two rudders, each 1/2 rho u A C_La x^2.
    let of_the_fins =
        DENSITY_KG_M3 * LUMPED_AT_M_S * FIN_AREA_M2 * RUDDER_LIFT_SLOPE * FIN_ARM_M * FIN_ARM_M;
    hull.linear_damping[5] -= of_the_fins;
    hull
}

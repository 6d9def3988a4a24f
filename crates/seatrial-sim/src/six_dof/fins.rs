//! Fins on the hull, in the flow where they stand.

use core::f64::consts::PI;

use nalgebra::{Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::foil::Foil;
use super::rigid_body::{force_at, split};

/// What deflects a fin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// The rudder actuator.
    Rudder,
    /// The elevator actuator.
    Elevator,
}

/// One fin.
///
/// ```text
/// V = v + w x r_f,   b = atan2(V . n, V . x),   a = delta - b
/// F = 1/2 rho A |V|^2 (C_L(a) l - C_D(a) d),   d = (x cos b + n sin b),  l = (n cos b - x sin b)
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | v, w | velocity through the water | m/s, rad/s | body's axes |
/// | r_f | `position_m` | m | x forward, y starboard, z down |
/// | n | `normal` | 1 | the way a positive deflection pushes, across x |
/// | delta | deflection | rad | |
/// | |V| | | m/s | speed across the span: spanwise flow makes no force |
///
/// C_L, C_D, A: [`Foil`]. Drift and turning thus act on the fins as deflection does, which damps both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fin {
    /// What deflects it.
    pub drive: Drive,
    /// Centre of pressure, m.
    pub position_m: [f64; 3],
    /// Direction of its force at a positive deflection, a unit vector across the hull's axis.
    pub normal: [f64; 3],
    /// Its lift and drag.
    pub foil: Foil,
}

/// Deflections of the two drives, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deflections {
    /// Positive turns towards increasing heading.
    pub rudder_rad: f64,
    /// Positive pitches the bow up.
    pub elevator_rad: f64,
}

impl Fin {
    /// Two rudders and two elevators of one kind, `arm_m` aft of the origin and `radius_m` off the axis.
    pub fn cruciform(arm_m: f64, radius_m: f64, rudder: Foil, elevator: Foil) -> [Self; 4] {
        let fin = |drive, y: f64, z: f64, normal, foil| Self {
            drive,
            position_m: [-arm_m, radius_m * y, radius_m * z],
            normal,
            foil,
        };
        let (to_port, down) = ([0.0, -1.0, 0.0], [0.0, 0.0, 1.0]);
        [
            fin(Drive::Rudder, 0.0, -1.0, to_port, rudder),
            fin(Drive::Rudder, 0.0, 1.0, to_port, rudder),
            fin(Drive::Elevator, -1.0, 0.0, down, elevator),
            fin(Drive::Elevator, 1.0, 0.0, down, elevator),
        ]
    }

    /// Force and moment at a velocity of the vehicle through the water.
    pub fn force(
        &self,
        density_kg_m3: f64,
        velocity: &Vector6<f64>,
        deflections: Deflections,
    ) -> Vector6<f64> {
        let (linear, angular) = split(velocity);
        let (position, normal) = (Vector3::from(self.position_m), Vector3::from(self.normal));
        let local = linear + angular.cross(&position);
        let (along, across) = (local.x, local.dot(&normal));
        let speed = (along * along + across * across).sqrt();
        if speed == 0.0 {
            return Vector6::zeros();
        }
        let deflection = match self.drive {
            Drive::Rudder => deflections.rudder_rad,
            Drive::Elevator => deflections.elevator_rad,
        };
        let mut angle = deflection - libm::atan2(across, along);
        if angle > PI {
            angle -= 2.0 * PI;
        } else if angle < -PI {
            angle += 2.0 * PI;
        }
        let [lift, drag] = self.foil.coefficients(angle);
        let forward = Vector3::x();
        let push = 0.5 * density_kg_m3 * self.foil.area_m2 * speed;
        let force = (normal * along - forward * across) * (push * lift)
            - (forward * along + normal * across) * (push * drag);
        force_at(&position, force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOIL: Foil = Foil {
        area_m2: 0.01,
        lift_slope_per_rad: 2.5,
        aspect_ratio: 2.2,
        profile_drag: 0.02,
        stall_rad: 0.4,
    };

    fn total(velocity: [f64; 6], rudder_rad: f64, elevator_rad: f64) -> Vector6<f64> {
        let deflections = Deflections { rudder_rad, elevator_rad };
        Fin::cruciform(0.8, 0.1, FOIL, FOIL)
            .iter()
            .map(|fin| fin.force(1000.0, &velocity.into(), deflections))
            .sum()
    }

    #[test]
    fn exact_rudder_turns_to_increasing_heading_and_elevator_lifts_the_bow() {
        let force = total([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, 0.0);
        // Two fins: 1/2 rho U^2 2 A C_La delta at 0.8 m.
        let lift = 0.5 * 1000.0 * 4.0 * 0.02 * 2.5 * 0.1;
        assert!((force[5] - 0.8 * lift).abs() < 1e-12);
        assert!((force[1] + lift).abs() < 1e-12 && force[3].abs() < 1e-12);
        let force = total([2.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.0, 0.1);
        assert!((force[4] - 0.8 * lift).abs() < 1e-12);
    }

    /// Held fins take power from every motion.
    #[test]
    fn prop_held_fins_dissipate() {
        for k in 0..500 {
            let x = |scale: f64, i: f64| scale * libm::sin(f64::from(k) * (1.3 + i));
            let velocity =
                [x(2.0, 0.0), x(1.0, 0.7), x(1.0, 1.1), x(1.0, 1.9), x(1.0, 2.3), x(1.0, 3.1)];
            let power = Vector6::from(velocity).dot(&total(velocity, x(0.3, 0.4), x(0.3, 0.9)));
            assert!(power <= 0.0, "{power} W at {velocity:?}");
        }
    }
}

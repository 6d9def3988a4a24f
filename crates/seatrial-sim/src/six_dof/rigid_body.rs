//! The rigid body: mass, centres of gravity and buoyancy, restoring forces.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};

/// Acceleration of gravity, m/s^2.
pub const GRAVITY_M_S2: f64 = 9.81;

/// A rigid body whose centre of gravity need not be the origin of its axes.
///
/// ```text
/// M_RB = [  m I        -m S(r_g)             ]
///        [  m S(r_g)    I_g - m S(r_g) S(r_g) ]
/// tau_g = [ (W - s B) k,  (W r_g - s B r_b) x k ]
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | m | `mass_kg` | kg | |
/// | I_g | `inertia_kg_m2` | kg m^2 | about the centre of gravity, diagonal |
/// | r_g, r_b | `centre_of_gravity_m`, `centre_of_buoyancy_m` | m | x forward, y starboard, z down |
/// | W, B | m g, `buoyancy_n` | N | weight down, buoyancy up |
/// | s | `submerged` | 1 | share of the volume that is under water |
/// | k | | 1 | down, in the body's axes |
/// | S(a) | | | the matrix with S(a) b = a x b |
///
/// Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), chapters 3 and 4.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidBody {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Moments of inertia about the centre of gravity, kg m^2.
    pub inertia_kg_m2: [f64; 3],
    /// Centre of gravity, m.
    pub centre_of_gravity_m: [f64; 3],
    /// Centre of buoyancy, m.
    pub centre_of_buoyancy_m: [f64; 3],
    /// Buoyancy, N.
    pub buoyancy_n: f64,
}

impl RigidBody {
    /// M_RB.
    pub fn mass_matrix(&self) -> Matrix6<f64> {
        let arm = Vector3::from(self.centre_of_gravity_m).cross_matrix();
        let inertia = Matrix3::from_diagonal(&Vector3::from(self.inertia_kg_m2));
        let mut matrix = Matrix6::zeros();
        let mut set = |row, column, block: Matrix3<f64>| {
            matrix.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        set(0, 0, Matrix3::identity() * self.mass_kg);
        set(0, 3, arm * -self.mass_kg);
        set(3, 0, arm * self.mass_kg);
        set(3, 3, inertia - arm * arm * self.mass_kg);
        matrix
    }

    /// Weight, N.
    pub fn weight_n(&self) -> f64 {
        self.mass_kg * GRAVITY_M_S2
    }

    /// tau_g, force and moment of weight and buoyancy.
    pub fn restoring(&self, down: &Vector3<f64>, submerged: f64) -> Vector6<f64> {
        let afloat = Self { buoyancy_n: submerged * self.buoyancy_n, ..*self };
        join(down * (afloat.weight_n() - afloat.buoyancy_n), afloat.righting_arm_n_m().cross(down))
    }

    /// Potential energy at a depth, J; 0 with both centres at the surface.
    pub fn potential_energy_j(&self, depth_m: f64, down: &Vector3<f64>) -> f64 {
        -(self.weight_n() - self.buoyancy_n) * depth_m - self.righting_arm_n_m().dot(down)
    }

    /// W r_g - B r_b, N m.
    fn righting_arm_n_m(&self) -> Vector3<f64> {
        Vector3::from(self.centre_of_gravity_m) * self.weight_n()
            - Vector3::from(self.centre_of_buoyancy_m) * self.buoyancy_n
    }
}

/// C(nu) nu, the Coriolis and centripetal forces of a symmetric mass matrix M.
///
/// ```text
/// C(nu) nu = [ w x p,  v x p + w x h ],   [p, h] = M nu,  nu = [v, w]
/// ```
///
/// | symbol | unit | meaning |
/// |---|---|---|
/// | v, w | m/s, rad/s | linear and angular velocity in the body's axes |
/// | p, h | kg m/s, kg m^2/s | linear and angular momentum |
///
/// Source: Fossen (2021), chapter 3. nu . C(nu) nu = 0: these forces do no work.
pub fn coriolis(mass_matrix: &Matrix6<f64>, velocity: &Vector6<f64>) -> Vector6<f64> {
    let (linear, angular) = split(velocity);
    let (momentum, angular_momentum) = split(&(mass_matrix * velocity));
    join(angular.cross(&momentum), linear.cross(&momentum) + angular.cross(&angular_momentum))
}

/// Linear and angular part.
pub fn split(vector: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let [x, y, z, k, m, n] = (*vector).into();
    (Vector3::new(x, y, z), Vector3::new(k, m, n))
}

/// A vector of linear and angular part.
pub fn join(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// Force and moment of a force at a point.
pub fn force_at(point: &Vector3<f64>, force: Vector3<f64>) -> Vector6<f64> {
    join(force, point.cross(&force))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: RigidBody = RigidBody {
        mass_kg: 30.0,
        inertia_kg_m2: [0.2, 3.0, 4.0],
        centre_of_gravity_m: [0.1, -0.02, 0.03],
        centre_of_buoyancy_m: [0.05, 0.0, -0.01],
        buoyancy_n: 300.0,
    };

    /// Kinetic energy is that of the centre of gravity and of the rotation about it.
    #[test]
    fn exact_energy_of_an_offset_centre_of_gravity() {
        let velocity = Vector6::new(1.5, -0.3, 0.2, 0.7, -0.4, 0.9);
        let (linear, angular) = split(&velocity);
        let at_centre = linear + angular.cross(&Vector3::from(BODY.centre_of_gravity_m));
        let spin: f64 = (0..3).map(|i| BODY.inertia_kg_m2[i] * angular[i] * angular[i]).sum();
        let expected = 0.5 * (BODY.mass_kg * at_centre.norm_squared() + spin);
        let energy = 0.5 * velocity.dot(&(BODY.mass_matrix() * velocity));
        // Rounding.
        assert!((energy - expected).abs() < 1e-12 * expected);
        let power = velocity.dot(&coriolis(&BODY.mass_matrix(), &velocity));
        assert!(power.abs() < 1e-12 * expected, "{power}");
    }

    /// Heeled to starboard with the centre of gravity low, it rights itself; too light, it rises.
    #[test]
    fn exact_restoring_rights_and_lifts() {
        let body = RigidBody {
            centre_of_gravity_m: [0.0, 0.0, 0.02],
            centre_of_buoyancy_m: [0.0; 3],
            ..BODY
        };
        let heel = 0.1_f64;
        let down = Vector3::new(0.0, heel.sin(), heel.cos());
        let force = body.restoring(&down, 1.0);
        let weight = body.weight_n();
        assert!((force[3] + 0.02 * weight * heel.sin()).abs() < 1e-12);
        assert!((force[2] - (weight - 300.0) * heel.cos()).abs() < 1e-12);
    }
}

//! The equations of motion and their integration.

use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector3, Vector6};

use super::config::{SixDofConfig, required};
use super::fins::{Deflections, Fin};
use super::hydrodynamics::Hull;
use super::propeller::Propeller;
use super::rigid_body::{GRAVITY_M_S2, RigidBody, coriolis, join, split};
use super::sea::{Flow, Sea};
use super::waves::WaveField;
use crate::config_error::ConfigError;

/// Position, attitude and velocity, or their rates of change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// North, east and down of the origin, m.
    pub position_m: Vector3<f64>,
    /// From the body's axes to north, east and down.
    pub attitude: Quaternion<f64>,
    /// Velocity over ground and angular velocity in the body's axes, m/s and rad/s.
    pub velocity: Vector6<f64>,
}

/// What acts on the vehicle besides the water.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Fins.
    pub deflections: Deflections,
    /// Shaft speed, rev/s.
    pub shaft_rev_s: f64,
    /// Yaw acceleration that is not the vehicle's, rad/s^2.
    pub yaw_disturbance_rad_s2: f64,
    /// The waves' time, s.
    pub time_s: f64,
}

/// A vehicle in the sea.
///
/// ```text
/// p'  = R(q) v,    q' = 1/2 q (0, w)
/// nu' = (M_RB + M_A)^-1 (tau - C_RB(nu) nu - C_A(nu_r) nu_r + M_A nu_c')
/// nu_r = nu - nu_c,   nu_c = [R^T c(p, t), 0],   nu_c' = [R^T (dc/dt + grad c p') - w x R^T c, 0]
/// tau = hull(nu_r) + fins(nu_r, delta) + propeller(u_r, n) + weight and buoyancy + m_d [R^T (dc/dt + grad c c), 0]
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | p, q | `position_m`, `attitude` | m, 1 |
/// | nu = [v, w] | `velocity` | m/s, rad/s |
/// | c(p, t) | [`Sea::flow`] | m/s |
/// | m_d | mass of the displaced water | kg |
/// | delta, n | [`Inputs`] | rad, rev/s |
///
/// Source: Fossen (2021), chapters 2, 8 and 10, with unit quaternions for every attitude; the fourth-order
/// Runge-Kutta method. The water's own acceleration in waves acts on the mass that the
/// vehicle displaces, as at its origin (Froude and Krylov's force for a vehicle shorter than the waves): one of its own
/// mass moves with the water. Buoyancy goes, in proportion to depth, over one diameter about the surface; hull, fins and propeller
/// act above it as in water.
#[derive(Clone, Debug)]
pub struct Dynamics {
    rigid_body: RigidBody,
    hull: Hull,
    fins: Vec<Fin>,
    propeller: Propeller,
    sea: Sea,
    waves: Option<WaveField>,
    rigid_mass: Matrix6<f64>,
    added_mass: Matrix6<f64>,
    inverse_mass: Matrix6<f64>,
    yaw_inertia_kg_m2: f64,
}

impl Dynamics {
    /// The dynamics of a vehicle; an error where its masses are not positive.
    pub fn new(config: &SixDofConfig) -> Result<Self, ConfigError> {
        let rigid_mass = config.rigid_body.mass_matrix();
        let added_mass = config.hull.added_mass_matrix();
        let mass = rigid_mass + added_mass;
        let inverse_mass = mass.cholesky().map(|factor| factor.inverse());
        Ok(Self {
            rigid_body: config.rigid_body,
            hull: config.hull,
            fins: config.fins.clone(),
            propeller: config.propeller,
            sea: config.sea.clone(),
            waves: config.sea.waves.map(|waves| waves.field()),
            rigid_mass,
            added_mass,
            inverse_mass: required(
                "rigid_body and hull.added_mass",
                "a positive mass in every direction",
                inverse_mass,
            )?,
            yaw_inertia_kg_m2: mass[(5, 5)],
        })
    }

    /// The state `h_s` later; inputs at the start, the middle and the end.
    pub fn step(&self, state: &State, inputs: &[Inputs; 3], h_s: f64) -> State {
        let [start, middle, end] = inputs;
        let k1 = self.rate(state, start);
        let k2 = self.rate(&state.plus(&k1, 0.5 * h_s), middle);
        let k3 = self.rate(&state.plus(&k2, 0.5 * h_s), middle);
        let k4 = self.rate(&state.plus(&k3, h_s), end);
        let mut after = state
            .plus(&k1, h_s / 6.0)
            .plus(&k2, h_s / 3.0)
            .plus(&k3, h_s / 3.0)
            .plus(&k4, h_s / 6.0);
        after.attitude /= after.attitude.norm();
        after
    }

    /// The velocity through the water at a time.
    pub fn velocity_through_water(&self, state: &State, time_s: f64) -> Vector6<f64> {
        let flow = self.flow(state, time_s);
        let current = state.rotation().inverse_transform_vector(&flow.velocity_m_s);
        state.velocity - join(current, Vector3::zeros())
    }

    /// Kinetic energy of vehicle and water and potential energy of the vehicle, J, in still water.
    pub fn energy_j(&self, state: &State) -> f64 {
        let kinetic =
            0.5 * state.velocity.dot(&((self.rigid_mass + self.added_mass) * state.velocity));
        kinetic + self.rigid_body.potential_energy_j(state.position_m.z, &state.down())
    }

    /// What an accelerometer at the origin measures, in the body's axes: acceleration less gravity, m/s^2. A body that
    /// lies on the bottom has no acceleration.
    pub fn specific_force_m_s2(
        &self,
        state: &State,
        inputs: &Inputs,
        is_aground: bool,
    ) -> Vector3<f64> {
        let weight = state.down() * GRAVITY_M_S2;
        if is_aground {
            return -weight;
        }
        let (linear, angular) = split(&state.velocity);
        let (change, _) = split(&self.rate(state, inputs).velocity);
        change + angular.cross(&linear) - weight
    }

    /// Share of the hull's volume that is under water with its origin at a depth.
    fn submerged(&self, depth_m: f64) -> f64 {
        (0.5 + depth_m / self.hull.diameter_m).clamp(0.0, 1.0)
    }

    fn flow(&self, state: &State, time_s: f64) -> Flow {
        self.sea.flow(self.waves.as_ref(), &state.position_m, time_s)
    }

    fn rate(&self, state: &State, inputs: &Inputs) -> State {
        let rotation = state.rotation();
        let (linear, angular) = split(&state.velocity);
        let flow = self.flow(state, inputs.time_s);
        let drift = rotation * linear;
        let current = rotation.inverse_transform_vector(&flow.velocity_m_s);
        let sheared = rotation.inverse_transform_vector(&flow.changes_along_m_s2(&drift));
        let water = rotation.inverse_transform_vector(&flow.of_the_water_m_s2());
        let displaced_kg = self.rigid_body.buoyancy_n / GRAVITY_M_S2;
        let through_water = state.velocity - join(current, Vector3::zeros());
        let current_change = join(sheared - angular.cross(&current), Vector3::zeros());
        let force = self.force(&through_water, inputs)
            + self.rigid_body.restoring(&state.down(), self.submerged(state.position_m.z))
            + self.added_mass * current_change
            + join(water * displaced_kg, Vector3::zeros())
            - coriolis(&self.rigid_mass, &state.velocity)
            - self.hull.added_coriolis(&self.added_mass, &through_water);
        State {
            position_m: drift,
            attitude: state.attitude * Quaternion::from_imag(angular) * 0.5,
            velocity: self.inverse_mass * force,
        }
    }

    fn force(&self, through_water: &Vector6<f64>, inputs: &Inputs) -> Vector6<f64> {
        let density = self.sea.density_kg_m3;
        let fins: Vector6<f64> =
            self.fins.iter().map(|fin| fin.force(density, through_water, inputs.deflections)).sum();
        let propeller = self.propeller.force(density, through_water[0], inputs.shaft_rev_s);
        let mut force = self.hull.force(density, through_water) + fins + propeller;
        force[5] += self.yaw_inertia_kg_m2 * inputs.yaw_disturbance_rad_s2;
        force
    }
}

impl State {
    /// Level at a heading, at a depth, moving ahead.
    pub fn level(heading_rad: f64, depth_m: f64, surge_speed_m_s: f64) -> Self {
        let half = 0.5 * heading_rad;
        Self {
            position_m: Vector3::new(0.0, 0.0, depth_m),
            attitude: Quaternion::new(libm::cos(half), 0.0, 0.0, libm::sin(half)),
            velocity: Vector6::new(surge_speed_m_s, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    }

    /// Roll, pitch and heading, rad.
    pub fn euler_rad(&self) -> [f64; 3] {
        let matrix = *self.rotation().to_rotation_matrix().matrix();
        [
            libm::atan2(matrix[(2, 1)], matrix[(2, 2)]),
            libm::asin((-matrix[(2, 0)]).clamp(-1.0, 1.0)),
            libm::atan2(matrix[(1, 0)], matrix[(0, 0)]),
        ]
    }

    /// Velocity over ground towards north, east and down, m/s.
    pub fn drift_m_s(&self) -> Vector3<f64> {
        self.rotation() * split(&self.velocity).0
    }

    fn rotation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::new_normalize(self.attitude)
    }

    /// Down, in the body's axes.
    fn down(&self) -> Vector3<f64> {
        self.rotation().inverse_transform_vector(&Vector3::z())
    }

    fn plus(&self, rate: &Self, interval_s: f64) -> Self {
        Self {
            position_m: self.position_m + rate.position_m * interval_s,
            attitude: self.attitude + rate.attitude * interval_s,
            velocity: self.velocity + rate.velocity * interval_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_dof::remus100;
    use crate::six_dof::sea::CurrentPoint;
    use crate::six_dof::waves::Waves;

    /// Sinking through a sheared current, the water it carries along is accelerated: (m + A11) u' = A11 dc/dz w.
    #[test]
    fn exact_added_mass_feels_the_shear() {
        let mut config = remus100::config();
        config.rigid_body.centre_of_gravity_m = [0.0; 3];
        let point = |depth_m, north_m_s| CurrentPoint { depth_m, north_m_s, east_m_s: 0.0 };
        config.sea.current = vec![point(0.0, -0.4), point(4.0, 0.4)];
        let dynamics = Dynamics::new(&config).unwrap();
        // At 2 m the current is 0: no surge force on a hull that only sinks.
        let mut state = State::level(0.0, 2.0, 0.0);
        state.velocity[2] = 0.5;
        let rate = dynamics.rate(&state, &Inputs::default());
        let (mass, added) = (config.rigid_body.mass_kg, config.hull.added_mass[0]);
        let expected = added * 0.2 * 0.5 / (mass + added);
        assert!((rate.velocity[0] / expected - 1.0).abs() < 1e-12);
    }

    /// A neutral body at rest in the water goes with the water, waves and all.
    #[test]
    fn exact_a_neutral_body_follows_the_waves() {
        let mut config = remus100::config();
        config.rigid_body.centre_of_gravity_m = [0.0; 3];
        config.sea.waves = Some(Waves {
            significant_height_m: 0.5,
            peak_period_s: 4.0,
            peak_enhancement: 3.3,
            towards_rad: 0.4,
            components: 20,
            seed: 1,
        });
        let dynamics = Dynamics::new(&config).unwrap();
        let mut state = State::level(0.0, 2.0, 0.0);
        let flow = dynamics.flow(&state, 3.0);
        state.velocity.fixed_rows_mut::<3>(0).copy_from(&flow.velocity_m_s);
        let inputs = Inputs { time_s: 3.0, ..Inputs::default() };
        let rate = dynamics.rate(&state, &inputs);
        let followed = rate.velocity.fixed_rows::<3>(0) - flow.of_the_water_m_s2();
        assert!(followed.norm() < 1e-12 && flow.of_the_water_m_s2().norm() > 0.01);
    }

    #[test]
    fn exact_attitude_of_a_constant_rate() {
        let mut state = State::level(3.0, 2.0, 0.0);
        assert!((state.euler_rad()[2] - 3.0).abs() < 1e-15);
        let config = remus100::config();
        let dynamics = Dynamics::new(&config).unwrap();
        state.velocity[5] = 0.2;
        let rate = dynamics.rate(&state, &Inputs::default());
        let [roll, pitch, heading] = state.plus(&rate, 1e-6).euler_rad();
        assert!(roll.abs() < 1e-15 && pitch.abs() < 1e-15);
        // Rounding of 3 rad over 1e-6 s.
        assert!(((heading - 3.0) / 1e-6 - 0.2).abs() < 1e-8);
    }
}

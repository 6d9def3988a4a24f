//! What a vehicle of six degrees of freedom is made from.

use serde::{Deserialize, Serialize};

use super::actuator::Actuator;
use super::depth_hold::DepthHold;
use super::fins::{Drive, Fin};
use super::hydrodynamics::Hull;
use super::propeller::Propeller;
use super::rigid_body::RigidBody;
use super::sea::{CurrentPoint, Sea};
use crate::config::HelmConfig;
use crate::config_error::ConfigError;
use crate::faults::Damage;
use crate::range::{a_number, check, check_not_negative, check_positive};

/// A vehicle of six degrees of freedom and the sea it is in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SixDofConfig {
    /// Name of the vehicle.
    pub name: String,
    /// Mass and buoyancy.
    pub rigid_body: RigidBody,
    /// The hull in the water.
    pub hull: Hull,
    /// Every fin.
    pub fins: Vec<Fin>,
    /// The propeller.
    pub propeller: Propeller,
    /// What deflects the rudders.
    pub rudder: Actuator,
    /// What deflects the elevators.
    pub elevator: Actuator,
    /// Its depth controller.
    pub depth_hold: DepthHold,
    /// Steering, instruments and the start.
    pub helm: HelmConfig,
    /// The water around it.
    pub sea: Sea,
}

impl SixDofConfig {
    /// This vehicle in still water with exact sensors; the bottom stays.
    pub fn noise_free(mut self) -> Self {
        self.helm = self.helm.noise_free();
        self.sea.current.clear();
        self.sea.waves = None;
        self
    }

    /// This vehicle after damage: rudder area goes fin by fin, and what is added to the moment of inertia in yaw
    /// comes on top of that in pitch too, as a payload along the hull does.
    pub fn damaged(&self, damage: &Damage) -> Self {
        let mut config = self.clone();
        let rudders = || self.fins.iter().filter(|fin| fin.drive == Drive::Rudder);
        let mut lost_m2 =
            damage.lost_rudder_area * rudders().map(|fin| fin.foil.area_m2).sum::<f64>();
        for fin in config.fins.iter_mut().filter(|fin| fin.drive == Drive::Rudder) {
            let gone_m2 = lost_m2.min(fin.foil.area_m2);
            fin.foil.area_m2 -= gone_m2;
            lost_m2 -= gone_m2;
        }
        let added = (damage.yaw_inertia_factor - 1.0)
            * (self.rigid_body.inertia_kg_m2[2] + self.hull.added_mass[5]);
        config.rigid_body.inertia_kg_m2[1] += added;
        config.rigid_body.inertia_kg_m2[2] += added;
        let [north_m_s, east_m_s] = damage.current_m_s;
        if config.sea.current.is_empty() {
            config.sea.current.push(CurrentPoint { depth_m: 0.0, north_m_s: 0.0, east_m_s: 0.0 });
        }
        for point in &mut config.sea.current {
            point.north_m_s += north_m_s;
            point.east_m_s += east_m_s;
        }
        config
    }

    /// Names the first field that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.helm.check()?;
        let (hull, propeller) = (&self.hull, &self.propeller);
        let (rudder, elevator) = (&self.rudder, &self.elevator);
        let above_0 = [
            ("sea.density_kg_m3", self.sea.density_kg_m3),
            ("rigid_body.mass_kg", self.rigid_body.mass_kg),
            ("hull.length_m", hull.length_m),
            ("hull.diameter_m", hull.diameter_m),
            ("hull.planform_area_m2", hull.planform_area_m2),
            ("propeller.diameter_m", propeller.diameter_m),
            ("propeller.full_speed_rev_s", propeller.full_speed_rev_s),
            ("rudder.limit_rad", rudder.limit_rad),
            ("elevator.limit_rad", elevator.limit_rad),
        ];
        let least_damping = hull.linear_damping.into_iter().fold(f64::INFINITY, f64::min);
        let from_0 = [
            ("hull.frontal_drag", hull.frontal_drag),
            ("hull.cross_flow_drag", hull.cross_flow_drag),
            ("hull.linear_damping", least_damping),
            ("propeller.time_constant_s", propeller.time_constant_s),
            ("rudder.servo.time_constant_s", rudder.servo.time_constant_s),
            ("rudder.dead_band_rad", rudder.dead_band_rad),
            ("rudder.backlash_rad", rudder.backlash_rad),
            ("elevator.servo.time_constant_s", elevator.servo.time_constant_s),
            ("elevator.dead_band_rad", elevator.dead_band_rad),
            ("elevator.backlash_rad", elevator.backlash_rad),
            ("depth_hold.pitch_limit_rad", self.depth_hold.pitch_limit_rad),
        ];
        for (field, x) in above_0 {
            check_positive(field, x)?;
        }
        for (field, x) in from_0 {
            check_not_negative(field, x)?;
        }
        let dead_band = propeller.dead_band;
        check(
            "propeller.dead_band",
            dead_band,
            (0.0..1.0).contains(&dead_band),
            "a fraction, 0 to below 1",
        )?;
        self.check_places()?;
        self.sea.waves.map_or(Ok(()), |waves| waves.check())?;
        let in_order = self.sea.current.windows(2).all(|pair| pair[1].depth_m > pair[0].depth_m);
        required("sea.current", "in order of depth", in_order.then_some(()))
    }

    /// This vehicle, checked, in the waves of a seed.
    pub(crate) fn in_waves_of(mut self, seed: u64) -> Result<Self, ConfigError> {
        self.check()?;
        if let Some(waves) = &mut self.sea.waves {
            waves.seed = waves.seed.wrapping_add(seed);
        }
        Ok(self)
    }

    fn check_places(&self) -> Result<(), ConfigError> {
        let (body, sea) = (&self.rigid_body, &self.sea);
        let all_are_numbers = |numbers: &[f64]| numbers.iter().all(|x| a_number(*x)).then_some(());
        let bottom: Vec<f64> = sea
            .bottom
            .iter()
            .flat_map(|bottom| [bottom.depth_m, bottom.slope_north, bottom.slope_east])
            .collect();
        let current: Vec<f64> = sea
            .current
            .iter()
            .flat_map(|point| [point.depth_m, point.north_m_s, point.east_m_s])
            .collect();
        for (field, numbers) in [
            ("rigid_body.inertia_kg_m2", body.inertia_kg_m2.as_slice()),
            ("rigid_body.centre_of_gravity_m", &body.centre_of_gravity_m),
            ("rigid_body.centre_of_buoyancy_m", &body.centre_of_buoyancy_m),
            ("rigid_body.buoyancy_n", &[body.buoyancy_n]),
            ("hull.added_mass", &self.hull.added_mass),
            ("hull.centre_of_lift_m", &[self.hull.centre_of_lift_m]),
            ("depth_hold.depth_m", &[self.depth_hold.depth_m]),
            ("sea.bottom", &bottom),
            ("sea.current", &current),
        ] {
            required(field, "of numbers", all_are_numbers(numbers))?;
        }
        Ok(())
    }
}

/// The value, or the field that it hangs on.
pub(crate) fn required<T>(
    field: &str,
    requirement: &'static str,
    value: Option<T>,
) -> Result<T, ConfigError> {
    value.ok_or_else(|| ConfigError::Unfit { field: field.to_owned(), requirement })
}

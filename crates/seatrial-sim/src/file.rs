//! Vehicle files of every kind, and conditions that take the place of a vehicle's own.

use std::path::Path;

use serde::Deserialize;
use toml::{Table, Value};

use crate::config::VehicleConfig;
use crate::config_error::ConfigError;
use crate::identified::IdentifiedVehicle;
use crate::range::{a_number, check_not_negative, positive};
use crate::simulated::SimulatedConfig;
use crate::six_dof::config::required;
use crate::six_dof::fins::Drive;
use crate::six_dof::rigid_body::{GRAVITY_M_S2, RigidBody};
use crate::six_dof::{SixDofConfig, remus100, starfish};
use crate::vehicle_text::{in_file, is_json};

/// Tables of a file that are the helm's.
const OF_THE_HELM: [&str; 7] = [
    "rudder_limit_rad",
    "initial_thrust",
    "initial_heading_rad",
    "heading_hold",
    "disturbance",
    "sensors",
    "timing",
];

/// A vehicle to begin with, and what is changed of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleVariant {
    base: Base,
    payload: Option<Payload>,
    trim_n: Option<f64>,
    #[serde(default = "unchanged")]
    rudder_area_factor: f64,
    #[serde(default = "unchanged")]
    elevator_area_factor: f64,
}

fn unchanged() -> f64 {
    1.0
}

#[derive(Deserialize)]
enum Base {
    #[serde(rename = "remus100")]
    Remus100,
    #[serde(rename = "starfish-6dof")]
    Starfish,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Payload {
    mass_kg: f64,
    displaced_kg: Option<f64>,
    position_m: [f64; 3],
}

impl SimulatedConfig {
    /// The vehicle of a TOML text.
    ///
    /// A text with a `schema` is an [`IdentifiedVehicle`], whose twin has a yaw model at every speed.
    ///
    /// One with a table `vehicle` is one of six degrees of freedom: it names a vehicle to begin with, and everything
    /// else in the file takes the place of that vehicle's numbers. Any field of [`SixDofConfig`] may; those of its helm
    /// stand at the top as in the file of a [`VehicleConfig`].
    ///
    /// ```
    /// let text = r#"
    /// name = "remus with a sonar"
    ///
    /// [vehicle]
    /// base = "remus100"                # or starfish-6dof
    /// trim_n = 7.0                     # buoyancy less weight
    /// rudder_area_factor = 1.2
    /// elevator_area_factor = 1.0
    ///
    /// [vehicle.payload]
    /// mass_kg = 2.0
    /// displaced_kg = 1.5               # water that it displaces; absent: its own mass
    /// position_m = [0.5, 0.0, 0.05]    # forward, starboard, down
    ///
    /// [hull]
    /// cross_flow_drag = 1.1
    ///
    /// [depth_hold]
    /// depth_m = 3.0
    ///
    /// [sea.waves]                      # JONSWAP; absent peak_enhancement: Pierson and Moskowitz
    /// significant_height_m = 0.3
    /// peak_period_s = 3.0
    /// peak_enhancement = 3.3
    /// towards_rad = 1.0
    ///
    /// [[sea.current]]                  # one is uniform, several are sheared
    /// depth_m = 0.0
    /// north_m_s = 0.3
    /// east_m_s = 0.0
    ///
    /// [[sea.current]]
    /// depth_m = 5.0
    /// north_m_s = 0.1
    /// east_m_s = 0.0
    ///
    /// [sea.bottom]
    /// depth_m = 12.0
    /// slope_north = -0.05
    ///
    /// [sensors.dvl]
    /// range_m = [0.5, 30.0]
    /// "#;
    /// let seatrial_sim::SimulatedConfig::SixDof(config) = seatrial_sim::SimulatedConfig::from_toml(text)? else {
    ///     panic!("six degrees of freedom");
    /// };
    /// assert_eq!(config.sea.current.len(), 2);
    /// # Ok::<(), seatrial_sim::ConfigError>(())
    /// ```
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let table: Table = toml::from_str(text)?;
        if table.contains_key("schema") {
            return Ok(Self::identified(&IdentifiedVehicle::from_toml(text)?));
        }
        if !table.contains_key("vehicle") {
            return VehicleConfig::from_toml(text).map(|config| Self::FirstOrder(Box::new(config)));
        }
        Self::of_base(table)
    }

    /// The vehicle of a JSON text, with the names of the TOML file.
    pub fn from_json(text: &str) -> Result<Self, ConfigError> {
        let fields: Table = serde_json::from_str(text)?;
        if fields.contains_key("schema") {
            return Ok(Self::identified(&IdentifiedVehicle::from_json(text)?));
        }
        if !fields.contains_key("vehicle") {
            let config: VehicleConfig = serde_json::from_str(text)?;
            config.check()?;
            return Ok(Self::FirstOrder(Box::new(config)));
        }
        Self::of_base(fields)
    }

    fn identified(vehicle: &IdentifiedVehicle) -> Self {
        Self::FirstOrder(Box::new(vehicle.twin()))
    }

    /// The vehicle that the table `vehicle` names, with the other fields in the place of its own.
    fn of_base(mut table: Table) -> Result<Self, ConfigError> {
        let vehicle = table.remove("vehicle").unwrap_or(Value::Table(Table::new()));
        let changed: VehicleVariant = vehicle.try_into()?;
        let base = match changed.base {
            Base::Remus100 => remus100::config(),
            Base::Starfish => starfish::config(),
        };
        let mut config = base.with(table)?;
        changed.apply(&mut config)?;
        config.check()?;
        Ok(Self::SixDof(Box::new(config)))
    }

    /// The vehicle of a TOML or JSON file.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        in_file(path, |text| match is_json(text) {
            true => Self::from_json(text),
            false => Self::from_toml(text),
        })
    }
}

impl VehicleConfig {
    /// This vehicle with the fields of a file in place of its own. Refuses a field that it does not have or that is out of
    /// range.
    pub fn with(&self, fields: Table) -> Result<Self, ConfigError> {
        let mut table = own(self)?;
        overlay(&mut table, fields);
        let config: Self = table.try_into()?;
        config.check()?;
        Ok(config)
    }
}

impl SixDofConfig {
    /// This vehicle with the fields of a file in place of its own. Refuses a field that it does not have or that is out of
    /// range.
    pub fn with(&self, mut fields: Table) -> Result<Self, ConfigError> {
        let helm: Table =
            OF_THE_HELM.into_iter().filter_map(|name| fields.remove_entry(name)).collect();
        let mut table = own(self)?;
        overlay(&mut table, fields);
        if !helm.is_empty() {
            overlay(&mut table, Table::from_iter([("helm".to_owned(), Value::Table(helm))]));
        }
        let config: Self = table.try_into()?;
        config.check()?;
        Ok(config)
    }
}

/// The fields of a configuration.
fn own(config: &impl serde::Serialize) -> Result<Table, ConfigError> {
    required("vehicle", "one that a file can hold", Table::try_from(config).ok())
}

/// Puts fields in the place of those of the same name, table by table.
fn overlay(below: &mut Table, above: Table) {
    for (name, value) in above {
        match (below.get_mut(&name), value) {
            (Some(Value::Table(below)), Value::Table(above)) => overlay(below, above),
            (_, value) => {
                below.insert(name, value);
            }
        }
    }
}

impl VehicleVariant {
    fn apply(&self, config: &mut SixDofConfig) -> Result<(), ConfigError> {
        let factors = [
            ("vehicle.rudder_area_factor", self.rudder_area_factor),
            ("vehicle.elevator_area_factor", self.elevator_area_factor),
        ];
        for (field, x) in factors {
            check_not_negative(field, x)?;
        }
        for fin in &mut config.fins {
            fin.foil.area_m2 *= match fin.drive {
                Drive::Rudder => self.rudder_area_factor,
                Drive::Elevator => self.elevator_area_factor,
            };
        }
        if let Some(payload) = &self.payload {
            config.rigid_body = payload.in_the_body(&config.rigid_body)?;
        }
        if let Some(trim_n) = self.trim_n {
            config.rigid_body.buoyancy_n = config.rigid_body.weight_n() + trim_n;
        }
        let is_a_number = self.trim_n.is_none_or(a_number);
        required("vehicle.trim_n", "a number", is_a_number.then_some(()))
    }
}

impl Payload {
    /// The body with a point mass more: Steiner's theorem about the new centre of gravity. Products of inertia that
    /// a mass off the axes makes about that centre are left out.
    fn in_the_body(&self, body: &RigidBody) -> Result<RigidBody, ConfigError> {
        let displaced_kg = self.displaced_kg.unwrap_or(self.mass_kg);
        let mass_kg = body.mass_kg + self.mass_kg;
        let own_kg = body.buoyancy_n / GRAVITY_M_S2;
        let is_positive = positive(mass_kg) && positive(own_kg + displaced_kg);
        required(
            "vehicle.payload",
            "such that mass and buoyancy stay positive",
            is_positive.then_some(()),
        )?;
        let is_somewhere = self.position_m.iter().all(|x| a_number(*x));
        required("vehicle.payload.position_m", "three numbers", is_somewhere.then_some(()))?;
        let centre = |a_kg: f64, a_m: [f64; 3], b_kg: f64| -> [f64; 3] {
            std::array::from_fn(|i| (a_kg * a_m[i] + b_kg * self.position_m[i]) / (a_kg + b_kg))
        };
        let centre_of_gravity_m = centre(body.mass_kg, body.centre_of_gravity_m, self.mass_kg);
        let mut inertia_kg_m2 = body.inertia_kg_m2;
        for (kg, at_m) in
            [(body.mass_kg, body.centre_of_gravity_m), (self.mass_kg, self.position_m)]
        {
            let arm: [f64; 3] = std::array::from_fn(|i| at_m[i] - centre_of_gravity_m[i]);
            let square: f64 = arm.iter().map(|x| x * x).sum();
            for (inertia, along) in inertia_kg_m2.iter_mut().zip(arm) {
                *inertia += kg * (square - along * along);
            }
        }
        Ok(RigidBody {
            mass_kg,
            inertia_kg_m2,
            centre_of_gravity_m,
            centre_of_buoyancy_m: centre(own_kg, body.centre_of_buoyancy_m, displaced_kg),
            buoyancy_n: body.buoyancy_n + displaced_kg * GRAVITY_M_S2,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn six_dof(text: &str) -> SixDofConfig {
        match SimulatedConfig::from_toml(text).unwrap() {
            SimulatedConfig::SixDof(config) => *config,
            SimulatedConfig::FirstOrder(_) => panic!("{text}"),
        }
    }

    #[test]
    fn exact_a_base_alone_is_the_vehicle_itself() {
        for (name, config) in
            [("remus100", remus100::config()), ("starfish-6dof", starfish::config())]
        {
            assert_eq!(six_dof(&format!("[vehicle]\nbase = {name:?}")), config);
        }
        let first_order = toml::to_string(&VehicleConfig::starfish()).unwrap();
        let file = SimulatedConfig::from_toml(&first_order).unwrap();
        let starfish = Box::new(VehicleConfig::starfish());
        assert_eq!(file, SimulatedConfig::FirstOrder(starfish));
    }

    #[test]
    fn io_a_file_may_be_json() {
        let base = r#"{"vehicle": {"base": "remus100", "trim_n": 3}, "name": "other"}"#;
        let toml = "name = 'other'\n[vehicle]\nbase = 'remus100'\ntrim_n = 3";
        let json = SimulatedConfig::from_json(base).unwrap();
        assert_eq!(json, SimulatedConfig::from_toml(toml).unwrap());
        let config = VehicleConfig::starfish();
        let toml = toml::to_string(&config).unwrap();
        let json = serde_json::to_string(&toml::from_str::<Table>(&toml).unwrap()).unwrap();
        assert!(is_json(&format!("\n {json}")) && !is_json(&toml));
        let read = SimulatedConfig::from_json(&json).unwrap();
        assert_eq!(read, SimulatedConfig::FirstOrder(Box::new(config)));
        for (text, expected) in [
            ("{", "not a vehicle: EOF while parsing"),
            (r#"{"vehicle": {"base": "titanic"}}"#, "titanic"),
            (r#"{"schema": "seatrial.vehicle.v1"}"#, "missing field"),
        ] {
            let message = SimulatedConfig::from_json(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn exact_a_payload_moves_the_centres_and_adds_inertia() {
        let base = remus100::config().rigid_body;
        let changed = six_dof(
            "[vehicle]\nbase = 'remus100'\ntrim_n = 3\nrudder_area_factor = 2\n\
             [vehicle.payload]\nmass_kg = 2\nposition_m = [0.5, 0, 0.02]",
        );
        let body = changed.rigid_body;
        assert!((body.mass_kg - base.mass_kg - 2.0).abs() < 1e-12);
        assert!((body.buoyancy_n - body.weight_n() - 3.0).abs() < 1e-9);
        assert!((body.centre_of_gravity_m[0] - 1.0 / body.mass_kg).abs() < 1e-12);
        // Two masses 0.5 m apart turn about their centre with their reduced mass.
        let reduced_kg = base.mass_kg * 2.0 / body.mass_kg;
        let added = body.inertia_kg_m2[2] - base.inertia_kg_m2[2];
        assert!((added - reduced_kg * 0.25).abs() < 1e-12);
        assert!((body.inertia_kg_m2[0] - base.inertia_kg_m2[0]).abs() < 1e-12);
        let area =
            |config: &SixDofConfig| config.fins.iter().map(|fin| fin.foil.area_m2).sum::<f64>();
        assert!((area(&changed) / area(&remus100::config()) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn exact_other_fields_take_the_place_of_the_vehicles_own() {
        let config = six_dof(
            "name = 'rough'\ninitial_thrust = 0.7\n[vehicle]\nbase = 'starfish-6dof'\n\
             [hull]\ncross_flow_drag = 1.1\n[sensors.compass]\nlag_s = 0.3\n\
             [sea]\ndensity_kg_m3 = 1025\n[sea.waves]\nsignificant_height_m = 0.3\npeak_period_s = 3\n\
             [sea.bottom]\ndepth_m = 9",
        );
        let base = starfish::config();
        assert_eq!(config.name, "rough");
        assert_eq!(config.helm.initial_thrust, 0.7);
        assert_eq!(config.hull.cross_flow_drag, 1.1);
        assert_eq!(config.hull.added_mass, base.hull.added_mass);
        assert_eq!(config.helm.sensors.compass.lag_s, 0.3);
        assert_eq!(config.helm.sensors.compass.noise_rad, base.helm.sensors.compass.noise_rad);
        assert_eq!(config.sea.density_kg_m3, 1025.0);
        assert_eq!(config.sea.waves.unwrap().peak_enhancement, 1.0);
        assert_eq!(config.sea.bottom.unwrap().depth_m, 9.0);
    }

    #[test]
    fn io_faults_name_the_field() {
        let base = "[vehicle]\nbase = 'remus100'\n";
        for (text, expected) in [
            ("[vehicle]\nbase = 'titanic'", "titanic"),
            (&format!("{base}sail = 1"), "unknown field `sail`"),
            (&format!("{base}rudder_area_factor = -1"), "vehicle.rudder_area_factor must be"),
            (&format!("{base}trim_n = inf"), "vehicle.trim_n must be"),
            (
                &format!("{base}[vehicle.payload]\nmass_kg = -99\nposition_m = [0, 0, 0]"),
                "vehicle.payload must be",
            ),
            (&format!("{base}[hull]\nkeel_m = 1"), "unknown field `keel_m`"),
            (
                &format!("{base}[sea.waves]\nsignificant_height_m = -1\npeak_period_s = 3"),
                "sea.waves.significant_height_m must be",
            ),
            (&format!("{base}[sea.bottom]\ndepth_m = nan"), "sea.bottom must be"),
            (
                &format!("{base}[sensors.gyro]\nnoise_rad_s = -1"),
                "sensors.gyro.noise_rad_s must be",
            ),
            (&format!("{base}[sensors.sonar]"), "unknown field `sonar`"),
        ] {
            let message = SimulatedConfig::from_toml(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        let message = SimulatedConfig::load(Path::new("no-such.toml")).unwrap_err().to_string();
        assert!(message.starts_with("no-such.toml:"), "{message}");
    }
}

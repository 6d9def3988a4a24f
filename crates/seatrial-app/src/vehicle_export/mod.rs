//! The vehicle file in the form that simulators, planners and controllers read.
//!
//! A template holds the equations of [`IdentifiedVehicle`] in the target's language; where a target has a model of its own, its
//! parameters are those that do the same at one speed. `docs/exports.md` says where each is defined and what it cannot carry.

mod fmu;
mod gazebo;
mod guidance;
mod moos;
mod nav2;
mod program;
mod ros2_control;

use std::fmt::Display;

use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::IdentifiedSpeed;

use crate::Error;
use crate::file_form::{FileForm, Row};
use fmu::Fmu;

/// What a vehicle is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Form {
    /// The vehicle file, TOML.
    Toml,
    /// The vehicle file, JSON.
    Json,
    /// A Python class that needs numpy only.
    Python,
    /// CasADi functions in Python, for MPC and acados.
    Casadi,
    /// The vehicle in MuJoCo's engine, Python.
    Mujoco,
    /// Functions of Octave and Matlab.
    Octave,
    /// Transfer functions of ControlSystems.jl, Julia.
    ControlSystems,
    /// A Functional Mock-up Unit, FMI 3.0 for co-simulation.
    Fmu,
    /// SDF of Gazebo with its hydrodynamics plugin.
    Gazebo,
    /// Configuration of MOOS-IvP's uSimMarine.
    Moos,
    /// Limits of ROS 2's Nav2, YAML.
    Nav2,
    /// Gains and limits of ROS 2's ros2_controllers, YAML.
    Ros2Control,
    /// The joints of ros2_control's hardware, an element of URDF.
    Ros2ControlUrdf,
    /// Radius, rate, lookahead and waypoint radius of each speed, TOML.
    Guidance,
}

impl FileForm for Form {
    const ALL: &[Row<Self>] = &[
        Row {
            form: Self::Toml,
            name: "vehicle",
            extension: "toml",
            label: "Vehicle file, TOML",
            about: "The vehicle file, TOML",
        },
        Row {
            form: Self::Json,
            name: "vehicle-json",
            extension: "vehicle.json",
            label: "Vehicle file, JSON",
            about: "The vehicle file, JSON",
        },
        Row {
            form: Self::Python,
            name: "python",
            extension: "py",
            label: "Python",
            about: "A Python class that needs numpy only",
        },
        Row {
            form: Self::Casadi,
            name: "casadi",
            extension: "casadi.py",
            label: "CasADi",
            about: "CasADi functions in Python, for MPC and acados",
        },
        Row {
            form: Self::Mujoco,
            name: "mujoco",
            extension: "mujoco.py",
            label: "MuJoCo",
            about: "The vehicle in MuJoCo's engine, Python",
        },
        Row {
            form: Self::Octave,
            name: "octave",
            extension: "m",
            label: "Octave and Matlab",
            about: "Functions of Octave and Matlab",
        },
        Row {
            form: Self::ControlSystems,
            name: "julia",
            extension: "jl",
            label: "Julia, ControlSystems.jl",
            about: "Transfer functions of ControlSystems.jl, Julia",
        },
        Row {
            form: Self::Fmu,
            name: "fmu",
            extension: "fmu",
            label: "FMU, FMI 3.0",
            about: "A Functional Mock-up Unit, FMI 3.0 for co-simulation",
        },
        Row {
            form: Self::Gazebo,
            name: "gazebo",
            extension: "sdf",
            label: "Gazebo, SDF",
            about: "SDF of Gazebo with its hydrodynamics plugin",
        },
        Row {
            form: Self::Moos,
            name: "moos",
            extension: "moos",
            label: "MOOS-IvP",
            about: "Configuration of MOOS-IvP's uSimMarine",
        },
        Row {
            form: Self::Nav2,
            name: "nav2",
            extension: "nav2.yaml",
            label: "Nav2, YAML",
            about: "Limits of ROS 2's Nav2, YAML",
        },
        Row {
            form: Self::Ros2Control,
            name: "ros2_control",
            extension: "ros2_control.yaml",
            label: "ros2_control, YAML",
            about: "Gains and limits of ROS 2's ros2_controllers, YAML",
        },
        Row {
            form: Self::Ros2ControlUrdf,
            name: "ros2_control-urdf",
            extension: "urdf",
            label: "ros2_control, URDF",
            about: "The joints of ros2_control's hardware, an element of URDF",
        },
        Row {
            form: Self::Guidance,
            name: "guidance",
            extension: "guidance.toml",
            label: "Path follower, TOML",
            about: "Radius, rate, lookahead and waypoint radius of each speed, TOML",
        },
    ];
}

/// The bytes of a vehicle's file, and what to know about it. A form that has a model of a single speed gets that at `thrust`, the
/// fastest without.
///
/// # Errors
/// What the form cannot carry, and a thrust that is none.
pub fn file(
    vehicle: &IdentifiedVehicle,
    form: Form,
    thrust: Option<f64>,
) -> Result<(Vec<u8>, Option<String>), Error> {
    let unwritten = |error: &dyn Display| Error::Input(format!("{}: {error}", vehicle.name));
    let is_none = |thrust: f64| !(thrust > 0.0 && thrust <= 1.0);
    let at_thrust = || operating_point(vehicle, thrust);
    let text = match (form, thrust) {
        (Form::Fmu, _) => {
            let fmu = Fmu::of(vehicle)?;
            let note = fmu.without_binary.map(|reason| {
                format!("the FMU holds source code only ({reason}); `fmpy compile FILE.fmu` adds a binary")
            });
            return Ok((fmu.bytes, note));
        }
        (Form::Toml, _) => vehicle.to_toml().map_err(|error| unwritten(&error))?,
        (Form::Json, _) => vehicle.to_json().map_err(|error| unwritten(&error))?,
        (_, Some(thrust)) if is_none(thrust) => {
            return Err(Error::Setting(format!(
                "--at-thrust {thrust}: expected a fraction of full, above 0 and at most 1"
            )));
        }
        (Form::Python, _) => program::numpy(vehicle),
        (Form::Casadi, _) => program::casadi(vehicle),
        (Form::Mujoco, _) => program::mujoco(vehicle),
        (Form::Octave, _) => program::octave(vehicle),
        (Form::ControlSystems, _) => program::control_systems(vehicle),
        (Form::Gazebo, _) => gazebo::sdf(vehicle, &at_thrust()),
        (Form::Moos, _) => moos::configuration(vehicle, &at_thrust())?,
        (Form::Nav2, _) => nav2::yaml(vehicle, &at_thrust())?,
        (Form::Ros2Control, _) => ros2_control::yaml(vehicle, &at_thrust())?,
        (Form::Ros2ControlUrdf, _) => ros2_control::urdf(vehicle, &at_thrust()),
        (Form::Guidance, _) => guidance::toml(vehicle)?,
    };
    Ok((text.into_bytes(), None))
}

/// Refuses a form with gains where these are warned of: the models are not to be used, or not even the sign of a gain is known.
///
/// # Errors
/// Why no file of gains is written.
pub fn check_usable(
    vehicle: &IdentifiedVehicle,
    form: Form,
    thrust: Option<f64>,
    rejected: Option<&String>,
) -> Result<(), Error> {
    if form != Form::Ros2Control {
        return Ok(());
    }
    let unsure = || ros2_control::unsure(vehicle, &operating_point(vehicle, thrust));
    match rejected.cloned().or_else(unsure) {
        None => Ok(()),
        Some(why) => {
            Err(Error::Rejected(format!("{}: no file of gains is written: {why}", vehicle.name)))
        }
    }
}

/// The model at a thrust, between or beyond the speeds of the file.
fn operating_point(vehicle: &IdentifiedVehicle, thrust: Option<f64>) -> IdentifiedSpeed {
    let fastest = vehicle.speeds[vehicle.speeds.len() - 1];
    let Some(thrust) = thrust else {
        return fastest;
    };
    let truth = vehicle.plant(thrust).truth(thrust);
    IdentifiedSpeed {
        thrust,
        surge_speed_m_s: truth.surge_speed_m_s,
        ..fastest.with_model(&truth.model)
    }
}

/// Where the numbers come from and what the file cannot carry, a line each.
fn head(vehicle: &IdentifiedVehicle, cannot: &[String]) -> Vec<String> {
    let provenance = &vehicle.provenance;
    let mut lines =
        vec![format!("{}, by seatrial {}", plain(&vehicle.name), env!("CARGO_PKG_VERSION"))];
    let mut about = |what: &str, text: &str| {
        if !text.is_empty() {
            lines.push(format!("{what}: {}", plain(text)));
        }
    };
    about("From", &provenance.source);
    about("Trial begun", &provenance.trial_started);
    if provenance.is_rehearsal {
        about("REHEARSAL", "of a simulator, not measured on a vehicle");
    }
    for assumption in &provenance.assumptions {
        about("Assumed", assumption);
    }
    for caution in &provenance.cautions {
        about("Caution", caution);
    }
    about(
        "Not carried",
        "the intervals of the parameters; `seatrial export --sample N` draws vehicles from them",
    );
    for what in cannot {
        about("Not carried", what);
    }
    lines
}

/// Text on one line that ends no comment of a program.
fn plain(text: &str) -> String {
    let text = text.replace(char::is_control, " ");
    let text = text.replace("\"\"\"", "'''");
    text.replace("*/", "* /").replace('\\', "/")
}

/// Text in an attribute of XML.
fn attribute(text: &str) -> String {
    let text = text.replace(char::is_control, " ").replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// What a target of one speed leaves out.
fn single_speed(vehicle: &IdentifiedVehicle, at: &IdentifiedSpeed) -> Vec<String> {
    let mut cannot = vec![format!(
        "the schedule over speed: the numbers are those at {} m/s",
        at.surge_speed_m_s
    )];
    let rudder = &vehicle.rudder;
    if rudder.lag_s > 0.0 || rudder.delay_s > 0.0 {
        cannot.push(format!(
            "the rudder's lag of {} s and dead time of {} s",
            rudder.lag_s, rudder.delay_s
        ));
    }
    cannot
}

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
use fmu::Fmu;

/// What a vehicle is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// A Python module that needs numpy only.
    Numpy,
    /// A Python module of CasADi functions, for MPC.
    Casadi,
    /// A Python module with the vehicle in MuJoCo's engine.
    Mujoco,
    /// Functions of Octave and Matlab.
    Octave,
    /// SDF of Gazebo with its hydrodynamics plugin.
    Gazebo,
    /// The configuration of MOOS-IvP's uSimMarine.
    Moos,
    /// Limits of ROS 2's Nav2: MPPI, smoother, planner.
    Nav2,
    /// Gains and limits of the controllers of `ros2_controllers`, YAML.
    Ros2Control,
    /// The joints of `ros2_control`'s hardware, an element of URDF.
    Ros2ControlUrdf,
    /// What a path follower has to know, TOML.
    Guidance,
}

/// The form of a file of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The vehicle file, TOML.
    Toml,
    /// The vehicle file, JSON.
    Json,
    /// A Functional Mock-up Unit, FMI 3.0 for co-simulation.
    Fmu,
    /// A text for a target.
    For(Target),
}

impl Form {
    /// How its name ends.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Toml | Self::For(Target::Guidance) => "toml",
            Self::Json => "json",
            Self::Fmu => "fmu",
            Self::For(Target::Numpy | Target::Casadi | Target::Mujoco) => "py",
            Self::For(Target::Octave) => "m",
            Self::For(Target::Gazebo) => "sdf",
            Self::For(Target::Moos) => "moos",
            Self::For(Target::Nav2 | Target::Ros2Control) => "yaml",
            Self::For(Target::Ros2ControlUrdf) => "urdf",
        }
    }

    /// The target, where it is a text for one.
    pub fn target(self) -> Option<Target> {
        match self {
            Self::For(target) => Some(target),
            Self::Toml | Self::Json | Self::Fmu => None,
        }
    }
}

/// The bytes of a vehicle's file, and what to know about it; `thrust` as for [`text`].
///
/// # Errors
/// What the target cannot carry, and a thrust that is none.
pub fn file(
    vehicle: &IdentifiedVehicle,
    form: Form,
    thrust: Option<f64>,
) -> Result<(Vec<u8>, Option<String>), Error> {
    let unwritten = |error: &dyn Display| Error::Input(format!("{}: {error}", vehicle.name));
    let text = match form {
        Form::Fmu => {
            let fmu = Fmu::of(vehicle)?;
            let note = fmu.without_binary.map(|reason| {
                format!("the FMU holds source code only ({reason}); `fmpy compile FILE.fmu` adds a binary")
            });
            return Ok((fmu.bytes, note));
        }
        Form::Toml => vehicle.to_toml().map_err(|error| unwritten(&error))?,
        Form::Json => vehicle.to_json().map_err(|error| unwritten(&error))?,
        Form::For(target) => text(vehicle, target, thrust)?,
    };
    Ok((text.into_bytes(), None))
}

/// Writes a vehicle for a target; one that has a model of a single speed gets that at `thrust`, the fastest without.
pub fn text(
    vehicle: &IdentifiedVehicle,
    target: Target,
    thrust: Option<f64>,
) -> Result<String, Error> {
    if let Some(thrust) = thrust.filter(|thrust| !(*thrust > 0.0 && *thrust <= 1.0)) {
        return Err(Error::Setting(format!(
            "--at-thrust {thrust}: expected a fraction of full, above 0 and at most 1"
        )));
    }
    Ok(match target {
        Target::Numpy => program::numpy(vehicle),
        Target::Casadi => program::casadi(vehicle),
        Target::Mujoco => program::mujoco(vehicle),
        Target::Octave => program::octave(vehicle),
        Target::Gazebo => gazebo::sdf(vehicle, &operating_point(vehicle, thrust)),
        Target::Moos => moos::configuration(vehicle, &operating_point(vehicle, thrust))?,
        Target::Nav2 => nav2::yaml(vehicle, &operating_point(vehicle, thrust))?,
        Target::Ros2Control => ros2_control::yaml(vehicle, &operating_point(vehicle, thrust))?,
        Target::Ros2ControlUrdf => ros2_control::urdf(vehicle, &operating_point(vehicle, thrust)),
        Target::Guidance => guidance::toml(vehicle)?,
    })
}

/// Refuses a target with gains where these are warned of: the models are not to be used, or not even the sign of a gain is known.
///
/// # Errors
/// Why no file of gains is written.
pub fn check_usable(
    vehicle: &IdentifiedVehicle,
    target: Target,
    thrust: Option<f64>,
    rejected: Option<&String>,
) -> Result<(), Error> {
    if target != Target::Ros2Control {
        return Ok(());
    }
    let unsure = || ros2_control::unsure(vehicle, &operating_point(vehicle, thrust));
    match rejected.cloned().or_else(unsure) {
        None => Ok(()),
        Some(why) => Err(Error::Rejected(format!(
            "{}: no file of gains is written: {why}",
            vehicle.name
        ))),
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
    let mut lines = vec![format!(
        "{}, by seatrial {}",
        plain(&vehicle.name),
        env!("CARGO_PKG_VERSION")
    )];
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
    let text = text
        .replace(char::is_control, " ")
        .replace('&', "&amp;")
        .replace('<', "&lt;");
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

//! The XML files of an FMU.

use std::fmt::Write as _;

use seatrial_sim::IdentifiedVehicle;

use super::super::{attribute, head};

/// A variable of the source code: unit, name and what it is.
type Variable = (&'static str, &'static str, &'static str);

const INPUTS: [Variable; 2] = [
    ("rad", "rudder_command_rad", "rudder angle commanded, starboard positive"),
    ("1", "thrust", "thrust, fraction of full"),
];
const OUTPUTS: [Variable; 6] = [
    ("m", "north_m", "north of the start"),
    ("m", "east_m", "east of the start"),
    ("rad", "heading_rad", "heading, clockwise positive, not wrapped"),
    ("m/s", "speed_m_s", "forward speed"),
    ("rad/s", "yaw_rate_rad_s", "yaw rate, clockwise positive"),
    ("rad", "rudder_rad", "rudder angle"),
];
const PARAMETERS: [Variable; 8] = [
    ("rad", "initial_heading_rad", "heading at the start"),
    ("rad", "rudder_limit_rad", "largest rudder angle"),
    ("s", "rudder_lag_s", "time constant of the rudder's lag"),
    ("s", "rudder_delay_s", "dead time of the rudder"),
    ("rad/s", "rudder_rate_limit_rad_s", "fastest motion of the rudder; 0: no limit"),
    ("s", "surge_time_constant_s", "T of the speed, where drag_length_m is 0"),
    ("m", "drag_length_m", "mass over drag per speed squared; 0: the speed follows with T"),
    ("m", "turning_drag_m", "speed that a turn costs"),
];
const TABLES: [Variable; 5] = [
    ("1", "thrust_points", "thrusts of the points, rising"),
    ("m/s", "steady_speed_m_s", "steady speed at each, rising"),
    ("1/s", "a22_per_s", "yaw damping at each"),
    ("1/s2", "b2_per_s2", "rudder effectiveness at each, per rad"),
    ("rad/s2", "c0_rad_per_s2", "constant yaw acceleration at each"),
];
const UNITS: &str = "\
    <Unit name=\"1\"><BaseUnit/></Unit>
    <Unit name=\"m\"><BaseUnit m=\"1\"/></Unit>
    <Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>
    <Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>
    <Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit>
    <Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit>
    <Unit name=\"rad/s2\"><BaseUnit rad=\"1\" s=\"-2\"/></Unit>
    <Unit name=\"1/s\"><BaseUnit s=\"-1\"/></Unit>
    <Unit name=\"1/s2\"><BaseUnit s=\"-2\"/></Unit>
";

/// `sources/buildDescription.xml`.
pub(super) fn build(model: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  <BuildConfiguration \
         modelIdentifier=\"{model}\">\n    <SourceFileSet language=\"C99\">\n      <SourceFile name=\"vehicle.c\"/>\n    \
         </SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
}

/// `modelDescription.xml`: value references count the variables in the order of the source code, the time being 0.
pub(super) fn model(vehicle: &IdentifiedVehicle, model: &str, token: &str) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" \
         instantiationToken=\"{token}\" description=\"{}\" generationTool=\"seatrial {}\" variableNamingConvention=\"flat\">\n  \
         <CoSimulation modelIdentifier=\"{model}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"true\"/>\n  \
         <UnitDefinitions>\n{UNITS}  </UnitDefinitions>\n  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  \
         </LogCategories>\n  <DefaultExperiment startTime=\"0\" stopTime=\"60\" stepSize=\"0.05\"/>\n  <ModelVariables>\n    <Float64 \
         name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" unit=\"s\" description=\"time\"/>\n",
        attribute(&vehicle.name),
        attribute(&head(vehicle, &[]).join("; ")),
        env!("CARGO_PKG_VERSION"),
    );
    let mut reference = 0;
    let mut add = |variable: &Variable, role: &str, start: Option<&str>, points: usize| {
        reference += 1;
        let (unit, name, what) = variable;
        let start = start.map_or(String::new(), |start| format!(" start=\"{start}\""));
        let end = match points {
            0 => "/>".to_owned(),
            _ => format!(">\n      <Dimension start=\"{points}\"/>\n    </Float64>"),
        };
        let _ = writeln!(
            text,
            "    <Float64 name=\"{name}\" valueReference=\"{reference}\" {role} unit=\"{unit}\"{start} description=\"{what}\"{end}",
        );
    };
    for (variable, start) in INPUTS.iter().zip([0.0, vehicle.fastest_thrust()]) {
        let role = "causality=\"input\" variability=\"continuous\"";
        add(variable, role, Some(&format!("{start:?}")), 0);
    }
    for variable in &OUTPUTS {
        let role = "causality=\"output\" variability=\"continuous\" initial=\"calculated\"";
        add(variable, role, None, 0);
    }
    let fixed = "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"";
    for (variable, start) in PARAMETERS.iter().zip(scalars(vehicle)) {
        add(variable, fixed, Some(&format!("{start:?}")), 0);
    }
    for (variable, start) in TABLES.iter().zip(columns(vehicle)) {
        add(variable, fixed, Some(&start), vehicle.speeds.len());
    }
    text.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    let outputs = (1..=OUTPUTS.len()).map(|k| INPUTS.len() + k);
    for kind in ["Output", "InitialUnknown"] {
        for reference in outputs.clone() {
            let _ = writeln!(text, "    <{kind} valueReference=\"{reference}\"/>");
        }
    }
    text + "  </ModelStructure>\n</fmiModelDescription>\n"
}

fn scalars(vehicle: &IdentifiedVehicle) -> [f64; 8] {
    let (rudder, surge) = (&vehicle.rudder, &vehicle.surge);
    [
        0.0,
        rudder.limit_rad,
        rudder.lag_s,
        rudder.delay_s,
        rudder.rate_limit_rad_s.unwrap_or(0.0),
        surge.time_constant_s,
        surge.drag_length_m.unwrap_or(0.0),
        surge.turning_drag_m.unwrap_or(0.0),
    ]
}

/// The numbers of each table, separated by blanks.
fn columns(vehicle: &IdentifiedVehicle) -> [String; 5] {
    let of: [fn(&seatrial_sim::identified::IdentifiedSpeed) -> f64; 5] = [
        |p| p.thrust,
        |p| p.surge_speed_m_s,
        |p| p.a22_per_s,
        |p| p.b2_per_s2,
        |p| p.c0_rad_per_s2,
    ];
    of.map(|of| {
        let numbers: Vec<String> = vehicle.speeds.iter().map(|p| format!("{:?}", of(p))).collect();
        numbers.join(" ")
    })
}

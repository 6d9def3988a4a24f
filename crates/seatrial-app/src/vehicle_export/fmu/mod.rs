//! A Functional Mock-up Unit of FMI 3.0: the equations of the vehicle in C, in a container that simulators import.

mod binary;
mod description;
mod zip;

use seatrial_sim::IdentifiedVehicle;

use super::program::{self, identifier};
use crate::Error;

/// An FMU for co-simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Fmu {
    /// The file.
    pub bytes: Vec<u8>,
    /// Why it holds no binary for this machine, only the source code; absent where it does.
    pub without_binary: Option<String>,
}

impl Fmu {
    /// The unit of a vehicle: its description, source code and vehicle file, and a binary where a C compiler is here (`CC`, else `cc`).
    pub fn of(vehicle: &IdentifiedVehicle) -> Result<Self, Error> {
        let model = identifier(&vehicle.name);
        let source = program::fmu(vehicle);
        // The token follows from the code.
        let token = format!("{model}-{:08x}", crc32fast::hash(source.as_bytes()));
        let source = source.replace("@TOKEN@", &token);
        let vehicle_file = vehicle
            .to_toml()
            .map_err(|error| Error::Input(format!("{}: {error}", vehicle.name)))?;
        let mut archive = zip::Archive::default();
        let mut add = |path: &str, content: &[u8]| {
            let too_large = Error::Input(format!("{}: {path} is too large", vehicle.name));
            archive.add(path, content).ok_or(too_large)
        };
        let model_description = description::model(vehicle, &model, &token);
        add("modelDescription.xml", model_description.as_bytes())?;
        let build_description = description::build(&model);
        add("sources/buildDescription.xml", build_description.as_bytes())?;
        add("sources/vehicle.c", source.as_bytes())?;
        add("resources/vehicle.toml", vehicle_file.as_bytes())?;
        let without_binary = match binary::compiled(&source, &model) {
            Ok(binary) => {
                add(&binary.path, &binary.bytes)?;
                None
            }
            Err(reason) => Some(reason.to_string()),
        };
        Ok(Self {
            bytes: archive.finish(),
            without_binary,
        })
    }
}

//! A Functional Mock-up Unit of FMI 3.0: the equations of the vehicle in C, in a container that simulators import.

mod binary;
mod description;

use std::io::{Cursor, Write};

use seatrial_sim::IdentifiedVehicle;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

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
        let refused =
            |error: zip::result::ZipError| Error::Input(format!("{}: {error}", vehicle.name));
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        // Without a date: the same vehicle gives the same file.
        let stored = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default());
        let mut add = |path: &str, content: &[u8]| {
            archive.start_file(path, stored).map_err(refused)?;
            archive.write_all(content).map_err(|error| refused(error.into()))
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
        let bytes = archive.finish().map_err(refused)?.into_inner();
        Ok(Self { bytes, without_binary })
    }
}

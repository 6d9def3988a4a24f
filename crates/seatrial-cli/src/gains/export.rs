//! `gains --export`: gains and limits as files that controllers read.

use seatrial::gains::export::VehicleType;
use seatrial_app::gains_export::{Format, GainsFile};
use seatrial_app::models::Models;

use super::Args;
use crate::output::{Failure, Output, say};

/// The values of `--vehicle-type`.
pub const VEHICLE_TYPES: [(VehicleType, &str, &str); 2] = [
    (VehicleType::Surface, "surface", "A boat"),
    (VehicleType::Underwater, "underwater", "An underwater vehicle"),
];

/// Writes the export to its file or on standard output.
pub fn write(format: Format, args: &Args, source: &Models, output: &Output) -> Result<(), Failure> {
    if output.json && args.out.is_none() && !matches!(format, Format::Json) {
        return Err(Failure::usage(
            "--json and an --export that is no JSON: give a file with --out",
        ));
    }
    let wanted = args.wanted();
    let file = GainsFile::new(format, &wanted, source, args.vehicle_type, args.rehearsal)?;
    file.notes.iter().for_each(say);
    let text = file.text;
    match &args.out {
        Some(path) => output.save(path, text),
        None => output.as_text().print(&(), || text),
    }
}

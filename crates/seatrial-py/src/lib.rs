//! The native part of the Python package `seatrial`: arrays in, numbers and JSON documents out. The Python part gives
//! them their types and names.

mod arrays;
mod design;
mod estimator;
mod fleet;
mod identify;
mod logs;
mod models;
mod plan;
mod reading;
mod simulate;

use pyo3::prelude::*;
use seatrial::identification::Reader;
use seatrial::words::shortened;
use seatrial_app::advice::addressed;

/// An exception of the Python part, by its name; it carries the exit code of the command.
fn error(py: Python<'_>, class: &str, message: impl ToString) -> PyErr {
    let raised =
        py.import("seatrial._errors").and_then(|errors| errors.getattr(class)).and_then(|class| {
            class.call1((addressed(&shortened(&message.to_string()), Reader::Python),))
        });
    match raised {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

fn usage(py: Python<'_>, message: impl ToString) -> PyErr {
    error(py, "UsageError", message)
}

/// JSON or the text of a file, and what to warn of.
type Document = (String, Vec<String>);

/// Texts in the words of Python.
fn for_python(texts: &[String]) -> Vec<String> {
    let texts = texts.iter();
    texts.map(|text| addressed(text, Reader::Python)).collect()
}

/// What is told of a document or a file, with its warnings in the words of Python.
fn answer(document: String, warnings: Vec<String>) -> Document {
    (document, for_python(&warnings))
}

/// The exception for what a use case gives no result for.
fn failed(py: Python<'_>, found: &seatrial_app::Error) -> PyErr {
    let class = match found {
        seatrial_app::Error::Setting(_) => "UsageError",
        seatrial_app::Error::Input(_)
        | seatrial_app::Error::Log(_)
        | seatrial_app::Error::Logbook(_) => "InputError",
        seatrial_app::Error::Rejected(_) => "RejectedError",
    };
    error(py, class, found)
}

/// A document as JSON.
fn json(py: Python<'_>, document: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(document).map_err(|found| error(py, "SeatrialError", found))
}

#[pymodule]
mod _native {
    /// The version of the package, and the names of the forms of files.
    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        use seatrial_app::{gains_export::Format, vehicle_export::Form};

        module.add("GAINS_FORMS", super::models::names_of::<Format>())?;
        module.add("VEHICLE_FORMS", super::models::names_of::<Form>())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use super::design::{Schedule, gain, turn};
    #[pymodule_export]
    use super::estimator::Estimator;
    #[pymodule_export]
    use super::fleet::{FleetJournal, fleet, fleet_work};
    #[pymodule_export]
    use super::identify::{identify, identify_log, least_squares, paper_claims, read_log};
    #[pymodule_export]
    use super::logs::{compare, health, inspect, validate};
    #[pymodule_export]
    use super::models::{export_gains, export_vehicle, heading_gains, save, turning_limits};
    #[pymodule_export]
    use super::plan::plan;
    #[pymodule_export]
    use super::simulate::{study, trial};
}

//! Why a vehicle's configuration is refused.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// A vehicle file that cannot be used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The text is not a vehicle.
    #[error("not a vehicle: {0}")]
    Syntax(#[from] toml::de::Error),
    /// The JSON text is not a vehicle.
    #[error("not a vehicle: {0}")]
    Json(#[from] serde_json::Error),
    /// A value is out of range.
    #[error("{field} must be {requirement}, not {found}")]
    Invalid {
        /// The field.
        field: String,
        /// What it has to be.
        requirement: String,
        /// What it is.
        found: String,
    },
    /// Something is not as it has to be.
    #[error("{field} must be {requirement}")]
    Unfit {
        /// The field.
        field: String,
        /// What it has to be.
        requirement: &'static str,
    },
    /// Any of these in a file.
    #[error("{}: {source}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<ConfigError>,
    },
}

pub(crate) fn invalid(
    field: impl Into<String>,
    requirement: impl Into<String>,
    found: impl ToString,
) -> ConfigError {
    ConfigError::Invalid {
        field: field.into(),
        requirement: requirement.into(),
        found: found.to_string(),
    }
}

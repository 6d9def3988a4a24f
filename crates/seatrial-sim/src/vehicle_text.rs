//! The text of a vehicle file.

use std::fs;
use std::path::Path;

use crate::config_error::ConfigError;

/// Is a vehicle's text JSON? Only JSON begins with a brace.
pub(crate) fn is_json(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

/// Reads a vehicle from a file, whose name stands before what is wrong with it.
pub(crate) fn in_file<T>(
    path: &Path,
    read: impl FnOnce(&str) -> Result<T, ConfigError>,
) -> Result<T, ConfigError> {
    let text = fs::read_to_string(path)
        .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    read(text)
        .map_err(|error| ConfigError::InFile { path: path.to_owned(), source: Box::new(error) })
}

//! Recordings as the command line names them: files by their suffix, Foxglove by its address.

use std::path::Path;

use seatrial_app::trials::recording::Format;
use seatrial_logs::RowWriter;

use crate::output::Failure;
#[cfg(feature = "foxglove")]
use crate::output::say;

/// The format of a file by its suffix; the option is named to who gave another.
pub fn format_of(path: &Path, option: &str) -> Result<Format, Failure> {
    Format::of(path).ok_or_else(|| {
        Failure::usage(format!(
            "{option} {}: expected a name that ends in .csv, .parquet or .mcap",
            path.display()
        ))
    })
}

/// Shows rows live to Foxglove at an address, HOST:PORT or a port of this machine alone, and says where.
#[cfg(feature = "foxglove")]
pub fn show(address: &str) -> Result<Box<dyn RowWriter>, Failure> {
    let (host, port) = address.rsplit_once(':').unwrap_or(("127.0.0.1", address));
    let port = port.parse().map_err(|_| {
        Failure::usage(format!(
            "--foxglove {address}: expected a port or HOST:PORT, 127.0.0.1:8765"
        ))
    })?;
    let server = seatrial_logs::FoxgloveServer::start(host, port)
        .map_err(|error| Failure::usage(format!("--foxglove {address}: {error}")))?;
    say(format!("Foxglove may connect to {}", server.url()));
    Ok(Box::new(server))
}

/// Without Foxglove.
#[cfg(not(feature = "foxglove"))]
pub fn show(address: &str) -> Result<Box<dyn RowWriter>, Failure> {
    Err(Failure::usage(format!(
        "--foxglove {address}: this seatrial was built without; build it with --features foxglove"
    )))
}

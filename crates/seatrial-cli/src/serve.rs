//! `seatrial serve`: the dashboard.

#[cfg(feature = "dashboard")]
mod dashboard;
#[cfg(not(feature = "dashboard"))]
mod not_built;

use std::path::PathBuf;

use crate::autopilot::LinkArgs;
#[cfg(feature = "dashboard")]
pub use dashboard::{beside, run};
#[cfg(not(feature = "dashboard"))]
pub use not_built::{beside, run};

/// Serve the dashboard: watch, command and look up trials in a browser, or over its programming interface.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Everybody on this machine may watch and command. On any other address than a loopback one a token is needed: one for \
operators and one for viewers are made and shown once, and kept as hashes beside the logbook. docs/dashboard.md says more.

Ctrl-C aborts a trial that runs, hands the vehicle back and ends. Exit code 0: ended by Ctrl-C; 2: the address cannot be listened on.

Example:
  seatrial serve --listen 127.0.0.1:8042 --logbook seatrial.db")]
pub struct Args {
    /// Address and port; port 0 is any that is free.
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8042")]
    listen: String,
    /// Where everything is kept.
    #[arg(long, value_name = "FILE", default_value = "seatrial.db")]
    logbook: PathBuf,
    /// A vehicle that trials may be run on, beside the simulators: mavlink:udp:HOST:PORT, mavlink:udpout:HOST:PORT,
    /// mavlink:tcp:HOST:PORT, mavlink:serial:DEVICE:BAUD, ros2:FILE.toml or sim:FILE.toml; repeatable.
    #[arg(long = "vehicle", value_name = "VEHICLE")]
    vehicles: Vec<String>,
    /// Largest log that may be opened in the page, MB.
    #[arg(long, value_name = "MB", default_value_t = 256, value_parser = clap::value_parser!(u16).range(1..))]
    largest_log: u16,
    #[command(flatten)]
    access: AccessArgs,
    #[command(flatten)]
    link: LinkArgs,
}

/// Who may use the dashboard.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Access")]
pub struct AccessArgs {
    /// A name that the server goes by, beside localhost and its address, as in boat.local; repeatable.
    #[arg(long = "host", value_name = "NAME")]
    hosts: Vec<String>,
    /// Everybody on this machine needs a token, too.
    #[arg(long)]
    require_token: bool,
    /// Make new tokens; those given before are not known any more.
    #[arg(long)]
    new_tokens: bool,
}

//! `seatrial serve`: the dashboard.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;

use seatrial_app::commission::GainsVehicle;
use seatrial_app::trial_run::TrialVehicle;
use seatrial_dash::{Server, Settings, StartError};
use serde::Serialize;

use crate::autopilot::LinkArgs;
use crate::output::{Exit, Failure, Output, say};
use crate::vehicle;
use seatrial_app::simulated::BUILT_IN;

/// Serve the dashboard: watch, command and look up trials in a browser, or over its programming interface.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Everybody on this machine may watch and command. On any other address than a loopback one a token is needed: one for \
operators and one for viewers are made and shown once, and kept as hashes beside the logbook. docs/dashboard.md says more.

Ctrl-C aborts a trial that runs, hands the vehicle back and ends. Exit code 0: ended so; 2: the address cannot be listened on.

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

#[derive(Serialize)]
struct Served<'a> {
    schema: &'static str,
    url: &'a str,
}

/// Serves until Ctrl-C.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let (interrupt, interrupted) = channel();
    ctrlc::set_handler(move || {
        // Nobody waits any more where the server has ended.
        let _ = interrupt.send(());
    })
    .map_err(Failure::internal)?;
    let names = BUILT_IN.iter().map(|(name, _)| *name);
    let names = names.chain(args.vehicles.iter().map(String::as_str));
    let vehicles = names
        .map(|name| vehicle::named(name, None, &args.link, &args.logbook))
        .collect::<Result<_, _>>()?;
    let settings = Settings {
        upload_limit: usize::from(args.largest_log) * 1_000_000,
        ..args.access.settings(&args.listen, &args.logbook)?
    };
    let autopilots = args
        .vehicles
        .iter()
        .filter(|name| name.starts_with("mavlink:"))
        .map(|name| Ok(Box::new(vehicle::autopilot(name, &args.link, &args.logbook)?) as _))
        .collect::<Result<_, Failure>>()?;
    let server = start(&settings, vehicles, autopilots)?;
    let url = server.url();
    let served = Served {
        schema: "seatrial.served.v1",
        url: &url,
    };
    output.print(&served, || url.clone())?;
    interrupted.recv().map_err(Failure::internal)?;
    server.stop();
    Ok(Exit::Done)
}

impl AccessArgs {
    /// A server at this address with this logbook.
    pub fn settings(&self, listen: &str, logbook: &Path) -> Result<Settings, Failure> {
        Ok(Settings {
            token_needed: self.require_token,
            new_tokens: self.new_tokens,
            hosts: self.hosts.clone(),
            ..Settings::new(address(listen)?, logbook)
        })
    }
}

/// Starts a server and says its tokens where they are new.
pub fn start(
    settings: &Settings,
    vehicles: Vec<Box<dyn TrialVehicle>>,
    autopilots: Vec<Box<dyn GainsVehicle>>,
) -> Result<Server, Failure> {
    let server = Server::start(settings, vehicles, autopilots).map_err(|error| match error {
        StartError::Logbook(error) => error.into(),
        error => Failure::usage(error),
    })?;
    if let Some(tokens) = server.new_tokens() {
        say(format_args!(
            "the tokens are shown only now\n  operator  {}\n  viewer    {}",
            tokens.operator, tokens.viewer
        ));
    }
    Ok(server)
}

fn address(listen: &str) -> Result<SocketAddr, Failure> {
    let expected = "expected ADDRESS:PORT, as in 127.0.0.1:8042 or 0.0.0.0:8042";
    let mut found = listen
        .to_socket_addrs()
        .map_err(|error| Failure::usage(format!("--listen {listen}: {error}; {expected}")))?;
    found
        .next()
        .ok_or_else(|| Failure::usage(format!("--listen {listen}: {expected}")))
}

//! `seatrial serve`: the dashboard.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;

use seatrial::Campaign;
use seatrial::preview::{self, Preview};
use seatrial_app::conduct::{Conducted, Watch, conduct};
use seatrial_app::identify_log::{Options, identify_opened};
use seatrial_app::inspect_log::Inspection;
use seatrial_app::logs::{self, Unobserved};
use seatrial_core::{Plan, Vehicle};
use seatrial_dash::api::{self, LogReading};
use seatrial_dash::{Craft, ReadLog, Server, Settings, StartError, Take, Workshop};
use seatrial_sim::FaultyVehicle;
use serde::Serialize;

use crate::autopilot::{LinkArgs, Taken};
use crate::log::{ChannelArgs, quantity_and_unit};
use crate::output::{Exit, Failure, Output, say};
use crate::{prior, vehicle};

/// The simulators that need no file.
const BUILT_IN: [(&str, &str); 3] = [
    ("sim:starfish", "the paper's vehicle, first order in yaw"),
    (
        "sim:starfish-6dof",
        "the paper's vehicle in six degrees of freedom",
    ),
    ("sim:remus100", "REMUS 100 in six degrees of freedom"),
];

/// Serve the dashboard: watch, command and look up trials in a browser, or over its programming interface.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Everybody on this machine may watch and command. On any other address than a loopback one a token is needed: one for
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
    /// mavlink:tcp:HOST:PORT, mavlink:serial:DEVICE:BAUD or sim:FILE.toml; repeatable.
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
    let yard = Yard {
        vehicles: args.vehicles.clone(),
        link: args.link.clone(),
        logbook: args.logbook.clone(),
    };
    for name in &args.vehicles {
        yard.check(name)?;
    }
    let settings = Settings {
        upload_limit: usize::from(args.largest_log) * 1_000_000,
        ..args.access.settings(&args.listen, &args.logbook)?
    };
    let server = start(&settings, yard)?;
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
pub fn start(settings: &Settings, yard: Yard) -> Result<Server, Failure> {
    let server = Server::start(settings, yard).map_err(|error| match error {
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

/// Vehicles and logs as the command line knows them.
pub struct Yard {
    /// Vehicles beside the built-in simulators.
    pub vehicles: Vec<String>,
    /// How autopilots are reached.
    pub link: LinkArgs,
    /// What an autopilot had before a trial is kept beside it.
    pub logbook: PathBuf,
}

impl Yard {
    fn check(&self, name: &str) -> Result<(), Failure> {
        match name.strip_prefix("mavlink:") {
            Some(address) => LinkArgs::check_address(address),
            None => vehicle::config(name).map(drop),
        }
    }
}

impl Workshop for Yard {
    fn vehicles(&self) -> Vec<api::VehicleForm> {
        let built_in = BUILT_IN.iter().map(|(name, description)| api::VehicleForm {
            name: (*name).into(),
            description: (*description).into(),
            is_simulated: true,
        });
        let named = self.vehicles.iter().map(|name| {
            let is_simulated = !name.starts_with("mavlink:");
            let description = if is_simulated {
                "a vehicle file"
            } else {
                "an autopilot that speaks MAVLink: it moves"
            };
            api::VehicleForm {
                name: name.clone(),
                description: description.into(),
                is_simulated,
            }
        });
        built_in.chain(named).collect()
    }

    fn preview(&self, vehicle: &str, plan: &Plan<f64>) -> Result<Preview, String> {
        if vehicle.starts_with("mavlink:") {
            return Err(format!(
                "{vehicle}: how it steers is not known before its trial; preview the plan on a simulator"
            ));
        }
        let named = prior::of_vehicle(vehicle, plan).map_err(|failure| failure.to_string())?;
        preview::preview(plan, &named.prior).map_err(|error| error.to_string())
    }

    fn preflight(&self, vehicle: &str, plan: &Plan<f64>) -> Result<api::Preflight, String> {
        let check = |name: &str, passed, text| api::Check {
            name: String::from(name),
            passed,
            text,
        };
        let Some(address) = vehicle.strip_prefix("mavlink:") else {
            let made = vehicle::config(vehicle).and_then(|_| vehicle::simulated(vehicle, 1));
            let found =
                made.map_or_else(|e| (false, e.to_string()), |_| (true, "simulated".into()));
            return Ok(api::Preflight {
                ready: found.0,
                checks: vec![check("vehicle", found.0, found.1)],
                changes: Vec::new(),
            });
        };
        let mut autopilot = self
            .link
            .open(address, Some(plan), true, &Arc::default())
            .map_err(|failure| failure.to_string())?;
        let found = autopilot.inspect();
        Ok(api::Preflight {
            ready: found.is_passed(),
            checks: found
                .checks
                .into_iter()
                .map(|found| check(found.name, found.passed, found.text))
                .collect(),
            changes: found
                .changes
                .into_iter()
                .map(|change| api::Change {
                    name: change.name,
                    from: change.from,
                    to: change.to,
                    why: change.why.into(),
                })
                .collect(),
        })
    }

    fn take(&self, order: &Take) -> Result<Box<dyn Craft>, String> {
        let Take {
            vehicle,
            plan,
            stop,
            ..
        } = order;
        let taken: Result<Box<dyn Craft>, Failure> = match vehicle.strip_prefix("mavlink:") {
            Some(address) => {
                let backup = self.logbook.with_extension("restore.toml");
                self.link
                    .take(address, plan, order.plan_is_given, true, &backup, stop)
                    .map(|taken| Box::new(taken) as Box<dyn Craft>)
            }
            None => vehicle::rehearsed(vehicle, None, order.seed)
                .map(|simulated| Box::new(Simulator(simulated)) as Box<dyn Craft>),
        };
        taken.map_err(|failure| failure.to_string())
    }

    fn identify(&self, log: &Path, reading: &LogReading) -> Result<ReadLog, String> {
        identified(log, reading).map_err(|failure| said_of(log, reading, &failure))
    }

    fn inspect(&self, log: &Path, reading: &LogReading) -> Result<ReadLog, String> {
        inspected(log, reading).map_err(|failure| said_of(log, reading, &failure))
    }
}

/// A failure with the log by its name, not by that of the file that it was put into.
fn said_of(log: &Path, reading: &LogReading, failure: &Failure) -> String {
    let said = failure.to_string();
    said.replace(&*log.to_string_lossy(), reading.name())
}

struct Simulator(FaultyVehicle<vehicle::Simulated>);

impl Craft for Simulator {
    fn conduct(
        &mut self,
        plan: Plan<f64>,
        about: Campaign,
        watch: &mut dyn Watch,
    ) -> Result<Conducted<String>, String> {
        conducted(&mut self.0, plan, about, watch)
    }

    fn hand_back(&mut self) -> Option<String> {
        None
    }
}

impl Craft for Taken {
    fn conduct(
        &mut self,
        plan: Plan<f64>,
        about: Campaign,
        watch: &mut dyn Watch,
    ) -> Result<Conducted<String>, String> {
        conducted(&mut self.autopilot, plan, about, watch)
    }

    fn hand_back(&mut self) -> Option<String> {
        self.hand_back()
    }
}

fn conducted<V: Vehicle<f64>>(
    vehicle: &mut V,
    plan: Plan<f64>,
    about: Campaign,
    watch: &mut dyn Watch,
) -> Result<Conducted<String>, String>
where
    V::Error: std::fmt::Display,
{
    let conducted =
        conduct(vehicle, plan, about, watch).map_err(|error| format!("the plan: {error}"))?;
    Ok(Conducted {
        campaign: conducted.campaign,
        fault: conducted.fault.map(|fault| fault.to_string()),
    })
}

/// The options that were asked for over the network.
fn channels(reading: &LogReading) -> Result<ChannelArgs, Failure> {
    let reading = reading.clone();
    let units = reading.units.unwrap_or_default();
    let units = units.split(',').filter(|unit| !unit.trim().is_empty());
    Ok(ChannelArgs {
        time: reading.time,
        heading: reading.heading,
        rudder: reading.rudder,
        speed: reading.speed,
        depth: reading.depth,
        altitude: None,
        roll: reading.roll,
        pitch: reading.pitch,
        yaw_rate: reading.yaw_rate,
        north: reading.north,
        east: reading.east,
        thrust: reading.thrust,
        mapping: None,
        units: units
            .map(|unit| quantity_and_unit(unit.trim()))
            .collect::<Result<_, _>>()
            .map_err(|why| Failure::usage(format!("units: {why}")))?,
        rudder_trim: reading.rudder_trim_us,
        rudder_range_deg: reading.rudder_range_deg,
        rudder_delay: reading.rudder_delay_s.unwrap_or(0.0),
        rudder_lag: reading.rudder_lag_s.unwrap_or(0.0),
        drop_invalid: reading.drop_invalid.unwrap_or(false),
    })
}

/// What `seatrial identify` makes of an uploaded log, which goes by the name that it was given.
fn identified(log: &Path, reading: &LogReading) -> Result<ReadLog, Failure> {
    let options = Options {
        reading: channels(reading)?.read_settings()?,
        ..Options::default()
    };
    let mut logs = options
        .windows
        .open(log, &options.reading, &mut Unobserved)?;
    logs.log.path = reading.name().into();
    let found = identify_opened(logs, &options, &mut Unobserved)?;
    let validated = found
        .identification()
        .and_then(|found| Some((found.model(), found.validation?.window)));
    Ok(ReadLog {
        document: serde_json::to_value(found.document()).map_err(Failure::internal)?,
        validated,
        record: found.logs.log.record,
    })
}

/// What `seatrial inspect` says of an uploaded log, which goes by the name that it was given.
fn inspected(log: &Path, reading: &LogReading) -> Result<ReadLog, Failure> {
    let settings = channels(reading)?.read_settings()?;
    let mut opened = logs::open(log, &settings, None, &mut Unobserved)?;
    opened.path = reading.name().into();
    Ok(ReadLog {
        document: serde_json::to_value(Inspection::of(&opened)).map_err(Failure::internal)?,
        record: opened.record,
        validated: None,
    })
}

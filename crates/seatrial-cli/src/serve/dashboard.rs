//! The dashboard's server, of this program.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;

use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;
use seatrial_app::trials::commission::GainsVehicle;
use seatrial_app::trials::order::{TrialVehicle, View};
use seatrial_app::trials::simulator::BUILT_IN;
use seatrial_dash::{Server, Settings, StartError};
use serde::Serialize;

use super::{AccessArgs, Args};
use crate::interrupt::on_interrupt;
use crate::output::{Exit, Failure, Output, say, say_laid_out};
use crate::vehicle;

#[derive(Serialize)]
struct DashboardDocument<'a> {
    schema: &'static str,
    url: &'a str,
}

/// Serves until Ctrl-C.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let (interrupt, interrupted) = channel();
    on_interrupt(move || {
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
    let served = DashboardDocument { schema: "seatrial.served.v1", url: &url };
    output.print(&served, || url.clone())?;
    interrupted.recv().map_err(Failure::internal)?;
    server.stop();
    Ok(Exit::Done)
}

impl AccessArgs {
    /// A server at this address with this logbook.
    fn settings(&self, listen: &str, logbook: &Path) -> Result<Settings, Failure> {
        Ok(Settings {
            token_needed: self.require_token,
            new_tokens: self.new_tokens,
            hosts: self.hosts.clone(),
            ..Settings::new(address(listen)?, logbook)
        })
    }
}

/// Starts a server and says its tokens where they are new.
fn start(
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
    if let Some(code) = server.code() {
        say_laid_out(&way_in(server.network_url().as_deref(), code));
    }
    Ok(server)
}

/// How a phone in the network gets in.
fn way_in(url: Option<&str>, code: &str) -> String {
    let place = url.unwrap_or("the address of this machine in its network, which is not known");
    let picture = url.map_or(String::new(), qr_code);
    format!(
        "{picture}On a phone or another computer in the network open\n  {place}\nand give the code {code} where a token is asked for. Until this server ends\nwhoever has the code commands."
    )
}

/// A QR code of half blocks, two rows to a line: its light parts are filled, as a terminal writes light on dark.
fn qr_code(url: &str) -> String {
    let Ok(code) = QrCode::new(url) else {
        return String::new();
    };
    code.render::<Dense1x2>().dark_color(Dense1x2::Light).light_color(Dense1x2::Dark).build() + "\n"
}

/// A dashboard that goes with a trial.
pub struct Beside(Server);

impl Beside {
    /// Ends it.
    pub fn stop(self) {
        self.0.stop();
    }
}

/// A dashboard at this address for a trial that ends where `stop` says so, and the trial as it shows it.
pub fn beside(
    listen: &str,
    access: &AccessArgs,
    logbook: &Path,
    stop: &Arc<AtomicBool>,
) -> Result<(Beside, Box<dyn View>), Failure> {
    let settings = access.settings(listen, logbook)?;
    let server = start(&settings, Vec::new(), Vec::new())?;
    let shown = server.attach(stop);
    let shown = shown.ok_or_else(|| Failure::internal("a new dashboard shows a trial"))?;
    say(format_args!("the dashboard is at {}", server.url()));
    Ok((Beside(server), Box::new(shown)))
}

fn address(listen: &str) -> Result<SocketAddr, Failure> {
    let expected = "expected ADDRESS:PORT, as in 127.0.0.1:8042 or 0.0.0.0:8042";
    let mut found = listen
        .to_socket_addrs()
        .map_err(|error| Failure::usage(format!("--listen {listen}: {error}; {expected}")))?;
    found.next().ok_or_else(|| Failure::usage(format!("--listen {listen}: {expected}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_phone_is_told_address_and_code_and_gets_a_picture() {
        let said = way_in(Some("http://192.168.1.20:8042/"), "7K3M-Q0XV");
        assert!(said.contains("http://192.168.1.20:8042/") && said.contains("7K3M-Q0XV"));
        // Version 2 has 25 modules and a margin of four on each side.
        let picture: Vec<&str> = said.lines().take_while(|l| !l.contains("phone")).collect();
        assert_eq!(picture.len(), 17, "{said}");
        assert!(picture.iter().all(|line| line.chars().count() == 33), "{said}");
        let unknown = way_in(None, "7K3M-Q0XV");
        assert!(unknown.contains("not known") && !unknown.contains('\u{2588}'));
    }
}

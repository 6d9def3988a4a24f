//! `seatrial sim mavlink`: a simulated vehicle that speaks MAVLink.

use seatrial_app::simulated;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use seatrial_links::autopilot::{Profile, Speaker};
use serde::Serialize;

use crate::autopilot::{parse_profile, signing};
use crate::output::{Exit, Failure, Output, say};

/// Play a vehicle that speaks MAVLink as ArduPilot's Rover, ArduSub or PX4 do, which holds its heading until somebody takes it.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Example, in two terminals:
  seatrial sim mavlink --seconds 300
  seatrial plan --out plan.toml && seatrial trial --vehicle mavlink:udp:127.0.0.1:14550 --full-rudder-deg 14.9 --plan plan.toml --yes")]
pub struct Args {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Kind of autopilot: rover, sub or px4, whose rudder is output 1.
    #[arg(long, value_name = "KIND", default_value = "rover", value_parser = parse_profile)]
    profile: Profile,
    /// Seed of noise and disturbance.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Send to a ground station that listens there.
    #[arg(
        long,
        value_name = "HOST:PORT",
        default_value = "127.0.0.1:14550",
        conflicts_with = "tcp"
    )]
    udp: String,
    /// Listen there for a ground station instead.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// How much faster than a real vehicle.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    speed: f64,
    /// Stop after this time of the vehicle, s.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Sign every frame with this key and take none without a signature.
    #[arg(long, value_name = "FILE")]
    signing_key: Option<PathBuf>,
}

#[derive(Serialize)]
struct Played {
    schema: &'static str,
    vehicle: String,
    steps: u64,
    seconds: f64,
}

enum Station {
    Udp(UdpSocket),
    Tcp(TcpListener, Option<TcpStream>),
}

impl Station {
    fn open(args: &Args) -> std::io::Result<Self> {
        match &args.tcp {
            Some(place) => {
                let listener = TcpListener::bind(place)?;
                listener.set_nonblocking(true)?;
                Ok(Self::Tcp(listener, None))
            }
            None => {
                let is_loopback = ["127.", "localhost:", "[::1]"]
                    .iter()
                    .any(|p| args.udp.starts_with(p));
                let any = if is_loopback {
                    "127.0.0.1:0"
                } else {
                    "0.0.0.0:0"
                };
                let socket = UdpSocket::bind(any)?;
                socket.connect(&args.udp)?;
                Ok(Self::Udp(socket))
            }
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        match self {
            // A station that is not there yet, or gone, does not stop the vehicle.
            Self::Udp(socket) => drop(socket.send(bytes)),
            Self::Tcp(_, stream) => {
                if stream.as_mut().is_some_and(|s| s.write_all(bytes).is_err()) {
                    *stream = None;
                }
            }
        }
    }

    /// What has come, after waiting this long at most.
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> usize {
        let timeout = timeout.max(Duration::from_micros(100));
        let received = match self {
            Self::Udp(socket) => socket
                .set_read_timeout(Some(timeout))
                .and_then(|()| socket.recv(buffer)),
            Self::Tcp(_, Some(stream)) => stream
                .set_read_timeout(Some(timeout))
                .and_then(|()| stream.read(buffer))
                .and_then(|length| match length {
                    0 => Err(ErrorKind::ConnectionReset.into()),
                    length => Ok(length),
                }),
            Self::Tcp(listener, stream) => {
                std::thread::sleep(timeout.min(Duration::from_millis(5)));
                if let Ok((accepted, _)) = listener.accept()
                    && accepted.set_nonblocking(false).is_ok()
                    && accepted.set_nodelay(true).is_ok()
                {
                    *stream = Some(accepted);
                }
                return 0;
            }
        };
        match received {
            Ok(length) => length,
            Err(error) => {
                let is_passing =
                    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
                match self {
                    Self::Tcp(_, stream) if !is_passing => *stream = None,
                    _ if !is_passing => std::thread::sleep(timeout),
                    _ => {}
                }
                0
            }
        }
    }
}

/// Plays the vehicle until it is stopped.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if !(args.speed > 0.0 && args.speed <= 1000.0) {
        return Err(Failure::usage(
            "--speed: expected a number above 0, at most 1000",
        ));
    }
    if args.profile == Profile::Generic {
        return Err(Failure::usage("--profile: expected rover, sub or px4"));
    }
    let config = simulated::config(&args.vehicle)?;
    let helm = config.helm();
    let interval_s = helm.timing.sample_interval_s;
    let simulated = simulated::vehicle(&args.vehicle, args.seed)?;
    let signing = signing(args.signing_key.as_deref(), 1)?;
    let mut speaker = Speaker::new(
        simulated,
        args.profile,
        interval_s,
        helm.rudder_limit_rad,
        signing,
    );
    let mut station = Station::open(args).map_err(|error| {
        let place = args.tcp.as_ref().unwrap_or(&args.udp);
        Failure::input(format!("{place}: {error}"))
    })?;
    say(format!(
        "full rudder is {:.1} degrees; --full-rudder-deg of the trial must say so",
        helm.rudder_limit_rad.to_degrees()
    ));
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
        .map_err(Failure::internal)?;
    let start = Instant::now();
    let mut buffer = vec![0; 1 << 16];
    let mut steps = 0_u64;
    let seconds = |steps: u64| steps as f64 * interval_s;
    while !stop.load(Ordering::Relaxed) && args.seconds.is_none_or(|s| seconds(steps) < s) {
        let due = Duration::from_secs_f64(seconds(steps) / args.speed);
        while let Some(left) = due
            .checked_sub(start.elapsed())
            .filter(|left| !left.is_zero())
        {
            let length = station.receive(&mut buffer, left);
            speaker.receive(&buffer[..length]);
        }
        let Ok(sent) = speaker.step();
        let Some(sent) = sent else {
            break;
        };
        station.send(&sent);
        steps += 1;
    }
    let played = Played {
        schema: "seatrial.simulated_mavlink.v1",
        vehicle: args.vehicle.clone(),
        steps,
        seconds: seconds(steps),
    };
    output.print(&played, || {
        format!(
            "{}: {} steps, {:.0} s",
            played.vehicle, played.steps, played.seconds
        )
    })?;
    Ok(Exit::Done)
}

//! Starts and stops serving.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use seatrial_app::trials::{commission::GainsVehicle, order::TrialVehicle};
use seatrial_logbook::Logbook;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{Semaphore, watch};

use crate::access::{Leases, NewTokens, Rates, Tokens, code as short_code, secret};
use crate::background::go_last;
use crate::board::Board;
use crate::connections;
use crate::live::Live;
use crate::routes::router;
use crate::server_state::ServerState;
use crate::slot::{Slot, TrialPlace};
use crate::trials::conductor;
use crate::uploads::Uploads;

/// Requests at a time that may wait for a disk or compute.
const AT_A_TIME: usize = 4;
/// Threads for these, and for uploads and aborts beside them.
const BLOCKING_THREADS: usize = 4 * AT_A_TIME;
/// How long the end of a trial is waited for.
const HANDED_BACK_WITHIN: Duration = Duration::from_secs(60);
/// How long open requests are waited for at the end.
const CLOSING: Duration = Duration::from_secs(2);

/// Where and for whom.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Address; port 0 is any that is free.
    pub listen: SocketAddr,
    /// The logbook; made where there is none.
    pub logbook: PathBuf,
    /// Also this machine's own users need a token. On any other than a loopback address everybody does.
    pub token_needed: bool,
    /// Forget the tokens given before.
    pub new_tokens: bool,
    /// Names that the server goes by, beside `localhost` and its address.
    pub hosts: Vec<String>,
    /// Requests a second from one address, four times as many at once.
    pub requests_per_s: f64,
    /// Largest log that may be uploaded, bytes.
    pub upload_limit: usize,
}

impl Settings {
    /// Loopback, without tokens.
    pub fn new(listen: SocketAddr, logbook: impl Into<PathBuf>) -> Self {
        Self {
            listen,
            logbook: logbook.into(),
            token_needed: false,
            new_tokens: false,
            hosts: Vec::new(),
            requests_per_s: 100.0,
            upload_limit: 256 << 20,
        }
    }
}

/// Addresses by which the way into a network is asked for; nothing is sent there. The first is the way to everywhere, the others are
/// the ways to the networks of routers and boats.
const ELSEWHERE: [[u8; 4]; 4] =
    [[192, 0, 2, 1], [192, 168, 255, 254], [10, 255, 255, 254], [172, 31, 255, 254]];

/// The address that this machine has in its network.
fn own_address() -> Option<IpAddr> {
    ELSEWHERE.into_iter().find_map(|there| {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
        socket.connect((Ipv4Addr::from(there), 9)).ok()?;
        let ip = socket.local_addr().ok()?.ip();
        (!ip.is_unspecified() && !ip.is_loopback()).then_some(ip)
    })
}

/// Why nothing is served.
#[derive(Debug)]
pub enum StartError {
    /// The address cannot be listened on.
    Listen(SocketAddr, std::io::Error),
    /// The logbook cannot be opened for writing.
    Logbook(seatrial_logbook::Error),
    /// The tokens' file cannot be read or written.
    Tokens(PathBuf, std::io::Error),
    /// No folder can be made for logs that are uploaded.
    Uploads(std::io::Error),
    /// No threads, no random numbers.
    System(std::io::Error),
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listen(address, error) => write!(
                f,
                "{address}: {error}; choose another address with --listen, or port 0 for any that is free"
            ),
            Self::Logbook(error) => error.fmt(f),
            Self::Tokens(path, error) => write!(
                f,
                "{}: {error}; expected the hashes of the tokens, --new-tokens makes new ones",
                path.display()
            ),
            Self::Uploads(error) => write!(
                f,
                "{}: {error}; logs that are uploaded are put there, TMPDIR names another folder",
                std::env::temp_dir().display()
            ),
            Self::System(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for StartError {}

/// A server that serves.
pub struct Server {
    address: SocketAddr,
    new_tokens: Option<NewTokens>,
    code: Option<String>,
    shared: Arc<ServerState>,
    thread: Option<JoinHandle<()>>,
}

/// What a server asks for: tokens where they are needed, those that were just made, and on a network its code.
#[derive(Default)]
struct Access {
    tokens: Option<Tokens>,
    new_tokens: Option<NewTokens>,
    code: Option<String>,
}

impl Access {
    fn of(settings: &Settings) -> Result<Self, StartError> {
        let is_loopback = settings.listen.ip().is_loopback();
        if !settings.token_needed && is_loopback {
            return Ok(Self::default());
        }
        let path = settings.logbook.with_extension("tokens.json");
        let (tokens, new_tokens) = Tokens::of_file(&path, settings.new_tokens)
            .map_err(|error| StartError::Tokens(path, error))?;
        let code = match is_loopback {
            true => None,
            false => Some(short_code().map_err(StartError::System)?),
        };
        let tokens = match &code {
            Some(code) => tokens.with_code(code),
            None => tokens,
        };
        Ok(Self { tokens: Some(tokens), new_tokens, code })
    }
}

impl Server {
    /// Begins to serve. Trials may be run on the vehicles, commissions on the autopilots. Campaigns that an earlier, killed server left open are closed as interrupted.
    pub fn start(
        settings: &Settings,
        vehicles: Vec<Box<dyn TrialVehicle>>,
        autopilots: Vec<Box<dyn GainsVehicle>>,
    ) -> Result<Self, StartError> {
        let writer = Logbook::open(&settings.logbook).map_err(StartError::Logbook)?;
        let is_loopback = settings.listen.ip().is_loopback();
        let access = Access::of(settings)?;
        let listen = |error| StartError::Listen(settings.listen, error);
        let listener = TcpListener::bind(settings.listen).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        let shared = Arc::new(ServerState {
            vehicles,
            autopilots,
            logbook: settings.logbook.clone(),
            writer: Mutex::new(writer),
            tokens: access.tokens,
            is_loopback,
            hosts: settings.hosts.clone(),
            rates: Rates::new(settings.requests_per_s),
            leases: Leases::default(),
            live: Live::start(secret().map_err(StartError::System)?),
            viewers: AtomicU32::new(0),
            uploads: Uploads::begin().map_err(StartError::Uploads)?,
            slot: Slot::default(),
            commission: Board::default(),
            lanes: Arc::new(Semaphore::new(AT_A_TIME)),
            conductor: conductor(),
            closing: watch::channel(false).0,
        });
        let runtime = runtime().map_err(StartError::System)?;
        let served = Arc::clone(&shared);
        let upload_limit = settings.upload_limit;
        let thread = std::thread::Builder::new()
            .name("dashboard".into())
            .spawn(move || {
                go_last();
                runtime.block_on(serve(served, listener, upload_limit));
                runtime.shutdown_timeout(CLOSING);
            })
            .map_err(StartError::System)?;
        Ok(Self {
            address,
            new_tokens: access.new_tokens,
            code: access.code,
            shared,
            thread: Some(thread),
        })
    }

    /// Where it serves.
    pub fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// The tokens, where they were just made: they are known only now.
    pub fn new_tokens(&self) -> Option<&NewTokens> {
        self.new_tokens.as_ref()
    }

    /// The code that stands for the operator's token until this server ends, where it listens to a network.
    pub fn code(&self) -> Option<&str> {
        self.code.as_deref()
    }

    /// Where others in the network find it: the address of this machine, where it listens on all of them. `None` on a loopback
    /// address, and where no network is known.
    pub fn network_url(&self) -> Option<String> {
        let ip = self.address.ip();
        let ip = match ip.is_unspecified() {
            true => own_address()?,
            false => ip,
        };
        (!ip.is_loopback()).then(|| format!("http://{}/", SocketAddr::new(ip, self.address.port())))
    }

    /// Shows a trial that the caller conducts, which is to end when the flag is set. `None` where a trial runs already.
    pub fn attach(&self, stop: &Arc<AtomicBool>) -> Option<TrialPlace> {
        self.shared.slot.take(stop, self.shared.live.tap()).ok()
    }

    /// Ends the trial that runs, hands the vehicle back, sends the viewers a goodbye and stops serving.
    pub fn stop(mut self) {
        if let Some((_, stop)) = self.shared.slot.stop() {
            stop.store(true, Ordering::Relaxed);
        }
        let begun = Instant::now();
        while self.shared.slot.is_taken() && begun.elapsed() < HANDED_BACK_WITHIN {
            std::thread::sleep(Duration::from_millis(10));
        }
        self.shared.closing.send_replace(true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// One core is left to the trial. There are two workers at least: an abort must not wait until one has written an answer.
fn runtime() -> std::io::Result<Runtime> {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    Builder::new_multi_thread()
        .worker_threads(cores.saturating_sub(1).clamp(2, 4))
        .max_blocking_threads(BLOCKING_THREADS)
        .on_thread_start(go_last)
        .enable_all()
        .build()
}

async fn serve(shared: Arc<ServerState>, listener: TcpListener, upload_limit: usize) {
    let mut closing = shared.closing.subscribe();
    let viewers = Arc::clone(&shared);
    let router = router(shared, upload_limit);
    let listener = match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => listener,
        Err(error) => {
            eprintln!("seatrial: the dashboard does not serve: {error}");
            return;
        }
    };
    tokio::select! {
        () = connections::serve(listener, router) => {}
        () = viewers.leases.watch(|control| viewers.live.tap().control(control)) => {}
        () = closed(&mut closing) => {}
    }
}

/// Returns at the end, after a moment in which the viewers get their goodbye.
async fn closed(closing: &mut watch::Receiver<bool>) {
    if closing.wait_for(|closing| *closing).await.is_ok() {
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

//! A vehicle on a socket: in step with whoever commands it until the injection, in real time from then on.

use std::net::{SocketAddr, UdpSocket};
use std::process::{Child, ExitStatus};
use std::time::{Duration, Instant};

use seatrial_links::autopilot::{Profile, Speaker};
use seatrial_links::link::{Decoder, Message};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use super::second_station;

pub const INTERVAL_S: f64 = 0.05;
const FULL_RUDDER_RAD: f64 = 0.26;
/// Wall time that a command may take: while there are any, and otherwise.
const COMMANDED: Duration = Duration::from_millis(250);
const ALONE: Duration = Duration::from_millis(5);
/// Without a command for so long, s, nobody commands.
const GAP_S: f64 = 0.3;
/// The preflight's last proof ends at most this long after the first command that follows its silence, s.
const PROVEN_S: f64 = 10.0;
/// Seen for so long after the injection, s.
const AFTERMATH_S: f64 = 2.5;
/// A process that has not ended by then hangs.
const LONGEST: Duration = Duration::from_secs(120);

/// What ends a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    Kill,
    Terminate,
    Interrupt,
    /// Nothing comes any more, and nothing arrives.
    Unplugged,
    /// For 3 s nothing comes and nothing arrives.
    UnpluggedForAWhile,
    /// The vehicle does not hear.
    Deaf,
    /// The vehicle is not heard.
    Mute,
    Mode,
    Stick,
    Battery,
    Disarmed,
    Restarted,
    SecondStation,
}

impl Injection {
    pub const ALL: [Self; 13] = [
        Self::Kill,
        Self::Terminate,
        Self::Interrupt,
        Self::Unplugged,
        Self::UnpluggedForAWhile,
        Self::Deaf,
        Self::Mute,
        Self::Mode,
        Self::Stick,
        Self::Battery,
        Self::Disarmed,
        Self::Restarted,
        Self::SecondStation,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Kill => "SIGKILL",
            Self::Terminate => "SIGTERM",
            Self::Interrupt => "SIGINT",
            Self::Unplugged => "link lost for good",
            Self::UnpluggedForAWhile => "link lost for 3 s",
            Self::Deaf => "vehicle does not hear",
            Self::Mute => "vehicle is not heard",
            Self::Mode => "pilot changes the mode",
            Self::Stick => "pilot moves a stick",
            Self::Battery => "battery at 5 %",
            Self::Disarmed => "disarmed",
            Self::Restarted => "autopilot starts again",
            Self::SecondStation => "second ground station",
        }
    }
}

fn speaker() -> Speaker<FirstOrderVehicle> {
    let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
    Speaker::new(vehicle, Profile::Rover, INTERVAL_S, FULL_RUDDER_RAD, None)
}

pub struct Boat {
    speaker: Speaker<FirstOrderVehicle>,
    socket: UdpSocket,
    station: Option<SocketAddr>,
    injection: Injection,
    /// After the first command, s.
    after_s: f64,
    clock_s: f64,
    commanded_s: Option<f64>,
    first_commanded_s: Option<f64>,
    /// When commands came again after the preflight's silence.
    resumed_s: Option<f64>,
    injected_s: Option<f64>,
    /// When the injection could be known to whoever listens.
    seen_s: Option<f64>,
    rudder_s: f64,
    is_reached: bool,
    from_station: Decoder,
    from_boat: Decoder,
}

impl Boat {
    pub fn new(injection: Injection, after_s: f64) -> Self {
        Self {
            speaker: speaker(),
            socket: UdpSocket::bind("127.0.0.1:0").unwrap(),
            station: None,
            injection,
            after_s,
            clock_s: 0.0,
            commanded_s: None,
            first_commanded_s: None,
            resumed_s: None,
            injected_s: None,
            seen_s: None,
            rudder_s: 0.0,
            is_reached: false,
            from_station: Decoder::default(),
            from_boat: Decoder::default(),
        }
    }

    pub fn address(&self) -> String {
        format!("mavlink:udpout:{}", self.socket.local_addr().unwrap())
    }

    /// Ends what cuts it off.
    pub fn be_reached(&mut self) {
        self.is_reached = true;
        self.station = None;
    }

    /// How long it was steered after the injection could be known, s.
    pub fn held_s(&self) -> f64 {
        let seen_s = self.seen_s.expect("the injection was seen");
        (self.rudder_s - seen_s).max(0.0)
    }

    /// The time of the last sample before the injection, s.
    pub fn sent_before_s(&self) -> f64 {
        self.injected_s.expect("it was injected") - INTERVAL_S
    }

    /// Had the trial begun when it was ended?
    pub fn is_under_way(&self) -> bool {
        let begun_s = self.resumed_s.map(|resumed_s| resumed_s + PROVEN_S);
        begun_s.is_some_and(|begun_s| self.injected_s.is_some_and(|at_s| at_s > begun_s))
    }

    /// Parameters that are not as they were.
    pub fn changed(&self) -> Vec<&'static str> {
        let names = [("RC_OVERRIDE_TIME", 3.0), ("FS_GCS_ENABLE", 0.0)];
        let is_changed = |(name, value): &(&str, f32)| self.speaker.parameter(name) != Some(*value);
        names.into_iter().filter(is_changed).map(|(name, _)| name).collect()
    }

    /// Sails until the process has ended and the aftermath is seen.
    pub fn sail_with(&mut self, process: &mut Child) -> ExitStatus {
        let start = Instant::now();
        let mut ended = None;
        loop {
            self.step(process.id());
            if ended.is_none() {
                ended = process.try_wait().unwrap();
            }
            let is_seen = self.injected_s.is_some_and(|at_s| self.clock_s >= at_s + AFTERMATH_S);
            if let Some(status) = ended.filter(|_| is_seen || self.injected_s.is_none()) {
                return status;
            }
            if start.elapsed() > LONGEST {
                process.kill().unwrap();
                panic!("{:?} after {:.2} s: it hangs", self.injection, self.after_s);
            }
        }
    }

    fn is_cut(&self, to_boat: bool) -> bool {
        let Some(at_s) = self.injected_s.filter(|_| !self.is_reached) else {
            return false;
        };
        match self.injection {
            Injection::Unplugged => true,
            Injection::UnpluggedForAWhile => self.clock_s < at_s + 3.0,
            Injection::Deaf => to_boat,
            Injection::Mute => !to_boat,
            _ => false,
        }
    }

    fn step(&mut self, process: u32) {
        let begin = Instant::now();
        let is_due =
            self.first_commanded_s.is_some_and(|first_s| self.clock_s >= first_s + self.after_s);
        if is_due && self.injected_s.is_none() {
            self.inject(process);
        }
        let bytes = self.speaker.step().unwrap().unwrap();
        self.clock_s += INTERVAL_S;
        if let Some(station) = self.station.filter(|_| !self.is_cut(false)) {
            self.look(&bytes);
            // Nobody may be there any more.
            let _ = self.socket.send_to(&bytes, station);
        }
        let is_commanded = self.commanded_s.is_some_and(|at_s| self.clock_s - at_s < GAP_S);
        let end = begin
            + match self.injected_s {
                Some(_) if !self.is_reached => Duration::from_secs_f64(INTERVAL_S),
                None if is_commanded => COMMANDED,
                _ => ALONE,
            };
        while self.listen(end) {
            let is_answered = self.commanded_s == Some(self.clock_s);
            if self.injected_s.is_none() && is_answered {
                break;
            }
        }
        if self.speaker.is_steered() && self.speaker.steering().abs() > 0.05 {
            self.rudder_s = self.clock_s;
        }
    }

    /// Takes in a datagram; `false`: none has come before `end`.
    fn listen(&mut self, end: Instant) -> bool {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return false;
        }
        self.socket.set_read_timeout(Some(left)).unwrap();
        let mut buffer = [0; 1 << 16];
        let Ok((length, sender)) = self.socket.recv_from(&mut buffer) else {
            return Instant::now() < end;
        };
        if self.is_cut(true) {
            return true;
        }
        self.station = Some(sender);
        self.speaker.receive(&buffer[..length]);
        self.from_station.push(&buffer[..length]);
        while let Some(frame) = self.from_station.next(None, 0.0) {
            if let Some(Message::RcChannelsOverride(_)) = frame.message() {
                let gap_s = self.commanded_s.map_or(0.0, |at_s| self.clock_s - at_s);
                if gap_s > GAP_S && self.resumed_s.is_none() {
                    self.resumed_s = Some(self.clock_s);
                }
                self.commanded_s = Some(self.clock_s);
                self.first_commanded_s.get_or_insert(self.clock_s);
            }
        }
        true
    }

    fn inject(&mut self, process: u32) {
        self.injected_s = Some(self.clock_s);
        match self.injection {
            Injection::Kill => self.signal(process, "KILL"),
            Injection::Terminate => self.signal(process, "TERM"),
            Injection::Interrupt => self.signal(process, "INT"),
            Injection::Mode => self.speaker.mode = 4,
            Injection::Stick => self.speaker.sticks_us[6] = 1900,
            Injection::Battery => self.speaker.battery_percent = 5,
            Injection::Disarmed => self.speaker.is_armed = false,
            Injection::Restarted => self.speaker = speaker(),
            Injection::SecondStation => {
                let frame = second_station::heartbeat();
                self.socket.send_to(&frame, self.station.unwrap()).unwrap();
                self.seen_s = self.injected_s;
            }
            _ => self.seen_s = self.injected_s,
        }
    }

    fn signal(&mut self, process: u32, signal: &str) {
        crate::signal::send(process, signal);
        self.seen_s = self.injected_s;
    }

    /// Does what is sent tell of the injection?
    fn look(&mut self, bytes: &[u8]) {
        self.from_boat.push(bytes);
        while let Some(frame) = self.from_boat.next(None, 0.0) {
            let Some(message) = frame.message() else {
                continue;
            };
            let tells = match (self.injection, message) {
                (Injection::Mode, Message::Heartbeat(beat)) => beat.custom_mode != 0,
                (Injection::Stick, Message::RcChannels(rc)) => rc.pulses[6] == 1900,
                (Injection::Battery, Message::SysStatus(status)) => status.battery_percent == 5,
                (Injection::Disarmed, Message::Heartbeat(beat)) => beat.base_mode & 0x80 == 0,
                (Injection::Restarted, Message::Attitude(_)) => true,
                _ => false,
            };
            if tells && self.injected_s.is_some() && self.seen_s.is_none() {
                self.seen_s = Some(self.clock_s);
            }
        }
    }
}

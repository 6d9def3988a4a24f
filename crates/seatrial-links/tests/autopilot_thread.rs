//! A vehicle whose trial is busy with something else: the link stays alive, and nobody steers for long alone.

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use seatrial_core::{AbortReason, Action, Steering, Vehicle};
use seatrial_links::autopilot::{Autopilot, AutopilotThread, Profile, Settings, Speaker, Stop};
use seatrial_links::link::{Address, Decoder, Message, Transport};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

const INTERVAL: Duration = Duration::from_millis(50);
const FULL_RUDDER_RAD: f64 = 0.26;
/// The trial is away for so long.
const AWAY: Duration = Duration::from_millis(2500);

/// What the vehicle saw since it was last asked.
#[derive(Default)]
struct Seen {
    heartbeat: Option<Instant>,
    longest_gap: Duration,
    /// When its rudder was last deflected.
    deflected: Option<Instant>,
}

/// Sails in a hurry until `is_real_time`, and until `is_over`.
fn sail(socket: &UdpSocket, is_real_time: &AtomicBool, is_over: &AtomicBool, seen: &Mutex<Seen>) {
    let vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1).unwrap();
    let interval_s = INTERVAL.as_secs_f64();
    let mut speaker = Speaker::new(vehicle, Profile::Rover, interval_s, FULL_RUDDER_RAD, None);
    let mut decoder = Decoder::default();
    let mut buffer = [0; 1 << 16];
    while !is_over.load(Ordering::Relaxed) {
        let bytes = speaker.step().unwrap().unwrap();
        // Nobody may be there yet.
        let _ = socket.send(&bytes);
        let hurry = match is_real_time.load(Ordering::Relaxed) {
            true => 1,
            false => 10,
        };
        let end = Instant::now() + INTERVAL / hurry;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            socket.set_read_timeout(Some(left)).unwrap();
            let Ok(length) = socket.recv(&mut buffer) else {
                continue;
            };
            speaker.receive(&buffer[..length]);
            decoder.push(&buffer[..length]);
            while let Some(frame) = decoder.next(None, 0.0) {
                if let Some(Message::Heartbeat(_)) = frame.message() {
                    let mut seen = seen.lock().unwrap();
                    let now = Instant::now();
                    let gap = seen.heartbeat.map_or(Duration::ZERO, |last| now - last);
                    seen.longest_gap = seen.longest_gap.max(gap);
                    seen.heartbeat = Some(now);
                }
            }
        }
        if speaker.is_steered() && speaker.steering().abs() > 0.05 {
            seen.lock().unwrap().deflected = Some(Instant::now());
        }
    }
}

#[test]
fn io_the_link_is_kept_while_the_trial_is_away_but_not_for_ever() {
    let ours = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr();
    let ours = ours.unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(ours).unwrap();
    let wire = Transport::open(&Address::UdpIn(ours.to_string())).unwrap();
    let settings = Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the paper's".into()),
        ..Settings::default()
    };
    let (is_real_time, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    let seen = Arc::new(Mutex::new(Seen::default()));
    std::thread::scope(|scope| {
        scope.spawn(|| sail(&socket, &is_real_time, &is_over, &seen));
        // The vehicle's thread ends also where an assertion fails.
        let over = Over(&is_over);
        let mut tended = AutopilotThread::new(Autopilot::new(wire, settings, None));
        let preflight = tended.autopilot().inspect();
        assert!(preflight.is_passed(), "{:?}", preflight.checks);
        let changes = preflight.changes;
        let checks = tended.autopilot().take_control(&changes, &mut |_| Ok(()));
        assert!(checks.iter().all(|check| check.passed), "{checks:?}");
        is_real_time.store(true, Ordering::Relaxed);

        let sample = tended.next_sample().unwrap().unwrap();
        let ask = |steering| Action { steering, thrust: Some(0.6), outcome: None };
        tended.act(&ask(Steering::HoldHeading(sample.heading_rad))).unwrap();
        *seen.lock().unwrap() = Seen::default();
        std::thread::sleep(AWAY);
        assert_eq!(tended.ended_for(), None, "judging a run takes its time");
        let longest_gap = seen.lock().unwrap().longest_gap;
        assert!(!longest_gap.is_zero(), "several heartbeats");
        // The second.
        assert!(longest_gap <= Duration::from_secs(1), "{longest_gap:?}");
        // Nothing of what was measured meanwhile is lost: 2.5 s of 20 Hz, less what the machine was late.
        for _ in 0..40 {
            assert!(tended.next_sample().unwrap().is_some());
        }

        tended.act(&ask(Steering::Rudder(0.2))).unwrap();
        let begin = Instant::now();
        std::thread::sleep(AWAY);
        let deflected = seen.lock().unwrap().deflected.unwrap() - begin;
        // One second, a sample and what the machine is late.
        assert!(deflected < Duration::from_millis(1300), "{deflected:?}");
        assert_eq!(tended.ended_for(), Some(AbortReason::NotAttended));
        let stop = std::iter::repeat_with(|| tended.next_sample()).find_map(Result::err);
        assert!(matches!(stop, Some(Stop::NotAttended(_))), "{stop:?}");
        let done = tended.autopilot().hand_back();
        assert!(done.is_complete(), "{done:?}");
        drop(over);
    });
}

/// The trial hangs in something else when the operator wants the vehicle back: mode and parameters are put back without it.
#[test]
fn io_a_vehicle_whose_trial_hangs_is_handed_back() {
    let ours = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr();
    let ours = ours.unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(ours).unwrap();
    let wire = Transport::open(&Address::UdpIn(ours.to_string())).unwrap();
    let abort = Arc::new(AtomicBool::new(false));
    let settings = Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        trying_thrust: 0.6,
        envelope: Some("the paper's".into()),
        abort: Arc::clone(&abort),
        ..Settings::default()
    };
    let (is_real_time, is_over) = (AtomicBool::new(false), AtomicBool::new(false));
    let seen = Mutex::new(Seen::default());
    std::thread::scope(|scope| {
        scope.spawn(|| sail(&socket, &is_real_time, &is_over, &seen));
        let over = Over(&is_over);
        let mut tended = AutopilotThread::new(Autopilot::new(wire, settings, None));
        let preflight = tended.autopilot().inspect();
        assert!(preflight.is_passed(), "{:?}", preflight.checks);
        let checks = tended.autopilot().take_control(&preflight.changes, &mut |_| Ok(()));
        assert!(checks.iter().all(|check| check.passed), "{checks:?}");
        is_real_time.store(true, Ordering::Relaxed);
        tended.next_sample().unwrap();
        abort.store(true, Ordering::Relaxed);
        // Half a second of patience, then an undisturbed hand-back; nobody fetches the vehicle meanwhile.
        std::thread::sleep(Duration::from_secs(6));
        let begun = Instant::now();
        let done = tended.autopilot().hand_back();
        assert!(done.is_complete() && !done.restored.is_empty(), "{done:?}");
        // It was done before: releasing alone takes 0.45 s.
        assert!(begun.elapsed() < Duration::from_millis(200));
        drop(over);
    });
}

struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

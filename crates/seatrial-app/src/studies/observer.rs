//! The vehicle as an independent observer sees it.

use std::cell::Cell;
use std::rc::Rc;

use seatrial_core::{AbortReason, Action, Envelope, Sample, Steering, Vehicle};
use seatrial_sim::faults::LinkLost;
use seatrial_sim::{FaultyVehicle, SimulatedVehicle};

use crate::studies::fault_run::Instant;

/// What observer and operator know of each other.
#[derive(Debug, Default)]
pub struct Shared {
    /// The vehicle's own time, s.
    pub time_s: Cell<f64>,
    /// Has the operator asked for the vehicle?
    pub is_asked: Cell<bool>,
}

/// Silences count for no more than this, s: in them nobody can give a command that depends on a sample.
const LONGEST_INTERVAL_S: f64 = 0.2;

/// A vehicle that is watched. It gives no more samples once it has given as many as a trial can need.
pub struct Observer {
    vehicle: FaultyVehicle<SimulatedVehicle>,
    /// For others to look at, and for the operator to ask for the vehicle.
    pub shared: Rc<Shared>,
    most_samples: u64,
    /// Samples given.
    pub samples: u64,
    keeps_instants: bool,
    /// What was true when each sample was given.
    pub instants: Vec<Instant>,
    thrust_given: bool,
    /// Time in which samples came, s; all times below are of this clock.
    attended_s: f64,
    /// When neutral rudder was asked for at the end, s.
    pub neutral_s: Option<f64>,
    /// The last that was asked for.
    pub last: Option<Action<f64>>,
    /// When the link was lost for good, s.
    pub lost_s: Option<f64>,
    /// When a sample came after the operator had asked for the vehicle or taken it over, s.
    asked_s: Option<f64>,
    beyond: Option<(AbortReason, f64)>,
    /// When a heading with a newer time last came, and when a depth did, s.
    heard_s: [f64; 2],
    newest_s: f64,
    digest: u64,
}

impl Observer {
    /// Watches a vehicle.
    pub fn new(
        vehicle: FaultyVehicle<SimulatedVehicle>,
        most_samples: u64,
        keeps_instants: bool,
    ) -> Self {
        Self {
            vehicle,
            shared: Rc::default(),
            most_samples,
            samples: 0,
            keeps_instants,
            instants: Vec::new(),
            thrust_given: false,
            attended_s: 0.0,
            neutral_s: None,
            last: None,
            lost_s: None,
            asked_s: None,
            beyond: None,
            heard_s: [0.0; 2],
            newest_s: f64::NEG_INFINITY,
            // FNV-1a.
            digest: 0xcbf2_9ce4_8422_2325,
        }
    }

    /// A number of all samples and actions: two trials with the same are the same, bit for bit.
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// Did the trial take more samples than any can need?
    pub fn is_endless(&self) -> bool {
        self.samples > self.most_samples
    }

    /// When the condition of an abort came about, s, where this observer can tell.
    pub fn condition_s(&self, reason: AbortReason) -> Option<f64> {
        match reason {
            AbortReason::LinkLost => self.lost_s,
            AbortReason::Operator => self.asked_s,
            AbortReason::StaleSamples => {
                let [heading_s, depth_s] = self.heard_s;
                Some(heading_s.min(depth_s) + Envelope::<f64>::default().stale_after_s)
            }
            _ => self
                .beyond
                .filter(|(beyond, _)| *beyond == reason)
                .map(|(_, s)| s),
        }
    }

    fn digest_number(&mut self, number: f64) {
        for byte in number.to_bits().to_le_bytes() {
            self.digest = (self.digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn look(&mut self, sample: &Sample<f64>) {
        let silence_s = self.vehicle.time_s() - self.shared.time_s.get();
        self.attended_s += silence_s.clamp(0.0, LONGEST_INTERVAL_S);
        let now_s = self.attended_s;
        self.shared.time_s.set(self.vehicle.time_s());
        self.samples += 1;
        self.digest_number(sample.time_s);
        self.digest_number(sample.heading_rad);
        if self.keeps_instants {
            self.instants.push(Instant {
                time_s: sample.time_s,
                upset: *self.vehicle.upset(),
                model: self.vehicle.apparent_yaw_model(),
            });
        }
        if self.vehicle.is_taken_over() || self.shared.is_asked.get() {
            self.asked_s.get_or_insert(now_s);
        }
        if sample.heading_rad.is_finite() && sample.time_s > self.newest_s {
            self.heard_s[0] = now_s;
        }
        if sample.depth_m.is_some() {
            self.heard_s[1] = now_s;
        }
        self.newest_s = self.newest_s.max(sample.time_s);
        let limits = Envelope::<f64>::default();
        let beyond = [
            (
                AbortReason::YawRate,
                sample.yaw_rate_rad_s,
                limits.yaw_rate_max_rad_s,
            ),
            (AbortReason::Depth, sample.depth_m, limits.depth_max_m),
        ];
        let beyond = beyond
            .into_iter()
            .find(|(_, x, limit)| x.is_some_and(|x| x.abs() > *limit));
        if let (None, Some((reason, ..))) = (self.beyond, beyond) {
            self.beyond = Some((reason, now_s));
        }
    }
}

impl Vehicle<f64> for Observer {
    type Error = LinkLost;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, LinkLost> {
        if self.is_endless() {
            return Ok(None);
        }
        let sample = self.vehicle.next_sample();
        match &sample {
            Ok(Some(sample)) => self.look(sample),
            Ok(None) | Err(LinkLost) => {
                self.lost_s.get_or_insert(self.attended_s);
            }
        }
        sample
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), LinkLost> {
        let (Steering::Rudder(angle) | Steering::HoldHeading(angle)) = action.steering;
        self.digest_number(angle);
        self.digest_number(action.thrust.unwrap_or(-1.0));
        match (action.thrust, action.steering) {
            (Some(_), _) => self.thrust_given = true,
            (None, Steering::Rudder(0.0)) if self.thrust_given => {
                self.neutral_s.get_or_insert(self.attended_s);
            }
            _ => {}
        }
        self.last = Some(*action);
        self.vehicle.act(action)
    }

    fn is_taken_over(&self) -> bool {
        self.vehicle.is_taken_over()
    }
}

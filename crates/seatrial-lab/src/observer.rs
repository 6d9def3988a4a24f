//! The vehicle as an independent observer sees it.

use std::cell::Cell;
use std::rc::Rc;

use seatrial_core::{AbortReason, Action, Envelope, Sample, Steering, Vehicle, YawModel};
use seatrial_sim::faults::{LinkLost, Upset};
use seatrial_sim::{FaultyVehicle, SimulatedVehicle};

/// What was true when a sample was delivered.
pub struct Instant {
    /// The sample's time, s.
    pub time_s: f64,
    /// What was wrong.
    pub upset: Upset,
    /// The yaw model that samples show, where the vehicle has one.
    pub model: Option<YawModel<f64>>,
}

/// When something happened.
#[derive(Clone, Copy, Debug, Default)]
pub struct When {
    /// Time in which samples came, s.
    pub attended_s: f64,
    /// On the vehicle's own clock, s.
    pub clock_s: f64,
}

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
    /// Time in which samples came, s.
    attended_s: f64,
    /// When neutral rudder was asked for at the end.
    pub neutral: Option<When>,
    /// When heading hold was asked for after it.
    pub hold: Option<When>,
    /// The last that was asked for.
    pub last: Option<Action<f64>>,
    /// When the link was lost for good.
    lost: Option<When>,
    /// When a sample came after the operator had asked for the vehicle or taken it over.
    asked: Option<When>,
    /// When a sample first was beyond a limit, and which.
    beyond: Option<(AbortReason, When)>,
    /// When a heading with a newer time last came, when a depth did, and when both came in one sample.
    heard: [When; 3],
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
            neutral: None,
            hold: None,
            last: None,
            lost: None,
            asked: None,
            beyond: None,
            heard: Default::default(),
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

    /// The vehicle that is watched.
    pub fn vehicle(&self) -> &FaultyVehicle<SimulatedVehicle> {
        &self.vehicle
    }

    /// When the condition of an abort came about, in s of the attended time, where this observer can tell.
    pub fn condition_s(&self, reason: AbortReason) -> Option<f64> {
        let condition = match reason {
            AbortReason::LinkLost => self.lost,
            AbortReason::Operator => self.asked,
            AbortReason::StaleSamples => {
                let [heading, depth, _] = self.heard;
                let heard_s = heading.attended_s.min(depth.attended_s);
                return Some(heard_s + Envelope::<f64>::default().stale_after_s);
            }
            _ => self.beyond_for(reason),
        };
        condition.map(|when| when.attended_s)
    }

    /// When a sample first was beyond a limit, where that is the reason of an abort.
    pub fn beyond_for(&self, reason: AbortReason) -> Option<When> {
        let beyond = self.beyond.filter(|(beyond, _)| *beyond == reason);
        beyond.map(|(_, when)| when)
    }

    /// When the latest whole sample came.
    pub fn whole(&self) -> When {
        self.heard[2]
    }

    fn now(&self) -> When {
        When { attended_s: self.attended_s, clock_s: self.vehicle.time_s() }
    }

    fn digest_number(&mut self, number: f64) {
        for byte in number.to_bits().to_le_bytes() {
            self.digest = (self.digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn look(&mut self, sample: &Sample<f64>) {
        let silence_s = self.vehicle.time_s() - self.shared.time_s.get();
        self.attended_s += silence_s.clamp(0.0, LONGEST_INTERVAL_S);
        let now = self.now();
        self.shared.time_s.set(now.clock_s);
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
            self.asked.get_or_insert(now);
        }
        let has_heading = sample.heading_rad.is_finite() && sample.time_s > self.newest_s;
        let has_depth = sample.depth_m.is_some();
        let heard = [has_heading, has_depth, has_heading && has_depth];
        for (when, _) in self.heard.iter_mut().zip(heard).filter(|(_, heard)| *heard) {
            *when = now;
        }
        self.newest_s = self.newest_s.max(sample.time_s);
        let limits = Envelope::<f64>::default();
        let beyond = [
            (AbortReason::Pitch, sample.pitch_rad, limits.pitch_max_rad),
            (AbortReason::Roll, sample.roll_rad, limits.roll_max_rad),
            (AbortReason::YawRate, sample.yaw_rate_rad_s, limits.yaw_rate_max_rad_s),
            (AbortReason::Depth, sample.depth_m, limits.depth_max_m),
        ];
        let beyond = beyond.into_iter().find(|(_, x, limit)| x.is_some_and(|x| x.abs() > *limit));
        if let (None, Some((reason, ..))) = (self.beyond, beyond) {
            self.beyond = Some((reason, now));
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
                let now = self.now();
                self.lost.get_or_insert(now);
            }
        }
        sample
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), LinkLost> {
        let (Steering::Rudder(angle) | Steering::HoldHeading(angle)) = action.steering;
        self.digest_number(angle);
        self.digest_number(action.thrust.unwrap_or(-1.0));
        let now = self.now();
        match (action.thrust, action.steering) {
            (Some(_), _) => self.thrust_given = true,
            (None, Steering::Rudder(0.0)) if self.thrust_given => {
                self.neutral.get_or_insert(now);
            }
            (None, Steering::HoldHeading(_)) if self.neutral.is_some() => {
                self.hold.get_or_insert(now);
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

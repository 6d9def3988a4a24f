//! A vehicle that faults befall.

use std::collections::VecDeque;
use std::convert::Infallible;

use seatrial_core::{Action, Sample, Vehicle, YawModel};
use thiserror::Error;

use super::invalid::InvalidFault;
use super::kind::Kind;
use super::scenario::{Fault, Onset, Scenario, ScenarioError};
use super::stages::{Moment, Stages};
use super::upset::Upset;

/// Instants closer than this are the same, s.
const RESOLUTION_S: f64 = 1e-9;

/// A simulated vehicle that can be upset.
pub trait Rehearsable: Vehicle<f64, Error = Infallible> {
    /// Why a kind of fault cannot be played on it.
    fn refuses(&self, kind: Kind) -> Option<&'static str>;
    /// The kinds of faults that can be played on it.
    fn playable(&self) -> Vec<Kind> {
        let playable = |kind: &Kind| self.refuses(*kind).is_none();
        Kind::ALL.into_iter().filter(playable).collect()
    }
    /// What is wrong with it from now on.
    fn upset(&mut self, upset: &Upset);
    /// The true yaw model as the body is now, where there is one.
    fn yaw_model(&self) -> Option<YawModel<f64>>;
}

/// The link to the vehicle was lost for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the link to the vehicle was lost")]
pub struct LinkLost;

/// A vehicle and the faults that befall it.
///
/// A fault that begins at a time acts on the motion from that time on and on the next reading. Without faults
/// the samples are the vehicle's own, bit for bit.
#[derive(Clone, Debug)]
pub struct FaultyVehicle<V> {
    vehicle: V,
    faults: Vec<ScheduledFault>,
    stages: Stages,
    upset: Upset,
    /// The vehicle's own time, s.
    time_s: f64,
    /// Where the motion up to the latest sample began: its faults are those of then, s.
    from_s: f64,
    /// What is still to be delivered.
    waiting: VecDeque<Sample<f64>>,
    /// A sample that arrives after the next one.
    late: Option<Sample<f64>>,
    /// Samples measured so far.
    measured: u64,
}

#[derive(Clone, Copy, Debug)]
struct ScheduledFault {
    fault: Fault,
    began_s: Option<f64>,
}

impl<V: Rehearsable> FaultyVehicle<V> {
    /// A vehicle and its scenario, `seed` choosing what is left to chance. The error names a fault that the
    /// vehicle cannot play.
    pub fn new(vehicle: V, scenario: &Scenario, seed: u64) -> Result<Self, ScenarioError> {
        let playable = vehicle.playable();
        let random = scenario.random.iter();
        let drawn = random.flat_map(|random| random.faults(&playable, seed));
        let faults: Vec<Fault> = scenario.faults.iter().copied().chain(drawn).collect();
        for (k, fault) in faults.iter().enumerate() {
            if let Some(reason) = vehicle.refuses(fault.kind) {
                return Err(ScenarioError::Fault {
                    number: k + 1,
                    kind: fault.kind.name().into(),
                    problem: InvalidFault::Unplayable(reason),
                });
            }
        }
        Ok(Self {
            vehicle,
            faults: faults
                .into_iter()
                .map(|fault| ScheduledFault { fault, began_s: None })
                .collect(),
            stages: Stages::default(),
            upset: Upset::default(),
            time_s: 0.0,
            from_s: 0.0,
            waiting: VecDeque::new(),
            late: None,
            measured: 0,
        })
    }

    /// The vehicle itself.
    pub fn vehicle(&self) -> &V {
        &self.vehicle
    }

    /// The vehicle's own time, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// What is wrong now.
    pub fn upset(&self) -> &Upset {
        &self.upset
    }

    /// When the first fault began, s.
    pub fn first_fault_s(&self) -> Option<f64> {
        let began = self.faults.iter().filter_map(|f| f.began_s);
        began.min_by(f64::total_cmp)
    }

    /// The yaw model that the samples show, where the vehicle has one.
    pub fn apparent_yaw_model(&self) -> Option<YawModel<f64>> {
        Some(self.upset.apparent(self.vehicle.yaw_model()?))
    }

    /// The faults that last now, with the time since they began, s.
    fn lasting(&self) -> impl Iterator<Item = (&Fault, f64)> {
        self.faults.iter().filter_map(|scheduled| {
            let age_s = self.from_s - scheduled.began_s?;
            let lasts = scheduled.fault.for_s.is_none_or(|for_s| age_s + RESOLUTION_S < for_s);
            lasts.then_some((&scheduled.fault, age_s))
        })
    }

    /// Begins what is due.
    fn begin(&mut self) {
        for scheduled in &mut self.faults {
            if scheduled.began_s.is_none()
                && is_due(scheduled.fault.onset, self.time_s, &self.stages)
            {
                scheduled.began_s = Some(self.time_s);
            }
        }
    }

    /// Where every lasting fault adds its own.
    fn upset_now(&self) -> Upset {
        let mut upset = Upset::default();
        for (fault, age_s) in self.lasting() {
            let [first, second] = fault.values;
            match fault.kind {
                Kind::CompassFreeze => upset.compass_frozen = true,
                Kind::CompassSpike if self.is_spike(age_s, second) => {
                    upset.compass_error_rad += first;
                }
                Kind::CompassStep => upset.compass_error_rad += first,
                Kind::CompassDrift => {
                    upset.compass_error_rad += first * age_s;
                    upset.compass_drift_rad_s += first;
                }
                Kind::CompassDropout => upset.compass_lost = true,
                Kind::DepthLoss => upset.depth_lost = true,
                Kind::RudderJam => upset.rudder_jammed = true,
                Kind::RudderOffset => upset.rudder_offset_rad += first,
                Kind::RudderReversed => upset.rudder_reversed = true,
                Kind::LostFin => {
                    upset.damage.lost_rudder_area =
                        (upset.damage.lost_rudder_area + first).min(1.0);
                }
                Kind::ThrustLoss => upset.thrust_left *= 1.0 - first,
                Kind::PayloadChange => upset.damage.yaw_inertia_factor *= first,
                Kind::CurrentStep => {
                    upset.damage.current_m_s[0] += first;
                    upset.damage.current_m_s[1] += second;
                }
                Kind::OperatorTakeover => upset.is_taken_over = true,
                Kind::CompassSpike
                | Kind::ClockJump
                | Kind::DuplicatedSamples
                | Kind::ReorderedSamples
                | Kind::LinkLoss => {}
            }
        }
        upset
    }

    /// Does the next sample lie on a multiple of `every_s` after the fault began?
    fn is_spike(&self, age_s: f64, every_s: f64) -> bool {
        let interval_s = self.interval_s();
        let phase_s = (age_s + RESOLUTION_S) % every_s.max(interval_s);
        phase_s < interval_s
    }

    /// Mean time between the samples so far, s.
    fn interval_s(&self) -> f64 {
        self.time_s / (self.measured.max(2) - 1) as f64
    }

    /// Takes the next measurement.
    fn measure(&mut self) -> Option<Sample<f64>> {
        self.from_s = self.time_s;
        self.begin();
        let upset = self.upset_now();
        if upset != self.upset {
            self.upset = upset;
            self.vehicle.upset(&upset);
        }
        let Ok(sample) = self.vehicle.next_sample();
        let mut sample = sample?;
        self.time_s = sample.time_s;
        self.measured += 1;
        for (fault, _) in self.lasting() {
            if fault.kind == Kind::ClockJump {
                sample.time_s += fault.values[0];
            }
        }
        if self.upset.depth_lost {
            sample.depth_m = None;
        }
        Some(sample)
    }

    /// Is this the n-th sample of a fault that counts them?
    fn counts(&self, kind: Kind) -> bool {
        self.lasting().any(|(fault, _)| {
            fault.kind == kind && self.measured.is_multiple_of(fault.values[0] as u64)
        })
    }

    /// Lines a sample up for delivery.
    fn deliver(&mut self, sample: Sample<f64>) {
        if self.late.is_none() && self.counts(Kind::ReorderedSamples) {
            self.late = Some(sample);
            return;
        }
        self.waiting.push_back(sample);
        if self.counts(Kind::DuplicatedSamples) {
            self.waiting.push_back(sample);
        }
        self.waiting.extend(self.late.take());
    }

    /// Is the link lost, and for good?
    fn link_lost(&self) -> Option<bool> {
        self.lasting()
            .filter(|(fault, _)| fault.kind == Kind::LinkLoss)
            .map(|(fault, _)| fault.for_s.is_none())
            .reduce(|a, b| a || b)
    }
}

/// Does a fault begin now?
fn is_due(onset: Onset, time_s: f64, stages: &Stages) -> bool {
    match onset {
        Onset::Time(at_s) => time_s + RESOLUTION_S >= at_s,
        Onset::Stage { stage, run, after_s } => {
            stages.now.is_some_and(|(now, since_s): (Moment, f64)| {
                now == stage
                    && stages.times(stage) == run
                    && time_s - since_s + RESOLUTION_S >= after_s
            })
        }
    }
}

impl<V: Rehearsable> Vehicle<f64> for FaultyVehicle<V> {
    type Error = LinkLost;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, LinkLost> {
        loop {
            if let Some(sample) = self.waiting.pop_front() {
                return Ok(Some(sample));
            }
            let Some(sample) = self.measure() else {
                return Ok(None);
            };
            match self.link_lost() {
                Some(true) => return Err(LinkLost),
                Some(false) => {}
                None => self.deliver(sample),
            }
        }
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), LinkLost> {
        self.stages.note(action, self.time_s);
        let Ok(()) = self.vehicle.act(action);
        Ok(())
    }

    fn is_taken_over(&self) -> bool {
        self.upset.is_taken_over
    }
}

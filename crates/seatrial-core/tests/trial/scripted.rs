//! A scripted vehicle and the record of a trial with it.

use seatrial_core::model::YawState;
use seatrial_core::{
    Action, Event, List, Plan, Real, RunResult, Sample, Stage, Steering, Trial, YawModel,
};

/// Time between samples, s.
pub const INTERVAL_S: f64 = 0.05;

/// A noise-free vehicle with one yaw model at every thrust.
pub struct Scripted {
    model: YawModel<f64>,
    state: YawState<f64>,
    rudder_rad: f64,
    /// Clock, s.
    pub time_s: f64,
    /// What the latest action wants.
    pub asked: Option<Steering<f64>>,
}

impl Scripted {
    /// A vehicle on its way, heading nearly south.
    pub fn new(b2_per_s2: f64) -> Self {
        Self {
            model: YawModel::from_theta([-1.07, b2_per_s2, 0.012]),
            state: YawState { heading_rad: 3.1, yaw_rate_rad_s: 0.0 },
            rudder_rad: 0.0,
            time_s: 100.0,
            asked: None,
        }
    }

    /// The vehicle one interval later.
    pub fn next_sample(&mut self) -> Sample<f64> {
        self.state = self.model.advance(self.state, self.rudder_rad, INTERVAL_S);
        self.time_s += INTERVAL_S;
        self.rudder_rad = match self.asked {
            Some(Steering::Rudder(rudder_rad)) => rudder_rad,
            Some(Steering::HoldHeading(heading_rad)) => {
                let error_rad = Real::wrapped(self.state.heading_rad - heading_rad);
                (-0.3 * self.model.b2_per_s2.signum() * error_rad).limited_to(0.2)
            }
            None => 0.0,
        };
        Sample {
            time_s: self.time_s,
            heading_rad: Real::wrapped(self.state.heading_rad),
            rudder_rad: self.rudder_rad,
            surge_speed_m_s: Some(1.6),
            depth_m: Some(2.0),
            altitude_m: Some(8.0),
            roll_rad: Some(0.0),
            pitch_rad: Some(0.0),
            yaw_rate_rad_s: Some(self.state.yaw_rate_rad_s),
            north_m: Some(0.0),
            east_m: Some(0.0),
            thrust: None,
        }
    }
}

/// What a trial did.
pub struct Log {
    /// Every action.
    pub actions: Vec<Action<f64>>,
    /// Every event.
    pub events: Vec<Event<f64>>,
    /// Heading of the last sample that was not spoilt.
    pub last_good_heading_rad: f64,
}

impl Log {
    /// The results of its runs.
    pub fn results(&self) -> Vec<RunResult<f64>> {
        let result = |event: &Event<f64>| match event {
            Event::RunFinished { result, .. } => Some(*result),
            _ => None,
        };
        self.events.iter().filter_map(result).collect()
    }

    /// Times at which a stage began.
    pub fn starts(&self, wanted: Stage) -> Vec<f64> {
        let start = |event: &Event<f64>| match event {
            Event::StageStarted { stage, time_s } if *stage == wanted => Some(*time_s),
            _ => None,
        };
        self.events.iter().filter_map(start).collect()
    }
}

/// Runs a trial to its end and three samples beyond; `script` may spoil each sample.
pub fn run(
    plan: Plan<f64>,
    mut vehicle: Scripted,
    mut script: impl FnMut(&mut Trial<f64>, &mut Sample<f64>),
) -> Log {
    let mut trial = Trial::new(plan).unwrap();
    let mut log = Log { actions: Vec::new(), events: Vec::new(), last_good_heading_rad: f64::NAN };
    let mut beyond = 0;
    while beyond < 3 {
        let mut sample = vehicle.next_sample();
        let intact = sample;
        script(&mut trial, &mut sample);
        if trial.outcome().is_none() && sample == intact {
            log.last_good_heading_rad = sample.heading_rad;
        }
        let action = trial.step(&sample);
        vehicle.asked = Some(action.steering);
        log.actions.push(action);
        while let Some(event) = trial.take_event() {
            log.events.push(event);
        }
        beyond += usize::from(action.outcome.is_some());
        assert!(log.actions.len() < 100_000, "the trial does not end");
    }
    log
}

/// The paper's plan at one thrust.
pub fn one_speed() -> Plan<f64> {
    Plan { thrusts: List::from_slice(&[0.8]).unwrap(), ..Plan::paper() }
}

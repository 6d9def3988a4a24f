//! Commissions on a vehicle that speaks MAVLink, in made-up time: proven gains, wrong models, mishaps in every stage.

mod endings;
mod mishaps;
mod under_water;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use seatrial::gains::commission::NoProposal;
use seatrial_app::models::{ModelPoint, Models};
use seatrial_app::trials::commission::{
    CommissionResult, Control, ControlLoss, Ending, GainsLease, Order, Proposal, conduct, propose,
};
use seatrial_core::{CascadeSettings, Envelope, Sample, SchedulePoint, Vehicle, YawModel};
use seatrial_links::autopilot::{
    Ahead, Autopilot, Backup, HandBack, HeadingControl, Profile, Settings, cascade,
};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use crate::autopilot::sea::{FULL_RUDDER_RAD, INTERVAL_S, Sea, Weather};

/// The speed of the model, m/s.
const THRUST: f64 = 0.8;

fn settings() -> Settings {
    Settings {
        full_rudder_rad: FULL_RUDDER_RAD,
        envelope: Some("the paper's".into()),
        ..Settings::default()
    }
}

/// The true model of the boat at 80 % thrust.
fn truth() -> ModelPoint {
    truth_of(&VehicleConfig::starfish())
}

/// That of another boat.
fn truth_of(config: &VehicleConfig) -> ModelPoint {
    let vehicle = FirstOrderVehicle::new(config.clone(), 1).unwrap();
    let truth = vehicle.truth(THRUST);
    let mut point = Models::given(truth.model, Some(truth.surge_speed_m_s)).points[0];
    point.point.thrust = Some(THRUST);
    point
}

/// The model of a boat with other damping and rudder effect.
fn changed(damping: f64, effect: f64) -> ModelPoint {
    let mut point = truth();
    point.point.model = YawModel {
        a22_per_s: damping * point.point.model.a22_per_s,
        b2_per_s2: effect * point.point.model.b2_per_s2,
        ..point.point.model
    };
    point
}

/// Where a commission is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    OldSteps,
    Writing,
    SmallStep,
    FullSteps,
    HandBack,
    PuttingBack,
}

impl Stage {
    const ALL: [Self; 6] = [
        Self::OldSteps,
        Self::Writing,
        Self::SmallStep,
        Self::FullSteps,
        Self::HandBack,
        Self::PuttingBack,
    ];

    /// The one that begins when this is told.
    fn announced(text: &str) -> Option<Self> {
        let is_steps = text.contains("steps of");
        match text {
            _ if text.starts_with("old gains") && is_steps => Some(Self::OldSteps),
            "writing the new gains" => Some(Self::Writing),
            _ if text.starts_with("new gains, small step") && is_steps => Some(Self::SmallStep),
            _ if text.starts_with("new gains") && is_steps => Some(Self::FullSteps),
            "putting the old gains back" => Some(Self::PuttingBack),
            _ => None,
        }
    }
}

/// A vehicle in its heading mode. What would put it back is kept as a file would keep it.
struct OnSea {
    profile: Profile,
    autopilot: Autopilot<Sea>,
    control: HeadingControl,
    now: CascadeSettings<f64>,
    /// What lies in the restore file.
    restore: Option<Backup>,
    /// What lies in the file that undoes kept gains.
    undo: Option<Backup>,
    handed_back: Option<HandBack>,
    /// When the process is gone, s.
    killed_s: Option<f64>,
    /// When the operator wants the vehicle back, s, and what tells so.
    abort_s: Option<f64>,
    abort: Arc<AtomicBool>,
    /// The stage that has been told, and every one that has begun and when, s.
    stage: Arc<Mutex<Option<Stage>>>,
    begun: Vec<(Stage, f64)>,
}

impl OnSea {
    fn take(sea: Sea) -> Self {
        let profile = sea.profile;
        let settings = settings();
        let abort = Arc::clone(&settings.abort);
        let mut autopilot = Autopilot::new(sea, settings, None);
        let (preflight, control) = autopilot.inspect_heading();
        let failed: Vec<_> = preflight.checks.iter().filter(|c| !c.passed).collect();
        assert!(failed.is_empty(), "{failed:?}");
        let mut restore = None;
        let checks = autopilot.take_heading(&preflight.changes, &mut |backup| {
            restore = Some(backup.clone());
            Ok(())
        });
        assert!(checks.iter().all(|check| check.passed), "{checks:?}");
        let control = control.unwrap();
        Self {
            profile,
            autopilot,
            now: control.settings,
            control,
            restore,
            undo: None,
            handed_back: None,
            killed_s: None,
            abort_s: None,
            abort,
            stage: Arc::default(),
            begun: Vec::new(),
        }
    }

    fn proposal(&self, point: &ModelPoint) -> Proposal {
        self.proposed(point).unwrap()
    }

    fn proposed(&self, point: &ModelPoint) -> Result<Proposal, NoProposal> {
        let control = Control {
            settings: self.control.settings_at(point.point.surge_speed_m_s),
            loop_interval_s: self.control.loop_interval_s,
            sample_interval_s: INTERVAL_S,
            output_scale: self.control.output_scale(point.point.surge_speed_m_s),
            steering_taken: self.control.steering_taken(point.point.thrust),
            keeps_speed: matches!(self.control.ahead, Ahead::Speed { .. }),
            rate_noise_rad_s: self.control.rate_noise_under_way_rad_s(),
        };
        propose(point, FULL_RUDDER_RAD, &control, 30_f64.to_radians())
    }

    fn commission(&mut self, point: &ModelPoint) -> CommissionResult {
        let proposal = self.proposal(point);
        self.carry_out(&proposal)
    }

    fn carry_out(&mut self, proposal: &Proposal) -> CommissionResult {
        let abort = Arc::clone(&self.abort);
        let stage = Arc::clone(&self.stage);
        let order = Order { proposal, envelope: Envelope::default(), stop: &abort };
        conduct(self, &order, &mut |text| {
            if let Some(begun) = Stage::announced(text) {
                *stage.lock().unwrap() = Some(begun);
            }
        })
    }

    /// Takes note of what has been told, and of a process that is gone.
    fn pass(&mut self, begun: Option<Stage>) {
        let now_s = self.autopilot.wire().now_s;
        let announced = self.stage.lock().unwrap().take();
        self.begun.extend(begun.or(announced).map(|stage| (stage, now_s)));
        if self.abort_s.is_some_and(|at_s| now_s >= at_s) {
            self.abort.store(true, Ordering::Relaxed);
        }
        let is_alive = self.killed_s.is_none_or(|at_s| now_s < at_s);
        assert!(is_alive, "the process is gone");
    }

    fn lost(&self, why: String) -> ControlLoss {
        ControlLoss { reason: self.autopilot.ended_for(), why }
    }

    fn gains(&mut self) -> Vec<(&'static str, Option<f32>)> {
        let profile = self.profile;
        let boat = &self.autopilot.wire().boat;
        cascade::names(profile).map(|name| (name, boat.parameter(name))).collect()
    }
}

impl GainsLease for OnSea {
    fn next_sample(&mut self) -> Result<Sample<f64>, ControlLoss> {
        self.pass(None);
        match self.autopilot.next_sample() {
            Ok(Some(sample)) => {
                Ok(Sample { rudder_rad: sample.rudder_rad / FULL_RUDDER_RAD, ..sample })
            }
            Ok(None) => Err(self.lost("not ours".into())),
            Err(stop) => Err(self.lost(stop.to_string())),
        }
    }

    fn steer_to(&mut self, heading_rad: f64, model: &SchedulePoint<f64>) {
        let drive = self.control.drive(model.surge_speed_m_s, model.thrust);
        self.autopilot.steer_to(heading_rad, drive);
    }

    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), ControlLoss> {
        for (name, value) in cascade::writes(&self.now, settings) {
            self.pass(None);
            let is_written = self.autopilot.write_parameter(name, value);
            if let Some(stop) = self.autopilot.stopped() {
                return Err(self.lost(stop.to_string()));
            }
            if !is_written {
                return Err(self.lost(name.into()));
            }
        }
        self.now = *settings;
        Ok(())
    }

    fn keep(&mut self) -> Result<String, ControlLoss> {
        self.undo = Some(self.autopilot.gains_before());
        self.restore = self.autopilot.keep_gains();
        Ok("restore".into())
    }

    fn hand_back(&mut self) -> Option<String> {
        self.pass(Some(Stage::HandBack));
        let done = self.autopilot.hand_back();
        let is_left = done.needs_restoring();
        if !is_left {
            self.restore = None;
        }
        self.handed_back = Some(done);
        is_left.then(|| "left".into())
    }
}

/// The new gains are kept, and do what was foreseen.
fn assert_kept_as_foreseen(found: &CommissionResult) {
    assert!(matches!(found.ending, Ending::Kept { .. }), "{}", found.line());
    let new = found.new.unwrap();
    assert!(new.overshoot <= 0.08, "{new:?}");
    let foreseen = found.new_foreseen.unwrap();
    assert!(new.settling_s.unwrap() < 1.3 * foreseen.settling_s.high, "{new:?} {foreseen:?}");
}

/// What lies in the file that undoes kept gains puts these back.
fn assert_undone(vehicle: &mut OnSea, before: &[(&'static str, Option<f32>)]) {
    let undo = vehicle.undo.clone().unwrap();
    assert!(vehicle.autopilot.restore(&undo).is_complete());
    assert_eq!(vehicle.gains(), before);
}

fn sea(seed: u64) -> Sea {
    Sea::new(VehicleConfig::starfish(), Weather::default(), seed)
}

/// A vehicle under ArduSub, with a gyro that no engine shakes.
fn under_water(seed: u64) -> Sea {
    let mut config = VehicleConfig::starfish();
    config.sensors.gyro.noise_rad_s = 0.002;
    Sea::of(Profile::Sub, config, Weather::default(), seed)
}

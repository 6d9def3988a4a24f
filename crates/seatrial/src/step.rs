//! One step of a trial: the sample, the action that answered it, the estimate after it.

use seatrial_core::{Action, Axis, Sample, Stage, Steering, Trial, YawModel};

/// One sample of a trial, what the trial made of it and what it answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// What the vehicle measured.
    pub sample: Sample<f64>,
    /// The stage of the run. `None` between stages.
    pub stage: Option<Stage>,
    /// What the trial answered.
    pub action: Action<f64>,
    /// The live estimate after this sample. `None` outside training.
    pub estimate: Option<YawModel<f64>>,
}

impl Step {
    /// Takes a sample to a trial. A step is made here both when it is lived and when it is replayed.
    ///
    /// ```
    /// use seatrial::{Sample, Step};
    /// use seatrial_core::{InvalidSetting, Plan, Stage, Trial};
    ///
    /// let mut trial = Trial::new(Plan::paper())?;
    /// let step = Step::take(&mut trial, Sample::default());
    /// // The vehicle settles before there is an estimate.
    /// assert_eq!((step.stage, step.estimate), (Some(Stage::Settle), None));
    /// # Ok::<(), InvalidSetting>(())
    /// ```
    pub fn take(trial: &mut Trial<f64>, sample: Sample<f64>) -> Self {
        let action = trial.step(&sample);
        let stage = trial.status().stage;
        Self {
            sample,
            stage,
            action,
            estimate: (stage == Some(Stage::Train)).then(|| trial.estimator().model()),
        }
    }

    /// The names of [`numbers`](Step::numbers), with their units.
    pub const COLUMNS: [&'static str; 18] = [
        "time_s",
        "heading_rad",
        "rudder_rad",
        "surge_speed_m_s",
        "depth_m",
        "altitude_m",
        "roll_rad",
        "pitch_rad",
        "yaw_rate_rad_s",
        "north_m",
        "east_m",
        "action_rudder_rad",
        "action_heading_rad",
        "action_thrust",
        "estimate_a22_per_s",
        "estimate_b2_per_s2",
        "estimate_c0_rad_per_s2",
        "thrust",
    ];

    /// The names of [`numbers`](Step::numbers) of a trial on this axis: those of pitch say pitch and elevator.
    ///
    /// ```
    /// use seatrial::Step;
    /// use seatrial_core::Axis;
    ///
    /// assert_eq!(
    ///     [Axis::Yaw, Axis::Pitch].map(|axis| Step::columns(axis)[2]),
    ///     ["rudder_rad", "elevator_rad"]
    /// );
    /// ```
    pub fn columns(axis: Axis) -> [&'static str; 18] {
        Self::COLUMNS.map(|column| match (axis, column) {
            (Axis::Pitch, "heading_rad") => "angle_rad",
            (Axis::Pitch, "rudder_rad") => "elevator_rad",
            (Axis::Pitch, "action_rudder_rad") => "action_elevator_rad",
            (Axis::Pitch, "action_heading_rad") => "action_hold_depth_from_angle_rad",
            (_, column) => column,
        })
    }

    /// Every number of the sample, the action and the estimate, in the order of [`COLUMNS`](Step::COLUMNS).
    ///
    /// ```
    /// use seatrial::{Sample, Step};
    /// use seatrial_core::{InvalidSetting, Plan, Trial};
    ///
    /// let mut trial = Trial::new(Plan::paper())?;
    /// let step = Step::take(&mut trial, Sample { heading_rad: 0.3, ..Sample::default() });
    /// let held = Step::COLUMNS.iter().position(|name| *name == "action_heading_rad");
    /// // It is to hold the heading that it has.
    /// assert_eq!(held.and_then(|column| step.numbers()[column]), Some(0.3));
    /// # Ok::<(), InvalidSetting>(())
    /// ```
    pub fn numbers(&self) -> [Option<f64>; 18] {
        let s = &self.sample;
        let (rudder, heading) = match self.action.steering {
            Steering::Rudder(angle) => (Some(angle), None),
            Steering::HoldHeading(angle) => (None, Some(angle)),
        };
        let [a22, b2, c0] = match self.estimate {
            Some(model) => model.theta().map(Some),
            None => [None; 3],
        };
        [
            Some(s.time_s),
            Some(s.heading_rad),
            Some(s.rudder_rad),
            s.surge_speed_m_s,
            s.depth_m,
            s.altitude_m,
            s.roll_rad,
            s.pitch_rad,
            s.yaw_rate_rad_s,
            s.north_m,
            s.east_m,
            rudder,
            heading,
            self.action.thrust,
            a22,
            b2,
            c0,
            s.thrust,
        ]
    }

    /// Are sample, stage, action and estimate the same, bit for bit?
    ///
    /// ```
    /// use seatrial::{Sample, Step};
    /// use seatrial_core::{InvalidSetting, Plan, Trial};
    ///
    /// let mut trial = Trial::new(Plan::paper())?;
    /// let step = Step::take(&mut trial, Sample::default());
    /// // A replay is the same to the last bit, the sign of zero included.
    /// let other = Step { sample: Sample { heading_rad: -0.0, ..step.sample }, ..step };
    /// assert!(step.same_bits(&step) && step == other && !step.same_bits(&other));
    /// # Ok::<(), InvalidSetting>(())
    /// ```
    pub fn same_bits(&self, other: &Self) -> bool {
        let bits = |step: &Self| step.numbers().map(|number| number.map(f64::to_bits));
        bits(self) == bits(other)
            && self.stage == other.stage
            && self.action.outcome == other.action.outcome
    }
}

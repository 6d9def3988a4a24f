//! The topics and services of a vehicle, and what passes through them.

/// Something that came from the vehicle or an operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// An attitude.
    Imu(Motion),
    /// An attitude with position and speed.
    Odometry(Motion),
    /// A measured rudder in the units of the description, with its stamp where it has one, s.
    Rudder {
        /// When it was measured.
        stamp_s: Option<f64>,
        /// In units of the description.
        units: f64,
    },
    /// Somebody called [`ABORT_SERVICE`](super::ABORT_SERVICE).
    Abort,
    /// Somebody called [`ENABLE_SERVICE`](super::ENABLE_SERVICE).
    Enable(bool),
    /// The vehicle's own service has answered: has it done as it was asked?
    Answered(bool),
}

/// Where a vehicle is and how it moves, in the axes of its description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Time in the message's header, s.
    pub stamp_s: f64,
    /// Attitude w, x, y, z.
    pub quaternion: [f64; 4],
    /// Turn rate about the body's vertical axis, rad/s.
    pub turn_rate_rad_s: f64,
    /// Position x, y, z, m.
    pub position_m: Option<[f64; 3]>,
    /// Speed along the body's first axis, m/s.
    pub speed_m_s: Option<f64>,
}

/// What is asked of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Rudder, rad.
    pub rudder_rad: f64,
    /// Thrust as a fraction of full.
    pub thrust: f64,
}

/// Subscribers to our commands, and other publishers of commands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GraphPeers {
    /// Topics of commands to which nobody subscribes.
    pub not_heard: Vec<String>,
    /// Topics of commands on which somebody else publishes.
    pub shared: Vec<String>,
    /// Is the vehicle's own service there?
    pub has_enable: bool,
}

/// The state of the trial, for a viewer of diagnostics.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Is the vehicle given back for a reason that nobody chose?
    pub is_error: bool,
    /// In a sentence.
    pub message: String,
    /// Names and values.
    pub values: Vec<(&'static str, String)>,
}

/// The topics and services of a vehicle.
pub trait Graph {
    /// Our clock, s.
    fn now_s(&self) -> f64;
    /// The next that has come, with the time on our clock when it came; waits for it until a time at most.
    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)>;
    /// Publishes a demand.
    fn command(&mut self, demand: Demand);
    /// Calls the vehicle's own service; the answer is [`Heard::Answered`].
    fn enable(&mut self, is_on: bool);
    /// Subscribers to our commands, other publishers of commands, and whether the vehicle's own service is there.
    fn matched(&self) -> GraphPeers;
    /// Publishes a diagnosis.
    fn diagnose(&mut self, diagnosis: &Diagnosis);
}

impl<G: Graph + ?Sized> Graph for Box<G> {
    fn now_s(&self) -> f64 {
        (**self).now_s()
    }
    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)> {
        (**self).receive(until_s)
    }
    fn command(&mut self, demand: Demand) {
        (**self).command(demand);
    }
    fn enable(&mut self, is_on: bool) {
        (**self).enable(is_on);
    }
    fn matched(&self) -> GraphPeers {
        (**self).matched()
    }
    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        (**self).diagnose(diagnosis);
    }
}

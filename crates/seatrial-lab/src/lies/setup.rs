//! Everything that makes a log: the vehicle, the sea, the manoeuvre, the instruments, the file.

use std::f64::consts::PI;

use serde::Serialize;

use super::draw::Draw;

/// Can the lie be seen in the log?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Decidability {
    /// There is no lie: the model should be accepted and right.
    Sound,
    /// The log holds what tells the lie: a model must be right or refused.
    Decidable,
    /// A sound vehicle could have made the same log: an accepted model must carry a note that says so.
    Undecidable,
}

impl Decidability {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Decidable => "decidable",
            Self::Undecidable => "undecidable",
        }
    }
}

/// A kind of log.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// What is wrong with the log, in one sentence.
    pub sentence: &'static str,
    /// Can it be seen?
    pub decidability: Decidability,
    /// Where something is wired wrongly: the quantity whose column is wrong, by the name that options have.
    pub wired: Option<&'static str>,
    /// What it changes of a sound log.
    pub(super) change: fn(&mut Setup, &mut Draw),
}

/// How the rudder is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// To one side and to the other, half a period each.
    Doublet,
    /// To a side until the heading has changed by this angle, rad, then to the other.
    ZigZag(f64),
    /// Angles and durations by chance.
    Random,
}

/// The vehicle in one of the two manoeuvres.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    pub a22_per_s: f64,
    pub b2_per_s2: f64,
    /// Rudder angle that equals the offset, rad: C0 / b2.
    pub delta0_rad: f64,
    /// The rudder stops at this share of the manoeuvre's angle.
    pub stop: Option<f64>,
    /// Speed after a change of thrust in the middle of the manoeuvre, as a share of that before.
    pub speed_change: f64,
}

/// Wave motion of the heading as sines of acceleration.
#[derive(Clone, Copy, Debug)]
pub struct Waves {
    /// Standard deviation of the yaw acceleration as a share of the rudder's effect.
    pub share: f64,
    /// Angular frequency of the peak, rad/s.
    pub frequency_rad_s: f64,
}

/// How the heading gets into the log.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeadingChannel {
    pub late_s: f64,
    pub low_pass_s: f64,
    pub held_s: f64,
    /// Hard iron: amplitude and phase of one sine over the circle, rad.
    pub deviation_rad: [f64; 2],
    /// The course over ground in a current of this speed north and east, m/s, is logged.
    pub course_over_ground: Option<[f64; 2]>,
    /// Resolution in the file's unit.
    pub resolution: f64,
    /// The heading modulo this angle, rad, instead of a turn.
    pub modulo_rad: Option<f64>,
    /// A share of the readings, in blocks, repeats the one before.
    pub stuck_share: f64,
    /// The compass jumps by this angle, rad, in the middle of the training manoeuvre.
    pub jump_rad: f64,
    /// The heading counts to the other side.
    pub mirrored: bool,
    /// No wrap at all for so many turns, then a wrap a turn too late: readings of 355 and 370 deg in one log.
    pub wraps_badly: bool,
    /// A constant copied over the whole channel.
    pub constant: bool,
}

/// How the rudder gets into the log.
#[derive(Clone, Copy, Debug)]
pub struct RudderChannel {
    pub held_s: f64,
    /// Rows by which the channel is late; negative is early.
    pub late_rows: i64,
    /// Factor on the angle.
    pub sense: f64,
    /// Is the fin's own angle logged instead of the command?
    pub measured: bool,
    pub constant: bool,
    /// Half the sum of two thrusters is logged, where half their difference steers.
    pub half_sum: bool,
}

/// How the yaw rate gets into the log.
#[derive(Clone, Copy, Debug)]
pub struct GyroChannel {
    pub noise_rad_s: f64,
    pub late_s: f64,
    /// Factor on the rate in the file's unit.
    pub factor: f64,
    /// The rate is computed from the file's headings and times: a mean over so many differences on either side.
    pub computed: Option<usize>,
}

/// What the clock does.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClockChannel {
    /// Numbers in the file for one second; the row's index where it is 0.
    pub per_second: f64,
    /// The clock at the first row, s.
    pub start_s: f64,
    /// Seconds by which the clock gains in a second.
    pub gains: f64,
    pub rounding_s: f64,
    /// Standard deviation of the stamps, as a share of the interval.
    pub jitter: f64,
    /// A step of the clock in the training manoeuvre, s.
    pub jump_s: f64,
    /// Every so many rows one is written twice.
    pub duplicate_every: usize,
    /// Every so many rows two change places.
    pub swap_every: usize,
    /// Share of the rows that is missing, in blocks.
    pub missing: f64,
}

impl ClockChannel {
    /// Decimals of the numbers in the file.
    pub fn decimals(&self) -> usize {
        match self.per_second {
            0.0 => 0,
            // Of days.
            per_second if per_second < 1e-3 => 9,
            _ => 4,
        }
    }
}

/// A unit as the file has it: the column's name, and numbers in it for one SI unit.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    pub name: &'static str,
    pub per_si: f64,
    pub offset: f64,
}

impl Column {
    pub const fn new(name: &'static str, per_si: f64) -> Self {
        Self { name, per_si, offset: 0.0 }
    }
}

/// Numbers of a full turn in a column of degrees.
pub const DEG: f64 = 180.0 / PI;

/// A log before it is made.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The vehicle in training and in validation.
    pub hulls: [Hull; 2],
    pub speed_m_s: f64,
    pub full_rudder_rad: f64,
    pub servo_lag_s: f64,
    pub dead_band_rad: f64,
    pub backlash_rad: f64,
    /// The first heading, rad.
    pub start_rad: f64,
    pub pattern: Pattern,
    /// Rudder angle in training and in validation, rad.
    pub amplitudes_rad: [f64; 2],
    pub noise_rad: f64,
    /// Yaw acceleration disturbance as a share of the rudder's effect.
    pub disturbance: f64,
    pub waves: Option<Waves>,
    /// Step of yaw acceleration in the middle of training, as a share of the rudder's effect: a current that shears.
    pub current_step: f64,
    /// The training window begins when the vehicle has been turning for a while.
    pub begins_in_turn: bool,
    /// Interval of the controller, s.
    pub control_s: f64,
    /// Rows are so many control intervals apart.
    pub rows_every: usize,
    pub heading: HeadingChannel,
    pub rudder: RudderChannel,
    pub gyro: Option<GyroChannel>,
    pub clock: ClockChannel,
    pub has_speed: bool,
    pub columns: Columns,
}

/// The names and units of the columns.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    pub time: &'static str,
    pub heading: Column,
    pub rudder: Column,
    pub yaw_rate: Column,
}

/// Columns that state degrees.
pub const IN_DEGREES: Columns = Columns {
    time: "time_s",
    heading: Column::new("heading_deg", DEG),
    rudder: Column::new("rudder_deg", DEG),
    yaw_rate: Column::new("yaw_rate_deg_s", DEG),
};

/// Columns that state radians.
pub const IN_RADIANS: Columns = Columns {
    time: "time_s",
    heading: Column::new("heading_rad", 1.0),
    rudder: Column::new("rudder_rad", 1.0),
    yaw_rate: Column::new("yaw_rate_rad_s", 1.0),
};

impl Setup {
    /// A kind's log of a seed.
    pub fn of(kind: &Kind, seed: u64) -> Self {
        let mut draw = Draw::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut setup = Self::sound(&mut draw);
        (kind.change)(&mut setup, &mut draw);
        setup
    }

    /// A vehicle with a time constant of 0.7 to 1.6 s, logged at 20 Hz.
    fn sound(draw: &mut Draw) -> Self {
        let mut setup = Self {
            hulls: [Hull {
                a22_per_s: -1.0,
                b2_per_s2: 1.0,
                delta0_rad: 0.0,
                stop: None,
                speed_change: 1.0,
            }; 2],
            speed_m_s: draw.within(1.2, 2.2),
            full_rudder_rad: 0.0,
            servo_lag_s: 0.0,
            dead_band_rad: 0.0,
            backlash_rad: 0.0,
            start_rad: draw.within(-2.5, 2.5),
            pattern: Pattern::Doublet,
            amplitudes_rad: [0.26, 0.15],
            noise_rad: draw.log_within(0.1, 0.6) / DEG,
            disturbance: draw.log_within(0.003, 0.012),
            waves: None,
            current_step: 0.0,
            begins_in_turn: false,
            control_s: 0.05,
            rows_every: 1,
            heading: HeadingChannel::default(),
            rudder: RudderChannel {
                held_s: 0.0,
                late_rows: 0,
                sense: 1.0,
                measured: false,
                constant: false,
                half_sum: false,
            },
            gyro: None,
            clock: ClockChannel {
                per_second: 1.0,
                start_s: draw.one_of(&[0.0, 12.35, 1834.6]),
                ..ClockChannel::default()
            },
            has_speed: draw.chance(0.7),
            columns: draw.one_of(&[IN_DEGREES, IN_RADIANS]),
        };
        setup.full_rudder_rad = draw.within(0.35, 0.52);
        let time_constant_s = draw.within(0.7, 1.6);
        let delta0_rad = draw.within(-0.03, 0.03);
        setup.with_time_constant(time_constant_s, delta0_rad, draw);
        if draw.chance(0.5) {
            setup.with_gyro(draw);
        }
        setup
    }

    /// Another vehicle: its training doublet turns it by some 30 deg.
    pub fn with_time_constant(&mut self, time_constant_s: f64, delta0_rad: f64, draw: &mut Draw) {
        let turn_rad = draw.within(0.4, 0.7);
        for hull in &mut self.hulls {
            hull.a22_per_s = -1.0 / time_constant_s;
            hull.b2_per_s2 =
                0.5 * turn_rad / (time_constant_s * time_constant_s * self.amplitudes_rad[0]);
            hull.delta0_rad = delta0_rad;
        }
    }

    /// The vehicle's time constant, s.
    pub fn time_constant_s(&self) -> f64 {
        -1.0 / self.hulls[0].a22_per_s
    }

    pub fn with_gyro(&mut self, draw: &mut Draw) {
        self.gyro = Some(GyroChannel {
            noise_rad_s: draw.within(0.1, 0.4) / DEG / self.time_constant_s(),
            late_s: 0.0,
            factor: 1.0,
            computed: None,
        });
    }

    /// Rows at this interval, s; the vehicle is controlled as often as it is logged.
    pub fn with_interval(&mut self, interval_s: f64) {
        self.control_s = interval_s;
        self.rows_every = 1;
    }

    /// Time between rows, s.
    pub fn row_s(&self) -> f64 {
        self.control_s * self.rows_every as f64
    }
}

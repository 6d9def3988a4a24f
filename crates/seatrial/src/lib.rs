//! Identifies how a marine vehicle steers from a log of its heading and its rudder.
//!
//! The result is a first-order yaw model with 95 % intervals, its R^2 on validation data, and a verdict that says whether
//! the model may be used and why. Controller gains and turning limits follow from it. Where the record shows more than a
//! first-order vehicle, such as sway, a lagging rudder or a strong disturbance, the verdict names it and the intervals allow for it.
//!
//! ```
//! use seatrial::identify::{IdentifySettings, ValidationData, identify};
//! use seatrial::{GainAllowance, Record, Sample, Window};
//!
//! // Arrays of a log: time in s, heading in rad, rudder in rad.
//! # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
//! # let mut state = seatrial_core::model::YawState::<f64>::default();
//! # let (mut time_s, mut heading_rad, mut rudder_rad) = (Vec::new(), Vec::new(), Vec::new());
//! # for k in 0..660_u32 {
//! #     let rudder = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
//! #     time_s.push(0.05 * f64::from(k));
//! #     heading_rad.push((1000.0_f64 * state.heading_rad).round() / 1000.0);
//! #     rudder_rad.push(rudder);
//! #     state = vehicle.advance(state, rudder, 0.05);
//! # }
//! let record: Record = (0..time_s.len())
//!     .map(|k| Sample {
//!         time_s: time_s[k],
//!         heading_rad: heading_rad[k],
//!         rudder_rad: rudder_rad[k],
//!         ..Sample::default()
//!     })
//!     .collect();
//!
//! // One doublet of the rudder to train on, the next to validate with.
//! let training = Window { from_s: 0.0, to_s: 16.5 };
//! let validation = ValidationData {
//!     record: &record,
//!     window: Window { from_s: 16.5, to_s: 33.0 },
//! };
//! let found = identify(&record, training, Some(validation), &IdentifySettings::default())?;
//!
//! for reason in &found.verdict.reasons {
//!     println!("{}: {}", reason.kind(), reason.text);
//! }
//! assert!(found.verdict.accepted);
//!
//! let model = found.model();
//! println!("a22 = {} 1/s, b2 = {} 1/s^2", model.a22_per_s, model.b2_per_s2);
//! # assert!((model.a22_per_s / vehicle.a22_per_s - 1.0).abs() < 0.02);
//!
//! // The gain allows for the loop's delays and for the uncertainty of a22.
//! let damping_ratio = std::f64::consts::FRAC_1_SQRT_2;
//! let gain = GainAllowance::of(&found).design(&model, damping_ratio)?;
//! println!("K_p = {}", gain.proportional_gain);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | for | look in |
//! |---|---|
//! | one model from one or several manoeuvres | [`identify`](mod@identify) |
//! | every method on the same record | [`study::compare`](study::compare()) |
//! | what several speeds or turn rates of one hull tell together | [`campaign::speeds`] |
//! | manoeuvres in a long log | [`log::segmentation`] |
//! | what a trial will tell before it is run | [`preview`] |
//! | whether a vehicle has changed since | [`health`] |
//! | gains and limits for an autopilot | [`gains`] |
//!
//! Everything here may need a heap and the whole record. It starts no thread, opens no file and writes no page. What runs on
//! the vehicle is in [`seatrial_core`].
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod campaign;
mod chi_squared;
mod course_change;
mod draw;
mod figures;
mod gain_allowance;
pub mod gains;
pub mod health;
pub mod identification;
pub mod identify;
mod legs;
pub mod likelihood;
mod line;
mod manoeuvre;
pub mod motions;
mod plain_text;
mod plausibility;
pub mod preview;
mod propagation;
mod record;
mod record_series;
mod savitzky_golay;
pub mod sea_trials;
mod segmentation;
mod servo;
mod stated_units;
mod step;
pub mod study;
mod time_scale;

/// What a log says beside its samples, and whether its numbers mean what it says.
pub mod log {
    pub use crate::legs::{LegSplit, split_by_legs};
    pub use crate::manoeuvre::{Manoeuvre, Stroke};
    pub use crate::plausibility::{heading_later_s, leave_out_unsound};
    pub use crate::record::{RudderUnit, duration_s, median_interval_s, rudder_text};
    pub use crate::savitzky_golay::{NoDerivative, SavitzkyGolay};
    pub use crate::servo::{InvalidServo, Servo};
    pub use crate::stated_units::{ColumnUnit, HeadingJumps, Origin, StatedUnits};
    pub use crate::time_scale::{ChosenLambda, LambdaLimit, LambdaReason, TimeScale};

    /// Manoeuvres in a long log.
    pub mod segmentation {
        pub use crate::segmentation::{Kind, Segment, find, find_in_each};
    }
}

/// Numbers and the text of others as people read them.
pub mod words {
    pub use crate::figures::{
        bounds_text, decimals_of, named_columns, r2_text, three_figures, with_decimals, within,
    };
    pub use crate::plain_text::{capitalised, plain, sentence, shortened};
}

pub use campaign::{Campaign, FullRudder, Run};
pub use course_change::{COURSE_CHANGE_RAD, CourseChange};
pub use gain_allowance::GainAllowance;
pub use identification::Identification;
pub use identify::verdict;
pub use record::{Record, Window};
pub use seatrial_core::Sample;
pub use step::Step;

/// The examples of the readme, which are compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

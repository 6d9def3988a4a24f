//! Estimation: everything about steering identification that needs a heap or the whole record.
//! It starts no thread, opens no file and writes no page. The part that runs on the vehicle is [`seatrial_core`].

pub mod campaign;
pub mod campaign_check;
pub mod circle_fit;
pub mod compare;
pub mod difference;
pub mod export;
pub mod field;
pub mod figures;
pub mod gain_allowance;
pub mod heading_step;
pub mod health;
pub mod identification;
pub mod identify;
pub mod legs;
pub mod manoeuvre;
pub mod pitch;
pub mod preview;
pub mod propagation;
pub mod record;
pub mod savitzky_golay;
pub mod segmentation;
pub mod servo;
pub mod step;
pub mod study;
pub mod surge;
pub mod sway_yaw;
pub mod time_scale;

pub use campaign::{Campaign, Run};
pub use gain_allowance::GainAllowance;
pub use identification::Identification;
pub use identify::verdict;
pub use record::{Record, Window};
pub use step::Step;

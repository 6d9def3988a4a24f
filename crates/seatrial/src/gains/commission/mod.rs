//! Gains for the heading controller of an autopilot: proposed from a model, foreseen, measured and judged by heading steps.
//!
//! ```text
//! Evidence -> propose -> CascadeSettings -> foresee -> Foreseen
//! record of steps -> Response (old gains), Response (new gains) -> judge -> keep or put back
//! ```
//!
//! Everything here counts steering in fractions of full, as the autopilot does, so that no angle of the rudder enters.

mod boat;
mod design;
mod evidence;
mod foresee;
mod judge;
mod led;
mod model_check;
mod response;

pub use crate::draw::Draw;
pub use boat::{Boat, StepInstant, StepTest, learning_s};
pub use design::propose;
pub use evidence::{Evidence, NoProposal};
pub use foresee::{Foreseen, Range, foresee};
pub use judge::{Against, JudgedSteps, Judgement, MOST_REPEATS, Stage, judge_repeats};
pub use model_check::{ModelCheck, check_model};
pub use response::{Response, scatter_rad};

//! What a seatrial without a dashboard says of it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial_app::trials::order::View;

use super::{AccessArgs, Args};
use crate::output::{Exit, Failure, Output};

fn refused(asked: &str) -> Failure {
    Failure::usage(format!(
        "{asked}: this seatrial was built without the dashboard; build it with `--features dashboard`"
    ))
}

/// Refuses.
pub fn run(args: &Args, _: &Output) -> Result<Exit, Failure> {
    Err(refused(&format!("serve --listen {}", args.listen)))
}

/// A dashboard that no trial has.
pub enum Beside {}

impl Beside {
    /// Never happens.
    pub fn stop(self) {
        match self {}
    }
}

/// Refuses.
pub fn beside(
    listen: &str,
    _: &AccessArgs,
    _: &Path,
    _: &Arc<AtomicBool>,
) -> Result<(Beside, Box<dyn View>), Failure> {
    Err(refused(&format!("--serve {listen}")))
}

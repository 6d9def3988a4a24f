//! What a person watches while a trial runs: a live view on a terminal, a plain log elsewhere.

use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use seatrial::words::plain;
use seatrial_core::Stage;

use crate::output::say;
use crate::screen::{width_of_stderr, wrapped};
use crate::standard_error;

#[cfg(feature = "live-view")]
mod drawing;
#[cfg_attr(not(feature = "live-view"), path = "live/no_view.rs")]
mod view;

use view::View;

/// Everything that the live view shows at one instant.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Vehicle, run, thrust, attempt.
    pub title: String,
    /// The stage that runs.
    pub stage: Option<Stage>,
    /// Time into the stage, s.
    pub elapsed_s: f64,
    /// Time until the stage ends at the latest, s.
    pub remaining_s: f64,
    /// Time until the trial ends without repeats, s.
    pub left_s: f64,
    /// Heading, rudder, speed and depth.
    pub strips: Vec<Strip>,
    /// a22, b2 and C0.
    pub parameters: [Parameter; 3],
    /// Step norm of the parameters (39).
    pub step_norm: f64,
    /// Its threshold.
    pub threshold: f64,
    /// When convergence was detected, s into training.
    pub converged_s: Option<f64>,
    /// Limit and how much of it is used, 1 is at the limit.
    pub envelope: Vec<(&'static str, f64)>,
}

/// One parameter of the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its symbol.
    pub name: &'static str,
    /// The estimate.
    pub value: f64,
    /// The 95 % interval, where known.
    pub interval: Option<[f64; 2]>,
    /// Its unit.
    pub unit: &'static str,
}

/// A measurement over the last samples.
#[derive(Clone, Debug)]
pub struct Strip {
    /// What it is.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Digits after the point.
    pub decimals: usize,
    /// The vertical axis covers at least this much, so that noise does not look like motion.
    pub least_span: f64,
    /// Times in s and values, oldest first.
    pub points: Vec<(f64, f64)>,
}

/// Time between two drawings.
const REDRAW: Duration = Duration::from_millis(100);

/// A place for the picture of the moment and for lines that stay. Nobody waits until they are seen.
pub struct Live {
    /// Redrawn in place; `None` for lines only.
    screen: Option<Arc<Screen>>,
    /// Time of the last drawing.
    drawn: Option<Instant>,
}

/// The drawing, touched only where standard error is written.
#[derive(Default)]
struct Screen {
    /// `None` until it is begun, where it cannot be drawn, and when it was taken away.
    view: Mutex<Option<View>>,
    /// A picture waits to be drawn.
    is_drawing: AtomicBool,
}

impl Screen {
    fn view(&self) -> MutexGuard<'_, Option<View>> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lines(&self, text: &str) {
        match &mut *self.view() {
            Some(view) => view.lines(text),
            None => {
                let _ = write!(stderr(), "{text}");
            }
        }
    }
}

impl Live {
    /// Lines only.
    pub const LOG: Self = Self { screen: None, drawn: None };

    /// The live view where standard error is a terminal, otherwise the log.
    pub fn start() -> Self {
        let wanted = stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|t| t != "dumb");
        let live = Self { screen: wanted.then(Arc::default), drawn: None };
        live.on_screen(|screen| *screen.view() = View::start());
        live
    }

    fn on_screen(&self, job: impl FnOnce(&Screen) + Send + 'static) {
        if let Some(screen) = self.screen.clone() {
            standard_error::write(move || job(&screen));
        }
    }

    /// Is there a live view to watch?
    pub fn is_watched(&self) -> bool {
        self.screen.is_some()
    }

    /// Is a drawing due? Preparing a picture costs more than asking.
    pub fn due(&self) -> bool {
        let is_free = |screen: &Arc<Screen>| !screen.is_drawing.load(Ordering::Relaxed);
        self.screen.as_ref().is_some_and(is_free)
            && self.drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW)
    }

    /// Draws the picture of the moment. A terminal that went away does not stop a trial.
    pub fn draw(&mut self, picture: Picture) {
        self.drawn = Some(Instant::now());
        if let Some(screen) = &self.screen {
            screen.is_drawing.store(true, Ordering::Relaxed);
        }
        self.on_screen(move |screen| {
            if let Some(view) = &mut *screen.view() {
                view.draw(&picture);
            }
            screen.is_drawing.store(false, Ordering::Relaxed);
        });
    }

    /// Prints a line that stays.
    pub fn line(&mut self, text: &str) {
        let text = wrapped(&plain(text), width_of_stderr().unwrap_or(usize::MAX));
        let screen = self.screen.clone().unwrap_or_default();
        standard_error::write(move || screen.lines(&text));
    }

    /// Takes the live view away, and says where lines were left out.
    pub fn end(&mut self) {
        self.on_screen(|screen| {
            if let Some(mut view) = screen.view().take() {
                view.end();
            }
        });
        let left_out = standard_error::finish();
        if left_out > 0 {
            say(format!(
                "{left_out} lines were left out here: nobody read them in time; the logbook has all"
            ));
        }
    }
}

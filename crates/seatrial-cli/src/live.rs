//! What a person watches while a trial runs: a live view on a terminal, a plain log elsewhere.

use std::io::{IsTerminal, Stderr, Write, stderr};
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::style::Style;
use ratatui::{Terminal, TerminalOptions, Viewport};
use seatrial::plain_text::plain;
use seatrial_core::Stage;

use crate::screen::{width_of_stderr, wrapped};

use drawing::render;

mod drawing;

/// Rows above the live view, where the lines that stay are seen.
const ROWS_ABOVE: u16 = 2;
/// Fewest rows of the live view.
const FEWEST_ROWS: u16 = 9;
/// Rows of the live view on a terminal that does not tell its size.
const USUAL_ROWS: u16 = 22;

/// Time between two drawings.
const REDRAW: Duration = Duration::from_millis(100);

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

/// A place for the picture of the moment and for lines that stay.
pub enum Live {
    /// Redrawn in place.
    Terminal {
        /// The drawing area, inline under what was printed before.
        terminal: Box<Terminal<CrosstermBackend<Stderr>>>,
        /// Time of the last drawing.
        drawn: Option<Instant>,
        /// Colours are wanted.
        colour: bool,
    },
    /// Lines only.
    Log,
}

impl Live {
    /// The live view where standard error is a terminal, otherwise the log.
    pub fn start() -> Self {
        let wanted = stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|t| t != "dumb");
        let rows = ratatui::crossterm::terminal::size()
            .map_or(USUAL_ROWS, |(_, rows)| rows.saturating_sub(ROWS_ABOVE));
        let options = TerminalOptions {
            viewport: Viewport::Inline(rows.max(FEWEST_ROWS)),
        };
        match wanted.then(|| Terminal::with_options(CrosstermBackend::new(stderr()), options)) {
            Some(Ok(terminal)) => Self::Terminal {
                terminal: Box::new(terminal),
                drawn: None,
                colour: std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
            },
            _ => Self::Log,
        }
    }

    /// Is somebody watching a terminal?
    pub fn is_terminal(&self) -> bool {
        matches!(self, Self::Terminal { .. })
    }

    /// Is a drawing due? Preparing a picture costs more than asking.
    pub fn due(&self) -> bool {
        match self {
            Self::Terminal { drawn, .. } => drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW),
            Self::Log => false,
        }
    }

    /// Draws the picture of the moment. A terminal that went away does not stop a trial.
    pub fn draw(&mut self, picture: &Picture) {
        if let Self::Terminal {
            terminal,
            drawn,
            colour,
        } = self
        {
            let _ = terminal.draw(|frame| render(frame, picture, *colour));
            *drawn = Some(Instant::now());
        }
    }

    /// Prints a line that stays.
    pub fn line(&mut self, text: &str) {
        let text = wrapped(&plain(text), width_of_stderr().unwrap_or(usize::MAX));
        match self {
            Self::Terminal { terminal, .. } => {
                let count = text.lines().count() as u16;
                let _ = terminal.insert_before(count, |buffer| {
                    for (row, line) in (buffer.area.y..).zip(text.lines()) {
                        buffer.set_string(buffer.area.x, row, line, Style::default());
                    }
                });
            }
            Self::Log => {
                let _ = write!(stderr(), "{text}");
            }
        }
    }

    /// Takes the live view away.
    pub fn end(&mut self) {
        if let Self::Terminal { terminal, .. } = self {
            // The lines that stay leave the cursor behind the last of them.
            let begins = terminal.get_frame().area().as_position();
            let _ = terminal.clear();
            let _ = terminal.set_cursor_position(begins);
            let _ = terminal.show_cursor();
        }
    }
}

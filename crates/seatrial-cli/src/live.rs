//! What a person watches while a trial runs: a live view on a terminal, a plain log elsewhere.

use std::io::{IsTerminal, Stderr, Write, stderr};
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Gauge, Paragraph};
use ratatui::{Frame, Terminal, TerminalOptions, Viewport};
use seatrial::plain_text::plain;
use seatrial_core::Stage;

/// Rows of the live view.
const ROWS: u16 = 9;

/// Time between two drawings.
const REDRAW: Duration = Duration::from_millis(100);

/// The names of the stages, in order.
const STAGES: [(Stage, &str); 3] = [
    (Stage::Settle, "settle"),
    (Stage::Train, "train"),
    (Stage::Validate, "validate"),
];

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
        let options = TerminalOptions {
            viewport: Viewport::Inline(ROWS),
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
        let text = &*plain(text);
        match self {
            Self::Terminal { terminal, .. } => {
                let _ = terminal.insert_before(1, |buffer| {
                    buffer.set_string(buffer.area.x, buffer.area.y, text, Style::default());
                });
            }
            Self::Log => {
                let _ = writeln!(stderr(), "{text}");
            }
        }
    }

    /// Takes the live view away.
    pub fn end(&mut self) {
        if let Self::Terminal { terminal, .. } = self {
            let _ = terminal.clear();
            let _ = terminal.show_cursor();
        }
    }
}

fn render(frame: &mut Frame, picture: &Picture, colour: bool) {
    let rows: [Rect; 7] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Length(3),
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let tint = |name: Color| if colour { name } else { Color::Reset };

    frame.render_widget(Line::from(picture.title.clone()).bold(), rows[0]);
    frame.render_widget(stage_line(picture), rows[1]);
    let duration_s = picture.elapsed_s + picture.remaining_s;
    frame.render_widget(
        Gauge::default()
            .ratio((picture.elapsed_s / duration_s.max(1e-9)).clamp(0.0, 1.0))
            .label(format!("{:.0} s left", picture.remaining_s))
            .gauge_style(Style::new().fg(tint(Color::Cyan))),
        rows[2],
    );
    let parameters: Vec<Line> = picture.parameters.iter().map(parameter_line).collect();
    frame.render_widget(Paragraph::new(parameters), rows[3]);
    frame.render_widget(Line::from(convergence_text(picture)), rows[4]);
    frame.render_widget(envelope_line(picture, &tint), rows[5]);
    frame.render_widget(
        Line::from("Ctrl-C aborts and hands the vehicle back").dim(),
        rows[6],
    );
}

fn stage_line(picture: &Picture) -> Line<'static> {
    let mut spans = Vec::new();
    for (stage, name) in STAGES {
        let style = if picture.stage == Some(stage) {
            Style::new().add_modifier(Modifier::BOLD | Modifier::REVERSED)
        } else {
            Style::new().add_modifier(Modifier::DIM)
        };
        spans.push(Span::styled(format!(" {name} "), style));
        spans.push(Span::raw(" "));
    }
    Line::from(spans)
}

fn parameter_line(parameter: &Parameter) -> Line<'static> {
    let interval = parameter.interval.map_or_else(String::new, |[low, high]| {
        format!("   95 %: {low:.4} to {high:.4}")
    });
    Line::from(format!(
        "{:>4} {:>9.4} {:<8}{interval}",
        parameter.name, parameter.value, parameter.unit
    ))
}

fn convergence_text(picture: &Picture) -> String {
    match picture.converged_s {
        Some(converged_s) => format!("converged {converged_s:.1} s into training"),
        None => format!(
            "step norm {:.1e}, converged under {:.0e}",
            picture.step_norm, picture.threshold
        ),
    }
}

fn envelope_line(picture: &Picture, tint: &impl Fn(Color) -> Color) -> Line<'static> {
    let mut spans = vec![Span::raw("envelope used:")];
    for (name, used) in &picture.envelope {
        let style = match used {
            used if *used >= 0.8 => Style::new().fg(tint(Color::Red)).bold(),
            used if *used >= 0.5 => Style::new().fg(tint(Color::Yellow)),
            _ => Style::new(),
        };
        spans.push(Span::styled(
            format!("  {name} {:.0} %", 100.0 * used),
            style,
        ));
    }
    Line::from(spans)
}

//! What a person watches while a trial runs: a live view on a terminal, a plain log elsewhere.

use std::io::{IsTerminal, Stderr, Write, stderr};
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Gauge, Paragraph};
use ratatui::{Frame, Terminal, TerminalOptions, Viewport};

/// Rows of the live view.
const ROWS: u16 = 9;

/// Time between two drawings.
const REDRAW: Duration = Duration::from_millis(100);

/// Everything that the live view shows at one instant.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Vehicle, run, thrust, attempt.
    pub title: String,
    /// Names of the stages and the index of the one that runs.
    pub stages: [&'static str; 3],
    /// Index of the stage that runs.
    pub stage: usize,
    /// Time into the stage and its longest duration, s.
    pub stage_time_s: [f64; 2],
    /// Name, value with unit, 95 % interval where known.
    pub parameters: Vec<(&'static str, f64, Option<[f64; 2]>, &'static str)>,
    /// Step norm of the parameters and its threshold (39).
    pub step_norm: Option<[f64; 2]>,
    /// When convergence was detected, s into training.
    pub converged_s: Option<f64>,
    /// Limit and how much of it is used, 1 is at the limit.
    pub envelope: Vec<(&'static str, f64)>,
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
    let [elapsed_s, duration_s] = picture.stage_time_s;
    frame.render_widget(
        Gauge::default()
            .ratio((elapsed_s / duration_s).clamp(0.0, 1.0))
            .label(format!("{:.0} s left", (duration_s - elapsed_s).max(0.0)))
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
    for (index, name) in picture.stages.iter().enumerate() {
        let style = if index == picture.stage {
            Style::new().add_modifier(Modifier::BOLD | Modifier::REVERSED)
        } else {
            Style::new().add_modifier(Modifier::DIM)
        };
        spans.push(Span::styled(format!(" {name} "), style));
        spans.push(Span::raw(" "));
    }
    Line::from(spans)
}

fn parameter_line(
    (name, value, interval, unit): &(&'static str, f64, Option<[f64; 2]>, &'static str),
) -> Line<'static> {
    let interval = interval.map_or_else(String::new, |[low, high]| {
        format!("   95 %: {low:.3} to {high:.3}")
    });
    Line::from(format!("{name:>4} {value:>9.4} {unit:<8}{interval}"))
}

fn convergence_text(picture: &Picture) -> String {
    match (picture.converged_s, picture.step_norm) {
        (Some(converged_s), _) => format!("converged {converged_s:.1} s into training"),
        (None, Some([norm, threshold])) => {
            format!("step norm {norm:.1e}, converged under {threshold:.0e}")
        }
        (None, None) => String::new(),
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
        spans.push(Span::styled(format!("  {name} {:.0} %", 100.0 * used), style));
    }
    Line::from(spans)
}

//! A drawing on a terminal, inline under what was printed before.

use std::io::{Stderr, stderr};

use ratatui::backend::CrosstermBackend;
use ratatui::style::Style;
use ratatui::{Terminal, TerminalOptions, Viewport};

use super::Picture;
use super::drawing::render;

/// Rows above the live view, where the lines that stay are seen.
const ROWS_ABOVE: u16 = 2;
/// Fewest rows of the live view.
const FEWEST_ROWS: u16 = 9;
/// Rows of the live view on a terminal that does not tell its size.
const USUAL_ROWS: u16 = 22;

/// The drawing area.
pub struct View {
    terminal: Terminal<CrosstermBackend<Stderr>>,
    /// Colours are wanted.
    colour: bool,
}

impl View {
    /// `None` where standard error cannot be drawn on.
    pub fn start() -> Option<Self> {
        let rows = ratatui::crossterm::terminal::size()
            .map_or(USUAL_ROWS, |(_, rows)| rows.saturating_sub(ROWS_ABOVE));
        let options = TerminalOptions { viewport: Viewport::Inline(rows.max(FEWEST_ROWS)) };
        Some(Self {
            terminal: Terminal::with_options(CrosstermBackend::new(stderr()), options).ok()?,
            colour: std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
        })
    }

    /// Draws the picture of the moment.
    pub fn draw(&mut self, picture: &Picture) {
        let _ = self.terminal.draw(|frame| render(frame, picture, self.colour));
    }

    /// Prints lines that stay above the drawing.
    pub fn lines(&mut self, text: &str) {
        let count = text.lines().count() as u16;
        let _ = self.terminal.insert_before(count, |buffer| {
            for (row, line) in (buffer.area.y..).zip(text.lines()) {
                buffer.set_string(buffer.area.x, row, line, Style::default());
            }
        });
    }

    /// Takes the drawing away.
    pub fn end(&mut self) {
        // The lines that stay leave the cursor behind the last of them.
        let begins = self.terminal.get_frame().area().as_position();
        let _ = self.terminal.clear();
        let _ = self.terminal.set_cursor_position(begins);
        let _ = self.terminal.show_cursor();
    }
}

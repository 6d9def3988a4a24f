//! How the live view is laid out: it fills what the terminal has.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Line as Stroke};
use ratatui::widgets::{Gauge, Paragraph};
use seatrial::words::{bounds_text, within};
use seatrial_core::Stage;

use super::{Parameter, Picture, Strip};

/// The names of the stages, in order.
const STAGES: [(Stage, &str); 3] =
    [(Stage::Settle, "settle"), (Stage::Train, "train"), (Stage::Validate, "validate")];

/// From so many columns on, numbers and limits stand beside the strips.
const WIDE: u16 = 120;
/// Columns of the numbers and limits there.
const SIDE: u16 = 52;
/// From so many rows on, each limit has a bar.
const TALL: u16 = 20;
/// Columns of a strip's name and number.
const NUMBER: u16 = 22;
/// Columns of a limit with its bar.
const LIMIT: usize = 38;

/// Colours, where they are wanted.
#[derive(Clone, Copy)]
struct Tint(bool);

impl Tint {
    fn of(self, colour: Color) -> Color {
        if self.0 { colour } else { Color::Reset }
    }
}

pub(super) fn render(frame: &mut Frame, picture: &Picture, colour: bool) {
    let tint = Tint(colour);
    let [head, body, hint] =
        Layout::vertical([Constraint::Length(3), Constraint::Min(0), Constraint::Length(1)])
            .areas(frame.area());
    draw_head(frame, picture, head, tint);
    if body.width >= WIDE {
        let [strips, side] = Layout::horizontal([Constraint::Min(0), Constraint::Length(SIDE)])
            .spacing(2)
            .areas(body);
        draw_strips(frame, picture, strips, tint);
        let [numbers, limits] =
            Layout::vertical([Constraint::Length(5), Constraint::Min(0)]).areas(side);
        draw_numbers(frame, picture, numbers);
        frame.render_widget(Paragraph::new(limit_bars(picture, side.width, tint)), limits);
    } else {
        let limits = match body.height + 4 >= TALL {
            true => limit_bars(picture, body.width, tint),
            false => vec![limit_line(picture, tint)],
        };
        let [strips, numbers, bars] = Layout::vertical([
            Constraint::Min(0),
            Constraint::Length(4),
            Constraint::Length(limits.len() as u16),
        ])
        .areas(body);
        draw_strips(frame, picture, strips, tint);
        draw_numbers(frame, picture, numbers);
        frame.render_widget(Paragraph::new(limits), bars);
    }
    frame.render_widget(Line::from("Ctrl-C aborts and hands the vehicle back").dim(), hint);
}

/// What runs, its stages and how long they take.
fn draw_head(frame: &mut Frame, picture: &Picture, place: Rect, tint: Tint) {
    let rows: [Rect; 3] = Layout::vertical([Constraint::Length(1); 3]).areas(place);
    frame.render_widget(Line::from(picture.title.clone()).bold(), rows[0]);
    frame.render_widget(stage_line(picture), rows[1]);
    let duration_s = picture.elapsed_s + picture.remaining_s;
    frame.render_widget(
        Gauge::default()
            .ratio((picture.elapsed_s / duration_s.max(1e-9)).clamp(0.0, 1.0))
            .label(format!("{:.0} s left", picture.remaining_s))
            .gauge_style(Style::new().fg(tint.of(Color::Cyan))),
        rows[2],
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
    let left_s = picture.left_s.max(0.0).round();
    spans.push(Span::raw(format!(
        "   about {:.0} min {:02.0} s left in all",
        (left_s / 60.0).floor(),
        left_s % 60.0
    )));
    Line::from(spans)
}

/// Each measurement as a number and a strip.
fn draw_strips(frame: &mut Frame, picture: &Picture, place: Rect, tint: Tint) {
    let count = picture.strips.len();
    let places = Layout::vertical(vec![Constraint::Fill(1); count]).split(place);
    for (strip, place) in picture.strips.iter().zip(places.iter()) {
        let [number, curve] =
            Layout::horizontal([Constraint::Length(NUMBER), Constraint::Min(0)]).areas(*place);
        frame.render_widget(Paragraph::new(number_text(strip)), number);
        draw_curve(frame, strip, curve, tint);
    }
}

fn number_text(strip: &Strip) -> String {
    let value = strip
        .points
        .last()
        .map_or_else(|| "-".to_owned(), |(_, value)| format!("{value:.*}", strip.decimals));
    let number = format!("{:<8}{value:>8} {}", strip.name, strip.unit);
    match span(strip) {
        Some([low, high]) => {
            let decimals = strip.decimals;
            format!("{number}\n{:>NUMBER_END$}", format!("{low:.decimals$} to {high:.decimals$}"))
        }
        None => number,
    }
}

/// Columns up to the end of a strip's number.
const NUMBER_END: usize = 16;

/// The least and the largest value of a strip: the ends of its curve.
fn span(strip: &Strip) -> Option<[f64; 2]> {
    let values = || strip.points.iter().map(|(_, value)| *value);
    let low = values().reduce(f64::min)?;
    Some([low, values().reduce(f64::max)?])
}

fn draw_curve(frame: &mut Frame, strip: &Strip, place: Rect, tint: Tint) {
    let (Some((from, _)), Some((to, _))) = (strip.points.first(), strip.points.last()) else {
        return;
    };
    let Some([low, high]) = span(strip) else {
        return;
    };
    let room = (0.05 * (high - low)).max(0.5 * (strip.least_span - (high - low)));
    let colour = tint.of(Color::Green);
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([*from, to.max(from + 1e-9)])
        .y_bounds([low - room, high + room])
        .paint(|context| {
            for pair in strip.points.windows(2) {
                let [(x1, y1), (x2, y2)] = [pair[0], pair[1]];
                context.draw(&Stroke { x1, y1, x2, y2, color: colour });
            }
        });
    frame.render_widget(canvas, place);
}

/// The estimate and whether it has come to rest.
fn draw_numbers(frame: &mut Frame, picture: &Picture, place: Rect) {
    // While the vehicle settles there is no estimate, only where the last one stood.
    if picture.stage == Some(Stage::Settle) {
        frame.render_widget(Paragraph::new("the estimate begins with the training"), place);
        return;
    }
    let mut lines: Vec<Line> = picture.parameters.iter().map(parameter_line).collect();
    lines.push(Line::from(convergence_text(picture)));
    frame.render_widget(Paragraph::new(lines), place);
}

fn parameter_line(parameter: &Parameter) -> Line<'static> {
    let Parameter { name, value, interval, unit } = parameter;
    let value = within(*value, *interval);
    let bounds = interval
        .map_or_else(String::new, |[low, high]| format!("  95 %: {}", bounds_text([low, high])));
    Line::from(format!("{name:>4} {value:>9} {unit:<8}{bounds}"))
}

fn convergence_text(picture: &Picture) -> String {
    let Picture { step_norm, threshold, .. } = picture;
    match picture.converged_s {
        Some(converged_s) => format!("at rest {converged_s:.1} s into training"),
        None => format!("change per sample {step_norm:.1e}, at rest below {threshold:.0e}"),
    }
}

/// How close a limit is, as a style.
fn warning(used: f64, tint: Tint) -> Style {
    match used {
        used if used >= 0.8 => Style::new().fg(tint.of(Color::Red)).bold(),
        used if used >= 0.5 => Style::new().fg(tint.of(Color::Yellow)),
        _ => Style::new(),
    }
}

/// The part used of each limit in one line, the closest first, so that a narrow terminal shows those.
fn limit_line(picture: &Picture, tint: Tint) -> Line<'static> {
    let mut limits = picture.envelope.clone();
    limits.sort_by(|a, b| b.1.total_cmp(&a.1));
    let shares = limits.into_iter().map(|(name, used)| {
        Span::styled(format!("  {name} {:.0} %", 100.0 * used), warning(used, tint))
    });
    [Span::raw("limits used:")].into_iter().chain(shares).collect()
}

/// The part used of each limit as a bar, as many beside each other as there is room for.
fn limit_bars(picture: &Picture, width: u16, tint: Tint) -> Vec<Line<'static>> {
    let columns = (usize::from(width) / LIMIT).max(1);
    let mut lines = vec![Line::from("Limits used")];
    for limits in picture.envelope.chunks(columns) {
        let spans = limits.iter().map(|(name, used)| {
            let text = format!("{name:<9}{:>4.0} % {:<24}", 100.0 * used, bar(*used, 20));
            Span::styled(text, warning(*used, tint))
        });
        lines.push(Line::from_iter(spans));
    }
    lines
}

fn bar(used: f64, length: usize) -> String {
    let filled = (used.clamp(0.0, 1.0) * length as f64).round() as usize;
    "█".repeat(filled) + &"░".repeat(length - filled)
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;

    fn picture() -> Picture {
        let strip = |name, unit| Strip {
            name,
            unit,
            decimals: 1,
            least_span: 1.0,
            points: (0..200).map(|k| (f64::from(k), f64::from(k % 50))).collect(),
        };
        let parameter = |name, unit| Parameter {
            name,
            value: -1.2e-8,
            interval: Some([-1.4e-8, -1.0e-8]),
            unit,
        };
        Picture {
            title: "sim:starfish   run 1, speed 1 of 5, 60 % thrust, try 1".into(),
            stage: Some(Stage::Train),
            elapsed_s: 4.0,
            remaining_s: 12.0,
            left_s: 207.0,
            strips: vec![
                strip("heading", "deg"),
                strip("rudder", "deg"),
                strip("speed", "m/s"),
                strip("depth", "m"),
            ],
            parameters: [
                parameter("a22", "1/s"),
                parameter("b2", "1/s^2"),
                parameter("C0", "rad/s^2"),
            ],
            step_norm: 1e-2,
            threshold: 1e-3,
            converged_s: None,
            envelope: [
                "depth", "altitude", "roll", "pitch", "rate", "heading", "area", "speed",
                "silence", "time",
            ]
            .map(|name| (name, if name == "silence" { 0.9 } else { 0.4 }))
            .to_vec(),
        }
    }

    /// The rows of the view on a terminal of this size.
    fn drawn(width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
        terminal.draw(|frame| render(frame, &picture(), true)).expect("it draws");
        let buffer = terminal.backend().buffer().clone();
        let row = |y: u16| (0..width).map(|x| buffer[(x, y)].symbol().to_owned()).collect();
        (0..height).map(row).collect()
    }

    /// 22 rows of a terminal of 80x24, 48 of one of 200x50: two show the lines that stay.
    #[test]
    fn exact_everything_is_seen_on_small_and_large_terminals() {
        for (width, height) in [(80, 22), (200, 48), (80, 12)] {
            let rows = drawn(width, height);
            let text = rows.join("\n");
            for shown in [
                "heading",
                "rudder",
                "speed",
                "depth",
                "3 min 27 s left in all",
                "12 s left",
                "a22",
                "-1.20e-8",
                "silence",
                "40 %",
                "Ctrl-C",
            ] {
                assert!(text.contains(shown), "{width}x{height}: {shown}\n{text}");
            }
            let empty = rows.iter().filter(|row| row.trim().is_empty()).count();
            assert!(empty <= 1, "{width}x{height}: {empty} empty rows\n{text}");
        }
    }
}

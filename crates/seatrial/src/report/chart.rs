//! A small SVG chart writer: panels stacked over one horizontal axis.
//!
//! A general plotting library was tried on paper and left out: kuva 0.6 writes a fixed pixel size
//! without a `viewBox`, colours as attributes of each element, no accessible name, and each panel
//! with its own axis. A report needs the opposite: pictures that scale with the column, take every
//! colour from a CSS variable so that one picture serves both themes and print, and share one time
//! axis under marks and stages that run through all panels.
//!
//! Everything is drawn in a user space [`WIDTH`] units wide. Data are drawn inside nested `svg`
//! elements, which clip, in tenths of a unit, as relative integer steps.

use std::fmt::Write;

use super::number::{escaped, tick_text};

/// Width of every chart, user units: chosen so that text stays readable on a phone.
pub(super) const WIDTH: f64 = 420.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 10.0;
/// Width of the drawing area, user units.
pub(super) const PLOT_WIDTH: f64 = WIDTH - LEFT - RIGHT;
const HEADER: f64 = 18.0;
const FOOTER: f64 = 36.0;
const GAP: f64 = 7.0;
const LABEL_ROW: f64 = 14.0;
/// Mean width of a character, user units, a little generous.
const CHARACTER: f64 = 6.8;

/// Panels over one horizontal axis.
pub(super) struct Chart {
    /// What the picture shows, for those who do not see it.
    pub alt: String,
    /// Title of the horizontal axis with its unit.
    pub x_label: &'static str,
    /// Ends of the horizontal axis.
    pub x_range: [f64; 2],
    /// Shaded stretches of the horizontal axis, through every panel.
    pub spans: Vec<Span>,
    /// Vertical lines through every panel.
    pub marks: Vec<Mark>,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

/// A shaded stretch of the horizontal axis.
pub(super) struct Span {
    pub from: f64,
    pub to: f64,
    /// CSS class that names the shade.
    pub shade: &'static str,
    /// Printed above the first panel.
    pub label: String,
}

/// A vertical line.
pub(super) struct Mark {
    pub at: f64,
    /// Printed above the first panel.
    pub label: String,
}

/// One vertical axis with what is drawn on it.
pub(super) struct Panel {
    /// Title of the vertical axis with its unit.
    pub label: String,
    pub height: f64,
    pub scale: Scale,
    /// Ends of the vertical axis; found from the data where `None`.
    pub range: Option<[f64; 2]>,
    /// The vertical axis covers at least this much, so that noise does not look like motion.
    pub least_span: f64,
    pub layers: Vec<Layer>,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear,
    Logarithmic,
}

/// Something drawn in a panel. `ink` is the CSS class that gives colour and dashes.
pub(super) struct Layer {
    pub ink: &'static str,
    /// Printed in the panel's legend where not empty.
    pub name: String,
    pub shape: Shape,
}

pub(super) enum Shape {
    /// A line through points, interrupted where one is not finite.
    Line(Vec<[f64; 2]>),
    /// A dot at each point.
    Dots(Vec<[f64; 2]>),
    /// At each x a bar from low to high.
    Bars(Vec<[f64; 3]>),
    /// A horizontal line over the whole width.
    Level(f64),
    /// A filled stretch of the vertical axis over the whole width.
    Band([f64; 2]),
}

impl Layer {
    pub fn line(ink: &'static str, name: &str, points: Vec<[f64; 2]>) -> Self {
        Self::new(ink, name, Shape::Line(points))
    }

    pub fn dots(ink: &'static str, name: &str, points: Vec<[f64; 2]>) -> Self {
        Self::new(ink, name, Shape::Dots(points))
    }

    pub fn bars(ink: &'static str, name: &str, bars: Vec<[f64; 3]>) -> Self {
        Self::new(ink, name, Shape::Bars(bars))
    }

    pub fn level(ink: &'static str, name: &str, at: f64) -> Self {
        Self::new(ink, name, Shape::Level(at))
    }

    pub fn new(ink: &'static str, name: &str, shape: Shape) -> Self {
        Self {
            ink,
            name: name.to_owned(),
            shape,
        }
    }

    fn values(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let inside = |x: f64| from <= x && x <= to;
        match &self.shape {
            Shape::Line(points) | Shape::Dots(points) => {
                let visible = points.iter().filter(|[x, _]| inside(*x));
                visible.map(|[_, y]| *y).collect()
            }
            Shape::Bars(bars) => {
                let visible = bars.iter().filter(|[x, ..]| inside(*x));
                visible.flat_map(|[_, low, high]| [*low, *high]).collect()
            }
            Shape::Level(at) => vec![*at],
            Shape::Band(ends) => ends.to_vec(),
        }
    }
}

impl Panel {
    pub fn linear(label: impl Into<String>, height: f64, layers: Vec<Layer>) -> Self {
        Self {
            label: label.into(),
            height,
            scale: Scale::Linear,
            range: None,
            least_span: 0.0,
            layers,
        }
    }

    pub fn logarithmic(label: impl Into<String>, height: f64, layers: Vec<Layer>) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(label, height, layers)
        }
    }

    pub fn with_range(self, range: Option<[f64; 2]>) -> Self {
        Self { range, ..self }
    }

    pub fn spanning_at_least(self, least_span: f64) -> Self {
        Self { least_span, ..self }
    }

    /// The vertical axis in the units in which it is even: the logarithm for a logarithmic one.
    fn axis(&self, x_range: [f64; 2]) -> [f64; 2] {
        let values = || {
            self.layers
                .iter()
                .flat_map(|layer| layer.values(x_range))
                .map(|y| self.even(y))
                .filter(|y| y.is_finite())
        };
        let found = [
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        ];
        let [low, high] = self
            .range
            .map_or(found, |range| range.map(|y| self.even(y)));
        if !(low <= high && (high - low).is_finite()) {
            return [0.0, 1.0];
        }
        let least = match self.scale {
            Scale::Linear => self
                .least_span
                .max(1e-3 * high.abs().max(low.abs()))
                .max(1e-6),
            Scale::Logarithmic => 0.5,
        };
        let padding = (0.06 * (high - low)).max(0.5 * (least - (high - low)));
        [low - padding, high + padding]
    }

    fn even(&self, y: f64) -> f64 {
        match self.scale {
            Scale::Linear => y,
            Scale::Logarithmic => y.log10(),
        }
    }

    /// Values and texts of the ticks.
    fn ticks(&self, axis: [f64; 2]) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => linear_ticks(axis, (self.height / 22.0).max(2.0)),
            Scale::Logarithmic => {
                let decades = (axis[1].floor() - axis[0].ceil()).max(0.0);
                let every = (decades / (self.height / 16.0)).ceil().max(1.0);
                let mut ticks = Vec::new();
                let mut exponent = (axis[0] / every).ceil() * every;
                while exponent <= axis[1] {
                    ticks.push((exponent, power_of_ten(exponent)));
                    exponent += every;
                }
                ticks
            }
        }
    }
}

/// 0.001 in digits where short, otherwise 10 with the exponent raised.
fn power_of_ten(exponent: f64) -> String {
    if (-3.0..=3.0).contains(&exponent) {
        return tick_text(10_f64.powf(exponent), 10_f64.powf(exponent));
    }
    let raised: String = format!("{exponent}")
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or(digit),
        })
        .collect();
    format!("10{raised}")
}

/// About `count` round values inside the axis, steps of 1, 2 or 5 times a power of ten.
pub(super) fn linear_ticks([low, high]: [f64; 2], count: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / count;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|step| *step >= 0.7 * rough)
        .unwrap_or(10.0 * power);
    let first = (low / step).ceil();
    (0..32)
        .map(|k| (first + f64::from(k)) * step)
        .take_while(|value| *value <= high + 1e-9 * step)
        .map(|value| (value, tick_text(value, step)))
        .collect()
}

/// The lowest and the highest point of each pixel column, in order: what a screen can show of a
/// long line. A point that is not finite stays as a break.
fn thinned(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut thin: Vec<[f64; 2]> = Vec::new();
    let mut column: Vec<[f64; 2]> = Vec::new();
    let flush = |column: &mut Vec<[f64; 2]>, thin: &mut Vec<[f64; 2]>| {
        let by_height = |a: &(usize, &[f64; 2]), b: &(usize, &[f64; 2])| a.1[1].total_cmp(&b.1[1]);
        let low = column.iter().enumerate().min_by(by_height).map(|(k, _)| k);
        let high = column.iter().enumerate().max_by(by_height).map(|(k, _)| k);
        if let (Some(low), Some(high)) = (low, high) {
            thin.push(column[low.min(high)]);
            if low != high {
                thin.push(column[low.max(high)]);
            }
        }
        column.clear();
    };
    for point in points {
        let finite = point[0].is_finite() && point[1].is_finite();
        let same_column = column
            .first()
            .is_none_or(|c| c[0].floor() == point[0].floor());
        if !finite || !same_column {
            flush(&mut column, &mut thin);
        }
        if finite {
            column.push(point);
        } else {
            thin.push([f64::NAN; 2]);
        }
    }
    flush(&mut column, &mut thin);
    thin
}

/// Where each label goes: its left end and its row, so that none lies on another.
fn placed(mut labels: Vec<(f64, String)>) -> (Vec<(f64, usize, String)>, usize) {
    labels.retain(|(x, text)| x.is_finite() && !text.is_empty());
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut row_ends: Vec<f64> = Vec::new();
    let mut placed = Vec::new();
    for (centre, text) in labels {
        let width = text.chars().count() as f64 * CHARACTER;
        let left = (centre - width / 2.0).clamp(2.0, (WIDTH - width - 2.0).max(2.0));
        let row = row_ends
            .iter()
            .position(|end| end + 6.0 <= left)
            .unwrap_or(row_ends.len());
        row_ends.resize(row_ends.len().max(row + 1), 0.0);
        row_ends[row] = left + width;
        placed.push((left, row, text));
    }
    (placed, row_ends.len())
}

impl Chart {
    /// The chart as one `svg` element.
    pub fn svg(&self) -> String {
        let [from, to] = self.x_range;
        let x = |value: f64| LEFT + (value - from) / (to - from) * PLOT_WIDTH;
        let inside = |value: f64| value.clamp(from, to);

        let span_labels = self
            .spans
            .iter()
            .filter(|span| span.to > from && span.from < to)
            .map(|s| (x(0.5 * (inside(s.from) + inside(s.to))), s.label.clone()));
        let mark_labels = self.marks.iter().map(|m| (x(m.at), m.label.clone()));
        let (labels, rows) = placed(span_labels.chain(mark_labels).collect());
        let labels_height = rows as f64 * LABEL_ROW;

        let mut body = String::new();
        for (left, row, text) in labels {
            let y = (row + 1) as f64 * LABEL_ROW - 3.0;
            text_at(&mut body, [left, y], "mark-label", &text);
        }
        let mut top = labels_height;
        for panel in &self.panels {
            top = self.draw_panel(panel, top, &mut body);
        }
        let bottom = top - GAP;
        for (value, text) in linear_ticks(self.x_range, 7.0) {
            text_at(&mut body, [x(value), bottom + 14.0], "tick middle", &text);
        }
        let middle = LEFT + PLOT_WIDTH / 2.0;
        text_at(
            &mut body,
            [middle, bottom + 30.0],
            "axis-label middle",
            self.x_label,
        );
        format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\" aria-label=\"{}\">{body}</svg>",
            bottom + FOOTER,
            escaped(&self.alt)
        )
    }

    /// Draws one panel below `top` and returns where the next one starts.
    fn draw_panel(&self, panel: &Panel, top: f64, body: &mut String) -> f64 {
        let legend_rows = draw_header(panel, top, body);
        let top = top + legend_rows as f64 * HEADER;
        let height = panel.height;
        let [from, to] = self.x_range;
        let [low, high] = panel.axis(self.x_range);
        // Tenths of a unit from the panel's top left corner.
        let x = |value: f64| (value - from) / (to - from) * PLOT_WIDTH * 10.0;
        let y = |value: f64| (high - panel.even(value)) / (high - low) * height * 10.0;

        let (width10, height10) = (PLOT_WIDTH * 10.0, height * 10.0);
        let _ = write!(
            body,
            "<svg x=\"{LEFT}\" y=\"{top}\" width=\"{PLOT_WIDTH}\" height=\"{height}\" viewBox=\"0 0 {width10} {height10}\" aria-hidden=\"true\"><rect class=\"ground\" width=\"{width10}\" height=\"{height10}\"/>"
        );
        for span in &self.spans {
            let (left, right) = (x(span.from.clamp(from, to)), x(span.to.clamp(from, to)));
            if right > left {
                let _ = write!(
                    body,
                    "<rect class=\"{}\" x=\"{left:.0}\" width=\"{:.0}\" height=\"{height10}\"/>",
                    span.shade,
                    right - left
                );
            }
        }
        let ticks = panel.ticks([low, high]);
        let tick_heights: Vec<f64> = ticks
            .iter()
            .map(|(value, _)| (high - value) / (high - low) * height)
            .collect();
        let _ = write!(body, "<path class=\"grid\" d=\"");
        for tick in &tick_heights {
            let _ = write!(body, "M0 {:.0}h{width10}", tick * 10.0);
        }
        for (value, _) in linear_ticks(self.x_range, 7.0) {
            let _ = write!(body, "M{:.0} 0v{height10}", x(value));
        }
        let _ = write!(body, "\"/>");
        for mark in self.marks.iter().filter(|m| from <= m.at && m.at <= to) {
            let _ = write!(
                body,
                "<path class=\"mark\" d=\"M{:.0} 0v{height10}\"/>",
                x(mark.at)
            );
        }
        for layer in &panel.layers {
            draw_layer(layer, body, x, y, width10);
        }
        body.push_str("</svg>");
        for ((_, text), tick) in ticks.iter().zip(tick_heights) {
            text_at(body, [LEFT - 5.0, top + tick + 3.5], "tick end", text);
        }
        top + height + GAP
    }
}

/// The panel's title at the left and its legend at the right, below the title where too long;
/// returns the rows used.
fn draw_header(panel: &Panel, top: f64, body: &mut String) -> usize {
    const SWATCH: f64 = 16.0;
    const BETWEEN: f64 = 9.0;
    text_at(body, [LEFT, top + 13.0], "axis-label", &panel.label);
    let width = |layer: &Layer| SWATCH + 3.0 + layer.name.chars().count() as f64 * CHARACTER;
    let named: Vec<&Layer> = panel.layers.iter().filter(|l| !l.name.is_empty()).collect();
    let legend: f64 = named.iter().map(|l| width(l) + BETWEEN).sum();
    let label = panel.label.chars().count() as f64 * CHARACTER + 14.0;
    let beside = label + legend <= WIDTH - LEFT;
    let mut row = usize::from(!beside);
    let mut left = if beside { WIDTH - legend } else { LEFT };
    for layer in named {
        if left > LEFT && left + width(layer) > WIDTH {
            row += 1;
            left = LEFT;
        }
        let y = top + row as f64 * HEADER + 9.0;
        let _ = match layer.shape {
            Shape::Dots(_) => write!(
                body,
                "<circle class=\"dot {}\" cx=\"{:.1}\" cy=\"{y:.1}\" r=\"3\"/>",
                layer.ink,
                left + SWATCH / 2.0
            ),
            _ => write!(
                body,
                "<path class=\"swatch {}\" d=\"M{left:.1} {y:.1}h{SWATCH}\"/>",
                layer.ink
            ),
        };
        text_at(body, [left + SWATCH + 3.0, y + 4.0], "legend", &layer.name);
        left += width(layer) + BETWEEN;
    }
    row + 1
}

fn draw_layer(
    layer: &Layer,
    body: &mut String,
    x: impl Fn(f64) -> f64,
    y: impl Fn(f64) -> f64,
    width10: f64,
) {
    // Far outside the panel there is nothing to see, and digits to save.
    let tenths = |value: f64| value.clamp(-2e4, 2e4).round() as i64;
    let ink = layer.ink;
    match &layer.shape {
        Shape::Line(points) => {
            let unit = points.iter().map(|[a, b]| [x(*a) / 10.0, y(*b) / 10.0]);
            let mut pen: Option<[i64; 2]> = None;
            let _ = write!(body, "<path class=\"line {ink}\" d=\"");
            for [a, b] in thinned(unit) {
                if !b.is_finite() {
                    pen = None;
                    continue;
                }
                let to = [tenths(a * 10.0), tenths(b * 10.0)];
                let _ = match pen {
                    Some(at) => write!(body, "l{} {}", to[0] - at[0], to[1] - at[1]),
                    None => write!(body, "M{} {}", to[0], to[1]),
                };
                pen = Some(to);
            }
            body.push_str("\"/>");
        }
        Shape::Dots(points) => {
            for [a, b] in points.iter().map(|[a, b]| [x(*a), y(*b)]) {
                if a.is_finite() && b.is_finite() {
                    let _ = write!(
                        body,
                        "<circle class=\"dot {ink}\" cx=\"{}\" cy=\"{}\" r=\"32\"/>",
                        tenths(a),
                        tenths(b)
                    );
                }
            }
        }
        Shape::Bars(bars) => {
            for [a, low, high] in bars.iter().map(|[a, l, h]| [x(*a), y(*l), y(*h)]) {
                if a.is_finite() && low.is_finite() && high.is_finite() {
                    let (a, low, high) = (tenths(a), tenths(low), tenths(high));
                    let _ = write!(
                        body,
                        "<path class=\"line {ink}\" d=\"M{a} {low}V{high}M{} {low}h60M{0} {high}h60\"/>",
                        a - 30
                    );
                }
            }
        }
        Shape::Band(ends) => {
            let [low, high] = ends.map(|end| tenths(y(end)));
            if ends.iter().all(|end| end.is_finite()) {
                let _ = write!(
                    body,
                    "<rect class=\"{ink}\" y=\"{high}\" width=\"{width10}\" height=\"{}\"/>",
                    (low - high).max(8)
                );
            }
        }
        Shape::Level(at) => {
            let at = y(*at);
            if at.is_finite() {
                let _ = write!(
                    body,
                    "<path class=\"line {ink}\" d=\"M0 {}h{width10}\"/>",
                    tenths(at)
                );
            }
        }
    }
}

fn text_at(body: &mut String, [x, y]: [f64; 2], class: &str, text: &str) {
    let _ = write!(
        body,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>",
        escaped(text)
    );
}

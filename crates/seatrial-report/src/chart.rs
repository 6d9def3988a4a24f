//! A small SVG chart writer: panels stacked over one horizontal axis.
//!
//! A general plotting library was weighed and left out: kuva 0.6 writes a fixed pixel size
//! without a `viewBox`, colours as attributes of each element, no accessible name, and each panel
//! with its own axis. A report needs the opposite: pictures that scale with the column, take every
//! colour from a CSS variable so that one picture serves both themes and print, and share one time
//! axis under marks and stages that run through all panels.
//!
//! Everything is drawn in a user space [`WIDTH`] units wide. Data are drawn inside nested `svg`
//! elements, which clip, in tenths of a unit, as relative integer steps. A panel's `data-x` and `data-y` are the ends
//! of its axes, from which `figures.js` tells values under the pointer; `data-ink` ties a line to its legend.

use std::fmt::Write;

use super::axis::{CHARACTER, extent, label_rows, linear_ticks, power_of_ten};
use super::layer::draw_layer;
pub(super) use super::layer::{Layer, Shape};
use super::number::escaped;

/// Width of every chart, user units: chosen so that text stays readable on a phone.
pub(super) const WIDTH: f64 = 420.0;
const LEFT: f64 = 53.0;
const RIGHT: f64 = 10.0;
/// Width of the drawing area, user units.
pub(super) const PLOT_WIDTH: f64 = WIDTH - LEFT - RIGHT;
const HEADER: f64 = 18.0;
const FOOTER: f64 = 36.0;
const GAP: f64 = 7.0;
const LABEL_ROW: f64 = 14.0;

/// Panels over one horizontal axis.
#[derive(Default)]
pub(super) struct Chart {
    /// What the picture shows, for those who do not see it.
    pub alt: String,
    /// Title of the horizontal axis with its unit.
    pub x_label: &'static str,
    /// Ends of the horizontal axis.
    pub x_range: [f64; 2],
    /// Shaded spans of the horizontal axis, through every panel.
    pub spans: Vec<Span>,
    /// Vertical lines through every panel.
    pub marks: Vec<Mark>,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

/// A shaded span of the horizontal axis.
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
        Self { scale: Scale::Logarithmic, ..Self::linear(label, height, layers) }
    }

    pub fn with_range(self, range: Option<[f64; 2]>) -> Self {
        Self { range, ..self }
    }

    pub fn spanning_at_least(self, least_span: f64) -> Self {
        Self { least_span, ..self }
    }

    /// The vertical axis in the units in which it is even: the logarithm for a logarithmic one.
    fn axis(&self, x_range: [f64; 2]) -> [f64; 2] {
        let values = self.layers.iter().flat_map(|layer| layer.values(x_range));
        let found = extent(values.map(|y| self.even(y)).filter(|y| y.is_finite()));
        let [low, high] = self.range.map_or(found, |range| range.map(|y| self.even(y)));
        if !(low <= high && (high - low).is_finite()) {
            return [0.0, 1.0];
        }
        let least = match self.scale {
            Scale::Linear => self.least_span.max(1e-3 * high.abs().max(low.abs())).max(1e-6),
            Scale::Logarithmic => 0.5,
        };
        let padding = (0.06 * (high - low)).max(0.5 * (least - (high - low)));
        [low - padding, high + padding]
    }

    fn even(&self, y: f64) -> f64 {
        match self.scale {
            Scale::Linear => y,
            Scale::Logarithmic => libm::log10(y),
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

impl Chart {
    /// The chart as one `svg` element.
    pub fn svg(&self) -> String {
        let [from, to] = self.ends();
        let x = |value: f64| LEFT + (value - from) / (to - from) * PLOT_WIDTH;
        let inside = |value: f64| value.clamp(from, to);

        let span_labels = self
            .spans
            .iter()
            .filter(|span| span.to > from && span.from < to)
            .map(|s| (x(0.5 * (inside(s.from) + inside(s.to))), s.label.clone()));
        let mark_labels = self.marks.iter().map(|m| (x(m.at), m.label.clone()));
        let (labels, rows) = label_rows(span_labels.chain(mark_labels).collect(), WIDTH);
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
        for (value, text) in linear_ticks([from, to], 7.0) {
            text_at(&mut body, [x(value), bottom + 14.0], "tick x middle", &text);
        }
        let middle = LEFT + PLOT_WIDTH / 2.0;
        text_at(&mut body, [middle, bottom + 30.0], "axis-label middle", self.x_label);
        format!(
            "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\" aria-label=\"{}\">{body}</svg>",
            bottom + FOOTER,
            escaped(&self.alt)
        )
    }

    /// The ends of the horizontal axis, also where the data gave none.
    fn ends(&self) -> [f64; 2] {
        let [from, to] = self.x_range;
        if from < to && (to - from).is_finite() { [from, to] } else { [0.0, 1.0] }
    }

    /// Shades the spans, over this height in tenths of a unit; `x` places a value.
    fn draw_spans(&self, height10: f64, x: impl Fn(f64) -> f64, body: &mut String) {
        let [from, to] = self.ends();
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
    }

    /// Draws one panel below `top` and returns where the next one starts.
    fn draw_panel(&self, panel: &Panel, top: f64, body: &mut String) -> f64 {
        body.push_str("<g class=\"panel\">");
        let legend_rows = draw_header(panel, top, body);
        let top = top + legend_rows as f64 * HEADER;
        let height = panel.height;
        let [from, to] = self.ends();
        let [low, high] = panel.axis([from, to]);
        // Tenths of a unit from the panel's top left corner.
        let x = |value: f64| (value - from) / (to - from) * PLOT_WIDTH * 10.0;
        let y = |value: f64| (high - panel.even(value)) / (high - low) * height * 10.0;

        let (width10, height10) = (PLOT_WIDTH * 10.0, height * 10.0);
        let _ = write!(
            body,
            "<svg class=\"plot\" x=\"{LEFT}\" y=\"{top}\" width=\"{PLOT_WIDTH}\" height=\"{height}\" viewBox=\"0 0 {width10} {height10}\" data-x=\"{from} {to}\" data-y=\"{low} {high}\"{} aria-hidden=\"true\"><rect class=\"ground\" width=\"{width10}\" height=\"{height10}\"/>",
            match panel.scale {
                Scale::Linear => "",
                Scale::Logarithmic => " data-log=\"\"",
            }
        );
        self.draw_spans(height10, x, body);
        let ticks = panel.ticks([low, high]);
        let tick_heights: Vec<f64> =
            ticks.iter().map(|(value, _)| (high - value) / (high - low) * height).collect();
        let _ = write!(body, "<path class=\"grid\" d=\"");
        for tick in &tick_heights {
            let _ = write!(body, "M0 {:.0}h{width10}", tick * 10.0);
        }
        for (value, _) in linear_ticks([from, to], 7.0) {
            let _ = write!(body, "M{:.0} 0v{height10}", x(value));
        }
        let _ = write!(body, "\"/>");
        for mark in self.marks.iter().filter(|m| from <= m.at && m.at <= to) {
            let _ = write!(body, "<path class=\"mark\" d=\"M{:.0} 0v{height10}\"/>", x(mark.at));
        }
        for layer in &panel.layers {
            draw_layer(layer, body, x, y, width10);
        }
        body.push_str("</svg>");
        for ((_, text), tick) in ticks.iter().zip(tick_heights) {
            text_at(body, [LEFT - 5.0, top + tick + 3.5], "tick end", text);
        }
        body.push_str("</g>");
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
        let _ = write!(body, "<g class=\"key\" data-ink=\"{}\">", layer.ink);
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
        body.push_str("</g>");
        left += width(layer) + BETWEEN;
    }
    row + 1
}

fn text_at(body: &mut String, [x, y]: [f64; 2], class: &str, text: &str) {
    let _ =
        write!(body, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escaped(text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_empty_and_flat_panels_have_an_axis() {
        for points in [vec![], vec![[0.0, f64::NAN]], vec![[0.0, 3.0], [1.0, 3.0]]] {
            let panel = Panel::linear("x", 50.0, vec![Layer::line("a", "", points)]);
            let [low, high] = panel.axis([0.0, 1.0]);
            assert!(low < high && (high - low).is_finite());
        }
    }
}

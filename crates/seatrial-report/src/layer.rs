//! Lines, dots, bars and bands of a panel, and how they are drawn as SVG.

use std::fmt::Write;

use super::axis::thinned;

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
    /// A filled range of the vertical axis over the whole width.
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
        Self { ink, name: name.to_owned(), shape }
    }

    /// Is there nothing to draw?
    pub fn is_empty(&self) -> bool {
        match &self.shape {
            Shape::Line(points) | Shape::Dots(points) => points.is_empty(),
            Shape::Bars(bars) => bars.is_empty(),
            Shape::Level(_) | Shape::Band(_) => false,
        }
    }

    pub fn values(&self, [from, to]: [f64; 2]) -> Vec<f64> {
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

/// Draws a layer in tenths of a unit from the panel's top left corner. `x` and `y` place a value.
pub(super) fn draw_layer(
    layer: &Layer,
    body: &mut String,
    x: impl Fn(f64) -> f64,
    y: impl Fn(f64) -> f64,
    width10: f64,
) {
    let ink = layer.ink;
    let _ = write!(body, "<g data-ink=\"{ink}\">");
    match &layer.shape {
        Shape::Line(points) => draw_line(points.iter().map(|[a, b]| [x(*a), y(*b)]), ink, body),
        Shape::Dots(points) => draw_dots(points.iter().map(|[a, b]| [x(*a), y(*b)]), ink, body),
        Shape::Bars(bars) => {
            let bars = bars.iter().map(|[a, low, high]| [x(*a), y(*low), y(*high)]);
            draw_bars(bars, ink, body);
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
                let _ =
                    write!(body, "<path class=\"line {ink}\" d=\"M0 {}h{width10}\"/>", tenths(at));
            }
        }
    }
    body.push_str("</g>");
}

/// A whole number of tenths of a unit. Far outside the panel there is nothing to see, and digits to
/// save.
fn tenths(value: f64) -> i64 {
    value.clamp(-2e4, 2e4).round() as i64
}

fn draw_line(points: impl Iterator<Item = [f64; 2]>, ink: &str, body: &mut String) {
    let unit = points.map(|[a, b]| [a / 10.0, b / 10.0]);
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

fn draw_dots(points: impl Iterator<Item = [f64; 2]>, ink: &str, body: &mut String) {
    for point in points.filter(|point| point.iter().all(|at| at.is_finite())) {
        let [a, b] = point.map(tenths);
        let _ = write!(body, "<circle class=\"dot {ink}\" cx=\"{a}\" cy=\"{b}\" r=\"32\"/>");
    }
}

fn draw_bars(bars: impl Iterator<Item = [f64; 3]>, ink: &str, body: &mut String) {
    for bar in bars.filter(|bar| bar.iter().all(|at| at.is_finite())) {
        let [a, low, high] = bar.map(tenths);
        let _ = write!(
            body,
            "<path class=\"line {ink}\" d=\"M{a} {low}V{high}M{} {low}h60M{0} {high}h60\"/>",
            a - 30
        );
    }
}

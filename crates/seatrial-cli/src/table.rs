//! A table of text for people, columns as wide as their widest cell.

use std::fmt;

use seatrial::figures::{bounds_text, with_decimals, within};
use seatrial_app::models::Estimate;

use crate::screen::labelled;

/// Rows of cells under a heading; every column is flush right.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with this heading: one `name unit` for each column, the unit in a line of its own.
    pub fn new(columns: &[(&str, &str)]) -> Self {
        let line = |of: fn(&(&str, &str)) -> String| columns.iter().map(of).collect();
        Self {
            rows: vec![line(|c| c.0.into()), line(|c| c.1.into())],
        }
    }

    /// Columns of its longest line.
    pub fn width(&self) -> usize {
        let line = |line: &str| line.chars().count();
        self.to_string().lines().map(line).max().unwrap_or(0)
    }

    /// The table as text that fits a screen: columns of these names are left out, in this order, until it does,
    /// and then the intervals. A line below says so.
    pub fn fitted(mut self, width: usize, dispensable: &[&str]) -> String {
        let mut left_out = Vec::new();
        for name in dispensable {
            if self.width() <= width {
                break;
            }
            while let Some(at) = self.rows[0].iter().position(|heading| heading == name) {
                self.rows.iter_mut().for_each(|row| {
                    row.remove(at);
                });
                left_out.push(*name);
            }
        }
        left_out.dedup();
        if self.width() > width && self.drop_intervals() {
            left_out.push("95 % intervals");
        }
        match left_out.is_empty() {
            true => self.to_string(),
            false => {
                let note = format!(
                    "On a wider screen, or with --json: {}.",
                    left_out.join(", ")
                );
                format!("{self}{}", labelled("", &note, width))
            }
        }
    }

    /// Leaves the bounds behind the values out. Were there any?
    fn drop_intervals(&mut self) -> bool {
        let mut dropped = false;
        for cell in self.rows.iter_mut().skip(2).flatten() {
            let bounds = cell.find(" (").filter(|at| cell[*at..].contains(" to "));
            if let Some(at) = bounds {
                cell.truncate(at);
                dropped = true;
            }
        }
        dropped
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let line: String = row
                .iter()
                .zip(&widths)
                .map(|(cell, width)| format!("{cell:>width$}  "))
                .collect();
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Decimals with which a value is printed: `least`, or as many as three significant figures of a small one need.
pub fn decimals(value: f64, least: usize) -> usize {
    if value == 0.0 || !value.is_finite() {
        return least;
    }
    let needed = 2.0 - value.abs().log10().floor();
    least.max(needed.clamp(0.0, 12.0) as usize)
}

/// A value, then the bounds of its interval where one is known.
pub fn estimate_text(estimate: &Estimate, least_decimals: usize, scale: f64) -> String {
    let value = estimate.value * scale;
    let Some(interval) = estimate.interval_95 else {
        return with_decimals(value, decimals(value, least_decimals));
    };
    let mut interval = interval.map(|bound| bound * scale);
    interval.sort_by(f64::total_cmp);
    let value = within(value, Some(interval));
    format!("{value} ({})", bounds_text(interval))
}

#[cfg(test)]
mod tests {
    use super::{Table, decimals};

    #[test]
    fn exact_a_table_leaves_out_what_does_not_fit() {
        let table = || {
            let mut table = Table::new(&[("speed", "m/s"), ("T", "s"), ("K", "1/s")]);
            table.row(vec!["1.07".into(), "0.9".into(), "1.0".into()]);
            table
        };
        assert_eq!(table().fitted(80, &["T"]), table().to_string());
        let narrow = table().fitted(12, &["T", "K"]);
        assert!(narrow.starts_with("speed    K\n"), "{narrow}");
        assert!(
            narrow.ends_with("On a wider\nscreen, or\nwith --json:\nT.\n"),
            "{narrow}"
        );
    }

    #[test]
    fn exact_a_narrow_table_keeps_its_values_and_leaves_out_their_intervals() {
        let mut table = Table::new(&[("speed", "m/s"), ("K_p", "")]);
        table.row(vec!["1.07".into(), "0.595 (0.544 to 0.646)".into()]);
        let narrow = table.fitted(20, &[]);
        assert!(narrow.contains("\n 1.07  0.595\n"), "{narrow}");
        assert!(narrow.contains("intervals."), "{narrow}");
    }

    #[test]
    fn exact_small_values_keep_three_figures() {
        assert_eq!(decimals(-1.07, 3), 3);
        assert_eq!(decimals(0.0096, 3), 5);
        assert_eq!(decimals(9.1e-5, 3), 7);
        assert_eq!(decimals(0.0, 3), 3);
    }
}

//! A table of text for people, columns as wide as their widest cell.

use std::fmt;

use seatrial::words::{bounds_text, named_columns, with_decimals, within};
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
        Self { rows: vec![line(|c| c.0.into()), line(|c| c.1.into())] }
    }

    /// A table under a heading, `speed [m/s] | gain`: names with units in brackets.
    pub fn under(heading: &str) -> Self {
        let columns = named_columns(heading);
        let (names, units) = columns.unzip();
        Self { rows: vec![names, units] }
    }

    /// Columns of its longest line.
    pub fn width(&self) -> usize {
        let line = |line: &str| line.chars().count();
        self.to_string().lines().map(line).max().unwrap_or(0)
    }

    /// The table as text that fits a screen: columns of these names, or of these names and units, are left out, in this order, until it
    /// does, then the intervals, those of the last column first. A line below says so. Where that is not enough each row becomes a paragraph.
    pub fn fitted(mut self, width: usize, dispensable: &[&str]) -> String {
        self.leave_out_empty();
        let mut left_out: Vec<String> = Vec::new();
        for name in dispensable {
            if self.width() > width && self.leave_out(name) {
                left_out.push((*name).to_owned());
            }
        }
        let mut without = Vec::new();
        for column in (0..self.rows[0].len()).rev() {
            if self.width() > width && self.drop_intervals(column) {
                without.insert(0, self.rows[0][column].clone());
            }
        }
        if let Some((last, others)) = without.split_last() {
            let others = others.join(", ");
            let and = if others.is_empty() { "" } else { " and " };
            left_out.push(format!("95 % intervals of {others}{and}{last}"));
        }
        let rows = match self.width() <= width {
            true => self.to_string(),
            false => self.paragraphs(width),
        };
        match left_out.is_empty() {
            true => rows,
            false => {
                let note = format!("On a wider screen, or with --json: {}.", left_out.join(", "));
                format!("{rows}{}", labelled("", &note, width))
            }
        }
    }

    /// Leaves the columns out that no row has.
    fn leave_out_empty(&mut self) {
        let [heads, _, rows @ ..] = &self.rows[..] else {
            return;
        };
        let is_empty = |column: &usize| rows.iter().all(|row| row[*column] == "-");
        let empty: Vec<usize> = (0..heads.len()).filter(is_empty).collect();
        if rows.is_empty() {
            return;
        }
        for column in empty.into_iter().rev() {
            self.rows.iter_mut().for_each(|row| drop(row.remove(column)));
        }
    }

    /// Leaves the columns of this name, or of this name and unit, out. Were there any?
    fn leave_out(&mut self, name: &str) -> bool {
        let [heads, units, ..] = &self.rows[..] else {
            return false;
        };
        let is_meant = |(head, unit): (&String, &String)| {
            head == name || name.strip_prefix(head.as_str()) == Some(&format!(" {unit}"))
        };
        let stays: Vec<bool> = heads.iter().zip(units).map(|of| !is_meant(of)).collect();
        for row in &mut self.rows {
            let mut stays = stays.iter();
            row.retain(|_| stays.next() != Some(&false));
        }
        stays.contains(&false)
    }

    /// Each row in a paragraph of its own, every cell with its heading.
    fn paragraphs(&self, width: usize) -> String {
        let [heads, units, rows @ ..] = &self.rows[..] else {
            return String::new();
        };
        let cells = |row: &Vec<String>| {
            let named = heads.iter().zip(units).zip(row);
            let cells = named.map(|((head, unit), cell)| format!("{head} {cell} {unit}"));
            let mut cells: Vec<String> = cells.map(|cell| cell.trim().to_owned()).collect();
            cells.retain(|cell| !cell.is_empty());
            labelled("- ", &cells.join(", "), width)
        };
        rows.iter().map(cells).collect()
    }

    /// Leaves the bounds behind the values of a column out. Were there any?
    fn drop_intervals(&mut self, column: usize) -> bool {
        let mut dropped = false;
        for row in self.rows.iter_mut().skip(2) {
            let cell = &mut row[column];
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
            let line: String =
                row.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}  ")).collect();
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

/// A cell with this number, `-` where there is none.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.decimals$}"))
}

/// A cell with this estimate, `-` where there is none.
pub fn estimate_cell(estimate: &Option<Estimate>, least_decimals: usize, scale: f64) -> String {
    let text = |estimate: &Estimate| estimate_text(estimate, least_decimals, scale);
    estimate.as_ref().map_or("-".into(), text)
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
            let mut table =
                Table::new(&[("speed", "m/s"), ("R^2", "rate"), ("R^2", "heading"), ("K", "1/s")]);
            table.row(vec!["1.07".into(), "0.9".into(), "0.8".into(), "1.0".into()]);
            table
        };
        assert_eq!(table().fitted(80, &["R^2 rate"]), table().to_string());
        let narrow = table().fitted(20, &["R^2 rate", "K"]);
        assert!(narrow.starts_with("speed      R^2    K\n"), "{narrow}");
        assert!(narrow.ends_with("R^2\nrate.\n"), "{narrow}");
    }

    #[test]
    fn exact_a_narrow_table_keeps_its_values_and_leaves_out_their_intervals() {
        let table = || {
            let mut table = Table::new(&[("speed", "m/s"), ("K_p", ""), ("overshoot", "%")]);
            let cells = ["1.07", "0.595 (0.544 to 0.646)", "2 (1 to 3)"];
            table.row(cells.map(str::to_owned).into());
            table
        };
        let narrow = table().fitted(40, &[]);
        assert!(narrow.contains("\n 1.07  0.595 (0.544 to 0.646)          2\n"), "{narrow}");
        assert!(narrow.contains("intervals of overshoot."), "{narrow}");
        let narrower = table().fitted(24, &[]);
        assert!(narrower.contains("\n 1.07  0.595"), "{narrower}");
        assert!(narrower.contains("K_p and"), "{narrower}");
    }

    #[test]
    fn exact_a_column_that_no_row_has_is_left_out() {
        let mut table = Table::new(&[("speed", "m/s"), ("circle", "m")]);
        table.row(vec!["1.07".into(), "-".into()]);
        assert_eq!(table.fitted(80, &[]), "speed\n  m/s\n 1.07\n");
    }

    #[test]
    fn exact_rows_that_fit_no_screen_become_paragraphs() {
        let mut table = Table::new(&[("log", ""), ("damping", "%")]);
        table.row(vec!["a_log_with_a_long_name.csv".into(), "+2".into()]);
        assert_eq!(table.fitted(30, &[]), "- log\n  a_log_with_a_long_name.csv,\n  damping +2 %\n");
    }

    #[test]
    fn exact_small_values_keep_three_figures() {
        assert_eq!(decimals(-1.07, 3), 3);
        assert_eq!(decimals(0.0096, 3), 5);
        assert_eq!(decimals(9.1e-5, 3), 7);
        assert_eq!(decimals(0.0, 3), 3);
    }
}

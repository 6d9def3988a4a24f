//! Ticks, thinned lines and the places of labels.

use super::number::decimals;

/// Mean width of a character, user units, a little generous.
pub(super) const CHARACTER: f64 = 6.8;

/// The least and the greatest of the values that are numbers; infinite ends in the wrong order where
/// there are none.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let nothing = [f64::INFINITY, f64::NEG_INFINITY];
    let widened = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    values.into_iter().fold(nothing, widened)
}

/// About `count` round values inside the axis, steps of 1, 2 or 5 times a power of ten; two at least, or nobody could tell its scale.
pub(super) fn linear_ticks([low, high]: [f64; 2], count: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / count;
    let power = libm::pow(10_f64, libm::log10(rough).floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|step| *step >= 0.7 * rough)
        .unwrap_or(10.0 * power);
    let first = (low / step).ceil();
    let ticks: Vec<(f64, String)> = (0..32)
        .map(|k| (first + f64::from(k)) * step + 0.0)
        .take_while(|value| *value <= high + 1e-9 * step)
        .map(|value| (value, tick_text(value, step)))
        .collect();
    match ticks.len() < 2 && rough.is_finite() && rough > 0.0 {
        true => linear_ticks([low, high], 2.0 * count),
        false => ticks,
    }
}

/// The text of a tick with just the decimals that its step needs; a power of ten beside it where
/// these would be many.
fn tick_text(value: f64, step: f64) -> String {
    let exponent = (libm::log10(step) + 1e-9).floor();
    if value == 0.0 && exponent < -4.0 {
        return "0".to_owned();
    }
    if exponent >= -4.0 {
        return decimals(value, (-exponent).clamp(0.0, 4.0) as usize);
    }
    let mantissa = decimals(value / libm::pow(10_f64, exponent), 0);
    format!("{mantissa}·{}", power_of_ten(exponent))
}

/// 0.001 in digits where short, otherwise 10 with the exponent raised.
pub(super) fn power_of_ten(exponent: f64) -> String {
    if (-3.0..=3.0).contains(&exponent) {
        return tick_text(libm::pow(10_f64, exponent), libm::pow(10_f64, exponent));
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

/// The lowest and the highest point of each pixel column, in order: what a screen can show of a
/// long line. A point that is not finite stays as a break.
pub(super) fn thinned(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
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
        let same_column = column.first().is_none_or(|c| c[0].floor() == point[0].floor());
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

/// Where each label goes: its left end and its row, so that none lies on another and all lie
/// inside the chart.
pub(super) fn label_rows(
    mut labels: Vec<(f64, String)>,
    chart_width: f64,
) -> (Vec<(f64, usize, String)>, usize) {
    labels.retain(|(x, text)| x.is_finite() && !text.is_empty());
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut row_ends: Vec<f64> = Vec::new();
    let mut positions = Vec::new();
    for (centre, text) in labels {
        let width = text.chars().count() as f64 * CHARACTER;
        let left = (centre - width / 2.0).clamp(2.0, (chart_width - width - 2.0).max(2.0));
        let row = row_ends.iter().position(|end| end + 6.0 <= left).unwrap_or(row_ends.len());
        row_ends.resize(row_ends.len().max(row + 1), 0.0);
        row_ends[row] = left + width;
        positions.push((left, row, text));
    }
    (positions, row_ends.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: [f64; 2], count: f64) -> Vec<String> {
        let ticks = linear_ticks(axis, count);
        ticks.into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn exact_extent_passes_over_what_is_no_number() {
        assert_eq!(extent([2.0, f64::NAN, -1.0, 0.5]), [-1.0, 2.0]);
        let [low, high] = extent([f64::NAN]);
        assert!(low > high);
    }

    #[test]
    fn exact_ticks_are_round_and_inside() {
        assert_eq!(texts([0.0, 10.0], 5.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(texts([-0.011, 0.012], 3.0), ["−0.01", "0.00", "0.01"]);
        assert_eq!(texts([99.5, 100.6], 2.0), ["99.5", "100.0", "100.5"]);
        assert_eq!(texts([-4.9, 4.6], 2.0), ["−4", "−2", "0", "2", "4"]);
        assert_eq!(texts([-2e-6, 1e-5], 2.0), ["0", "5·10⁻⁶", "10·10⁻⁶"]);
    }

    #[test]
    fn exact_powers_of_ten() {
        assert_eq!(power_of_ten(-3.0), "0.001");
        assert_eq!(power_of_ten(2.0), "100");
        assert_eq!(power_of_ten(-12.0), "10⁻¹²");
    }

    /// A spike of one sample among ten thousand is what a reader looks for.
    #[test]
    fn prop_thinning_keeps_spikes_breaks_and_ends() {
        let mut points: Vec<[f64; 2]> =
            (0..10_000).map(|k| [f64::from(k) * 0.036, f64::from(k % 7)]).collect();
        points[4321][1] = 50.0;
        points[7000][1] = f64::NAN;
        let thin = thinned(points.iter().copied());
        assert!(thin.iter().any(|point| point[1] == 50.0));
        assert_eq!(thin.iter().filter(|point| point[1].is_nan()).count(), 1);
        // Two points a column of 360, one break and the column that it divides.
        assert!(thin.len() <= 2 * 361 + 1, "{}", thin.len());
        assert_eq!(thin[0][0].floor(), 0.0);
        assert_eq!(thin[thin.len() - 1][0].floor(), 359.0);
    }

    #[test]
    fn prop_labels_do_not_lie_on_each_other() {
        const WIDTH: f64 = 420.0;
        let labels = ["doublet", "armed", "converged 6.3 s", "least radius"];
        let crowded = labels.iter().zip([100.0, 104.0, 110.0, 419.0]);
        let crowded = crowded.map(|(text, x)| (x, (*text).to_owned()));
        let (positions, rows) = label_rows(crowded.collect(), WIDTH);
        assert_eq!(rows, 3);
        for (k, (left, row, text)) in positions.iter().enumerate() {
            let end = left + text.chars().count() as f64 * CHARACTER;
            assert!(*left >= 0.0 && end <= WIDTH, "{text}");
            for (other, other_row, _) in &positions[k + 1..] {
                assert!(other_row != row || *other > end, "{text}");
            }
        }
    }
}

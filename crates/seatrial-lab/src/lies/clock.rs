//! What a clock makes of the rows.

use super::draw::Draw;
use super::setup::{ClockChannel, Setup};

/// Which rows are written in which order, each with the number in its time column.
pub fn stamps(
    setup: &Setup,
    times_s: &[f64],
    jump_at_s: f64,
    chance: &mut Draw,
) -> Vec<(usize, f64)> {
    let clock = &setup.clock;
    let row_s = setup.row_s();
    let mut rows: Vec<(usize, f64)> = times_s
        .iter()
        .enumerate()
        .map(|(row, &time_s)| {
            let jump_s = if time_s >= jump_at_s { clock.jump_s } else { 0.0 };
            let jitter_s = clock.jitter * row_s * chance.normal();
            (
                row,
                clock.start_s
                    + time_s * (1.0 + clock.gains)
                    + jump_s
                    + jitter_s.clamp(-0.45 * row_s, 0.45 * row_s),
            )
        })
        .collect();
    drop_blocks(&mut rows, setup, chance);
    for (row, stamp) in &mut rows {
        if clock.rounding_s > 0.0 {
            *stamp = (*stamp / clock.rounding_s).round() * clock.rounding_s;
        }
        *stamp = match clock.per_second {
            0.0 => *row as f64,
            per_second => *stamp * per_second,
        };
    }
    disorder(rows, clock)
}

/// Leaves blocks of half a time constant out.
fn drop_blocks(rows: &mut Vec<(usize, f64)>, setup: &Setup, chance: &mut Draw) {
    if setup.clock.missing == 0.0 {
        return;
    }
    let block = ((0.5 * setup.time_constant_s() / setup.row_s()) as usize).max(2);
    let blocks = rows.len() / block + 1;
    let missing: Vec<bool> = (0..blocks).map(|_| chance.chance(setup.clock.missing)).collect();
    rows.retain(|(row, _)| !missing[row / block]);
}

fn disorder(mut rows: Vec<(usize, f64)>, clock: &ClockChannel) -> Vec<(usize, f64)> {
    let pairs = rows.len().checked_div(clock.swap_every).unwrap_or(0);
    for pair in 1..pairs {
        rows.swap(pair * clock.swap_every, pair * clock.swap_every - 1);
    }
    if clock.duplicate_every > 0 {
        rows = rows
            .iter()
            .enumerate()
            .flat_map(|(k, row)| {
                let copies = if k % clock.duplicate_every == 0 { 2 } else { 1 };
                std::iter::repeat_n(*row, copies)
            })
            .collect();
    }
    rows
}

//! Prediction of what was left out: a free run over each block with the parameters that the other blocks give.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::filter::innovations;
use super::fit::{Fit, Problem};
use super::gear::angles;
use super::leg::deviation;
use super::motion::Start;

/// Blocks that a record is cut into.
pub const BLOCKS: usize = 5;

/// Fewest comparisons of a block.
const LEAST: usize = 6;

/// No parameter moves further for a block, in units of its scale.
const FURTHEST: f64 = 1.0;

/// A part of a leg that is left out.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    leg: usize,
    from: usize,
    to: usize,
    /// Its first row among the innovations of all legs.
    row: usize,
    is_whole_leg: bool,
}

/// Blocks of about equal length; with as many legs as blocks, the legs.
pub fn blocks(problem: &Problem) -> Vec<Block> {
    let total = problem.comparisons();
    let mut blocks = Vec::new();
    let mut row = 0;
    for (leg, record) in problem.legs.iter().enumerate() {
        let n = record.len();
        let count = match problem.legs.len() < BLOCKS {
            true => ((BLOCKS * n + total / 2) / total.max(1)).max(1),
            false => 1,
        };
        for k in 0..count {
            let (from, to) = (k * n / count, (k + 1) * n / count);
            if to - from >= LEAST {
                blocks.push(Block { leg, from, to, row: row + from, is_whole_leg: count == 1 });
            }
        }
        row += n;
    }
    blocks
}

/// Parameters without a block by one step from those of all.
pub fn without(problem: &Problem, fit: &Fit, block: &Block) -> DVector<f64> {
    let rows = block.to - block.from;
    let jacobian = fit.jacobian.rows(block.row, rows).into_owned();
    let information = &fit.information - jacobian.tr_mul(&jacobian) / fit.variance_rad2;
    let slope = jacobian.tr_mul(&fit.errors.rows(block.row, rows)) / fit.variance_rad2;
    let own = problem.first_of_leg(block.leg);
    let is_own = |i: usize| block.is_whole_leg && (own..own + problem.per_leg()).contains(&i);
    let free: Vec<usize> = (0..problem.size()).filter(|i| !is_own(*i)).collect();
    let deviations: Vec<f64> =
        free.iter().map(|i| information[(*i, *i)].max(1e-12).sqrt()).collect();
    let scaled = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        information[(free[a], free[b])] / (deviations[a] * deviations[b])
    });
    let eigen = scaled.symmetric_eigen();
    let right = DVector::from_fn(free.len(), |a, _| slope[free[a]] / deviations[a]);
    let mut along = eigen.eigenvectors.tr_mul(&right);
    for (value, eigenvalue) in along.iter_mut().zip(eigen.eigenvalues.iter()) {
        *value /= eigenvalue.max(1e-5);
    }
    let step = &eigen.eigenvectors * along;
    let shared = problem.parameters.len();
    let furthest = (0..free.len())
        .filter(|a| free[*a] < shared)
        .map(|a| (step[a] / deviations[a]).abs())
        .fold(0.0, f64::max);
    let share = if furthest > FURTHEST { FURTHEST / furthest } else { 1.0 };
    let mut x = fit.x.clone();
    for (a, i) in free.iter().enumerate() {
        x[*i] += share * step[a] / deviations[a];
    }
    if block.is_whole_leg && problem.legs.len() > 1 {
        let others = (0..problem.legs.len()).filter(|leg| *leg != block.leg);
        let sum: f64 = others.map(|leg| x[problem.first_of_leg(leg) + 2]).sum();
        x[own + 2] = sum / (problem.legs.len() - 1) as f64;
    }
    x
}

/// Variance of the heading over a block, rad^2.
pub fn heading_variance_rad2(problem: &Problem, block: &Block) -> f64 {
    let leg = &problem.legs[block.leg];
    deviation(&leg.heading_rad[block.from..block.to]).powi(2)
}

/// Mean square of the free run over a block, rad^2, with its own initial state and offset.
pub fn free_run_rad2(problem: &Problem, x: &DVector<f64>, block: &Block) -> f64 {
    let leg = &problem.legs[block.leg];
    let vehicle = problem.vehicle(x);
    let angles = angles(leg, &vehicle);
    let scale = &problem.scale;
    let near = (block.from + 4).min(block.to - 1);
    let mut start = Start {
        heading_rad: leg.heading_rad[block.from],
        yaw_rate_rad_s: (leg.heading_rad[near] - leg.heading_rad[block.from])
            / (leg.time_s[near] - leg.time_s[block.from]),
        sway_rad: 0.0,
        offset_rad_s2: problem.start_of(x, block.leg).offset_rad_s2,
    };
    let sizes = [
        1.0,
        scale.yaw_rate_rad_s,
        scale.yaw_rate_rad_s * scale.rate_per_s,
        scale.yaw_rate_rad_s / scale.rate_per_s,
    ];
    let free = problem.per_leg();
    let run = |start: &Start| {
        let range = [block.from, block.to];
        DVector::from_vec(innovations(leg, range, &vehicle, start, None, &angles))
    };
    const STEP: f64 = 1e-5;
    for _ in 0..3 {
        let here = run(&start);
        let columns: Vec<DVector<f64>> =
            (0..free).map(|i| (run(&moved(&start, i, STEP * sizes[i])) - &here) / STEP).collect();
        let mut information = SMatrix::<f64, 4, 4>::identity();
        let mut right = SVector::<f64, 4>::zeros();
        for i in 0..free {
            for j in 0..free {
                information[(i, j)] = columns[i].dot(&columns[j]);
            }
            right[i] = columns[i].dot(&here);
        }
        let ridge = 1e-3 * (0..free).map(|i| information[(i, i)]).sum::<f64>()
            / (free * free * here.len()) as f64;
        for i in 0..free {
            information[(i, i)] += ridge;
        }
        let Some(step) = information.cholesky().map(|factor| factor.solve(&right)) else {
            break;
        };
        for i in 0..free {
            start = moved(&start, i, -step[i] * sizes[i]);
        }
    }
    let errors = run(&start);
    let mean = errors.norm_squared() / errors.len() as f64;
    if mean.is_finite() { mean } else { f64::MAX }
}

fn moved(start: &Start, i: usize, by: f64) -> Start {
    let mut start = *start;
    match i {
        0 => start.heading_rad += by,
        1 => start.yaw_rate_rad_s += by,
        2 => start.offset_rad_s2 += by,
        _ => start.sway_rad += by,
    }
    start
}

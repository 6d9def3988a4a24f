//! A simulation of a record with its sensitivities.
//!
//! Heading, yaw rate and drift go from one half of a comparison to the next, their sensitivities from comparison to comparison, by Runge and
//! Kutta's formula or, where the model is linear, exactly.

use super::comparisons::{Comparison, RudderWithin};
use super::passage::{Linear, Passage};
use super::tangent::{TO_A11, TO_A21, TO_A22, TO_CROSS_FLOW, Tangent};
use super::theta::{
    A11, A21, A22, B2, C0, CROSS_FLOW, HEADING, LAG, PARAMETERS, Theta, YAW_RATE, model_of,
};
use crate::sway_yaw::model::{SwayYawModel, SwayYawState};

/// Sensitivities of the heading to all parameters, and what is left of the measured heading.
pub(super) const COLUMNS: usize = PARAMETERS + 1;
pub(super) type Row = [f64; COLUMNS];

/// What parameters do to heading, yaw rate and drift.
type Forced = [[f64; 3]; PARAMETERS];

/// The simulation of a record with its sensitivities.
pub(super) struct Simulation {
    model: SwayYawModel,
    is_linear: bool,
    /// Transitions of a linear model over the halves of a comparison; `linear` is that over the whole.
    halves: [Linear; 2],
    linear: Linear,
    /// Over the last comparison.
    passage: Passage,
    /// Parts of the last comparison between which the drift of a model with cross-flow damping changed its sign.
    parts: Vec<Part>,
    state: SwayYawState,
    /// Sensitivities of heading, yaw rate and drift to each parameter.
    sensitivities: [[f64; 3]; PARAMETERS],
}

/// A time with one rudder.
struct Part {
    duration_s: f64,
    rudder_rad: f64,
    begin: SwayYawState,
    end: SwayYawState,
}

impl Simulation {
    /// `is_linear`: k is 0 and its derivatives are not asked for.
    pub(super) fn new(theta: &Theta, is_linear: bool) -> Self {
        let mut sensitivities = [[0.0; 3]; PARAMETERS];
        sensitivities[HEADING][0] = 1.0;
        sensitivities[YAW_RATE][1] = 1.0;
        Self {
            model: model_of(theta),
            is_linear,
            halves: [Linear::NONE; 2],
            linear: Linear::NONE,
            passage: Passage::NONE,
            parts: Vec::new(),
            state: SwayYawState {
                heading_rad: theta[HEADING],
                yaw_rate_rad_s: theta[YAW_RATE],
                drift_rad: 0.0,
            },
            sensitivities,
        }
    }

    /// Means over a comparison, and how it leads to the next.
    pub(super) fn pass(
        &mut self,
        comparison: &Comparison,
        rudder: &RudderWithin,
    ) -> (Row, &Passage) {
        let begin = self.state;
        let (heading_rad, middle) = self.simulate(comparison, rudder);
        let of_begin = self.sensitivities;
        self.carry_sensitivities(comparison.duration_s, rudder, [&begin, &middle]);
        let [psi_0, r_0, psi_1, r_1] = comparison.path;
        let mut row = [0.0; COLUMNS];
        for (of_row, (begin, end)) in row.iter_mut().zip(of_begin.iter().zip(&self.sensitivities)) {
            *of_row = psi_0 * begin[0] + r_0 * begin[1] + psi_1 * end[0] + r_1 * end[1];
        }
        let b2 = self.model.b2_per_s2;
        row[B2] += rudder.to_mean[0];
        row[LAG] += b2 * rudder.to_mean[1];
        row[PARAMETERS] = comparison.heading_rad - heading_rad;
        self.move_sensitivities(rudder);
        (row, &self.passage)
    }

    /// The mean heading of a comparison, rad, and the state in its middle.
    fn simulate(&mut self, comparison: &Comparison, rudder: &RudderWithin) -> (f64, SwayYawState) {
        let b2 = self.model.b2_per_s2;
        let begin = self.state;
        self.parts.clear();
        let mut heading_rad = 0.0;
        let mut between = None;
        for (i, (half, of_rudder)) in comparison.halves.iter().zip(&rudder.halves).enumerate() {
            let before = self.state;
            let after = self.advanced(i, half.duration_s, of_rudder.mean_rad);
            let [psi_0, r_0, psi_1, r_1] = half.path;
            heading_rad += psi_0 * before.heading_rad
                + r_0 * before.yaw_rate_rad_s
                + psi_1 * after.heading_rad
                + r_1 * after.yaw_rate_rad_s
                + b2 * of_rudder.to_mean;
            let (p, q) = (b2 * of_rudder.to_end, b2 * of_rudder.integral);
            let [heading, rate, drift] = self.besides_the_mean(p, q);
            self.state = SwayYawState {
                heading_rad: after.heading_rad + heading,
                yaw_rate_rad_s: after.yaw_rate_rad_s + rate,
                drift_rad: after.drift_rad + drift,
            };
            between.get_or_insert(self.state);
        }
        let [first, second] = &comparison.halves;
        let (mean_rad, duration_s) = (rudder.halves[0].mean_rad, comparison.duration_s);
        let middle = match between {
            Some(between) if second.duration_s > 0.0 => {
                let until_s = 0.5 * duration_s - first.duration_s;
                self.model.soon(&between, mean_rad, until_s)
            }
            _ => (self.model).middle(mean_rad, duration_s, [&begin, &self.state]),
        };
        (heading_rad, middle)
    }

    /// The state after a half with its mean rudder.
    fn advanced(&mut self, half: usize, duration_s: f64, rudder_rad: f64) -> SwayYawState {
        if duration_s == 0.0 {
            return self.state;
        }
        if !self.is_linear {
            return self.advanced_in_parts(duration_s, rudder_rad);
        }
        if !is_same(duration_s, self.halves[half].passage.interval_s) {
            self.halves[half] = Linear::over(&self.model.linear_part(), duration_s);
        }
        let state = self.state;
        let begin = [state.heading_rad, state.yaw_rate_rad_s, state.drift_rad];
        let input = self.model.b2_per_s2 * rudder_rad + self.model.c0_rad_per_s2;
        let [heading_rad, yaw_rate_rad_s, drift_rad] = self.halves[half].passage.of(begin, input);
        SwayYawState {
            heading_rad,
            yaw_rate_rad_s,
            drift_rad,
        }
    }

    /// The state after a time with one rudder, of which the parts are kept that the drift's change of sign makes.
    fn advanced_in_parts(&mut self, duration_s: f64, rudder_rad: f64) -> SwayYawState {
        let begin = self.state;
        let part = |begin: SwayYawState, duration_s: f64| Part {
            duration_s,
            rudder_rad,
            begin,
            end: self.model.after(begin, rudder_rad, duration_s),
        };
        let whole = part(begin, duration_s);
        let (before, after) = (begin.drift_rad, whole.end.drift_rad);
        if before * after >= 0.0 {
            let end = whole.end;
            self.parts.push(whole);
            return end;
        }
        let first = part(begin, duration_s * before / (before - after));
        let second = part(first.end, duration_s - first.duration_s);
        let end = second.end;
        self.parts.extend([first, second]);
        end
    }

    fn carry_sensitivities(
        &mut self,
        duration_s: f64,
        rudder: &RudderWithin,
        [begin, middle]: [&SwayYawState; 2],
    ) {
        if duration_s == 0.0 {
            self.passage = Passage::NONE;
            return;
        }
        if self.is_linear {
            let forced = self.forced_linear(duration_s, [begin, middle]);
            return self.carry(&self.passage.clone(), forced, rudder);
        }
        if self.parts.len() <= 2 {
            let tangent = Tangent::over(&self.model, duration_s, [begin, middle, &self.state]);
            self.passage = tangent.passage(duration_s);
            return self.carry(&self.passage.clone(), forced(&tangent), rudder);
        }
        let mut together = Passage::NONE;
        for part in core::mem::take(&mut self.parts) {
            let Part {
                begin,
                end,
                duration_s,
                rudder_rad,
            } = part;
            let middle = self.model.middle(rudder_rad, duration_s, [&begin, &end]);
            let tangent = Tangent::over(&self.model, duration_s, [&begin, &middle, &end]);
            let passage = tangent.passage(duration_s);
            self.carry(&passage, forced(&tangent), rudder);
            together = together.then(&passage);
        }
        self.passage = together;
    }

    /// Carries the sensitivities over a passage in which the dynamics force them so.
    fn carry(&mut self, passage: &Passage, mut forced: Forced, rudder: &RudderWithin) {
        let [mean_rad, mean_to_lag] = rudder.mean;
        let of_input = |factor: f64| passage.to_rate.map(|value| factor * value);
        forced[B2] = of_input(mean_rad);
        forced[C0] = of_input(1.0);
        forced[LAG] = of_input(self.model.b2_per_s2 * mean_to_lag);
        for (column, forced) in self.sensitivities.iter_mut().zip(forced) {
            let carried = passage.of(*column, 0.0);
            *column = core::array::from_fn(|i| carried[i] + forced[i]);
        }
    }

    /// What the parameters of a linear model do over a comparison; its passage.
    fn forced_linear(&mut self, duration_s: f64, [begin, middle]: [&SwayYawState; 2]) -> Forced {
        let is_same = is_same(duration_s, self.linear.passage.interval_s);
        if !is_same {
            self.linear = Linear::over(&self.model.linear_part(), duration_s);
        }
        self.passage = Passage {
            is_same,
            ..self.linear.passage
        };
        let end = &self.state;
        let r = (end.heading_rad - begin.heading_rad) / duration_s;
        let w = (begin.drift_rad + 4.0 * middle.drift_rad + end.drift_rad) / 6.0;
        let r_slope = (end.yaw_rate_rad_s - begin.yaw_rate_rad_s) / duration_s;
        let w_slope = (end.drift_rad - begin.drift_rad) / duration_s;
        let [of_rate_slope, of_drift_slope] = &self.linear.slopes;
        let by = |mean: f64, force: &[f64; 3], slope: f64, of_slope: &[f64; 3]| {
            core::array::from_fn(|i| mean * force[i] + slope * of_slope[i])
        };
        let mut forced = [[0.0; 3]; PARAMETERS];
        forced[A22] = by(r, &self.passage.to_rate, r_slope, of_rate_slope);
        forced[A21] = by(w, &self.passage.to_rate, w_slope, of_rate_slope);
        forced[A11] = by(w, &self.linear.to_drift, w_slope, of_drift_slope);
        forced
    }

    /// What the rudder did besides its mean, to heading, yaw rate and drift; `q` is the integral of P.
    fn besides_the_mean(&self, p: f64, q: f64) -> [f64; 3] {
        let (a22, a21, a11) = (
            self.model.a22_per_s,
            self.model.a21_per_s2,
            self.model.a11_per_s,
        );
        [
            p + a22 * q,
            a22 * p + (a22 * a22 - a21) * q,
            -p - (a22 + a11) * q,
        ]
    }

    fn move_sensitivities(&mut self, rudder: &RudderWithin) {
        let b2 = self.model.b2_per_s2;
        for (parameter, of, factor) in [(B2, 0, 1.0), (LAG, 1, b2)] {
            let (p, q) = (rudder.to_end[of], rudder.integral[of]);
            let moved = self.besides_the_mean(factor * p, factor * q);
            for (column, moved) in self.sensitivities[parameter].iter_mut().zip(moved) {
                *column += moved;
            }
        }
    }
}

/// What the parameters of a model with cross-flow damping do.
fn forced(tangent: &Tangent) -> Forced {
    let mut forced = [[0.0; 3]; PARAMETERS];
    forced[A22] = tangent.column(TO_A22);
    forced[A21] = tangent.column(TO_A21);
    forced[A11] = tangent.column(TO_A11);
    forced[CROSS_FLOW] = tangent.column(TO_CROSS_FLOW);
    forced
}

/// Intervals of an even clock differ by its rounding.
fn is_same(interval_s: f64, last_s: f64) -> bool {
    (interval_s - last_s).abs() <= 1e-9 * interval_s
}

#[cfg(test)]
mod tests {
    use super::super::comparisons::Comparisons;
    use super::*;
    use seatrial_core::Sample;

    /// Headings of a vehicle with everything, on a rudder that moves within comparisons, against its own simulation at each sample, and
    /// the sensitivities against its differences.
    #[test]
    fn exact_comparisons_are_means_of_the_simulation() {
        let samples: Vec<Sample<f64>> = (0..600)
            .map(|k| Sample {
                time_s: 0.05 * f64::from(k),
                rudder_rad: 0.2 * f64::from(k % 90 - 45).clamp(-9.0, 9.0) / 9.0,
                ..Sample::default()
            })
            .collect();
        let theta = [-0.4, 0.5, 0.01, 0.05, -0.2, -0.3, 0.15, 0.1, 0.02];
        for (block, cross_flow) in [(1, -0.3), (4, -0.3), (5, 0.0)] {
            let record = Comparisons::new(&samples, block);
            let mut theta: Theta = theta;
            theta[CROSS_FLOW] = cross_flow;
            let headings = |theta: &Theta| -> Vec<f64> {
                let start = SwayYawState {
                    heading_rad: theta[HEADING],
                    yaw_rate_rad_s: theta[YAW_RATE],
                    drift_rad: 0.0,
                };
                let states = model_of(theta).simulate(&samples, start);
                let blocks = states.chunks_exact(block);
                let sum =
                    |states: &[SwayYawState]| states.iter().map(|s| s.heading_rad).sum::<f64>();
                blocks.map(|states| sum(states) / block as f64).collect()
            };
            let here = headings(&theta);
            let moved: Vec<[Vec<f64>; 2]> = (0..PARAMETERS)
                .map(|p| {
                    [1e-5, -1e-5].map(|step| {
                        let mut moved = theta;
                        moved[p] += step;
                        headings(&moved)
                    })
                })
                .collect();
            let acting = record.acting(theta[LAG]);
            let mut simulation = Simulation::new(&theta, cross_flow == 0.0);
            let mut worst = [0.0_f64; COLUMNS];
            let mut largest = [0.0_f64; COLUMNS];
            for (k, (comparison, rudder)) in record.all.iter().zip(&*acting).enumerate() {
                let (row, _) = simulation.pass(comparison, rudder);
                worst[PARAMETERS] = worst[PARAMETERS].max((row[PARAMETERS] + here[k]).abs());
                for p in 0..PARAMETERS {
                    let expected = (moved[p][0][k] - moved[p][1][k]) / 2e-5;
                    worst[p] = worst[p].max((row[p] - expected).abs());
                    largest[p] = largest[p].max(expected.abs());
                }
            }
            // Of a heading that moves by a radian; derivatives of the simulation at each sample jump where the drift changes its sign.
            assert!(worst[PARAMETERS] < 1e-5, "{block} {worst:?}");
            for p in (0..PARAMETERS).filter(|p| *p != CROSS_FLOW || cross_flow != 0.0) {
                assert!(
                    worst[p] < 3e-3 * largest[p],
                    "{block} {p} {worst:?} {largest:?}"
                );
            }
        }
    }
}

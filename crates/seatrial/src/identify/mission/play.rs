//! The play of a rudder that steers.

use super::fit::{Fit, Problem};
use super::record::Legs;
use crate::identify::robust::play::{LIKELIER, PLAYS};
use crate::likelihood::hypothesis::Scale;

/// Steps of the search for the likeliest play: each goes on or, where that is no better, halves the next.
const STEPS: u32 = 8;

/// The play from stop to stop, rad, that makes legs likeliest under the hypothesis of a fit. `None` where a step of scoring with none of several
/// makes them clearly likelier.
pub fn likely_play_rad(legs: &Legs, scale: Scale, fit: &Fit) -> Option<f64> {
    let amplitude_rad = legs.rudder_amplitude_rad();
    let behind = |play_rad: f64, look: &mut dyn FnMut(&Problem) -> Option<Fit>| {
        let legs = &legs.behind_play(play_rad);
        Some((play_rad, look(&Problem::new(legs, scale))?))
    };
    let looks = PLAYS.iter().skip(1).step_by(2).filter_map(|share| {
        let mut cost = f64::INFINITY;
        let first = behind(share * amplitude_rad, &mut |problem| {
            let here = problem.at(fit.hypothesis, &fit.x)?;
            cost = here.cost - problem.next_gain(&here)?;
            Some(here)
        })?;
        Some((cost, first))
    });
    let (cost, first) = looks.min_by(|a, b| a.0.total_cmp(&b.0))?;
    if 2.0 * (fit.cost - cost) <= LIKELIER {
        return None;
    }
    let fitted =
        |play_rad: f64, near: &Fit| behind(play_rad, &mut |p| p.fit(fit.hypothesis, &near.x));
    let mut best = fitted(first.0, &first.1)?;
    let mut step_rad = 0.5 * best.0;
    for _ in 0..STEPS {
        let next = beside(best.0, step_rad, amplitude_rad)
            .filter_map(|play_rad| fitted(play_rad, &best.1))
            .find(|(_, next)| next.cost < best.1.cost);
        match next {
            Some(next) => best = next,
            None => step_rad *= 0.5,
        }
    }
    Some(best.0)
}

/// Plays a step more and a step less: a rudder that moves has play of more than none and of less than its whole way.
fn beside(play_rad: f64, step_rad: f64, amplitude_rad: f64) -> impl Iterator<Item = f64> {
    let steps = [play_rad + step_rad, play_rad - step_rad].into_iter();
    steps.filter(move |play_rad| *play_rad > 0.0 && *play_rad < 2.0 * amplitude_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps down that follow steps down once ended below none, where no fin can be.
    #[test]
    fn regress_no_play_is_none_or_less() {
        let of = |play_rad, step_rad| beside(play_rad, step_rad, 0.1).collect::<Vec<_>>();
        assert_eq!(of(0.1, 0.05), [0.1 + 0.05, 0.1 - 0.05]);
        assert_eq!(of(0.05, 0.05), [0.1]);
        assert_eq!(of(0.18, 0.05), [0.18 - 0.05]);
    }
}

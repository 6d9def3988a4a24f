//! Points of a mixture of normal distributions.

use super::normal::{below, density};

/// A normal distribution and its part in a mixture.
#[derive(Clone, Copy, Debug)]
pub struct Normal {
    /// Weight of the component; all weights add up to 1.
    pub weight: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation, above 0.
    pub deviation: f64,
}

/// Steps of Newton's method, or of halving where that leaves the bracket.
const MOST_STEPS: u32 = 60;

/// A step of this share of the smallest standard deviation ends the search.
const ARRIVED: f64 = 1e-9;

/// The number below which a mixture lies with a probability of `share`.
pub fn point_below_which(share: f64, normals: &[Normal]) -> f64 {
    let ends = |side: f64| {
        normals
            .iter()
            .map(move |n| n.mean + side * 8.0 * n.deviation)
    };
    let mut low = ends(-1.0).fold(f64::INFINITY, f64::min);
    let mut high = ends(1.0).fold(f64::NEG_INFINITY, f64::max);
    let smallest = normals
        .iter()
        .map(|n| n.deviation)
        .fold(f64::INFINITY, f64::min);
    let total: f64 = normals.iter().map(|n| n.weight).sum();
    let mut point = two_deviations_off(share, normals, total).max(low).min(high);
    for _ in 0..MOST_STEPS {
        let mut excess = -share * total;
        let mut slope = 0.0;
        for n in normals {
            let away = (point - n.mean) / n.deviation;
            excess += n.weight * below(away);
            slope += n.weight * density(away) / n.deviation;
        }
        match excess < 0.0 {
            true => low = point,
            false => high = point,
        }
        let newton = point - excess / slope;
        let next = match newton > low && newton < high {
            true => newton,
            false => 0.5 * (low + high),
        };
        let is_there = (next - point).abs() < ARRIVED * smallest;
        point = next;
        if is_there {
            break;
        }
    }
    point
}

/// Two standard deviations of the mixture from its mean, to the side of the share: near where 2.5 % lie beyond.
fn two_deviations_off(share: f64, normals: &[Normal], total: f64) -> f64 {
    let mean_of =
        |of: &dyn Fn(&Normal) -> f64| normals.iter().map(|n| n.weight * of(n)).sum::<f64>() / total;
    let mean = mean_of(&|n| n.mean);
    let variance = mean_of(&|n| n.deviation * n.deviation + (n.mean - mean) * (n.mean - mean));
    mean + 2.0 * (share - 0.5).signum() * variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMALS: [Normal; 3] = [
        Normal {
            weight: 0.7,
            mean: -1.0,
            deviation: 0.1,
        },
        Normal {
            weight: 0.24,
            mean: -0.8,
            deviation: 0.5,
        },
        Normal {
            weight: 0.06,
            mean: 3.0,
            deviation: 2.0,
        },
    ];

    /// Against halving a bracket until nothing is left of it.
    #[test]
    fn exact_points_of_a_mixture() {
        for share in [0.025, 0.35, 0.5, 0.975] {
            let (mut low, mut high) = (-20.0, 20.0);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                let shares = NORMALS.map(|n| n.weight * below((middle - n.mean) / n.deviation));
                match shares.iter().sum::<f64>() < share {
                    true => low = middle,
                    false => high = middle,
                }
            }
            let found = point_below_which(share, &NORMALS);
            // A billionth of the smallest deviation.
            assert!((found - low).abs() < 1e-8, "{share} {found} {low}");
        }
    }

    #[test]
    fn regress_no_mixture_has_no_point() {
        assert!(point_below_which(0.025, &[]).is_nan());
    }
}

//! Rudder manoeuvres that excite the yaw dynamics.

use crate::{List, Real};

/// Two instants closer than this are the same one, s: clocks that count from 1970 resolve 0.24 us.
pub const CLOCK_RESOLUTION_S: f64 = 1e-6;

/// Most tones of a multisine.
pub const MULTISINE_TONES: u8 = 16;

/// Most deflections of a switched manoeuvre.
pub const DEFLECTIONS: usize = 8;

/// A rudder manoeuvre as a function of the time since its start.
///
/// ```text
/// doublet         +A for P/2, -A for P/2                             (Section IV-B)
/// 3-2-1-1         +A for 3 U, -A for 2 U, +A for U, -A for U
/// switched        +A for D1, -A for D2, +A for D3, ...
/// multisine       A/c sqrt(2/n) sum_k cos(2 pi k t/P - pi k (k-1)/n),  k = 1..n
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | A | `amplitude_rad` | rad | the first deflection; a negative one mirrors the manoeuvre |
/// | P | `period_s` | s | |
/// | U | `unit_s` | s | |
/// | D1, D2, ... | `deflections_s` | s | |
/// | n | `tones` | 1 to [`MULTISINE_TONES`] | |
/// | c | | 1 | above the largest crest factor of these sums, 2.142 |
///
/// The phases of the multisine are Schroeder's (IEEE Trans. Inf. Theory 16, 1970), which keep its
/// peak low; no sum exceeds A.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Excitation<T> {
    /// One deflection to each side.
    Doublet {
        /// A, rad.
        amplitude_rad: T,
        /// P, s.
        period_s: f64,
    },
    /// Four deflections of 3, 2, 1 and 1 units: a wider band than the doublet's.
    ThreeTwoOneOne {
        /// A, rad.
        amplitude_rad: T,
        /// U, s.
        unit_s: f64,
    },
    /// Deflections to alternating sides, each of its own length.
    Switched {
        /// A, rad.
        amplitude_rad: T,
        /// D1, D2, ..., s.
        deflections_s: List<f64, DEFLECTIONS>,
    },
    /// A sum of cosines at multiples of 1/P.
    Multisine {
        /// A, rad.
        amplitude_rad: T,
        /// P, s.
        period_s: f64,
        /// n.
        tones: u8,
    },
}

const LARGEST_CREST_FACTOR: f64 = 2.15;

impl<T: Real> Excitation<T> {
    /// A, rad: no deflection is larger.
    ///
    /// ```
    /// use seatrial_core::Excitation;
    ///
    /// let to_port_first = Excitation::ThreeTwoOneOne { amplitude_rad: -0.2, unit_s: 1.0 };
    /// assert_eq!(to_port_first.amplitude_rad(), -0.2);
    /// ```
    pub fn amplitude_rad(&self) -> T {
        match *self {
            Self::Doublet { amplitude_rad, .. }
            | Self::ThreeTwoOneOne { amplitude_rad, .. }
            | Self::Switched { amplitude_rad, .. }
            | Self::Multisine { amplitude_rad, .. } => amplitude_rad,
        }
    }

    /// From the first deflection to the return to neutral, s.
    ///
    /// ```
    /// use seatrial_core::{Excitation, List};
    ///
    /// assert_eq!(Excitation::ThreeTwoOneOne { amplitude_rad: 0.2, unit_s: 1.5 }.duration_s(), 10.5);
    /// let deflections_s = List::from_slice(&[2.0, 1.0, 0.5]).unwrap_or_default();
    /// assert_eq!(Excitation::Switched { amplitude_rad: 0.2, deflections_s }.duration_s(), 3.5);
    /// ```
    pub fn duration_s(&self) -> f64 {
        match *self {
            Self::Doublet { period_s, .. } | Self::Multisine { period_s, .. } => period_s,
            Self::ThreeTwoOneOne { unit_s, .. } => 7.0 * unit_s,
            Self::Switched { deflections_s, .. } => deflections_s.iter().sum(),
        }
    }

    /// The instants at which the rudder jumps, s since the start, the return to neutral included.
    ///
    /// ```
    /// use seatrial_core::Excitation;
    ///
    /// let manoeuvre = Excitation::ThreeTwoOneOne { amplitude_rad: 0.2, unit_s: 1.0 };
    /// let times_s: Vec<f64> = manoeuvre.switching_times_s().collect();
    /// assert_eq!(times_s, [0.0, 3.0, 5.0, 6.0, 7.0]);
    /// ```
    pub fn switching_times_s(&self) -> impl Iterator<Item = f64> + use<T> {
        let deflections_s = self.deflections_s();
        let jumps = deflections_s.len() + 1;
        (0..jumps).map(move |jump| deflections_s.iter().take(jump).sum())
    }

    /// The time scale on which the manoeuvre turns the vehicle one way, s: the longest deflection of
    /// the stepped manoeuvres, half the longest tone of the multisine.
    ///
    /// ```
    /// use seatrial_core::Excitation;
    ///
    /// assert_eq!(Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 }.longest_deflection_s(), 2.0);
    /// assert_eq!(
    ///     Excitation::ThreeTwoOneOne { amplitude_rad: 0.26, unit_s: 1.0 }.longest_deflection_s(),
    ///     3.0
    /// );
    /// ```
    pub fn longest_deflection_s(&self) -> f64 {
        match *self {
            Self::Multisine { period_s, .. } => period_s / 2.0,
            _ => self.deflections_s().iter().copied().fold(0.0, f64::max),
        }
    }

    /// The rudder at a time since the start, rad. `None` before the start and after the end.
    ///
    /// ```
    /// use seatrial_core::Excitation;
    ///
    /// let doublet = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
    /// assert_eq!([0.0, 1.9, 2.0].map(|s| doublet.rudder_rad(s)), [Some(0.26), Some(0.26), Some(-0.26)]);
    /// assert_eq!([-0.1, 4.0].map(|s| doublet.rudder_rad(s)), [None, None]);
    /// ```
    pub fn rudder_rad(&self, elapsed_s: f64) -> Option<T> {
        let elapsed_s = elapsed_s + CLOCK_RESOLUTION_S;
        // Written so that NaN is outside too.
        if !(elapsed_s >= 0.0 && elapsed_s < self.duration_s()) {
            return None;
        }
        if let Self::Multisine { amplitude_rad, period_s, tones } = *self {
            return Some(schroeder_sum(T::of(elapsed_s / period_s), tones) * amplitude_rad);
        }
        let jumps_so_far =
            self.switching_times_s().take_while(|jump_s| elapsed_s >= *jump_s).count();
        let is_first_side = jumps_so_far % 2 == 1;
        Some(if is_first_side { self.amplitude_rad() } else { -self.amplitude_rad() })
    }

    /// Is every value finite, every duration positive, the number of tones in range?
    ///
    /// ```
    /// use seatrial_core::Excitation;
    ///
    /// assert!(Excitation::Multisine { amplitude_rad: 0.2, period_s: 20.0, tones: 16 }.is_valid());
    /// assert!(!Excitation::Multisine { amplitude_rad: 0.2, period_s: 20.0, tones: 17 }.is_valid());
    /// assert!(!Excitation::Doublet { amplitude_rad: 0.2, period_s: 0.0 }.is_valid());
    /// ```
    pub fn is_valid(&self) -> bool {
        let tones_valid = match *self {
            Self::Multisine { tones, .. } => (1..=MULTISINE_TONES).contains(&tones),
            _ => true,
        };
        let duration_s = self.duration_s();
        self.amplitude_rad().is_finite()
            && duration_s.is_finite()
            && duration_s > 0.0
            && self.deflections_s().iter().all(|length_s| *length_s > 0.0)
            && tones_valid
    }

    /// The lengths of the deflections to alternating sides, s; one for the whole multisine.
    fn deflections_s(&self) -> List<f64, DEFLECTIONS> {
        let lengths = |lengths_s: &[f64]| List::from_slice(lengths_s).unwrap_or_default();
        match *self {
            Self::Doublet { period_s, .. } => lengths(&[period_s / 2.0, period_s / 2.0]),
            Self::ThreeTwoOneOne { unit_s, .. } => {
                lengths(&[3.0 * unit_s, 2.0 * unit_s, unit_s, unit_s])
            }
            Self::Switched { deflections_s, .. } => deflections_s,
            Self::Multisine { period_s, .. } => lengths(&[period_s]),
        }
    }
}

/// sqrt(2/n)/c sum_k cos(2 pi k x - pi k (k-1)/n), within -1..=1.
fn schroeder_sum<T: Real>(x: T, tones: u8) -> T {
    let n = T::of(f64::from(tones));
    let sum: T = (1..=tones)
        .map(|tone| {
            let k = T::of(f64::from(tone));
            let phase = T::PI * k * (k - T::ONE) / n;
            ((T::PI + T::PI) * k * x - phase).cos()
        })
        .sum();
    (T::of(2.0) / n).sqrt() / T::of(LARGEST_CREST_FACTOR) * sum
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn exact_doublet_is_the_papers() {
        let doublet = Excitation::Doublet { amplitude_rad: 0.26, period_s: 4.0 };
        for (elapsed_s, rudder_rad) in [
            (-0.05, None),
            (0.0, Some(0.26)),
            (1.95, Some(0.26)),
            (2.0, Some(-0.26)),
            (3.95, Some(-0.26)),
            (4.0, None),
            (f64::NAN, None),
        ] {
            assert_eq!(doublet.rudder_rad(elapsed_s), rudder_rad, "at {elapsed_s}");
        }
        assert_eq!(doublet.switching_times_s().collect::<Vec<_>>(), [0.0, 2.0, 4.0]);
    }

    #[test]
    fn exact_three_two_one_one() {
        let manoeuvre = Excitation::ThreeTwoOneOne { amplitude_rad: 0.1_f32, unit_s: 0.5 };
        let at = [0.0, 1.4, 1.5, 2.4, 2.5, 2.9, 3.0, 3.4, 3.5]
            .map(|t| manoeuvre.rudder_rad(t).unwrap_or(0.0));
        assert_eq!(at, [0.1, 0.1, -0.1, -0.1, 0.1, 0.1, -0.1, -0.1, 0.0]);
        assert_eq!(manoeuvre.switching_times_s().collect::<Vec<_>>(), [0.0, 1.5, 2.5, 3.0, 3.5]);
    }

    #[test]
    fn exact_switched_is_the_doublet_and_the_3_2_1_1_of_its_lengths() {
        let switched = |lengths_s: &[f64]| Excitation::Switched {
            amplitude_rad: 0.1,
            deflections_s: List::from_slice(lengths_s).unwrap(),
        };
        let three_two_one_one = Excitation::ThreeTwoOneOne { amplitude_rad: 0.1, unit_s: 0.5 };
        let doublet = Excitation::Doublet { amplitude_rad: 0.1, period_s: 4.0 };
        for (switched, other) in
            [(switched(&[1.5, 1.0, 0.5, 0.5]), three_two_one_one), (switched(&[2.0, 2.0]), doublet)]
        {
            for k in -2..100 {
                let elapsed_s = f64::from(k) * 0.05;
                assert_eq!(switched.rudder_rad(elapsed_s), other.rudder_rad(elapsed_s));
            }
            assert_eq!(switched.duration_s(), other.duration_s());
            assert_eq!(switched.longest_deflection_s(), other.longest_deflection_s());
        }
        for wrong in [&[][..], &[1.0, 0.0], &[1.0, -0.5, 2.0], &[f64::NAN]] {
            assert!(!switched(wrong).is_valid(), "{wrong:?}");
        }
    }

    /// A clock that counts from 1970 must not delay a switch by one sample.
    #[test]
    fn exact_switching_with_an_epoch_clock() {
        let doublet = Excitation::Doublet { amplitude_rad: 1.0, period_s: 4.0 };
        let start_s = 1_800_000_000.1_f64;
        let signs: Vec<f64> = (0..=80)
            .filter_map(|k| doublet.rudder_rad(start_s + f64::from(k) * 0.05 - start_s))
            .collect();
        assert_eq!(signs.iter().filter(|s| **s == 1.0).count(), 40);
        assert_eq!(signs.iter().filter(|s| **s == -1.0).count(), 40);
    }

    #[test]
    fn prop_multisine_stays_within_its_amplitude_and_has_no_mean() {
        for tones in 1..=MULTISINE_TONES {
            let manoeuvre = Excitation::Multisine { amplitude_rad: 0.2, period_s: 8.0, tones };
            let rudder: Vec<f64> =
                (0..4000).filter_map(|k| manoeuvre.rudder_rad(f64::from(k) * 0.002)).collect();
            let peak = rudder.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            // Never above the amplitude; the crest factors of 1 to 16 tones span 1.41 to 2.14.
            assert!((0.65 * 0.2..=0.2).contains(&peak), "{tones}: {peak}");
            // Whole periods: the mean is the rounding of 4000 terms.
            assert!((rudder.iter().sum::<f64>() / 4000.0).abs() < 1e-6);
        }
    }
}

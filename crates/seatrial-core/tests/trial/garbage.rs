//! Whatever arrives.

use proptest::prelude::*;
use seatrial_core::{Plan, Sample, Steering, Trial};

use super::scripted::Scripted;

/// Numbers that a broken sensor or link may send.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -4.0..4.0_f64,
        1 => -1e30..1e30_f64,
        1 => prop::sample::select(vec![0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, f64::MAX]),
    ]
}

fn garbage() -> impl Strategy<Value = Sample<f64>> {
    (
        prop_oneof![20 => 0.0..0.1_f64, 1 => number()],
        number(),
        number(),
        prop::option::of(number()),
        prop::option::of(number()),
    )
        .prop_map(|(time_s, heading_rad, rudder_rad, speed, other)| Sample {
            time_s,
            heading_rad,
            rudder_rad,
            surge_speed_m_s: speed,
            depth_m: other,
            north_m: other,
            east_m: speed,
            ..Sample::default()
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever arrives, no rudder above the limit is commanded, and what is over stays over.
    #[test]
    fn prop_garbage_never_moves_the_rudder_beyond_its_limit(
        samples in prop::collection::vec((garbage(), 0..20_u32), 1..60),
        limits in any::<bool>(),
    ) {
        let mut plan = Plan::paper();
        if !limits {
            // Wide limits let the garbage through to the manoeuvres.
            plan.envelope.depth_min_m = -1e300;
            plan.envelope.depth_max_m = 1e300;
            plan.envelope.heading_excursion_max_rad = 3.1;
            plan.envelope.speed_drift_max = 1e300;
            plan.envelope.stale_after_s = 1e9;
            plan.settle.at_most_s = 10.0;
        }
        let mut trial = Trial::new(plan).unwrap();
        let mut vehicle = Scripted::new(1.08);
        let mut ended = None;
        for (bad, good) in samples {
            let mut good_samples: Vec<_> = (0..good * 5).map(|_| vehicle.next_sample()).collect();
            let time_s = vehicle.time_s + bad.time_s;
            good_samples.push(Sample { time_s, ..bad });
            for sample in good_samples {
                let action = trial.step(&sample);
                vehicle.asked = Some(action.steering);
                if let Steering::Rudder(rudder_rad) = action.steering {
                    prop_assert!(rudder_rad.abs() <= plan.rudder_limit_rad);
                }
                if let Some(thrust) = action.thrust {
                    prop_assert!(thrust > 0.0 && thrust <= 1.0);
                }
                if ended.is_some() {
                    prop_assert_eq!(trial.outcome(), ended);
                }
                ended = trial.outcome();
                while trial.take_event().is_some() {}
            }
        }
    }
}

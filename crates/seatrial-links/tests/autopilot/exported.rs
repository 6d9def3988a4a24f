//! Parameters that a trial gives back to its autopilot.

use seatrial::campaign::{Campaign, FullRudder};
use seatrial::gains::export::{Parameter, VehicleType, ardupilot, px4};
use seatrial_app::conduct::conduct;
use seatrial_app::models::{Models, TuningPoint};
use seatrial_core::{Excitation, Plan};
use seatrial_links::autopilot::Settings;

use super::sea::{FULL_RUDDER_RAD, Sea, Weather};
use super::{Witness, about, calm, plan, settings, taken_with};

/// The plan with this much more rudder, so that the steering, and with it the record, is the same to rounding.
fn plan_of(factor: f64) -> Plan<f64> {
    let doublet = |amplitude_rad: f64| Excitation::Doublet {
        amplitude_rad: factor * amplitude_rad,
        period_s: 4.0,
    };
    let mut plan = plan();
    plan.rudder_limit_rad *= factor;
    plan.training.excitation = doublet(0.26);
    plan.validation.excitation = doublet(0.15);
    plan
}

/// The models of a trial on the same boat whose full steering is taken for this angle.
fn models(full_rudder_deg: f64, plan: Plan<f64>) -> Models {
    let full_rudder = FullRudder { angle_rad: full_rudder_deg.to_radians(), is_assumed: true };
    let settings = Settings { full_rudder_rad: full_rudder.angle_rad, ..settings() };
    let (mut autopilot, _) = taken_with(Sea::new(calm(), Weather::default(), 1), settings);
    let about = Campaign {
        vehicle: "mavlink:udp:0.0.0.0:14550".into(),
        rudder_limit_rad: plan.rudder_limit_rad,
        full_rudder: Some(full_rudder),
        ..about()
    };
    let conducted = conduct(&mut autopilot, plan, about, &mut Witness::default()).unwrap();
    Models::of_trial("trial".into(), &conducted.campaign).unwrap()
}

fn parameters(
    models: &Models,
    export: fn(&seatrial::gains::export::OperatingPoint, VehicleType) -> Vec<Parameter>,
    vehicle: VehicleType,
) -> Vec<Parameter> {
    let tuned = TuningPoint::from(models.points.last().unwrap());
    let point = models.operating_point(&tuned, std::f64::consts::FRAC_1_SQRT_2);
    export(&point.unwrap(), vehicle)
}

/// Steering from -1 to 1 does what it does, whatever angle it is taken for.
#[test]
fn parity_parameters_do_not_depend_on_the_angle_that_was_assumed() {
    let of_the_boat = models(FULL_RUDDER_RAD.to_degrees(), plan());
    for full_rudder_deg in [35.0_f64, 60.0] {
        let scaled = plan_of(full_rudder_deg.to_radians() / FULL_RUDDER_RAD);
        let found = models(full_rudder_deg, scaled);
        for (export, vehicle) in [
            (ardupilot::parameters as fn(&_, _) -> _, VehicleType::Surface),
            (ardupilot::parameters, VehicleType::Underwater),
            (px4::parameters, VehicleType::Underwater),
        ] {
            let expected = parameters(&of_the_boat, export, vehicle);
            let found = parameters(&found, export, vehicle);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                // The 1 %.
                let error = (found.value - expected.value).abs();
                assert!(
                    error <= 0.01 * expected.value.abs(),
                    "{full_rudder_deg} deg: {} {} for {}",
                    found.name,
                    found.value,
                    expected.value
                );
            }
        }
    }
}

/// The limits of a turn under full rudder are said to be extrapolated where the trial kept its rudder within less.
#[test]
fn exact_limits_beyond_the_trial_say_so() {
    let found = models(60.0, plan());
    let limits = parameters(&found, ardupilot::parameters, VehicleType::Surface);
    for name in ["ATC_STR_RAT_MAX", "ATC_TURN_MAX_G"] {
        let limit = limits.iter().find(|limit| limit.name == name).unwrap();
        let seen = limit.seen.expect("the trial's rudder went to a sixth of full");
        assert!(seen < 0.25 * limit.value, "{name}: {seen} of {}", limit.value);
    }
    let tuned = TuningPoint::from(found.points.last().unwrap());
    let point = found.operating_point(&tuned, 0.7).unwrap();
    let file = ardupilot::param_file(&point, VehicleType::Surface);
    assert!(file.contains("EXTRAPOLATED to full rudder: in the record"), "{file}");
    assert!(file.contains("ASSUMED to be 60.0 degrees"), "{file}");
}

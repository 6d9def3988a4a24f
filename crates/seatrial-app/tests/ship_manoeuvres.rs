//! The manoeuvres that are predicted from a vehicle's equations, against closed forms.

use seatrial::sea_trials::ship_manoeuvres::Index;
use seatrial_app::file_form::{FileForm, Row};
use seatrial_app::ship_trials::{ManoeuvreRequest, predicted};
use seatrial_app::vehicle_export::{Form, file};
use seatrial_sim::IdentifiedVehicle;
use seatrial_sim::identified::{IdentifiedSpeed, Provenance, Rudder, SCHEMA, SurgeLaw};

fn figures(vehicle: &IdentifiedVehicle) -> Vec<Index> {
    let wanted = ManoeuvreRequest {
        thrust: None,
        length_m: None,
        draws: 0,
        seed: 1,
        zig_zag_rad: None,
        own_error: None,
    };
    predicted(vehicle, &wanted).unwrap().indices
}

fn value(figures: &[Index], manoeuvre: &str, name: &str) -> f64 {
    let mut found = figures.iter();
    let found = found.find(|i| i.manoeuvre.starts_with(manoeuvre) && i.name == name);
    found.unwrap_or_else(|| panic!("{manoeuvre}: {name}")).value
}

fn boat(b2_per_s2: f64, lag_s: f64) -> IdentifiedVehicle {
    IdentifiedVehicle {
        schema: SCHEMA.into(),
        name: "boat".into(),
        sample_interval_s: None,
        rudder: Rudder { limit_rad: 0.6, lag_s, delay_s: 0.0, rate_limit_rad_s: None },
        surge: SurgeLaw { time_constant_s: 3.0, drag_length_m: None, turning_drag_m: None },
        noise: None,
        speeds: vec![IdentifiedSpeed {
            thrust: 0.8,
            surge_speed_m_s: 1.6,
            a22_per_s: -0.9,
            b2_per_s2,
            c0_rad_per_s2: 0.0,
            covariance: None,
            seen_rudder_rad: None,
        }],
        provenance: Provenance::default(),
    }
}

/// r' = a r + b d in closed form: with A the rate that the rudder steers to, the swing after an order over at the rate r goes on by
/// r T - A T ln(1 + r/A), to its peak T ln(1 + r/A) later.
#[test]
fn exact_a_first_order_zig_zag_overshoots_by_its_formula() {
    let boat = boat(1.2, 0.0);
    let found = figures(&boat);
    let (time_s, rate) = (1.0 / 0.9, 1.2 / 0.9);
    for degrees in [10_f64, 20.0] {
        let value = |name: &str| value(&found, &format!("zig-zag {degrees:.0}/"), name);
        let angle = degrees.to_radians();
        let towards = rate * angle;
        // The heading after t from straight ahead is A (t - T (1 - e^{-t/T})): solved for the first order over.
        let heading = |t: f64| towards * (t + time_s * (-t / time_s).exp_m1());
        let (mut low, mut high) = (0.0, 100.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if heading(middle) < angle { low = middle } else { high = middle }
        }
        let at_order = towards * -(-low / time_s).exp_m1();
        let peak_s = time_s * (1.0 + at_order / towards).ln();
        let overshoot = at_order * time_s - towards * peak_s;
        // Fifty steps a time constant: the track's highest instant is within (1/100 T)^2/2 of the peak's curvature.
        assert!((value("initial turning time") / low - 1.0).abs() < 1e-4);
        assert!(
            (value("first overshoot angle").to_radians() / overshoot - 1.0).abs() < 1e-2,
            "{overshoot}"
        );
        let way = value("initial turning track");
        assert!((way / (1.6 * low) - 1.0).abs() < 1e-2, "{way}");
    }
}

/// Reversing the rudder's sense changes nothing.
#[test]
fn exact_a_reversed_rudder_makes_the_same_manoeuvres() {
    let [found, reversed] = [1.2, -1.2].map(|b2| figures(&boat(b2, 0.2)));
    for (a, b) in found.iter().zip(&reversed) {
        // Rounding.
        assert!((a.value - b.value).abs() <= 1e-9 * a.value.abs().max(1.0), "{a:?} {b:?}");
    }
    assert_eq!(found.len(), reversed.len());
}

/// Without thrust the speed falls as e^{-t/T}: to a fifth after T ln 5, over 0.8 u T.
#[test]
fn exact_an_inertia_stop_of_linear_drag() {
    let found = figures(&boat(1.2, 0.0));
    let value = |name: &str| value(&found, "inertia stop", name);
    // Up to a step of 1/50 of the yaw's time constant late.
    assert!((value("time") / (3.0 * 5_f64.ln()) - 1.0).abs() < 0.01);
    assert!((value("track reach") / (0.8 * 1.6 * 3.0) - 1.0).abs() < 0.01);
}

/// A vehicle that is not stable on its course, or hardly, neither panics nor hangs.
#[test]
fn exact_a_vehicle_without_figures_is_refused() {
    let wanted = ManoeuvreRequest {
        thrust: None,
        length_m: Some(100.0),
        draws: 0,
        seed: 1,
        zig_zag_rad: None,
        own_error: None,
    };
    for a22_per_s in [0.0, 0.3] {
        let mut vehicle = boat(1.2, 0.0);
        vehicle.speeds[0].a22_per_s = a22_per_s;
        let message = predicted(&vehicle, &wanted).unwrap_err().to_string();
        assert!(message.contains("not stable on its course"), "{message}");
    }
    let mut vehicle = boat(1.2, 0.0);
    vehicle.speeds[0].a22_per_s = -1e3;
    assert!(predicted(&vehicle, &wanted).is_ok());
}

/// A name of any characters is an identifier and ends no comment in the files of every target.
#[test]
fn exact_names_are_harmless_in_every_target() {
    let mut vehicle = boat(1.2, 0.1);
    vehicle.name = "3rd\"\"\" --> */ \n boat".into();
    let text = |form, thrust| {
        file(&vehicle, form, thrust).map(|(bytes, _)| String::from_utf8(bytes).unwrap())
    };
    for &Row { form, name, .. } in Form::ALL {
        assert_eq!(Form::named(name), Some(form));
        // The vehicle file quotes by its own rules, and a FMU is no text.
        if [Form::Toml, Form::Json, Form::Fmu].contains(&form) {
            continue;
        }
        let file = text(form, None).unwrap();
        assert!(!file.contains("3rd\"") && !file.contains("\n boat"), "{file}");
        let places = file.split('@').skip(1);
        let is_left = |part: &str| part.starts_with(|c: char| c.is_ascii_uppercase());
        assert!(!places.into_iter().any(is_left), "{file}");
    }
    let sdf = text(Form::Gazebo, None).unwrap();
    let (_, comment) = sdf.split_once("<!--").unwrap();
    let (comment, _) = comment.split_once("-->").unwrap();
    assert!(comment.contains("boat") && !comment.contains("--"), "{comment}");
    let program = text(Form::Python, None).unwrap();
    assert!(program.contains("NAME = \"vehicle_3rd"), "{program}");
    let program = text(Form::ControlSystems, None).unwrap();
    let head = program.lines().take_while(|line| !line.starts_with("using"));
    assert!(head.clone().count() > 3 && head.clone().all(|line| line.starts_with('#')));
    for number in [
        "vehicle_b2_per_s2 = [1.2]",
        "vehicle_rudder_rate_rad_s = Inf",
        "vehicle_rudder_lag_s = 0.1\n",
    ] {
        assert!(program.contains(number), "{number}: {program}");
    }
    assert!(text(Form::Gazebo, Some(1.5)).is_err());
}

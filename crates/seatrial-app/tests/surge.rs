//! The surge model of a trial against the simulated vehicle, and what a schedule makes of it.

use seatrial::Campaign;
use seatrial::motions::surge::SurgeModel;
use seatrial_app::conduct::{NoWatch, conduct};
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{Plan, SchedulePoint, SpeedSchedule};
use seatrial_sim::six_dof::{equivalent, remus100, starfish};
use seatrial_sim::{SixDofConfig, SixDofVehicle};

fn campaign(config: SixDofConfig, seed: u64) -> Campaign {
    let mut vehicle = SixDofVehicle::new(config, seed).unwrap();
    let about = Campaign { seed: Some(seed), ..Campaign::of("sim", &Plan::paper()) };
    conduct(&mut vehicle, Plan::paper(), about, &mut NoWatch).unwrap().campaign
}

/// Time in which u' = (u_s^2 - u^2)/l makes 63 % of the change from 60 % thrust to full.
fn to_63_percent_s(surge: &SurgeModel) -> f64 {
    let full = surge.speed_m_s(1.0);
    let before = surge.speed_m_s(0.6) / full;
    let reached = before + (1.0 - (-1.0_f64).exp()) * (1.0 - before);
    let way = (reached - before) / (1.0 - before * reached);
    way.atanh() * surge.drag_length_m.unwrap() / full
}

#[test]
fn recover_speed_over_thrust_and_its_time_constant() {
    for (config, dead_band) in [(starfish::config(), 0.205), (remus100::config(), 0.0)] {
        for seed in 1..4 {
            let surge = SurgeModel::of(&campaign(config.clone(), seed)).unwrap();
            let at_full = surge.speed_m_s(1.0);
            let truth_s = equivalent::surge_time_constant_s(&config).unwrap();
            let found_s = to_63_percent_s(&surge);
            println!("{} {seed}: {surge:.3?}, {found_s:.2} s against {truth_s:.2} s", config.name);
            // Speed is linear in the setting beyond its dead band; linear damping bends it by a per cent.
            assert!(surge.rms_residual_m_s < 0.01 * at_full, "{surge:?}");
            assert!((surge.dead_band - dead_band).abs() < 0.03, "{surge:?}");
            // The lag of the screw, 1 s, makes a change of 40 % last longer than the changes of 10 % tell: 12 and 19 %.
            assert!((found_s / truth_s - 1.0).abs() < 0.25, "{found_s} {truth_s}");
        }
    }
}

/// Asked by thrust or by the speed that the thrust gives, a schedule answers alike.
#[test]
fn recover_schedules_by_thrust_and_by_speed_agree() {
    for config in [starfish::config(), remus100::config()] {
        let campaign = campaign(config, 1);
        let surge = SurgeModel::of(&campaign).unwrap();
        let points: Vec<SchedulePoint<f64>> = campaign
            .accepted_runs()
            .iter()
            .map(|run| SchedulePoint {
                thrust: Some(run.thrust),
                surge_speed_m_s: Some(surge.speed_m_s(run.thrust)),
                model: run.identification.as_ref().unwrap().model(),
            })
            .collect();
        let by = |key| SpeedSchedule::new(key, &points).unwrap();
        let (by_thrust, by_speed) = (by(ScheduleKey::Thrust), by(ScheduleKey::Speed));
        for k in 0..=40 {
            let thrust = 0.6 + 0.01 * f64::from(k);
            let speed = surge.speed_m_s(thrust);
            // The ends round to just outside.
            let at = |schedule: &SpeedSchedule<f64>, at| {
                let found = schedule.lookup(at, Beyond::Extrapolate).unwrap();
                found.value().model.theta()
            };
            for (one, other) in at(&by_thrust, thrust).iter().zip(at(&by_speed, speed)) {
                // Speed is linear in thrust: rounding.
                assert!((one - other).abs() < 1e-9, "{thrust}: {one} {other}");
            }
            assert!((surge.thrust(speed) - thrust).abs() < 1e-12);
        }
    }
}

//! A whole sea trial on a simulated vehicle, kept in a logbook: `cargo run -p seatrial-app --example trial_on_simulator`.
//! Put a vehicle of yours, which implements `TrialVehicle`, in place of the simulator.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::Campaign;
use seatrial_app::TrialPlan;
use seatrial_app::trials::order::{Order, Sinks, begin};
use seatrial_app::trials::simulator::Simulator;
use seatrial_core::{List, Plan};
use seatrial_logbook::Logbook;

fn main() {
    run().unwrap();
}

/// The campaign as the logbook has it.
pub fn run() -> Result<Campaign, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let logbook = folder.path().join("seatrial.db");
    let order = Order {
        // The paper's plan at two of its speeds.
        plan: TrialPlan::from(Plan {
            thrusts: List::from_slice(&[0.6, 0.8]).expect("two speeds"),
            ..Plan::paper()
        })
        .checked()?,
        plan_is_given: true,
        seed: 1,
        configuration: "bare hull".into(),
        notes: None,
        circumstances: Default::default(),
        realtime_factor: None,
        is_agreed: true,
        // Set it from another thread to have the vehicle back.
        stop: Arc::new(AtomicBool::new(false)),
    };
    let sinks = Sinks { logbook: logbook.clone(), ..Sinks::default() };
    let vehicle = Simulator::new("sim:starfish", None)?;
    let ended = begin(&vehicle, order, sinks)?.conduct();
    for why in ended.fault.iter().chain(&ended.unsaved) {
        println!("{why}");
    }
    let campaign = Logbook::open_read_only(&logbook)?.campaign(ended.number)?;
    for run in campaign.accepted_runs() {
        let Some(identification) = &run.identification else {
            continue;
        };
        let model = identification.model();
        println!(
            "thrust {:.0} %: a22 {:.3} 1/s, b2 {:.3} 1/s^2",
            100.0 * run.thrust,
            model.a22_per_s,
            model.b2_per_s2
        );
    }
    Ok(campaign)
}

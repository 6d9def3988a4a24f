//! A vehicle that goes back as soon as its trial is over.

use std::panic::{AssertUnwindSafe, catch_unwind};

use seatrial_core::{AbortReason, Action, Sample, Vehicle};

use super::{VehicleFault, VehicleLease};

/// Hands its vehicle back with the last action of a trial, before the trial judges, keeps or shows anything of its end.
pub(super) struct VehicleLoan {
    vehicle: Box<dyn VehicleLease>,
    /// What could not be put back, once the vehicle was handed back.
    returned: Option<Option<String>>,
}

impl VehicleLoan {
    pub(super) fn new(vehicle: Box<dyn VehicleLease>) -> Self {
        Self { vehicle, returned: None }
    }

    /// Hands the vehicle back unless it was; what could not be put back.
    pub(super) fn hand_back(&mut self) -> Option<String> {
        let vehicle = &mut self.vehicle;
        let returned = self.returned.get_or_insert_with(|| {
            catch_unwind(AssertUnwindSafe(|| vehicle.hand_back()))
                .unwrap_or_else(|_| Some("the hand-back failed: a fault of the program".into()))
        });
        returned.clone()
    }
}

impl Vehicle<f64> for VehicleLoan {
    type Error = VehicleFault;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, VehicleFault> {
        self.vehicle.next_sample()
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), VehicleFault> {
        if self.returned.is_some() {
            return Ok(());
        }
        let acted = self.vehicle.act(action);
        if action.outcome.is_some() {
            self.hand_back();
        }
        acted
    }

    fn is_live(&self) -> bool {
        self.vehicle.is_live()
    }

    fn is_taken_over(&self) -> bool {
        self.vehicle.is_taken_over()
    }

    fn ended_for(&self) -> Option<AbortReason> {
        self.vehicle.ended_for()
    }
}

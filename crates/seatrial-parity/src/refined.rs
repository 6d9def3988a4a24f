//! The refined estimate of a training stage, in double precision.

use core::fmt;

use seatrial_core::refine::{StageRecord, refine};
use seatrial_core::{Action, Steering};

use crate::row::Row;
use crate::vehicle::{INTERVAL_S, Vehicle};

const HEADER: &str = "samples,a22_per_s,b2_per_s2,c0_rad_per_s2,a22_low,a22_high,b2_low,b2_high,\
c0_low,c0_high,p11,p12,p13,p22,p23,p33\n";

/// One sample in this many is kept: double precision in software, on an emulated processor, is slow.
const THINNED: u32 = 4;
const KEPT: usize = 80;

/// Writes the refined estimate of a doublet: one line of bits as in [`write()`](crate::write()).
pub fn write_refined(out: &mut impl fmt::Write) -> fmt::Result {
    let mut vehicle = Vehicle::<f64>::new();
    let mut record = StageRecord::<KEPT>::new(f64::from(THINNED) * INTERVAL_S);
    let mut samples = 0;
    for kept in 0..KEPT {
        let rudder_rad = match kept {
            15..28 => 0.26,
            28..41 => -0.26,
            _ => 0.0,
        };
        vehicle.carry_out(&Action {
            steering: Steering::Rudder(rudder_rad),
            thrust: Some(0.8),
            outcome: None,
        });
        let sample = vehicle.sample();
        if sample.heading_rad.is_finite() && record.push(&sample).is_ok() {
            samples += 1;
        }
        for _ in 1..THINNED {
            vehicle.sample();
        }
    }
    let found = refine(record.series(), None).map_err(|_| fmt::Error)?;
    out.write_str(HEADER)?;
    let mut row = Row::new(out);
    row.number(f64::from(samples))?;
    row.model(&found.model)?;
    for interval in [found.a22_per_s, found.b2_per_s2, found.c0_rad_per_s2] {
        for end in interval {
            row.number(end)?;
        }
    }
    row.upper_triangle(&found.covariance)?;
    row.end()
}

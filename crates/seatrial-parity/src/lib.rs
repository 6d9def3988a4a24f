//! The parity vectors: a rehearsed trial, sample by sample, with what the core must make of it, as bit patterns.
//!
//! One generator for all: the host prints the vectors, the firmware computes them again on a Cortex-M, and Python
//! and C read the samples and compare their own results. [`write()`] says what is in a table.
#![no_std]

mod estimator;
mod fixed_rate;
mod refined;
mod row;
mod trial;
mod vehicle;

use core::fmt;

pub use refined::write_refined;
pub use row::Bits;
pub use trial::rehearse;

/// What is rehearsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// A whole trial of two speeds with spoilt samples: [`seatrial_core::Trial`].
    Trial,
    /// Calls of the guarded estimator: [`seatrial_core::Estimator`].
    Estimator,
    /// Calls of the lean estimator: [`seatrial_core::FixedRateEstimator`].
    FixedRate,
}

impl Table {
    /// All tables.
    pub const ALL: [Self; 3] = [Self::Trial, Self::Estimator, Self::FixedRate];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Trial => "trial",
            Self::Estimator => "estimator",
            Self::FixedRate => "fixed_rate",
        }
    }
}

/// Writes a table: CSV with a header line; numbers as the hexadecimal digits of their bits, most significant
/// first, 16 for times and 16 or 8 for the others (f64 or f32); what is missing is empty.
///
/// | column | meaning |
/// |---|---|
/// | `time_s` to `yaw_rate_rad_s` | the sample that goes in; an absent column or empty field is not measured |
/// | `stage`, `steering`, `steering_rad`, `thrust`, `outcome` | the trial after the sample, and its action |
/// | `call` | which function of the estimator is called: `warm`, `update`, `excitation_ended`, `restart`; `new`, `settle` of the lean one |
/// | `intake` | what it answers: `used`, `warming` or `rejected` |
/// | `a22_per_s`, `b2_per_s2`, `c0_rad_per_s2` | the estimate after the sample or call |
/// | `least_squares_*`, `p11` to `p33` | that of plain least squares and its covariance |
///
/// The trial has the paper's plan at thrusts 0.7 and 0.9; the estimator its default settings; the lean one those of lambda 1.5 rad/s
/// at 0.05 s, with P0 = 100 I at every restart.
pub fn write<T: Bits>(table: Table, out: &mut impl fmt::Write) -> fmt::Result {
    match table {
        Table::Trial => trial::write::<T>(out),
        Table::Estimator => estimator::write::<T>(out),
        Table::FixedRate => fixed_rate::write::<T>(out),
    }
}

/// Writes every table for `f32` and `f64`, each under a line with its name and type, and the refined estimate.
pub fn write_all(out: &mut impl fmt::Write) -> fmt::Result {
    for table in Table::ALL {
        out.write_str("# ")?;
        out.write_str(table.name())?;
        out.write_str(" f32\n")?;
        write::<f32>(table, out)?;
        out.write_str("# ")?;
        out.write_str(table.name())?;
        out.write_str(" f64\n")?;
        write::<f64>(table, out)?;
    }
    out.write_str("# refined f64\n")?;
    write_refined(out)
}

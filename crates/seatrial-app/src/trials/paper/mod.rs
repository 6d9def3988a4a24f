//! The paper's printed tables and claims beside what follows from them.

mod claims;
mod errata;
pub mod recreation;
pub mod tables;

use serde::Serialize;

pub use claims::claims;
pub use errata::{ERRATA, Erratum};

/// A number as printed: its value and the digits after the point (negative: rounded before it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedNumber {
    /// The value.
    pub value: f64,
    /// Digits after the point.
    pub decimals: i32,
}

impl PrintedNumber {
    /// Half a unit of the last digit printed.
    pub fn half_unit(self) -> f64 {
        0.5 * 10_f64.powi(-self.decimals)
    }
}

/// Does the printed number follow from the other printed numbers?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Agreement {
    /// The recomputed value rounds to the printed one.
    Agrees,
    /// The figure follows for some values that the inputs had before they were rounded for print.
    WithinInputRounding,
    /// The figure follows for none of these values.
    Differs,
}

impl Agreement {
    /// As a person reads it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::WithinInputRounding => "within the rounding of its inputs",
            Self::Differs => "DIFFERS",
        }
    }
}

/// One printed number and its recomputation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Table, figure or section.
    pub place: &'static str,
    /// What the number is.
    pub quantity: String,
    /// Its unit.
    pub unit: &'static str,
    /// As printed.
    pub printed: f64,
    /// Digits printed after the point.
    pub decimals: i32,
    /// From the printed inputs as they stand.
    pub recomputed: f64,
    /// From the inputs anywhere within their rounding.
    pub recomputed_range: [f64; 2],
    /// The comparison.
    pub agreement: Agreement,
    /// What to know about it.
    pub note: Option<&'static str>,
}

impl Claim {
    /// Compares a printed number with a formula of other printed numbers.
    ///
    /// The range is taken over the corners of the box in which the inputs lay before rounding, which
    /// is exact for formulas that rise or fall with each input over so small a box.
    fn new(
        place: &'static str,
        quantity: impl Into<String>,
        unit: &'static str,
        printed: PrintedNumber,
        inputs: &[PrintedNumber],
        formula: impl Fn(&[f64]) -> f64,
    ) -> Self {
        let nominal: Vec<f64> = inputs.iter().map(|input| input.value).collect();
        let recomputed = formula(&nominal);
        let mut range = [recomputed, recomputed];
        for corner in 0..1_u32 << inputs.len() {
            let at: Vec<f64> = inputs
                .iter()
                .enumerate()
                .map(|(i, input)| {
                    let upper = corner >> i & 1 == 1;
                    input.value + if upper { 1.0 } else { -1.0 } * input.half_unit()
                })
                .collect();
            let value = formula(&at);
            range = [range[0].min(value), range[1].max(value)];
        }
        // A thousandth of the half unit absorbs binary rounding of values that lie on the edge.
        let half_unit = 1.001 * printed.half_unit();
        let agreement = if (recomputed - printed.value).abs() <= half_unit {
            Agreement::Agrees
        } else if range[0] <= printed.value + half_unit && range[1] >= printed.value - half_unit {
            Agreement::WithinInputRounding
        } else {
            Agreement::Differs
        };
        Self {
            place,
            quantity: quantity.into(),
            unit,
            printed: printed.value,
            decimals: printed.decimals,
            recomputed,
            recomputed_range: range,
            agreement,
            note: None,
        }
    }

    fn noting(self, note: &'static str) -> Self {
        Self { note: Some(note), ..self }
    }
}

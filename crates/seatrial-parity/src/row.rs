//! A line of a table, without the formatting machinery, which can panic.

use core::fmt;

use seatrial_core::{Real, YawModel};

/// A number with its bits.
pub trait Bits: Real {
    /// The bits, right aligned.
    fn bits(self) -> u64;
    /// How many hexadecimal digits they fill.
    const DIGITS: u32;
}

impl Bits for f32 {
    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }
    const DIGITS: u32 = 8;
}

impl Bits for f64 {
    fn bits(self) -> u64 {
        self.to_bits()
    }
    const DIGITS: u32 = 16;
}

/// Fields separated by commas.
pub struct Row<'a, W> {
    out: &'a mut W,
    begun: bool,
}

impl<'a, W: fmt::Write> Row<'a, W> {
    pub fn new(out: &'a mut W) -> Self {
        Self { out, begun: false }
    }

    pub fn text(&mut self, text: &str) -> fmt::Result {
        if self.begun {
            self.out.write_char(',')?;
        }
        self.begun = true;
        self.out.write_str(text)
    }

    pub fn number<T: Bits>(&mut self, number: T) -> fmt::Result {
        self.text("")?;
        for digit in (0..T::DIGITS).rev() {
            let nibble = (number.bits() >> (4 * digit)) & 15;
            let character = char::from_digit(nibble as u32, 16).unwrap_or('?');
            self.out.write_char(character)?;
        }
        Ok(())
    }

    pub fn optional<T: Bits>(&mut self, number: Option<T>) -> fmt::Result {
        match number {
            Some(number) => self.number(number),
            None => self.text(""),
        }
    }

    pub fn model<T: Bits>(&mut self, model: &YawModel<T>) -> fmt::Result {
        for parameter in model.theta() {
            self.number(parameter)?;
        }
        Ok(())
    }

    pub fn upper_triangle<T: Bits>(&mut self, matrix: &[[T; 3]; 3]) -> fmt::Result {
        for (i, row) in matrix.iter().enumerate() {
            for element in row.iter().skip(i) {
                self.number(*element)?;
            }
        }
        Ok(())
    }

    pub fn end(self) -> fmt::Result {
        self.out.write_char('\n')
    }
}

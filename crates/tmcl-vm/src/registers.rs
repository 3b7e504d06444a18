//! Accumulator, X register and the result of the last comparison, and what CALC and CALCX do with them (TMCM-1311 §5.7.16
//! to §5.7.18, §5.7.28; TMCM-1640 §4.6.21 for the descriptions that the first lost).
//!
//! 32-bit two's complement that wraps. Where the manuals are silent it does what a Cortex-M3 does: division by zero gives
//! 0, the remainder by zero leaves the accumulator. The logical operations are bitwise.

use core::cmp::Ordering;

/// The registers of a program; direct mode calculates with the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    /// A.
    pub accumulator: i32,
    /// X.
    pub x: i32,
    /// What JC tests: A against the value of COMP, or against 0 since an instruction wrote A.
    pub comparison: Ordering,
}

impl Default for Registers {
    fn default() -> Self {
        Self { accumulator: 0, x: 0, comparison: Ordering::Equal }
    }
}

impl Registers {
    /// Writes A.
    pub fn load(&mut self, value: i32) {
        self.accumulator = value;
        self.comparison = value.cmp(&0);
    }

    /// COMP.
    pub fn compare(&mut self, value: i32) {
        self.comparison = self.accumulator.cmp(&value);
    }

    /// CALC: the accumulator and a constant. None, and nothing done, when there is no such operation.
    pub fn calculate(&mut self, operation: u8, operand: i32) -> Option<()> {
        self.load(match operation {
            8 => !self.accumulator,
            9 => operand,
            _ => binary(operation, self.accumulator, operand)?,
        });
        Some(())
    }

    /// CALCX: the accumulator and the X register. NOT and LOAD write X only, and leave the comparison alone.
    pub fn calculate_x(&mut self, operation: u8) -> Option<()> {
        match operation {
            8 => self.x = !self.x,
            9 => self.x = self.accumulator,
            10 => {
                let x = self.x;
                self.x = self.accumulator;
                self.load(x);
            }
            _ => self.load(binary(operation, self.accumulator, self.x)?),
        }
        Some(())
    }

    /// Whether condition `kind` of JC, 0 to 7, holds.
    pub(crate) fn holds(&self, kind: u8) -> Option<bool> {
        Some(match kind {
            0 | 2 => self.comparison.is_eq(),
            1 | 3 => self.comparison.is_ne(),
            4 => self.comparison.is_gt(),
            5 => self.comparison.is_ge(),
            6 => self.comparison.is_lt(),
            7 => self.comparison.is_le(),
            _ => return None,
        })
    }
}

fn binary(operation: u8, left: i32, right: i32) -> Option<i32> {
    Some(match operation {
        0 => left.wrapping_add(right),
        1 => left.wrapping_sub(right),
        2 => left.wrapping_mul(right),
        3 if right == 0 => 0,
        3 => left.wrapping_div(right),
        4 if right == 0 => left,
        4 => left.wrapping_rem(right),
        5 => left & right,
        6 => left | right,
        7 => left ^ right,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(accumulator: i32, x: i32) -> Registers {
        Registers { accumulator, x, comparison: Ordering::Equal }
    }

    #[test]
    fn every_operation_of_calc() {
        let cases = [
            (0, 7, 5, 12),
            (0, i32::MAX, 1, i32::MIN),
            (1, 7, 9, -2),
            (2, 1, -5000, -5000),
            (2, 65_536, 65_536, 0),
            (3, -7, 2, -3),
            (3, 7, 0, 0),
            (3, i32::MIN, -1, i32::MIN),
            (4, -7, 2, -1),
            (4, 7, 0, 7),
            (4, i32::MIN, -1, 0),
            (5, 0b1100, 0b1010, 0b1000),
            (6, 0b1100, 0b1010, 0b1110),
            (7, 0b1100, 0b1010, 0b0110),
            (8, 5, 99, -6),
            (9, 5, 99, 99),
        ];
        for (operation, accumulator, operand, expected) in cases {
            let mut registers = with(accumulator, 0);
            assert_eq!(registers.calculate(operation, operand), Some(()));
            assert_eq!(registers.accumulator, expected, "{accumulator} op{operation} {operand}");
            assert_eq!(registers.comparison, expected.cmp(&0), "{accumulator} op{operation} {operand}");
        }
        assert_eq!(with(1, 2).calculate(10, 3), None);
    }

    #[test]
    fn calcx_load_not_and_swap_write_x() {
        let mut registers = with(6, 3);
        registers.calculate_x(2);
        assert_eq!((registers.accumulator, registers.x), (18, 3));
        registers.compare(18);
        registers.calculate_x(9);
        assert_eq!((registers.accumulator, registers.x), (18, 18));
        registers.calculate_x(8);
        assert_eq!((registers.accumulator, registers.x), (18, -19));
        assert_eq!(registers.comparison, Ordering::Equal, "LOAD and NOT leave the comparison");
        registers.calculate_x(10);
        assert_eq!((registers.accumulator, registers.x), (-19, 18));
        assert_eq!(registers.comparison, Ordering::Less, "SWAP writes A");
        assert_eq!(registers.calculate_x(11), None);
    }

    #[test]
    fn conditions_are_those_of_signed_numbers_at_the_ends_too() {
        let mut registers = with(i32::MIN, 0);
        registers.compare(i32::MAX);
        let holding: [Option<bool>; 9] = core::array::from_fn(|kind| registers.holds(kind as u8));
        let [ze, nz, eq, ne, gt, ge, lt, le, none] = holding;
        assert_eq!([ze, eq, gt, ge], [Some(false); 4]);
        assert_eq!([nz, ne, lt, le], [Some(true); 4]);
        assert_eq!(none, None);
    }
}

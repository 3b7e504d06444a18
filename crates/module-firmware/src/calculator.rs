//! The accumulator and the X register, and what CALC and CALCX do with them (TMCM-1311 §5.7.16, §5.7.28; TMCM-1640
//! §4.6.21 for the descriptions that the first lost).
//!
//! 32-bit two's complement that wraps. Where the manuals are silent it does what a Cortex-M3 does: division by zero gives
//! 0, the remainder by zero leaves the accumulator. The logical operations are bitwise.

/// The two registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Registers {
    pub(crate) accumulator: i32,
    pub(crate) x: i32,
}

impl Registers {
    /// CALC: the accumulator and a constant. The type was checked before; an unknown one changes nothing.
    pub(crate) fn calculate(&mut self, operation: u8, operand: i32) {
        self.accumulator = match operation {
            8 => !self.accumulator,
            9 => operand,
            _ => binary(operation, self.accumulator, operand),
        };
    }

    /// CALCX: the accumulator and the X register.
    pub(crate) fn calculate_x(&mut self, operation: u8) {
        match operation {
            8 => self.x = !self.x,
            9 => self.x = self.accumulator,
            10 => core::mem::swap(&mut self.accumulator, &mut self.x),
            _ => self.accumulator = binary(operation, self.accumulator, self.x),
        }
    }
}

fn binary(operation: u8, left: i32, right: i32) -> i32 {
    match operation {
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
        _ => left,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let mut registers = Registers { accumulator, x: 0 };
            registers.calculate(operation, operand);
            assert_eq!(registers.accumulator, expected, "{accumulator} op{operation} {operand}");
        }
    }

    #[test]
    fn calcx_load_not_and_swap_write_x() {
        let mut registers = Registers { accumulator: 6, x: 3 };
        registers.calculate_x(2);
        assert_eq!(registers, Registers { accumulator: 18, x: 3 });
        registers.calculate_x(9);
        assert_eq!(registers, Registers { accumulator: 18, x: 18 });
        registers.calculate_x(8);
        assert_eq!(registers, Registers { accumulator: 18, x: -19 });
        registers.calculate_x(10);
        assert_eq!(registers, Registers { accumulator: -19, x: 18 });
    }
}

//! How fast the rotor turns: the [tachometer](crate::tachometer) as the TMCM-1311 has it.

pub use crate::tachometer::CountRate;

/// It looks back 16 ms, and 100 ms without an edge are standstill (a decision).
pub type Tachometer = crate::tachometer::Tachometer<64, 2000>;

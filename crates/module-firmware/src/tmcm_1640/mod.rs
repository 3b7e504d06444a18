//! The TMCM-1640: one axis for a brushless motor, field-oriented control, hall sensors and encoder.

mod exchange;

pub use exchange::{Drive, PWM_PERIOD, Sensed};
pub use tmcl_tables::tmcm_1640::{AxisParameter, Port};

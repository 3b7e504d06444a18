//! The classical Runge-Kutta step of fourth order.
//!
//! One step a control period is enough: winding time constants are milliseconds, the period is 50 µs, and voltages are held
//! within it, so that nothing inside a step is stiff or jumps.

/// The state after `dt_s` of this slope.
#[inline]
pub(crate) fn moved<const N: usize>(mut state: [f64; N], slope: [f64; N], dt_s: f64) -> [f64; N] {
    for (value, slope) in state.iter_mut().zip(slope) {
        *value += dt_s * slope;
    }
    state
}

/// The mean over a step of what was found at its beginning, twice in its middle, and at its end: of the slopes, or of whatever
/// else depends on nothing but the state.
#[inline]
pub(crate) fn mean<const N: usize>([first, second, third, fourth]: [[f64; N]; 4]) -> [f64; N] {
    let mut mean = first;
    for (((mean, second), third), fourth) in mean.iter_mut().zip(second).zip(third).zip(fourth) {
        *mean = (*mean + 2.0 * (second + third) + fourth) * (1.0 / 6.0);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(state: [f64; 2], dt_s: f64, derivative: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
        let k1 = derivative(state);
        let k2 = derivative(moved(state, k1, 0.5 * dt_s));
        let k3 = derivative(moved(state, k2, 0.5 * dt_s));
        let k4 = derivative(moved(state, k3, dt_s));
        moved(state, mean([k1, k2, k3, k4]), dt_s)
    }

    #[test]
    fn an_oscillator_keeps_its_energy_to_fifth_order() {
        let mut state = [1.0, 0.0];
        for _ in 0..1000 {
            state = step(state, 0.01, |[x, v]| [v, -x]);
        }
        let [x, v] = state;
        assert!((x - libm::cos(10.0)).abs() < 1e-8 && (v + libm::sin(10.0)).abs() < 1e-8);
    }
}

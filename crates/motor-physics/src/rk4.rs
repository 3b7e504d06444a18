//! The classical Runge-Kutta step of fourth order.
//!
//! One step a control period is enough: winding time constants are milliseconds, the period is 50 µs, and voltages are held
//! within it, so that nothing inside a step is stiff or jumps.

/// The state after `dt_s`, with `derivative` giving its rate of change.
pub(crate) fn step<const N: usize>(
    state: [f64; N],
    dt_s: f64,
    derivative: impl Fn([f64; N]) -> [f64; N],
) -> [f64; N] {
    let k1 = derivative(state);
    let k2 = derivative(moved(state, k1, 0.5 * dt_s));
    let k3 = derivative(moved(state, k2, 0.5 * dt_s));
    let k4 = derivative(moved(state, k3, dt_s));
    let mut next = state;
    let slopes = k1.iter().zip(&k2).zip(k3.iter().zip(&k4));
    for (value, ((k1, k2), (k3, k4))) in next.iter_mut().zip(slopes) {
        *value += dt_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    next
}

fn moved<const N: usize>(mut state: [f64; N], slope: [f64; N], dt_s: f64) -> [f64; N] {
    for (value, slope) in state.iter_mut().zip(slope) {
        *value += dt_s * slope;
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

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

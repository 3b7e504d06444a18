//! Three phases, the plane of their space vectors, and the frame that turns with the rotor.
//!
//! Vectors are as long as the phases' amplitude; α points along phase U's axis.

use crate::angle::Direction;

/// √3: between two terminals there is so much more than in a phase.
pub(super) const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// The axes of phases U, V and W.
pub(super) const AXES: [[f64; 2]; 3] = [[1.0, 0.0], [-0.5, 0.5 * SQRT_3], [-0.5, -0.5 * SQRT_3]];

/// The vector of three phase quantities; what they have in common drops out.
pub(super) fn vector_of([u, v, w]: [f64; 3]) -> [f64; 2] {
    [(2.0 * u - v - w) / 3.0, (v - w) / SQRT_3]
}

/// The phase quantities of a vector; their sum is zero.
pub(super) fn phases_of(vector: [f64; 2]) -> [f64; 3] {
    AXES.map(|axis| dot(vector, axis))
}

/// As the direction of the rotor's d axis.
impl Direction {
    /// A vector of the stationary plane, seen from the rotor.
    pub(super) fn to_rotor(self, [alpha, beta]: [f64; 2]) -> [f64; 2] {
        [alpha * self.cosine + beta * self.sine, beta * self.cosine - alpha * self.sine]
    }

    /// A vector of the rotor's frame, seen from the stator.
    pub(super) fn to_stator(self, [d, q]: [f64; 2]) -> [f64; 2] {
        [d * self.cosine - q * self.sine, d * self.sine + q * self.cosine]
    }
}

pub(super) fn dot([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * c + b * d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_and_vectors_are_the_same_thing() {
        let phases = phases_of([3.0, -1.0]);
        assert!(phases.iter().sum::<f64>().abs() < 1e-12);
        let [alpha, beta] = vector_of(phases.map(|phase| phase + 7.0));
        assert!((alpha - 3.0).abs() < 1e-12 && (beta + 1.0).abs() < 1e-12);
        assert!((SQRT_3 - libm::sqrt(3.0)).abs() < 1e-15);
    }

    #[test]
    fn what_turns_with_the_rotor_stands_still_in_its_frame() {
        for angle_rad in [0.0, 1.0, 4.0] {
            let [d, q] =
                Direction::of(angle_rad).to_rotor([2.0 * libm::cos(angle_rad), 2.0 * libm::sin(angle_rad)]);
            assert!((d - 2.0).abs() < 1e-12 && q.abs() < 1e-12);
            let [alpha, beta] = Direction::of(angle_rad).to_stator([0.5, -0.5]);
            let [d, q] = Direction::of(angle_rad).to_rotor([alpha, beta]);
            assert!((d - 0.5).abs() < 1e-12 && (q + 0.5).abs() < 1e-12);
        }
    }
}

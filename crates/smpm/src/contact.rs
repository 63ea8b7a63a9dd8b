//! What bodies with velocities of their own do to each other at a node.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::node::Node;
use crate::number::Number;

/// Contact of two bodies (Bardenhagen et al. 2001): where they approach, an impulse makes their normal velocities equal, and a
/// part of it, at most `coefficient` times as large, acts against their slip. The velocity changes become those with the impulse.
///
/// With velocities `v`, reduced mass `m` and the normal `n` along the gradient of the mass of the first, which points outward,
///
/// $$ J_n = m (v_a - v_b) \cdot n > 0, \qquad J_t = \min(m |v_t|, \mu J_n) $$
#[inline(always)]
pub(crate) fn meet<S: Number, const D: usize>(
    (a, mass_a): (&mut Node<S, D>, S),
    (b, mass_b): (&mut Node<S, D>, S),
    outward: [S; D],
    coefficient: f64,
) {
    let zero = S::constant(0.0);
    let (mut normal, mut square) = (outward, zero);
    for k in 0..D {
        square = square + normal[k].squared();
    }
    if square.value() <= 0.0 {
        return;
    }
    let inverse = square.sqrt().recip();
    let (mut relative, mut approach) = ([zero; D], zero);
    for k in 0..D {
        normal[k] = normal[k] * inverse;
        relative[k] =
            (a.velocity()[k] + a.velocity_change()[k]) - (b.velocity()[k] + b.velocity_change()[k]);
        approach = approach + relative[k] * normal[k];
    }
    if approach.value() <= 0.0 {
        return;
    }
    let (mut slip, mut square) = ([zero; D], zero);
    for k in 0..D {
        slip[k] = relative[k] - approach * normal[k];
        square = square + slip[k].squared();
    }
    let most = coefficient * approach.value();
    // Sticking takes the whole of the relative velocity.
    if square.value() > most * most {
        let share = approach * coefficient / square.sqrt();
        for k in 0..D {
            relative[k] = approach * normal[k] + slip[k] * share;
        }
    }
    let both = (mass_a + mass_b).recip();
    for k in 0..D {
        let (of_a, of_b) = (a.velocity_change()[k], b.velocity_change()[k]);
        a.velocity_change_mut()[k] = of_a - relative[k] * (mass_b * both);
        b.velocity_change_mut()[k] = of_b + relative[k] * (mass_a * both);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Change of the first body and of the momentum of both.
    fn met(velocity: [f64; 2], coefficient: f64) -> ([f64; 2], [f64; 2]) {
        let (mut a, mut b) = (Node::moving(velocity), Node::moving([0.0; 2]));
        // The normal is (0.6, 0.8).
        meet((&mut a, 2.0), (&mut b, 3.0), [0.3, 0.4], coefficient);
        (
            *a.velocity_change(),
            std::array::from_fn(|k| 2.0 * a.velocity_change()[k] + 3.0 * b.velocity_change()[k]),
        )
    }

    #[test]
    fn approach_is_stopped_slip_is_limited_and_parting_is_free() {
        // Approach at 1 and slip at 0.5 along (0.8, -0.6); reduced mass over the first: 0.6.
        let v = [0.6 + 0.4, 0.8 - 0.3];
        for (coefficient, kept) in [(0.0, 0.0), (0.2, 0.2), (0.5, 0.5), (10.0, 0.5)] {
            let (change, momentum) = met(v, coefficient);
            let expected = [-0.6 * (0.6 + 0.8 * kept), -0.6 * (0.8 - 0.6 * kept)];
            for k in 0..2 {
                assert!((change[k] - expected[k]).abs() < 1e-15, "{coefficient}: {change:?}");
                assert!(momentum[k].abs() < 1e-15);
            }
        }
        assert!(met(v.map(|c| -c), 0.3) == ([0.0; 2], [0.0; 2]));
    }
}

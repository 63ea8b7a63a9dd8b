//! Contact of two bodies at a node.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::node::Node;
use crate::number::Number;

/// What a node sees of a body: the share of the volume around it, and its gradient.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface<S, const D: usize> {
    /// `phi = sum_p V_p N_i / h^D`: one inside, a half at a flat surface, zero outside.
    pub(crate) fill: S,
    /// `sum_p V_p grad N_i / h^D`, per cell: it points out of the body.
    pub(crate) outward: [S; D],
}

impl<S: Number, const D: usize> Surface<S, D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let zero = S::constant(0.0);
        Self { fill: zero, outward: [zero; D] }
    }

    /// The unit normal from one body into another, both weighted by the size of their gradients: where a corner meets a flat
    /// surface, the gradient of the corner leans and is the smaller one. `None` where it has no direction.
    #[inline(always)]
    fn normal_into(&self, other: &Self) -> Option<[S; D]> {
        let zero = S::constant(0.0);
        let (mut of_a, mut of_b) = (zero, zero);
        for k in 0..D {
            of_a = of_a + self.outward[k].squared();
            of_b = of_b + other.outward[k].squared();
        }
        let (mut normal, mut square) = ([zero; D], zero);
        for k in 0..D {
            normal[k] = self.outward[k] * of_a - other.outward[k] * of_b;
            square = square + normal[k].squared();
        }
        if square.value() <= 0.0 {
            return None;
        }
        let inverse = square.sqrt().recip();
        for k in 0..D {
            normal[k] = normal[k] * inverse;
        }
        Some(normal)
    }
}

/// Contact of two bodies at a node where no gap is left between them.
///
/// Symbols: `v` = the velocities that particles bring, `dv` = their changes by forces, `m` = the reduced mass, `n` = the normal
/// from `a` to `b`. An approach $(v_a - v_b) \cdot n > 0$ that particles bring is taken from the nodal velocities as a mirror
/// takes it: it is no change over the step, particles do not lose it, and no energy is lost with it. The approach that forces
/// add is an impulse on the particles, and bears friction:
///
/// $$ J_n = m ((v_a - v_b) \cdot n^- + (dv_a - dv_b) \cdot n) > 0, \qquad J_t = \min(m |v_t|, \mu J_n) $$
///
/// with the negative part of what is brought, and the slip `v_t` after the forces. What parts is free.
#[inline(always)]
pub(crate) fn meet<S: Number, const D: usize>(
    (a, mass_a, of_a): (&mut Node<S, D>, S, &Surface<S, D>),
    (b, mass_b, of_b): (&mut Node<S, D>, S, &Surface<S, D>),
    coefficient: f64,
) {
    let Some(normal) = of_a.normal_into(of_b) else { return };
    let zero = S::constant(0.0);
    let (mut relative, mut brought, mut approach) = ([zero; D], zero, zero);
    for k in 0..D {
        let before = a.velocity()[k] - b.velocity()[k];
        relative[k] = before + (a.velocity_change()[k] - b.velocity_change()[k]);
        brought = brought + before * normal[k];
        approach = approach + relative[k] * normal[k];
    }
    let slip = across(&relative, approach, &normal);
    if brought.value() > 0.0 {
        approach = approach - brought;
    } else {
        brought = zero;
    }
    if approach.value() < 0.0 {
        approach = zero;
    }
    let share = friction_share(&slip, approach, coefficient);
    let both = (mass_a + mass_b).recip();
    let (share_a, share_b) = (mass_b * both, mass_a * both);
    for k in 0..D {
        let (taken, lost) = (normal[k] * brought, normal[k] * approach + slip[k] * share);
        a.velocity_mut()[k] = a.velocity()[k] - taken * share_a;
        b.velocity_mut()[k] = b.velocity()[k] + taken * share_b;
        a.velocity_change_mut()[k] = a.velocity_change()[k] - lost * share_a;
        b.velocity_change_mut()[k] = b.velocity_change()[k] + lost * share_b;
    }
}

/// What of a relative velocity is across the normal.
#[inline(always)]
fn across<S: Number, const D: usize>(relative: &[S; D], approach: S, normal: &[S; D]) -> [S; D] {
    let mut slip = *relative;
    for k in 0..D {
        slip[k] = slip[k] - approach * normal[k];
    }
    slip
}

/// The part of the slip that friction takes: all of it where they stick.
#[inline(always)]
fn friction_share<S: Number, const D: usize>(slip: &[S; D], approach: S, coefficient: f64) -> S {
    let mut square = S::constant(0.0);
    for k in 0..D {
        square = square + slip[k].squared();
    }
    let most = coefficient * approach.value();
    if square.value() > most * most {
        approach * coefficient / square.sqrt()
    } else {
        S::constant(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTWARD: Surface<f64, 2> = Surface { fill: 0.5, outward: [0.3, 0.4] };
    const INWARD: Surface<f64, 2> = Surface { fill: 0.5, outward: [-0.3, -0.4] };

    /// What the first body brings and by how much it changes, and the momentum of both, after contact with a body at rest:
    /// from what particles bring to it and what forces do.
    fn met(brought: [f64; 2], forced: [f64; 2], coefficient: f64) -> [[f64; 2]; 3] {
        let (mut a, mut b) = (Node::moving(brought), Node::moving([0.0; 2]));
        *a.velocity_change_mut() = forced;
        // The normal is (0.6, 0.8).
        meet((&mut a, 2.0, &OUTWARD), (&mut b, 3.0, &INWARD), coefficient);
        let momentum = |k: usize| {
            2.0 * (a.velocity()[k] + a.velocity_change()[k])
                + 3.0 * (b.velocity()[k] + b.velocity_change()[k])
        };
        [*a.velocity(), *a.velocity_change(), std::array::from_fn(momentum)]
    }

    fn assert_close(found: [f64; 2], expected: [f64; 2]) {
        let apart = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(apart < 1e-15, "{found:?} {expected:?}");
    }

    #[test]
    fn forces_that_press_are_stopped_and_slip_is_limited() {
        // Approach at 1 and slip at 0.5 along (0.8, -0.6); reduced mass over the first: 0.6.
        let forced = [0.6 + 0.4, 0.8 - 0.3];
        for (coefficient, kept) in [(0.0, 0.0), (0.2, 0.2), (0.5, 0.5), (10.0, 0.5)] {
            let [before, change, momentum] = met([0.0; 2], forced, coefficient);
            assert_close(before, [0.0; 2]);
            let lost = [0.6 * (0.6 + 0.8 * kept), 0.6 * (0.8 - 0.6 * kept)];
            assert_close(change, [forced[0] - lost[0], forced[1] - lost[1]]);
            assert_close(momentum, forced.map(|c| 2.0 * c));
        }
    }

    #[test]
    fn an_approach_that_particles_bring_is_taken_from_the_node_and_not_from_them() {
        let brought = [0.6 + 0.4, 0.8 - 0.3];
        let [before, change, momentum] = met(brought, [0.0; 2], 0.3);
        // No force presses, so there is no friction.
        assert_close(before, [brought[0] - 0.36, brought[1] - 0.48]);
        assert_close(change, [0.0; 2]);
        assert_close(momentum, brought.map(|c| 2.0 * c));
        // Parting: not touched; parting faster than forces press: neither.
        let parting = brought.map(|c| -c);
        assert_eq!(met(parting, [0.0; 2], 0.3)[..2], [parting, [0.0; 2]]);
        let pressed = [0.3, 0.4];
        assert_eq!(met(parting, pressed, 0.3)[..2], [parting, pressed]);
    }

    #[test]
    fn the_normal_does_not_know_which_body_is_first_and_follows_the_flatter_one() {
        let corner = Surface { fill: 0.25, outward: [-0.1, -0.2] };
        let flat = Surface { fill: 0.5, outward: [0.0, 0.75] };
        let (one, other) = (flat.normal_into(&corner).unwrap(), corner.normal_into(&flat).unwrap());
        assert_close(one, other.map(|c| -c));
        // The gradient of the corner leans by 27 degrees, the normal by less than 1.
        assert!(one[0] > 0.0 && one[0] < 0.0175 && one[1] > 0.0, "{one:?}");
        assert!(flat.normal_into(&flat).is_none());
    }
}

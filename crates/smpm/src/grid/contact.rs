//! Contact of two bodies at a node.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::grid::node::Node;
use crate::number::CarriedNumber;

/// Bodies are in contact at a node where they fill at least `1 - MOST_GAP` of the volume around it (no unit).
///
/// Flat surfaces fill all of it once they touch. Strain and the sums over particles move the sum by up to a per cent where bodies
/// press on each other. Without the margin, contact goes off and on there: a block at rest creeps by 1.5 % of free fall. With a
/// margin of 1/20 the leading edge of a block that slides catches.
pub(crate) const MOST_GAP: f64 = 1.0 / 64.0;

/// Friction at the nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Friction {
    /// Coulomb's coefficient (no unit).
    pub(crate) coefficient: f64,
    /// Whether particles take the nodal velocity (APIC), not its change.
    pub(crate) affine: bool,
}

/// Fraction of volume that a body fills around a node, and its gradient.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface<S, const D: usize> {
    /// `phi = sum_p V_p N_i / h^D`: one inside, a half at a flat surface, zero outside.
    pub(crate) fill: S,
    /// `sum_p V_p grad N_i / h^D`, per cell: it points out of the body.
    pub(crate) outward: [S; D],
}

/// What a body fills at a node half a cell before its flat surface (quadratic B-splines).
const FILL_OF_NEAREST: f64 = 1.0 / 6.0;

/// What a body would fill at a node beside its edge if its face went on: with `L` the part that the edge leaves, it fills `L H`
/// and has the gradient `L H'` along the normal of the face, so that `H'/H` is free of `L`.
///
/// Exact for quadratic B-splines at surfaces half a cell before, on and behind the node, within 0.02 between.
fn fill_at_edge(ratio: f64) -> f64 {
    if ratio >= 3.0 {
        return 4.5 / (ratio * ratio * ratio);
    }
    (5.0 / 6.0 - 0.37037 * (ratio - 0.6) + 0.061_728 * (ratio - 0.6) * (ratio - 1.5)).min(1.0)
}

impl<S: CarriedNumber, const D: usize> Surface<S, D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let zero = S::constant(0.0);
        Self { fill: zero, outward: [zero; D] }
    }

    /// Whether this rigid body bears another at a node where both fill all of the volume, or else at an edge of the other.
    ///
    /// Only the nodes nearest to its surface and those behind it bear, as those of a plane do.
    #[inline(always)]
    fn bears(&self, other: &Self, is_full: bool) -> bool {
        let fill = self.fill.value();
        if is_full || fill < FILL_OF_NEAREST {
            return fill >= FILL_OF_NEAREST - MOST_GAP;
        }
        let (mut square, mut along) = (0.0, 0.0);
        for k in 0..D {
            square += self.outward[k].value().powi(2);
            along -= self.outward[k].value() * other.outward[k].value();
        }
        let ratio = along / (square.sqrt() * other.fill.value());
        fill + fill_at_edge(ratio) >= 1.0 - MOST_GAP
    }

    /// This surface beside a rigid body, whose normal alone counts.
    #[inline(always)]
    fn without_normal(&self) -> Self {
        Self { outward: [S::constant(0.0); D], ..*self }
    }

    /// The surfaces of two bodies where they are in contact; none where they are not.
    #[inline(always)]
    pub(crate) fn in_contact(
        [a, b]: [&Self; 2],
        is_full: bool,
        rigid: [bool; 2],
    ) -> Option<[Self; 2]> {
        match rigid {
            [true, _] => a.bears(b, is_full).then(|| [*a, b.without_normal()]),
            [_, true] => b.bears(a, is_full).then(|| [a.without_normal(), *b]),
            _ => is_full.then_some([*a, *b]),
        }
    }

    /// The unit normal from one body into another: their gradients, each weighted by its square. Where a corner meets a flat
    /// surface, the gradient of the corner is oblique and the smaller one. `None` where both vanish or cancel.
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

/// Contact of two bodies at a node that they fill.
///
/// Symbols: $v$ = nodal velocities before the step, $\Delta v$ = their changes by forces, $m = m_a m_b / (m_a + m_b)$.
/// The unit normal $n$ points from `a` to `b`, and $\Delta = (v_a - v_b) \cdot n$. $\mu$ = `coefficient`; $\beta$ is
/// one where particles take the nodal velocity (APIC), zero where they take its change (FLIP).
///
/// The approach before the step is removed from the nodal velocities as at a mirror plane. It is
/// no velocity change, so FLIP particles keep it, and the collision loses no energy by it. The approach that forces add is an
/// impulse on the particles:
///
/// $$ J_n = m \max(\min(\Delta, 0) + (\Delta v_a - \Delta v_b) \cdot n, 0), \qquad
///    J_t = \min(m |v_t|, \mu (J_n + \beta m \max(\Delta, 0))) $$
///
/// with the slip $v_t$ after the forces. $J_t$ acts against the slip. Neither impulse adds kinetic energy: each at most stops the
/// relative velocity that it acts against. Bodies that separate are free.
///
/// Source: Bardenhagen et al. 2001 for the impulse on the whole approach, which is this one at $\beta = 1$; the split of the
/// approach is ours.
#[inline(always)]
pub(crate) fn meet<S: CarriedNumber, const D: usize>(
    (a, mass_a, of_a): (&mut Node<S, D>, S, &Surface<S, D>),
    (b, mass_b, of_b): (&mut Node<S, D>, S, &Surface<S, D>),
    Friction { coefficient, affine }: Friction,
) {
    let Some(normal) = of_a.normal_into(of_b) else { return };
    let zero = S::constant(0.0);
    let (mut relative, mut before, mut approach) = ([zero; D], zero, zero);
    for k in 0..D {
        let difference = a.velocity()[k] - b.velocity()[k];
        relative[k] = difference + (a.velocity_change()[k] - b.velocity_change()[k]);
        before = before + difference * normal[k];
        approach = approach + relative[k] * normal[k];
    }
    let slip = across(&relative, approach, &normal);
    if before.value() > 0.0 {
        approach = approach - before;
    } else {
        before = zero;
    }
    if approach.value() < 0.0 {
        approach = zero;
    }
    let pressed = if affine { approach + before } else { approach };
    let share = friction_share(&slip, pressed, coefficient);
    let both = (mass_a + mass_b).recip();
    let (share_a, share_b) = (mass_b * both, mass_a * both);
    for k in 0..D {
        let (removed, impulse) = (normal[k] * before, normal[k] * approach + slip[k] * share);
        a.velocity_mut()[k] = a.velocity()[k] - removed * share_a;
        b.velocity_mut()[k] = b.velocity()[k] + removed * share_b;
        a.velocity_change_mut()[k] = a.velocity_change()[k] - impulse * share_a;
        b.velocity_change_mut()[k] = b.velocity_change()[k] + impulse * share_b;
    }
}

/// The part of a relative velocity across the normal.
#[inline(always)]
fn across<S: CarriedNumber, const D: usize>(
    relative: &[S; D],
    approach: S,
    normal: &[S; D],
) -> [S; D] {
    let mut slip = *relative;
    for k in 0..D {
        slip[k] = slip[k] - approach * normal[k];
    }
    slip
}

/// The fraction of the slip that friction removes: one where the bodies stick.
#[inline(always)]
pub(crate) fn friction_share<S: CarriedNumber, const D: usize>(
    slip: &[S; D],
    approach: S,
    coefficient: f64,
) -> S {
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

    /// Contact of the first body with a second at rest: its velocity before the step and its change, and the momentum of both.
    fn met(brought: [f64; 2], forced: [f64; 2], friction: Friction) -> [[f64; 2]; 3] {
        let (mut a, mut b) = (Node::moving(brought), Node::moving([0.0; 2]));
        *a.velocity_change_mut() = forced;
        let energy = |a: &Node<f64, 2>, b: &Node<f64, 2>| {
            let square =
                |of: &Node<f64, 2>, k: usize| (of.velocity()[k] + of.velocity_change()[k]).powi(2);
            (0..2).map(|k| square(a, k) + 1.5 * square(b, k)).sum::<f64>()
        };
        let start = energy(&a, &b);
        // The normal is (0.6, 0.8).
        meet((&mut a, 2.0, &OUTWARD), (&mut b, 3.0, &INWARD), friction);
        assert!(energy(&a, &b) <= start * (1.0 + 1e-15), "{start}");
        let momentum = |k: usize| {
            2.0 * (a.velocity()[k] + a.velocity_change()[k])
                + 3.0 * (b.velocity()[k] + b.velocity_change()[k])
        };
        [*a.velocity(), *a.velocity_change(), std::array::from_fn(momentum)]
    }

    fn flip(coefficient: f64) -> Friction {
        Friction { coefficient, affine: false }
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
            let [before, change, momentum] = met([0.0; 2], forced, flip(coefficient));
            assert_close(before, [0.0; 2]);
            let lost = [0.6 * (0.6 + 0.8 * kept), 0.6 * (0.8 - 0.6 * kept)];
            assert_close(change, [forced[0] - lost[0], forced[1] - lost[1]]);
            assert_close(momentum, forced.map(|c| 2.0 * c));
        }
    }

    #[test]
    fn an_approach_before_the_step_is_removed_from_the_node_and_not_from_the_particles() {
        let brought = [0.6 + 0.4, 0.8 - 0.3];
        let [before, change, momentum] = met(brought, [0.0; 2], flip(0.3));
        // No force presses, so there is no friction.
        assert_close(before, [brought[0] - 0.36, brought[1] - 0.48]);
        assert_close(change, [0.0; 2]);
        assert_close(momentum, brought.map(|c| 2.0 * c));
        // With APIC particles lose it, and it bears friction.
        let [_, change, _] = met(brought, [0.0; 2], Friction { coefficient: 0.3, affine: true });
        assert_close(change, [-0.6 * 0.3 * 0.8, 0.6 * 0.3 * 0.6]);
        // Bodies that separate are free, also where forces press less than they separate.
        let parting = brought.map(|c| -c);
        assert_eq!(met(parting, [0.0; 2], flip(0.3))[..2], [parting, [0.0; 2]]);
        let pressed = [0.3, 0.4];
        assert_eq!(met(parting, pressed, flip(0.3))[..2], [parting, pressed]);
    }

    #[test]
    fn the_normal_is_antisymmetric_in_the_bodies_and_follows_the_flatter_one() {
        let corner = Surface { fill: 0.25, outward: [-0.1, -0.2] };
        let flat = Surface { fill: 0.5, outward: [0.0, 0.75] };
        let (one, other) = (flat.normal_into(&corner).unwrap(), corner.normal_into(&flat).unwrap());
        assert_close(one, other.map(|c| -c));
        // The gradient of the corner is oblique by 27 degrees, the normal by less than 1.
        assert!(one[0] > 0.0 && one[0] < 0.0175 && one[1] > 0.0, "{one:?}");
        assert!(flat.normal_into(&flat).is_none());
    }
}

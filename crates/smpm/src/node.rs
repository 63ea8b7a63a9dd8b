//! What a node of the grid holds.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::number::Number;

/// Two vectors of a node, next to each other in memory so that rows of nodes are whole registers. From particle-to-grid to the
/// solution at the nodes: [momentum](Self::momentum) and [force](Self::force). From there to grid-to-particle:
/// [velocity](Self::velocity) and its [change](Self::velocity_change) over the step. The nodal mass is stored separately.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node<S, const D: usize> {
    first: [S; D],
    second: [S; D],
}

/// A vector by its name, to be read and to be written.
macro_rules! vector {
    ($($(#[$about:meta])* $name:ident, $name_mut:ident: $field:ident;)+) => {
        $(
            $(#[$about])*
            #[inline(always)]
            pub(crate) fn $name(&self) -> &[S; D] {
                &self.$field
            }

            #[inline(always)]
            pub(crate) fn $name_mut(&mut self) -> &mut [S; D] {
                &mut self.$field
            }
        )+
    };
}

impl<S: Number, const D: usize> Node<S, D> {
    vector! {
        /// `(m v)_i`, before the solution.
        momentum, momentum_mut: first;
        /// `f_i`, before the solution.
        force, force_mut: second;
        /// `v_i`, after the solution.
        velocity, velocity_mut: first;
        /// By how much the step changes `v_i`, after the solution.
        velocity_change, velocity_change_mut: second;
    }

    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zero = S::constant(0.0);
        Self { first: [zero; D], second: [zero; D] }
    }

    /// A node that moves.
    #[cfg(test)]
    pub(crate) fn moving(velocity: [S; D]) -> Self {
        Self { first: velocity, ..Self::zero() }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        for k in 0..D {
            self.first[k] = self.first[k] + other.first[k];
            self.second[k] = self.second[k] + other.second[k];
        }
    }
}

//! What a node of the grid holds.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::number::CarriedNumber;

/// Two vectors of a node, next to each other in memory so that rows of nodes are whole registers. From particle-to-grid to the
/// solution at the nodes: [momentum](Self::momentum) and [force](Self::force). From there to grid-to-particle:
/// [velocity](Self::velocity) and its [change](Self::velocity_change) over the step. The nodal mass is stored separately.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node<S, const D: usize>([[S; D]; 2]);

/// A vector by its name, to be read and to be written.
macro_rules! vector {
    ($($(#[$about:meta])* $name:ident, $name_mut:ident: $vector:literal;)+) => {
        $(
            $(#[$about])*
            #[inline(always)]
            pub(crate) fn $name(&self) -> &[S; D] {
                &self.0[$vector]
            }

            #[inline(always)]
            pub(crate) fn $name_mut(&mut self) -> &mut [S; D] {
                &mut self.0[$vector]
            }
        )+
    };
}

impl<S: CarriedNumber, const D: usize> Node<S, D> {
    vector! {
        /// `(m v)_i`, before the solution.
        momentum, momentum_mut: 0;
        /// `f_i`, before the solution.
        force, force_mut: 1;
        /// `v_i`, after the solution.
        velocity, velocity_mut: 0;
        /// By how much the step changes `v_i`, after the solution.
        velocity_change, velocity_change_mut: 1;
    }

    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self([[S::constant(0.0); D]; 2])
    }

    /// A node that moves.
    #[cfg(test)]
    pub(crate) fn moving(velocity: [S; D]) -> Self {
        Self([velocity, [S::constant(0.0); D]])
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        for k in 0..D {
            self.0[0][k] = self.0[0][k] + other.0[0][k];
            self.0[1][k] = self.0[1][k] + other.0[1][k];
        }
    }

    /// Both vectors, one after the other.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> &[S] {
        self.0.as_flattened()
    }

    /// The same, to be written.
    #[inline(always)]
    pub(crate) fn numbers_mut(&mut self) -> &mut [S] {
        self.0.as_flattened_mut()
    }
}

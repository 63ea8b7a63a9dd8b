//! Velocity gradients of a batch of particles, between grid-to-particle and the material.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::number::CarriedNumber;
use crate::points::particles::BATCH;

/// `L_ij = dv_i/dx_j` of the particles of a batch: entry by entry, so that registers load adjacent particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VelocityGradients<S>([[[S; BATCH]; 3]; 3]);

impl<S: CarriedNumber> VelocityGradients<S> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self([[[S::constant(0.0); BATCH]; 3]; 3])
    }

    /// Entry `ij` of all particles.
    #[inline(always)]
    pub(crate) fn entries(&self, i: usize, j: usize) -> &[S; BATCH] {
        &self.0[i][j]
    }

    /// The same, to be written.
    #[inline(always)]
    pub(crate) fn entries_mut(&mut self, i: usize, j: usize) -> &mut [S; BATCH] {
        &mut self.0[i][j]
    }

    /// One particle.
    #[inline(always)]
    pub(crate) fn get(&self, particle: usize) -> [[S; 3]; 3] {
        let mut l = [[self.0[0][0][particle]; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                l[i][j] = self.0[i][j][particle];
            }
        }
        l
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, particle: usize, l: &[[S; 3]; 3]) {
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j][particle] = l[i][j];
            }
        }
    }
}

//! Derivatives of eight responses by all numbers of the particles.

use super::eight::Eight;
use super::saved::{Kind, Layout};

/// Derivatives of eight responses by the numbers of a body, by the numbers of particles.
#[derive(Debug)]
pub(super) struct BodyAdjoint<const D: usize> {
    pub(super) position: Vec<[Eight; D]>,
    pub(super) velocity: Vec<[Eight; D]>,
    /// APIC's matrix; empty without.
    pub(super) affine: Vec<[[Eight; D]; D]>,
    pub(super) mass: Vec<Eight>,
    /// Slots of [`Layout::n_slots`], particle by particle.
    pub(super) material: Vec<Eight>,
    /// By the velocity gradients of the step.
    pub(super) gradient: Vec<[[Eight; D]; D]>,
    /// By the hoop of the velocity gradient.
    pub(super) hoop: Vec<Eight>,
    /// By the positions at the end of the step.
    pub(super) moved: Vec<[Eight; D]>,
}

impl<const D: usize> BodyAdjoint<D> {
    pub(super) fn zero(n: usize, layout: &Layout, with_affine: bool) -> Self {
        let (zero, vector, matrix) = (Eight::ZERO, [Eight::ZERO; D], [[Eight::ZERO; D]; D]);
        Self {
            position: vec![vector; n],
            velocity: vec![vector; n],
            affine: vec![matrix; if with_affine { n } else { 0 }],
            mass: vec![zero; n],
            material: vec![zero; n * layout.n_slots()],
            gradient: vec![matrix; n],
            hoop: vec![zero; n],
            moved: vec![vector; n],
        }
    }

    /// That of a number of a particle.
    pub(super) fn of_kind(
        &mut self,
        layout: &Layout,
        particle: usize,
        kind: Kind,
    ) -> Option<&mut Eight> {
        match kind {
            Kind::Position(k) => Some(&mut self.position[particle][k]),
            Kind::Velocity(k) => Some(&mut self.velocity[particle][k]),
            Kind::Affine(k, l) => Some(&mut self.affine[particle][k][l]),
            Kind::Mass => Some(&mut self.mass[particle]),
            Kind::Material(slot) => Some(&mut self.material[particle * layout.n_slots() + slot]),
            Kind::None => None,
        }
    }
}

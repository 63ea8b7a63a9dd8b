//! What of a particle goes to its nodes, as far as the node does not matter.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use crate::config::{Config, Geometry, Transfer};
use crate::grid::lattice::Lattice;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::points::conditions::Columns;
use crate::transfer::shape::Shape;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Entry `kl` of a symmetric tensor.
pub(crate) const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// What particle-to-grid sums at the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Given {
    /// Momentum alone: the nodes know their masses.
    Momentum,
    /// Mass, momentum and force.
    MassMomentumAndForce,
}

/// Particle-to-grid of a configuration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ParticleToGrid<const D: usize> {
    pub(crate) lattice: Lattice<D>,
    pub(crate) shape: Shape,
    pub(crate) given: Given,
    /// Whether with APIC's matrix.
    pub(crate) affine: bool,
    pub(crate) gravity: [f64; D],
    pub(crate) axisymmetric: bool,
    /// See [`Shape::hoop_curvature`].
    pub(crate) hoop_curvature: f64,
    /// Whether there is gravity, or loads on the body.
    pub(crate) body_force: bool,
}

/// A run of particles. Columns that the configuration leaves out are empty.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run<'a, S, const D: usize> {
    pub(crate) position: &'a [[S; D]],
    pub(crate) velocity: &'a [[S; D]],
    affine: &'a [[[S; D]; D]],
    pub(crate) mass: &'a [S],
    pub(crate) reference_volume: &'a [f64],
    pub(crate) conditions: Columns<'a, S>,
    /// Of loads.
    pub(crate) force: &'a [[f64; D]],
    /// The lowest node that it sees.
    pub(crate) base: &'a [[i32; D]],
    /// Where in the blocks of the grid this node is.
    pub(crate) node: &'a [usize],
}

/// The momentum of a particle at its nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MomentumTerms<S, const D: usize> {
    /// That at the lowest node, `m_p (v_p + C_p (x_0 - x_p))`, of which a node has the part `N_i`.
    pub(crate) lowest: [S; D],
    /// By how much it grows from node to node along each axis: `m_p C_p e_l` times the cell.
    pub(crate) growth: [[S; D]; D],
}

impl<'a, S: CarriedNumber, const D: usize> Run<'a, S, D> {
    #[inline(always)]
    pub(crate) fn of(body: &'a Body<S, D>, conditions: &Columns<'a, S>, run: Range<usize>) -> Self {
        let (particles, binning) = (&body.particles, &body.binning);
        Self {
            position: &particles.position[run.clone()],
            velocity: &particles.velocity[run.clone()],
            affine: particles.affine.get(run.clone()).unwrap_or_default(),
            mass: &particles.mass[run.clone()],
            reference_volume: &particles.reference_volume[run.clone()],
            conditions: conditions.part(run.clone()),
            force: particles.force.get(run.clone()).unwrap_or_default(),
            base: &binning.bases[run.clone()],
            node: &binning.nodes[run],
        }
    }
}

impl<const D: usize> ParticleToGrid<D> {
    pub(crate) fn of(config: &Config<D>, given: Given) -> Self {
        let falls = config.gravity.iter().any(|&along| along != 0.0);
        Self {
            lattice: Lattice::of(config),
            shape: config.shape,
            given,
            affine: config.transfer == Transfer::Apic,
            gravity: config.gravity,
            axisymmetric: config.geometry == Geometry::Axisymmetric,
            hoop_curvature: 0.0,
            body_force: falls,
        }
    }

    /// The same for the particles of a body.
    pub(crate) fn of_body<S: CarriedNumber>(&self, body: &Body<S, D>) -> Self {
        let spacing = body.spacing()[0] * self.lattice.per_cell;
        let hoop_curvature = self.shape.hoop_curvature(spacing);
        Self { hoop_curvature, body_force: self.body_force || body.is_loaded(), ..*self }
    }

    /// Momentum with APIC's matrix.
    #[inline(always)]
    pub(crate) fn affine_momentum<S: CarriedNumber>(
        &self,
        of: &Run<'_, S, D>,
        p: usize,
    ) -> MomentumTerms<S, D> {
        let (lattice, mass) = (&self.lattice, of.mass[p]);
        let (mut velocity, mut growth) = (of.velocity[p], [[mass; D]; D]);
        let (matrix, x) = (&of.affine[p], &of.position[p]);
        for l in 0..D {
            let arm = -(x[l] - lattice.origin[l]) + f64::from(of.base[p][l]) * lattice.cell;
            for k in 0..D {
                velocity[k] = velocity[k] + matrix[k][l] * arm;
                growth[l][k] = matrix[k][l] * mass * lattice.cell;
            }
        }
        let mut lowest = velocity;
        for k in 0..D {
            lowest[k] = velocity[k] * mass;
        }
        MomentumTerms { lowest, growth }
    }

    /// The force of the hoop on the nodes of a particle, along the radius: `-V_p sigma_tt / r`.
    #[inline(always)]
    pub(crate) fn hoop_force<S: CarriedNumber>(of: &Run<'_, S, D>, p: usize) -> S {
        let Columns { volume, viscosity, stress, .. } = &of.conditions;
        let volume = volume[p] * of.reference_volume[p];
        let hoop = stress[2][p] - viscosity[p];
        -(volume * hoop / of.position[p][0])
    }
}

//! What of a particle goes to its nodes, as far as the node does not matter.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use crate::body::Body;
use crate::conditions::Columns;
use crate::config::{Config, Geometry, Transfer};
use crate::lattice::Lattice;
use crate::node::Node;
use crate::number::Number;
use crate::shape::Shape;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Entry `kl` of a symmetric tensor.
pub(crate) const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// What particle-to-grid sums at the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Given {
    /// Mass and momentum.
    MassAndMomentum,
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
    /// Whether anything acts on all nodes of a particle alike: gravity, the hoop.
    pub(crate) body_force: bool,
}

/// A run of particles. Columns that the configuration leaves out are empty.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run<'a, S, const D: usize> {
    pub(crate) position: &'a [[S; D]],
    pub(crate) velocity: &'a [[S; D]],
    affine: &'a [[[S; D]; D]],
    pub(crate) half_length: &'a [[S; D]],
    pub(crate) mass: &'a [S],
    pub(crate) reference_volume: &'a [f64],
    pub(crate) conditions: Columns<'a, S>,
    /// The lowest node that it sees.
    pub(crate) base: &'a [[i32; D]],
    /// Where in the blocks of the grid this node is.
    pub(crate) node: &'a [usize],
}

/// The terms of a particle, in the order in which registers take them. What the configuration leaves out is not written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms<S, const D: usize> {
    /// Momentum at the lowest node, `m_p (v_p + C_p (x_0 - x_p))`, of which a node has the part `N_i`; the force
    /// `-V_p sigma_p e_x` over the cell, of which it has the part `dN_i/dx`.
    pub(crate) along: Node<S, D>,
    /// `m_p`.
    pub(crate) mass: S,
    /// No momentum; the force `-V_p sigma_p e_y` over the cell, likewise.
    pub(crate) across: Node<S, D>,
    /// The force `-V_p sigma_p e_z` over the cell, likewise.
    pub(crate) force_z: [S; D],
    /// `m_p b`, and the hoop, of which a node has the part `N_i`.
    pub(crate) body_force: [S; D],
    /// By how much the momentum grows from node to node along each axis: `m_p C_p e_l` times the cell.
    pub(crate) growth: [[S; D]; D],
}

impl<S: Number, const D: usize> Terms<S, D> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zero = S::constant(0.0);
        Self {
            along: Node::zero(),
            across: Node::zero(),
            force_z: [zero; D],
            body_force: [zero; D],
            growth: [[zero; D]; D],
            mass: zero,
        }
    }
}

impl<'a, S: Number, const D: usize> Run<'a, S, D> {
    #[inline(always)]
    pub(crate) fn of(body: &'a Body<S, D>, conditions: &Columns<'a, S>, run: Range<usize>) -> Self {
        let (particles, binning) = (&body.particles, &body.binning);
        Self {
            position: &particles.position[run.clone()],
            velocity: &particles.velocity[run.clone()],
            affine: particles.affine.get(run.clone()).unwrap_or_default(),
            half_length: particles.half_length.get(run.clone()).unwrap_or_default(),
            mass: &particles.mass[run.clone()],
            reference_volume: &particles.reference_volume[run.clone()],
            conditions: conditions.part(run.clone()),
            base: &binning.bases[run.clone()],
            node: &binning.nodes[run],
        }
    }
}

impl<const D: usize> ParticleToGrid<D> {
    pub(crate) fn of(config: &Config<D>, given: Given) -> Self {
        let axisymmetric = config.geometry == Geometry::Axisymmetric;
        let falls = config.gravity.iter().any(|&along| along != 0.0);
        Self {
            lattice: Lattice::of(config),
            shape: config.shape,
            given,
            affine: config.transfer == Transfer::Apic,
            gravity: config.gravity,
            axisymmetric,
            body_force: falls || axisymmetric,
        }
    }

    #[inline(always)]
    pub(crate) fn find_terms<S: Number>(
        &self,
        of: &Run<'_, S, D>,
        p: usize,
        terms: &mut Terms<S, D>,
    ) {
        self.find_momentum(of, p, terms);
        if self.given == Given::MassMomentumAndForce {
            let force = self.stress_force(of, p);
            for c in 0..D {
                terms.along.force_mut()[c] = force[0][c];
                if D > 1 {
                    terms.across.force_mut()[c] = force[D.min(2) - 1][c];
                }
                if D > 2 {
                    terms.force_z[c] = force[D - 1][c];
                }
            }
            if self.body_force {
                terms.body_force = self.force_on_all_nodes(of, p);
            }
        }
    }

    /// Mass, momentum, and how it grows.
    #[inline(always)]
    pub(crate) fn find_momentum<S: Number>(
        &self,
        of: &Run<'_, S, D>,
        p: usize,
        terms: &mut Terms<S, D>,
    ) {
        let lattice = &self.lattice;
        terms.mass = of.mass[p];
        let mut velocity = of.velocity[p];
        if self.affine {
            let (matrix, x) = (&of.affine[p], &of.position[p]);
            for l in 0..D {
                let arm = -(x[l] - lattice.origin[l]) + f64::from(of.base[p][l]) * lattice.cell;
                for k in 0..D {
                    velocity[k] = velocity[k] + matrix[k][l] * arm;
                    terms.growth[l][k] = matrix[k][l] * terms.mass * lattice.cell;
                }
            }
        }
        for k in 0..D {
            terms.along.momentum_mut()[k] = velocity[k] * terms.mass;
        }
    }

    /// `-V_p sigma_p e_l` over the cell, by the axis `l` of the gradient.
    #[inline(always)]
    fn stress_force<S: Number>(&self, of: &Run<'_, S, D>, p: usize) -> [[S; D]; D] {
        let Columns { volume, viscosity, stress: columns, .. } = &of.conditions;
        let factor = volume[p] * of.reference_volume[p] * -self.lattice.per_cell;
        let mut stress = [factor; 6];
        for k in 0..6 {
            stress[k] = columns[k][p];
        }
        for k in 0..3 {
            stress[k] = stress[k] - viscosity[p];
        }
        let mut force = [[factor; D]; D];
        for l in 0..D {
            for k in 0..D {
                force[l][k] = stress[ENTRY[k][l]] * factor;
            }
        }
        force
    }

    /// What acts on all nodes of a particle alike: gravity, the hoop.
    #[inline(always)]
    pub(crate) fn force_on_all_nodes<S: Number>(&self, of: &Run<'_, S, D>, p: usize) -> [S; D] {
        let mut force = [of.mass[p]; D];
        for k in 0..D {
            force[k] = of.mass[p] * self.gravity[k];
        }
        if self.axisymmetric {
            let Columns { volume, viscosity, stress, .. } = &of.conditions;
            let volume = volume[p] * of.reference_volume[p];
            let hoop = stress[2][p] - viscosity[p];
            force[0] = force[0] - volume * hoop / of.position[p][0];
        }
        force
    }
}

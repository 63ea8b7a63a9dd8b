//! What a particle makes of its sums over nodes: velocity gradient, velocity, APIC's matrix, displacement.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{Config, Geometry, Transfer};
use crate::grid::lattice::Lattice;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::points::particles::Chunk;
use crate::transfer::shape::Shape;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// What a pass over the particles does; a step has one of each, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Velocities from the nodes, and displacements. Particles stay in place, since their stress comes from the same place.
    Velocity,
    /// Velocity gradients from the nodes, the stress from them; then the particles move.
    StressAndMove,
}

/// Grid-to-particle of a configuration in a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GridToParticle<const D: usize> {
    pub(crate) lattice: Lattice<D>,
    pub(crate) shape: Shape,
    pub(crate) dt: f64,
    pub(crate) pass: Pass,
    pub(crate) axisymmetric: bool,
    /// See [`Shape::hoop_curvature`].
    pub(crate) hoop_curvature: f64,
    /// Whether with APIC's matrix.
    pub(crate) affine: bool,
    /// `1/d` of `D_p = d I`.
    pub(crate) inverse_inertia: f64,
}

/// Sums over the nodes that a particle sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums<S, const D: usize> {
    /// `sum_i v_i N_i`.
    pub(crate) velocity: [S; D],
    /// The same of the velocity changes.
    pub(crate) change: [S; D],
    /// `sum_i v_k dN_i/dx_l`, per cell, by the axis `l`.
    pub(crate) gradient: [[S; D]; D],
    /// `sum_i v_k n_il N_i`, `n_il` the number of the node along axis `l` from the lowest.
    pub(crate) moment: [[S; D]; D],
    /// `sum_i v_r (N_i + c N_i'')`, `c` of [`Shape::hoop_curvature`].
    pub(crate) around: S,
}

/// What a sum starts with: minus zero, to which anything may be added without a change, so that for `f64` the compiler
/// leaves the addition out.
#[inline(always)]
pub(crate) fn nothing<S: CarriedNumber>() -> S {
    S::constant(-0.0)
}

impl<S: CarriedNumber, const D: usize> Sums<S, D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let (vector, matrix) = ([nothing(); D], [[nothing(); D]; D]);
        Self {
            velocity: vector,
            change: vector,
            gradient: matrix,
            moment: matrix,
            around: nothing(),
        }
    }
}

impl<const D: usize> GridToParticle<D> {
    pub(crate) fn of(lattice: Lattice<D>, config: &Config<D>, pass: Pass, dt: f64) -> Self {
        let square = config.cell * config.cell;
        Self {
            lattice,
            shape: config.shape,
            dt,
            pass,
            axisymmetric: config.geometry == Geometry::Axisymmetric,
            hoop_curvature: 0.0,
            affine: config.transfer == Transfer::Apic,
            inverse_inertia: match config.shape {
                Shape::QuadraticBSpline => 4.0 / square,
                Shape::CubicBSpline => 3.0 / square,
            },
        }
    }

    /// The same for the particles of a body.
    pub(crate) fn of_body<S: CarriedNumber>(&self, body: &Body<S, D>) -> Self {
        let spacing = body.spacing()[0] * self.lattice.per_cell;
        Self { hoop_curvature: self.shape.hoop_curvature(spacing), ..*self }
    }

    /// Updates a particle from its sums over nodes.
    #[inline(always)]
    pub(crate) fn apply<S: CarriedNumber>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        p: usize,
        sums: &Sums<S, D>,
        velocity_gradient: &mut [[S; 3]; 3],
    ) {
        if self.pass == Pass::StressAndMove {
            self.find_gradient(chunk, p, sums, velocity_gradient);
            return;
        }
        for k in 0..D {
            // APIC's velocity is `sum_i v_i N_i`, FLIP's `v_p + sum_i dv_i N_i`.
            let velocity = &mut chunk.velocity[p][k];
            *velocity = if self.affine { sums.velocity[k] } else { *velocity + sums.change[k] };
            chunk.displacement[p][k] = sums.velocity[k] * self.dt;
        }
        if self.affine {
            chunk.affine[p] = self.matrix(sums, &chunk.base[p], &chunk.position[p]);
        }
    }

    /// `L_p = sum_i v_i grad N_i`, and the hoop `sum_i v_r (N_i + c N_i'') / r`.
    #[inline(always)]
    fn find_gradient<S: CarriedNumber>(
        &self,
        chunk: &Chunk<'_, S, D>,
        p: usize,
        sums: &Sums<S, D>,
        l: &mut [[S; 3]; 3],
    ) {
        for k in 0..D {
            for m in 0..D {
                l[k][m] = sums.gradient[m][k] * self.lattice.per_cell;
            }
        }
        if self.axisymmetric {
            l[2][2] = sums.around / chunk.position[p][0];
        }
    }

    /// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8).
    #[inline(always)]
    fn matrix<S: CarriedNumber>(
        &self,
        sums: &Sums<S, D>,
        base: &[i32; D],
        x: &[S; D],
    ) -> [[S; D]; D] {
        let Lattice { origin, cell, .. } = self.lattice;
        let mut matrix = sums.moment;
        for l in 0..D {
            let arm = -(x[l] - origin[l]) + f64::from(base[l]) * cell;
            for k in 0..D {
                let moment = sums.velocity[k] * arm + sums.moment[k][l] * cell;
                matrix[k][l] = moment * self.inverse_inertia;
            }
        }
        matrix
    }
}

//! What a particle makes of its sums over nodes: velocity gradient, velocity, APIC's matrix, displacement.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{Config, Geometry, Transfer};
use crate::lattice::Lattice;
use crate::number::Number;
use crate::particles::Chunk;
use crate::pass::Pass;
use crate::shape::Shape;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Grid-to-particle of a configuration in a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GridToParticle<const D: usize> {
    pub(crate) lattice: Lattice<D>,
    pub(crate) shape: Shape,
    pub(crate) dt: f64,
    pub(crate) pass: Pass,
    pub(crate) axisymmetric: bool,
    /// Whether with APIC's matrix.
    pub(crate) affine: bool,
    /// Whether with velocities themselves (PIC), not their changes alone.
    pub(crate) with_pic: bool,
    /// The share of FLIP, and that of PIC.
    pub(crate) shares: (f64, f64),
    /// `1/d` of `D_p = d I` where the shape function has such (B-splines); none where the gradient serves.
    pub(crate) inverse_inertia: Option<f64>,
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
}

/// What a sum starts with: minus zero, to which anything may be added without a change, so that for `f64` the compiler
/// leaves the addition out.
#[inline(always)]
pub(crate) fn nothing<S: Number>() -> S {
    S::constant(-0.0)
}

impl<S: Number, const D: usize> Sums<S, D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        let (vector, matrix) = ([nothing(); D], [[nothing(); D]; D]);
        Self { velocity: vector, change: vector, gradient: matrix, moment: matrix }
    }
}

impl<const D: usize> GridToParticle<D> {
    pub(crate) fn of(lattice: Lattice<D>, config: &Config<D>, pass: Pass, dt: f64) -> Self {
        let shares = config.transfer.shares(dt);
        let square = config.cell * config.cell;
        Self {
            lattice,
            shape: config.shape,
            dt,
            pass,
            axisymmetric: config.geometry == Geometry::Axisymmetric,
            affine: config.transfer == Transfer::Apic,
            with_pic: shares.1 != 0.0,
            shares,
            inverse_inertia: match config.shape {
                Shape::QuadraticBSpline => Some(4.0 / square),
                Shape::CubicBSpline => Some(3.0 / square),
                Shape::Linear | Shape::Gimp => None,
            },
        }
    }

    #[inline(always)]
    pub(crate) fn apply<S: Number, const NODES: usize>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        p: usize,
        sums: &Sums<S, D>,
        velocity_gradient: &mut [[S; 3]; 3],
    ) {
        if self.pass.updates_stress() {
            self.find_gradient(chunk, p, sums, velocity_gradient);
            if NODES == Shape::Gimp.n_nodes() && self.shape == Shape::Gimp {
                for k in 0..D {
                    let length = chunk.half_length[p][k];
                    chunk.stretched[p][k] = length + length * velocity_gradient[k][k] * self.dt;
                }
            }
        }
        if !self.pass.updates_velocity() {
            return;
        }
        self.find_velocity(&mut chunk.velocity[p], sums);
        if self.affine {
            chunk.affine[p] = self.matrix(sums, &chunk.base[p], &chunk.position[p]);
        }
        // Where the stress is still to come from the same place, the particle stays until then.
        for k in 0..D {
            let by = sums.velocity[k] * self.dt;
            if self.pass.moves() {
                chunk.position[p][k] = chunk.position[p][k] + by;
            } else {
                chunk.displacement[p][k] = by;
            }
        }
    }

    /// `L_p = sum_i v_i grad N_i`, and the hoop `v_r/r`.
    #[inline(always)]
    fn find_gradient<S: Number>(
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
            l[2][2] = sums.velocity[0] / chunk.position[p][0];
        }
    }

    /// FLIP's `v_p + sum_i dv_i N_i`, PIC's `sum_i v_i N_i`, or both by their shares.
    #[inline(always)]
    fn find_velocity<S: Number>(&self, velocity: &mut [S; D], sums: &Sums<S, D>) {
        let (flip, pic) = self.shares;
        for k in 0..D {
            let new = sums.velocity[k];
            if !self.with_pic {
                velocity[k] = velocity[k] + sums.change[k];
            } else if flip == 0.0 {
                velocity[k] = new;
            } else {
                velocity[k] = (velocity[k] + sums.change[k]) * flip + new * pic;
            }
        }
    }

    /// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8); for shape functions of the hat
    /// `sum_i v_i grad N_i^T`, to which it comes down there.
    #[inline(always)]
    fn matrix<S: Number>(&self, sums: &Sums<S, D>, base: &[i32; D], x: &[S; D]) -> [[S; D]; D] {
        let Lattice { origin, cell, per_cell } = self.lattice;
        let mut matrix = sums.moment;
        for l in 0..D {
            let arm = -(x[l] - origin[l]) + f64::from(base[l]) * cell;
            for k in 0..D {
                matrix[k][l] = match self.inverse_inertia {
                    None => sums.gradient[l][k] * per_cell,
                    Some(inverse) => (sums.velocity[k] * arm + sums.moment[k][l] * cell) * inverse,
                };
            }
        }
        matrix
    }
}

//! From nodes to particles.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::binning::Binning;
use crate::config::{Geometry, Transfer};
use crate::grid::{Grid, Node};
use crate::number::Number;
use crate::particles::Chunk;
use crate::shape::{Axis, Shape, ShapeFunction, nodes_along, outer};
use crate::tiles::block_edge;
use crate::transfer::{Pass, Places, Sweep};

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// What is taken, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taker<const D: usize> {
    places: Places<D>,
    dt: f64,
    pass: Pass,
    field: usize,
    axisymmetric: bool,
    affine: bool,
    /// Whether velocities themselves are taken, not their changes alone.
    picks: bool,
    /// The share of FLIP, and that of PIC.
    shares: (f64, f64),
    /// `1/d` of `D_p = d I` where the shape function has such (B-splines); none where the gradient serves.
    inverse_inertia: Option<f64>,
}

/// Sums over nodes.
#[derive(Debug, Clone, Copy)]
struct Sums<S, const D: usize> {
    velocity: [S; D],
    change: [S; D],
    /// `sum_i v_k dN_i/dx_l`, per cell.
    gradient: [[S; D]; D],
    /// `sum_i v_k n_il N_i`, `n_il` the number of the node along axis `l` from the lowest.
    moment: [[S; D]; D],
}

impl<const D: usize> Taker<D> {
    pub(crate) fn of<S>(sweep: &Sweep<'_, S, D>) -> Self {
        let (grid, config) = (sweep.grid, sweep.config);
        let shares = match config.transfer {
            Transfer::Flip { damping_time } => {
                let share = (-sweep.dt / damping_time).exp();
                (share, 1.0 - share)
            }
            Transfer::Apic => (0.0, 1.0),
        };
        let square = config.cell * config.cell;
        Self {
            places: Places::of(grid),
            dt: sweep.dt,
            pass: sweep.pass,
            field: sweep.field,
            axisymmetric: config.geometry == Geometry::Axisymmetric,
            affine: config.transfer == Transfer::Apic,
            picks: shares.1 != 0.0,
            shares,
            inverse_inertia: match config.shape {
                Shape::QuadraticBSpline => Some(4.0 / square),
                Shape::CubicBSpline => Some(3.0 / square),
                Shape::Linear | Shape::Gimp => None,
            },
        }
    }

    /// All particles of a chunk. Of plain numbers, in the usual cases, what is taken is known to the compiler, which then asks
    /// at no node; beside the arithmetic of a jet a question costs nothing, and its code is long.
    #[inline(always)]
    pub(crate) fn take_all<F: ShapeFunction, S: Number>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        grid: &Grid<S, D>,
    ) {
        if const { size_of::<S>() > size_of::<f64>() } {
            self.take_each::<F, S>(chunk, gradients, grid);
            return;
        }
        let plain = Self { affine: false, picks: false, ..*self };
        match (self.pass, self.affine || self.picks) {
            (Pass::Whole, false) => {
                Self { pass: Pass::Whole, ..plain }.take_each::<F, S>(chunk, gradients, grid);
            }
            (Pass::Motion, false) => {
                Self { pass: Pass::Motion, ..plain }.take_each::<F, S>(chunk, gradients, grid);
            }
            (Pass::StressAndMove, _) => {
                let stress = Self { pass: Pass::StressAndMove, ..plain };
                stress.take_each::<F, S>(chunk, gradients, grid);
            }
            _ => self.take_each::<F, S>(chunk, gradients, grid),
        }
    }

    #[inline(always)]
    fn take_each<F: ShapeFunction, S: Number>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        grid: &Grid<S, D>,
    ) {
        let mut axes = [Axis::empty(); D];
        for p in 0..gradients.len() {
            self.take::<F, S>(chunk, p, (&mut axes, &mut gradients[p]), grid);
        }
    }

    #[inline(always)]
    fn take<F: ShapeFunction, S: Number>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        p: usize,
        (axes, l): (&mut [Axis<S>; D], &mut [[S; 3]; 3]),
        grid: &Grid<S, D>,
    ) {
        let (base, slot) = (&chunk.base[p], chunk.slot[p] as usize);
        let sized = (&chunk.position[p], &*chunk.half_length);
        self.places.find_axes::<F, S>(sized, (p, base), axes);
        let offset = Binning::offset(base, &grid.corner(slot));
        let sums = self.sums::<F, S>(axes, &grid.block(slot, self.field)[offset..]);
        if self.pass.updates_stress() {
            for k in 0..D {
                for m in 0..D {
                    l[k][m] = sums.gradient[k][m] * self.places.per_cell;
                }
            }
            if self.axisymmetric {
                l[2][2] = sums.velocity[0] / chunk.position[p][0];
            }
            if F::SIZED {
                for k in 0..D {
                    let length = chunk.half_length[p][k];
                    chunk.stretched[p][k] = length + length * l[k][k] * self.dt;
                }
            }
        }
        if !self.pass.takes_motion() {
            return;
        }
        let (flip, picked) = self.shares;
        let velocity = &mut chunk.velocity[p];
        for k in 0..D {
            let new = sums.velocity[k];
            if !self.picks {
                velocity[k] = velocity[k] + sums.change[k];
            } else if flip == 0.0 {
                velocity[k] = new;
            } else {
                velocity[k] = (velocity[k] + sums.change[k]) * flip + new * picked;
            }
        }
        if self.affine {
            chunk.affine[p] = self.matrix(&sums, base, &chunk.position[p]);
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

    /// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8); for shape functions of the hat
    /// `sum_i v_i grad N_i^T`, to which it comes down there.
    #[inline(always)]
    fn matrix<S: Number>(&self, sums: &Sums<S, D>, base: &[i32; D], x: &[S; D]) -> [[S; D]; D] {
        let cell = self.places.cell;
        let mut matrix = sums.gradient;
        for l in 0..D {
            let arm = -(x[l] - self.places.origin[l]) + f64::from(base[l]) * cell;
            for k in 0..D {
                matrix[k][l] = match self.inverse_inertia {
                    None => sums.gradient[k][l] * self.places.per_cell,
                    Some(inverse) => (sums.velocity[k] * arm + sums.moment[k][l] * cell) * inverse,
                };
            }
        }
        matrix
    }

    #[inline(always)]
    fn sums<F: ShapeFunction, S: Number>(
        &self,
        axes: &[Axis<S>; D],
        nodes: &[Node<S, D>],
    ) -> Sums<S, D> {
        let (zero, edge) = (S::constant(0.0), block_edge(D));
        let mut sums = Sums {
            velocity: [zero; D],
            change: [zero; D],
            gradient: [[zero; D]; D],
            moment: [[zero; D]; D],
        };
        let with_change = self.pass.takes_motion() && (!self.picks || self.shares.0 != 0.0);
        let with_matrix = self.pass.takes_motion() && self.affine;
        let with_gradient =
            self.pass.updates_stress() || (with_matrix && self.inverse_inertia.is_none());
        let with_moment = with_matrix && self.inverse_inertia.is_some();
        let (value, along) = (&axes[0].value, &axes[0].slope);
        for k in 0..nodes_along::<F, D>(2) {
            for j in 0..nodes_along::<F, D>(1) {
                let (weight, slope) = outer(axes, (j, k));
                let start = (k * edge + j) * edge;
                let row = &nodes[start..start + F::NODES];
                let (mut velocity, mut change) = ([zero; D], [zero; D]);
                for i in 0..F::NODES {
                    for c in 0..D {
                        velocity[c] = velocity[c] + row[i].motion[c] * value[i];
                    }
                    if with_change {
                        for c in 0..D {
                            change[c] = change[c] + row[i].change[c] * value[i];
                        }
                    }
                }
                for c in 0..D {
                    let here = velocity[c] * weight;
                    sums.velocity[c] = sums.velocity[c] + here;
                    if with_change {
                        sums.change[c] = sums.change[c] + change[c] * weight;
                    }
                    if with_moment {
                        if D > 1 {
                            let l = D.min(2) - 1;
                            sums.moment[c][l] = sums.moment[c][l] + here * j as f64;
                        }
                        if D > 2 {
                            sums.moment[c][D - 1] = sums.moment[c][D - 1] + here * k as f64;
                        }
                    }
                }
                if with_gradient {
                    let mut steep = [zero; D];
                    for i in 0..F::NODES {
                        for c in 0..D {
                            steep[c] = steep[c] + row[i].motion[c] * along[i];
                        }
                    }
                    for c in 0..D {
                        sums.gradient[c][0] = sums.gradient[c][0] + steep[c] * weight;
                        for l in 1..D {
                            sums.gradient[c][l] = sums.gradient[c][l] + velocity[c] * slope[l];
                        }
                    }
                }
                if with_moment {
                    let mut moment = [zero; D];
                    for i in 1..F::NODES {
                        for c in 0..D {
                            moment[c] = moment[c] + row[i].motion[c] * (value[i] * i as f64);
                        }
                    }
                    for c in 0..D {
                        sums.moment[c][0] = sums.moment[c][0] + moment[c] * weight;
                    }
                }
            }
        }
        sums
    }
}

//! From nodes to particles.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{Geometry, Transfer};
use crate::grid::{Grid, Node};
use crate::number::{Number, is_plain};
use crate::particles::Chunk;
use crate::shape::{Axis, Shape, ShapeFunction, nodes_along, nodes_spanned, outer};
use crate::tiles::block_edge;
use crate::transfer::{Pass, Places, Sweep};

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Particles whose sums stand in memory together: few enough for the nearest cache.
const BATCH: usize = 8;

/// What is taken, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taker<const D: usize> {
    places: Places<D>,
    dt: f64,
    pass: Pass,
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
    /// `sum_i v_k dN_i/dx_l`, per cell, by the axis `l`.
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
        if const { !is_plain::<S>() } {
            self.take_each::<F, S, 1>(chunk, gradients, grid);
            return;
        }
        let plain = Self { affine: false, picks: false, ..*self };
        match (self.pass, self.affine || self.picks) {
            (Pass::Whole, false) => {
                Self { pass: Pass::Whole, ..plain }
                    .take_each::<F, S, BATCH>(chunk, gradients, grid);
            }
            (Pass::Motion, false) => {
                let motion = Self { pass: Pass::Motion, ..plain };
                motion.take_each::<F, S, BATCH>(chunk, gradients, grid);
            }
            (Pass::StressAndMove, _) => {
                let stress = Self { pass: Pass::StressAndMove, ..plain };
                stress.take_each::<F, S, BATCH>(chunk, gradients, grid);
            }
            _ => self.take_each::<F, S, BATCH>(chunk, gradients, grid),
        }
    }

    /// `N` at a time: sums over nodes go through memory, whence registers take several numbers at once.
    #[inline(always)]
    fn take_each<F: ShapeFunction, S: Number, const N: usize>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        grid: &Grid<S, D>,
    ) {
        let mut axes = [Axis::<S, N>::empty(); D];
        let mut sums = [Sums::none(); N];
        let mut begin = 0;
        while begin < gradients.len() {
            let these = begin..gradients.len().min(begin + N);
            let half_length = chunk.half_length.get(these.clone()).unwrap_or_default();
            let (position, base) = (&chunk.position[these.clone()], &chunk.base[these.clone()]);
            self.places.find_axes::<F, S, N>(position, half_length, base, &mut axes);
            let (sums, node) = (&mut sums[..these.len()], &chunk.node[these.clone()]);
            for p in 0..node.len() {
                let nodes = &grid.from(node[p])[..nodes_spanned::<F, D>()];
                self.sum::<F, S, N>((&axes, p), nodes, &mut sums[p]);
            }
            for (p, sums) in these.clone().zip(sums) {
                self.apply::<F, S>(chunk, p, sums, &mut gradients[p]);
            }
            begin = these.end;
        }
    }

    #[inline(always)]
    fn apply<F: ShapeFunction, S: Number>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        p: usize,
        sums: &Sums<S, D>,
        l: &mut [[S; 3]; 3],
    ) {
        if self.pass.updates_stress() {
            for k in 0..D {
                for m in 0..D {
                    l[k][m] = sums.gradient[m][k] * self.places.per_cell;
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

    /// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8); for shape functions of the hat
    /// `sum_i v_i grad N_i^T`, to which it comes down there.
    #[inline(always)]
    fn matrix<S: Number>(&self, sums: &Sums<S, D>, base: &[i32; D], x: &[S; D]) -> [[S; D]; D] {
        let cell = self.places.cell;
        let mut matrix = sums.moment;
        for l in 0..D {
            let arm = -(x[l] - self.places.origin[l]) + f64::from(base[l]) * cell;
            for k in 0..D {
                matrix[k][l] = match self.inverse_inertia {
                    None => sums.gradient[l][k] * self.places.per_cell,
                    Some(inverse) => (sums.velocity[k] * arm + sums.moment[k][l] * cell) * inverse,
                };
            }
        }
        matrix
    }

    #[inline(always)]
    fn sum<F: ShapeFunction, S: Number, const N: usize>(
        &self,
        (axes, p): (&[Axis<S, N>; D], usize),
        nodes: &[Node<S, D>],
        sums: &mut Sums<S, D>,
    ) {
        let edge = block_edge(D);
        *sums = Sums::none();
        let with_change = self.pass.takes_motion() && (!self.picks || self.shares.0 != 0.0);
        let with_matrix = self.pass.takes_motion() && self.affine;
        let with_gradient =
            self.pass.updates_stress() || (with_matrix && self.inverse_inertia.is_none());
        let with_moment = with_matrix && self.inverse_inertia.is_some();
        let (value, along) = (&axes[0].value, &axes[0].slope);
        for k in 0..nodes_along::<F, D>(2) {
            for j in 0..nodes_along::<F, D>(1) {
                let (weight, slope) = outer(axes, p, (j, k));
                let start = (k * edge + j) * edge;
                let row = &nodes[start..start + F::NODES];
                let (mut velocity, mut change) = ([nothing::<S>(); D], [nothing::<S>(); D]);
                for i in 0..F::NODES {
                    for c in 0..D {
                        velocity[c] = velocity[c] + row[i].motion[c] * value[i][p];
                    }
                    if with_change {
                        for c in 0..D {
                            change[c] = change[c] + row[i].change[c] * value[i][p];
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
                    let mut steep = [nothing::<S>(); D];
                    for i in 0..F::NODES {
                        for c in 0..D {
                            steep[c] = steep[c] + row[i].motion[c] * along[i][p];
                        }
                    }
                    for c in 0..D {
                        sums.gradient[0][c] = sums.gradient[0][c] + steep[c] * weight;
                        for l in 1..D {
                            sums.gradient[l][c] = sums.gradient[l][c] + velocity[c] * slope[l];
                        }
                    }
                }
                if with_moment {
                    let mut moment = [nothing::<S>(); D];
                    for i in 1..F::NODES {
                        for c in 0..D {
                            moment[c] = moment[c] + row[i].motion[c] * (value[i][p] * i as f64);
                        }
                    }
                    for c in 0..D {
                        sums.moment[c][0] = sums.moment[c][0] + moment[c] * weight;
                    }
                }
            }
        }
    }
}

/// What a sum starts with: minus zero, to which anything may be added without a change, so that for plain numbers the compiler
/// leaves the addition out.
#[inline(always)]
fn nothing<S: Number>() -> S {
    S::constant(-0.0)
}

impl<S: Number, const D: usize> Sums<S, D> {
    #[inline(always)]
    fn none() -> Self {
        let (vector, matrix) = ([nothing(); D], [[nothing(); D]; D]);
        Self { velocity: vector, change: vector, gradient: matrix, moment: matrix }
    }
}

//! Shape functions of a particle whose place carries derivatives, as `f64`.
//!
//! $$ N_i(x) = N_i(x_0) + \sum_l N_{i,l}(x_0) \, d_l + \tfrac12 \sum_{l m} N_{i,lm}(x_0) \, d_l d_m, \qquad d = x - x_0 $$
//!
//! `x_0` is the value of the place, so `d` has the value zero: the series ends after the first power for numbers with first
//! derivatives, after the second for those with second ones. It is exact, and `N_i(x_0)` with its derivatives are `f64`.
//! A derivative of order `n` of a product `q d_l ..` with `k` factors `d` is zero unless `k <= n`. So what a node receives of a
//! quantity `q` in the order `n` is a polynomial of degree `n` in the derivatives of `N_i`; for `q dN_i/dx_l`, one of degree
//! `n + 1`.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::LANES;
use simd_lanes::{Lanes, Registers};

use crate::grid::lattice::Lattice;
use crate::grid::tile_size::{MOST_NODES, block_edge};
use crate::number::CarriedNumber;
use crate::transfer::shape::{Axis, nodes_along};

/// Derivatives of a shape function up to the third order, the function itself among them.
pub(crate) const MOST_TERMS: usize = 20;
/// Those of its factor along the axes beyond the first.
const MOST_OUTER: usize = 10;
/// Highest order of a derivative: two of the number, one of the gradient.
const HIGHEST: usize = 3;

/// A derivative of a shape function, of a known order along each axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Derivative {
    /// Order along the first axis.
    along: usize,
    /// Which derivative of the factor along the other axes.
    outer: usize,
    /// The highest order along any axis.
    highest: usize,
}

/// All derivatives in `D` dimensions, sorted by their order.
#[derive(Debug)]
pub(crate) struct Derivatives<const D: usize>;

/// Orders along three axes, sorted by their sum; those with an axis beyond `dimension` are left out.
const fn orders(dimension: usize) -> [[usize; 3]; MOST_TERMS] {
    let (mut all, mut n, mut sum) = ([[0; 3]; MOST_TERMS], 0, 0);
    while sum <= HIGHEST {
        let mut z = 0;
        while z <= sum {
            let mut y = 0;
            while y + z <= sum {
                if (dimension > 1 || y == 0) && (dimension > 2 || z == 0) {
                    all[n] = [sum - y - z, y, z];
                    n += 1;
                }
                y += 1;
            }
            z += 1;
        }
        sum += 1;
    }
    all
}

/// Where orders are among those of `dimension`.
const fn find(dimension: usize, [x, y, z]: [usize; 3]) -> usize {
    let (all, mut t) = (orders(dimension), 0);
    while t < MOST_TERMS && !(all[t][0] == x && all[t][1] == y && all[t][2] == z) {
        t += 1;
    }
    t
}

impl<const D: usize> Derivatives<D> {
    const ORDERS: [[usize; 3]; MOST_TERMS] = orders(D);

    /// Orders along the axes beyond the first.
    const OUTER: [[usize; 2]; MOST_OUTER] = {
        let (all, mut outer, mut t) = (orders(D - 1), [[0; 2]; MOST_OUTER], 0);
        while t < Self::n_outer(HIGHEST) {
            outer[t] = [all[t][0], all[t][1]];
            t += 1;
        }
        outer
    };

    /// All of them.
    pub(crate) const ALL: [Derivative; MOST_TERMS] = {
        let (mut all, mut t) = ([Derivative { along: 0, outer: 0, highest: 0 }; MOST_TERMS], 0);
        while t < Self::count(HIGHEST) {
            let [x, y, z] = Self::ORDERS[t];
            let mut highest = if x > y { x } else { y };
            highest = if z > highest { z } else { highest };
            let outer = if D == 1 { 0 } else { find(D - 1, [y, z, 0]) };
            all[t] = Derivative { along: x, outer, highest };
            t += 1;
        }
        all
    };

    /// The next derivative along each axis, of those below the highest order.
    pub(crate) const NEXT: [[usize; D]; MOST_TERMS] = {
        let (mut all, mut t) = ([[0; D]; MOST_TERMS], 0);
        while t < Self::count(HIGHEST - 1) {
            let mut l = 0;
            while l < D {
                let mut orders = Self::ORDERS[t];
                orders[l] += 1;
                all[t][l] = find(D, orders);
                l += 1;
            }
            t += 1;
        }
        all
    };

    /// What the nodes of a row have in common, by the order along it.
    #[inline(always)]
    fn row<V: Lanes<Number = f64>, const NODES: usize>(
        terms: &[V; MOST_TERMS],
        highest: usize,
        outer: &[f64; MOST_OUTER],
    ) -> [V; HIGHEST + 1] {
        let mut row = [terms[0].splat(-0.0); HIGHEST + 1];
        for t in 0..Self::count(highest) {
            let of = Self::ALL[t];
            if of.highest < NODES {
                let weight = terms[t].splat(outer[of.outer]);
                row[of.along] = row[of.along] + terms[t] * weight;
            }
        }
        row
    }

    /// How many have an order of at most `highest`.
    pub(crate) const fn count(highest: usize) -> usize {
        let n = highest + 1;
        match D {
            1 => n,
            2 => n * (n + 1) / 2,
            _ => n * (n + 1) * (n + 2) / 6,
        }
    }

    /// The same of the factor along the axes beyond the first.
    const fn n_outer(highest: usize) -> usize {
        let n = highest + 1;
        match D {
            1 => 1,
            2 => n,
            _ => n * (n + 1) / 2,
        }
    }
}

/// Derivatives of the shape function of a particle at the value of its place, per cell, at all nodes that it sees. A B-spline
/// over `NODES` nodes is a polynomial of degree `NODES - 1`: higher derivatives along an axis are zero.
#[derive(Debug)]
pub(crate) struct TaylorWeights<const NODES: usize, const D: usize> {
    /// Of the factor along the first axis, by order and node.
    pub(crate) along: [[f64; MOST_NODES]; HIGHEST + 1],
    /// Of the factor along the other axes, by row of nodes.
    pub(crate) outer: [[f64; MOST_OUTER]; MOST_NODES * MOST_NODES],
}

impl<const NODES: usize, const D: usize> TaylorWeights<NODES, D> {
    #[inline(always)]
    pub(crate) fn none() -> Self {
        Self {
            along: [[0.0; MOST_NODES]; HIGHEST + 1],
            outer: [[0.0; MOST_OUTER]; MOST_NODES * MOST_NODES],
        }
    }

    /// Those of `N + c N''`, the second derivative along the first axis.
    #[inline(always)]
    pub(crate) fn with_curvature(&self, c: f64) -> Self {
        let Self { mut along, outer } = *self;
        for order in 0..=HIGHEST - 2 {
            for i in 0..NODES {
                along[order][i] += c * self.along[order + 2][i];
            }
        }
        Self { along, outer }
    }

    /// Those of a particle, from the lowest node that it sees.
    #[inline(always)]
    pub(crate) fn find<S: CarriedNumber>(
        &mut self,
        lattice: &Lattice<D>,
        position: &[S; D],
        lowest: &[i32; D],
    ) {
        let mut axes = [[[0.0; MOST_NODES]; HIGHEST + 1]; D];
        for k in 0..D {
            let s = (position[k].value() - lattice.origin[k]) * lattice.per_cell;
            axes[k] = derivatives_along::<NODES>(s, lowest[k]);
        }
        self.along = axes[0];
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let outer = &mut self.outer[k * NODES + j];
                for t in 0..Derivatives::<D>::n_outer(HIGHEST) {
                    let [y, z] = Derivatives::<D>::OUTER[t];
                    outer[t] = match D {
                        1 => 1.0,
                        2 => axes[1][y][j],
                        _ => axes[D.min(2) - 1][y][j] * axes[D - 1][z][k],
                    };
                }
            }
        }
    }
}

/// Value and derivatives of the shape functions of the nodes along one axis, per cell, by order and node.
#[inline(always)]
fn derivatives_along<const NODES: usize>(s: f64, lowest: i32) -> [[f64; MOST_NODES]; HIGHEST + 1] {
    let mut axis = Axis::<f64>::empty();
    axis.set_b_spline::<NODES>(s, lowest);
    let (second, third) = if NODES == 3 {
        ([1.0, -2.0, 1.0, 0.0], [0.0; MOST_NODES])
    } else {
        let f = s - f64::from(lowest + 1);
        let rest = 1.0 - f;
        ([rest, 3.0 * f - 2.0, 3.0 * rest - 2.0, f], [-1.0, 3.0, -3.0, 1.0])
    };
    [axis.value, axis.slope, second, third]
}

/// Derivatives of the place of a particle in a register of directions, in cells.
#[derive(Debug)]
pub(crate) struct Shift<V, const D: usize> {
    pub(crate) first: [V; D],
    pub(crate) second: [V; D],
}

impl<V: Lanes<Number = f64>, const D: usize> Shift<V, D> {
    #[inline(always)]
    pub(crate) fn load<S: CarriedNumber, R: Registers<f64, Vector = V>>(
        registers: R,
        position: &[S; D],
        per_cell: f64,
        at: usize,
    ) -> Self {
        let (mut first, mut second) = ([registers.splat(0.0); D], [registers.splat(0.0); D]);
        let per_cell = registers.splat(per_cell);
        for k in 0..D {
            first[k] = load(registers, &position[k], 1, at) * per_cell;
            second[k] = load(registers, &position[k], 2, at) * per_cell;
        }
        Self { first, second }
    }
}

/// The derivatives of a number in the register of directions that begins with `at`.
#[inline(always)]
pub(crate) fn load<S: CarriedNumber, R: Registers<f64>>(
    registers: R,
    number: &S,
    order: usize,
    at: usize,
) -> R::Vector {
    match number.derivatives(order) {
        Some(derivatives) => registers.load_at(derivatives, at),
        None => registers.splat(0.0),
    }
}

/// Writes them.
#[inline(always)]
pub(crate) fn store<S: CarriedNumber, R: Registers<f64>>(
    registers: R,
    vector: R::Vector,
    (number, order): (&mut S, usize),
    at: usize,
) {
    if let Some(derivatives) = number.derivatives_mut(order) {
        registers.store_at(vector, derivatives, at);
    }
}

/// Adds to them.
#[inline(always)]
pub(crate) fn add<S: CarriedNumber, R: Registers<f64>>(
    registers: R,
    vector: R::Vector,
    (number, order): (&mut S, usize),
    at: usize,
) {
    if let Some(derivatives) = number.derivatives_mut(order) {
        let sum = registers.load_at(derivatives, at) + vector;
        registers.store_at(sum, derivatives, at);
    }
}

/// The first direction of each register of them; one register for a number without derivatives.
#[inline(always)]
pub(crate) fn registers_of_directions<S: CarriedNumber, R: Registers<f64>>()
-> impl Iterator<Item = usize> {
    (0..if S::ORDER == 0 { 1 } else { LANES }).step_by(R::N)
}

impl<const NODES: usize, const D: usize> TaylorWeights<NODES, D> {
    /// `sum_t terms_t N_i^(t)` at every node, over the derivatives `t` up to the order `highest`: `add(i, sum)`. With an axis
    /// `times`, multiplied by the number of the node along it.
    #[inline(always)]
    pub(crate) fn spread<V: Lanes<Number = f64>>(
        &self,
        (terms, times): (&[V; MOST_TERMS], Option<usize>),
        highest: usize,
        mut add: impl FnMut(usize, V),
    ) {
        let (edge, nothing) = (block_edge(D), terms[0].splat(-0.0));
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let outer = &self.outer[k * NODES + j];
                let row = Derivatives::<D>::row::<V, NODES>(terms, highest, outer);
                for i in 0..NODES {
                    let mut sum = nothing;
                    for a in 0..=highest.min(NODES - 1) {
                        sum = sum + row[a] * nothing.splat(self.along[a][i]);
                    }
                    if let Some(l) = times {
                        sum = sum * nothing.splat([i, j, k][l] as f64);
                    }
                    add((k * edge + j) * edge + i, sum);
                }
            }
        }
    }

    /// `sum_i u_i N_i^(t)` for the derivatives `t` up to the order `highest`, with `u_i = read(i)`; with an axis `times`, of
    /// `u_i` times the number of the node along it.
    #[inline(always)]
    pub(crate) fn gather<V: Lanes<Number = f64>>(
        &self,
        (nothing, times): (V, Option<usize>),
        highest: usize,
        read: impl Fn(usize) -> V,
    ) -> [V; MOST_TERMS] {
        let (edge, mut sums) = (block_edge(D), [nothing; MOST_TERMS]);
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let mut row = [nothing; HIGHEST + 1];
                for i in 0..NODES {
                    let value = read((k * edge + j) * edge + i);
                    for a in 0..=highest.min(NODES - 1) {
                        let mut weight = self.along[a][i];
                        if let Some(l) = times {
                            weight *= if l == 0 { i as f64 } else { 1.0 };
                        }
                        row[a] = row[a] + value * nothing.splat(weight);
                    }
                }
                let outer = &self.outer[k * NODES + j];
                for t in 0..Derivatives::<D>::count(highest) {
                    let of = Derivatives::<D>::ALL[t];
                    if of.highest < NODES {
                        let mut here = row[of.along] * nothing.splat(outer[of.outer]);
                        if let Some(l) = times {
                            here = here * nothing.splat([1.0, j as f64, k as f64][l]);
                        }
                        sums[t] = sums[t] + here;
                    }
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::shape::{Shape, lowest_node};
    use perturbation_moments::Jet;

    fn check<const NODES: usize>(shape: Shape) {
        for step in 0..100 {
            let s = 0.31 + 0.01 * f64::from(step);
            let lowest = lowest_node(s, shape.reach());
            let mut axis = Axis::<Jet>::empty();
            axis.set_b_spline::<NODES>(Jet::variable(s, 0), lowest);
            let plain = derivatives_along::<NODES>(s, lowest);
            for i in 0..NODES {
                let (value, slope) = (axis.value[i], axis.slope[i]);
                assert_eq!((plain[0][i], plain[1][i]), (value.value, slope.value));
                // roundoff: numbers of order one.
                assert!((plain[2][i] - value.second[0]).abs() < 4e-15);
                assert!((plain[2][i] - slope.first[0]).abs() < 4e-15);
                assert!((plain[3][i] - slope.second[0]).abs() < 4e-15);
            }
        }
    }

    #[test]
    fn derivatives_as_plain_numbers_are_those_that_jets_carry() {
        check::<3>(Shape::QuadraticBSpline);
        check::<4>(Shape::CubicBSpline);
    }

    #[test]
    fn derivatives_are_numbered_by_their_order_and_the_next_one_is_one_higher() {
        fn check_numbers<const D: usize>() {
            for t in 0..Derivatives::<D>::count(HIGHEST) {
                let [x, y, z] = Derivatives::<D>::ORDERS[t];
                let order = x + y + z;
                assert!(t < Derivatives::<D>::count(order));
                assert!(order == 0 || t >= Derivatives::<D>::count(order - 1));
                let of = Derivatives::<D>::ALL[t];
                assert_eq!((of.along, Derivatives::<D>::OUTER[of.outer]), (x, [y, z]));
                assert_eq!(of.highest, x.max(y).max(z));
                for l in (0..D).filter(|_| order < HIGHEST) {
                    let mut next = [x, y, z];
                    next[l] += 1;
                    assert_eq!(Derivatives::<D>::ORDERS[Derivatives::<D>::NEXT[t][l]], next);
                }
            }
        }
        check_numbers::<1>();
        check_numbers::<2>();
        check_numbers::<3>();
    }
}

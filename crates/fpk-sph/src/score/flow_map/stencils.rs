//! Stencils of local polynomials over a lattice.

use std::collections::HashMap;
use std::ops::Range;

use neighbour_search::NeighbourList;

use super::arrangement::{Turn, Turned};
use super::pattern::Pattern;
use crate::error::Error;
use crate::score::Fits;

/// The local polynomials of all lattice points. Points whose neighbours are arranged alike, but for reflections and
/// permutations of the axes, share their weights: inside a lattice all do.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stencils<const D: usize> {
    /// Members of point `i`, itself included, in the order of its class: `members[start[i]..start[i + 1]]`.
    start: Vec<usize>,
    members: Vec<u32>,
    /// The class of each point, and how its arrangement is turned into that of the class.
    of_point: Vec<(u32, Turn<D>)>,
    classes: Vec<Pattern<D>>,
    /// Points at the rim, in an order in which each has a member inside or before it.
    rim: Vec<Rim>,
    /// What the points at the rim take from members before them, with weights that sum to 1.
    links: Vec<(u32, f64)>,
    /// The layer of a point at the rim, from 1 on; 0 inside.
    rank: Vec<u32>,
    /// How well the lattice determines the polynomials.
    pub(crate) fits: Fits,
}

/// A point at the rim and its links.
#[derive(Debug, Clone)]
struct Rim {
    i: usize,
    links: Range<usize>,
}

/// The members of a point with their weights, which are along the axes of its class.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil<'a, const D: usize> {
    pub(crate) members: &'a [u32],
    pub(crate) weights: &'a Pattern<D>,
    pub(crate) turn: &'a Turn<D>,
}

/// A point with fewer than this part of the members of a point inside lies at the rim. By the eigenvalues of the
/// linearised diffusion on balls in 2-D: from 0.65 to 1 no mode grows, while one-sided gradients of every point of the rim
/// give growth rates up to 9 per unit of whitened time.
pub(crate) const RIM: f64 = 0.65;

/// Wavelengths at which the gradient is looked at.
const WAVES: usize = 64;

impl<const D: usize> Stencils<D> {
    /// The polynomials of degree at most `degree` over lattice points within `reach` spacings, by Lucy's weights.
    /// `places` in spacings; `neighbours` within the reach, rows ascending.
    pub(crate) fn new(
        places: &[[f64; D]],
        neighbours: &NeighbourList,
        reach: f64,
        degree: usize,
    ) -> Result<Self, Error> {
        let n = places.len();
        let mut stencils = Self { start: vec![0], ..Self::default() };
        let mut known: HashMap<Vec<[i32; D]>, u32> = HashMap::new();
        // The arrangement of the point before; inside the lattice it is that of the next point too.
        let (mut offsets, mut turned, mut class) = (Vec::new(), Turned::of(&[]), 0);
        let mut members = Vec::new();
        for (i, row) in neighbours.rows().enumerate() {
            let own = u32::try_from(i).map_err(|_| too_many(n))?;
            let at = row.partition_point(|&j| j < own);
            members.clear();
            members.extend_from_slice(&row[..at]);
            members.push(own);
            members.extend_from_slice(&row[at..]);
            let offset = |&j: &u32| -> [i32; D] {
                #[allow(
                    clippy::cast_possible_truncation,
                    reason = "whole numbers within the reach"
                )]
                std::array::from_fn(|k| (places[j as usize][k] - places[i][k]) as i32)
            };
            if i == 0 || !members.iter().map(offset).eq(offsets.iter().copied()) {
                offsets.clear();
                offsets.extend(members.iter().map(offset));
                turned = Turned::of(&offsets);
                class = if let Some(&class) = known.get(&turned.offsets) {
                    class
                } else {
                    let fresh = u32::try_from(stencils.classes.len()).map_err(|_| too_many(n))?;
                    stencils.classes.push(Pattern::new(&turned.offsets, reach, degree, i)?);
                    known.insert(turned.offsets.clone(), fresh);
                    fresh
                };
            }
            stencils.members.extend(turned.order.iter().map(|&t| members[t as usize]));
            stencils.fits = stencils.fits.and(stencils.classes[class as usize].fits);
            stencils.of_point.push((class, turned.turn));
            stencils.start.push(stencils.members.len());
        }
        stencils.find_rim()?;
        Ok(stencils)
    }

    /// Orders the points of the rim from the inside outward.
    fn find_rim(&mut self) -> Result<(), Error> {
        let n = self.of_point.len();
        let full = (0..n).map(|i| self.start[i + 1] - self.start[i]).max().unwrap_or(0);
        let inside = |i: usize| (self.start[i + 1] - self.start[i]) as f64 >= RIM * full as f64;
        let mut rank: Vec<u32> = (0..n).map(|i| if inside(i) { 0 } else { u32::MAX }).collect();
        let (mut layer, mut missing) = (1, rank.iter().filter(|&&r| r > 0).count());
        while missing > 0 {
            let touches = |i: &usize| self.of(*i).members.iter().any(|&j| rank[j as usize] < layer);
            let next: Vec<usize> =
                (0..n).filter(|&i| rank[i] == u32::MAX).filter(touches).collect();
            if next.is_empty() {
                let particle = rank.iter().position(|&r| r == u32::MAX).unwrap_or(0);
                return Err(Error::NoLatticeCell { particle });
            }
            for &i in &next {
                let links = self.link(i, |j| rank[j] < layer);
                self.rim.push(Rim { i, links });
            }
            for &i in &next {
                rank[i] = layer;
            }
            missing -= next.len();
            layer += 1;
        }
        self.rank = rank;
        Ok(())
    }

    /// Links a point to those of its members that are known before it.
    fn link(&mut self, i: usize, is_before: impl Fn(usize) -> bool) -> Range<usize> {
        let (start, members) = (self.links.len(), self.start[i]..self.start[i + 1]);
        let weights = &self.classes[self.of_point[i].0 as usize].mean;
        let all = self.members[members].iter().zip(weights);
        self.links.extend(all.filter(|(j, _)| is_before(**j as usize)).map(|(&j, &w)| (j, w)));
        let links = &mut self.links[start..];
        let total: f64 = links.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in links {
            *weight /= total;
        }
        start..self.links.len()
    }

    /// The largest magnitude that the gradient inside the lattice gives to a wave along an axis of amplitude 1, per
    /// spacing: `max |sum_j g_jk exp(i theta o_jk)|` over axes `k` and `0 < theta <= pi`, with offsets `o`.
    pub(crate) fn steepest_wave(&self, places: &[[f64; D]]) -> f64 {
        let inside = |&i: &usize| self.start[i + 1] - self.start[i];
        let Some(i) = (0..places.len()).max_by_key(inside) else { return 0.0 };
        let stencil = self.of(i);
        let mut steepest = 0.0_f64;
        for k in 0..D {
            for step in 1..=WAVES {
                let theta = std::f64::consts::PI * step as f64 / WAVES as f64;
                let (mut real, mut imaginary) = (0.0, 0.0);
                for (t, &j) in stencil.members.iter().enumerate() {
                    let (sin, cos) = (theta * (places[j as usize][k] - places[i][k])).sin_cos();
                    let weight = stencil.gradient(t)[k];
                    real += weight * cos;
                    imaginary += weight * sin;
                }
                steepest = steepest.max(real.hypot(imaginary));
            }
        }
        steepest
    }

    /// Stencil of the local fit of a point, with its weights.
    #[inline]
    pub(crate) fn of(&self, i: usize) -> Stencil<'_, D> {
        let (class, turn) = &self.of_point[i];
        Stencil {
            members: &self.members[self.start[i]..self.start[i + 1]],
            weights: &self.classes[*class as usize],
            turn,
        }
    }

    /// The class of a point, by its number.
    pub(crate) fn class_of(&self, i: usize) -> usize {
        self.of_point[i].0 as usize
    }

    /// All classes, by their numbers.
    pub(crate) fn classes(&self) -> &[Pattern<D>] {
        &self.classes
    }

    /// Whether the members of point `i + 1` are those of point `i`, each one further on.
    pub(crate) fn advances(&self, i: usize) -> bool {
        let [members, next] = [i, i + 1].map(|i| self.of(i).members);
        self.of_point[i] == self.of_point[i + 1]
            && members.iter().zip(next).all(|(j, next)| j + 1 == *next)
    }

    /// Whether a point lies at the rim.
    #[inline]
    pub(crate) fn at_rim(&self, i: usize) -> bool {
        self.rank[i] > 0
    }

    /// The score at the rim: that of a Gaussian, `-y`, and the mean of what members further inside have beyond it. It goes
    /// from the inside outward.
    pub(crate) fn score_at_rim(&self, y: &[[f64; D]], score: &mut [[f64; D]]) {
        for Rim { i, links } in &self.rim {
            let mut mean = [0.0; D];
            for &(j, weight) in &self.links[links.clone()] {
                let (score, y) = (&score[j as usize], &y[j as usize]);
                for k in 0..D {
                    mean[k] += weight * (score[k] + y[k]);
                }
            }
            score[*i] = std::array::from_fn(|k| mean[k] - y[*i][k]);
        }
    }
}

impl<const D: usize> Stencil<'_, D> {
    /// The weights of member `t` in the gradient, along the axes of the lattice.
    pub(crate) fn gradient(&self, t: usize) -> [f64; D] {
        self.turn.back(&self.weights.gradient[t])
    }

    /// The weights of member `t` in the second derivatives, along the axes of the lattice.
    pub(crate) fn hessian(&self, t: usize) -> [[f64; D]; D] {
        self.turn.back_matrix(&self.weights.hessian[t])
    }

    /// `sum_j gradient_j f_j`, along the axes of the lattice.
    pub(crate) fn gradient_of(&self, f: &[f64]) -> [f64; D] {
        let mut gradient = [0.0; D];
        for (&j, weight) in self.members.iter().zip(&self.weights.gradient) {
            let f_j = f[j as usize];
            for k in 0..D {
                gradient[k] += weight[k] * f_j;
            }
        }
        self.turn.back(&gradient)
    }
}

fn too_many(n: usize) -> Error {
    Error::TooManyParticles { count: n, limit: u32::MAX as usize }
}

#[cfg(test)]
mod tests {
    use neighbour_search::{CellGrid, NeighbourSearch, Radii};
    use particle_store::Lattice;

    use super::*;

    fn stencils<const D: usize>(lattice: &Lattice<D>, reach: f64, degree: usize) -> Stencils<D> {
        let places: Vec<[f64; D]> = lattice.indices.iter().map(|i| i.map(f64::from)).collect();
        let mut list = NeighbourList::new();
        CellGrid::new().full_list(&places, Radii::Uniform(reach), &mut list).unwrap();
        list.sort_rows();
        Stencils::new(&places, &list, reach, degree).unwrap()
    }

    #[test]
    fn a_cubic_is_differentiated_exactly_wherever_the_fit_is_cubic() {
        let lattice = Lattice::<2>::ball_lattice(5.0, 1.0).unwrap();
        let stencils = stencils(&lattice, 2.8, 3);
        let f = |[x, y]: [f64; 2]| 0.3 + x - 2.0 * y + 0.1 * x * x * y - 0.05 * y * y * y;
        let values: Vec<f64> = lattice.points.iter().map(|&p| f(p)).collect();
        for (i, &[x, y]) in lattice.points.iter().enumerate() {
            if stencils.of(i).members.len() < 15 {
                continue;
            }
            let [g_x, g_y] = stencils.of(i).gradient_of(&values);
            let expected = [1.0 + 0.2 * x * y, -2.0 + 0.1 * x * x - 0.15 * y * y];
            // Roundoff of values up to 10 times weights whose size is about 1.
            assert!((g_x - expected[0]).abs() < 1e-12 && (g_y - expected[1]).abs() < 1e-12);
            let mut hessian = [[0.0; 2]; 2];
            for (t, &j) in stencils.of(i).members.iter().enumerate() {
                let weight = stencils.of(i).hessian(t);
                for (sum, weight) in
                    hessian.as_flattened_mut().iter_mut().zip(weight.as_flattened())
                {
                    *sum += weight * values[j as usize];
                }
            }
            let expected = [[0.2 * y, 0.2 * x], [0.2 * x, -0.3 * y]];
            for (sum, expected) in hessian.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((sum - expected).abs() < 1e-12, "point {i}: {sum} against {expected}");
            }
        }
    }

    #[test]
    fn points_inside_share_one_class_and_turn_and_every_point_of_the_rim_has_one_before_it() {
        let lattice = Lattice::<3>::ball_lattice(6.0, 1.0).unwrap();
        let stencils = stencils(&lattice, 2.8, 3);
        let full = (0..lattice.points.len()).map(|i| stencils.of(i).members.len()).max().unwrap();
        let inside = (0..lattice.points.len()).filter(|&i| stencils.of(i).members.len() == full);
        let of_inside: Vec<_> = inside.map(|i| stencils.of_point[i]).collect();
        assert!(of_inside.len() > 100 && of_inside.iter().all(|p| *p == of_inside[0]));
        for Rim { i, links } in &stencils.rim {
            assert!(!links.is_empty(), "point {i}");
            let total: f64 = stencils.links[links.clone()].iter().map(|link| link.1).sum();
            // Roundoff of a sum of at most 123 terms.
            assert!((total - 1.0).abs() < 1e-14, "point {i}: {total}");
        }
    }
}

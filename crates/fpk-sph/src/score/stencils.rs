//! Stencils and constant weights of local polynomials over a lattice.

use std::collections::HashMap;
use std::ops::Range;

use neighbour_search::NeighbourList;
use smoothing_kernels::{Kernel, Lucy, power};

use super::Fits;
use super::fit_points::Points;
use super::monomials::{Monomials, unknowns};
use super::polynomial_fit::LeastSquares;
use crate::error::Error;

/// The local polynomials of all lattice points. Points with the same neighbours share their weights: inside a lattice all
/// do.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stencils<const D: usize> {
    /// Members of point `i`, itself included: `members[start[i]..start[i + 1]]`.
    start: Vec<usize>,
    members: Vec<u32>,
    pattern_of: Vec<u32>,
    patterns: Vec<Pattern<D>>,
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

/// The weights of one arrangement of neighbours; one entry per member.
#[derive(Debug, Clone)]
pub(crate) struct Pattern<const D: usize> {
    /// Places of the members against the point, in spacings.
    pub(crate) offsets: Vec<[i32; D]>,
    /// Whether the first member is opposite to the last, the second to the last but one, and so on.
    pub(crate) is_symmetric: bool,
    /// Positive weights that sum to 1: a local mean.
    pub(crate) mean: Vec<f64>,
    /// The polynomial's value at the point.
    pub(crate) value: Vec<f64>,
    /// Its gradient, per spacing.
    pub(crate) gradient: Vec<[f64; D]>,
    /// Its second derivatives, per spacing squared; zero where it is linear.
    pub(crate) hessian: Vec<[[f64; D]; D]>,
    /// How well the arrangement determines the polynomial.
    fits: Fits,
}

/// The members of a point with their weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil<'a, const D: usize> {
    pub(crate) members: &'a [u32],
    pub(crate) weights: &'a Pattern<D>,
}

/// Points per unknown of a local polynomial: fewer, and its degree is lowered.
const POINTS_PER_UNKNOWN: f64 = 1.5;

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
        for (i, row) in neighbours.rows().enumerate() {
            let own = u32::try_from(i).map_err(|_| too_many(n))?;
            let at = row.partition_point(|&j| j < own);
            stencils.members.extend_from_slice(&row[..at]);
            stencils.members.push(own);
            stencils.members.extend_from_slice(&row[at..]);
            let members = &stencils.members[stencils.start[i]..];
            let offsets: Vec<[i32; D]> = members
                .iter()
                .map(|&j| {
                    #[allow(
                        clippy::cast_possible_truncation,
                        reason = "whole numbers within the reach"
                    )]
                    std::array::from_fn(|k| (places[j as usize][k] - places[i][k]).round() as i32)
                })
                .collect();
            let pattern = if let Some(&pattern) = known.get(&offsets) {
                pattern
            } else {
                let fresh = u32::try_from(stencils.patterns.len()).map_err(|_| too_many(n))?;
                stencils.patterns.push(Pattern::new(&offsets, reach, degree, i)?);
                known.insert(offsets, fresh);
                fresh
            };
            stencils.fits = stencils.fits.and(stencils.patterns[pattern as usize].fits);
            stencils.pattern_of.push(pattern);
            stencils.start.push(stencils.members.len());
        }
        stencils.find_rim()?;
        Ok(stencils)
    }

    /// Orders the points of the rim from the inside outward.
    fn find_rim(&mut self) -> Result<(), Error> {
        let n = self.pattern_of.len();
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
        let weights = &self.patterns[self.pattern_of[i] as usize].mean;
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
                for (&j, weight) in stencil.members.iter().zip(&stencil.weights.gradient) {
                    let (sin, cos) = (theta * (places[j as usize][k] - places[i][k])).sin_cos();
                    real += weight[k] * cos;
                    imaginary += weight[k] * sin;
                }
                steepest = steepest.max(real.hypot(imaginary));
            }
        }
        steepest
    }

    /// Stencil of the local fit of a point, with its weights.
    #[inline]
    pub(crate) fn of(&self, i: usize) -> Stencil<'_, D> {
        Stencil {
            members: &self.members[self.start[i]..self.start[i + 1]],
            weights: &self.patterns[self.pattern_of[i] as usize],
        }
    }

    /// The pattern of a point, by its number.
    pub(crate) fn pattern_of(&self, i: usize) -> u32 {
        self.pattern_of[i]
    }

    /// A pattern by its number.
    pub(crate) fn pattern(&self, number: u32) -> &Pattern<D> {
        &self.patterns[number as usize]
    }

    /// Whether the members of point `i + 1` are those of point `i`, each one further on.
    pub(crate) fn advances(&self, i: usize) -> bool {
        let [members, next] = [i, i + 1].map(|i| self.of(i).members);
        self.pattern_of[i] == self.pattern_of[i + 1]
            && members.iter().zip(next).all(|(j, next)| j + 1 == *next)
    }

    /// Whether a point lies at the rim.
    #[inline]
    pub(crate) fn at_rim(&self, i: usize) -> bool {
        self.rank[i] > 0
    }

    /// The score at the rim: that of a Gaussian, `-y`, and the mean of what members further inside have beyond it. From the
    /// inside outward.
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
    /// `sum_j gradient_j f_j`.
    #[inline]
    pub(crate) fn gradient_of(&self, f: &[f64]) -> [f64; D] {
        let mut gradient = [0.0; D];
        for (&j, weight) in self.members.iter().zip(&self.weights.gradient) {
            let f_j = f[j as usize];
            for k in 0..D {
                gradient[k] += weight[k] * f_j;
            }
        }
        gradient
    }
}

impl<const D: usize> Pattern<D> {
    fn new(
        offsets: &[[i32; D]],
        reach: f64,
        degree: usize,
        particle: usize,
    ) -> Result<Self, Error> {
        let count = offsets.len();
        let tables = Monomials::carried_by::<D>(count, degree, POINTS_PER_UNKNOWN)
            .ok_or(Error::TooFewNeighbours { step: 0, time: 0.0, particle, count, limit: D + 2 })?;
        let n = tables.n_unknowns;
        let mut fit = LeastSquares::new(tables);
        let points: Vec<_> = offsets.iter().map(|offset| weighted(offset, reach)).collect();
        fit.sum_in_all(&Points::of(&points));
        let asked = unknowns(D, degree);
        let fits = Fits::of(n, asked, fit.factorise()[0]);
        // Value, gradient, second derivatives.
        let mut weights = fit.weights(&points, 1 + D + D * (D + 1) / 2).into_iter();
        let mut next = || weights.next().unwrap_or_default();
        let mut pattern = Self {
            offsets: offsets.to_vec(),
            is_symmetric: false,
            mean: Vec::with_capacity(count),
            value: next(),
            gradient: vec![[0.0; D]; count],
            hessian: vec![[[0.0; D]; D]; count],
            fits,
        };
        let total: f64 = points.iter().map(|(_, w)| w).sum();
        pattern.mean.extend(points.iter().map(|(_, w)| w / total));
        for k in 0..D {
            for (entry, weight) in pattern.gradient.iter_mut().zip(next()) {
                entry[k] = weight / reach;
            }
        }
        for k in 0..D {
            for l in k..D {
                let factor = if k == l { 2.0 } else { 1.0 } / power::<2>(reach);
                for (entry, weight) in pattern.hessian.iter_mut().zip(next()) {
                    entry[k][l] = factor * weight;
                    entry[l][k] = factor * weight;
                }
            }
        }
        pattern.make_symmetric();
        Ok(pattern)
    }

    /// Gives the weights the symmetries of the offsets, which roundoff of the fit has broken: those of reflections along
    /// an axis, and that of opposite members.
    fn make_symmetric(&mut self) {
        for axis in 0..D {
            if let Some(mirror) = self.mirror(|k| k == axis) {
                self.symmetrise(&mirror, |k| k == axis);
            }
        }
        let last = self.offsets.len() - 1;
        if let Some(mirror) = self.mirror(|_| true) {
            self.symmetrise(&mirror, |_| true);
            self.is_symmetric =
                mirror.iter().enumerate().all(|(t, &opposite)| opposite == last - t);
        }
    }

    /// For each member the one with the given components of its offset reversed; none where one of them is missing.
    fn mirror(&self, is_reversed: impl Fn(usize) -> bool) -> Option<Vec<usize>> {
        let reversed = |offset: &[i32; D]| -> [i32; D] {
            std::array::from_fn(|k| if is_reversed(k) { -offset[k] } else { offset[k] })
        };
        let place = |offset| self.offsets.iter().position(|other| *other == reversed(offset));
        self.offsets.iter().map(place).collect()
    }

    /// Replaces the weights of members and their mirror images by the mean of both.
    fn symmetrise(&mut self, mirror: &[usize], is_reversed: impl Fn(usize) -> bool) {
        let mean = |weights: &mut [f64], t: usize, image: usize| {
            let both = 0.5 * (weights[t] + weights[image]);
            (weights[t], weights[image]) = (both, both);
        };
        let sign = |k: usize| if is_reversed(k) { -1.0 } else { 1.0 };
        for (t, &image) in mirror.iter().enumerate().filter(|(t, image)| t <= image) {
            mean(&mut self.mean, t, image);
            mean(&mut self.value, t, image);
            for k in 0..D {
                let both = 0.5 * (self.gradient[t][k] + sign(k) * self.gradient[image][k]);
                self.gradient[t][k] = both;
                self.gradient[image][k] = sign(k) * both;
                for l in 0..D {
                    let sign = sign(k) * sign(l);
                    let both = 0.5 * (self.hessian[t][k][l] + sign * self.hessian[image][k][l]);
                    self.hessian[t][k][l] = both;
                    self.hessian[image][k][l] = sign * both;
                }
            }
        }
    }
}

/// A place in units of the reach, with Lucy's weight.
fn weighted<const D: usize>(offset: &[i32; D], reach: f64) -> ([f64; D], f64) {
    let u = offset.map(|k| f64::from(k) / reach);
    let q = u.iter().map(|c| c * c).sum::<f64>().sqrt();
    (u, <Lucy as Kernel<D>>::shape(&Lucy, q * <Lucy as Kernel<D>>::support(&Lucy)))
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
        }
    }

    #[test]
    fn points_inside_share_one_pattern_and_every_point_of_the_rim_has_one_before_it() {
        let lattice = Lattice::<3>::ball_lattice(6.0, 1.0).unwrap();
        let stencils = stencils(&lattice, 2.8, 3);
        let full = (0..lattice.points.len()).map(|i| stencils.of(i).members.len()).max().unwrap();
        let inside = (0..lattice.points.len()).filter(|&i| stencils.of(i).members.len() == full);
        let patterns: Vec<u32> = inside.map(|i| stencils.pattern_of[i]).collect();
        assert!(patterns.len() > 100 && patterns.iter().all(|p| *p == patterns[0]));
        for Rim { i, links } in &stencils.rim {
            assert!(!links.is_empty(), "point {i}");
            let total: f64 = stencils.links[links.clone()].iter().map(|link| link.1).sum();
            // Roundoff of a sum of at most 123 terms.
            assert!((total - 1.0).abs() < 1e-14, "point {i}: {total}");
        }
    }
}

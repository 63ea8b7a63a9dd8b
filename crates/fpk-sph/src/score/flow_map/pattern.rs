//! Constant weights of a local polynomial over lattice neighbours.

use smoothing_kernels::{Kernel, Lucy, power};

use super::arrangement::place_of;
use crate::error::Error;
use crate::score::Fits;
use crate::score::monomials::{Monomials, unknowns};
use crate::score::polynomial_fit::LeastSquares;

/// The weights of a class of arrangements of neighbours, along the axes of the class; one entry per member.
#[derive(Debug, Clone)]
pub(crate) struct Pattern<const D: usize> {
    /// Places of the members against the point, in spacings.
    offsets: Vec<[i32; D]>,
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
    pub(crate) fits: Fits,
}

/// Points per unknown of a local polynomial: fewer, and its degree is lowered.
const POINTS_PER_UNKNOWN: f64 = 1.5;

impl<const D: usize> Pattern<D> {
    /// The weights of members at the given offsets, in the order of their class, by Lucy's weights over `reach` spacings.
    /// `particle` has this arrangement.
    ///
    /// # Errors
    /// [`Error::TooFewNeighbours`] where the members do not carry a linear polynomial.
    pub(crate) fn new(
        offsets: &[[i32; D]],
        reach: f64,
        degree: usize,
        particle: usize,
    ) -> Result<Self, Error> {
        let count = offsets.len();
        let tables = Monomials::carried_by::<D>(count, degree, POINTS_PER_UNKNOWN)
            .ok_or(Error::TooFewNeighbours { step: 0, time: 0.0, particle, count, limit: D + 2 })?;
        let n = tables.n_unknowns;
        let points: Vec<_> = offsets.iter().map(|offset| weighted(offset, reach)).collect();
        let (fit, determined) = LeastSquares::new(tables, &points);
        let fits = Fits::of(n, unknowns(D, degree), determined);
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
        self.offsets.iter().map(|offset| place_of(&self.offsets, &reversed(offset))).collect()
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

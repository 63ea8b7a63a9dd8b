//! Products of eigenfunctions on a box.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::correlations::correlation::{Correlation, CorrelationFunction};
use crate::correlations::spatial_correlation::{Axes, SpatialCorrelation};
use crate::error::Error;
use crate::modes::exponential_modes::ExponentialModes;
use crate::modes::truncation::{MOST_TERMS, Truncation};

/// Distance outside of the box, in units of its side, that is roundoff of a coordinate.
const ROUNDOFF: f64 = 1e-9;

/// Eigenfunctions of a product of exponential correlations on a box: products of those along its axes, ordered by eigenvalue.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BoxModes<const D: usize> {
    axes: Axes<D>,
    centre: [f64; D],
    half: [f64; D],
    along: [ExponentialModes; D],
    /// For each term the mode along each axis.
    indices: Vec<[usize; D]>,
    /// Eigenvalues over the volume of the box, descending.
    shares: Vec<f64>,
}

/// A product of modes that may be the next term.
struct Candidate<const D: usize> {
    share: f64,
    index: [usize; D],
    /// The last axis along which the mode is not the first.
    last: usize,
}

impl<const D: usize> BoxModes<D> {
    pub(crate) fn new(
        bounds: [[f64; D]; 2],
        correlation: &SpatialCorrelation<D>,
        truncation: Truncation,
    ) -> Result<Self, Error> {
        let factors = exponential_factors(correlation)?;
        let axes = correlation.axes();
        let [low, high] = about(&axes, &bounds);
        let half: [f64; D] = std::array::from_fn(|k| 0.5 * (high[k] - low[k]));
        let mut modes = Self {
            axes,
            centre: std::array::from_fn(|k| 0.5 * (high[k] + low[k])),
            half,
            along: std::array::from_fn(|k| ExponentialModes::new(factors[k].length, half[k])),
            indices: vec![],
            shares: vec![],
        };
        modes.expand(truncation)?;
        Ok(modes)
    }

    /// Takes terms in the order of their eigenvalues. The terms that follow a term have one mode more along one axis, so none is
    /// larger, and each has one predecessor.
    fn expand(&mut self, truncation: Truncation) -> Result<(), Error> {
        let mut heap = BinaryHeap::new();
        heap.push(self.candidate([0; D], 0));
        let mut sum = 0.0;
        while !truncation.is_reached(self.shares.len(), sum) {
            let Some(next) = heap.pop() else { break };
            if self.shares.len() == MOST_TERMS {
                return Err(Error::TooManyTerms {
                    n_terms: MOST_TERMS,
                    reached: sum,
                    asked: truncation.share(),
                });
            }
            sum += next.share;
            self.shares.push(next.share);
            self.indices.push(next.index);
            for axis in next.last..D {
                let mut index = next.index;
                index[axis] += 1;
                heap.push(self.candidate(index, axis));
            }
        }
        for k in 0..D {
            let most = self.indices.iter().map(|index| index[k]).max();
            self.along[k].truncate(most.map_or(0, |most| most + 1));
        }
        Ok(())
    }

    fn candidate(&mut self, index: [usize; D], last: usize) -> Candidate<D> {
        let share = (0..D).map(|k| self.along[k].share(index[k])).product();
        Candidate { share, index, last }
    }

    pub(crate) fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Modes of the axes, side by side, that [`BoxModes::values`] needs.
    pub(crate) fn scratch(&self) -> Vec<f64> {
        vec![0.0; self.along.iter().map(ExponentialModes::n_modes).sum()]
    }

    /// All terms at a point, whose index is for errors.
    pub(crate) fn values(
        &self,
        point: usize,
        x: &[f64; D],
        scratch: &mut [f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        let mut starts = [0; D];
        let mut next = 0;
        for axis in 0..D {
            let value: f64 = (0..D).map(|k| self.axes[axis][k] * x[k]).sum();
            let (centre, half) = (self.centre[axis], self.half[axis]);
            let from_centre = value - centre;
            if from_centre.is_nan() || from_centre.abs() > half * (1.0 + ROUNDOFF) {
                let (from, to) = (centre - half, centre + half);
                return Err(Error::OutsideBox { point, axis, value, from, to });
            }
            starts[axis] = next;
            let end = next + self.along[axis].n_modes();
            self.along[axis].values(from_centre, &mut scratch[next..end]);
            next = end;
        }
        for (out, index) in out.iter_mut().zip(&self.indices) {
            *out = (0..D).map(|k| scratch[starts[k] + index[k]]).product();
        }
        Ok(())
    }
}

impl<const D: usize> Ord for Candidate<D> {
    fn cmp(&self, other: &Self) -> Ordering {
        // The largest share comes first; of equal ones the lowest index.
        self.share.total_cmp(&other.share).then_with(|| other.index.cmp(&self.index))
    }
}

impl<const D: usize> PartialOrd for Candidate<D> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const D: usize> PartialEq for Candidate<D> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<const D: usize> Eq for Candidate<D> {}

/// The factors along the axes, where all are exponential.
fn exponential_factors<const D: usize>(
    correlation: &SpatialCorrelation<D>,
) -> Result<[Correlation; D], Error> {
    let factors = match correlation {
        SpatialCorrelation::Isotropic(factor) if D == 1 => Some([*factor; D]),
        SpatialCorrelation::Elliptic { function, lengths, .. } if D == 1 => {
            Some(lengths.map(|length| Correlation { function: *function, length }))
        }
        SpatialCorrelation::Separable { factors, .. } => Some(*factors),
        _ => None,
    };
    factors
        .filter(|factors| {
            factors.iter().all(|factor| factor.function == CorrelationFunction::Exponential)
        })
        .ok_or_else(|| Error::NoEigenfunctions { correlation: format!("{correlation:?}") })
}

/// Bounds of a box along other axes: those of its corners.
fn about<const D: usize>(axes: &Axes<D>, [low, high]: &[[f64; D]; 2]) -> [[f64; D]; 2] {
    let end = |axis: usize, is_high: bool| {
        (0..D)
            .map(|k| {
                let e = axes[axis][k];
                e * if (e > 0.0) == is_high { high[k] } else { low[k] }
            })
            .sum()
    };
    [std::array::from_fn(|axis| end(axis, false)), std::array::from_fn(|axis| end(axis, true))]
}

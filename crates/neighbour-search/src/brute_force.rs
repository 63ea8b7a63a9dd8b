//! Brute-force search over all pairs.

use crate::domain::Domain;
use crate::error::Error;
use crate::index::stored;
use crate::list::NeighbourList;
use crate::radii::Radii;
use crate::search::{NeighbourSearch, check};

/// Tests every pair: defines the result, and is the oracle of the tests.
///
/// Time `O(n^2)`, no memory of its own. Below about a hundred points it is as fast as a grid. Rows ascend.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BruteForce<const D: usize> {
    domain: Domain<D>,
}

impl<const D: usize> BruteForce<D> {
    /// A search in an unbounded space.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A search in a space that may be periodic.
    #[must_use]
    pub fn in_domain(domain: Domain<D>) -> Self {
        Self { domain }
    }
}

impl<const D: usize> NeighbourSearch<D> for BruteForce<D> {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        check(points, radii, &self.domain)?;
        list.fill(points.len(), &self.domain, |i, found| {
            for (j, x_j) in points.iter().enumerate() {
                let limit = radii.limit(i, j);
                if i != j && self.domain.squared_distance(&points[i], x_j) <= limit * limit {
                    found.push(stored(j));
                }
            }
        })
    }
}

//! Every point against every other.

use crate::error::Error;
use crate::list::NeighbourList;
use crate::radii::Radii;
use crate::search::{NeighbourSearch, check, squared_distance};

/// Tests every pair: the definition of the answer, and the oracle of the tests.
///
/// Time `O(n^2)`, memory none of its own. Below some hundred points it is as quick as a grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BruteForce;

impl<const D: usize> NeighbourSearch<D> for BruteForce {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        check(points, radii)?;
        list.restart();
        for (i, x_i) in points.iter().enumerate() {
            for (j, x_j) in points.iter().enumerate() {
                let limit = radii.limit(i, j);
                if i != j && squared_distance(x_i, x_j) <= limit * limit {
                    list.push(j);
                }
            }
            list.end_row();
        }
        Ok(())
    }
}

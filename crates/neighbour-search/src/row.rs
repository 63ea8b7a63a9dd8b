//! A point with all of its neighbours, and the rows of a list.

use crate::domain::square;
use crate::error::Error;
use crate::list::NeighbourList;

/// A point and all of its `n` neighbours, for loops over whole rows; the search determines their order.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a, const D: usize> {
    /// The point.
    pub i: usize,
    /// Its neighbours, `n` indices.
    pub j: &'a [u32],
    /// `x_i - x_j` of the nearest images, axis by axis, `n` values each, unit of length of the points.
    pub x_ij: [&'a [f64]; D],
    /// `|x_ij|^2`, `n` values.
    pub squared_distances: &'a [f64],
}

/// Visits the rows of a list, one by one.
pub(crate) fn visit_list<const D: usize>(
    list: &NeighbourList,
    points: &[[f64; D]],
    visit: &mut dyn FnMut(Row<'_, D>),
) -> Result<(), Error> {
    let (mut x_ij, mut squared_distances) = ([const { Vec::new() }; D], Vec::new());
    for (i, j) in list.rows().enumerate() {
        x_ij.iter_mut().for_each(Vec::clear);
        squared_distances.clear();
        list.for_each_pair_of(i, points, |pair| {
            for (column, along) in x_ij.iter_mut().zip(pair.x_ij) {
                column.push(along);
            }
            squared_distances.push(square(&pair.x_ij));
        })?;
        let x_ij = core::array::from_fn(|axis| x_ij[axis].as_slice());
        visit(Row { i, j, x_ij, squared_distances: &squared_distances });
    }
    Ok(())
}

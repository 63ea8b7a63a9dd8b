//! Values at the rim of a lattice from those inside.

use std::ops::Range;

use neighbour_search::NeighbourList;

use crate::cloud::lattice::ParticleLattice;
use crate::error::Error;
use crate::score::{RIM, determinant, solve};

/// Linear extrapolation of values from the inside of a lattice to its rim, with constant weights.
///
/// A point at the rim takes the value there of the linear function that fits the inner points within the reach best, by
/// plain least squares; where these do not determine it, inner points of the reaches beyond count too.
#[derive(Debug, Clone, Default)]
pub(crate) struct RimExtrapolation {
    rim: Vec<(usize, Range<usize>)>,
    /// Inner points and their weights, which sum to 1.
    links: Vec<(u32, f64)>,
}

/// Inner points per unknown of the linear function, at the least.
const POINTS_PER_UNKNOWN: usize = 2;

/// The least determinant of the second moments of the inner points over that of as many points spread alike in all
/// directions. Points in a plane have zero, two layers of a cubic lattice within 2.8 spacings 0.4.
const FLATTEST: f64 = 0.1;

impl RimExtrapolation {
    /// For the lattice of an estimator that works on it.
    ///
    /// # Errors
    /// [`Error::NoLatticeCell`] for a point from which not enough inner points can be reached.
    pub(crate) fn new<const D: usize>(lattice: &ParticleLattice<D>) -> Result<Self, Error> {
        let (places, neighbours) = (&lattice.places, &lattice.neighbours);
        let counts: Vec<usize> = neighbours.rows().map(|row| row.len() + 1).collect();
        let full = counts.iter().copied().max().unwrap_or(0) as f64;
        let is_inside = |i: usize| counts[i] as f64 >= RIM * full;
        let mut extrapolation = Self::default();
        for i in (0..places.len()).filter(|&i| !is_inside(i)) {
            let start = extrapolation.links.len();
            extrapolation.links.extend(links(i, places, neighbours, &is_inside)?);
            extrapolation.rim.push((i, start..extrapolation.links.len()));
        }
        Ok(extrapolation)
    }

    /// Replaces the values at the rim, `n` numbers of each particle.
    pub(crate) fn apply(&self, values: &mut [f64], n: usize) {
        for (i, links) in &self.rim {
            for k in 0..n {
                let linked = self.links[links.clone()].iter();
                values[i * n + k] =
                    linked.map(|&(j, weight)| weight * values[j as usize * n + k]).sum();
            }
        }
    }
}

/// The inner points from which point `i` takes its value, in ascending order, with their weights.
fn links<const D: usize>(
    i: usize,
    places: &[[f64; D]],
    neighbours: &NeighbourList,
    is_inside: &impl Fn(usize) -> bool,
) -> Result<Vec<(u32, f64)>, Error> {
    let mut reached = vec![u32::try_from(i).unwrap_or(u32::MAX)];
    loop {
        let before = reached.len();
        let further = reached.iter().flat_map(|&j| neighbours.of(j as usize)).copied();
        reached = further.chain(reached.iter().copied()).collect();
        reached.sort_unstable();
        reached.dedup();
        let inner: Vec<u32> = reached.iter().copied().filter(|&j| is_inside(j as usize)).collect();
        if let Some(links) =
            weights::<D>(&inner, |j| std::array::from_fn(|k| places[j as usize][k] - places[i][k]))
        {
            return Ok(links);
        }
        if reached.len() == before {
            return Err(Error::NoLatticeCell { particle: i });
        }
    }
}

/// The weights that make of values at some points the value at the origin of the linear function that fits them best; none
/// where they do not determine it.
fn weights<const D: usize>(
    points: &[u32],
    offset: impl Fn(u32) -> [f64; D],
) -> Option<Vec<(u32, f64)>> {
    if points.len() < POINTS_PER_UNKNOWN * (D + 1) {
        return None;
    }
    let share = 1.0 / points.len() as f64;
    let mut mean = [0.0; D];
    for &j in points {
        for (mean, offset) in mean.iter_mut().zip(offset(j)) {
            *mean += share * offset;
        }
    }
    let centred = |j: u32| -> [f64; D] {
        let offset = offset(j);
        std::array::from_fn(|k| offset[k] - mean[k])
    };
    let mut moments = [[0.0; D]; D];
    for &j in points {
        let offset = centred(j);
        for k in 0..D {
            for l in 0..D {
                moments[k][l] += offset[k] * offset[l];
            }
        }
    }
    let alike = (0..D).map(|k| moments[k][k]).sum::<f64>() / D as f64;
    if determinant(&moments) <= FLATTEST * (0..D).map(|_| alike).product::<f64>() {
        return None;
    }
    let slope = solve(&moments, &mean);
    let weight = |j: u32| share - centred(j).iter().zip(&slope).map(|(o, s)| o * s).sum::<f64>();
    Some(points.iter().map(|&j| (j, weight(j))).collect())
}

#[cfg(test)]
mod tests {
    use particle_store::Lattice;

    use super::*;

    #[test]
    fn linear_values_reach_every_point_of_the_rim_of_a_ball_and_of_a_box() {
        let ball = Lattice::<3>::ball_lattice(4.0, 1.0).unwrap();
        let cube = Lattice::<3>::box_lattice([3.0; 3], [7; 3]).unwrap();
        for lattice in [ball, cube] {
            let mut lattice = ParticleLattice::<3>::new(lattice.indices, 1.0);
            lattice.find_neighbours(2.8).unwrap();
            let extrapolation = RimExtrapolation::new(&lattice).unwrap();
            assert!(extrapolation.rim.len() > 50 && extrapolation.rim.len() < lattice.places.len());
            let linear = |[x, y, z]: [f64; 3]| [1.0 + x - 2.0 * y, 0.5 * z - x];
            let exact: Vec<f64> = lattice.places.iter().flat_map(|&p| linear(p)).collect();
            let mut found = exact.clone();
            for (i, _) in &extrapolation.rim {
                found[2 * i..2 * i + 2].fill(f64::NAN);
            }
            extrapolation.apply(&mut found, 2);
            for (found, exact) in found.iter().zip(&exact) {
                // Roundoff of sums of up to a hundred values of size 10.
                assert!((found - exact).abs() < 1e-12, "{found} {exact}");
            }
        }
    }

    #[test]
    fn a_line_of_points_in_a_plane_is_refused_by_name() {
        let indices = (0..9).map(|k| [k, 0]).collect();
        let mut lattice = ParticleLattice::<2>::new(indices, 1.0);
        lattice.find_neighbours(2.8).unwrap();
        let refused = RimExtrapolation::new(&lattice);
        assert!(matches!(refused, Err(Error::NoLatticeCell { particle: 0 })), "{refused:?}");
    }
}

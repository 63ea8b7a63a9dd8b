//! Positions of a new lattice that hold a particle.

use std::collections::{BTreeMap, BTreeSet};

use neighbour_search::NeighbourList;

use super::interpolation::{Departure, Found};
use crate::cloud::lattice::neighbours_on_lattice;
use crate::error::Error;
use crate::method::remapping::Remapping;
use crate::parallel::fill;
use crate::score::RIM;

/// A lattice in whitened coordinates with the mass of each of its cells.
#[derive(Debug)]
pub(super) struct FreshLattice<const D: usize> {
    pub(super) indices: Vec<[i32; D]>,
    pub(super) masses: Vec<f64>,
    /// What the cells of the outermost layer carry.
    pub(super) outermost_mass: f64,
    /// Particles beyond the cloud as it was.
    pub(super) n_beyond: usize,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    mass: f64,
    beyond: bool,
}

/// Passes in which the least mass of a cell is lowered until the outermost layer is light enough. Each halves the layer's
/// mass at least, so this number reaches any mass that differs from 0 in double precision.
const MOST_PASSES: usize = 1100;
/// Least share of an interior point's neighbours that a position needs for a polynomial.
const FEWEST_NEIGHBOURS: f64 = 0.3;

impl<const D: usize> FreshLattice<D> {
    /// The cells from the cloud outward, layer by layer, until the outermost layer carries less than asked or the cloud
    /// ends.
    pub(super) fn grow(
        departure: &Departure<'_, D>,
        time: f64,
        reach: f64,
        remapping: &Remapping,
    ) -> Result<Self, Error> {
        let mut cells = BTreeMap::new();
        let mut least = remapping.outermost_mass;
        let mut fresh = Self::of_cells(&cells);
        for _ in 0..MOST_PASSES {
            let before = fresh.indices.len();
            extend(&mut cells, least, departure, remapping.most_particles);
            let kept = cells.iter().filter(|(_, cell)| cell.mass >= least);
            let kept: BTreeMap<[i32; D], Cell> = kept.map(|(&k, &cell)| (k, cell)).collect();
            let (count, limit) = (kept.len(), remapping.most_particles);
            if count > limit {
                return Err(Error::RemappingTooLarge { time, count, limit });
            }
            fresh = Self::of_cells(&without_tips(kept, reach)?);
            if fresh.outermost_mass <= remapping.outermost_mass
                || (before > 0 && fresh.indices.len() == before)
            {
                break;
            }
            least *= 0.5 * remapping.outermost_mass / fresh.outermost_mass;
        }
        let (count, limit) = (fresh.indices.len(), 3_usize.pow(u32::try_from(D).unwrap_or(0)));
        if count < limit {
            return Err(Error::TooFewParticles { count, limit, dimension: D });
        }
        Ok(fresh)
    }

    fn of_cells(cells: &BTreeMap<[i32; D], Cell>) -> Self {
        let outermost = |index: &&[i32; D]| beside(index).any(|other| !cells.contains_key(&other));
        Self {
            outermost_mass: cells.keys().filter(outermost).map(|k| cells[k].mass).sum(),
            n_beyond: cells.values().filter(|cell| cell.beyond).count(),
            masses: cells.values().map(|cell| cell.mass).collect(),
            indices: cells.keys().copied().collect(),
        }
    }
}

/// The places one step away along each axis.
fn beside<const D: usize>(index: &[i32; D]) -> impl Iterator<Item = [i32; D]> {
    let index = *index;
    (0..D).flat_map(move |axis| {
        [-1, 1].map(|step| {
            let mut beside = index;
            beside[axis] += step;
            beside
        })
    })
}

/// Evaluates the cells that contain a particle, and those adjacent to every cell that carries `least`, until more than `most` carry
/// it: a density that is extrapolated without falling off has no end.
fn extend<const D: usize>(
    cells: &mut BTreeMap<[i32; D], Cell>,
    least: f64,
    departure: &Departure<'_, D>,
    most: usize,
) {
    let spacing = departure.spacing();
    let cell_volume = (0..D).fold(1.0, |volume, _| volume * spacing);
    loop {
        let heavy = cells.iter().filter(|(_, cell)| cell.mass >= least);
        let mut fresh: BTreeSet<[i32; D]> = heavy.flat_map(|(index, _)| beside(index)).collect();
        if cells.is_empty() {
            fresh.extend(departure.indices());
        }
        let fresh: Vec<[i32; D]> =
            fresh.into_iter().filter(|index| !cells.contains_key(index)).collect();
        if fresh.is_empty() || cells.values().filter(|cell| cell.mass >= least).count() > most {
            return;
        }
        let mut found = vec![Cell { mass: 0.0, beyond: true }; fresh.len()];
        fill(&mut found, |i| {
            let place = fresh[i].map(|k| f64::from(k) * spacing);
            let (value, beyond) = match departure.at(&place) {
                Found::Within(value) => (value, false),
                Found::Beyond(value) => (value, true),
                Found::Nothing => return Cell { mass: 0.0, beyond: true },
            };
            let log_density = value - 0.5 * place.iter().map(|c| c * c).sum::<f64>();
            let mass = log_density.exp() * cell_volume;
            // A place where nothing finite is known is not in the cloud.
            Cell { mass: if mass.is_finite() { mass } else { 0.0 }, beyond }
        });
        cells.extend(fresh.into_iter().zip(found));
    }
}

/// Takes away places with too few neighbours for a polynomial, and islands.
fn without_tips<const D: usize>(
    mut cells: BTreeMap<[i32; D], Cell>,
    reach: f64,
) -> Result<BTreeMap<[i32; D], Cell>, Error> {
    loop {
        let places: Vec<[f64; D]> = cells.keys().map(|index| index.map(f64::from)).collect();
        let list: NeighbourList = neighbours_on_lattice(&places, reach)?;
        let fewest = FEWEST_NEIGHBOURS * (1 + list.max_count()) as f64;
        let before = cells.len();
        let mut rows = list.rows();
        cells.retain(|_, _| rows.next().is_some_and(|row| (1 + row.len()) as f64 >= fewest));
        if cells.len() == before {
            let is_joined = joined_to_the_inside(&list);
            let mut all = is_joined.into_iter();
            cells.retain(|_, _| all.next().unwrap_or(false));
            return Ok(cells);
        }
    }
}

/// Whether each place is connected to one inside the lattice by neighbours: an island of the rim has no polynomial.
fn joined_to_the_inside(list: &NeighbourList) -> Vec<bool> {
    let fewest = RIM * (1 + list.max_count()) as f64;
    let mut is_joined: Vec<bool> =
        list.rows().map(|row| (1 + row.len()) as f64 >= fewest).collect();
    let mut next: Vec<usize> = (0..is_joined.len()).filter(|&i| is_joined[i]).collect();
    while let Some(i) = next.pop() {
        for &j in list.of(i) {
            if !std::mem::replace(&mut is_joined[j as usize], true) {
                next.push(j as usize);
            }
        }
    }
    is_joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_island_is_taken_away() {
        let cells = (-9..=9).chain(20..=23).map(|k| ([k], Cell { mass: 0.1, beyond: false }));
        assert_eq!(without_tips(cells.collect(), 6.0).unwrap().len(), 19);
    }
}

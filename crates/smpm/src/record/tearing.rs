//! Bodies that come apart because their particles no longer share nodes, not because their material has failed.

use std::collections::{HashMap, HashSet};

use perturbation_moments::Scalar;

use crate::grid::lattice::Lattice;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::simulation::Simulation;
use crate::transfer::shape::lowest_node;

/// The pairs of particles of each body that are adjacent on the lattice from which it starts.
#[derive(Debug, Clone)]
pub struct Neighbours(Vec<Vec<[u32; 2]>>);

impl<S: CarriedNumber, const D: usize> Simulation<S, D> {
    /// Pairs of adjacent particles; to be asked for at the start.
    #[must_use]
    pub fn neighbours(&self) -> Neighbours {
        Neighbours(self.bodies().iter().map(adjacent).collect())
    }

    /// How many of these pairs have been torn by the grid, by body: the material of neither particle has failed (damage below one),
    /// they share no node any more, and no particle of the body is in the cell midway between them.
    ///
    /// Such a gap is numerical fracture: the particles were stretched beyond the reach of the shape function, and from then on
    /// pull no longer on each other whatever their material bears. For bodies with strength; a gas may expand into such gaps.
    #[must_use]
    pub fn torn(&self, neighbours: &Neighbours) -> Vec<usize> {
        let config = self.config();
        let lattice = Lattice::of(config);
        let (reach, n_nodes) = (config.shape.reach(), config.shape.n_nodes());
        let bodies = self.bodies().iter().zip(&neighbours.0);
        bodies
            .map(|(body, pairs)| {
                let places: Vec<[f64; D]> =
                    body.positions().iter().map(|x| x.map(Scalar::value)).collect();
                let in_cells = |x: f64, k: usize| (x - lattice.origin[k]) * lattice.per_cell;
                let cell = |x: [f64; D]| -> [i32; D] {
                    std::array::from_fn(|k| lowest_node(in_cells(x[k], k), (0.0, 0)))
                };
                let base = |x: [f64; D], k: usize| lowest_node(in_cells(x[k], k), reach);
                let occupied: HashSet<[i32; D]> = places.iter().map(|&x| cell(x)).collect();
                let has_failed = |p: u32| body.observe(p as usize).damage.value() >= 1.0;
                let is_torn = |pair: &&[u32; 2]| {
                    let [a, b] = pair.map(|p| places[p as usize]);
                    let share_no_node =
                        (0..D).any(|k| base(a, k).abs_diff(base(b, k)) as usize >= n_nodes);
                    let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
                    share_no_node
                        && !occupied.contains(&cell(middle))
                        && !pair.iter().any(|&p| has_failed(p))
                };
                pairs.iter().filter(is_torn).count()
            })
            .collect()
    }
}

/// Pairs of particles that are one spacing apart along an axis.
fn adjacent<S: CarriedNumber, const D: usize>(body: &Body<S, D>) -> Vec<[u32; 2]> {
    let (places, spacing) = (body.positions(), body.spacing());
    let Some(first) = places.first() else { return vec![] };
    let site = |x: &[S; D]| -> [i64; D] {
        #[allow(clippy::cast_possible_truncation, reason = "a particle has a number of 32 bits")]
        std::array::from_fn(|k| ((x[k].value() - first[k].value()) / spacing[k]).round() as i64)
    };
    let sites: HashMap<[i64; D], u32> = places.iter().map(site).zip(0..).collect();
    let mut pairs = vec![];
    for (place, number) in places.iter().zip(0..) {
        for k in 0..D {
            let mut next = site(place);
            next[k] += 1;
            if let Some(&other) = sites.get(&next) {
                pairs.push([number, other]);
            }
        }
    }
    pairs
}

//! Which nodes touch, lane by lane, and what they push each other with.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use sde_integrators::SimdLevel;

use crate::error::Error;
use crate::nodes::Nodes;
use crate::real::Real;
use crate::repulsion::Repulsion;

/// In spacings: pairs are listed that would touch if they were nearer by so much. Less than what lies between the neighbours of a
/// lattice at rest and where they touch, so that none of them is listed.
const SKIN: f64 = 0.09;

/// What roundoff takes from the skin, of all that is computed here with single precision.
const ROUNDOFF: f64 = 1e-6;

/// The pairs that may touch of `L` realisations, and those that do.
///
/// Pairs come by the lower node, then by the higher one, whenever they were searched for; those that do not touch leave no trace
/// in a sum. So forces do not depend on when lists were made, nor on the lanes beside.
#[derive(Debug)]
pub(crate) struct Contact<T, const D: usize, const L: usize> {
    law: Repulsion,
    search: Search<D>,
    near: [Vec<Near>; L],
    /// Displacements at which each lane was last searched, not a number before that.
    searched_at: Vec<T>,
    touching: Vec<Touch<D>>,
}

/// What a search works with.
#[derive(Debug, Default)]
struct Search<const D: usize> {
    grid: CellGrid<D>,
    list: NeighbourList,
    places: Vec<[f64; D]>,
}

/// Two nodes that may touch.
#[derive(Debug, Clone, Copy)]
struct Near {
    i: u32,
    j: u32,
    /// `d_ij` (length).
    distance: f64,
}

/// Two nodes that do.
#[derive(Debug, Clone, Copy)]
struct Touch<const D: usize> {
    i: usize,
    j: usize,
    lane: usize,
    /// On `i`; on `j` its opposite (force).
    force: [f64; D],
}

/// In which step, with which realisations and over which registers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Now<const L: usize> {
    pub(crate) step: u64,
    pub(crate) time: f64,
    pub(crate) realisations: [u64; L],
    pub(crate) level: SimdLevel,
}

impl<T: Real, const D: usize, const L: usize> Contact<T, D, L> {
    pub(crate) fn new(law: Repulsion, n_nodes: usize) -> Self {
        Self {
            law,
            search: Search::default(),
            near: std::array::from_fn(|_| Vec::new()),
            searched_at: vec![T::of(f64::NAN); n_nodes * D * L],
            touching: Vec::new(),
        }
    }

    /// Finds who touches under displacements `u`.
    ///
    /// # Errors
    /// [`Error::Lost`], [`Error::Coincident`] for two nodes at one place, [`Error::OutOfRange`].
    pub(crate) fn find(&mut self, nodes: &Nodes<D>, u: &[T], now: &Now<L>) -> Result<(), Error> {
        let moved = self.moved(u, SKIN * nodes.spacing(), now.level);
        self.touching.clear();
        for lane in 0..L {
            if moved[lane] {
                self.search.run::<T, L>(&self.law, nodes, u, lane, &mut self.near[lane], now)?;
                let lanes = self.searched_at.as_chunks_mut::<L>().0;
                for (then, u) in lanes.iter_mut().zip(u.as_chunks::<L>().0) {
                    then[lane] = u[lane];
                }
            }
            let touching = &mut self.touching;
            touches::<T, D, L>(&self.law, nodes, u, lane, &self.near[lane], |touch, _| {
                touching.push(touch);
            })?;
        }
        Ok(())
    }

    /// Adds what those who touch push each other with.
    pub(crate) fn add(&self, forces: &mut [T]) {
        for &Touch { i, j, lane, force } in &self.touching {
            for k in 0..D {
                let push = T::of(force[k]);
                forces[(i * D + k) * L + lane] += push;
                forces[(j * D + k) * L + lane] -= push;
            }
        }
    }

    /// Energy and forces of a lane, by a search of their own.
    pub(crate) fn of_lane(
        &self,
        nodes: &Nodes<D>,
        u: &[T],
        lane: usize,
        now: &Now<L>,
    ) -> Result<(f64, Vec<[f64; D]>), Error> {
        let mut near = Vec::new();
        Search::default().run::<T, L>(&self.law, nodes, u, lane, &mut near, now)?;
        let (mut sum, mut forces) = (0.0, vec![[0.0; D]; nodes.positions().len()]);
        touches::<T, D, L>(
            &self.law,
            nodes,
            u,
            lane,
            &near,
            |Touch { i, j, force, .. }, energy| {
                sum += energy;
                for k in 0..D {
                    forces[i][k] += force[k];
                    forces[j][k] -= force[k];
                }
            },
        )?;
        Ok((sum, forces))
    }

    /// In which lanes a node has moved by half the skin or more since they were searched, or is nowhere.
    fn moved(&self, u: &[T], skin: f64, level: SimdLevel) -> [bool; L] {
        let half = 0.5 * skin * (1.0 - ROUNDOFF);
        let (limit, one) = (T::of(half * half), T::of(1.0));
        let mut far = [T::ZERO; L];
        let nodes = u.as_chunks::<L>().0.as_chunks::<D>().0;
        let then = self.searched_at.as_chunks::<L>().0.as_chunks::<D>().0;
        level.call(
            #[inline(always)]
            || {
                for (u, then) in nodes.iter().zip(then) {
                    let mut square = [T::ZERO; L];
                    for k in 0..D {
                        for lane in 0..L {
                            let moved = u[k][lane] - then[k][lane];
                            square[lane] += moved * moved;
                        }
                    }
                    for lane in 0..L {
                        far[lane] += if square[lane] < limit { T::ZERO } else { one };
                    }
                }
            },
        );
        far.map(|far| far > T::ZERO)
    }
}

impl<const D: usize> Search<D> {
    /// Fills `near` with the pairs of a lane that touch, or would if they were nearer by the skin.
    fn run<T: Real, const L: usize>(
        &mut self,
        law: &Repulsion,
        nodes: &Nodes<D>,
        u: &[T],
        lane: usize,
        near: &mut Vec<Near>,
        now: &Now<L>,
    ) -> Result<(), Error> {
        let lanes = u.as_chunks::<L>().0.as_chunks::<D>().0;
        let place =
            |(x, u): (&[f64; D], &[[T; L]; D])| std::array::from_fn(|k| x[k] + u[k][lane].to_f64());
        self.places.clear();
        self.places.extend(nodes.positions().iter().zip(lanes).map(place));
        let reach = law.spacing_factor * nodes.spacing() + SKIN * nodes.spacing();
        self.pairs(law, nodes, reach, near).map_err(|error| refused(error, reach, lane, now))
    }

    /// Pairs of the nodes at their present places.
    fn pairs(
        &mut self,
        law: &Repulsion,
        nodes: &Nodes<D>,
        reach: f64,
        near: &mut Vec<Near>,
    ) -> Result<(), neighbour_search::Error> {
        let (x, spacing) = (nodes.positions(), nodes.spacing());
        let skin = SKIN * spacing;
        let Self { grid, list, places } = self;
        grid.full_list(places, Radii::Uniform(reach), list)?;
        list.sort_rows();
        near.clear();
        for (i, row) in list.rows().enumerate() {
            for &partner in &row[row.partition_point(|&partner| (partner as usize) < i)..] {
                let j = partner as usize;
                let distance = law.distance(square(&between(&x[i], &x[j])).sqrt(), spacing);
                if square(&between(&places[i], &places[j])) < (distance + skin).powi(2) {
                    #[allow(clippy::cast_possible_truncation, reason = "an index has 32 bits")]
                    near.push(Near { i: i as u32, j: partner, distance });
                }
            }
        }
        Ok(())
    }
}

/// Nodes are fewer than an index holds, which leaves what is not finite, and a radius that has no square.
fn refused<const L: usize>(
    error: neighbour_search::Error,
    reach: f64,
    lane: usize,
    now: &Now<L>,
) -> Error {
    match error {
        neighbour_search::Error::CoordinateNotFinite { particle, value, .. } => Error::Lost {
            step: now.step,
            time: now.time,
            node: particle,
            realisation: now.realisations[lane],
            value,
        },
        _ => Error::OutOfRange {
            name: "reach of the repulsion",
            value: reach,
            from: neighbour_search::MIN_RADIUS,
            to: neighbour_search::MAX_RADIUS,
        },
    }
}

/// Hands out those of the near that touch, each with its energy.
fn touches<T: Real, const D: usize, const L: usize>(
    law: &Repulsion,
    nodes: &Nodes<D>,
    u: &[T],
    lane: usize,
    near: &[Near],
    mut visit: impl FnMut(Touch<D>, f64),
) -> Result<(), Error> {
    let (x, volumes, slope) = (nodes.positions(), nodes.volumes(), law.slope());
    let lanes = u.as_chunks::<L>().0.as_chunks::<D>().0;
    for &Near { i, j, distance } in near {
        let (i, j) = (i as usize, j as usize);
        let apart: [f64; D] = std::array::from_fn(|k| {
            (x[j][k] - x[i][k]) + (lanes[j][k][lane].to_f64() - lanes[i][k][lane].to_f64())
        });
        let square = square(&apart);
        if square >= distance * distance {
            continue;
        }
        let r = square.sqrt();
        if r <= 0.0 {
            return Err(Error::Coincident { first: i, second: j });
        }
        let (overlap, stiffness) = (distance - r, slope * volumes[i] * volumes[j]);
        let force = apart.map(|apart| -(stiffness * overlap / r) * apart);
        visit(Touch { i, j, lane, force }, 0.5 * stiffness * overlap * overlap);
    }
    Ok(())
}

fn between<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| b[k] - a[k])
}

fn square<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

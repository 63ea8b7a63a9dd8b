//! Nodes of cracks, and the ways along them.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};

use super::fractured::Fractured;
use crate::error::Error;

/// Nodes of cracks nearer than this are linked (spacings): on a lattice, those across the diagonal of a square or a cube.
const LINK: f64 = 1.75;

/// The nodes of all cracks, numbered anew, and their links.
pub(super) struct Cluster<const D: usize> {
    /// The number of each member among the nodes.
    pub(super) nodes: Vec<usize>,
    pub(super) positions: Vec<[f64; D]>,
    links: NeighbourList,
    /// The longest bond.
    pub(super) horizon: f64,
}

impl<const D: usize> Cluster<D> {
    /// The nodes that have lost `threshold` of their bonds, half of that not to the notch.
    pub(super) fn new(body: &Fractured<'_, D>, threshold: f64) -> Result<Self, Error> {
        let mut by_notch = vec![false; body.bonds.len()];
        for &bond in body.cut {
            by_notch[bond] = true;
        }
        let notch = damage(body, |bond| by_notch[bond]);
        let all = damage(body, |bond| by_notch[bond] || body.broken[bond]);
        let of_crack =
            |&node: &usize| all[node] >= threshold && all[node] - notch[node] >= 0.5 * threshold;
        let nodes: Vec<usize> = (0..all.len()).filter(of_crack).collect();
        let positions: Vec<_> = nodes.iter().map(|&node| body.nodes.positions()[node]).collect();
        let mut links = NeighbourList::new();
        let radius = LINK * body.nodes.spacing();
        // Nodes are finite and fewer than an index holds; what is left is a spacing beyond all measure.
        CellGrid::new()
            .full_list(&positions, Radii::Uniform(radius), &mut links)
            .map_err(|_| Error::NotPositive { name: "spacing of the nodes", value: radius })?;
        let horizon = body.bonds.all().iter().fold(0.0, |most, bond| f64::max(most, bond.length));
        Ok(Self { nodes, positions, links, horizon })
    }
}

/// The damage of each node, as of [`Network::damage`](crate::Network::damage).
fn damage<const D: usize>(body: &Fractured<'_, D>, lost: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; body.bonds.n_nodes()];
    for ((bond, of), (i, j)) in body.bonds.all().iter().enumerate().zip(body.bonds.pairs()) {
        for node in [i, j] {
            sums[node][0] += if lost(bond) { of.stiffness } else { 0.0 };
            sums[node][1] += of.stiffness;
        }
    }
    sums.iter().map(|[lost, all]| lost / all).collect()
}

/// The shortest ways to members, from the tip of a notch or from what is planted.
pub(super) struct Tree<'a, const D: usize> {
    cluster: &'a Cluster<D>,
    /// Infinite where no way leads.
    distances: Vec<f64>,
    previous: Vec<Option<usize>>,
}

/// The nearest member not yet settled; of two as near, the one of the lower number.
#[derive(PartialEq)]
struct Next {
    distance: f64,
    member: usize,
}

impl Eq for Next {}

impl Ord for Next {
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.member.cmp(&self.member))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a, const D: usize> Tree<'a, D> {
    /// Ways from members within a horizon of places that start as far off as `start` says.
    pub(super) fn new(cluster: &'a Cluster<D>, start: impl Fn(&[f64; D]) -> f64) -> Self {
        let n = cluster.positions.len();
        let mut tree = Self { cluster, distances: vec![f64::INFINITY; n], previous: vec![None; n] };
        for (distance, position) in tree.distances.iter_mut().zip(&cluster.positions) {
            let from = start(position);
            if from <= cluster.horizon {
                *distance = from;
            }
        }
        tree.settle();
        tree
    }

    pub(super) fn from_tip(cluster: &'a Cluster<D>, tip: &[f64; D]) -> Self {
        Self::new(cluster, |x| distance(x, tip))
    }

    /// Dijkstra's algorithm.
    fn settle(&mut self) {
        let mut queue: BinaryHeap<Next> = (0..)
            .zip(&self.distances)
            .filter(|(_, distance)| distance.is_finite())
            .map(|(member, &distance)| Next { distance, member })
            .collect();
        while let Some(Next { distance: way, member }) = queue.pop() {
            if way > self.distances[member] {
                continue;
            }
            for &other in self.cluster.links.of(member) {
                let other = other as usize;
                let (from, to) = (&self.cluster.positions[member], &self.cluster.positions[other]);
                let longer = way + distance(from, to);
                if longer < self.distances[other] {
                    self.distances[other] = longer;
                    self.previous[other] = Some(member);
                    queue.push(Next { distance: longer, member: other });
                }
            }
        }
    }

    pub(super) fn reaches(&self, member: usize) -> bool {
        self.distances[member].is_finite()
    }

    /// The members on the way to the farthest one, if that is at least so far; of two as far, to that of the lower number.
    pub(super) fn longest(&self, least: f64) -> Option<Vec<usize>> {
        let mut farthest: Option<usize> = None;
        for (member, &distance) in self.distances.iter().enumerate() {
            let most = farthest.map_or(f64::NEG_INFINITY, |farthest| self.distances[farthest]);
            if distance.is_finite() && distance > most {
                farthest = Some(member);
            }
        }
        let end = farthest.filter(|&member| self.distances[member] >= least)?;
        let mut way: Vec<usize> =
            std::iter::successors(Some(end), |&member| self.previous[member]).collect();
        way.reverse();
        Some(way)
    }

    /// From now on distances are from this way alone.
    pub(super) fn restart(&mut self, way: &[usize]) {
        self.distances.fill(f64::INFINITY);
        self.plant(way);
    }

    /// From now on distances are from this way too.
    pub(super) fn plant(&mut self, way: &[usize]) {
        for &member in way {
            self.distances[member] = 0.0;
            self.previous[member] = None;
        }
        self.settle();
    }
}

pub(super) fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

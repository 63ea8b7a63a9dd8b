//! Nodes of cracks, and the ways along them.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};

use super::fractured::Fractured;
use crate::error::Error;

/// Nodes of cracks nearer than this are linked (spacings): on a lattice, those across the diagonal of a square or a cube.
const LINK: f64 = 1.75;

/// The nodes of all cracks, numbered anew, and their links.
pub(super) struct Cluster {
    /// The number of each member among the nodes.
    pub(super) nodes: Vec<usize>,
    pub(super) positions: Vec<[f64; 2]>,
    links: NeighbourList,
    /// The longest bond.
    pub(super) horizon: f64,
}

impl Cluster {
    /// The nodes that have lost `threshold` of their bonds, half of that not to the notch.
    pub(super) fn new(body: &Fractured<'_>, threshold: f64) -> Result<Self, Error> {
        let mut by_notch = vec![false; body.bonds.len()];
        for &bond in body.cut {
            by_notch[bond] = true;
        }
        let damage = |lost: &dyn Fn(usize) -> bool| {
            body.bonds.damage_of_nodes(|bond| f64::from(u8::from(lost(bond))))
        };
        let notch = damage(&|bond| by_notch[bond]);
        let all = damage(&|bond| by_notch[bond] || body.broken[bond]);
        let of_crack =
            |&node: &usize| all[node] >= threshold && all[node] - notch[node] >= 0.5 * threshold;
        let nodes: Vec<usize> = (0..all.len()).filter(of_crack).collect();
        let positions: Vec<_> = nodes.iter().map(|&node| body.nodes.positions()[node]).collect();
        let mut links = NeighbourList::new();
        let radius = LINK * body.nodes.spacing();
        CellGrid::new().full_list(&positions, Radii::Uniform(radius), &mut links)?;
        let horizon = body.bonds.all().iter().fold(0.0, |most, bond| f64::max(most, bond.length));
        Ok(Self { nodes, positions, links, horizon })
    }
}

/// The shortest ways to members, from the tip of a notch or from ways that are planted.
pub(super) struct Tree<'a> {
    cluster: &'a Cluster,
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

impl<'a> Tree<'a> {
    /// Ways from the members within a horizon of the tip.
    pub(super) fn from_tip(cluster: &'a Cluster, tip: &[f64; 2]) -> Self {
        let n = cluster.positions.len();
        let mut tree = Self { cluster, distances: vec![f64::INFINITY; n], previous: vec![None; n] };
        for (from_tip, position) in tree.distances.iter_mut().zip(&cluster.positions) {
            let straight = distance(position, tip);
            if straight <= cluster.horizon {
                *from_tip = straight;
            }
        }
        tree.settle();
        tree
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

/// As `sqrt` of the squares: `hypot` has other bits.
fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt()
}

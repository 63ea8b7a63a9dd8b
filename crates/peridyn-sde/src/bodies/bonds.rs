//! Which nodes are bonded, and how stiffly.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};

use crate::bodies::nodes::Nodes;
use crate::error::{Error, exists};

/// What does not change of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// Its length at rest (length).
    pub length: f64,
    /// Its tension over its stretch, `c omega beta V_i V_j` with the share `beta` of the volumes, times the
    /// factor of the surface correction (force).
    pub stiffness: f64,
}

/// The bonds of a body, each once: the rows of node `i` hold those to nodes `j > i`, by ascending `j`.
#[derive(Debug, Clone, PartialEq)]
pub struct Bonds {
    /// Where the bonds of each node begin; one more at the end.
    starts: Vec<usize>,
    partners: Vec<u32>,
    all: Vec<Bond>,
}

impl Bonds {
    /// Bonds those nodes within `reach` of each other that `of` makes a bond for, given their numbers, the lower first, and their
    /// distance.
    pub(crate) fn within<const D: usize>(
        nodes: &Nodes<D>,
        reach: f64,
        horizon: f64,
        of: impl Fn((usize, usize), f64) -> Option<Bond>,
    ) -> Result<Self, Error> {
        let positions = nodes.positions();
        let mut list = NeighbourList::new();
        CellGrid::new().full_list(positions, Radii::Uniform(reach), &mut list)?;
        list.sort_rows();
        let n = positions.len();
        let (mut starts, mut partners, mut all) = (Vec::with_capacity(n + 1), vec![], vec![]);
        let mut counts = vec![0_u32; n];
        starts.push(0);
        for (i, row) in list.rows().enumerate() {
            // A half list of the search has a pair under either of its ends; here it belongs to the lower one.
            for &partner in &row[row.partition_point(|&partner| (partner as usize) < i)..] {
                let j = partner as usize;
                let length = distance(&positions[i], &positions[j]);
                if length <= 0.0 {
                    return Err(Error::Coincident { first: i, second: j });
                }
                if let Some(bond) = of((i, j), length) {
                    partners.push(partner);
                    all.push(bond);
                    counts[i] += 1;
                    counts[j] += 1;
                }
            }
            starts.push(partners.len());
        }
        match counts.iter().position(|&count| count == 0) {
            Some(node) => Err(Error::LooseNode { node, horizon }),
            None => Ok(Self { starts, partners, all }),
        }
    }

    /// Multiplies the stiffness of each bond by a factor.
    pub(crate) fn stiffen(&mut self, factors: Vec<f64>) {
        for (bond, factor) in self.all.iter_mut().zip(factors) {
            bond.stiffness *= factor;
        }
    }

    /// Replaces the stiffness of each bond.
    pub(crate) fn set_stiffness(&mut self, stiffness: Vec<f64>) {
        for (bond, stiffness) in self.all.iter_mut().zip(stiffness) {
            bond.stiffness = stiffness;
        }
    }

    /// How many bonds there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// How many nodes they bond.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// What does not change of each bond.
    #[must_use]
    pub fn all(&self) -> &[Bond] {
        &self.all
    }

    /// Both nodes of every bond, in the order of [`Bonds::all`].
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.n_nodes()).flat_map(move |i| self.row(i).map(move |bond| (i, self.partner(bond))))
    }

    /// The damage of each node: the part of the stiffness of its bonds that is lost, given the damage of each bond.
    pub(crate) fn damage_of_nodes(&self, of_bond: impl Fn(usize) -> f64) -> Vec<f64> {
        let (mut lost, mut all) = (vec![0.0; self.n_nodes()], vec![0.0; self.n_nodes()]);
        for (bond, ((i, j), of)) in self.pairs().zip(&self.all).enumerate() {
            let part = of.stiffness * of_bond(bond);
            for node in [i, j] {
                lost[node] += part;
                all[node] += of.stiffness;
            }
        }
        lost.iter().zip(&all).map(|(lost, all)| lost / all).collect()
    }

    /// The numbers of the bonds in the row of a node.
    pub(crate) fn row(&self, node: usize) -> std::ops::Range<usize> {
        self.starts[node]..self.starts[node + 1]
    }

    /// The nodes of a bond, the lower first.
    pub(crate) fn ends(&self, bond: usize) -> (usize, usize) {
        let node = self.starts.partition_point(|&start| start <= bond) - 1;
        (node, self.partner(bond))
    }

    /// The bond between two nodes, the lower first.
    pub(crate) fn number(&self, i: usize, j: usize) -> Option<usize> {
        let row = self.row(i);
        let partners = &self.partners[row.clone()];
        let at = partners.binary_search_by_key(&j, |&partner| partner as usize).ok()?;
        Some(row.start + at)
    }

    /// The other nodes of bonds.
    #[inline]
    pub(crate) fn partners(&self, bonds: std::ops::Range<usize>) -> &[u32] {
        self.partners.get(bonds).unwrap_or_default()
    }

    #[inline]
    pub(crate) fn partner(&self, bond: usize) -> usize {
        self.partners[bond] as usize
    }
}

/// Numbers of bonds that exist.
pub(crate) fn cut_numbers(bonds: &[usize], expected: usize) -> Result<(), Error> {
    bonds.iter().try_for_each(|&bond| exists("the number of a bond to cut", bond, expected))
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}

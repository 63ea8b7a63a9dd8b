//! Where the nodes of a lattice are in memory, and the vectors of its bonds.

use super::vectors::{MOST_LANES, Mask};
use crate::bonds::Bonds;
use crate::error::Error;
use crate::nodes::Nodes;
use crate::real::Real;

/// Sites that share the words of bits.
pub(super) const GROUP: usize = MOST_LANES;

/// Nodes off their sites by more of a spacing are no lattice.
const OFF: f64 = 1e-6;

/// Two stiffnesses that differ by more of themselves are not of one vector.
const UNLIKE: f64 = 1e-9;

const NOBODY: u32 = u32::MAX;

/// The box of sites around a body: rows along the first axis, with a margin that no bond leaves.
#[derive(Debug, Clone)]
pub(super) struct Sites<const D: usize> {
    of_nodes: Vec<u32>,
    occupants: Vec<u32>,
    /// The first site of each row within the margin.
    rows: Vec<usize>,
    /// Row of each node.
    rows_of_nodes: Vec<u32>,
    groups: usize,
    coordinates: Vec<[i32; D]>,
}

impl<const D: usize> Sites<D> {
    pub(super) fn new(nodes: &Nodes<D>, bonds: &Bonds) -> Result<Self, Error> {
        let coordinates = coordinates(nodes)?;
        let (mut extent, mut reach) = ([0; D], [0; D]);
        for c in &coordinates {
            extent = std::array::from_fn(|k| extent[k].max(c[k] + 1));
        }
        for (i, j) in bonds.pairs() {
            let (a, b) = (coordinates[i], coordinates[j]);
            reach = std::array::from_fn(|k| reach[k].max((b[k] - a[k]).abs()));
        }
        let along = |value: i32| usize::try_from(value).unwrap_or(0);
        let groups = along(extent[0]).div_ceil(GROUP);
        // A register that begins at the last group and looks along a bond ends within the next row's margin.
        let mut strides = [1; D];
        let mut size = groups * GROUP + 2 * along(reach[0]);
        for k in 1..D {
            strides[k] = size;
            size *= along(extent[k]) + 2 * along(reach[k]);
        }
        if size > u32::MAX as usize {
            return Err(Error::TooManyNodes { value: size, limit: u32::MAX as usize });
        }
        let site =
            |c: &[i32; D]| (0..D).map(|k| along(c[k] + reach[k]) * strides[k]).sum::<usize>();
        let row_of = |c: &[i32; D]| {
            let mut row = 0;
            for k in (1..D).rev() {
                row = row * along(extent[k]) + along(c[k]);
            }
            row
        };
        let n_rows = (1..D).map(|k| along(extent[k])).product();
        let mut rows = vec![0; n_rows];
        let mut occupants = vec![NOBODY; size + GROUP];
        let (mut of_nodes, mut rows_of_nodes) = (Vec::new(), Vec::new());
        for (node, c) in (0_u32..).zip(&coordinates) {
            let (at, row) = (site(c), row_of(c));
            rows[row] = at - along(c[0]);
            occupants[at] = node;
            of_nodes.push(narrow(at));
            rows_of_nodes.push(narrow(row));
        }
        // Rows without a node keep the site zero; they have no bonds, and their forces go nowhere.
        Ok(Self { of_nodes, occupants, rows, rows_of_nodes, groups, coordinates })
    }

    /// How many sites there are, with the margins.
    pub(super) fn len(&self) -> usize {
        self.occupants.len()
    }

    pub(super) fn rows(&self) -> &[usize] {
        &self.rows
    }

    pub(super) fn groups(&self) -> usize {
        self.groups
    }

    pub(super) fn of(&self, node: usize) -> usize {
        self.of_nodes[node] as usize
    }

    /// Row of a node, and its place in it.
    pub(super) fn place(&self, node: usize) -> (usize, usize) {
        let row = self.rows_of_nodes[node] as usize;
        (row, self.of(node) - self.rows[row])
    }

    /// Where the bit of a node's bond is: row, word and bit.
    pub(super) fn bit(&self, node: usize, vector: usize, n_vectors: usize) -> (usize, usize, Mask) {
        let (row, at) = self.place(node);
        (row, at / GROUP * n_vectors + vector, 1 << (at % GROUP))
    }

    /// The nodes at a site and at an offset from it.
    pub(super) fn nodes(&self, site: usize, offset: isize) -> Option<(usize, usize)> {
        let other = site.checked_add_signed(offset)?;
        let (i, j) = (*self.occupants.get(site)?, *self.occupants.get(other)?);
        (i != NOBODY && j != NOBODY).then_some((i as usize, j as usize))
    }

    fn offset(&self, (from, to): (usize, usize)) -> isize {
        self.of(to).cast_signed() - self.of(from).cast_signed()
    }
}

fn narrow(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(NOBODY)
}

/// Whole numbers of spacings from the lowest corner.
fn coordinates<const D: usize>(nodes: &Nodes<D>) -> Result<Vec<[i32; D]>, Error> {
    let spacing = nodes.spacing();
    let mut low = [f64::INFINITY; D];
    for x in nodes.positions() {
        low = std::array::from_fn(|k| low[k].min(x[k]));
    }
    let of = |(node, x): (usize, &[f64; D])| {
        let mut c = [0; D];
        for k in 0..D {
            let along = (x[k] - low[k]) / spacing;
            if (along - along.round()).abs() > OFF || along > f64::from(i32::MAX) {
                return Err(Error::NotLattice { what: "the place", node, spacing });
            }
            #[allow(clippy::cast_possible_truncation, reason = "a whole number within range")]
            let whole = along.round() as i32;
            c[k] = whole;
        }
        Ok(c)
    };
    nodes.positions().iter().enumerate().map(of).collect()
}

/// The vectors from a node to those it is bonded to.
#[derive(Debug, Clone)]
pub(super) struct Stencil<T, const D: usize> {
    /// Between sites, ascending.
    offsets: Vec<isize>,
    pub(super) vectors: Vec<Vector<T, D>>,
}

/// One of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vector<T, const D: usize> {
    pub(super) offset: isize,
    pub(super) xi: [T; D],
    /// `1/|xi|^2`.
    pub(super) inverse_square: T,
    /// Stiffness over length.
    pub(super) stiffness: T,
}

impl<T: Real, const D: usize> Stencil<T, D> {
    pub(super) fn new(nodes: &Nodes<D>, bonds: &Bonds, sites: &Sites<D>) -> Result<Self, Error> {
        let spacing = nodes.spacing();
        let mut found: std::collections::BTreeMap<isize, ([i32; D], f64)> = [].into();
        for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
            let (a, b) = (sites.coordinates[i], sites.coordinates[j]);
            let stiffness = bond.stiffness / bond.length;
            for (from, to, sign) in [(i, j, 1), (j, i, -1)] {
                let vector = std::array::from_fn(|k| sign * (b[k] - a[k]));
                let (_, known) =
                    *found.entry(sites.offset((from, to))).or_insert((vector, stiffness));
                if (known - stiffness).abs() > UNLIKE * stiffness {
                    let what = "the stiffness of a bond";
                    return Err(Error::NotLattice { what, node: i, spacing });
                }
            }
        }
        let vectors = found.iter().map(|(&offset, &(c, stiffness))| {
            let xi: [f64; D] = c.map(|c| f64::from(c) * spacing);
            let square: f64 = xi.iter().map(|x| x * x).sum();
            Vector {
                offset,
                xi: xi.map(T::of),
                inverse_square: T::of(1.0 / square),
                stiffness: T::of(stiffness),
            }
        });
        Ok(Self { offsets: found.keys().copied().collect(), vectors: vectors.collect() })
    }

    pub(super) fn len(&self) -> usize {
        self.offsets.len()
    }

    pub(super) fn offset(&self, vector: usize) -> isize {
        self.offsets[vector]
    }

    /// Which of the vectors a bond has.
    pub(super) fn vector(&self, sites: &Sites<D>, ends: (usize, usize)) -> usize {
        self.offsets.partition_point(|&offset| offset < sites.offset(ends))
    }
}

//! Where the nodes of a lattice are in memory, and the vectors of its bonds.

use std::collections::BTreeMap;
use std::ops::Range;

use simd_lanes::MOST_LANES;

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, at_most};
use crate::fast::LaneBits;
use crate::real::Real;

/// Sites that share the words of bits.
pub(super) const GROUP: usize = MOST_LANES;

/// Layers of a band at least, so that what it adds to the next is the lesser part.
const LAYERS: usize = 8;

/// Nodes off their sites by more of a spacing are no lattice.
const OFF: f64 = 1e-6;

/// Relative difference above which two stiffnesses belong to different vectors.
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
    runs: Vec<Run>,
    /// Number of sites along a row, within the margin.
    width: usize,
    /// Rows and sites to a layer across the last axis, and layers that a bond reaches over.
    layer: (usize, usize),
    reach: usize,
    coordinates: Vec<[i32; D]>,
}

/// Consecutive nodes that are consecutive along a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub(super) node: usize,
    pub(super) site: usize,
    pub(super) row: usize,
    pub(super) length: usize,
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
        let width = along(extent[0]);
        // A register that begins at the last group and looks along a bond ends within the next row's margin.
        let mut strides = [1; D];
        let mut size = width.next_multiple_of(GROUP) + 2 * along(reach[0]);
        for k in 1..D {
            strides[k] = size;
            size *= along(extent[k]) + 2 * along(reach[k]);
        }
        at_most("sites", size, u32::MAX as usize)?;
        let site =
            |c: &[i32; D]| (0..D).map(|k| along(c[k] + reach[k]) * strides[k]).sum::<usize>();
        let row_of = |c: &[i32; D]| {
            let mut row = 0;
            for k in (1..D).rev() {
                row = row * along(extent[k]) + along(c[k]);
            }
            row
        };
        let n_rows: usize = (1..D).map(|k| along(extent[k])).product();
        let mut rows = vec![0; n_rows];
        let mut occupants = vec![NOBODY; size + GROUP];
        let (mut of_nodes, mut rows_of_nodes) = (Vec::new(), Vec::new());
        let mut runs: Vec<Run> = Vec::new();
        for (node, c) in (0_u32..).zip(&coordinates) {
            let (at, row) = (site(c), row_of(c));
            rows[row] = at - along(c[0]);
            occupants[at] = node;
            of_nodes.push(narrow(at));
            rows_of_nodes.push(narrow(row));
            match runs.last_mut() {
                Some(run) if run.row == row && run.site + run.length == at => run.length += 1,
                _ => runs.push(Run { node: node as usize, site: at, row, length: 1 }),
            }
        }
        // Rows without a node keep the site zero.
        let n_layers = if D > 1 { along(extent[D - 1]) } else { 1 };
        let layer = (n_rows / n_layers, if D > 1 { strides[D - 1] } else { size });
        let reach = if D > 1 { along(reach[D - 1]) } else { 0 };
        Ok(Self {
            of_nodes,
            occupants,
            rows,
            rows_of_nodes,
            runs,
            width,
            layer,
            reach,
            coordinates,
        })
    }

    /// How many sites there are, with the margins.
    pub(super) fn len(&self) -> usize {
        self.occupants.len()
    }

    pub(super) fn rows(&self) -> &[usize] {
        &self.rows
    }

    pub(super) fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Sites along a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// Groups of sites along a row.
    pub(super) fn groups(&self) -> usize {
        self.width.div_ceil(GROUP)
    }

    /// Rows to a band: layers enough that bonds of a band end in it or in the next.
    pub(super) fn rows_of_band(&self) -> usize {
        self.reach.max(LAYERS) * self.layer.0
    }

    /// The sites of some rows of whole layers and of those that their bonds reach.
    pub(super) fn sites_of(&self, rows: &Range<usize>) -> Range<usize> {
        let (rows_of_layer, sites_of_layer) = self.layer;
        let layers = rows.start / rows_of_layer..rows.end / rows_of_layer;
        let start = (layers.start + self.reach) * sites_of_layer;
        let end = (layers.end + 2 * self.reach) * sites_of_layer + GROUP;
        start..end.min(self.len())
    }

    pub(super) fn of(&self, node: usize) -> usize {
        self.of_nodes[node] as usize
    }

    /// The ends of a bond in the order of their sites.
    pub(super) fn in_order(&self, (i, j): (usize, usize)) -> (usize, usize) {
        if self.of(i) < self.of(j) { (i, j) } else { (j, i) }
    }

    /// Where the bit of a bond from a node on is: row, word in the row, and bit.
    pub(super) fn bit(
        &self,
        node: usize,
        vector: usize,
        n_vectors: usize,
    ) -> (usize, usize, LaneBits) {
        let row = self.rows_of_nodes[node] as usize;
        let at = self.of(node) - self.rows[row];
        (row, at / GROUP * n_vectors + vector, 1 << (at % GROUP))
    }

    /// The nodes at a site and at an offset from it.
    pub(super) fn nodes(&self, site: usize, offset: usize) -> Option<(usize, usize)> {
        let other = site + offset;
        let (i, j) = (*self.occupants.get(site)?, *self.occupants.get(other)?);
        (i != NOBODY && j != NOBODY).then_some((i as usize, j as usize))
    }

    /// Offset from a node to a later one.
    fn offset(&self, (from, to): (usize, usize)) -> usize {
        self.of(to) - self.of(from)
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

/// The vectors from a node to those further on that it is bonded to.
#[derive(Debug, Clone)]
pub(super) struct Stencil<T, const D: usize> {
    /// Between sites, ascending, and which of the vectors has it.
    offsets: Vec<(usize, usize)>,
    pub(super) vectors: Vec<Vector<T, D>>,
}

/// One of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vector<T, const D: usize> {
    pub(super) offset: usize,
    pub(super) xi: [T; D],
    /// `1/|xi|^2`.
    pub(super) inverse_square: T,
    /// Stiffness over length.
    pub(super) stiffness: T,
}

impl<T: Real, const D: usize> Stencil<T, D> {
    /// The stencil of bonds with a stiffness over length.
    pub(super) fn new(
        nodes: &Nodes<D>,
        bonds: &Bonds,
        sites: &Sites<D>,
        stiffness: &dyn Fn(usize) -> f64,
    ) -> Result<Self, Error> {
        let spacing = nodes.spacing();
        // By their components, the first first: bonds to the same row are far from each other, whose forces overlap in memory.
        let mut found: BTreeMap<[i32; D], (usize, f64)> = [].into();
        for (bond, pair) in bonds.pairs().enumerate() {
            let (i, j) = sites.in_order(pair);
            let (a, b) = (sites.coordinates[i], sites.coordinates[j]);
            let stiffness = stiffness(bond);
            let vector = std::array::from_fn(|k| b[k] - a[k]);
            let (_, known) = *found.entry(vector).or_insert((sites.offset((i, j)), stiffness));
            if (known - stiffness).abs() > UNLIKE * stiffness {
                let what = "the stiffness of a bond";
                return Err(Error::NotLattice { what, node: pair.0, spacing });
            }
        }
        let vectors = found.iter().map(|(c, &(offset, stiffness))| {
            let xi: [f64; D] = c.map(|c| f64::from(c) * spacing);
            let square: f64 = xi.iter().map(|x| x * x).sum();
            Vector {
                offset,
                xi: xi.map(T::of),
                inverse_square: T::of(1.0 / square),
                stiffness: T::of(stiffness),
            }
        });
        let vectors: Vec<_> = vectors.collect();
        let mut offsets: Vec<_> = vectors.iter().map(|v| v.offset).zip(0..).collect();
        offsets.sort_unstable();
        Ok(Self { offsets, vectors })
    }

    pub(super) fn len(&self) -> usize {
        self.vectors.len()
    }

    /// Which of the vectors a bond has, whose ends are in order.
    pub(super) fn vector(&self, sites: &Sites<D>, ends: (usize, usize)) -> usize {
        let at = self.offsets.partition_point(|&(offset, _)| offset < sites.offset(ends));
        self.offsets[at].1
    }
}

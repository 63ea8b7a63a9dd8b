//! The preconditioner: blocks of the nodes, and the rigid motions of boxes of nodes.

use super::band::Band;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::bodies::surface::direction;
use crate::error::Error;

/// Width of a box over the longest bond: of 1, 1.5, 2 and 3 that with the fewest iterations over the breakages of two notched
/// plates together, of 64 x 64 and 128 x 128 nodes (measured once, 2026-11-26: 14,352, 10,391, 13,770 and 24,027; blocks alone
/// 55,570).
const BOX: f64 = 1.5;

/// Most boxes; beyond, boxes are wider.
const MOST_BOXES: f64 = 4096.0;

/// Added to the diagonal of the intact body, as a part of it, so that parts that came loose have a factor.
const HELD: f64 = 1e-6;

/// Most rigid motions of a box.
const MOTIONS: usize = 6;

/// An additive two-level preconditioner (Nicolaides 1987): `B + P (P^T K P)^-1 P^T` with the inverse `B` of the diagonal
/// blocks of `K`, and the rigid motions `P` of boxes. A bond reaches over several nodes, so that boxes of one or two bonds leave the
/// blocks little to do, and the iterations do not grow with the body.
#[derive(Debug)]
pub(super) struct TwoLevel<const D: usize> {
    free: Vec<[bool; D]>,
    /// The box of each node.
    boxes: Vec<u32>,
    /// From the centre of its box to each node.
    arms: Vec<[f64; D]>,
    /// Diagonal blocks of `K`, and what is added to them.
    blocks: Vec<[[f64; D]; D]>,
    held: Vec<f64>,
    inverses: Vec<[[f64; D]; D]>,
    n_boxes: usize,
    width: usize,
    /// What is added to the diagonal of the coarse matrix.
    held_boxes: Vec<f64>,
    band: Band,
    coarse: Vec<f64>,
}

const fn n_motions<const D: usize>() -> usize {
    D + D * (D - 1) / 2
}

/// Bonds with their ends, direction and stiffness (force over length).
fn for_each_bond<const D: usize>(
    nodes: &Nodes<D>,
    bonds: &Bonds,
    weights: &[f64],
    mut each: impl FnMut((usize, usize), [f64; D], f64),
) {
    for ((i, j), (of, &weight)) in bonds.pairs().zip(bonds.all().iter().zip(weights)) {
        each((i, j), direction(nodes, (i, j), of.length), weight);
    }
}

impl<const D: usize> TwoLevel<D> {
    /// The preconditioner of a body with a stiffness of each bond (force over length).
    pub(super) fn new(
        nodes: &Nodes<D>,
        bonds: &Bonds,
        weights: &[f64],
        free: Vec<[bool; D]>,
    ) -> Result<Self, Error> {
        let n = nodes.positions().len();
        let (boxes, arms, n_boxes) = boxes(nodes, bonds);
        let apart = bonds.pairs().map(|(i, j)| boxes[i].abs_diff(boxes[j]) as usize).max();
        let mut made = Self {
            free,
            boxes,
            arms,
            blocks: vec![[[0.0; D]; D]; n],
            held: vec![0.0; n],
            inverses: vec![[[0.0; D]; D]; n],
            n_boxes,
            width: (apart.unwrap_or(0) + 1) * n_motions::<D>() - 1,
            held_boxes: vec![0.0; n_boxes * n_motions::<D>()],
            band: Band::default(),
            coarse: vec![0.0; n_boxes * n_motions::<D>()],
        };
        for_each_bond(nodes, bonds, weights, |ends, e, weight| made.stiffen(ends, e, weight));
        for node in 0..n {
            let trace: f64 = (0..D).map(|k| made.blocks[node][k][k]).sum();
            made.held[node] = HELD * trace;
            made.invert(node)?;
        }
        made.assemble(nodes, bonds, weights);
        let mean = (0..made.coarse.len()).map(|row| made.band.diagonal(row)).sum::<f64>()
            / made.coarse.len() as f64;
        for (row, held) in made.held_boxes.iter_mut().enumerate() {
            let diagonal = made.band.diagonal(row);
            *held = if diagonal > 0.0 { HELD * diagonal } else { mean };
        }
        made.factor()?;
        Ok(made)
    }

    /// Changes the stiffness of a bond in the blocks of its ends.
    fn stiffen(&mut self, (i, j): (usize, usize), e: [f64; D], change: f64) {
        for node in [i, j] {
            for (row, block) in self.blocks[node].iter_mut().enumerate() {
                for (column, entry) in block.iter_mut().enumerate() {
                    *entry += change * e[row] * e[column];
                }
            }
        }
    }

    /// The same, with the blocks ready for use.
    pub(super) fn change(
        &mut self,
        (i, j): (usize, usize),
        e: [f64; D],
        change: f64,
    ) -> Result<(), Error> {
        self.stiffen((i, j), e, change);
        self.invert(i)?;
        self.invert(j)
    }

    fn invert(&mut self, node: usize) -> Result<(), Error> {
        let (free, mut block) = (self.free[node], self.blocks[node]);
        for row in 0..D {
            for column in 0..D {
                if !(free[row] && free[column]) {
                    block[row][column] = 0.0;
                }
            }
            block[row][row] += if free[row] { self.held[node] } else { 1.0 };
        }
        self.inverses[node] = inverse(block)?;
        Ok(())
    }

    /// Makes the coarse matrix anew, of the bonds as they are.
    pub(super) fn renew(
        &mut self,
        nodes: &Nodes<D>,
        bonds: &Bonds,
        weights: &[f64],
    ) -> Result<(), Error> {
        self.assemble(nodes, bonds, weights);
        self.factor()
    }

    fn assemble(&mut self, nodes: &Nodes<D>, bonds: &Bonds, weights: &[f64]) {
        let motions = n_motions::<D>();
        let mut band = Band::zero(self.n_boxes * motions, self.width);
        for_each_bond(nodes, bonds, weights, |(i, j), e, weight| {
            if weight <= 0.0 {
                return;
            }
            let [a, b] =
                [i, j].map(|node| (self.boxes[node] as usize * motions, self.project(node, e)));
            for (row, from) in a.1[..motions].iter().enumerate() {
                for column in 0..motions {
                    let (one, two) = (a.1[column], b.1[column]);
                    if column <= row {
                        band.add(a.0 + row, a.0 + column, weight * from * one);
                        band.add(b.0 + row, b.0 + column, weight * b.1[row] * two);
                    }
                    // Within one box an entry and its mirror image are added at once.
                    if a.0 != b.0 {
                        band.add(a.0 + row, b.0 + column, -weight * from * two);
                    } else if column <= row {
                        let both = from * two + b.1[row] * one;
                        band.add(a.0 + row, a.0 + column, -weight * both);
                    }
                }
            }
        });
        self.band = band;
    }

    fn factor(&mut self) -> Result<(), Error> {
        for (row, &held) in self.held_boxes.iter().enumerate() {
            self.band.add(row, row, held);
        }
        self.band.factor()
    }

    /// `P^T` of a force on one node.
    fn project(&self, node: usize, force: [f64; D]) -> [f64; MOTIONS] {
        let (free, arm) = (self.free[node], self.arms[node]);
        let f: [f64; D] = std::array::from_fn(|k| if free[k] { force[k] } else { 0.0 });
        let mut found = [0.0; MOTIONS];
        found[..D].copy_from_slice(&f);
        let mut at = D;
        for a in 0..D {
            for b in a + 1..D {
                found[at] = f[b] * arm[a] - f[a] * arm[b];
                at += 1;
            }
        }
        found
    }

    /// The displacement of one node by the motions of its box.
    fn displace(&self, node: usize, motions: &[f64]) -> [f64; D] {
        let arm = self.arms[node];
        let mut moved: [f64; D] = std::array::from_fn(|k| motions[k]);
        let mut at = D;
        for a in 0..D {
            for b in a + 1..D {
                moved[b] += motions[at] * arm[a];
                moved[a] -= motions[at] * arm[b];
                at += 1;
            }
        }
        let free = self.free[node];
        std::array::from_fn(|k| if free[k] { moved[k] } else { 0.0 })
    }

    /// The image of a residual, which is zero where displacements are prescribed.
    pub(super) fn apply(&mut self, residual: &[f64], image: &mut [f64]) {
        let motions = n_motions::<D>();
        let mut coarse = std::mem::take(&mut self.coarse);
        coarse.fill(0.0);
        for (node, r) in residual.as_chunks::<D>().0.iter().enumerate() {
            let to = self.boxes[node] as usize * motions;
            let sums = self.project(node, *r);
            for (sum, value) in coarse[to..to + motions].iter_mut().zip(sums) {
                *sum += value;
            }
        }
        self.band.solve(&mut coarse);
        let images = image.as_chunks_mut::<D>().0.iter_mut();
        for (node, (z, r)) in images.zip(residual.as_chunks::<D>().0).enumerate() {
            let from = self.boxes[node] as usize * motions;
            let moved = self.displace(node, &coarse[from..from + motions]);
            for k in 0..D {
                let row: f64 = (0..D).map(|m| self.inverses[node][k][m] * r[m]).sum();
                z[k] = row + moved[k];
            }
        }
        self.coarse = coarse;
    }
}

/// The box of each node, the way from its centre, and how many there are.
fn boxes<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds) -> (Vec<u32>, Vec<[f64; D]>, usize) {
    let x = nodes.positions();
    let longest = bonds.all().iter().fold(0.0, |most: f64, bond| most.max(bond.length));
    let low: [f64; D] =
        std::array::from_fn(|k| x.iter().fold(f64::INFINITY, |least, x| least.min(x[k])));
    let extent: [f64; D] =
        std::array::from_fn(|k| x.iter().fold(0.0, |most: f64, x| most.max(x[k] - low[k])));
    let mut edge = BOX * longest;
    let count = |edge: f64| extent.map(|extent| (extent / edge).floor().max(1.0));
    while count(edge).iter().product::<f64>() > MOST_BOXES {
        edge *= 1.1;
    }
    let counts = count(edge);
    // Along the longest side last, so that neighbours in a row are near in number.
    let mut axes: [usize; D] = std::array::from_fn(|k| k);
    axes.sort_by(|&a, &b| counts[a].total_cmp(&counts[b]));
    let cell = |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| {
            let along = (x[k] - low[k]) / extent[k].max(f64::MIN_POSITIVE) * counts[k];
            along.floor().min(counts[k] - 1.0)
        })
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "fewer than the most boxes"
    )]
    let number = |cell: [f64; D]| {
        axes.iter().rev().fold(0.0, |number, &k| number * counts[k] + cell[k]) as usize
    };
    let cells: Vec<usize> = x.iter().map(|x| number(cell(x))).collect();
    // Boxes without a node have no number.
    let mut numbers = vec![u32::MAX; cells.iter().max().map_or(0, |last| last + 1)];
    for &cell in &cells {
        numbers[cell] = 0;
    }
    let mut n_boxes = 0;
    for number in numbers.iter_mut().filter(|number| **number == 0) {
        *number = n_boxes;
        n_boxes += 1;
    }
    let arms = x
        .iter()
        .map(|x| {
            let cell = cell(x);
            // In units of the box, so that rotations are as stiff as translations.
            std::array::from_fn(|k| {
                let size = extent[k] / counts[k];
                (x[k] - low[k] - (cell[k] + 0.5) * size) / edge
            })
        })
        .collect();
    (cells.iter().map(|&cell| numbers[cell]).collect(), arms, n_boxes as usize)
}

/// The inverse of a symmetric positive definite matrix, by elimination.
fn inverse<const D: usize>(mut a: [[f64; D]; D]) -> Result<[[f64; D]; D], Error> {
    let mut right = [[0.0; D]; D];
    for (k, row) in right.iter_mut().enumerate() {
        row[k] = 1.0;
    }
    for k in 0..D {
        if a[k][k] <= 0.0 || !a[k][k].is_finite() {
            return Err(Error::NotPositiveDefinite { row: k, limit: 0.0 });
        }
        let scale = 1.0 / a[k][k];
        a[k] = a[k].map(|entry| entry * scale);
        right[k] = right[k].map(|entry| entry * scale);
        for row in (0..D).filter(|&row| row != k) {
            let factor = a[row][k];
            for column in 0..D {
                a[row][column] -= factor * a[k][column];
                right[row][column] -= factor * right[k][column];
            }
        }
    }
    Ok(right)
}

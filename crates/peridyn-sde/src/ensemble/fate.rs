//! Bodies that broke where they were not meant to.

use super::study::CrackStudy;
use crate::statistics::CrackOutcome;

/// Damage of a prescribed node from which its edge counts as broken.
const BROKEN_GRIP: f64 = 0.3;

/// Pieces of fewer nodes than this part of the body are crumbs of a crack.
const CRUMB: f64 = 0.02;

impl CrackStudy<'_> {
    /// Reason to reject the crack of a body: a prescribed node has lost its bonds, or an unsupported piece is
    /// disconnected.
    pub(super) fn broke_elsewhere(&self, broken: &[bool], damage: &[f64]) -> Option<CrackOutcome> {
        let gripped = self.loading.prescribed();
        let is_gripped = |node: usize| gripped[node].contains(&true);
        if (0..gripped.len()).any(|node| is_gripped(node) && damage[node] > BROKEN_GRIP) {
            return Some(CrackOutcome::GripsBroken);
        }
        let pieces = self.pieces(broken);
        let (mut sizes, mut held) = (vec![0_usize; pieces.len()], vec![false; pieces.len()]);
        for (node, &piece) in pieces.iter().enumerate() {
            sizes[piece] += 1;
            held[piece] |= is_gripped(node);
        }
        let large = CRUMB * pieces.len() as f64;
        let loose = (0..sizes.len()).any(|piece| sizes[piece] as f64 > large && !held[piece]);
        loose.then_some(CrackOutcome::Disconnected)
    }

    /// The lowest node that each node hangs together with.
    fn pieces(&self, broken: &[bool]) -> Vec<usize> {
        let mut parents: Vec<usize> = (0..self.bonds.n_nodes()).collect();
        for (bond, (i, j)) in self.bonds.pairs().enumerate() {
            if !broken[bond] {
                let (a, b) = (root(&mut parents, i), root(&mut parents, j));
                parents[a.max(b)] = a.min(b);
            }
        }
        (0..parents.len()).map(|node| root(&mut parents, node)).collect()
    }
}

/// The root of a tree, which the path to it is made shorter for.
fn root(parents: &mut [usize], mut node: usize) -> usize {
    while parents[node] != node {
        parents[node] = parents[parents[node]];
        node = parents[node];
    }
    node
}

//! A body with broken bonds: what a search for cracks reads.

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, exists, same_length};

/// A body with its bonds, intact and broken.
#[derive(Debug, Clone, Copy)]
pub struct Fractured<'a> {
    /// The nodes.
    pub nodes: &'a Nodes<2>,
    /// The bonds.
    pub bonds: &'a Bonds,
    /// Whether each bond is broken, in the order of [`Bonds::all`]; what the notch cut may be among them. To exclude
    /// prescribed edges, pass their bonds as intact.
    pub broken: &'a [bool],
    /// The bonds that the notch cut, as [`Bonds::across_segment`] gives them.
    pub cut: &'a [usize],
}

impl Fractured<'_> {
    pub(super) fn check(&self) -> Result<(), Error> {
        same_length("nodes", self.nodes.positions().len(), self.bonds.n_nodes())?;
        let n_bonds = self.bonds.len();
        same_length("flags of broken bonds", self.broken.len(), n_bonds)?;
        self.cut.iter().try_for_each(|&bond| exists("the number of a cut bond", bond, n_bonds))
    }
}

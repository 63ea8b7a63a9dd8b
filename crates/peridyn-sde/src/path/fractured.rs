//! A body with broken bonds: what a search for cracks reads.

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::Error;

/// A body with its bonds, intact and broken.
#[derive(Debug, Clone, Copy)]
pub struct Fractured<'a, const D: usize> {
    /// The nodes.
    pub nodes: &'a Nodes<D>,
    /// The bonds.
    pub bonds: &'a Bonds,
    /// Whether each bond is broken, in the order of [`Bonds::all`]; what the notch cut may be among them. To exclude
    /// prescribed edges, pass their bonds as intact.
    pub broken: &'a [bool],
    /// The bonds that the notch cut, as [`Bonds::across_segment`] and [`Bonds::across_plane`] give them.
    pub cut: &'a [usize],
}

impl<const D: usize> Fractured<'_, D> {
    pub(super) fn check(&self) -> Result<(), Error> {
        let length = |name, value, expected| {
            if value == expected { Ok(()) } else { Err(Error::Length { name, value, expected }) }
        };
        length("nodes", self.nodes.positions().len(), self.bonds.n_nodes())?;
        let expected = self.bonds.len();
        length("flags of broken bonds", self.broken.len(), expected)?;
        match self.cut.iter().find(|&&bond| bond >= expected) {
            Some(&value) => {
                Err(Error::Length { name: "the number of a cut bond", value, expected })
            }
            None => Ok(()),
        }
    }
}
